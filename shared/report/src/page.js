// Pointer readout, zoom along the horizontal axis and print of a page that works without a network.
(() => {
  const readout = document.createElement('div');
  readout.className = 'readout';
  readout.hidden = true;
  document.body.append(readout);
  const digits = (v) => Number(v.toPrecision(5)).toString();
  const ends = (panel, axis) => panel.dataset[axis].split(' ').map(Number);
  const size = (panel, name) => Number(panel.getAttribute(name));
  // value at a share of an axis; logarithmic axes are even in the logarithm
  const value = (panel, axis, share) => {
    const [low, high] = ends(panel, axis);
    if (panel.dataset[axis + 'log']) return low * Math.pow(high / low, share);
    return low + (high - low) * share;
  };
  const view = (panel) => {
    const box = panel.getAttribute('viewBox');
    if (!box) return [0, size(panel, 'width')];
    const [from, , width] = box.split(' ').map(Number);
    return [from, width];
  };
  // place of the pointer in the coordinates of the drawing
  const place = (panel, event) => {
    const box = panel.querySelector('.catch').getBoundingClientRect();
    const whole = size(panel, 'width'), height = size(panel, 'height');
    return [(event.clientX - box.left) / box.width * whole, (event.clientY - box.top) / box.height * height];
  };
  const vertices = (group) => {
    if (!group.vertices) {
      group.vertices = [...group.querySelectorAll('path')].flatMap((path) =>
        [...path.getAttribute('d').matchAll(/[ML](-?[\d.]+) (-?[\d.]+)/g)].map((m) => [Number(m[1]), Number(m[2])]));
    }
    return group.vertices;
  };
  const nearest = (group, x, reach) => {
    let best = null;
    for (const point of vertices(group)) {
      if (Math.abs(point[0] - x) <= reach && (!best || Math.abs(point[0] - x) < Math.abs(best[0] - x))) best = point;
    }
    return best;
  };
  const show = (panel, event) => {
    const [x, y] = place(panel, event);
    const [width, height] = [size(panel, 'width'), size(panel, 'height')];
    const lines = [panel.dataset.xname + ': ' + digits(value(panel, 'x', x / width))];
    const reach = view(panel)[1] / 60;
    const groups = [...panel.querySelectorAll('g[data-label]')];
    for (const group of groups) {
      const point = nearest(group, x, reach);
      if (point) lines.push(group.dataset.label + ': ' + digits(value(panel, 'y', 1 - point[1] / height)));
    }
    if (!groups.length) lines.push(panel.dataset.yname + ': ' + digits(value(panel, 'y', 1 - y / height)));
    readout.replaceChildren(...lines.map((line) => {
      const row = document.createElement('div');
      row.textContent = line;
      return row;
    }));
    readout.hidden = false;
    const right = event.clientX + 14 + readout.offsetWidth > document.documentElement.clientWidth;
    readout.style.left = Math.max(0, right ? event.clientX - 14 - readout.offsetWidth : event.clientX + 14) + 'px';
    readout.style.top = event.clientY + 14 + 'px';
  };
  // round numbers between two values, at most six of them
  const rounds = (low, high) => {
    const raw = (high - low) / 6, decade = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].map((m) => m * decade).find((s) => s >= raw);
    const all = [];
    for (let k = Math.ceil(low / step); k * step <= high && all.length < 9; k += 1) all.push(k * step);
    return all;
  };
  const element = (like, name, attributes, text) => {
    const made = document.createElementNS(like.namespaceURI, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text) made.textContent = text;
    return made;
  };
  const relabel = (panel, ticks) => {
    const [from, width] = view(panel), whole = size(panel, 'width');
    const [low, high] = [from / whole, (from + width) / whole].map((share) => value(panel, 'x', share));
    const [left, top, height] = [size(panel, 'x'), size(panel, 'y'), size(panel, 'height')];
    const share = (v) => panel.dataset.xlog ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low);
    const labelled = ticks.dataset.labelled;
    ticks.replaceChildren(...rounds(low, high).flatMap((v) => {
      const x = left + share(v) * whole;
      const line = element(panel, 'line', { class: 'grid', x1: x, x2: x, y1: top, y2: top + height });
      const text = { class: 'tick middle', x, y: top + height + 16 };
      return labelled ? [line, element(panel, 'text', text, digits(v))] : [line];
    }));
  };
  for (const figure of document.querySelectorAll('figure')) {
    const panels = [...figure.querySelectorAll('svg.panel')], ticks = [...figure.querySelectorAll('g.xticks')];
    const asDrawn = ticks.map((group) => group.innerHTML);
    const zoom = (like, from, width) => panels.forEach((panel, i) => {
      if (panel.dataset.x !== like.dataset.x || !panel.querySelector('g[data-label]')) return;
      if (width === undefined) {
        panel.removeAttribute('viewBox');
        ticks[i].innerHTML = asDrawn[i];
      } else {
        panel.setAttribute('viewBox', [from, 0, width, size(panel, 'height')].join(' '));
        panel.setAttribute('preserveAspectRatio', 'none');
        relabel(panel, ticks[i]);
      }
    });
    for (const panel of panels) {
      const [width, height] = [size(panel, 'width'), size(panel, 'height')];
      panel.append(element(panel, 'rect', { class: 'catch', x: 0, y: 0, width, height }));
      const chosen = element(panel, 'rect', { class: 'chosen', y: 0, height, width: 0 });
      panel.append(chosen);
      let begin = null;
      panel.addEventListener('pointerdown', (event) => {
        if (event.button || !panel.querySelector('g[data-label]')) return;
        begin = place(panel, event)[0];
        event.preventDefault();
      });
      panel.addEventListener('pointermove', (event) => {
        show(panel, event);
        if (begin === null) return;
        const now = place(panel, event)[0];
        chosen.setAttribute('x', Math.min(begin, now));
        chosen.setAttribute('width', Math.abs(now - begin));
      });
      const end = (event) => {
        if (begin !== null && event.type === 'pointerup') {
          const now = place(panel, event)[0], [from, seen] = view(panel);
          const [low, high] = [Math.max(from, Math.min(begin, now)), Math.min(from + seen, Math.max(begin, now))];
          if (high - low > seen / 100 && high - low > width * 1e-4) zoom(panel, low, high - low);
        }
        begin = null;
        chosen.setAttribute('width', 0);
        if (event.type === 'pointerleave') readout.hidden = true;
      };
      panel.addEventListener('pointerup', end);
      panel.addEventListener('pointerleave', end);
      panel.addEventListener('dblclick', () => zoom(panel));
    }
  }
  // paper shows what a screen folds
  let folded = [];
  addEventListener('beforeprint', () => {
    folded = [...document.querySelectorAll('details:not([open])')];
    folded.forEach((details) => { details.open = true; });
  });
  addEventListener('afterprint', () => folded.forEach((details) => { details.open = false; }));
})();
