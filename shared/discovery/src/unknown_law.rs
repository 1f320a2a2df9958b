//! A law that no entry of the catalogue describes: a smooth map of a force, or of a reading's
//! error.
//!
//! ```text
//! f(a, b) = Σ w_i φ_i(a, b),   φ Gaussians on a 5 × 5 grid over the visited box (25 along one coordinate),   w ~ N(0, s²)
//! ```
//!
//! The weights have one prior scale s, which maximises the evidence; every place has its map, and
//! the one of most evidence is taken. It is accepted when it predicts parts of the recording that
//! it was not fitted to. Columns come from the forcing of the linear model: a force acts at a noise
//! input, an error at the reading of its channel.

mod noise_hypotheses;
mod places;
mod powers;
mod ridge;

pub(crate) use noise_hypotheses::NoiseHypothesis;
pub use places::{Acts, Coordinate, Place, site_of_input};
pub(crate) use powers::{Power, powers};
pub use ridge::Cell;

use crate::score::event_of_sample;
use crate::score::forcing::{Sources, respond};
use dynamics::description::Plant;
use identification::dot::dot;
use identification::filter::{Linear, NoiseModel, Propagator};
use identification::fit::{EstimationSession, LinearisedProblem, White};
use identification::held_out::{BLOCK_S, Gain, block_s, blocks};
use nalgebra::Cholesky;
use noise_hypotheses::noise_hypotheses;
use places::{FUNCTIONS, Span, basis, places, samples_of, visited};
use ridge::Ridge;

/// Folds of the recording, each predicted from the others; stretches that a fold is made of where
/// the law depends on time.
const FOLDS: usize = 8;
const STRETCHES: usize = 8;

/// The map of most evidence.
#[derive(Clone, Debug)]
pub struct UnknownLaw {
    pub place: Place,
    pub names: Vec<String>,
    pub cells: Vec<Cell>,
    /// Twice the logarithm of the evidence relative to no map, noise maximised over the hypotheses
    /// on both sides.
    pub evidence: f64,
    /// Number of maps tested.
    pub tried: usize,
    /// Gain on parts of the recording that the weights were not fitted to.
    pub held_out: Gain,
    /// Of a law of one parameter.
    pub formula: Option<String>,
}

/// The best map so far.
struct Leader {
    evidence: f64,
    place: Place,
    columns: Vec<Vec<f64>>,
    ridge: Ridge,
    noise: NoiseModel,
    span: Span,
}

/// Share of all work for every place on every hypothesis, and least number of places kept; beyond
/// the share only the places that lead on the first and the last hypothesis are continued. Chosen,
/// no derivation.
const MAP_WORK_SHARE: f64 = 0.05;
const PLACES_MIN: usize = 3;

