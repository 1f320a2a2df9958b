//! Wrong units, flipped signs and swapped channels, detected by the likelihood of a plant.
//!
//! A channel that reads `f` times its true value is predicted by the plant, to the stated noise,
//! once it is divided by `f`. The test is made only where the plant misses the recording by far, or
//! follows it with parameters far from those its file states. The corrected recording must be
//! explained: the whitened innovations must fall far below their former value, counted in the unit
//! of the readings, because a free response divided by anything is still one, and its misfit is
//! divided as well. A channel that only shrinks to zero explains nothing: the reading must stay
//! above its noise, and without the command the plant must miss the recording again.
//!
//! Of a long recording the first samples are tested before the whole; the mistake that explains
//! them must explain the whole, and where none explains them, none explains the whole. The cost of
//! testing is counted ([`identification::work`]): the nearest hypotheses come first, and those
//! beyond the work are omitted and reported for no channel.

mod prediction;

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use dynamics::description::Plant;

use crate::diagnose::LabelReport;
use channels::{Channel, Recording};
use examination::doctor::quantity::{Kind, Quantity, of_channel};
use examination::doctor::{Check, Finding, Severity, short};
use identification::problem::{Problem, sample_sigma};
use identification::statistics::deviation;
use identification::work::Work;
use prediction::{MISFIT_MEAN_SQUARE, ParameterChoice, PlantEvaluator, Prediction};

/// What is wrong with the metadata of a channel, or of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// They read so many times their true value, as in `degrees read as radians`.
    Factor(f64, &'static str),
    /// Two channels are exchanged.
    Swapped,
}

/// Channels of a recording whose metadata is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Mislabelled {
    pub recording: String,
    pub channels: Vec<String>,
    pub mistake: Mistake,
    /// Other mistakes that explain it as well.
    pub instead: Vec<Mislabelled>,
    /// Rms of the innovations of the whole recording [stated standard deviations] as labelled, at
    /// least, and corrected; infinite where the plant cannot follow it at all.
    pub before: f64,
    pub after: f64,
}

/// Standard deviations of its noise that a corrected reading must exceed, and ratio by which the
/// mean square must rise without the command. Chosen on seeded cases, no derivation.
const SIGNAL_TO_NOISE_MIN: f64 = 3.0;
const UNDRIVEN_MISFIT_RATIO: f64 = 2.0;
/// Ratio to the best mean square within which a hypothesis explains it as well. Chosen, no
/// derivation.
const EQUAL_FIT_RATIO: f64 = 1.1;
/// Mean square of the innovations below which a plant predicts better than its noise lets it,
/// because a command made smaller leaves all to its disturbance: a third of the stated standard
/// deviation, 3.7 standard deviations of what data sheets are off by.
const QUIET_MEAN_SQUARE: f64 = 1.0 / 9.0;
/// Hypotheses that are evaluated, those of single channels first.
const HYPOTHESES: usize = 200;
/// Share of the remaining work for ranking them. Chosen, no derivation.
const RANKING_WORK_SHARE: f64 = 0.6;
/// What is omitted where the work is spent.
const OMITTED_HYPOTHESES: &str = "mistakes of the channel metadata that come less near at first";
const OMITTED_PARTS: &str = "channel metadata on more of a recording";
/// Hypotheses that are fitted completely.
const HYPOTHESES_FITTED: usize = 5;
/// Readings that are tested first, and the factor to the next part.
const FIRST_PART_READINGS: usize = 2000;
const PART_GROWTH: usize = 4;

