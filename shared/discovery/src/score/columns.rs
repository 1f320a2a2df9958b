//! Columns of candidates: by the forcing of the linear model where a law is linear in its
//! amplitude, else by passes at finite amplitude.

use super::Candidate;
use super::candidates::Direction;
use super::forcing::{Course, Sources, comparable, respond};
use dynamics::description::{Plant, SiteKind};
use dynamics::effect::{Family, Law, Role};
use identification::dot::dot;
use identification::filter::{Gains, Propagator, gains, whiten};
use identification::fit::{EstimationSession, LinearisedProblem, parallel};

/// One candidate with its effect on the innovations.
#[derive(Clone, Debug)]
pub struct Column {
    pub candidate: Candidate,
    /// `−∂ν/∂amplitude` per direction.
    pub raw: Vec<Vec<f64>>,
    /// Amplitude of the pass.
    pub step: f64,
    /// Largest push of a direction per amplitude, in the metric of the kinetic energy [√J]; `None`
    /// where it was not taken from the forcing of the linear model.
    pub push: Option<f64>,
}

/// Whitened size of the change that a pass aims at [standard deviations]: small against the
/// curvature, large against rounding.
const PASS_SIZE_SIGMA: f64 = 2.0;
/// Whitened size at half the largest amplitude that is rounding, negligible.
const NEGLIGIBLE_SIZE: f64 = 1e-3;
const TRIES: usize = 8;
/// Passes beside that one, over its amplitude, where a law is not in proportion to it: to effects
/// of some thirty standard errors.
const LARGER: [f64; 2] = [4.0, 16.0];
/// Share of an amplitude beside which the rest of its change is the law's.
const LINEAR_SHARE: f64 = 0.1;

/// Columns of all candidates that change anything, in their order, along the trajectory of a
/// linearised problem.
///
/// Cost: one evaluation of the forcing for each direction of a law linear in its amplitude, else a
/// few filter passes.
pub fn columns(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    candidates: &[Candidate],
) -> Vec<Column> {
    let found: Option<Vec<Gains>> = (linearised.linears.iter().zip(session.timelines.iter()))
        .map(|(linear, timeline)| gains(linear, timeline, &linear.noise))
        .collect();
    let Some(found) = found else { return Vec::new() };
    let courses: Option<Vec<Course<'_>>> = (linearised.linears.iter().enumerate())
        .map(|(run, linear)| Some(Course::new(linear, propagator(session, plant, theta, run)?)))
        .collect();
    let Some(courses) = courses else { return Vec::new() };
    courses.iter().for_each(|course| session.work.add(course.base.work()));
    let laws: Vec<&[Candidate]> = candidates.chunk_by(|a, b| a.same_law(b)).collect();
    let own = |i: usize| law((session, linearised), plant, theta, laws[i], (&found, &courses));
    parallel(laws.len(), session.threads, own).into_iter().flatten().collect()
}

/// Columns of the points of one law; the right amplitude at one of them is about that at the next.
fn law(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    points: &[Candidate],
    (found, courses): (&[Gains], &[Course<'_>]),
) -> Vec<Column> {
    let (mut felt, mut silent) = (None, Vec::new());
    let mut own = |(place, point): (usize, &Candidate)| {
        let mut point = Candidate { felt: point.felt.or(felt), ..point.clone() };
        point.directions.retain(|direction| !silent.contains(direction));
        let own = |point: &Candidate| column_of((session, linearised), plant, theta, point, (found, courses));
        let found = own(&point);
        felt = found.felt;
        if place == 0 && is_a_part_that_swings(&point) {
            silent = found.silent;
        }
        let sizes = found.column.as_ref().map_or_else(Vec::new, |column| larger(column, &point));
        let at_sizes = sizes.into_iter().filter_map(|at| own(&Candidate { at: Some(at), ..point.clone() }).column);
        let at_sizes: Vec<Column> = at_sizes.collect();
        found.column.into_iter().chain(at_sizes)
    };
    points.iter().enumerate().flat_map(&mut own).collect()
}

/// Larger amplitudes at which a gap is looked at: what it does is not in proportion to its width.
/// What a law does that forces the linear model is.
fn larger(column: &Column, point: &Candidate) -> Vec<f64> {
    let is_gap = point.effect.family == Family::Clearance && point.at.is_none() && column.push.is_none();
    let sizes = LARGER.map(|factor| factor * column.step);
    sizes.into_iter().filter(|at| is_gap && *at < point.high).collect()
}

/// The effect adds an oscillator of its own: what excites it shows most at its softest, which is
/// the first point of its grid; a direction without response there has none at any frequency. A
/// direction that only a lever excites is that of a law of rotation.
fn is_a_part_that_swings(candidate: &Candidate) -> bool {
    let swings = candidate.inner_with(Role::Frequency).is_some();
    swings && matches!(candidate.effect.law, Law::Structure(_)) && candidate.at.is_none()
}

pub(crate) fn propagator<'a>(
    session: &'a EstimationSession<'_>,
    plant: &Plant,
    theta: &[f64],
    run: usize,
) -> Option<Propagator<'a>> {
    let instance = session.problem.instance(plant, theta, run);
    Propagator::new(session.problem, run, &instance, &session.timelines[run]).ok()
}

