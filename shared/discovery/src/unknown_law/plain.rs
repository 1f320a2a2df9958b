//! One-parameter laws: a coefficient times a power of one coordinate, or a product of powers of
//! two.
//!
//! ```text
//! f = c φ_i(x)   or   c φ_i(x) φ_j(y),   φ_i(x) = |x|^i, or with the sign of x
//! ```
//!
//! An effect with several shape parameters can describe a motion that one parameter describes as
//! well: a ripple of less than one lobe is a cubic spring, a torque that decays is a drift. Every
//! one-parameter law is evaluated where a force or an error may act; those in the catalogue (a
//! collinear law of one parameter) are skipped. The caller compares the best one with the adopted
//! effects.

use super::places::{Acts, Coordinate, Near, Place, Span, near, visited};
use super::ridge::{Cell, cells};
use super::{Functions, UnknownLaw, Weights, columns, predicted, propagators};
use crate::compete::subsets::NoiseHypothesis;
use dynamics::description::Plant;
use identification::filter::{Linear, NoiseModel, Propagator};
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, LinearisedProblem};

/// `|x|^power`, odd: with the sign of x.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Factor {
    power: i32,
    is_odd: bool,
}

const fn odd(power: i32) -> Factor {
    Factor { power, is_odd: true }
}

const fn even(power: i32) -> Factor {
    Factor { power, is_odd: false }
}

/// Over a position; over a rate; over both.
const POSITION: &[&[Factor]] = &[&[odd(1)], &[odd(2)], &[odd(3)], &[even(1)], &[even(2)]];
const RATE: &[&[Factor]] = &[&[odd(0)], &[odd(1)], &[odd(2)], &[odd(3)], &[even(1)], &[even(2)]];
const BOTH: &[&[Factor]] = &[
    &[odd(1), odd(1)],
    &[even(2), odd(1)],
    &[odd(1), even(2)],
    &[even(1), odd(0)],
    &[even(1), odd(1)],
    &[odd(1), even(1)],
];
/// Over a command; over its rate, and the rate of another coordinate.
const COMMAND: &[&[Factor]] = &[&[odd(0)], &[odd(1)], &[odd(2)], &[odd(3)], &[even(1)], &[even(2)]];
const LINEAR: &[&[Factor]] = &[&[odd(1)]];
/// A force over time, from the beginning of the recording; an error over a reading, and over time.
const FORCE_TIME: &[&[Factor]] = &[&[even(0)], &[odd(1)], &[even(2)]];
const READING: &[&[Factor]] = &[&[odd(1)], &[odd(2)], &[odd(3)], &[even(1)], &[even(2)]];
const READING_TIME: &[&[Factor]] = &[&[odd(1)], &[even(2)]];

/// Absolute cosine from which two laws are the same. Chosen, no derivation.
const SAME_LAW_COSINE: f64 = 0.98;
/// Laws whose likelihood is maximised.
const LAWS_MAXIMISED: usize = 3;

/// A law with its column.
struct Law {
    place: Place,
    factors: &'static [Factor],
    span: Span,
    scales: Vec<Scale>,
    column: Vec<f64>,
}

/// Values of a coordinate that are mapped to zero, and to one.
type Scale = [f64; 2];

/// The one-parameter law of highest likelihood.
pub struct Plain {
    /// Least `−2 ln p`, maximised over noise and the plant's parameters.
    pub objective: f64,
    law: Law,
    noise: NoiseModel,
    /// Largest value within the range visited, and its standard error.
    amplitude: [f64; 2],
    tried: usize,
}

/// A one-parameter law in the report.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainLawReport {
    pub formula: String,
    /// Number of parameters of the effects that it replaces.
    pub numbers: usize,
}