/// The mistake that explains why `plant` misses `recording` by far; `None` where the plant follows
/// it, and where `work` has no budget left, which is recorded there.
///
/// Cost: a linearisation. Where the plant is far off, for each part up to `HYPOTHESES`
/// linearisations, `HYPOTHESES_FITTED` fits and as many again for commands, within `work`; then
/// the test on the whole recording.
#[must_use]
pub fn mislabelled(recording: &Recording, plant: &Plant, work: &Arc<Work>) -> Option<Mislabelled> {
    // channels that the plant cannot read are left to the other checks
    Problem::new(plant, core::slice::from_ref(recording), &[]).ok()?;
    let evaluator = PlantEvaluator::new(plant, work);
    if is_near(&evaluator.predicted(recording, ParameterChoice::Priors)) {
        return None;
    }
    let all = evaluator.samples(recording);
    let mut many = FIRST_PART_READINGS;
    while many < all {
        let beginning = recording.beginning(many as f64 / all as f64);
        let found = explained(&evaluator, &beginning)?;
        if found.none_near {
            return None;
        }
        let found = if found.list.is_empty() { None } else { confirmed(&evaluator, recording, found) };
        if found.is_some() {
            return found;
        }
        many *= PART_GROWTH;
    }
    explained(&evaluator, recording)?.best()
}

/// The finding that the channel metadata was not tested completely, for the reason in `note`.
pub(super) fn not_tested(recording: &Recording, plant: &Plant, note: &str) -> Option<Finding> {
    let is_read = |channel: &&Channel| plant.sensors.iter().any(|sensor| sensor.name == channel.name);
    let read: Vec<&str> = recording.channels.iter().filter(is_read).map(|channel| channel.name.as_str()).collect();
    let (first, others) = read.split_first()?;
    Some(
        Finding::new(Check::Units, Severity::Note, first, read.len() as f64, "channels")
            .with(others)
            .because(format!("with the parameters that its file states the plant misses the recording by far, and whether wrong channel metadata explains that was not tested completely: {note}"))
            .cure("diagnose a shorter part of the recording, or a plant with fewer uncertain parameters"),
    )
}

fn is_near(found: &Option<Prediction>) -> bool {
    found.as_ref().is_some_and(Prediction::is_near)
}

/// Hypotheses that explain why a recording is missed by far, best first.
struct Explained {
    before: Option<Prediction>,
    list: Vec<(Prediction, Mislabelled)>,
    /// As labelled the plant misses by far, and so it does with every mistake corrected.
    none_near: bool,
}

impl Explained {
    /// The plant comes near, and nearer by far than `before`.
    fn holds(&self, plant: &Plant, (after, found): &(Prediction, Mislabelled)) -> bool {
        let as_read = after.mean_square * found.weight(plant);
        let falls = self.before.as_ref().is_none_or(|before| as_read < before.mean_square / MISFIT_MEAN_SQUARE);
        after.is_near() && after.mean_square > QUIET_MEAN_SQUARE && (falls || found.is_of_command(plant))
    }

    /// Keeps the hypotheses that hold, best first; none where the recording is followed as
    /// labelled.
    fn keep_near(&mut self, plant: &Plant) {
        let list = core::mem::take(&mut self.list);
        if !is_near(&self.before) {
            self.list = list.into_iter().filter(|found| self.holds(plant, found)).collect();
        }
        nearest_first(&mut self.list);
    }

    fn best(self) -> Option<Mislabelled> {
        let mut all = self.list.into_iter();
        let (after, best) = all.next()?;
        let as_well = all.filter(|(other, _)| other.mean_square < EQUAL_FIT_RATIO * after.mean_square);
        Some(Mislabelled {
            before: self.before.map_or(f64::INFINITY, |before| before.mean_square.sqrt()),
            after: after.mean_square.sqrt(),
            instead: as_well.map(|(_, other)| other).collect(),
            ..best
        })
    }
}

