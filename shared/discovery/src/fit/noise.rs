//! Sizes and poles of the noise by maximum likelihood on a linear model, with or without further columns; disturbances that nobody
//! states pay their prior.
//!
//! Coordinates: logarithm of every input's and channel's standard deviation, inverse hyperbolic tangent of every channel's pole. They are
//! moved one after the other along parabolas through three points, a bounded number of sweeps.
//!
//! Of a large plant or a long recording that is dear: many columns are whitened for every point. Noise and mean of a Gaussian tell nothing of each
//! other (their Fisher information has no common block), so there unknowns and columns are held where they explain most under the noise of
//! the sweep's beginning, or since much was gained ([`Held`]); what finds nothing rests until others have gained; and a pole has a price.

use super::{Board, Engine, parallel};
use crate::filter::NoiseModel;

/// What is moved, and how far.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    pub sweeps: usize,
    /// Poles are estimated too.
    pub colour: bool,
    /// Inputs at their floor are looked for at decades above it.
    pub scan: bool,
}

/// Beyond this size of z the sensors' sizes alone are moved.
const SIZE_MAX: usize = 26;
/// Largest pole: slower noise is a drift.
const POLE_MAX: f64 = 0.98;
/// Gain in `−2 ln p` below which a pole is none where the search is dear: what chance gives a number that is not there (AIC).
const POLE_PRICE: f64 = 2.0;
/// Share of all work from which on a search is dear, if every coordinate asks for so many points and these whiten so many columns.
const DEAR: f64 = 0.05;
const POINTS: usize = 24;
const COLUMNS: usize = 16;

/// Gain in `−2 ln p` of a sweep that is not worth another.
const SWEPT: f64 = 0.05;
/// Of a coordinate that found nothing, of all others since then that wakes it, and behind which what is held is found again.
const FLAT: f64 = 5e-3;
const WOKEN: f64 = 1.0;
const MOVED: f64 = 10.0;

/// Jitters that are tried, as shares of the sampling interval, and the gain in `−2 ln p` from which one is taken up.
const JITTER_SHARES: [f64; 3] = [3e-3, 0.02, 0.1];
const JITTER_GAIN: f64 = 10.0;
/// Sweeps over a channel's size, and over its size and jitter.
const JITTER_SWEEPS: usize = 3;

#[derive(Clone, Copy, Debug)]
enum Coordinate {
    Input(usize),
    Sensor(usize),
    Pole(usize),
    Jitter(usize),
}

fn moved(noise: &NoiseModel, coordinate: Coordinate, by: f64) -> NoiseModel {
    let mut moved = noise.clone();
    match coordinate {
        Coordinate::Input(k) => moved.input_sigma[k] *= libm::exp(by),
        Coordinate::Sensor(k) => moved.sensor_sigma[k] *= libm::exp(by),
        Coordinate::Jitter(k) => moved.jitter_s[k] *= libm::exp(by),
        Coordinate::Pole(k) => moved.pole[k] = libm::tanh(libm::atanh(moved.pole[k]) + by).clamp(-0.5, POLE_MAX),
    }
    moved
}

/// Noise that minimises `−2 ln p` over noise, unknowns and `extra` columns from `start`; returns it with that minimum.
pub fn maximise(
    engine: &Engine<'_>,
    board: &Board,
    theta: &[f64],
    extra: &[&Vec<f64>],
    start: &NoiseModel,
    search: Search,
) -> Option<(NoiseModel, f64)> {
    let value = |noise: &NoiseModel| -> Option<f64> {
        Some(board.normal(engine, theta, noise, extra)?.minimum()?.0 + engine.disturbance_price(noise))
    };
    let size = board.linears.first().map_or(0, |linear| linear.layout.len());
    let mut list: Vec<Coordinate> = (0..start.sensor_sigma.len()).map(Coordinate::Sensor).collect();
    if size <= SIZE_MAX {
        list.extend((0..start.input_sigma.len()).map(Coordinate::Input));
        if search.colour {
            list.extend((0..start.sensor_sigma.len()).map(Coordinate::Pole));
        }
    }
    let mut noise = start.clone();
    let mut best = value(&noise)?;
    if search.scan && size <= SIZE_MAX {
        (noise, best) = scan(engine, &noise, best, &value);
        (noise, best) = jitter(engine, &noise, best, &value);
    }
    list.extend((0..noise.jitter_s.len()).filter(|k| noise.jitter_s[*k] > 0.0).map(Coordinate::Jitter));
    let mut along_all = Sweeps::new(&list);
    // the same for every set of effects: what is compared is searched alike
    let is_dear = engine.work.affords(DEAR, board.whitening_work(engine, COLUMNS)) < (POINTS * list.len()) as f64;
    for _ in 0..search.sweeps {
        let (before, poles) = (best, noise.poles());
        if is_dear {
            let hold = |noise: &NoiseModel| Held::new((engine, board), theta, extra, noise);
            (noise, best) = along_all.held(engine.threads, noise, &hold)?;
        } else {
            (noise, best) = along_all.joint(engine.threads, (noise, best), &value);
        }
        // one pole less is a loss, and something for the others to gain
        if before - best < SWEPT && noise.poles() >= poles {
            break;
        }
    }
    Some((noise, best))
}

