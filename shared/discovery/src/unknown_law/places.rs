//! Where an unknown law may act, the coordinates it may depend on, and its basis functions.

use dynamics::description::{ActuatorKind, Plant};
use identification::filter::{DISTURBANCE, Linear, Propagator};
use identification::fit::LinearisedProblem;

/// Functions along each of two coordinates, and along one that is alone: as many in all.
const SIDE: usize = 5;
pub(super) const FUNCTIONS: usize = SIDE * SIDE;
/// Width of a Gaussian in distances of the grid.
const WIDTH: f64 = 0.8;
/// Pairs of coordinates of one input.
const PAIRS_MAX: usize = 5;

/// Where a law may act and on what it may depend: one coordinate or two.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub acts: Acts,
    pub site: String,
    pub along: Vec<Coordinate>,
}

/// Point of action of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// The force at a noise input.
    Force(usize),
    /// The reading of a channel.
    Reading(usize),
}

/// A coordinate that a law may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Index of a state.
    State(usize),
    /// Index in `u` of a command, and its rate of change.
    Command(usize),
    CommandRate(usize),
    /// Predicted reading of the channel (past its lag), and its rate of change.
    Reading,
    ReadingRate,
    Time,
}

/// Lower and upper end of each coordinate.
pub(super) type Span = Vec<[f64; 2]>;

impl Place {
    /// It depends on time alone: predicted between neighbours in time it is no law yet, and it
    /// holds for one run only.
    pub fn is_of_time(&self) -> bool {
        self.along == [Coordinate::Time]
    }

    /// Names of the coordinates.
    pub fn names(&self, linear: &Linear) -> Vec<String> {
        let name = |coordinate: &Coordinate| match (coordinate, self.acts) {
            (Coordinate::State(state), _) => linear.state_names[*state].clone(),
            (Coordinate::Command(_), Acts::Force(input)) => format!("actuator:{}", linear.input_names[input]),
            (Coordinate::CommandRate(_), Acts::Force(input)) => format!("actuator:{}.rate", linear.input_names[input]),
            (Coordinate::Command(_) | Coordinate::CommandRate(_) | Coordinate::Reading, _) => self.site.clone(),
            (Coordinate::ReadingRate, _) => format!("{}.rate", self.site),
            (Coordinate::Time, _) => "time".to_owned(),
        };
        self.along.iter().map(name).collect()
    }

    /// Coordinates of a force in state `x` at the start of the stretch behind event `k`, or at its
    /// end.
    pub fn at_state(&self, propagator: &Propagator<'_>, (k, end): (usize, bool), x: &[f64], out: &mut [f64]) {
        for (out, coordinate) in out.iter_mut().zip(&self.along) {
            *out = match coordinate {
                Coordinate::State(state) => x[*state],
                Coordinate::Command(input) => propagator.acting(k, end, *input),
                Coordinate::CommandRate(input) => command_rate(propagator, k, *input),
                _ => propagator.timeline.events[if end { k + 1 } else { k }].t_s,
            };
        }
    }

    /// Coordinates of a reading at one of its samples.
    pub fn at_sample(&self, linear: &Linear, propagator: &Propagator<'_>, sample: usize, out: &mut [f64]) {
        for (out, coordinate) in out.iter_mut().zip(&self.along) {
            *out = match coordinate {
                Coordinate::Reading => propagator.timeline.value[sample] - (linear.nu[sample] - linear.pull[sample]),
                Coordinate::ReadingRate => linear.slope[sample],
                _ => propagator.timeline.stamp_s[sample],
            };
        }
    }
}

/// Rate of change of a command over the stretch behind event `k`: of one that is held its step,
/// spread over that stretch.
fn command_rate(propagator: &Propagator<'_>, k: usize, input: usize) -> f64 {
    let timeline = propagator.timeline;
    let Some(next) = timeline.events.get(k + 1) else { return 0.0 };
    let lasts_s = next.t_s - timeline.events[k].t_s;
    let before = if k == 0 { propagator.acting(0, false, input) } else { propagator.acting(k - 1, true, input) };
    if lasts_s > 0.0 { (propagator.acting(k, true, input) - before) / lasts_s } else { 0.0 }
}

/// Every place of a plant: forces on a coordinate with their pairs, on its position alone and on
/// time; errors of readings over the reading, over it and its rate, and over time.
pub(super) fn places(plant: &Plant, linear: &Linear) -> Vec<Place> {
    let forces = (0..linear.input_names.len()).flat_map(|input| of_input(plant, linear, input));
    let readings = plant.sensors.iter().enumerate().flat_map(|(channel, sensor)| {
        let (reading, rate, time) = (Coordinate::Reading, Coordinate::ReadingRate, Coordinate::Time);
        let along = [vec![reading], vec![reading, rate], vec![time]];
        along.map(|along| Place { acts: Acts::Reading(channel), site: format!("sensor:{}", sensor.name), along })
    });
    forces.chain(readings).collect()
}

/// Coordinates that a force at an input may depend on.
pub(super) struct Near {
    pub site: String,
    /// Position and rate of the coordinate that it moves most, the command, other rates.
    pub own: Option<Coordinate>,
    pub rate: Coordinate,
    pub command: usize,
    pub others: Vec<Coordinate>,
}

