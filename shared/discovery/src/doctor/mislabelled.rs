//! Channels in another unit, or of another sign, than their label says, as the likelihood of a plant has it.
//!
//! A channel that reads `f` times what it should is predicted by the plant, to the noise that it states, once it is divided by `f`. That is
//! asked where the plant misses the recording by far alone, or follows it with numbers far from what its file states. What is put right must be
//! explained: the whitened innovations fall far below what they were, counted in the unit of the readings, for a free response divided by
//! anything is one still, and by as much less of whatever it misses. What only shrinks to nothing explains nothing: the reading must stay
//! above its noise, and without the command the plant must miss the recording again.
//!
//! Of a long recording beginnings that the plant misses by far are asked before the whole; what explains one must explain the whole.

use core::f64::consts::{PI, TAU};

use plant::description::Plant;

use super::quantity::{Kind, Quantity, of_channel};
use super::{Check, Finding, Severity, short};
use crate::fit::board::dot;
use crate::fit::{Board, Engine, fit, fit_from_afar};
use crate::problem::{Problem, sample_sigma};
use crate::series::{Channel, Recording};
use crate::statistics::deviation;

/// What is wrong with the label of a channel, or of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// They read so many times what they should, as `degrees read as radians` do.
    Factor(f64, &'static str),
    /// Two are each other's.
    Swapped,
}

/// Channels of a recording whose label is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Mislabelled {
    pub recording: String,
    pub channels: Vec<String>,
    pub mistake: Mistake,
    /// Other mistakes that explain it as well.
    pub instead: Vec<Mislabelled>,
    /// Rms of the innovations of the whole recording [stated standard deviations] as it is labelled and put right; infinite where the
    /// plant cannot follow it at all.
    pub before: f64,
    pub after: f64,
}

/// Mean square of the whitened innovations from which on a recording is missed by far, and by how much it must fall.
const FAR_OFF: f64 = 25.0;
/// Standard deviations within which the plant's numbers must stay.
const ASTRAY: f64 = 5.0;
/// Standard deviations of its noise that a reading must stay above, and times the mean square without a command.
const ABOVE_NOISE: f64 = 3.0;
const WITHOUT: f64 = 2.0;
/// A hypothesis explains it as well within this factor of the best mean square.
const AS_WELL: f64 = 1.1;
/// Hypotheses that are looked at, those of single channels first.
const HYPOTHESES: usize = 200;
/// Samples times numbers of the plant times hypotheses up to which each is fitted in one round to be ranked, else none.
const PASSED: usize = 20_000_000;
/// Hypotheses that are fitted to the end.
const FITTED: usize = 5;
/// Samples that are asked first, and how many times more next.
const BEGINNING: usize = 8000;
const GROWTH: usize = 4;
/// Relinearisations of a fit.
const ROUNDS: usize = 4;

/// The mistake that explains what `plant` misses of `recording` by far; none where it follows it.
///
/// Cost: a linearisation; where the plant is far off, for each beginning up to [`HYPOTHESES`] of them and [`FITTED`] fits and as many again for
/// commands.
#[must_use]
pub fn mislabelled(recording: &Recording, plant: &Plant) -> Option<Mislabelled> {
    let is_near = |found: &Option<Prediction>| found.as_ref().is_some_and(Prediction::is_near);
    if is_near(&Prediction::of(recording, plant, 0)) {
        return None;
    }
    let before = Prediction::of(recording, plant, ROUNDS);
    if is_near(&before) {
        return None;
    }
    let list = explaining((recording, &before), plant, suspects(recording, plant));
    let mut all = list.into_iter();
    let (after, best) = all.next()?;
    let as_well = all.filter(|(other, _)| other.mean_square < AS_WELL * after.mean_square);
    let before = before.map_or(f64::INFINITY, |before| before.mean_square.sqrt());
    Some(Mislabelled {
        before,
        after: after.mean_square.sqrt(),
        instead: as_well.map(|(_, other)| other).collect(),
        ..best
    })
}