/// The map of most evidence about `theta`; `None` where nothing varies.
///
/// Cost: `FUNCTIONS` columns for each place, whitened once for each hypothesis; those of the
/// unknowns once for all places.
pub fn best(
    session: &EstimationSession<'_>,
    plant: &Plant,
    linearised: &LinearisedProblem,
    theta: &[f64],
    adapted: &NoiseModel,
) -> Option<UnknownLaw> {
    let mut places = places(plant, linearised.linears.first()?);
    // time differs from run to run
    places.retain(|place| linearised.linears.len() == 1 || !place.is_of_time());
    let noises = noise_hypotheses(session, adapted);
    let propagators = propagators(session, plant, theta)?;
    let whites: Vec<White<'_>> = noises.iter().filter_map(|noise| White::new(session, linearised, noise)).collect();
    let all: Vec<&White<'_>> = whites.iter().collect();
    let on = |place: &Place, whites: &[&White<'_>]| {
        on_hypotheses((session, &propagators), (linearised, theta), place, whites)
    };
    let hypotheses = (places.len() * all.len()) as f64;
    let mut few: Vec<&Place> = places.iter().collect();
    let each = linearised.normal_work(session, FUNCTIONS) - linearised.normal_work(session, 0);
    if let [first, .., last] = all[..]
        && all.len() > 2
        && session.work.affords(MAP_WORK_SHARE, each) < hypotheses
    {
        let evidence = |place: &Place| on(place, &[first, last]).map_or(f64::NEG_INFINITY, |leader| leader.evidence);
        let mut order: Vec<(f64, &Place)> = places.iter().map(|place| (evidence(place), place)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        few = order.into_iter().take(PLACES_MIN).map(|(_, place)| place).collect();
    }
    let leaders = few.into_iter().filter_map(|place| on(place, &all));
    let leader = leaders.reduce(|best, other| if other.evidence > best.evidence { other } else { best })?;
    let Leader { evidence, place, columns, ridge, noise, span } = leader;
    let weights = Weights { columns: &columns, precision: ridge.precision, is_of_time: place.is_of_time() };
    let held_out = predicted(session, (linearised, theta), &noise, &weights)?;
    let names = place.names(&linearised.linears[0]);
    Some(UnknownLaw { place, names, cells: ridge.cells(&span), evidence, tried: places.len(), held_out, formula: None })
}

/// The map of one place on the hypothesis where it has most evidence; `None` where nothing varies.
fn on_hypotheses(
    (session, propagators): (&EstimationSession<'_>, &[Propagator<'_>]),
    (linearised, theta): (&LinearisedProblem, &[f64]),
    place: &Place,
    whites: &[&White<'_>],
) -> Option<Leader> {
    let span = visited(linearised, propagators, place)?;
    let functions = Functions { count: FUNCTIONS, fill: &|at, out| basis(&span, at, out) };
    let columns = columns((session, propagators), linearised, (place, &functions), &mut |_, _| {});
    let extra: Vec<&Vec<f64>> = columns.iter().collect();
    let on =
        |white: &&White<'_>| NoiseHypothesis::of(session, theta, white.normal(session, theta, &extra)?, &white.noise);
    let hypotheses: Vec<NoiseHypothesis> = whites.iter().filter_map(on).collect();
    let samples = (session.samples + session.problem.unknowns.len()) as f64;
    let null = hypotheses
        .iter()
        .map(|hypothesis| hypothesis.at(hypothesis.reduced_chi2, samples))
        .fold(f64::INFINITY, f64::min);
    let of = |hypothesis: &NoiseHypothesis| Some((Ridge::new(hypothesis, samples)?, hypothesis.noise.clone()));
    let ridges = hypotheses.iter().filter_map(of);
    let (ridge, noise) =
        ridges.reduce(|best, other| if other.0.objective < best.0.objective { other } else { best })?;
    Some(Leader { evidence: null - ridge.objective, place: place.clone(), columns, ridge, noise, span })
}

/// Functions of the coordinates of a place.
struct Functions<'f> {
    count: usize,
    fill: &'f dyn Fn(&[f64], &mut [f64]),
}

/// One propagator for each run; `None` where the plant cannot be evaluated.
fn propagators<'e>(session: &'e EstimationSession<'_>, plant: &Plant, theta: &[f64]) -> Option<Vec<Propagator<'e>>> {
    let propagator = |run: usize| {
        Propagator::new(session.problem, run, &session.problem.instance(plant, theta, run), &session.timelines[run])
            .ok()
    };
    (0..session.timelines.len()).map(propagator).collect()
}

/// `−∂ν/∂w` of every function; `seen` receives what it adds to the states, run by run.
fn columns(
    (session, propagators): (&EstimationSession<'_>, &[Propagator<'_>]),
    linearised: &LinearisedProblem,
    (place, functions): (&Place, &Functions<'_>),
    seen: &mut dyn FnMut((usize, usize), &Sources),
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; linearised.nu.len()]; functions.count];
    for (run, (linear, propagator)) in linearised.linears.iter().zip(propagators).enumerate() {
        let sources: Box<dyn Fn(usize) -> Sources> = match place.acts {
            Acts::Force(input) => Box::new(forces(linear, propagator, (place, input), functions)),
            Acts::Reading(channel) => Box::new(errors(linear, propagator, (place, channel), functions)),
        };
        for (i, column) in columns.iter_mut().enumerate() {
            let sources = sources(i);
            seen((run, i), &sources);
            let change = respond(linear, propagator.timeline, &sources);
            for (c, change) in column[session.offsets[run]..].iter_mut().zip(change) {
                *c = -change;
            }
        }
    }
    columns
}

