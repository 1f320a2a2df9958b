//! What a kept arc misses, within a stated amount of work.

use channels::Recording;
use craft::missing::Missing;
use craft::pace::WORK_MAX;
use craft::parameters::Parameters;
use discovery::diagnose::{Diagnosis, EffectReport, Options, Verdict};
use discovery::evidence::diagnose;
use dynamics::description::Plant;
use identification::held_out::Status;
use identification::joint::JointUnknown;
use identification::problem::Problem;
use identification::work::Watch;
use telemetry::DiagnosisVerdict;

/// What the rows of an arc say that `plant` lacks, from the values `start` of the shared parameters
/// at which its own message ended: a verdict, effects, and the shared parameters beside them. Rows
/// that the plant cannot predict decide nothing, and leave the parameters where they were.
///
/// The start is no prior: values that made up for what is missing would cost the effect that is
/// right what they are off. `watch` sees the work, whose limit is [`WORK_MAX`], and stops it.
pub fn examined(
    plant: &Plant,
    recording: Option<Recording>,
    (parameters, start): (&Parameters, &[f64]),
    watch: &Watch,
) -> (DiagnosisVerdict, Vec<Missing>, Vec<f64>) {
    let problem = recording.and_then(|recording| Problem::new(plant, &[recording], &[]).ok());
    let at = parameters.unknowns.iter().zip(start).map(|(unknown, value)| (unknown.name.clone(), *value));
    let refused_at = Some(at.collect());
    // nothing here flies an experiment: `next_experiment` is off
    let options = Options {
        threads: 1,
        work_max: WORK_MAX,
        refused_at,
        next_experiment: false,
        watch: watch.clone(),
        ..Options::default()
    };
    let found = problem.map_or_else(
        || Diagnosis::cannot_decide("the rows were not kept".into()),
        |problem| diagnose(&problem, &options, &mut |_, _| {}),
    );
    let after = |(k, unknown): (usize, &JointUnknown)| {
        let own = found.nominal.iter().find(|own| own.name == unknown.name).map(|own| own.after);
        own.or(start.get(k).copied()).filter(|value| value.is_finite()).unwrap_or(unknown.prior)
    };
    let theta = parameters.unknowns.iter().enumerate().map(after).collect();
    (verdict(found.verdict), effects(&found), theta)
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
    let estimated = effect.parameters.iter().map(|p| (p.name.clone(), p.value, p.sigma));
    let kept = effect.kept.iter().map(|(name, value)| (name.clone(), *value, f64::NAN));
    Some(Missing {
        kind: effect.kind.clone(),
        site: effect.site.parse().ok()?,
        stands_in_for: None,
        probability: effect.probability,
        significance: effect.d,
        values: estimated.chain(kept).collect(),
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
        Verdict::CannotDecide => DiagnosisVerdict::CannotDecide,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use discovery::diagnose::ParameterReport;

    fn report(kind: &str, status: Status) -> EffectReport {
        let force = ParameterReport::inside("force".into(), (0.08, 0.001), "N*m".into());
        EffectReport {
            kind: kind.into(),
            title: String::new(),
            site: "joint:elbow".into(),
            probability: 1.0,
            status,
            rivals: Vec::new(),
            parameters: vec![force],
            kept: vec![("smooth_rate".into(), 4e-4)],
            kappa: 0.0,
            d: 9.0,
            evidence: None,
        }
    }

    fn named(effects: Vec<EffectReport>) -> Vec<Missing> {
        let found = Diagnosis { verdict: Verdict::Named, effects, ..Diagnosis::cannot_decide(String::new()) };
        super::effects(&found)
    }

    #[test]
    fn an_effect_that_data_reject_or_that_no_fit_ends_with_is_not_added() {
        let kinds = |effects: &[Missing]| effects.iter().map(|one| one.kind.clone()).collect::<Vec<_>>();
        let all = [
            report("joint_coulomb", Status::Unconfirmed),
            report("joint_viscous", Status::Rejected),
            report("joint_stribeck", Status::NotConverged),
        ];
        assert_eq!(kinds(&named(all.to_vec())), ["joint_coulomb"]);
        assert!(named(all[1..].to_vec()).is_empty());
    }

    #[test]
    fn what_the_fit_kept_travels_with_what_it_estimated() {
        let values = &named(vec![report("joint_coulomb", Status::Confirmed)])[0].values;
        assert_eq!(values[0], ("force".into(), 0.08, 0.001));
        assert!(values[1].0 == "smooth_rate" && values[1].1 == 4e-4 && values[1].2.is_nan(), "{values:?}");
    }
}
