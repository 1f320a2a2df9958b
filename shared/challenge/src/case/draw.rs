//! A case from its seed and index.

use super::search::{rival, scale, shaped};
use super::{BiasedParameter, Class, Exam, Sealed, Truth, digest, recording_digest};
use crate::bench::{BENCHES, Bench, Entry, kept};
use crate::disturb::{Disturbance, NoiseKind, WRONG, disturbance, input_sigma, sensor_sigma};
use crate::equations::Numbers;
use crate::excite::{Flight, flight};
use crate::hidden::{Hidden, Seat};
use crate::random::Draw;
use crate::realised::{Lab, Realised, rig};
use crate::simulate::{Experiment, simulate};
use catalogue::EFFECTS;
use channels::{Channel, Recording, Role};
use dynamics::description::{Plant, Scope};
use dynamics::effect::sites;

/// Entries drawn before a case is accepted without the further requirement of its class.
const TRIALS: usize = 12;
/// Least bias of a nominal parameter, in its sigmas, and least absorbed share of energy in a masked
/// case.
const BIAS_SIGMA_MIN: f64 = 2.0;
const ABSORBED_SHARE_MIN: f64 = 0.3;

/// Remainder of a control, as a share of the signal, and by how many samples its factor is late.
const REMAINDER: [f64; 2] = [0.01, 0.03];
const LAGS: [f64; 2] = [10.0, 40.0];

/// Ten cases hold three nulls, four single effects, a pair, one with its effect outside the
/// catalogue, one masked.
pub(super) fn class_of(case: u64) -> Class {
    match case % 10 {
        0 | 3 | 6 => Class::Null,
        4 => Class::Pair,
        7 => Class::LeftOut,
        9 => Class::Masked,
        _ => Class::Single,
    }
}

/// A third of the nulls has right noise, the others each wrong one in turn.
fn noise_of(case: u64, class: Class, plant: &Plant) -> NoiseKind {
    if class != Class::Null {
        return NoiseKind::Right;
    }
    let null = case / 10 * 3 + (case % 10) / 3;
    if null.is_multiple_of(3) {
        return NoiseKind::Right;
    }
    let wrong = null / 3 * 2 + null % 3 - 1;
    let kind = WRONG[(wrong % 6) as usize];
    // noise that is not there cannot double; a sensor of higher variance takes its turn
    let quiet = plant.actuators.iter().all(|actuator| actuator.noise.value == 0.0);
    if kind == NoiseKind::ActuatorDouble && quiet { NoiseKind::SensorNoiseHigher } else { kind }
}

/// Draws the parameters of `plant` from their priors: those of all recordings, and those of the
/// recording `own`.
fn true_numbers(plant: &Plant, (seed, case): (u64, u64), own: &str) -> Numbers {
    let mut numbers = Numbers::of(plant);
    for parameter in plant.parameters() {
        let Some(sigma) = parameter.sigma.filter(|_| !parameter.name.starts_with("initial")) else { continue };
        let whose = if parameter.scope == Scope::Shared { "" } else { own };
        let mut draw = Draw::new(seed, case, &format!("number/{}/{whose}", parameter.name));
        let value = parameter.value + sigma * draw.normal().clamp(-2.0, 2.0);
        let value = if parameter.value > 0.0 { value.max(0.3 * parameter.value) } else { value };
        numbers.0.insert(parameter.name, value);
    }
    numbers
}

fn priors(plant: &Plant) -> Vec<(String, f64)> {
    let stated = plant.parameters().into_iter().filter(|p| !p.name.starts_with("initial"));
    stated.filter_map(|p| p.sigma.map(|sigma| (p.name, sigma))).collect()
}

/// One experiment: trajectory, parameters and noise.
struct Setup<'a> {
    bench: &'a Bench,
    names: Vec<String>,
    numbers: Numbers,
    flight: Flight,
    noise: Disturbance,
    ids: (u64, u64),
}

impl<'a> Setup<'a> {
    fn new(bench: &'a Bench, plant: &Plant, kind: NoiseKind, ids: (u64, u64), own: &str) -> Self {
        let mut draw = Draw::new(ids.0, ids.1, &format!("{own}/excitation"));
        Self {
            bench,
            names: plant.sensors.iter().map(|sensor| sensor.name.clone()).collect(),
            numbers: true_numbers(plant, ids, own),
            flight: flight(bench, plant, &mut draw),
            noise: disturbance(bench, plant, kind, ids, own),
            ids,
        }
    }

    fn experiment(&self, noisy: bool) -> Experiment {
        let of = |list: &Vec<Vec<f64>>| if noisy { list.clone() } else { Vec::new() };
        Experiment {
            period_s: self.bench.period_s,
            samples: self.bench.samples,
            q: self.flight.q.clone(),
            v: self.flight.v.clone(),
            command: self.flight.command.clone(),
            input_noise: of(&self.noise.inputs),
            sensor_noise: of(&self.noise.sensors),
            resolution: if noisy { self.noise.resolution.clone() } else { Vec::new() },
        }
    }