/// `None` of an input that moves no coordinate.
pub(super) fn near(plant: &Plant, linear: &Linear, input: usize) -> Option<Near> {
    let states = &linear.state_names;
    let find = |name: &str| states.iter().position(|state| state == name);
    let name = &linear.input_names[input];
    let target = name.strip_prefix(DISTURBANCE).or_else(|| driven_joint(plant, name)).unwrap_or(name);
    let (n, m) = (linear.layout.tangent, linear.layout.noise_inputs.len());
    let gamma = |row: usize| linear.transition.get(row * (n + m) + n + input).copied().unwrap_or(0.0);
    let named = find(&format!("joint:{target}.rate"));
    // what acts in no joint acts on the rate that it moves most
    let pushed = named.or_else(|| {
        let moved = linear.names.iter().enumerate().filter(|(_, name)| name.ends_with(".rate"));
        let most = moved.max_by(|a, b| gamma(a.0).abs().total_cmp(&gamma(b.0).abs()))?;
        find(most.1)
    });
    let rate = pushed?;
    let site = states[rate].trim_end_matches(".rate").to_owned();
    let others = (0..states.len()).filter(|i| *i != rate && states[*i].ends_with(".rate"));
    Some(Near {
        own: find(&site).map(Coordinate::State),
        rate: Coordinate::State(rate),
        command: linear.layout.noise_inputs[input],
        others: others.map(Coordinate::State).collect(),
        site,
    })
}

/// The joint that an actuator acts in.
fn driven_joint<'p>(plant: &'p Plant, actuator: &str) -> Option<&'p str> {
    match &plant.actuators.iter().find(|own| own.name == actuator)?.kind {
        ActuatorKind::JointTorque { joint } | ActuatorKind::Motor { joint, .. } => Some(joint),
        _ => None,
    }
}

/// Where the force at a noise input acts, as a site is written.
pub fn site_of_input(plant: &Plant, linear: &Linear, input: usize) -> Option<String> {
    near(plant, linear, input).map(|near| near.site)
}

/// Its own position and rate, the input's command and its rate, its rate with every other rate; its
/// position alone; time.
fn of_input(plant: &Plant, linear: &Linear, input: usize) -> Vec<Place> {
    let Some(Near { site, own, rate, command, others }) = near(plant, linear, input) else { return Vec::new() };
    let pairs = own.into_iter().chain([Coordinate::Command(command)]).chain(others).take(PAIRS_MAX);
    let pairs = pairs.map(|other| vec![other, rate]);
    let along = pairs.chain(own.map(|own| vec![own])).chain([vec![Coordinate::Time]]);
    along.map(|along| Place { acts: Acts::Force(input), site: site.clone(), along }).collect()
}

/// Functions along each coordinate.
pub(super) fn sides(span: &Span) -> usize {
    if span.len() == 1 { FUNCTIONS } else { SIDE }
}

/// Every function at a point of the box.
pub(super) fn basis(span: &Span, at: &[f64], out: &mut [f64]) {
    let side = sides(span);
    let along = |k: usize, i: usize| {
        let step = (span[k][1] - span[k][0]) / (side - 1) as f64;
        let z = (at[k] - span[k][0] - i as f64 * step) / (WIDTH * step);
        libm::exp(-0.5 * z * z)
    };
    if span.len() == 1 {
        return out.iter_mut().enumerate().for_each(|(i, out)| *out = along(0, i));
    }
    let second: [f64; SIDE] = core::array::from_fn(|j| along(1, j));
    for (i, row) in out.chunks_exact_mut(SIDE).enumerate() {
        let first = along(0, i);
        row.iter_mut().zip(&second).for_each(|(out, second)| *out = first * second);
    }
}

/// The middle 98 % of every coordinate, all of time and of a rate of commands, which may change
/// seldom; `None` where one is constant.
pub(super) fn visited(linearised: &LinearisedProblem, propagators: &[Propagator<'_>], place: &Place) -> Option<Span> {
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); place.along.len()];
    let mut at = vec![0.0; place.along.len()];
    for (linear, propagator) in linearised.linears.iter().zip(propagators) {
        let mut take = |at: &[f64]| values.iter_mut().zip(at).for_each(|(values, at)| values.push(*at));
        match place.acts {
            Acts::Force(_) => linear.updated.chunks(linear.state_names.len()).enumerate().for_each(|(k, x)| {
                place.at_state(propagator, (k, false), x, &mut at);
                take(&at);
            }),
            Acts::Reading(channel) => samples_of(propagator, channel).for_each(|sample| {
                place.at_sample(linear, propagator, sample, &mut at);
                take(&at);
            }),
        }
    }
    let span = |(mut values, coordinate): (Vec<f64>, &Coordinate)| {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((values.len().saturating_sub(1) as f64 * share) as usize).copied();
        let out = if matches!(coordinate, Coordinate::CommandRate(_) | Coordinate::Time) { 0.0 } else { 0.01 };
        let ends = [at(out)?, at(1.0 - out)?];
        (ends[1] - ends[0] > 1e-9 * (1.0 + ends[0].abs())).then_some(ends)
    };
    values.into_iter().zip(&place.along).map(span).collect()
}

pub(super) fn samples_of(propagator: &Propagator<'_>, channel: usize) -> impl Iterator<Item = usize> {
    let timeline = propagator.timeline;
    (0..timeline.value.len()).filter(move |sample| timeline.channel[*sample] == channel)
}