fn samples(recording: &Recording) -> usize {
    recording.channels.iter().map(|channel| channel.value.len()).sum()
}

/// What explains the first [`BEGINNING`] samples, [`GROWTH`] times as many, and so on, where the plant misses them by far alone; what comes nearest to the
/// whole where nothing does.
fn suspects(recording: &Recording, plant: &Plant) -> Vec<Mislabelled> {
    let mut many = BEGINNING;
    while many < samples(recording) {
        let beginning = recording.beginning(many as f64 / samples(recording) as f64);
        let missed = Prediction::of(&beginning, plant, ROUNDS);
        if !missed.as_ref().is_some_and(Prediction::is_near) {
            let list = explaining((&beginning, &missed), plant, ranked(&beginning, plant));
            if !list.is_empty() {
                return list.into_iter().map(|(_, found)| found).collect();
            }
        }
        many *= GROWTH;
    }
    ranked(recording, plant)
}

/// Those hypotheses that come nearest.
fn ranked(recording: &Recording, plant: &Plant) -> Vec<Mislabelled> {
    let all = hypotheses(recording, plant);
    let numbers = plant.parameters().iter().filter(|parameter| parameter.sigma.is_some()).count();
    let rounds = usize::from(all.len() * samples(recording) * numbers < PASSED);
    let own = |found: Mislabelled| Some((found.predicted(recording, plant, rounds)?.mean_square, found));
    let mut ranked: Vec<(f64, Mislabelled)> = all.into_iter().filter_map(own).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.truncate(FITTED);
    ranked.into_iter().map(|(_, found)| found).collect()
}

/// Those of `list` that explain what the plant misses of a recording that it predicts like `before`, best first.
fn explaining(
    (recording, before): (&Recording, &Option<Prediction>),
    plant: &Plant,
    list: Vec<Mislabelled>,
) -> Vec<(Prediction, Mislabelled)> {
    let explains = |(after, found): &(Prediction, Mislabelled)| {
        let as_read = after.mean_square * found.weight(plant);
        let falls = before.as_ref().is_none_or(|before| as_read < before.mean_square / FAR_OFF);
        let is_near = after.is_near() && (falls || found.is_of_command(plant));
        is_near && found.is_seen(recording, plant, after.mean_square)
    };
    let fitted = list.into_iter().filter_map(|found| Some((found.predicted(recording, plant, ROUNDS)?, found)));
    let mut explaining: Vec<(Prediction, Mislabelled)> = fitted.filter(explains).collect();
    explaining.sort_by(|a, b| a.0.mean_square.total_cmp(&b.0.mean_square));
    explaining
}

impl Mislabelled {
    fn of(recording: &Recording, channels: &[&Channel], mistake: Mistake) -> Self {
        let channels = channels.iter().map(|channel| channel.name.clone()).collect();
        let (recording, instead) = (recording.name.clone(), Vec::new());
        Self { recording, channels, mistake, instead, before: f64::NAN, after: f64::NAN }
    }