/// Coordinates with the steps of their parabolas; and what all had gained when one last found nothing.
struct Sweeps<'l> {
    list: &'l [Coordinate],
    steps: Vec<f64>,
    rests: Vec<Option<f64>>,
    gained: f64,
}

impl<'l> Sweeps<'l> {
    fn new(list: &'l [Coordinate]) -> Self {
        let first = |c: &Coordinate| if matches!(c, Coordinate::Sensor(_)) { 0.1 } else { 0.3 };
        Self { list, steps: list.iter().map(first).collect(), rests: vec![None; list.len()], gained: 0.0 }
    }

    /// One sweep, unknowns and columns free at every point.
    fn joint(
        &mut self,
        threads: usize,
        (mut noise, mut best): (NoiseModel, f64),
        value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
    ) -> (NoiseModel, f64) {
        for (coordinate, step) in self.list.iter().zip(&mut self.steps) {
            (noise, best) = along(threads, (&noise, best), *coordinate, step, value);
        }
        (noise, best)
    }

    /// One sweep, unknowns and columns held.
    fn held<'e, 'p: 'e>(
        &mut self,
        threads: usize,
        mut noise: NoiseModel,
        hold: &dyn Fn(&NoiseModel) -> Option<Held<'e, 'p>>,
    ) -> Option<(NoiseModel, f64)> {
        let mut held = hold(&noise)?;
        let mut best = held.least;
        for ((coordinate, step), rests) in self.list.iter().zip(&mut self.steps).zip(&mut self.rests) {
            if rests.is_some_and(|gained| self.gained < gained + WOKEN) {
                continue;
            }
            let value = |noise: &NoiseModel| held.value(noise);
            let found = along(threads, (&noise, best), *coordinate, step, &value);
            let found = match coordinate {
                Coordinate::Pole(k) => worth_a_pole((&noise, best), found, *k, &value),
                _ => found,
            };
            // a pole less is a change, too
            self.gained += (best - found.1).abs();
            *rests = (best - found.1 < FLAT).then_some(self.gained);
            (noise, best) = found;
            if held.least - best > MOVED {
                held = hold(&noise)?;
                self.gained += best - held.least;
                best = held.least;
            }
        }
        let best = if best == held.least { best } else { hold(&noise)?.least };
        Some((noise, best))
    }
}

/// Unknowns and further columns held where they explain most under one noise.
struct Held<'e, 'p> {
    engine: &'e Engine<'p>,
    board: &'e Board,
    /// What they leave of the raw innovations, and where the unknowns are.
    left: Vec<f64>,
    theta: Vec<f64>,
    /// `−2 ln p` there under that noise: least over unknowns and columns.
    least: f64,
}