/// Mistakes that explain the misfit of `recording`; empty where it is followed, `None` where no
/// budget is left.
fn explained(evaluator: &PlantEvaluator<'_>, recording: &Recording) -> Option<Explained> {
    if !evaluator.affords(recording, ParameterChoice::Fitted, OMITTED_PARTS) {
        return None;
    }
    let mut explained = Explained {
        before: evaluator.predicted(recording, ParameterChoice::Fitted),
        list: Vec::new(),
        none_near: false,
    };
    if is_near(&explained.before) {
        return Some(explained);
    }
    evaluator.plan_hypotheses(recording, hypotheses(recording, evaluator.plant).len());
    explained.list = nearer(evaluator, recording, ParameterChoice::Fitted, ranked(evaluator, recording));
    if !explained.list.iter().any(|found| explained.holds(evaluator.plant, found)) {
        explained.list = nearer(evaluator, recording, ParameterChoice::ByContinuation, explained.list);
    }
    explained.none_near = !explained.list.iter().any(|(after, _)| after.is_near());
    explained.keep_near(evaluator.plant);
    if !explained.list.is_empty() {
        if evaluator.affords(recording, ParameterChoice::ByContinuation, OMITTED_PARTS) {
            explained.before = evaluator.predicted(recording, ParameterChoice::ByContinuation);
            explained.keep_near(evaluator.plant);
        }
        explained.list.retain(|(after, found)| found.is_seen(evaluator, recording, after));
    }
    Some(explained)
}

/// The same on the whole `recording`, started where the fits to its first part ended.
fn confirmed(evaluator: &PlantEvaluator<'_>, recording: &Recording, of_part: Explained) -> Option<Mislabelled> {
    let mut list = Vec::new();
    for (part, found) in of_part.list {
        let from = ParameterChoice::From(&part);
        // the nearest in any case
        if !list.is_empty() && !evaluator.affords(recording, from, OMITTED_HYPOTHESES) {
            break;
        }
        list.extend(evaluated(evaluator, recording, from, found));
    }
    let samples = list.first()?.0.samples;
    let fitted = || evaluator.predicted(recording, ParameterChoice::Fitted);
    let before = of_part.before.map(|before| before.of_more(samples)).or_else(fitted);
    let mut explained = Explained { before, list, none_near: false };
    if let Some(least) = &explained.before
        && (least.is_near() || !explained.list.iter().any(|found| explained.holds(evaluator.plant, found)))
    {
        explained.before = evaluator.predicted(recording, ParameterChoice::From(least)).or_else(fitted);
    }
    explained.keep_near(evaluator.plant);
    explained.best()
}

/// The hypotheses that come nearest: at the priors, and after one step where the work allows.
fn ranked(evaluator: &PlantEvaluator<'_>, recording: &Recording) -> Vec<(Prediction, Mislabelled)> {
    let until = evaluator.work.until(RANKING_WORK_SHARE);
    let mut all = hypotheses(recording, evaluator.plant).into_iter();
    let mut at_priors = Vec::new();
    while evaluator.affords_until(until, recording, ParameterChoice::Priors)
        && let Some(found) = all.next()
    {
        at_priors.extend(evaluated(evaluator, recording, ParameterChoice::Priors, found));
    }
    if all.len() > 0 {
        evaluator.work.leave_out(OMITTED_HYPOTHESES);
    }
    nearest_first(&mut at_priors);
    let mut all = at_priors.into_iter();
    let mut ranked = Vec::new();
    while evaluator.affords_until(until, recording, ParameterChoice::Step)
        && let Some((_, found)) = all.next()
    {
        ranked.extend(evaluated(evaluator, recording, ParameterChoice::Step, found));
    }
    nearest_first(&mut ranked);
    ranked.extend(all);
    ranked.truncate(HYPOTHESES_FITTED);
    ranked
}

/// The hypotheses of `list` with parameters found in another way, as far as the work allows.
fn nearer(
    evaluator: &PlantEvaluator<'_>,
    recording: &Recording,
    how: ParameterChoice<'_>,
    list: Vec<(Prediction, Mislabelled)>,
) -> Vec<(Prediction, Mislabelled)> {
    let mut nearer = Vec::new();
    let mut list = list.into_iter();
    while list.len() > 0
        && evaluator.affords(recording, how, OMITTED_HYPOTHESES)
        && let Some((_, found)) = list.next()
    {
        nearer.extend(evaluated(evaluator, recording, how, found));
    }
    nearer.extend(list);
    nearest_first(&mut nearer);
    nearer
}

