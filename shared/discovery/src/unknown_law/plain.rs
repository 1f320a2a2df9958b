//! Plain laws: one number times a power of one coordinate, or a product of powers of two.
//!
//! ```text
//! f = c φ_i(x)   or   c φ_i(x) φ_j(y),   φ_i(x) = |x|^i, or with the sign of x
//! ```
//!
//! And of a reading a step at an instant, for ever or to another instant: one number more for each of these. An instant is one where a step
//! from there on has the largest score of its neighbourhood: the sum of `∂ ln p / ∂y` over all later readings, the plant's numbers and an offset taken out ([`crate::filter::Gradient`]).
//!
//! A name with several numbers inside can describe a motion that one number describes as well: a ripple of less than one lobe is a cubic spring, a
//! torque that decays is a drift. Every plain law is looked at where a force or an error may act; those that have a name in the catalogue
//! (one of its laws of no more numbers does the same) are passed over. What then fits is compared with the names by whoever asks.

use super::places::{Acts, Coordinate, Near, Place, Span, near, visited};
use super::ridge::{Cell, cells};
use super::{Functions, UnknownLaw, Weights, columns, machines, predicted};
use crate::compete::subsets::Rung;
use crate::filter::{Linear, Machine, NoiseModel};
use crate::fit::noise::{Search, maximise};
use crate::fit::{Board, Engine};
use crate::problem::Timeline;
use plant::description::Plant;

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

/// Cosine from which two laws are the same.
const SAME: f64 = 0.98;
/// Instants of a channel, each the best within this share of its samples.
const INSTANTS: usize = 4;
const ALONE: usize = 64;
/// Laws whose likelihood is taken.
const TAKEN: usize = 3;

/// What a law says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Product(&'static [Factor]),
    /// One from a time to a time [s].
    Step([f64; 2]),
}

/// A law that was looked at.
struct Law {
    place: Place,
    form: Form,
    span: Span,
    scales: Vec<Scale>,
    column: Vec<f64>,
}

/// Where a coordinate is zero, and where one.
type Scale = [f64; 2];

/// A column that the catalogue has a name for, and its numbers.
pub type Named<'c> = (usize, &'c Vec<f64>);

/// The plain law that fits best.
pub struct Plain {
    /// Least `−2 ln p`, noise and the plant's numbers maximised.
    pub objective: f64,
    law: Law,
    noise: NoiseModel,
    /// Largest value within what was visited, and its standard error.
    amplitude: [f64; 2],
    tried: usize,
}

/// What a plain law says, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    pub formula: String,
    /// Its numbers, and those of the names that it stands for.
    pub own: usize,
    pub numbers: usize,
}

