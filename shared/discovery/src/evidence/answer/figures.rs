//! Where the evidence of an answer lies, its figures, and the experiment that would decide.

use super::Shown;
use crate::diagnose::{Figures, Next, Rival, Verdict, Where, curve, place_of, separating, tiles};
use crate::evidence::decide::LEVEL;
use crate::evidence::hypothesis::{Hypothesis, Part, name_of};
use crate::evidence::model::{Ground, Model};
use dynamics::effect::Role;
use identification::filter::NoiseModel;
use identification::held_out::instants;

impl Shown<'_> {
    /// Whitened innovations of a model under `noise`.
    fn white(&self, model: &Model, noise: &NoiseModel) -> Option<Vec<f64>> {
        let session = model.session(Ground { session: self.session })?;
        Some(instants(&session, &model.fit.linearised.linears, noise)?.1)
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        self.leader().model.set.iter().flat_map(Hypothesis::parts)
    }

    /// Of the names together, beside the plant alone; of a law or a bin that no name takes up.
    pub(super) fn located(&self) -> Vec<Where> {
        let names = if self.has_effects() { self.place_of_names() } else { None };
        names.into_iter().chain(self.law.map(|law| law.place.clone())).collect()
    }

    fn place_of_names(&self) -> Option<Where> {
        let (bare, leader) = (&self.bare().model, &self.leader().model);
        let (before, after) = (self.white(bare, &leader.noise)?, self.white(leader, &leader.noise)?);
        let change: Vec<f64> = before.iter().zip(&after).map(|(before, after)| before - after).collect();
        let first = &self.parts().next()?.column.candidate;
        let probability =
            self.names.iter().position(|name| *name == name_of(first)).map(|at| self.decision.inclusion[at]);
        let site = (first.site.to_string(), (1.0 - probability.unwrap_or(0.0)).max(0.0));
        let mut place = place_of(self.session, &change, &before, site)?;
        let time = |role: Role| {
            let name = first.effect.with_role(role)?.name;
            first.inner.iter().find(|(own, _)| *own == name).map(|(_, value)| *value)
        };
        if let (Some(begin), Some(duration)) = (time(Role::Onset), time(Role::Duration)) {
            place.time = [begin, (begin + duration).min(place.time[1].max(begin))];
        }
        Some(place)
    }

    pub(super) fn figures(&self) -> Figures {
        let (bare, leader) = (&self.bare().model, &self.leader().model);
        let noises = (self.white(bare, &bare.noise), self.white(leader, &leader.noise));
        let (Some(before), Some(after)) = noises else { return Figures::default() };
        // evidence under one noise: a gain by noise of higher variance is not evidence
        let fair = self.white(bare, &leader.noise).unwrap_or_else(|| before.clone());
        let joined = |of: &dyn Fn(&Part) -> String| self.parts().map(of).collect::<Vec<_>>().join(" + ");
        let kinds = joined(&|part| part.column.candidate.effect.kind.to_owned());
        let sites = joined(&|part| part.column.candidate.site.to_string());
        let shown = self.has_effects();
        Figures {
            tiles: tiles(self.session, &before, &after),
            evidence: curve(self.session, (&fair, &after), &[kinds, sites]).filter(|_| shown).into_iter().collect(),
            law_maps: self.law.and_then(|law| law.map.clone()).into_iter().collect(),
            overlays: if shown { self.unseen.overlays.clone() } else { Vec::new() },
            ..Figures::default()
        }
    }

    /// The experiment that separates the least sure name from its strongest rival.
    pub(super) fn next(&self) -> Next {
        if self.verdict() != Verdict::NotSeparable {
            return Next::NothingOpen;
        }
        let place = |part: &Part| self.names.iter().position(|name| *name == name_of(&part.column.candidate));
        let sure = |part: &&Part| place(part).map_or(1.0, |at| self.decision.inclusion[at]);
        let open = self.parts().filter(|part| sure(part) < LEVEL).min_by(|a, b| sure(a).total_cmp(&sure(b)));
        let Some(first) = open else { return Next::NothingOpen };
        let all = || self.pool.entries.iter().flat_map(|entry| entry.model.set.iter().flat_map(Hypothesis::parts));
        let is_of = |rival: &Rival, part: &Part| {
            let own = &part.column.candidate;
            own.effect.kind == rival.kind && own.site.to_string() == rival.site
        };
        let rivals = place(first).map_or(Vec::new(), |at| self.rivals(at));
        let second = rivals.iter().find_map(|rival| all().find(|part| is_of(rival, part)));
        let Some(second) = second else { return Next::NothingOpen };
        let (own, amplitude) = (&first.column.candidate, &first.amplitude[..]);
        separating(self.session, &self.posterior(), (own, amplitude), &second.column.candidate)
    }
}
