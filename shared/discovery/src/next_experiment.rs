//! Design of the experiment that separates two effects: a menu within limits, evaluated by
//! simulation.
//!
//! Each entry is simulated with the first effect at work and linearised as a recording of its own.
//! With both effects' columns `c_1`, `c_2` whitened and the nominal unknowns (known as well as this
//! recording leaves them) projected off, the second can imitate the first up to
//!
//! ```text
//! d = |a| |c_1'| √(1 − ρ²),   ρ = cos(c_1', c_2')
//! ```
//!
//! the discriminating power: standard errors between the best fits of the two (Atkinson and
//! Fedorov's T-optimality, linearised). An entry drives one free actuator, or scales the references
//! of closed loops or the initial state.

use crate::score::{Candidate, Score, columns, cosine, scores};
use channels::Recording;
use dynamics::description::{Plant, Quantity, Signal, SignalKind};
use identification::fit::{EstimationSession, LinearisedProblem};
use identification::problem::Problem;
use identification::work::Work;
use simulation::record;

/// An entry of the menu with its discriminating power.
#[derive(Clone, Debug)]
pub struct Experiment {
    pub name: String,
    /// The plant as it would be flown, with the first effect.
    pub plant: Plant,
    pub duration_s: f64,
    /// Standard errors between the two effects' best fits.
    pub d: f64,
}

/// Discriminating power [standard errors] below which no entry separates the two: two-sided 0.3 %
/// of a normal distribution.
pub const SEPARATES: f64 = 3.0;
/// Bound of the control periods of a simulated entry.
const PERIODS_MAX: f64 = 20_000.0;
/// Scales of references and of initial states.
const SCALES: [f64; 2] = [0.3, 2.0];

/// The two effects to separate, and the limits of the experiment.
pub struct Question<'a> {
    /// With the first effect; parameters as fitted, with their standard deviations on this
    /// recording.
    pub plant: &'a Plant,
    pub first: &'a Candidate,
    /// Amplitude of the first along each of its directions.
    pub amplitude: &'a [f64],
    pub second: &'a Candidate,
    pub duration_s: f64,
    /// Largest |command| of each actuator where its range is unspecified.
    pub flown: &'a [f64],
}

/// All feasible entries by falling discriminating power. Cost: for each entry a simulation, a
/// linearisation and two columns,
/// counted beside `work`.
pub fn menu(question: &Question<'_>, threads: usize, work: &Work) -> Vec<Experiment> {
    let period_s = question.plant.simulation.period_s;
    let duration_s = question.duration_s.min(PERIODS_MAX * period_s);
    let mut list: Vec<Experiment> = flyable(question, duration_s)
        .into_iter()
        .filter_map(|(name, plant)| {
            let d = power(question, &plant, duration_s, (threads, work))?;
            Some(Experiment { name, plant, duration_s, d })
        })
        .collect();
    list.sort_by(|a, b| b.d.total_cmp(&a.d));
    list
}

fn flyable(question: &Question<'_>, duration_s: f64) -> Vec<(String, Plant)> {
    let plant = question.plant;
    let mut list = vec![("the same once more".to_owned(), plant.clone())];
    for (index, actuator) in plant.actuators.iter().enumerate() {
        let closed = plant.controllers.iter().any(|controller| controller.actuator == actuator.name);
        let limit = actuator.range.as_ref().map_or(question.flown[index], |range| range.value);
        if closed || actuator.kind.is_imposed() || limit.is_nan() || limit <= 0.0 {
            continue;
        }
        for (what, kind) in profiles(limit, duration_s, plant.simulation.period_s) {
            let mut flown = plant.clone();
            flown.actuators[index].command = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
            list.push((format!("{what} on {}", actuator.name), flown));
        }
    }
    for scale in SCALES {
        if !plant.controllers.is_empty() {
            let mut flown = plant.clone();
            let references = flown.controllers.iter_mut().flat_map(|controller| &mut controller.reference);
            references.for_each(|signal| scaled(&mut signal.kind, scale));
            list.push((format!("references times {scale}"), flown));
        } else if !plant.initial.values.is_empty() && plant.actuators.is_empty() {
            let mut flown = plant.clone();
            for value in &mut flown.initial.values {
                value.position.value *= scale;
                value.rate.value *= scale;
            }
            list.push((format!("released from {scale} of the present state"), flown));
        }
    }
    list
}

