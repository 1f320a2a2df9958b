// Mode shapes that move: choice of the mode, play and pause, amplitude, a view that turns.
(() => {
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  for (const group of document.querySelectorAll('[data-structure]')) {
    const { nodes, measured, strokes, modes, largest, tilt, turn: firstTurn } = JSON.parse(group.dataset.structure);
    const views = [...group.querySelectorAll('svg.view')];
    const state = { mode: 0, amplitude: 1, phase: 0, turn: firstTurn, playing: !still };
    const make = (name, attributes, text) => {
      const made = Object.assign(document.createElement(name), attributes);
      if (text) made.textContent = text;
      return made;
    };
    const axes = (name) => {
      const flat = { 'x–y': [[1, 0, 0], [0, 1, 0]], 'x–z': [[1, 0, 0], [0, 0, 1]], 'y–z': [[0, 1, 0], [0, 0, 1]] };
      if (flat[name]) return flat[name];
      const [s, c, down, up] = [Math.sin(state.turn), Math.cos(state.turn), Math.sin(tilt), Math.cos(tilt)];
      return [[c, s, 0], [-s * down, c * down, up]];
    };
    // the real part of shape times e^(i phase) beside each node, in half diagonals
    const places = (view, amplitude) => {
      const [width, height] = ['width', 'height'].map((name) => Number(view.getAttribute(name)));
      const zoom = 0.5 * Math.min(width, height) / (1 + 2.5 * largest);
      const shape = modes[state.mode].shape, [right, up] = axes(view.dataset.view);
      const [c, s] = [Math.cos(state.phase), Math.sin(state.phase)];
      return nodes.map((node, k) => {
        const at = node.map((x, i) => x + 2 * largest * amplitude * (shape[6 * k + 2 * i] * c - shape[6 * k + 2 * i + 1] * s));
        const along = (axis) => axis[0] * at[0] + axis[1] * at[1] + axis[2] * at[2];
        return [0.5 * width + zoom * along(right), 0.5 * height - zoom * along(up)];
      });
    };
    const lines = (points) => strokes.map((stroke) =>
      stroke.map((k, i) => (i ? 'L' : 'M') + points[k][0].toFixed(1) + ' ' + points[k][1].toFixed(1)).join('')).join('');
    const draw = () => {
      for (const view of views) {
        const [line, dots] = view.querySelectorAll('.moving path');
        const points = places(view, state.amplitude);
        line.setAttribute('d', lines(points));
        dots.setAttribute('d', points.filter((_, k) => measured[k])
          .map(([x, y]) => 'M' + x.toFixed(1) + ' ' + y.toFixed(1) + 'h0').join(''));
        if (view.dataset.view === 'turned') view.querySelector('.before').setAttribute('d', lines(places(view, 0)));
      }
    };
    let before = null;
    const step = (now) => {
      if (!state.playing) return;
      // one swing in two seconds, whatever the frequency
      if (before !== null) state.phase = (state.phase + (now - before) * Math.PI / 1000) % (2 * Math.PI);
      before = now;
      draw();
      requestAnimationFrame(step);
    };
    const play = make('button', { type: 'button' });
    const playing = (on) => {
      state.playing = on;
      play.textContent = on ? 'Pause' : 'Play';
      before = null;
      if (on) requestAnimationFrame(step);
    };
    play.addEventListener('click', () => playing(!state.playing));
    const choice = make('select', { ariaLabel: 'mode' });
    modes.forEach((mode, k) => choice.append(make('option', { value: k }, mode.name)));
    choice.addEventListener('change', () => { state.mode = Number(choice.value); draw(); });
    const slider = (label, name, min, max) => {
      const input = make('input', { type: 'range', min, max, step: 0.01, value: state[name] });
      input.addEventListener('input', () => { state[name] = Number(input.value); draw(); });
      const labelled = make('label', {}, label + ' ');
      labelled.append(input);
      return labelled;
    };
    const controls = make('div', { className: 'controls' });
    controls.append(choice, play, slider('amplitude', 'amplitude', 0, 2), slider('turn', 'turn', -3.14, 3.14));
    group.closest('svg.figure').before(controls);
    // paper and a reader who wants less motion see the largest displacement at rest
    addEventListener('beforeprint', () => { state.phase = 0; draw(); });
    playing(state.playing);
  }
})();
