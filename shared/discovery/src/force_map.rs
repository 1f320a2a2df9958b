//! A force that no law of the catalogue describes: a smooth map over two coordinates.
//!
//! ```text
//! F(a, b) = Σ w_i φ_i(a, b),   φ Gaussians on a 5 × 5 grid over the visited box,   w ~ N(0, s²)
//! ```
//!
//! The weights have one prior scale s, which maximises the evidence; every pair of coordinates has its map, the best evidence wins. It
//! counts when it predicts parts of the recording that it was not fitted to. Columns come from the forcing of the linear model: the
//! force acts where a noise input acts.

use crate::compete::subsets::{Rung, ladder};
use crate::filter::{DISTURBANCE, Linear, Machine, NoiseModel};
use crate::fit::board::dot;
use crate::fit::{Board, Engine};
use crate::held_out::{BLOCK_S, Gain, block_s, blocks};
use crate::score::event_of_sample;
use crate::score::forcing::{Sources, respond};
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use plant::description::Plant;

/// Basis functions along one coordinate.
const SIDE: usize = 5;
/// Width of a Gaussian in distances of the grid.
const WIDTH: f64 = 0.8;
/// Parts of the recording, each predicted from the others.
const FOLDS: usize = 8;
/// Pairs of coordinates of one input.
const PAIRS_MAX: usize = 5;
/// Cells of the map that is told, along one coordinate.
const CELLS: usize = 9;

/// Where a force may act and on what it may depend.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Index of the noise input that pushes there.
    pub input: usize,
    pub site: String,
    pub along: [Coordinate; 2],
}

/// What a force may depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// Index of a state.
    State(usize),
    /// Index in `u` of a command.
    Command(usize),
}

/// One value of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub at: [f64; 2],
    pub force: f64,
    pub sigma: f64,
}

/// The best map.
#[derive(Clone, Debug)]
pub struct ForceMap {
    pub place: Place,
    pub names: [String; 2],
    pub cells: Vec<Cell>,
    /// Twice the logarithm of the evidence above no map, noise maximised along the rungs on both sides.
    pub evidence: f64,
    /// Maps that were tried.
    pub tried: usize,
    /// Gain on parts of the recording that the weights were not fitted to.
    pub held_out: Gain,
}

/// Lower and upper end of both coordinates.
type Span = [[f64; 2]; 2];

/// The map that leads so far.
struct Leader {
    evidence: f64,
    place: Place,
    columns: Vec<Vec<f64>>,
    ridge: Ridge,
    noise: NoiseModel,
    span: Span,
}

/// The map of most evidence about `theta`; `None` where nothing can push.
pub fn best(
    engine: &Engine<'_>,
    plant: &Plant,
    board: &Board,
    theta: &[f64],
    adapted: &NoiseModel,
) -> Option<ForceMap> {
    let places = places(board.linears.first()?);
    let noises = ladder(engine, adapted);
    let machine = |run: usize| {
        Machine::new(engine.problem, run, &engine.problem.instance(plant, theta, run), &engine.timelines[run]).ok()
    };
    let machines: Vec<Machine<'_>> = (0..board.linears.len()).map(machine).collect::<Option<_>>()?;
    let mut found: Option<Leader> = None;
    for place in &places {
        let Some(span) = visited(board, &machines, place) else { continue };
        let columns = columns((engine, &machines), board, place, span);
        let extra: Vec<&Vec<f64>> = columns.iter().collect();
        let rungs: Vec<Rung> = noises.iter().filter_map(|n| Rung::new(engine, board, theta, &extra, n)).collect();
        let samples = (engine.samples + engine.problem.unknowns.len()) as f64;
        let null = rungs.iter().map(|rung| rung.at(rung.reduced_chi2, samples)).fold(f64::INFINITY, f64::min);
        for rung in &rungs {
            let Some(ridge) = Ridge::new(rung, samples) else { continue };
            let evidence = null - ridge.objective;
            if found.as_ref().is_none_or(|best| evidence > best.evidence) {
                let (place, columns, noise) = (place.clone(), columns.clone(), rung.noise.clone());
                found = Some(Leader { evidence, place, columns, ridge, noise, span });
            }
        }
    }
    let Leader { evidence, place, columns, ridge, noise, span } = found?;
    let held_out = predicted(engine, board, theta, &columns, &ridge, &noise)?;
    let first = &board.linears[0];
    let names = place.along.map(|coordinate| match coordinate {
        Coordinate::State(state) => first.state_names[state].clone(),
        Coordinate::Command(_) => format!("actuator:{}", first.input_names[place.input]),
    });
    let cells = ridge.cells(span);
    Some(ForceMap { place, names, cells, evidence, tried: places.len(), held_out })
}

