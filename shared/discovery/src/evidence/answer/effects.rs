//! The effects of an answer: parameters, rivals, evidence.

use super::super::decide::Weighted;
use super::super::hypothesis::{Hypothesis, Part, name_of, unknown_of};
use super::super::model::Ground;
use super::super::onset::onset_estimates;
use super::{REPORTED, Shown};
use crate::diagnose::{EffectEvidence, EffectReport, ExtraParameterBound, ParameterReport, Rival, kept};
use dynamics::effect::Role;

impl Shown<'_> {
    /// A part of the leading model.
    pub(super) fn effect(&self, own: &Hypothesis, part: &Part) -> EffectReport {
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
            kept: kept(&self.leader().model.problem.plant, candidate),
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
                extra_parameter_bound: self.larger_laws(part),
            }),
        }
    }

    /// What the data leave of the laws that hold a part as their limit, fitted in its place.
    fn larger_laws(&self, part: &Part) -> Vec<ExtraParameterBound> {
        let own = &part.column.candidate;
        let all = self.pool.entries.iter().filter(|entry| entry.model.set.len() == self.leader().model.set.len());
        let mut list: Vec<ExtraParameterBound> = Vec::new();
        for entry in all {
            for child in entry.model.set.iter().flat_map(Hypothesis::parts).map(|part| &part.column.candidate) {
                let limit = child.effect.limits.iter().find(|limit| limit.kind == own.effect.kind);
                let Some(limit) = limit.filter(|_| child.site == own.site) else { continue };
                list.extend(limit.at.iter().filter_map(|(parameter, same_at)| {
                    let name = unknown_of(child, parameter);
                    let (model, fit) = (&entry.model, &entry.model.fit);
                    let at = model.problem.unknowns.iter().position(|unknown| unknown.parameter == name)?;
                    let (value, unknown) = (fit.theta[at], &model.problem.unknowns[at]);
                    Some(ExtraParameterBound {
                        kind: child.effect.kind.to_owned(),
                        parameter: (*parameter).to_owned(),
                        low: (value - 2.0 * fit.sigma[at]).max(unknown.low),
                        high: (value + 2.0 * fit.sigma[at]).min(unknown.high),
                        same_at: *same_at,
                        unit: unknown.unit.clone(),
                    })
                }));
            }
        }
        list
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
    /// `name`, be it as a limit.
    pub(super) fn rivals(&self, name: usize) -> Vec<Rival> {
        let holds = |model: &Weighted, name: usize| model.members.iter().any(|(_, own)| *own == name);
        let leading = &self.models[self.decision.leader];
        let mut list = Vec::new();
        for (other, text) in self.names.iter().enumerate().filter(|(other, _)| !holds(leading, *other)) {
            let is_apart = |model: &&Weighted| !holds(model, name) && !model.contains.contains(&name);
            let own = self.models.iter().filter(|model| holds(model, other)).filter(is_apart);
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
        let session = model.session(Ground { session: self.session });
        let found = session.and_then(|session| onset_estimates(&session, (&model.fit, &model.noise), candidate));
        let (times, sigma) = found.unwrap_or_else(|| (Vec::new(), model.fit.sigma.clone()));
        let own = model.problem.unknowns.iter().enumerate().filter(|(_, u)| u.parameter.starts_with(&prefix));
        let fitted = own.map(|(i, unknown)| ParameterReport {
            name: unknown.parameter[prefix.len()..].to_owned(),
            value: model.fit.theta[i],
            sigma: sigma[i],
            unit: unknown.unit.clone(),
            at_bound: !(unknown.low < model.fit.theta[i] && model.fit.theta[i] < unknown.high),
        });
        let period_s = self.session.timelines[0].period_s;
        let role = |name: &str| candidate.effect.parameter(name).map(|parameter| parameter.role);
        let all = candidate.inner.iter().filter(|(name, _)| matches!(role(name), Some(Role::Onset | Role::Duration)));
        let times = all.map(|(name, value)| {
            let found = times.iter().find(|found| found.name == *name);
            let (value, sigma) = found.map_or((*value, period_s), |found| (found.value, found.sigma));
            ParameterReport::inside((*name).to_owned(), (value, sigma), "s".to_owned())
        });
        fitted.chain(times).collect()
    }
}