    /// The same mistake, of whatever recording.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.channels == other.channels && self.mistake == other.mistake
    }

    fn is_of_command(&self, plant: &Plant) -> bool {
        self.channels.iter().any(|name| plant.actuator(name).is_some())
    }

    /// Squared size of a reading as recorded in what it is once put right, at least one.
    fn weight(&self, plant: &Plant) -> f64 {
        if self.is_of_command(plant) { 1.0 } else { (self.factor() * self.factor()).max(1.0) }
    }

    fn factor(&self) -> f64 {
        if let Mistake::Factor(factor, _) = self.mistake { factor } else { 1.0 }
    }

    fn is(&self, channel: &Channel) -> bool {
        self.channels.contains(&channel.name)
    }

    /// `recording` put right.
    #[must_use]
    pub fn cured(&self, recording: &Recording) -> Recording {
        let mut cured = recording.clone();
        let mut own: Vec<&mut Channel> = cured.channels.iter_mut().filter(|channel| self.is(channel)).collect();
        match (self.mistake, &mut own[..]) {
            (Mistake::Factor(factor, _), all) => {
                all.iter_mut().flat_map(|channel| &mut channel.value).for_each(|value| *value /= factor);
            }
            (Mistake::Swapped, [a, b]) => core::mem::swap(&mut a.name, &mut b.name),
            (Mistake::Swapped, _) => {}
        }
        cured
    }

    /// `'rate' reads 57.3 times what the plant says (degrees read as radians)`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let names = self.channels.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(" and ");
        let verb = if self.channels.len() == 1 { "reads" } else { "read" };
        let own = match self.mistake {
            Mistake::Factor(factor, meaning) => {
                format!("{names} {verb} {} times what the plant says ({meaning})", short(factor))
            }
            Mistake::Swapped => format!("{names} are each other's"),
        };
        self.instead.iter().fold(own, |all, other| format!("{all}, or {}", other.in_words()))
    }

    pub(super) fn finding(&self) -> Finding {
        let (first, others) = (&self.channels[0], self.channels[1..].iter().map(String::as_str).collect::<Vec<_>>());
        let (check, cure) = match self.mistake {
            Mistake::Factor(factor, _) => {
                let check = if factor < 0.0 { Check::Sign } else { Check::Units };
                (
                    check,
                    format!("a line NAME = {{ name = \"...\", scale = {:.7} }} of [channels] for each", 1.0 / factor),
                )
            }
            Mistake::Swapped => (Check::Axes, "the one's name for the other in [channels]".to_owned()),
        };
        let now =
            if self.before.is_finite() { format!("{} now", short(self.before)) } else { "not at all now".to_owned() };
        Finding::new(check, Severity::Fault, first, self.factor(), "-")
            .with(&others)
            .because(format!(
                "{}: with that put right the plant predicts the recording to {} stated standard deviations rms, {now}",
                self.in_words(),
                short(self.after)
            ))
            .cure(format!("correct the header, or give --map FILE with {cure}"))
    }
}

/// How well a plant predicts a recording.
struct Prediction {
    /// Of the whitened innovations.
    mean_square: f64,
    /// Largest distance of a number from its prior [standard deviations].
    astray: f64,
}

impl Prediction {
    fn is_near(&self) -> bool {
        self.mean_square < FAR_OFF && self.astray < ASTRAY
    }

    /// Where a fit of so many rounds ends, without any at the priors; `None` where the filter fails.
    fn of(recording: &Recording, plant: &Plant, rounds: usize) -> Option<Self> {
        let problem = Problem::new(plant, core::slice::from_ref(recording), &[]).ok()?;
        let engine = Engine::new(&problem, 1).ok()?;
        let (mean_square, theta) = if rounds == 0 {
            let board = Board::new(&engine, plant, &engine.prior(), &engine.noise).ok()?;
            let (r, _) = board.whitened(&engine, &engine.noise, &[])?;
            (dot(&r, &r) / r.len().max(1) as f64, engine.prior())
        } else {
            let fit = if rounds < ROUNDS {
                fit(&engine, plant, &engine.prior(), &engine.noise, rounds)
            } else {
                fit_from_afar(&engine, rounds)
            };
            let fit = fit.ok()?;
            (fit.chi2_per_sample, fit.theta)
        };
        let off =
            theta.iter().zip(&problem.unknowns).map(|(theta, unknown)| ((theta - unknown.prior) / unknown.sigma).abs());
        let astray = off.fold(0.0, f64::max);
        mean_square.is_finite().then_some(Self { mean_square, astray })
    }
}

impl Mislabelled {
    fn predicted(&self, recording: &Recording, plant: &Plant, rounds: usize) -> Option<Prediction> {
        Prediction::of(&self.cured(recording), plant, rounds)
    }