/// Result of one candidate.
struct Done {
    column: Option<Column>,
    /// Amplitude of its passes, where all of them had the right size.
    felt: Option<f64>,
    /// Directions without response at any amplitude.
    silent: Vec<Direction>,
}

/// Column of a candidate.
fn column_of(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    candidate: &Candidate,
    (found, courses): (&[Gains], &[Course<'_>]),
) -> Done {
    let (mut felt, mut silent) = (Some(0.0f64), Vec::new());
    let mut column = Column { candidate: candidate.clone(), raw: Vec::new(), step: 0.0, push: Some(0.0) };
    column.candidate.directions.clear();
    for direction in 0..candidate.directions.len() {
        // a direction without response (out of the plane) would make the others singular
        let forced = || forced(session, linearised, (plant, courses), theta, (candidate, direction));
        let forced = candidate.at.is_none().then(forced).flatten();
        let found = match forced {
            Some(forced) => forced.map(|(raw, step, push)| (raw, step, Some(push))),
            None => {
                let passed = along(session, linearised, plant, theta, (candidate, direction), found);
                let own = passed.as_ref().filter(|(.., is_felt)| *is_felt).map(|(_, step, _)| *step);
                felt = felt.zip(own).map(|(a, b)| a.max(b));
                passed.map(|(raw, step, _)| (raw, step, None))
            }
        };
        let Some((raw, step, push)) = found else { continue };
        if 0.5 * candidate.range(direction)[1] * stated_size(session, &raw) < NEGLIGIBLE_SIZE {
            silent.push(candidate.directions[direction].clone());
            continue;
        }
        column.candidate.directions.push(candidate.directions[direction].clone());
        column.step = column.step.max(step);
        column.push = column.push.zip(push).map(|(most, push)| most.max(push));
        column.raw.push(raw);
    }
    Done { column: (!column.raw.is_empty()).then_some(column), felt: felt.filter(|step| *step > 0.0), silent }
}

/// Amplitude of the forcing in default amplitudes, and largest nonlinearity of a law between it and
/// the default [relative]. Chosen, no derivation: the error of the column is of this order.
const FORCING_AMPLITUDE: f64 = 1e-2;
const NONLINEARITY_MAX: f64 = 0.02;
/// Instants at which the linearity of a law is tested.
const LINEARITY_TEST_INSTANTS: usize = 60;

/// Column of one direction by forcing, its amplitude and its push per amplitude. Outer `None`: the
/// law is not linear in its amplitude, or has states, lags or parts of its own.
#[allow(clippy::option_option)]
fn forced(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    (plant, courses): (&Plant, &[Course<'_>]),
    theta: &[f64],
    (candidate, direction): (&Candidate, usize),
) -> Option<Option<(Vec<f64>, f64, f64)>> {
    let default = candidate.effect.parameters[0].default.abs();
    let large = if default > 0.0 { default.min(0.5 * candidate.high) } else { 1e-3 * candidate.high };
    let with = |amplitude: f64| -> Option<Plant> {
        let mut with = plant.clone();
        with.add_effect(candidate.effect.kind, &candidate.site, &candidate.values(amplitude, direction)).ok()?;
        Some(with)
    };
    let (small, large_plant) = (with(FORCING_AMPLITUDE * large)?, with(large)?);
    let largest = with(0.5 * candidate.range(direction)[1])?;
    // a sensor moves nothing: commands are those recorded
    let readings_alone = candidate.site.kind == SiteKind::Sensor;
    let mut raw = vec![0.0; linearised.nu.len()];
    let (mut any, mut any_larger, mut push) = (false, false, 0.0);
    for (run, (linear, course)) in linearised.linears.iter().zip(courses).enumerate() {
        let timeline = &session.timelines[run];
        let mut other = propagator(session, &small, theta, run)?;
        if !comparable(&course.base, &other) {
            return None;
        }
        let every = (timeline.events.len() / LINEARITY_TEST_INSTANTS).max(1);
        let mut much = propagator(session, &large_plant, theta, run)?;
        let few = course.sources(&mut other, readings_alone, every);
        let bends = bent(&few, &course.sources(&mut much, readings_alone, every)) > NONLINEARITY_MAX;
        let all = (!bends).then(|| course.sources(&mut other, readings_alone, 1));
        session.work.add(other.work() + much.work());
        let all = all?;
        push += course.kinetic.square(&all.state);
        if all.is_silent() {
            let mut most = propagator(session, &largest, theta, run)?;
            any_larger |=
                [&mut much, &mut most].into_iter().any(|own| !course.sources(own, readings_alone, 1).is_silent());
            session.work.add(much.work() + most.work());
            continue;
        }
        any = true;
        let change = respond(linear, timeline, &all);
        if !change.iter().all(|c| c.is_finite()) {
            return None;
        }
        for (raw, change) in raw[session.offsets[run]..].iter_mut().zip(&change) {
            *raw = -change / (FORCING_AMPLITUDE * large);
        }
    }
    // a law without effect at this amplitude may have one at its usual size
    let is_forced = any || !any_larger;
    is_forced.then(|| any.then(|| (raw, large, push.sqrt() / (FORCING_AMPLITUDE * large))))
}

/// Distance of two sets of sources per amplitude, relative to the larger.
fn bent(small: &Sources, large: &Sources) -> f64 {
    let of = |small: &[f64], large: &[f64]| -> (f64, f64) {
        let apart = small
            .iter()
            .zip(large)
            .map(|(s, l)| (s / FORCING_AMPLITUDE - l) * (s / FORCING_AMPLITUDE - l))
            .sum::<f64>();
        (apart, dot(large, large).max(dot(small, small) / (FORCING_AMPLITUDE * FORCING_AMPLITUDE)))
    };
    let (state, reading) = (of(&small.state, &large.state), of(&small.reading, &large.reading));
    let share = |(apart, whole): (f64, f64)| if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 };
    share(state).max(share(reading))
}

/// Column of one direction at an amplitude of visible size: with that amplitude, and whether it was
/// reached.
fn along(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    plant: &Plant,
    theta: &[f64],
    (candidate, direction): (&Candidate, usize),
    found: &[Gains],
) -> Option<(Vec<f64>, f64, bool)> {
    let default = candidate.effect.parameters[0].default.abs();
    if let Some(step) = candidate.at {
        let change = change(session, linearised, plant, theta, candidate, (step, direction))?;
        return change.iter().all(|c| c.is_finite()).then(|| (change.iter().map(|d| -d / step).collect(), step, false));
    }
    let mut step =
        candidate.felt.unwrap_or(if default > 0.0 { default.min(0.5 * candidate.high) } else { 1e-3 * candidate.high });
    let mut best: Option<(Vec<f64>, f64, f64)> = None;
    // largest amplitude without effect, smallest of too large an effect: between them a law may
    // begin to act
    let mut between = [0.0, f64::INFINITY];
    let mut is_felt = false;
    for _ in 0..TRIES {
        let felt = change(session, linearised, plant, theta, candidate, (step, direction));
        let size =
            felt.as_ref().map(|change| felt_size(session, linearised, change, found)).filter(|size| size.is_finite());
        let (Some(change), Some(size)) = (felt, size) else {
            between[1] = step.min(between[1]);
            step = within(0.01 * step, between);
            continue;
        };
        let off = libm::log(size / PASS_SIZE_SIGMA).abs();
        if best.as_ref().is_none_or(|(.., least)| off < *least) {
            best = Some((change, step, off));
        }
        is_felt = (0.02 * PASS_SIZE_SIGMA..5.0 * PASS_SIZE_SIGMA).contains(&size);
        if is_felt {
            break;
        }
        between = if size < PASS_SIZE_SIGMA {
            [step.max(between[0]), between[1]]
        } else {
            [between[0], step.min(between[1])]
        };
        let factor = if size > 0.0 { (PASS_SIZE_SIGMA / size).clamp(1e-4, 1e3) } else { 1e3 };
        let next = within(step * factor, between).min(0.5 * candidate.high);
        if next == step {
            break;
        }
        step = next;
    }
    // no effect at amplitudes that the plant survives is no statement about larger ones
    let (own, step, _) = best.filter(|(.., off)| off.is_finite() || between[1].is_infinite())?;
    let mut raw: Vec<f64> = own.iter().map(|d| -d / step).collect();
    if !integrates_alike(session, plant, theta, candidate, (step, direction)) {
        // a change by finer steps alone does not grow with the amplitude
        let little = change(session, linearised, plant, theta, candidate, (LINEAR_SHARE * step, direction))?;
        raw = own.iter().zip(&little).map(|(own, little)| (little - own) / ((1.0 - LINEAR_SHARE) * step)).collect();
    }
    raw.iter().all(|c| c.is_finite()).then_some((raw, step, is_felt))
}

/// The plant with the candidate takes the same integration steps as without: states of its own may
/// need finer ones.
fn integrates_alike(
    session: &EstimationSession<'_>,
    plant: &Plant,
    theta: &[f64],
    candidate: &Candidate,
    (step, direction): (f64, usize),
) -> bool {
    if !matches!(candidate.effect.law, Law::Structure(_)) {
        return true;
    }
    let mut with = plant.clone();
    if with.add_effect(candidate.effect.kind, &candidate.site, &candidate.values(step, direction)).is_err() {
        return true;
    }
    let finer = |plant: &Plant, run: usize| propagator(session, plant, theta, run).map(|propagator| propagator.finer());
    (0..session.timelines.len()).all(|run| finer(plant, run) == finer(&with, run))
}

/// `step`, or where it is beyond a step of too small or too large an effect, the geometric mean of
/// the two.
fn within(step: f64, [low, high]: [f64; 2]) -> f64 {
    if low > 0.0 && high.is_finite() && !(low < step && step < high) { (low * high).sqrt() } else { step }
}

/// Size of a column in stated standard deviations.
fn stated_size(session: &EstimationSession<'_>, raw: &[f64]) -> f64 {
    let channels = session.timelines.iter().flat_map(|timeline| &timeline.channel);
    let own = raw.iter().zip(channels).map(|(change, channel)| change / session.noise.sensor_sigma[*channel]);
    own.map(|change| change * change).sum::<f64>().sqrt()
}

/// Whitened size of a change of the innovations.
fn felt_size(session: &EstimationSession<'_>, linearised: &LinearisedProblem, change: &[f64], found: &[Gains]) -> f64 {
    let mut white = change.to_vec();
    for (run, linear) in linearised.linears.iter().enumerate() {
        let range = session.offsets[run]..session.offsets[run] + linear.nu.len();
        whiten(linear, &session.timelines[run], &found[run], &mut [&mut white[range]]);
    }
    dot(&white, &white).sqrt()
}

/// Change of the innovations at one amplitude in one direction.
fn change(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    plant: &Plant,
    theta: &[f64],
    candidate: &Candidate,
    (step, direction): (f64, usize),
) -> Option<Vec<f64>> {
    let mut with = plant.clone();
    with.add_effect(candidate.effect.kind, &candidate.site, &candidate.values(step, direction)).ok()?;
    let nu = session.innovations(&with, theta, &linearised.linears, &|_| true)?;
    let mut change: Vec<f64> = nu.iter().zip(&linearised.nu).map(|(a, b)| a - b).collect();
    change.iter_mut().for_each(|c| {
        if !c.is_finite() {
            *c = f64::NAN
        }
    });
    Some(change)
}

#[cfg(test)]
mod tests;