    fn lab(&self) -> Lab<'a> {
        let plant = &self.flight.plant;
        let steps = plant.sensors.iter().map(|sensor| sensor.resolution.value);
        let sigma = sensor_sigma(plant, self.bench.period_s);
        let sigma: Vec<f64> = sigma.iter().zip(steps).map(|(s, step)| (s * s + step * step / 12.0).sqrt()).collect();
        let noise = (&sigma[..], &input_sigma(plant)[..]);
        Lab::new(self.bench, &self.numbers, self.experiment(false), self.names.clone(), priors(plant), noise)
    }

    fn record(&self, list: &[(Hidden, Seat)], name: &str) -> Recording {
        let plant = &self.flight.plant;
        let rig = rig(self.bench, &self.numbers, list, plant.actuators.len(), self.names.len());
        let mut trace = simulate(&rig, &self.numbers, &self.names, &self.experiment(true));
        if self.noise.kind == NoiseKind::Remainder {
            with_remainder(&mut trace.measured, &mut Draw::new(self.ids.0, self.ids.1, "remainder"));
        }
        let time = |off: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..self.bench.samples).map(|k| k as f64 * self.bench.period_s + off(k)).collect()
        };
        let channel = |name: &str, unit: &str, time_s: Vec<f64>, value: &[f64], role: Role| Channel {
            name: name.to_owned(),
            unit: unit.to_owned(),
            time_s,
            value: value.to_vec(),
            role,
        };
        let inputs = plant.actuators.iter().zip(&trace.command).map(|(actuator, u)| {
            channel(&actuator.name, plant.actuator_unit(actuator), time(&|_| 0.0), u, Role::Input)
        });
        let outputs = plant.sensors.iter().zip(&trace.measured).map(|(sensor, y)| {
            channel(&sensor.name, plant.sensor_unit(sensor), time(&|k| self.noise.stamps[k]), y, Role::Output)
        });
        Recording { name: name.to_owned(), channels: inputs.chain(outputs).collect() }
    }
}

/// Adds to every channel its product with another one of a while ago, both in units of their rms:
/// deterministic, the same law in every recording of a case, and none of the catalogue.
fn with_remainder(measured: &mut [Vec<f64>], draw: &mut Draw) {
    let rms = |y: &[f64]| {
        let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
        (mean, (y.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / y.len().max(1) as f64).sqrt())
    };
    let before = measured.to_vec();
    for (channel, values) in measured.iter_mut().enumerate() {
        let other = &before[draw.below(before.len())];
        let (share, lag) = (draw.log_uniform(REMAINDER[0], REMAINDER[1]), draw.uniform(LAGS[0], LAGS[1]) as usize);
        let ((mean, _), (their_mean, theirs)) = (rms(&before[channel]), rms(other));
        for k in 0..values.len() {
            let past = (other[k.saturating_sub(lag)] - their_mean) / theirs;
            values[k] += share * (before[channel][k] - mean) * past;
        }
    }
}

/// Hidden effects of a case and their detectability.
#[derive(Default)]
struct Chosen {
    list: Vec<(Hidden, Seat)>,
    realised: Vec<Realised>,
    without: Vec<String>,
}

fn choose(lab: &Lab<'_>, class: Class, planned: f64, draw: &mut Draw) -> Chosen {
    let mut fallback = Chosen::default();
    let mut first: Option<(&Entry, Hidden, Realised)> = None;
    for _ in 0..TRIALS {
        let entry = &lab.bench.menu[draw.below(lab.bench.menu.len())];
        if first.as_ref().is_some_and(|(e, ..)| e.kind == entry.kind || e.site == entry.site && e.seat == entry.seat) {
            continue;
        }
        let Some((hidden, found)) = scale(lab, entry, &shaped(entry, draw), planned) else { continue };
        let one = Chosen {
            list: vec![(hidden.clone(), entry.seat)],
            realised: vec![found.clone()],
            without: std::iter::once(entry.kind).chain(entry.kin.iter().copied()).map(str::to_owned).collect(),
        };
        let good = match class {
            Class::Null => false,
            Class::Single => true,
            Class::Masked => {
                found.kappa >= ABSORBED_SHARE_MIN && most_biased(&found).is_some_and(|w| w.1.abs() >= BIAS_SIGMA_MIN)
            }
            Class::LeftOut => rival_outside(lab, entry, &found, draw) < 0.8,
            Class::Pair => match first.take() {
                Some((e, h, f)) => {
                    return Chosen {
                        list: vec![(h, e.seat), (hidden, entry.seat)],
                        realised: vec![f, found],
                        without: Vec::new(),
                    };
                }
                None => {
                    first = Some((entry, hidden, found));
                    false
                }
            },
        };
        if good {
            return one;
        }
        fallback = one;
    }
    fallback
}