/// The best one-parameter law about `theta` outside the catalogue (`named`: columns of the
/// catalogue's one-parameter laws); `None` where there is none, or the work does not allow the
/// search. Laws are evaluated `along` a trajectory: where a loop feeds noise back into the
/// commands, that of the loop without it.
///
/// Cost: a column each (some thirty for each input, eight for each channel), whitened once with all
/// products.
pub fn plain(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    along: (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
    named: &[&Vec<f64>],
) -> Option<Plain> {
    let about = linearised.linears.first().map_or(0, |linear| places(plant, linear).iter().map(|(_, f)| f.len()).sum());
    if !session.work.allows(linearised.normal_work(session, about + named.len()), "laws of one number without a name") {
        return None;
    }
    let propagators = propagators(along.0, plant, theta)?;
    let mut laws = laws((along.0, &propagators), along.1, plant);
    let extra: Vec<&Vec<f64>> = laws.iter().map(|law| &law.column).chain(named.iter().copied()).collect();
    let hypothesis = NoiseHypothesis::new(session, linearised, theta, &extra, noise)?;
    let (gram, right) = (&hypothesis.reduced, &hypothesis.reduced_right);
    let same = |i: usize, j: usize| gram[(i, j)].abs() > SAME_LAW_COSINE * (gram[(i, i)] * gram[(j, j)]).sqrt();
    let has_name = |i: usize| (laws.len()..extra.len()).any(|j| same(i, j));
    let statistic = |i: usize| right[i] * right[i] / gram[(i, i)];
    let mut order: Vec<usize> = (0..laws.len()).filter(|i| hypothesis.seen(*i) && !has_name(*i)).collect();
    order.sort_by(|a, b| statistic(*b).total_cmp(&statistic(*a)).then(a.cmp(b)));
    let mut taken: Vec<usize> = Vec::with_capacity(LAWS_MAXIMISED);
    for i in order {
        if taken.len() < LAWS_MAXIMISED && !taken.iter().any(|j| same(i, *j)) {
            taken.push(i);
        }
    }
    let tried = laws.len();
    let fitted = |i: &usize| {
        let own = [&laws[*i].column];
        let search = Search { sweeps: 3, colour: true, scan: false };
        let (noise, objective) = maximise(session, linearised, theta, &own, noise, search)?;
        let (_, amplitude) = linearised.normal(session, theta, &noise, &own)?.minimum()?;
        let alone = NoiseHypothesis::new(session, linearised, theta, &own, &noise)?;
        Some((*i, noise, objective, [*amplitude.first()?, 1.0 / alone.reduced[(0, 0)].sqrt()]))
    };
    let fits = taken.iter().filter_map(fitted);
    let (i, noise, objective, amplitude) = fits.min_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(Plain { objective, law: laws.swap_remove(i), noise, amplitude, tried })
}

impl Plain {
    /// As an unknown law, ahead by so much of effects with so many `numbers`; `None` where parts of
    /// the recording cannot be predicted.
    pub fn as_unknown_law(
        self,
        session: &EstimationSession<'_>,
        (linearised, theta): (&LinearisedProblem, &[f64]),
        ahead: f64,
        numbers: usize,
    ) -> Option<UnknownLaw> {
        let Law { place, factors, span, scales, column } = self.law;
        let names = place.names(linearised.linears.first()?);
        let is_of_time = place.is_of_time();
        let columns = [column];
        let weights = Weights { columns: &columns, precision: 0.0, is_of_time };
        let held_out = predicted(session, (linearised, theta), &self.noise, &weights)?;
        let [value, sigma] = self.amplitude;
        let cell = |at: [f64; 2]| {
            let shape = shape(factors, &scales, &at);
            Cell { at, value: value * shape, sigma: sigma * shape.abs() }
        };
        let plain = Some(PlainLawReport { formula: formula(factors, &names), numbers });
        let cells = cells(&span).into_iter().map(cell).collect();
        Some(UnknownLaw { place, names, cells, evidence: ahead, tried: self.tried, held_out, plain })
    }
}

/// Every one-parameter law of a plant that varies, with its column.
fn laws(
    (session, propagators): (&EstimationSession<'_>, &[Propagator<'_>]),
    linearised: &LinearisedProblem,
    plant: &Plant,
) -> Vec<Law> {
    let Some(linear) = linearised.linears.first() else { return Vec::new() };
    let is_alone = linearised.linears.len() == 1;
    let mut laws = Vec::new();
    for (place, forms) in places(plant, linear) {
        // time differs from run to run
        if place.is_of_time() && !is_alone {
            continue;
        }
        let Some(span) = visited(linearised, propagators, &place) else { continue };
        let scales = scales(&place, &span);
        let fill = |at: &[f64], out: &mut [f64]| {
            out.iter_mut().zip(forms).for_each(|(out, factors)| *out = shape(factors, &scales, at));
        };
        let columns =
            columns((session, propagators), linearised, &place, &Functions { count: forms.len(), fill: &fill });
        for (factors, column) in forms.iter().zip(columns) {
            if column.iter().all(|c| c.is_finite()) && column.iter().any(|c| *c != 0.0) {
                laws.push(Law { place: place.clone(), factors, span: span.clone(), scales: scales.clone(), column });
            }
        }
    }
    laws
}