    /// What is put right is more than nothing.
    fn is_seen(&self, recording: &Recording, plant: &Plant, after: f64) -> bool {
        let mut silent = recording.clone();
        let commands =
            silent.channels.iter_mut().filter(|channel| self.is(channel) && plant.actuator(&channel.name).is_some());
        let mut any = false;
        for channel in commands {
            channel.value.fill(0.0);
            any = true;
        }
        if any {
            return Prediction::of(&silent, plant, ROUNDS).is_none_or(|without| without.mean_square > WITHOUT * after);
        }
        let is_above = |channel: &Channel| {
            let sensor = plant.sensors.iter().find(|sensor| sensor.name == channel.name);
            sensor.is_some_and(|sensor| {
                deviation(&channel.value) > ABOVE_NOISE * self.factor().abs() * sample_sigma(plant, sensor)
            })
        };
        recording.channels.iter().filter(|channel| self.is(channel)).any(is_above)
    }
}

/// Every channel that the plant reads or is driven by, and all sensors of one kind together, by every factor of their quantity; two of one
/// quantity for each other.
fn hypotheses(recording: &Recording, plant: &Plant) -> Vec<Mislabelled> {
    let recorded = |name: &String| recording.channels.iter().find(|channel| channel.name == *name);
    let sensors: Vec<&Channel> = plant.sensors.iter().filter_map(|sensor| recorded(&sensor.name)).collect();
    let commands: Vec<&Channel> = plant.actuators.iter().filter_map(|actuator| recorded(&actuator.name)).collect();
    let mut all = Vec::new();
    for channel in sensors.iter().chain(&commands) {
        let mistakes = factors(of_channel(channel)).into_iter().chain([Mistake::Factor(-1.0, "its sign is turned")]);
        all.extend(mistakes.map(|mistake| Mislabelled::of(recording, &[*channel], mistake)));
    }
    for kind in [Kind::Angle, Kind::Length] {
        let like = |channel: &&&Channel| of_channel(channel).is_some_and(|quantity| quantity.kind == kind);
        let group: Vec<&Channel> = sensors.iter().filter(like).copied().collect();
        if group.len() > 1 {
            let common = factors(Some(Quantity { kind, order: 0, factor: 1.0 }));
            all.extend(common.into_iter().map(|mistake| Mislabelled::of(recording, &group, mistake)));
        }
    }
    let quantity = |channel: &Channel| of_channel(channel).map(|quantity| (quantity.kind, quantity.order));
    for (i, a) in sensors.iter().enumerate() {
        let alike = sensors[i + 1..].iter().filter(|b| quantity(a) == quantity(b));
        all.extend(alike.map(|b| Mislabelled::of(recording, &[*a, *b], Mistake::Swapped)));
    }
    all.truncate(HYPOTHESES);
    all
}

/// What a reading of `quantity` is multiplied by where its unit is mistaken.
fn factors(quantity: Option<Quantity>) -> Vec<Mistake> {
    let (degree, g, rpm) = (180.0 / PI, 9.80665, 60.0 / TAU);
    let milli = [(1e3, "milli read as one"), (1e-3, "one read as milli")];
    let own: &[(f64, &'static str)] = match quantity.map(|quantity| (quantity.kind, quantity.order)) {
        Some((Kind::Angle, 0)) => &[(degree, "degrees read as radians"), (1.0 / degree, "radians read as degrees")],
        Some((Kind::Angle, 1)) => &[
            (degree, "degrees read as radians"),
            (1.0 / degree, "radians read as degrees"),
            (rpm, "turns per minute read as rad/s"),
            (1.0 / rpm, "rad/s read as turns per minute"),
        ],
        Some((Kind::Angle, _)) => &[(degree, "degrees read as radians"), (1.0 / degree, "radians read as degrees")],
        Some((Kind::Length, 2)) => &[(1.0 / g, "g read as m/s^2"), (g, "m/s^2 read as g")],
        Some((Kind::Length, 0)) => &[(1e2, "centimetres read as metres"), (1e-2, "metres read as centimetres")],
        _ => &[],
    };
    own.iter().copied().chain(milli).map(|(factor, meaning)| Mistake::Factor(factor, meaning)).collect()
}

#[cfg(test)]
mod tests;