/// Each function as a force at a noise input: mean of both ends of an interval, and the direct part
/// of an instant.
fn forces<'l>(
    linear: &'l Linear,
    propagator: &'l Propagator<'_>,
    (place, input): (&Place, usize),
    functions: &Functions<'_>,
) -> impl Fn(usize) -> Sources + use<'l> {
    let count = functions.count;
    let timeline = propagator.timeline;
    let (n, m, x) = (linear.layout.tangent, linear.layout.noise_inputs.len(), linear.state_names.len());
    let events = timeline.events.len();
    let row_len = linear.row_len();
    let [mut begins, mut ends, mut reads] = [0; 3].map(|_| vec![0.0; events * count]);
    let mut at = vec![0.0; place.along.len()];
    for k in 0..events {
        let slot = k * count..(k + 1) * count;
        let mut fill = |states: &[f64], acts: (usize, bool), out: &mut [f64]| {
            place.at_state(propagator, acts, &states[k * x..(k + 1) * x], &mut at);
            (functions.fill)(&at, out);
        };
        fill(&linear.updated, (k, false), &mut begins[slot.clone()]);
        fill(&linear.states, (k.saturating_sub(1), k > 0), &mut ends[slot.clone()]);
        fill(&linear.states, (k, false), &mut reads[slot]);
    }
    move |i| {
        let mut sources = Sources { state: vec![0.0; events * n], reading: vec![0.0; timeline.value.len()] };
        for (k, event) in timeline.events.iter().enumerate() {
            for sample in event.first..event.first + event.count {
                sources.reading[sample] = linear.measurement[sample * row_len + n + input] * reads[k * count + i];
            }
            if k + 1 < events {
                let mean = 0.5 * (begins[k * count + i] + ends[(k + 1) * count + i]);
                for row in 0..n {
                    sources.state[k * n + row] = linear.transition[(k * n + row) * (n + m) + n + input] * mean;
                }
            }
        }
        sources
    }
}

/// Each function as an error of a channel's readings.
fn errors<'l>(
    linear: &'l Linear,
    propagator: &'l Propagator<'_>,
    (place, channel): (&Place, usize),
    functions: &Functions<'_>,
) -> impl Fn(usize) -> Sources + use<'l> {
    let count = functions.count;
    let samples: Vec<usize> = samples_of(propagator, channel).collect();
    let mut values = vec![0.0; samples.len() * count];
    let mut at = vec![0.0; place.along.len()];
    for (sample, values) in samples.iter().zip(values.chunks_exact_mut(count)) {
        place.at_sample(linear, propagator, *sample, &mut at);
        (functions.fill)(&at, values);
    }
    let (states, readings) =
        (propagator.timeline.events.len() * linear.layout.tangent, propagator.timeline.value.len());
    move |i| {
        let mut sources = Sources { state: vec![0.0; states], reading: vec![0.0; readings] };
        samples.iter().zip(values.chunks_exact(count)).for_each(|(s, values)| sources.reading[*s] = values[i]);
        sources
    }
}

/// A law's functions and the precision of the prior of each weight.
struct Weights<'c> {
    columns: &'c [Vec<f64>],
    precision: f64,
    is_of_time: bool,
}