impl<'e, 'p> Held<'e, 'p> {
    fn new(
        (engine, board): (&'e Engine<'p>, &'e Board),
        theta: &[f64],
        extra: &[&Vec<f64>],
        noise: &NoiseModel,
    ) -> Option<Self> {
        let (least, x) = board.normal(engine, theta, noise, extra)?.least()?;
        let mut left = board.nu.clone();
        for (column, x) in board.jacobian.iter().chain(extra.iter().copied()).zip(&x) {
            left.iter_mut().zip(column).for_each(|(left, c)| *left -= c * x);
        }
        let unknowns = engine.problem.unknowns.iter().zip(&x);
        let theta = theta.iter().zip(unknowns).map(|(theta, (unknown, x))| theta + x * unknown.sigma).collect();
        Some(Self { engine, board, left, theta, least: least + engine.disturbance_price(noise) })
    }

    /// `−2 ln p` under another noise.
    fn value(&self, noise: &NoiseModel) -> Option<f64> {
        let value = self.board.objective(self.engine, &self.left, &self.theta, noise)?;
        Some(value + self.engine.disturbance_price(noise))
    }
}

/// A pole that gains less than its price is none: it would only make the filter larger.
fn worth_a_pole(
    (white, least): (&NoiseModel, f64),
    found: (NoiseModel, f64),
    k: usize,
    value: &dyn Fn(&NoiseModel) -> Option<f64>,
) -> (NoiseModel, f64) {
    if found.0.pole[k] == 0.0 {
        return found;
    }
    let mut without = if white.pole[k] == 0.0 { white.clone() } else { found.0.clone() };
    without.pole[k] = 0.0;
    let least = if white.pole[k] == 0.0 { Some(least) } else { value(&without) };
    match least {
        Some(least) if least < found.1 + POLE_PRICE => (without, least),
        _ => found,
    }
}

/// Decades above the floor for inputs that nobody stated.
fn scan(
    engine: &Engine<'_>,
    start: &NoiseModel,
    least: f64,
    value: &dyn Fn(&NoiseModel) -> Option<f64>,
) -> (NoiseModel, f64) {
    let (mut noise, mut best) = (start.clone(), least);
    for k in 0..noise.input_sigma.len() {
        if noise.input_sigma[k] > 1.01 * engine.noise.input_sigma[k] {
            continue;
        }
        let mut worse = 0;
        for decade in 1..5 {
            let tried = moved(&noise, Coordinate::Input(k), 0.0);
            let mut tried = NoiseModel { ..tried };
            tried.input_sigma[k] = engine.noise.input_sigma[k] * 10f64.powi(decade);
            let Some(found) = value(&tried) else { break };
            if found < best {
                (noise, best) = (tried, found);
                worse = 0;
            } else {
                worse += 1;
                if worse == 2 {
                    break;
                }
            }
        }
    }
    (noise, best)
}

/// Jitter of stamps, where it explains a channel better than noise of the size that suits it best.
fn jitter(
    engine: &Engine<'_>,
    start: &NoiseModel,
    least: f64,
    value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
) -> (NoiseModel, f64) {
    let climbed = |noise: &NoiseModel, best: f64, coordinates: &[Coordinate]| {
        let (mut noise, mut best) = (noise.clone(), best);
        let mut steps = vec![0.3; coordinates.len()];
        for _ in 0..JITTER_SWEEPS {
            for (coordinate, step) in coordinates.iter().zip(&mut steps) {
                (noise, best) = along(engine.threads, (&noise, best), *coordinate, step, value);
            }
        }
        (noise, best)
    };
    let (mut noise, mut best) = (start.clone(), least);
    // stamps that are even to the last digit do not jitter
    for k in (0..noise.jitter_s.len()).filter(|k| engine.has_uneven_stamps(*k)) {
        (noise, best) = climbed(&noise, best, &[Coordinate::Sensor(k)]);
        let trial = |share: &f64| {
            let mut tried = noise.clone();
            tried.jitter_s[k] = share * engine.interval_s(k);
            tried.sensor_sigma[k] = tried.sensor_sigma[k].min(engine.noise.sensor_sigma[k]);
            value(&tried).map(|found| (tried, found))
        };
        let best_share = JITTER_SHARES.iter().filter_map(trial).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((tried, found)) = best_share else { continue };
        let (tried, found) = climbed(&tried, found, &[Coordinate::Sensor(k), Coordinate::Jitter(k)]);
        if found < best - JITTER_GAIN {
            (noise, best) = (tried, found);
        }
    }
    (noise, best)
}

/// One step along a coordinate: both neighbours, then the least point of the parabola.
fn along(
    threads: usize,
    (noise, best): (&NoiseModel, f64),
    coordinate: Coordinate,
    step: &mut f64,
    value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
) -> (NoiseModel, f64) {
    let h = *step;
    let at = |by: f64| value(&moved(noise, coordinate, by)).unwrap_or(f64::INFINITY);
    let sides = parallel(2, threads, |side| at([h, -h][side]));
    let (up, down) = (sides[0], sides[1]);
    let curvature = up + down - 2.0 * best;
    let mut points = vec![(0.0, best), (h, up), (-h, down)];
    let by = if curvature > 0.0 {
        (0.5 * h * (down - up) / curvature).clamp(-4.0 * h, 4.0 * h)
    } else if up < down {
        3.0 * h
    } else {
        -3.0 * h
    };
    if by.abs() > 0.02 * h && (up - best).abs().max((down - best).abs()) > 0.01 {
        points.push((by, at(by)));
    }
    let least = points.into_iter().fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
    *step = (2.0 * least.0.abs()).clamp(0.3 * h, 2.0 * h).clamp(0.02, 1.0);
    if least.1 < best { (moved(noise, coordinate, least.0), least.1) } else { (noise.clone(), best) }
}