fn evaluated(
    evaluator: &PlantEvaluator<'_>,
    recording: &Recording,
    how: ParameterChoice<'_>,
    found: Mislabelled,
) -> Option<(Prediction, Mislabelled)> {
    Some((evaluator.predicted(&found.cured(recording), how)?, found))
}

fn nearest_first(list: &mut [(Prediction, Mislabelled)]) {
    list.sort_by(|a, b| a.0.mean_square.total_cmp(&b.0.mean_square));
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

    /// Squared ratio of a reading as recorded to its corrected value, at least one.
    fn weight(&self, plant: &Plant) -> f64 {
        if self.is_of_command(plant) { 1.0 } else { (self.factor() * self.factor()).max(1.0) }
    }

    fn factor(&self) -> f64 {
        if let Mistake::Factor(factor, _) = self.mistake { factor } else { 1.0 }
    }

    fn is(&self, channel: &Channel) -> bool {
        self.channels.contains(&channel.name)
    }

    /// `recording` with this mistake corrected.
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

    /// `'rate' reads 57.3 times what the plant predicts (degrees read as radians)`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let names = self.channels.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(" and ");
        let verb = if self.channels.len() == 1 { "reads" } else { "read" };
        let own = match self.mistake {
            Mistake::Factor(factor, meaning) => {
                format!("{names} {verb} {} times what the plant predicts ({meaning})", short(factor))
            }
            Mistake::Swapped => format!("{names} are swapped"),
        };
        self.instead.iter().fold(own, |all, other| format!("{all}, or {}", other.in_words()))
    }

    /// As an entry of a diagnosis.
    #[must_use]
    pub fn report(&self, probability: Option<f64>, corrected: bool) -> LabelReport {
        let (recording, channels, mistake) = (self.recording.clone(), self.channels.clone(), self.in_words());
        LabelReport { recording, channels, mistake, probability, corrected }
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
        let now = if self.before.is_finite() {
            format!("at least {} now", short(self.before))
        } else {
            "not at all now".to_owned()
        };
        Finding::new(check, Severity::Fault, first, self.factor(), "-")
            .with(&others)
            .because(format!(
                "{}: with that corrected the plant predicts the recording to {} stated standard deviations rms, {now}",
                self.in_words(),
                short(self.after)
            ))
            .cure(format!("correct the header, or give --map FILE with {cure}"))
    }
}

impl Mislabelled {
    /// The corrected reading is more than zero: it exceeds its noise.
    fn is_seen(&self, evaluator: &PlantEvaluator<'_>, recording: &Recording, after: &Prediction) -> bool {
        let plant = evaluator.plant;
        let mut silent = recording.clone();
        let commands =
            silent.channels.iter_mut().filter(|channel| self.is(channel) && plant.actuator(&channel.name).is_some());
        let mut any = false;
        for channel in commands {
            channel.value.fill(0.0);
            any = true;
        }
        if any {
            let without = evaluator.fitted(&silent, OMITTED_HYPOTHESES);
            let misses = |without: Prediction| without.mean_square > UNDRIVEN_MISFIT_RATIO * after.mean_square;
            return without.is_some_and(|without| without.is_none_or(misses));
        }
        let is_above = |channel: &Channel| {
            let sensor = plant.sensors.iter().find(|sensor| sensor.name == channel.name);
            sensor.is_some_and(|sensor| {
                deviation(&channel.value) > SIGNAL_TO_NOISE_MIN * self.factor().abs() * sample_sigma(plant, sensor)
            })
        };
        recording.channels.iter().filter(|channel| self.is(channel)).any(is_above)
    }
}

/// Every channel that the plant reads or is driven by, and all sensors of one kind together, by
/// every factor of their quantity; any two of one quantity exchanged.
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

/// Factors on a reading of `quantity` whose unit is mistaken.
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