/// Gain in log-likelihood of every fold with weights and unknowns from the others.
fn predicted(
    session: &EstimationSession<'_>,
    (linearised, theta): (&LinearisedProblem, &[f64]),
    noise: &NoiseModel,
    law: &Weights<'_>,
) -> Option<Gain> {
    let extra: Vec<&Vec<f64>> = law.columns.iter().collect();
    let normal = linearised.normal(session, theta, noise, &extra)?;
    let (r, white) = linearised.whitened(session, noise, &extra)?;
    let events = event_of_sample(session);
    let instants = events.last().map_or(0, |last| last + 1);
    let (u, n) = (normal.unknowns, white.len());
    // variance that the hypothesis's scale left open
    let scale = normal.chi2 / session.samples.max(1) as f64;
    let mut gained = vec![0.0; instants];
    let stretches = if law.is_of_time { STRETCHES } else { 1 };
    let fold_of = |sample: usize| (events[sample] * FOLDS * stretches / instants.max(1)) % FOLDS;
    for fold in 0..FOLDS {
        let own: Vec<usize> = (0..events.len()).filter(|s| fold_of(*s) == fold).collect();
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
            matrix[(i, i)] += law.precision;
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
    for timeline in session.timelines.iter() {
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        times.extend(timeline.events.iter().filter(|event| event.count > 0).map(|event| origin + event.t_s - first));
        origin += timeline.events.last().map_or(0.0, |event| event.t_s - first) + 10.0 * BLOCK_S;
    }
    Some(blocks(&times.into_iter().zip(gained).collect::<Vec<_>>(), block_s(session)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, problem, recording, with_effect};
    use identification::held_out::Status;

    /// The best map where `kind` is unmodelled, and whether it is accepted.
    fn found(name: &str, duration_s: f64, kind: &str, site: &str, values: &[(&str, f64)]) -> UnknownLaw {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&with_effect(&nominal, kind, site, values), 6, duration_s));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
        best(&session, &nominal, &linearised, &session.prior(), &session.noise).unwrap()
    }

    #[test]
    fn an_error_of_a_reading_is_found_at_its_channel_over_what_it_depends_on() {
        let map = found("drive_rig", 2.0, "sensor_quadratic", "sensor:rate", &[("coefficient", 2e-3)]);
        assert_eq!((map.place.acts, map.place.site.as_str()), (Acts::Reading(1), "sensor:rate"));
        assert!(map.names[0] == "sensor:rate" && map.held_out.status() == Status::Confirmed, "{:?}", map.names);
        let step = [("step", 0.03), ("begin", 0.7), ("duration", 0.6)];
        let map = found("drive_rig", 2.0, "sensor_step", "sensor:rate", &step);
        assert!(map.place.is_of_time() && map.place.site == "sensor:rate" && map.evidence > 50.0, "{:?}", map.place);
        // inside the step and well outside
        let at = |t_s: f64| {
            map.cells.iter().min_by(|a, b| (a.at[0] - t_s).abs().total_cmp(&(b.at[0] - t_s).abs())).unwrap().value
        };
        assert!((at(1.0) - at(0.3) - 0.03).abs() < 0.01, "{} {}", at(1.0), at(0.3));
    }

    /// It moves a bending mode, whose unit is another one, more than the joint.
    #[test]
    fn a_torque_in_a_joint_acts_there_whatever_it_moves_most() {
        let nominal = plant("hub_appendage");
        let problem = problem(&nominal, recording(&nominal, 6, 1.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
        let linear = &linearised.linears[0];
        let input = linear.input_names.iter().position(|name| name == "torque").unwrap();
        assert_eq!(site_of_input(&nominal, linear, input).as_deref(), Some("joint:bearing"));
    }

    #[test]
    fn a_force_over_a_position_is_found_at_its_joint() {
        let map = found("pendulum", 8.0, "joint_gear_ripple", "joint:pivot", &[("sine", 0.05), ("order", 6.0)]);
        assert!(matches!(map.place.acts, Acts::Force(_)) && map.place.site == "joint:pivot", "{:?}", map.place);
        assert!(map.evidence > 100.0 && map.held_out.status() == Status::Confirmed, "{}", map.evidence);
    }
}
