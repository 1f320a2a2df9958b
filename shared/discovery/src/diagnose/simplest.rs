//! The simplest law of a family that holds carries the name.
//!
//! A law that contains another one as its limit ([`Effect::limits`]) explains at least as much, and
//! its fit may end on the flank of the simpler one. The limit of every adopted effect is therefore
//! fitted to its end from where the effect itself ended, and takes its place unless BIC prefers the
//! larger law.
//!
//! [`Effect::limits`]: dynamics::effect::Effect::limits

use super::Adopted;
use super::search::SearchResult;
use crate::compete::{FittedModel, free_parameters, settled};
use crate::score::Candidate;
use dynamics::effect::Limit;
use identification::fit::{EstimationSession, fit};

/// Relinearisations of the simpler law before its noise is adapted: one parameter of many has
/// moved.
const LIMIT_ROUNDS: usize = 6;

impl SearchResult {
    /// Gives every adopted effect the name of the simplest law that holds.
    ///
    /// Cost: a fit to its end for each limit of each adopted effect.
    pub(super) fn simplify(&mut self, session: &EstimationSession<'_>) {
        for place in 0..self.adopted.len() {
            let limits = self.adopted[place].column.candidate.effect.limits;
            for limit in limits.iter().filter(|_| !session.work.is_stopped()) {
                if let Some((adopted, model, ahead)) = self.simpler(session, place, limit) {
                    self.rivals.iter_mut().for_each(|(.., behind)| *behind += ahead);
                    (self.adopted[place], self.best) = (adopted, model);
                    break;
                }
            }
        }
    }

    /// The effect at `place` as its `limit`, with the fit and how far that is ahead by BIC; `None`
    /// where the larger law is.
    fn simpler(
        &self,
        session: &EstimationSession<'_>,
        place: usize,
        limit: &Limit,
    ) -> Option<(Adopted, FittedModel, f64)> {
        let gone = &self.adopted[place];
        let own = &gone.column.candidate;
        let is_limit = |c: &Candidate| c.effect.kind == limit.kind && c.site == own.site;
        let is_taken = self.adopted.iter().any(|other| is_limit(&other.column.candidate));
        let columns = self.screening.columns.iter().enumerate().filter(|(_, c)| is_limit(&c.candidate) && !is_taken);
        let (score, column) = columns.filter_map(|(at, column)| Some((self.screening.score(at)?, column))).next()?;
        let model = self.as_limit(session, own, limit)?;
        let free = free_parameters(&column.candidate, column.raw.len());
        let fewer = gone.parameter_count() - free as f64;
        let free = (self.best.free + free).saturating_sub(gone.parameter_count() as usize);
        let model = FittedModel { free, ..model.merged() };
        let lost = model.objective - self.best.objective;
        let ahead = libm::log(session.samples.max(2) as f64) * fewer - lost;
        let (column, score) = (column.clone(), score.clone());
        let d = (gone.d * gone.d - lost).max(0.0).sqrt();
        let new = Adopted { column, score, p: gone.p, d, weight: 1.0, rivals: Vec::new() };
        (ahead >= 0.0).then(|| (new.beside(gone, ahead), model, ahead))
    }

    /// The accepted model with the effect of `own` as its `limit`, fitted to its end.
    fn as_limit(&self, session: &EstimationSession<'_>, own: &Candidate, limit: &Limit) -> Option<FittedModel> {
        let mut plant = self.best.plant.clone();
        let simple = plant.catalogue.effect(limit.kind)?;
        let used = plant.effects.iter_mut().find(|used| used.kind == own.effect.kind && used.site == own.site)?;
        used.kind = limit.kind.to_owned();
        used.values.retain(|(name, _)| simple.parameter(name).is_some());
        let problem = session.problem.with_plant(&plant);
        let like = EstimationSession::like(session, &problem).ok()?;
        let of = |kind: &str| format!("effect.{kind}@{}.", own.site);
        let (before, after) = (of(own.effect.kind), of(limit.kind));
        let value = |name: &str| {
            let name = name.replacen(&after, &before, 1);
            let at = self.best.problem.unknowns.iter().position(|unknown| unknown.name == name)?;
            Some(self.best.fit.theta[at])
        };
        let unknowns = &problem.unknowns;
        let theta: Vec<f64> = unknowns.iter().map(|u| value(&u.name).unwrap_or(u.prior).clamp(u.low, u.high)).collect();
        let fitted = fit(&like, &plant, &theta, &self.best.noise, LIMIT_ROUNDS).ok()?;
        drop(like);
        let (noise, objective) = (self.best.noise.clone(), f64::INFINITY);
        let start = FittedModel::new(problem, fitted, noise, objective);
        Some(settled(session, start))
    }
}

#[cfg(test)]
mod tests {
    use super::super::screening::screen;
    use super::super::{Options, standing};
    use super::*;
    use crate::compete::refit_all;
    use crate::synthetic::{plant, problem, recording, with_effect};
    use std::rc::Rc;

    /// What Stribeck friction, adopted where `hidden` acts in a drive, is called in the end, and its
    /// rivals.
    fn called(hidden: &str, values: &[(&str, f64)]) -> (&'static str, Vec<&'static str>) {
        let nominal = plant("drive_rig");
        let truth = with_effect(&nominal, hidden, "joint:drive", values);
        let problem = problem(&nominal, recording(&truth, 5, 4.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let stated = fit(&session, &nominal, &session.prior(), &session.noise, LIMIT_ROUNDS).unwrap();
        let bare = standing(&session, &stated).unwrap();
        let screening = Rc::new(screen(&session, &bare, &Options::default()));
        let is_stribeck = |at: &usize| screening.columns[*at].candidate.effect.kind == "joint_stribeck";
        let score = |at: usize| Some((at, screening.score(at)?));
        let (at, score) = (0..screening.columns.len()).filter(is_stribeck).find_map(score).unwrap();
        let column = &screening.columns[at];
        let good = f64::NEG_INFINITY;
        let refit = refit_all(&session, &bare.fit, &[(column, &score.amplitude)], &bare.noise, good).unwrap();
        let mut found = SearchResult::nominal(settled(&session, refit), screening.clone());
        let (column, score) = (column.clone(), score.clone());
        found.adopted.push(Adopted { column, score, p: 1e-9, d: 50.0, weight: 1.0, rivals: Vec::new() });
        found.simplify(&session);
        let named = &found.adopted[0];
        let name = named.column.candidate.effect.kind;
        assert_eq!(found.best.plant.effects[0].kind, name);
        (name, named.rivals.iter().map(|rival| rival.kind).collect())
    }

    #[test]
    fn the_limit_of_a_larger_law_takes_its_name_where_it_explains_as_much() {
        let (name, rivals) = called("joint_coulomb", &[("force", 0.3)]);
        assert!(name == "joint_coulomb" && rivals.iter().all(|rival| *rival == "joint_stribeck"), "{name} {rivals:?}");
    }

    #[test]
    fn a_larger_law_that_explains_more_keeps_its_name() {
        let (name, _) = called("joint_stribeck", &[("force", 0.3), ("stribeck_rate", 0.15)]);
        assert_eq!(name, "joint_stribeck");
    }
}
