//! Sizes and poles of the noise by maximum likelihood on a linear model, with or without further
//! columns; unspecified disturbances pay their prior.
//!
//! Coordinates: logarithm of every input's and channel's standard deviation, inverse hyperbolic
//! tangent of every channel's pole. They are moved one after the other along parabolas through
//! three points, a bounded number of sweeps.
//!
//! Of a large plant or a long recording that is dear: many columns are whitened for every point.
//! The information on the noise and on the mean of a Gaussian is independent (their Fisher
//! information has no common block), so there unknowns and columns are held where they explain most
//! and all coordinates are moved at once along the gradient (`climb`).

mod climb;

use super::{EstimationSession, LinearisedProblem, parallel};
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
/// Largest pole: slower noise is a drift; and smallest.
const POLE_MAX: f64 = 0.98;
const POLE_MIN: f64 = -0.5;
/// Share of all work from which on a search is dear, if every coordinate asks for so many points
/// and these whiten so many columns.
const DEAR: f64 = 0.01;
const POINTS_PER_COORDINATE: usize = 24;
const COLUMNS_PER_POINT: usize = 16;

/// Gain in `−2 ln p` of a sweep that is not worth another.
const SWEPT: f64 = 0.05;

/// Jitters that are tried, as shares of the sampling interval, and the gain in `−2 ln p` from which
/// one is taken up: BIC's price of one parameter, `ln n`, at n = 22 000 samples.
const JITTER_SHARES: [f64; 3] = [3e-3, 0.02, 0.1];
const JITTER_GAIN: f64 = 10.0;
/// Sweeps over a channel's size, and over its size and jitter.
const JITTER_SWEEPS: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq)]
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
        Coordinate::Pole(k) => moved.pole[k] = libm::tanh(libm::atanh(moved.pole[k]) + by).clamp(POLE_MIN, POLE_MAX),
    }
    moved
}

/// Noise that minimises `−2 ln p` over noise, unknowns and `extra` columns from `start`; returns it
/// with that minimum.
pub fn maximise(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    theta: &[f64],
    extra: &[&Vec<f64>],
    start: &NoiseModel,
    search: Search,
) -> Option<(NoiseModel, f64)> {
    let value = |noise: &NoiseModel| -> Option<f64> {
        Some(linearised.normal(session, theta, noise, extra)?.minimum()?.0 + session.disturbance_price(noise))
    };
    let size = linearised.linears.first().map_or(0, |linear| linear.layout.len());
    let mut list: Vec<Coordinate> = (0..start.sensor_sigma.len()).map(Coordinate::Sensor).collect();
    if size <= SIZE_MAX {
        list.extend((0..start.input_sigma.len()).map(Coordinate::Input));
        if search.colour {
            list.extend((0..start.sensor_sigma.len()).map(Coordinate::Pole));
        }
    }
    // the same for every set of columns: what is compared is searched alike
    let is_dear = session.work.affords(DEAR, linearised.whitening_work(session, COLUMNS_PER_POINT))
        < (POINTS_PER_COORDINATE * list.len()) as f64;
    if is_dear {
        return climb::climbed((session, linearised), (theta, extra), start, list, search);
    }
    let least = value(start)?;
    Some(one_by_one(session, size, (start, least), list, search, &value))
}

/// Along one coordinate after the other.
fn one_by_one(
    session: &EstimationSession<'_>,
    size: usize,
    start: (&NoiseModel, f64),
    mut list: Vec<Coordinate>,
    search: Search,
    value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
) -> (NoiseModel, f64) {
    let (mut noise, mut best) = begun(session, search, size, start, value);
    list.extend((0..noise.jitter_s.len()).filter(|k| noise.jitter_s[*k] > 0.0).map(Coordinate::Jitter));
    let first = |c: &Coordinate| if matches!(c, Coordinate::Sensor(_)) { 0.1 } else { 0.3 };
    let mut steps: Vec<f64> = list.iter().map(first).collect();
    for _ in 0..search.sweeps {
        let before = best;
        for (coordinate, step) in list.iter().zip(&mut steps) {
            (noise, best) = along(session.threads, (&noise, best), *coordinate, step, value);
        }
        if before - best < SWEPT {
            break;
        }
    }
    (noise, best)
}

/// Inputs off their floor and jitters taken up, where the search asks for that.
fn begun(
    session: &EstimationSession<'_>,
    search: Search,
    size: usize,
    (start, best): (&NoiseModel, f64),
    value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
) -> (NoiseModel, f64) {
    if !search.scan || size > SIZE_MAX {
        return (start.clone(), best);
    }
    let (noise, best) = scan(session, start, best, value);
    jitter(session, &noise, best, value)
}

/// Decades above the floor for inputs of unspecified noise.
fn scan(
    session: &EstimationSession<'_>,
    start: &NoiseModel,
    least: f64,
    value: &dyn Fn(&NoiseModel) -> Option<f64>,
) -> (NoiseModel, f64) {
    let (mut noise, mut best) = (start.clone(), least);
    for k in 0..noise.input_sigma.len() {
        if noise.input_sigma[k] > 1.01 * session.noise.input_sigma[k] {
            continue;
        }
        let mut worse = 0;
        for decade in 1..5 {
            let tried = moved(&noise, Coordinate::Input(k), 0.0);
            let mut tried = NoiseModel { ..tried };
            tried.input_sigma[k] = session.noise.input_sigma[k] * 10f64.powi(decade);
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
    session: &EstimationSession<'_>,
    start: &NoiseModel,
    least: f64,
    value: &(dyn Fn(&NoiseModel) -> Option<f64> + Sync),
) -> (NoiseModel, f64) {
    let climbed = |noise: &NoiseModel, best: f64, coordinates: &[Coordinate]| {
        let (mut noise, mut best) = (noise.clone(), best);
        let mut steps = vec![0.3; coordinates.len()];
        for _ in 0..JITTER_SWEEPS {
            for (coordinate, step) in coordinates.iter().zip(&mut steps) {
                (noise, best) = along(session.threads, (&noise, best), *coordinate, step, value);
            }
        }
        (noise, best)
    };
    let (mut noise, mut best) = (start.clone(), least);
    // stamps that are even to the last digit do not jitter
    for k in (0..noise.jitter_s.len()).filter(|k| session.has_uneven_stamps(*k)) {
        (noise, best) = climbed(&noise, best, &[Coordinate::Sensor(k)]);
        let trial = |share: &f64| {
            let mut tried = noise.clone();
            tried.jitter_s[k] = share * session.interval_s(k);
            tried.sensor_sigma[k] = tried.sensor_sigma[k].min(session.noise.sensor_sigma[k]);
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
