//! What a kept arc misses, within a stated amount of work.

use channels::Recording;
use craft::missing::Missing;
use craft::parameters::Parameters;
use discovery::diagnose::{Diagnosis, EffectReport, Options, Verdict};
use discovery::engine::Engine;
use dynamics::description::Plant;
use identification::held_out::Status;
use identification::joint::JointUnknown;
use identification::problem::Problem;
use identification::work::QUICK_WORK;
use telemetry::DiagnosisVerdict;

/// What one diagnosis may cost, counted: about a minute of one core, and half as much for what it
/// then finishes. It pays for 20 s of the study case's arm motion whole; of a longer arc the
/// beginning is diagnosed, in which a motion may lack the reversal that tells friction from a
/// constant torque.
pub const WORK_MAX: f64 = 3.0 * QUICK_WORK;

/// What the rows of an arc say that `plant` lacks, from the values `start` of the shared parameters
/// at which its own message ended: a verdict, effects, and the shared parameters beside them. Rows
/// that the plant cannot predict decide nothing, and leave the parameters where they were.
pub fn examined(
    plant: &Plant,
    recording: Option<Recording>,
    (parameters, start): (&Parameters, &[f64]),
) -> (DiagnosisVerdict, Vec<Missing>, Vec<f64>) {
    let plant = started(plant, parameters, start);
    let problem = recording.and_then(|recording| Problem::new(&plant, &[recording], &[]).ok());
    let options = Options { threads: 1, work_max: WORK_MAX, is_refused: true, ..Options::default() };
    let found = problem.map_or_else(
        || Diagnosis::cannot_decide("the rows were not kept".into()),
        |problem| Engine::default().diagnose(&problem, &options, &mut |_, _| {}),
    );
    let after = |(k, unknown): (usize, &JointUnknown)| {
        let own = found.nominal.iter().find(|own| own.name == unknown.name).map(|own| own.after);
        own.or(start.get(k).copied()).filter(|value| value.is_finite()).unwrap_or(unknown.prior)
    };
    let theta = parameters.unknowns.iter().enumerate().map(after).collect();
    (verdict(found.verdict), effects(&found), theta)
}

/// The plant at the values where the arc's own message ended, so that its fit begins near its end.
/// A number that a plant which lacks something has moved is as uncertain as it was moved, and as
/// its file states: `σ² = σ₀² + (θ − θ₀)²`.
fn started(plant: &Plant, parameters: &Parameters, theta: &[f64]) -> Plant {
    let mut started = plant.clone();
    started.visit_quantities(&mut |name, _, quantity| {
        let at = parameters.unknowns.iter().position(|unknown| unknown.name == *name);
        if let Some(value) = at.and_then(|at| theta.get(at)) {
            let moved = value - quantity.value;
            quantity.sigma = quantity.sigma.map(|sigma| (sigma * sigma + moved * moved).sqrt());
            quantity.value = *value;
        }
    });
    started
}

/// Effects that were fitted and that nothing rejects, then those that could replace them; none
/// where the verdict names none.
fn effects(found: &Diagnosis) -> Vec<Missing> {
    if !matches!(found.verdict, Verdict::Named | Verdict::NotSeparable | Verdict::Sensor) {
        return Vec::new();
    }
    let stands = |effect: &&EffectReport| !matches!(effect.status, Status::NotConverged | Status::Rejected);
    let fitted: Vec<&EffectReport> = found.effects.iter().filter(stands).collect();
    let mut effects: Vec<Missing> = fitted.iter().filter_map(|effect| missing(effect)).collect();
    if effects.len() < fitted.len() {
        return Vec::new();
    }
    for (of, rival) in fitted.iter().enumerate().flat_map(|(of, effect)| effect.rivals.iter().map(move |r| (of, r))) {
        if let Ok(site) = rival.site.parse() {
            effects.push(Missing {
                kind: rival.kind.clone(),
                site,
                stands_in_for: Some(of),
                probability: rival.probability,
                significance: 0.0,
                values: Vec::new(),
            });
        }
    }
    effects
}

fn missing(effect: &EffectReport) -> Option<Missing> {
    let values = effect.parameters.iter().map(|p| (p.name.clone(), p.value, p.sigma));
    Some(Missing {
        kind: effect.kind.clone(),
        site: effect.site.parse().ok()?,
        stands_in_for: None,
        probability: effect.probability,
        significance: effect.d,
        values: values.collect(),
    })
}

const fn verdict(verdict: Verdict) -> DiagnosisVerdict {
    match verdict {
        Verdict::None => DiagnosisVerdict::Nothing,
        Verdict::Named => DiagnosisVerdict::Named,
        Verdict::NotSeparable => DiagnosisVerdict::NotSeparable,
        Verdict::NotInCatalogue => DiagnosisVerdict::NotInCatalogue,
        Verdict::NoiseModel => DiagnosisVerdict::NoiseModel,
        Verdict::ParameterConflict => DiagnosisVerdict::ParameterConflict,
        Verdict::InputTiming => DiagnosisVerdict::InputTiming,
        Verdict::Sensor => DiagnosisVerdict::Sensor,
        Verdict::Unobservable => DiagnosisVerdict::Unobservable,
        Verdict::CannotDecide => DiagnosisVerdict::CannotDecide,
    }
}