/// Noise inputs that act on a coordinate, with pairs: its own position and rate, the input's command and its rate, its rate with every other
/// rate.
fn places(linear: &Linear) -> Vec<Place> {
    let states = &linear.state_names;
    let find = |name: &str| states.iter().position(|state| state == name);
    let rates: Vec<usize> = (0..states.len()).filter(|i| states[*i].ends_with(".rate")).collect();
    let mut list = Vec::new();
    for (input, name) in linear.input_names.iter().enumerate() {
        let target = name.strip_prefix(DISTURBANCE).unwrap_or(name);
        let gamma = |row: usize| {
            linear
                .transition
                .get(row * (linear.layout.tangent + linear.layout.noise_inputs.len()) + linear.layout.tangent + input)
                .copied()
                .unwrap_or(0.0)
        };
        let named = find(&format!("joint:{target}.rate"));
        // a torque whose name is not its joint's pushes the rate that it moves most
        let pushed = named.or_else(|| {
            let moved = linear.names.iter().enumerate().filter(|(_, name)| name.ends_with(".rate"));
            let most = moved.max_by(|a, b| gamma(a.0).abs().total_cmp(&gamma(b.0).abs()))?;
            find(most.1)
        });
        let Some(rate) = pushed else { continue };
        let coordinate = states[rate].trim_end_matches(".rate").to_owned();
        let mut pairs = Vec::new();
        let with = |other: Coordinate| [other, Coordinate::State(rate)];
        pairs.extend(find(&coordinate).map(|position| with(Coordinate::State(position))));
        pairs.push(with(Coordinate::Command(linear.layout.noise_inputs[input])));
        pairs.extend(rates.iter().filter(|other| **other != rate).map(|other| with(Coordinate::State(*other))));
        let site = coordinate;
        list.extend(pairs.into_iter().take(PAIRS_MAX).map(|along| Place { input, site: site.clone(), along }));
    }
    list
}

/// Basis functions at `(a, b)` over a box.
fn basis(span: Span, at: [f64; 2], out: &mut [f64]) {
    let along = |k: usize, i: usize| {
        let step = (span[k][1] - span[k][0]) / (SIDE - 1) as f64;
        let z = (at[k] - span[k][0] - i as f64 * step) / (WIDTH * step);
        libm::exp(-0.5 * z * z)
    };
    for i in 0..SIDE {
        for j in 0..SIDE {
            out[i * SIDE + j] = along(0, i) * along(1, j);
        }
    }
}