/// The best plain law about `theta` that `named` has no name of no more numbers for, among them `steps` of readings; `None` where there is none, or no room for the work.
/// Laws are laid out `along` a trajectory: where a loop feeds noise back into the commands that of the loop without it.
///
/// Cost: a column each (some thirty an input, eighteen a channel), whitened once with all products.
pub fn plain(
    (engine, board): (&Engine<'_>, &Board),
    along: (&Engine<'_>, &Board),
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
    (named, steps): (&[Named<'_>], bool),
) -> Option<Plain> {
    let about: usize =
        board.linears.first().map_or(0, |linear| places(plant, linear).iter().map(|(_, f)| f.len()).sum());
    let about: usize = about + plant.sensors.len() * INSTANTS * (INSTANTS + 1) / 2;
    if !engine.work.allows(board.normal_work(engine, about + named.len()), "plain laws without a name") {
        return None;
    }
    let machines = machines(along.0, plant, theta)?;
    // time is another one in every run
    let slopes =
        if steps && board.linears.len() == 1 { slopes_of_readings(engine, board, theta, noise)? } else { Vec::new() };
    let mut laws = laws((along.0, &machines), along.1, plant, &slopes);
    let extra: Vec<&Vec<f64>> = laws.iter().map(|law| &law.column).chain(named.iter().map(|(_, own)| *own)).collect();
    let rung = Rung::new(engine, board, theta, &extra, noise)?;
    let (gram, right) = (&rung.reduced, &rung.reduced_right);
    let same = |i: usize, j: usize| gram[(i, j)].abs() > SAME * (gram[(i, i)] * gram[(j, j)]).sqrt();
    let may_name = |i: usize, j: usize| named[j].0 <= laws[i].form.numbers() && same(i, laws.len() + j);
    let has_name = |i: usize| (0..named.len()).any(|j| may_name(i, j));
    let price = |i: usize| libm::log(engine.samples.max(2) as f64) * laws[i].form.numbers() as f64;
    let statistic = |i: usize| right[i] * right[i] / gram[(i, i)] - price(i);
    let mut order: Vec<usize> = (0..laws.len()).filter(|i| rung.seen(*i) && !has_name(*i)).collect();
    order.sort_by(|a, b| statistic(*b).total_cmp(&statistic(*a)).then(a.cmp(b)));
    let mut taken: Vec<usize> = Vec::with_capacity(TAKEN);
    for i in order {
        if taken.len() < TAKEN && !taken.iter().any(|j| same(i, *j)) {
            taken.push(i);
        }
    }
    let tried = laws.len();
    let fitted = |i: &usize| {
        let own = [&laws[*i].column];
        let search = Search { sweeps: 3, colour: true, scan: false };
        let (noise, objective) = maximise(engine, board, theta, &own, noise, search)?;
        let (_, amplitude) = board.normal(engine, theta, &noise, &own)?.minimum()?;
        let alone = Rung::new(engine, board, theta, &own, &noise)?;
        Some((*i, noise, objective, [*amplitude.first()?, 1.0 / alone.reduced[(0, 0)].sqrt()]))
    };
    let fits = taken.iter().filter_map(fitted);
    let (i, noise, objective, amplitude) = fits.min_by(|a, b| (a.2 + price(a.0)).total_cmp(&(b.2 + price(b.0))))?;
    Some(Plain { objective, law: laws.swap_remove(i), noise, amplitude, tried })
}

/// `−∂ ln p / ∂y` of every reading, the plant's numbers maximised.
fn slopes_of_readings(engine: &Engine<'_>, board: &Board, theta: &[f64], noise: &NoiseModel) -> Option<Vec<f64>> {
    let (_, x) = board.normal(engine, theta, noise, &[])?.least()?;
    Some(board.gradient(engine, (&board.left(&x, &[]), theta), noise)?.0.readings)
}

impl Plain {
    /// Numbers of the law.
    pub fn numbers(&self) -> usize {
        self.law.form.numbers()
    }

    /// As a law without a name, ahead by so much of names with so many `numbers`; `None` where parts of the recording cannot be predicted.
    pub fn told(
        self,
        engine: &Engine<'_>,
        (board, theta): (&Board, &[f64]),
        ahead: f64,
        numbers: usize,
    ) -> Option<UnknownLaw> {
        let Law { place, form, span, scales, column } = self.law;
        let names = place.names(board.linears.first()?);
        let is_of_time = place.is_of_time();
        let columns = [column];
        let weights = Weights { columns: &columns, precision: 0.0, is_of_time };
        let held_out = predicted(engine, (board, theta), &self.noise, &weights)?;
        let [value, sigma] = self.amplitude;
        let cell = |at: [f64; 2]| {
            let shape = form.value(&scales, &at);
            Cell { at, value: value * shape, sigma: sigma * shape.abs() }
        };
        let plain = Some(Told { formula: form.told(&names), own: form.numbers(), numbers });
        let cells = cells(&span).into_iter().map(cell).collect();
        Some(UnknownLaw { place, names, cells, evidence: ahead, tried: self.tried, held_out, plain })
    }
}

/// Every plain law of a plant that varies, with its column.
fn laws((engine, machines): (&Engine<'_>, &[Machine<'_>]), board: &Board, plant: &Plant, slopes: &[f64]) -> Vec<Law> {
    let Some(linear) = board.linears.first() else { return Vec::new() };
    let is_alone = board.linears.len() == 1;
    let mut laws = Vec::new();
    let steps = plant.sensors.iter().enumerate().map(|(channel, sensor)| {
        let (acts, site) = (Acts::Reading(channel), format!("sensor:{}", sensor.name));
        let forms =
            if slopes.is_empty() { Vec::new() } else { steps(&instants(&engine.timelines[0], channel, slopes)) };
        (Place { acts, site, along: vec![Coordinate::Time] }, forms)
    });
    let products = places(plant, linear).into_iter().map(|(place, forms)| {
        let forms = forms.iter().map(|factors| Form::Product(factors)).collect();
        (place, forms)
    });
    for (place, forms) in products.chain(steps.filter(|(_, forms)| !forms.is_empty())).collect::<Vec<_>>() {
        // time is another one in every run
        if place.is_of_time() && !is_alone {
            continue;
        }
        let Some(span) = visited(board, machines, &place) else { continue };
        let scales = scales(&place, &span);
        let fill = |at: &[f64], out: &mut [f64]| {
            out.iter_mut().zip(&forms).for_each(|(out, form)| *out = form.value(&scales, at));
        };
        let columns = columns((engine, machines), board, &place, &Functions { count: forms.len(), fill: &fill });
        for (form, column) in forms.iter().zip(columns) {
            if column.iter().all(|c| c.is_finite()) && column.iter().any(|c| *c != 0.0) {
                let form = *form;
                laws.push(Law { place: place.clone(), form, span: span.clone(), scales: scales.clone(), column });
            }
        }
    }
    laws
}

/// Instants of a channel at which a step has the largest score, in order of time [s].
fn instants(timeline: &Timeline, channel: usize, slopes: &[f64]) -> Vec<f64> {
    let own: Vec<usize> = (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).collect();
    let offset = own.iter().map(|s| slopes[*s]).sum::<f64>() / own.len().max(1) as f64;
    let mut score = vec![0.0; own.len()];
    let mut sum = 0.0;
    for (k, sample) in own.iter().enumerate().rev() {
        sum += slopes[*sample] - offset;
        score[k] = f64::abs(sum);
    }
    let reach = (own.len() / ALONE).max(1);
    let about = |k: usize| score[k.saturating_sub(reach)..(k + reach + 1).min(score.len())].iter();
    let mut peaks: Vec<usize> = (1..score.len()).filter(|k| about(*k).all(|other| *other <= score[*k])).collect();
    peaks.sort_by(|a, b| score[*b].total_cmp(&score[*a]).then(a.cmp(b)));
    peaks.truncate(INSTANTS);
    peaks.sort_unstable();
    let at = |k: usize| timeline.stamp_s[own[k]] - timeline.shift_s[channel];
    peaks.into_iter().map(|k| 0.5 * (at(k - 1) + at(k))).collect()
}

/// Steps at every instant, for ever and to every later one.
fn steps(instants: &[f64]) -> Vec<Form> {
    let from = |i: usize| {
        let ends = instants[i + 1..].iter().copied().chain([f64::INFINITY]);
        ends.map(move |end| Form::Step([instants[i], end]))
    };
    (0..instants.len()).flat_map(from).collect()
}

impl Form {
    /// The number in front, and the times.
    fn numbers(&self) -> usize {
        match self {
            Self::Product(_) => 1,
            Self::Step([_, end]) if end.is_finite() => 3,
            Self::Step(_) => 2,
        }
    }

    /// With its number one, at a point.
    fn value(&self, scales: &[Scale], at: &[f64]) -> f64 {
        match self {
            Self::Product(factors) => shape(factors, scales, at),
            Self::Step([begin, end]) => f64::from(u8::from((*begin..*end).contains(&at[0]))),
        }
    }

    fn told(&self, names: &[String]) -> String {
        match self {
            Self::Product(factors) => formula(factors, names),
            Self::Step([begin, end]) if end.is_finite() => format!("a constant from {begin:.4} to {end:.4} s"),
            Self::Step([begin, _]) => format!("a constant from {begin:.4} s on"),
        }
    }
}

/// Where plain laws may act, and their forms.
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

/// Time counts from the beginning of what was visited, everything else from nothing; one is the end of `span` that is further away.
fn scales(place: &Place, span: &Span) -> Vec<Scale> {
    let own =
        |[low, high]: &[f64; 2]| if place.is_of_time() { [*low, *high] } else { [0.0, low.abs().max(high.abs())] };
    span.iter().map(own).collect()
}

/// The law with its number one, at a point.
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

    /// Place and formula of the best plain law where `kind` was left out, its amplitude, and whether the same is found where that has a name.
    fn found(name: &str, duration_s: f64, kind: &str, site: &str, values: &[(&str, f64)]) -> (Plain, String, bool) {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&with_effect(&nominal, kind, site, values), 6, duration_s));
        let engine = Engine::new(&problem, 1).unwrap();
        let fitted = crate::fit::fit(&engine, &nominal, &engine.prior(), &engine.noise, 6).unwrap();
        let (board, theta) = (&fitted.board, &fitted.theta);
        let along = (&engine, board);
        let best = |named: &[Named<'_>]| plain(along, along, &nominal, theta, &engine.noise, (named, true)).unwrap();
        let first = best(&[]);
        let again = best(&[(first.numbers(), &first.law.column)]);
        let names = first.law.place.names(&board.linears[0]);
        let told = first.law.form.told(&names);
        let same = again.law.place == first.law.place && again.law.form == first.law.form;
        (first, told, same)
    }

    #[test]
    fn a_law_of_one_number_is_found_with_its_power_its_place_and_its_size_and_passed_over_where_it_has_a_name() {
        let (law, told, same) = found("oscillator", 2.0, "joint_cubic_stiffness", "joint:rail", &[("stiffness", 2e5)]);
        assert_eq!(told, "joint:rail^3");
        // at the edge of what was visited; the line is taken where the law has led the plant's numbers astray
        let near = |law: &Plain, truth: f64| {
            let [value, sigma] = law.amplitude;
            assert!(
                (value - truth).abs() < 0.05 * truth.abs() && sigma < 0.05 * truth.abs(),
                "{value} {sigma} {truth}"
            );
        };
        near(&law, -2e5 * law.law.scales[0][1].powi(3));
        assert!(!same);
        let (law, told, same) = found("drive_rig", 2.0, "sensor_drift", "sensor:rate", &[("rate", 0.02)]);
        assert_eq!((told.as_str(), law.law.place.site.as_str()), ("time", "sensor:rate"));
        let [begin, end] = law.law.scales[0];
        near(&law, 0.02 * (end - begin));
        assert!(!same);
    }

    #[test]
    fn a_step_of_a_reading_is_found_with_both_its_times_and_more_numbers_have_a_price() {
        let step = |duration: f64| [("step", 2e-3), ("begin", 0.7003), ("duration", duration)];
        let (law, told, same) = found("drive_rig", 2.0, "sensor_step", "sensor:angle", &step(0.6));
        let Form::Step([begin, end]) = law.law.form else { panic!("{told}") };
        // samples are a millisecond apart
        assert!((begin - 0.7003).abs() < 1e-3 && (end - 1.3003).abs() < 1e-3 && law.numbers() == 3 && !same, "{told}");
        assert!((law.amplitude[0] - 2e-3).abs() < 2e-4 && law.law.place.site == "sensor:angle", "{told}");
        let of_rate = [("step", 0.03), ("begin", 0.7003), ("duration", 0.6)];
        let (law, told, _) = found("drive_rig", 2.0, "sensor_step", "sensor:rate", &of_rate);
        let Form::Step([begin, end]) = law.law.form else { panic!("{told}") };
        assert!((begin - 0.7003).abs() < 5e-3 && (end - 1.3003).abs() < 5e-3, "{told}");
        let (law, told, _) = found("drive_rig", 2.0, "sensor_step", "sensor:angle", &step(5.0));
        assert!(law.numbers() == 2 && told.ends_with("s on"), "{told}");
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