/// A reference `by` times as large.
fn scaled(kind: &mut SignalKind, by: f64) {
    match kind {
        SignalKind::Constant { value: size }
        | SignalKind::Step { size }
        | SignalKind::Sine { amplitude: size, .. }
        | SignalKind::Square { amplitude: size, .. }
        | SignalKind::Chirp { amplitude: size, .. }
        | SignalKind::Multisine { rms: size, .. }
        | SignalKind::Pulse { size, .. }
        | SignalKind::Slew { size, .. }
        | SignalKind::Staircase { step: size, .. } => size.value *= by,
        SignalKind::Fourier { sine, cosine, .. } => sine.iter_mut().chain(cosine).for_each(|term| term.value *= by),
        SignalKind::Table { value, .. } => value.iter_mut().for_each(|value| *value *= by),
    }
}

/// Profiles of one input within ± `limit`.
fn profiles(limit: f64, duration_s: f64, period_s: f64) -> Vec<(&'static str, SignalKind)> {
    let known = Quantity::known;
    let last = ((0.2 * duration_s / period_s) as u32).clamp(2, 200);
    // a Schroeder multisine peaks at about 1.7 times its rms
    let multisine = |share: f64| SignalKind::Multisine {
        rms: known(share * limit / 2.0),
        period_s: known(duration_s),
        first: 1,
        last,
    };
    vec![
        ("multisine", multisine(1.0)),
        ("small multisine", multisine(0.1)),
        (
            "slow crawl",
            SignalKind::Sine {
                amplitude: known(0.1 * limit),
                frequency_hz: known(2.0 / duration_s),
                phase_rad: known(0.0),
            },
        ),
        ("reversals", SignalKind::Square { amplitude: known(0.7 * limit), frequency_hz: known(8.0 / duration_s) }),
        (
            "pulses",
            SignalKind::Pulse {
                size: known(limit),
                width_s: known(duration_s / 40.0),
                period_s: Some(known(duration_s / 8.0)),
            },
        ),
    ]
}

/// Discriminating power of one entry; `None` where it is not feasible or shows neither effect.
fn power(question: &Question<'_>, with: &Plant, duration_s: f64, (threads, work): (usize, &Work)) -> Option<f64> {
    let recording = flown(with, duration_s)?;
    let mut plant = with.clone();
    plant.effects.retain(|used| used.kind != question.first.effect.kind || used.site != question.first.site);
    let plant = &plant;
    let problem = Problem::new(plant, &[recording], &[]).ok()?;
    let session = EstimationSession::counted(&problem, threads, work.beside()).ok()?;
    let theta = session.prior();
    let mut linearised = LinearisedProblem::new(&session, plant, &theta, &session.noise).ok()?;
    linearised.take_jacobian(&session, plant, &theta);
    let both = [question.first.clone(), question.second.clone()];
    let pair = columns((&session, &linearised), plant, &theta, &both);
    let found = scores(&session, &linearised, &theta, &session.noise, &pair);
    let own = |candidate: &Candidate| {
        found.iter().flatten().find(|score| pair[score.column].candidate.same_law(candidate)).cloned()
    };
    let mut first = own(question.first)?;
    first.amplitude = question.amplitude.iter().copied().take(first.projected.len()).collect();
    let rho = own(question.second).map_or(0.0, |second| cosine(&first, &second));
    Some(along(&first) * (1.0 - rho * rho).max(0.0).sqrt())
}

/// Norm of the first effect's projected column at its amplitude.
fn along(score: &Score) -> f64 {
    let n = score.projected.first().map_or(0, Vec::len);
    let at = |s: usize| score.projected.iter().zip(&score.amplitude).map(|(c, a)| a * c[s]).sum::<f64>();
    (0..n).map(|s| at(s) * at(s)).sum::<f64>().sqrt()
}

fn flown(plant: &Plant, duration_s: f64) -> Option<Recording> {
    let simulated = record(plant, 1, duration_s, &mut |_| {}).ok()?;
    Some(Recording { name: "next".to_owned(), ..simulated })
}
