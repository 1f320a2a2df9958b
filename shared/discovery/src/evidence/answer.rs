//! A pool of models as a diagnosis.

mod numbers;

use super::decide::{Class, Decision, Weighted, decide};
use super::hypothesis::{Hypothesis, Part, name_of, unknown_of};
use super::law::{Kind, Law};
use super::model::Model;
use super::pool::{Entry, Pool};
use crate::diagnose::{
    Compare, Diagnosis, EffectEvidence, EffectReport, OpenHypothesis, ParameterReport, Rival, Tried, Verdict,
};
use dynamics::effect::Role;
use identification::fit::{EstimationSession, NOT_FOUND_RATIO};
use identification::held_out::{Predictor, Status, free_run};

/// Weight below which a rival is left out of the report.
const REPORTED: f64 = 1e-3;

/// The names of all hypotheses in the pool: laws by kind and site, others by their keys.
struct Names {
    list: Vec<String>,
}

impl Names {
    fn place(&mut self, name: String) -> usize {
        self.list.iter().position(|own| *own == name).unwrap_or_else(|| {
            self.list.push(name);
            self.list.len() - 1
        })
    }

    /// Class and place of every member of a set; each site of a group is one.
    fn members(&mut self, model: &Model) -> Vec<(Class, usize)> {
        let mut members = Vec::new();
        for own in &model.set {
            if let Hypothesis::Effect(parts) = own {
                for part in parts {
                    members.push((own.class(), self.place(name_of(&part.column.candidate))));
                }
            } else {
                members.push((own.class(), self.place(own.key(&model.problem.plant))));
            }
        }
        members
    }
}

/// The whole answer; `law`: what no entry of the catalogue describes, beside the leading model.
pub(super) fn answered(
    session: &EstimationSession<'_>,
    pool: &Pool,
    law: Option<&Law>,
    notes: Vec<String>,
) -> Diagnosis {
    let weights = pool.weights();
    let mut names = Names { list: Vec::new() };
    let models: Vec<Weighted> = (pool.entries.iter().zip(&weights))
        .map(|(entry, weight)| {
            let rank = rank(&entry.model);
            Weighted { members: names.members(&entry.model), weight: *weight, rank }
        })
        .collect();
    let best = &pool.entries[pool.best()].model;
    let decision = decide(&models, names.list.len(), best.prior(session).is_off(&best.noise));
    let told = Told { session, pool, models: &models, names: &names.list, decision: &decision, law };
    told.diagnosis(notes)
}

/// Sum of the places of a model's laws in the catalogue.
fn rank(model: &Model) -> usize {
    let laws = model.set.iter().flat_map(Hypothesis::parts).map(|part| part.column.candidate.effect.kind);
    laws.map(|kind| model.problem.plant.catalogue.place(kind)).sum()
}

struct Told<'a> {
    session: &'a EstimationSession<'a>,
    pool: &'a Pool,
    models: &'a [Weighted],
    names: &'a [String],
    decision: &'a Decision,
    law: Option<&'a Law>,
}