/// `−∂ν/∂w` of every basis function over `span`.
fn columns(
    (engine, machines): (&Engine<'_>, &[Machine<'_>]),
    board: &Board,
    place: &Place,
    span: Span,
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; board.nu.len()]; SIDE * SIDE];
    for (run, (linear, machine)) in board.linears.iter().zip(machines).enumerate() {
        let timeline = machine.timeline;
        let (n, m, x) = (linear.layout.tangent, linear.layout.noise_inputs.len(), linear.state_names.len());
        let events = timeline.events.len();
        let row_len = linear.row_len();
        // as an interval begins, as it ends, and as an instant is read
        let [mut begins, mut ends, mut reads] = [0; 3].map(|_| vec![0.0; events * SIDE * SIDE]);
        for k in 0..events {
            let at = |states: &[f64], acts: (usize, bool)| {
                place.along.map(|coordinate| value(machine, acts, &states[k * x..(k + 1) * x], coordinate))
            };
            let slot = k * SIDE * SIDE..(k + 1) * SIDE * SIDE;
            basis(span, at(&linear.updated, (k, false)), &mut begins[slot.clone()]);
            basis(span, at(&linear.states, (k.saturating_sub(1), k > 0)), &mut ends[slot.clone()]);
            basis(span, at(&linear.states, (k, false)), &mut reads[slot]);
        }
        for (i, column) in columns.iter_mut().enumerate() {
            let mut sources = Sources { state: vec![0.0; events * n], reading: vec![0.0; timeline.value.len()] };
            for (k, event) in timeline.events.iter().enumerate() {
                for sample in event.first..event.first + event.count {
                    let direct = linear.measurement[sample * row_len + n + place.input];
                    sources.reading[sample] = direct * reads[k * SIDE * SIDE + i];
                }
                if k + 1 < events {
                    let mean = 0.5 * (begins[k * SIDE * SIDE + i] + ends[(k + 1) * SIDE * SIDE + i]);
                    for row in 0..n {
                        let at = k * n * (n + m) + row * (n + m) + n + place.input;
                        sources.state[k * n + row] = linear.transition[at] * mean;
                    }
                }
            }
            let change = respond(linear, timeline, &sources);
            for (c, change) in column[engine.offsets[run]..].iter_mut().zip(change) {
                *c = -change;
            }
        }
    }
    columns
}

/// A coordinate in state `x` under what acts as event `k` begins its stretch, or ends it.
fn value(machine: &Machine<'_>, (k, end): (usize, bool), x: &[f64], coordinate: Coordinate) -> f64 {
    match coordinate {
        Coordinate::State(state) => x[state],
        Coordinate::Command(input) => machine.acting(k, end, input),
    }
}

