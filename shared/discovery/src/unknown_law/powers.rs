//! One-parameter laws: a coefficient times a power of one coordinate, or a product of powers of
//! two.
//!
//! ```text
//! f = c φ_i(x)   or   c φ_i(x) φ_j(y),   φ_i(x) = |x|^i, or with the sign of x
//! ```
//!
//! Effects with several shape parameters can describe a motion that one parameter describes as
//! well: a ripple of less than one lobe beside an end stop is a cubic spring, a torque that decays
//! is a drift. Every one-parameter law is evaluated where a force or an error may act; the caller
//! compares it with the effects of the catalogue.

use super::places::{Acts, Coordinate, Near, Place, Span, near, visited};
use super::ridge::{Cell, cells};
use super::{Functions, UnknownLaw, Weights, columns, predicted, propagators};
use crate::score::forcing::Sources;
use crate::score::kinetic::Kinetic;
use dynamics::description::Plant;
use identification::filter::{Linear, NoiseModel, Propagator};
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

/// A law with its column `−∂ν/∂c`, c its value at the end of the range visited that is farther off.
#[derive(Clone)]
pub(crate) struct Power {
    pub place: Place,
    pub column: Vec<f64>,
    /// Of a force, with c = 1, in the metric of the kinetic energy [√J].
    pub push: Option<f64>,
    factors: &'static [Factor],
    span: Span,
    scales: Vec<Scale>,
}

/// Values of a coordinate that are mapped to zero, and to one.
type Scale = [f64; 2];

/// Gives `each` the one-parameter laws of one place after the other, those that vary.
///
/// Cost: a column each, some thirty for each input, eight for each channel.
pub(crate) fn powers(
    session: &EstimationSession<'_>,
    (linearised, theta): (&LinearisedProblem, &[f64]),
    plant: &Plant,
    each: &mut dyn FnMut(Vec<Power>),
) -> Option<()> {
    let mut propagators = propagators(session, plant, theta)?;
    let kinetic = |(linear, own): (&Linear, &mut Propagator<'_>)| Kinetic::new(linear, own);
    let kinetics: Vec<Kinetic> = linearised.linears.iter().zip(&mut propagators).map(kinetic).collect();
    let is_alone = linearised.linears.len() == 1;
    for (place, forms) in places(plant, linearised.linears.first()?) {
        // time differs from run to run
        if place.is_of_time() && !is_alone {
            continue;
        }
        let Some(span) = visited(linearised, &propagators, &place) else { continue };
        let scales = scales(&place, &span);
        let fill = |at: &[f64], out: &mut [f64]| {
            out.iter_mut().zip(forms).for_each(|(out, factors)| *out = shape(factors, &scales, at));
        };
        let functions = Functions { count: forms.len(), fill: &fill };
        let mut pushes = vec![0.0; forms.len()];
        let mut seen = |(run, form): (usize, usize), own: &Sources| pushes[form] += kinetics[run].square(&own.state);
        let columns = columns((session, &propagators), linearised, (&place, &functions), &mut seen);
        let is_force = matches!(place.acts, Acts::Force(_));
        let varies = |column: &Vec<f64>| column.iter().all(|c| c.is_finite()) && column.iter().any(|c| *c != 0.0);
        let laws = forms.iter().zip(columns).zip(pushes).filter(|((_, column), _)| varies(column));
        let laws = laws.map(|((factors, column), push)| {
            let (place, span, scales) = (place.clone(), span.clone(), scales.clone());
            Power { place, column, push: is_force.then(|| push.sqrt()), factors, span, scales }
        });
        each(laws.collect());
    }
    Some(())
}

impl Power {
    /// As an unknown law of a value with its standard deviation, of prior deviation `prior`;
    /// `evidence` is twice its logarithm, one of `tried`. `None` where parts of the recording cannot
    /// be predicted.
    pub fn into_unknown_law(
        self,
        session: &EstimationSession<'_>,
        (linearised, theta, noise): (&LinearisedProblem, &[f64], &NoiseModel),
        ([value, sigma], prior): ([f64; 2], f64),
        (evidence, tried): (f64, usize),
    ) -> Option<UnknownLaw> {
        let names = self.place.names(linearised.linears.first()?);
        let columns = [self.column];
        let is_of_time = self.place.is_of_time();
        let weights = Weights { columns: &columns, precision: 1.0 / (prior * prior), is_of_time };
        let held_out = predicted(session, (linearised, theta), noise, &weights)?;
        let cell = |at: [f64; 2]| {
            let shape = shape(self.factors, &self.scales, &at);
            Cell { at, value: value * shape, sigma: sigma * shape.abs() }
        };
        let formula = Some(formula(self.factors, &names));
        let cells = cells(&self.span).into_iter().map(cell).collect();
        Some(UnknownLaw { place: self.place, names, cells, evidence, tried, held_out, formula })
    }
}

/// Where one-parameter laws may act, and their forms.
fn places(plant: &Plant, linear: &Linear) -> Vec<(Place, &'static [&'static [Factor]])> {
    let of_input = |input: usize| {
        let near = near(plant, linear, input);
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
        match factor.is_odd {
            // at rest no sign pushes
            true if x == 0.0 => 0.0,
            true => size.copysign(x),
            false => size,
        }
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

    #[test]
    fn a_formula_reads_as_it_is_computed() {
        let names = |list: &[&str]| list.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let at = |factors: &[Factor], x: f64| shape(factors, &[[0.0, 1.0]], &[x]);
        assert_eq!((formula(&[odd(2)], &names(&["v"])), at(&[odd(2)], -3.0)), ("v |v|".into(), -9.0));
        assert_eq!((formula(&[even(2)], &names(&["v"])), at(&[even(2)], -3.0)), ("v^2".into(), 9.0));
        assert_eq!((formula(&[odd(3)], &names(&["v"])), at(&[odd(3)], -2.0)), ("v^3".into(), -8.0));
        assert_eq!((formula(&[odd(0)], &names(&["v"])), at(&[odd(0)], -2.0)), ("the sign of v".into(), -1.0));
        assert_eq!((at(&[odd(0)], 0.0), at(&[even(0)], 0.0), at(&[odd(0)], 2.0)), (0.0, 1.0, 1.0));
        assert_eq!((formula(&[even(1)], &names(&["v"])), at(&[even(1)], -2.0)), ("|v|".into(), 2.0));
        assert_eq!(formula(&[even(1), odd(0)], &names(&["q", "v"])), "|q| times the sign of v");
    }
}