impl Told<'_> {
    fn leader(&self) -> &Entry {
        &self.pool.entries[self.decision.leader]
    }

    fn bare(&self) -> &Entry {
        &self.pool.entries[0]
    }

    fn verdict(&self) -> Verdict {
        let is_quiet =
            matches!(self.decision.verdict, Verdict::None | Verdict::NoiseModel | Verdict::ParameterConflict);
        match self.law {
            Some(Law { kind: Kind::Instead, .. }) => Verdict::NotInCatalogue,
            Some(Law { kind: Kind::Coloured, .. }) if is_quiet => Verdict::CannotDecide,
            Some(Law { kind: Kind::Outliers, .. }) if is_quiet => Verdict::NoiseModel,
            _ => self.decision.verdict,
        }
    }

    fn has_effects(&self) -> bool {
        matches!(self.verdict(), Verdict::Named | Verdict::Sensor | Verdict::NotSeparable)
    }

    fn status(&self) -> Status {
        let gain = self.leader().held_out.as_ref().zip(self.bare().held_out.as_ref()).map(|(own, bare)| own.gain(bare));
        match gain {
            // a name is not confirmed where the plant runs away with it
            Some(gain) if gain.free_run_diverges() && gain.status() == Status::Confirmed => Status::Unconfirmed,
            Some(gain) => gain.status(),
            None => Status::Unconfirmed,
        }
    }

    fn diagnosis(&self, notes: Vec<String>) -> Diagnosis {
        let (session, bare) = (self.session, &self.bare().model);
        let mut diagnosis = Diagnosis::cannot_decide(self.reason());
        diagnosis.verdict = self.verdict();
        let nominal = Predictor { plant: &bare.problem.plant, theta: &bare.fit.theta, noise: &bare.noise };
        diagnosis.compare = Compare { channels: free_run(session, nominal) };
        diagnosis.notes = notes;
        if self.has_effects() {
            let parts = self.leader().model.set.iter().flat_map(|own| own.parts().iter().map(move |part| (own, part)));
            diagnosis.effects = parts.map(|(own, part)| self.effect(own, part)).collect();
            if self.status() == Status::Confirmed {
                diagnosis.augmented_plant = Some(plant_file::write(&self.posterior()));
            }
        }
        diagnosis.nominal = self.nominal();
        diagnosis.held_out = self.held_out();
        diagnosis.relevance_percent = self.shares().into_iter().reduce(f64::max).map(|share| 100.0 * share);
        diagnosis.detection_limits = self.limits();
        let ratios = bare.problem.unknowns.iter().zip(&bare.fit.ratio);
        let unseen = ratios.filter(|(_, ratio)| **ratio > NOT_FOUND_RATIO);
        diagnosis.not_found = unseen.map(|(unknown, _)| unknown.name.clone()).collect();
        diagnosis.open = self
            .pool
            .open
            .iter()
            .map(|open| {
                let (kind, site) = open.what.split_once('@').unwrap_or((&open.what, ""));
                OpenHypothesis { kind: kind.to_owned(), site: site.to_owned(), why: open.why.to_owned() }
            })
            .collect();
        diagnosis.tried = self
            .pool
            .looked
            .iter()
            .map(|own| Tried {
                kind: own.candidate.effect.kind.to_owned(),
                site: own.candidate.site.to_string(),
                chances: own.chances,
            })
            .collect();
        diagnosis
    }

    fn reason(&self) -> String {
        let leader = &self.leader().model;
        let key = leader.key();
        let odds = self.pool.log_odds(self.decision.leader);
        let beside = self.law.map_or(String::new(), |law| format!("; {}", law.words));
        let reason = match self.verdict() {
            Verdict::NotInCatalogue | Verdict::CannotDecide => {
                return self.law.map_or(String::new(), |law| law.words.clone());
            }
            Verdict::Named | Verdict::Sensor => {
                format!("{key}: {odds:.1} nats ahead of the plant alone, prior and multiplicity counted")
            }
            Verdict::NotSeparable => format!(
                "something is missing (probability {:.3}), and several laws explain it: {key} leads, {odds:.1} nats ahead of the plant alone",
                self.decision.found
            ),
            Verdict::ParameterConflict => format!("{key}: {odds:.1} nats ahead of the number as the file states it"),
            Verdict::NoiseModel => {
                format!("the noise is not as stated; no physics is missing beside it: {}", self.noise())
            }
            _ => "nothing is missing that this recording could show; see the detection limits".to_owned(),
        };
        format!("{reason}{beside}")
    }

    /// Fitted noise over stated, in words.
    fn noise(&self) -> String {
        let (noise, stated) = (&self.leader().model.noise, &self.session.noise);
        let sensors = self.session.problem.plant.sensors.iter().enumerate().map(|(i, sensor)| {
            let colour = if noise.pole[i] == 0.0 { String::new() } else { format!(", pole {:.2}", noise.pole[i]) };
            format!("{} x{:.2}{colour}", sensor.name, noise.sensor_sigma[i] / stated.sensor_sigma[i])
        });
        let inputs = self.session.noise_names.iter().enumerate();
        let stated_inputs = inputs.filter(|(i, _)| self.session.disturbance_sigma[*i].is_infinite());
        let inputs =
            stated_inputs.map(|(i, name)| format!("{name} x{:.2}", noise.input_sigma[i] / stated.input_sigma[i]));
        sensors.chain(inputs).collect::<Vec<_>>().join(", ")
    }

    fn effect(&self, own: &Hypothesis, part: &Part) -> EffectReport {
        let candidate = &part.column.candidate;
        let name = self.names.iter().position(|other| *other == name_of(candidate)).unwrap_or(0);
        let is_group = own.parts().len() > 1;
        EffectReport {
            kind: candidate.effect.kind.to_owned(),
            title: candidate.effect.title.to_owned(),
            site: candidate.site.to_string(),
            probability: self.decision.inclusion[name].min(1.0),
            status: self.status(),
            rivals: self.rivals(name),
            parameters: self.parameters(part),
            kappa: part.kappa,
            d: (2.0 * (self.leader().model.log_likelihood() - self.without(name))).max(0.0).sqrt(),
            evidence: Some(EffectEvidence {
                log_evidence: self.pool.log_odds(self.decision.leader),
                free_run_share_percent: self.shares().into_iter().map(|share| 100.0 * share).collect(),
                family: candidate.effect.family.name().to_owned(),
                group: if is_group {
                    own.parts().iter().map(|p| p.column.candidate.site.to_string()).collect()
                } else {
                    Vec::new()
                },
            }),
        }
    }

    /// Greatest log-likelihood of the models that lack a name and hold no more than the leader.
    fn without(&self, name: usize) -> f64 {
        let most = self.leader().model.set.len();
        let lacks =
            self.pool.entries.iter().zip(self.models).filter(|(entry, model)| {
                entry.model.set.len() < most && model.members.iter().all(|(_, own)| *own != name)
            });
        lacks.map(|(entry, _)| entry.model.log_likelihood()).fold(self.bare().model.log_likelihood(), f64::max)
    }

    /// Names outside the leading model, with the weight of the models that hold them and lack
    /// `name`.
    fn rivals(&self, name: usize) -> Vec<Rival> {
        let holds = |model: &Weighted, name: usize| model.members.iter().any(|(_, own)| *own == name);
        let leading = &self.models[self.decision.leader];
        let mut list = Vec::new();
        for (other, text) in self.names.iter().enumerate().filter(|(other, _)| !holds(leading, *other)) {
            let own = self.models.iter().filter(|model| holds(model, other) && !holds(model, name));
            let weight: f64 = own.map(|model| model.weight).sum();
            let Some((kind, site)) = text.split_once('@').filter(|_| weight > REPORTED) else { continue };
            list.push(Rival {
                kind: kind.to_owned(),
                site: site.to_owned(),
                probability: weight,
                reason: format!("sets with it and without the other have {:.1} % of the posterior", 100.0 * weight),
            });
        }
        list.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        list
    }

    fn parameters(&self, part: &Part) -> Vec<ParameterReport> {
        let model = &self.leader().model;
        let candidate = &part.column.candidate;
        let prefix = unknown_of(candidate, "");
        let own = model.problem.unknowns.iter().enumerate().filter(|(_, u)| u.parameter.starts_with(&prefix));
        let fitted = own.map(|(i, unknown)| ParameterReport {
            name: unknown.parameter[prefix.len()..].to_owned(),
            value: model.fit.theta[i],
            sigma: model.fit.sigma[i],
            unit: unknown.unit.clone(),
        });
        let period_s = self.session.timelines[0].period_s;
        let role = |name: &str| candidate.effect.parameter(name).map(|parameter| parameter.role);
        let times = candidate.inner.iter().filter(|(name, _)| matches!(role(name), Some(Role::Onset | Role::Duration)));
        let times = times.map(|(name, value)| ParameterReport {
            name: (*name).to_owned(),
            value: *value,
            sigma: period_s,
            unit: "s".to_owned(),
        });
        fitted.chain(times).collect()
    }
}