/// Where one-parameter laws may act, and their forms.
fn places(plant: &Plant, linear: &Linear) -> Vec<(Place, &'static [&'static [Factor]])> {
    let of_input = |input: usize| {
        let near = near(linear, input);
        near.into_iter().flat_map(move |near| of_force(near, input)).collect::<Vec<_>>()
    };
    let readings = plant.sensors.iter().enumerate().flat_map(|(channel, sensor)| {
        let over =
            [(Coordinate::Reading, READING), (Coordinate::ReadingRate, LINEAR), (Coordinate::Time, READING_TIME)];
        let site = format!("sensor:{}", sensor.name);
        over.map(|(coordinate, forms)| {
            (Place { acts: Acts::Reading(channel), site: site.clone(), along: vec![coordinate] }, forms)
        })
    });
    (0..linear.input_names.len()).flat_map(of_input).chain(readings).collect()
}

fn of_force(near: Near, input: usize) -> Vec<(Place, &'static [&'static [Factor]])> {
    let Near { site, own, rate, command, others } = near;
    let mut all = vec![
        (vec![rate], RATE),
        (vec![Coordinate::Command(command)], COMMAND),
        (vec![Coordinate::CommandRate(command)], LINEAR),
        (vec![Coordinate::Time], FORCE_TIME),
    ];
    all.extend(own.map(|own| (vec![own], POSITION)));
    all.extend(own.map(|own| (vec![own, rate], BOTH)));
    all.extend(others.into_iter().map(|other| (vec![other], LINEAR)));
    let place = |along| Place { acts: Acts::Force(input), site: site.clone(), along };
    all.into_iter().map(|(along, forms)| (place(along), forms)).collect()
}

/// Time counts from the start of the range visited, everything else from zero; one is the end of
/// `span` that is further away.
fn scales(place: &Place, span: &Span) -> Vec<Scale> {
    let own =
        |[low, high]: &[f64; 2]| if place.is_of_time() { [*low, *high] } else { [0.0, low.abs().max(high.abs())] };
    span.iter().map(own).collect()
}

/// The law with unit coefficient, at a point.
fn shape(factors: &[Factor], scales: &[Scale], at: &[f64]) -> f64 {
    let each = factors.iter().zip(scales).zip(at).map(|((factor, [zero, one]), x)| {
        let x = (x - zero) / (one - zero);
        let size = x.abs().powi(factor.power);
        if factor.is_odd && x < 0.0 { -size } else { size }
    });
    each.product()
}