/// Largest cosine with entries that stay in the catalogue when this one is removed.
fn rival_outside(lab: &Lab<'_>, entry: &Entry, found: &Realised, draw: &mut Draw) -> f64 {
    let own = Hidden { kind: entry.kind.into(), site: entry.site.into(), values: vec![] };
    let stays = |other: &Entry| other.kind != entry.kind && !entry.kin.contains(&other.kind);
    rival(lab, &own, found, draw, &stays).0
}

/// The nominal parameter with the largest bias in its sigmas.
fn most_biased(found: &Realised) -> Option<&(String, f64)> {
    found.shifts.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

fn planned_d(class: Class, draw: &mut Draw) -> f64 {
    match class {
        Class::Null => 0.0,
        Class::Single => draw.log_uniform(4.0, 50.0),
        Class::Pair => draw.uniform(13.0, 25.0),
        Class::LeftOut => draw.log_uniform(18.0, 50.0),
        Class::Masked => draw.log_uniform(8.0, 25.0),
    }
}

/// Draws, simulates and seals case `case` of `seed`.
#[must_use]
pub fn case(seed: u64, case: u64) -> Sealed {
    drawn((seed, case), class_of(case), false)
}

/// The same of a complete plant whose readings hold a remainder that no law of the catalogue makes,
/// in the held-out recording, too.
#[must_use]
pub fn control(seed: u64, case: u64) -> Sealed {
    drawn((seed, case), Class::Null, true)
}

fn drawn(ids: (u64, u64), class: Class, is_control: bool) -> Sealed {
    let (seed, case) = ids;
    let mut draw = Draw::new(seed, case, "plan");
    let bench = &BENCHES[draw.below(BENCHES.len())];
    let plant = kept(bench);
    let noise = if is_control { NoiseKind::Remainder } else { noise_of(case, class, &plant) };
    let unseen = if is_control { NoiseKind::Remainder } else { NoiseKind::Right };
    let setup = Setup::new(bench, &plant, noise, ids, "recording");
    let other = Setup::new(bench, &plant, unseen, ids, "held_out");
    let planned = planned_d(class, &mut draw);
    let chosen = if class == Class::Null { None } else { Some((setup.lab(), planned)) }.map(|(lab, planned)| {
        let chosen = choose(&lab, class, planned, &mut draw);
        let near = match (&chosen.list[..], &chosen.realised[..]) {
            ([(hidden, _)], [found]) => rival(&lab, hidden, found, &mut draw, &|_| true),
            _ => (0.0, String::new()),
        };
        (chosen, near)
    });
    let (chosen, (rho, rival)) = chosen.unwrap_or_default();
    let held_out_d = if chosen.list.is_empty() { 0.0 } else { other.lab().realised(&chosen.list, true).d };
    let recording = setup.record(&chosen.list, "recording");
    let held_out = other.record(&chosen.list, "held_out");
    let left_out = class == Class::LeftOut;
    let without = if left_out { chosen.without.clone() } else { Vec::new() };
    let biased =
        chosen.realised.first().filter(|_| class == Class::Masked).and_then(most_biased).map(|(name, shift)| {
            BiasedParameter { name: name.clone(), truth: setup.numbers.get(name), shift_sigma: *shift }
        });
    let truth = Truth {
        case,
        class: if chosen.list.is_empty() { Class::Null } else { class },
        plant: bench.plant.to_owned(),
        closed_loop: bench.closed.is_some(),
        noise,
        effects: chosen.list.iter().map(|(hidden, _)| hidden.clone()).collect(),
        without: without.clone(),
        planned_d: planned,
        d: chosen.realised.iter().map(|found| found.d).collect(),
        held_out_d,
        kappa: chosen.realised.first().map_or(0.0, |found| found.kappa),
        rho,
        rival,
        biased,
        window: chosen.list.first().and_then(|(hidden, _)| window(hidden)),
        numbers: priors(&plant).into_iter().map(|(name, _)| (name.clone(), setup.numbers.get(&name))).collect(),
        recordings: vec![recording_digest(&recording), recording_digest(&held_out)],
        candidates: EFFECTS.iter().map(|effect| sites(effect, &plant).len()).sum(),
    };
    let bytes = serde_json::to_vec(&truth).expect("numbers and names are JSON");
    let exam = Exam {
        plant: setup.flight.plant.clone(),
        recording,
        held_out: (class != Class::Null || is_control).then(|| (other.flight.plant.clone(), held_out)),
        without,
    };
    Sealed { exam, digest: digest(&bytes), truth: bytes }
}

fn window(hidden: &Hidden) -> Option<(String, [f64; 2])> {
    let value = |name: &str| hidden.values.iter().find(|(n, _)| n == name).map(|(_, value)| *value);
    let (begin, duration) = (value("begin")?, value("duration")?);
    Some((hidden.site.trim_start_matches("sensor:").to_owned(), [begin, begin + duration]))
}