/// The middle 98 % of both coordinates; `None` where one stands still.
fn visited(board: &Board, machines: &[Machine<'_>], place: &Place) -> Option<Span> {
    let mut span = [[0.0; 2]; 2];
    for (side, coordinate) in span.iter_mut().zip(place.along) {
        let mut values: Vec<f64> = Vec::new();
        for (linear, machine) in board.linears.iter().zip(machines) {
            let states = linear.updated.chunks(linear.state_names.len()).enumerate();
            values.extend(states.map(|(k, x)| value(machine, (k, false), x, coordinate)));
        }
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        *side = [at(0.01), at(0.99)];
        if side[1] - side[0] <= 1e-9 * (1.0 + side[0].abs()) {
            return None;
        }
    }
    Some(span)
}

/// Weights with one prior scale, by eigenvectors of their information.
struct Ridge {
    objective: f64,
    weights: DVector<f64>,
    covariance: DMatrix<f64>,
    /// `1/s²`.
    precision: f64,
}

impl Ridge {
    /// The scale that maximises the evidence on `rung`.
    fn new(rung: &Rung, samples: f64) -> Option<Self> {
        let eigen = SymmetricEigen::try_new(rung.reduced.clone(), 1e-12, 10_000)?;
        let g = eigen.eigenvectors.tr_mul(&rung.reduced_right);
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let mut best: Option<(f64, f64, f64)> = None;
        for step in 0..40 {
            // from a prior that allows nothing to one that is felt nowhere
            let variance = libm::exp(0.5 * (step as f64 - 8.0)) / largest;
            let (mut gain, mut price) = (0.0, 0.0);
            for (l, g) in eigen.eigenvalues.iter().zip(g.iter()) {
                let seen = variance * l.max(0.0);
                gain += variance * g * g / (1.0 + seen);
                price += libm::log(1.0 + seen);
            }
            let objective = rung.at(rung.reduced_chi2 - gain, samples) + price;
            if best.is_none_or(|best| objective < best.0) {
                best = Some((objective, variance, gain));
            }
        }
        let (objective, variance, gain) = best?;
        let scale = (rung.reduced_chi2 - gain).max(0.0) / samples;
        let n = rung.reduced.nrows();
        let factor = Cholesky::new(&rung.reduced + DMatrix::identity(n, n) / variance)?;
        let weights = factor.solve(&rung.reduced_right);
        Some(Self { objective, weights, covariance: factor.inverse() * scale, precision: 1.0 / variance })
    }

    fn cells(&self, span: Span) -> Vec<Cell> {
        let mut phi = vec![0.0; SIDE * SIDE];
        let mut cells = Vec::with_capacity(CELLS * CELLS);
        for i in 0..CELLS {
            for j in 0..CELLS {
                let share = [i, j].map(|i| i as f64 / (CELLS - 1) as f64);
                let at = [0, 1].map(|k| span[k][0] + share[k] * (span[k][1] - span[k][0]));
                basis(span, at, &mut phi);
                let phi = DVector::from_column_slice(&phi);
                let sigma = phi.dot(&(&self.covariance * &phi)).max(0.0).sqrt();
                cells.push(Cell { at, force: phi.dot(&self.weights), sigma });
            }
        }
        cells
    }
}

/// Gain in log-likelihood of every fold with weights and unknowns from the others.
fn predicted(
    engine: &Engine<'_>,
    board: &Board,
    theta: &[f64],
    columns: &[Vec<f64>],
    ridge: &Ridge,
    noise: &NoiseModel,
) -> Option<Gain> {
    let extra: Vec<&Vec<f64>> = columns.iter().collect();
    let normal = board.normal(engine, theta, noise, &extra)?;
    let (r, white) = board.whitened(engine, noise, &extra)?;
    let events = event_of_sample(engine);
    let instants = events.last().map_or(0, |last| last + 1);
    let (u, n) = (normal.unknowns, white.len());
    // variance that the rung's scale left open
    let scale = normal.chi2 / engine.samples.max(1) as f64;
    let mut gained = vec![0.0; instants];
    for fold in 0..FOLDS {
        let own: Vec<usize> = (0..events.len()).filter(|s| events[*s] * FOLDS / instants.max(1) == fold).collect();
        let part = |c: &[f64]| -> Vec<f64> { own.iter().map(|s| c[*s]).collect() };
        let parts: Vec<Vec<f64>> = white.iter().map(|c| part(c)).collect();
        let r = part(&r);
        let (mut matrix, mut right) = (normal.matrix.clone(), normal.right.clone());
        for i in 0..n {
            for j in 0..n {
                matrix[(i, j)] -= dot(&parts[i], &parts[j]);
            }
            right[i] -= dot(&parts[i], &r);
        }
        let bare = Cholesky::new(matrix.view((0, 0), (u, u)).into_owned())?.solve(&right.rows(0, u).into_owned());
        for i in u..n {
            matrix[(i, i)] += ridge.precision;
        }
        let full = Cholesky::new(matrix)?.solve(&right);
        for (k, s) in own.iter().enumerate() {
            let without = r[k] - (0..u).map(|i| parts[i][k] * bare[i]).sum::<f64>();
            let with = r[k] - (0..n).map(|i| parts[i][k] * full[i]).sum::<f64>();
            gained[events[*s]] += 0.5 * (without * without - with * with) / scale;
        }
    }
    let mut times = Vec::with_capacity(instants);
    let mut origin = 0.0;
    for timeline in engine.timelines.iter() {
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        times.extend(timeline.events.iter().filter(|event| event.count > 0).map(|event| origin + event.t_s - first));
        origin += timeline.events.last().map_or(0.0, |event| event.t_s - first) + 10.0 * BLOCK_S;
    }
    Some(blocks(&times.into_iter().zip(gained).collect::<Vec<_>>(), block_s(engine)))
}