/// `joint:pivot^3`, `joint:pivot |joint:pivot|`, `joint:pivot times joint:pivot.rate^2`.
fn formula(factors: &[Factor], names: &[String]) -> String {
    let one = |(factor, name): (&Factor, &String)| match (factor.power, factor.is_odd) {
        (0, false) => "a constant".to_owned(),
        (0, true) => format!("the sign of {name}"),
        (1, true) => name.clone(),
        (1, false) => format!("|{name}|"),
        (power, is_odd) if is_odd == (power % 2 == 1) => format!("{name}^{power}"),
        (2, _) => format!("{name} |{name}|"),
        (power, _) => format!("|{name}|^{power}"),
    };
    factors.iter().zip(names).map(one).collect::<Vec<_>>().join(" times ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, problem, recording, with_effect};

    /// Place and formula of the best one-parameter law where `kind` is unmodelled, its amplitude,
    /// and whether the same is found where the catalogue has it.
    fn found(name: &str, duration_s: f64, kind: &str, site: &str, values: &[(&str, f64)]) -> (Plain, String, bool) {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&with_effect(&nominal, kind, site, values), 6, duration_s));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let fitted = identification::fit::fit(&session, &nominal, &session.prior(), &session.noise, 6).unwrap();
        let (linearised, theta) = (&fitted.linearised, &fitted.theta);
        let best = |named: &[&Vec<f64>]| {
            plain((&session, linearised), (&session, linearised), &nominal, theta, &session.noise, named).unwrap()
        };
        let first = best(&[]);
        let again = best(&[&first.law.column]);
        let names = first.law.place.names(&linearised.linears[0]);
        let reported = formula(first.law.factors, &names);
        let same = again.law.place == first.law.place && again.law.factors == first.law.factors;
        (first, reported, same)
    }

    #[test]
    fn a_law_of_one_number_is_found_with_its_power_its_place_and_its_size_and_passed_over_where_it_has_a_name() {
        let (law, reported, same) =
            found("oscillator", 2.0, "joint_cubic_stiffness", "joint:rail", &[("stiffness", 2e5)]);
        assert_eq!(reported, "joint:rail^3");
        let [value, sigma] = law.amplitude;
        // at the edge of the range visited
        let truth = -2e5 * law.law.scales[0][1].powi(3);
        assert!((value - truth).abs() < 4.0 * sigma && sigma < 0.1 * truth.abs() && !same, "{value} {sigma} {truth}");
        let (law, reported, same) = found("drive_rig", 2.0, "sensor_drift", "sensor:rate", &[("rate", 0.02)]);
        assert_eq!((reported.as_str(), law.law.place.site.as_str()), ("time", "sensor:rate"));
        let [begin, end] = law.law.scales[0];
        let [value, sigma] = law.amplitude;
        let truth = 0.02 * (end - begin);
        assert!((value - truth).abs() < 4.0 * sigma && sigma < 0.1 * truth && !same, "{value} {sigma} {truth}");
        let (_, reported, same) = found("drive_rig", 2.0, "actuator_lag", "actuator:motor", &[("time_constant", 3e-4)]);
        assert!(reported == "actuator:motor.rate" && !same, "{reported}");
    }

    #[test]
    fn a_formula_reads_as_it_is_computed() {
        let names = |list: &[&str]| list.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let at = |factors: &[Factor], x: f64| shape(factors, &[[0.0, 1.0]], &[x]);
        assert_eq!((formula(&[odd(2)], &names(&["v"])), at(&[odd(2)], -3.0)), ("v |v|".into(), -9.0));
        assert_eq!((formula(&[even(2)], &names(&["v"])), at(&[even(2)], -3.0)), ("v^2".into(), 9.0));
        assert_eq!((formula(&[odd(3)], &names(&["v"])), at(&[odd(3)], -2.0)), ("v^3".into(), -8.0));
        assert_eq!((formula(&[odd(0)], &names(&["v"])), at(&[odd(0)], -2.0)), ("the sign of v".into(), -1.0));
        assert_eq!((formula(&[even(1)], &names(&["v"])), at(&[even(1)], -2.0)), ("|v|".into(), 2.0));
        assert_eq!(formula(&[even(1), odd(0)], &names(&["q", "v"])), "|q| times the sign of v");
    }
}
