//! A pool of models as a diagnosis.

mod compares;
mod effects;
mod figures;
mod numbers;
mod reason;
mod relevant;

use super::alias::classes;
use super::decide::{Class, Decision, Weighted, decide, found_verdict};
use super::exact::Exact;
use super::horizon::Compared;
use super::hypothesis::{Hypothesis, name_of};
use super::law::{Kind, Law};
use super::model::{Ground, Model};
use super::pool::{Entry, Open, Pool};
use super::timing::shift_of;
use crate::diagnose::{
    Compare, Diagnosis, FittedModel, HeldOutEvidence, InputTiming, Next, OpenHypothesis, Options, Tried, Verdict,
    held_out,
};
use crate::score::Candidate;
use dynamics::description::Plant;
use dynamics::effect::{Effect, Role};
use identification::fit::{EstimationSession, NOT_FOUND_RATIO};
use identification::held_out::{Gain, Status};

use compares::Compares;

/// Weight below which a rival is left out of the report.
const REPORTED: f64 = 1e-3;

/// The names of all hypotheses in the pool: kind and site.
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
                members.push((own.class(), self.place(other_name(own, &model.problem.plant))));
            }
        }
        members
    }

    /// Places of the simpler laws that a model's laws contain as limits of their shape: one that
    /// begins at its own time says something else than one that is always there.
    fn contained(&mut self, model: &Model) -> Vec<usize> {
        let is_time = |effect: &Effect, name: &str| {
            effect.parameter(name).is_some_and(|own| matches!(own.role, Role::Onset | Role::Duration))
        };
        let of = |own: &Candidate| {
            let of_shape =
                own.effect.limits.iter().filter(|limit| !limit.at.iter().any(|(name, _)| is_time(own.effect, name)));
            of_shape.map(|limit| format!("{}@{}", limit.kind, own.site)).collect::<Vec<_>>()
        };
        let parts = model.set.iter().flat_map(Hypothesis::parts);
        parts.flat_map(|part| of(&part.column.candidate)).map(|name| self.place(name)).collect()
    }
}

/// Kind and site of what is no effect.
fn other_name(own: &Hypothesis, plant: &Plant) -> String {
    match own {
        Hypothesis::Conflict(name) | Hypothesis::Exact(Exact { name, .. }) => format!("parameter_conflict@{name}"),
        Hypothesis::Coloured(channel) => format!("coloured_noise@sensor:{}", plant.sensors[*channel].name),
        Hypothesis::Disturbance(_, name) => format!("unstated_disturbance@{name}"),
        Hypothesis::Timing(_) => "input_timing@inputs".to_owned(),
        Hypothesis::Effect(_) => own.key(plant),
    }
}

/// The whole answer; `law`: what no entry of the catalogue describes, beside the leading model.
pub(super) fn answered(
    session: &EstimationSession<'_>,
    pool: &Pool,
    law: Option<&Law>,
    (options, notes): (&Options, Vec<String>),
) -> Diagnosis {
    let weights = pool.weights();
    let mut names = Names { list: Vec::new() };
    let classes = classes(Ground { session }, pool, &weights);
    let models: Vec<Weighted> = (pool.entries.iter().zip(&weights).zip(classes))
        .map(|((entry, weight), class)| {
            let rank = rank(&entry.model);
            let (members, contains) = (names.members(&entry.model), names.contained(&entry.model));
            Weighted { members, contains, weight: *weight, rank, class }
        })
        .collect();
    let best = &pool.entries[pool.best()].model;
    let mut decision = decide(&models, names.list.len(), best.prior(session).is_off(&best.noise));
    let setting = (session, pool, options);
    let found = [Verdict::Named, Verdict::Sensor, Verdict::NotSeparable].contains(&decision.verdict);
    let most = decision.leader;
    let (place, unworthy) =
        if found { relevant::worthy(setting, decision.leader) } else { (decision.leader, Vec::new()) };
    if !unworthy.is_empty() {
        decision.leader = place;
        decision.verdict = found_verdict(&models[place].members, &decision.inclusion);
    }
    let quiet = pool.quiet();
    let [leader, bare] = [decision.leader, quiet].map(|place| &pool.entries[place]);
    let compares = Compares::new(setting, decision.leader);
    let (compared, left) = (compares.beside(bare), compares.beside(leader));
    // shifted inputs are no plant that could be carried over
    let is_alone = decision.leader == quiet || shift_of(&leader.model.set).is_some();
    let with = fitted_model(&leader.model);
    let unseen = held_out(session.problem, session, &bare.model.fit, &with, is_alone, options);
    let (models, names) = (&models[..], &names.list[..]);
    let (decision, worth) = (&decision, options.worth);
    let shown =
        Shown { session, pool, models, names, decision, most, quiet, law, compared, left, unseen, unworthy, worth };
    shown.diagnosis(notes)
}

/// Sum of the places of a model's laws in the catalogue.
fn rank(model: &Model) -> usize {
    let laws = model.set.iter().flat_map(Hypothesis::parts).map(|part| part.column.candidate.effect.kind);
    laws.map(|kind| model.problem.plant.catalogue.place(kind)).sum()
}

/// A set without a weight, as the answer lists it.
fn opened(open: &Open) -> OpenHypothesis {
    let why = open.why.to_owned();
    let members: Vec<String> = open.what.split(", ").flat_map(|own| own.split(" + ")).map(str::to_owned).collect();
    match &members[..] {
        [own] => {
            let (kind, site) = own.split_once('@').unwrap_or((own, ""));
            OpenHypothesis { kind: kind.to_owned(), site: site.to_owned(), members: Vec::new(), why }
        }
        _ => OpenHypothesis { kind: "set".to_owned(), site: String::new(), members, why },
    }
}

struct Shown<'a> {
    session: &'a EstimationSession<'a>,
    pool: &'a Pool,
    models: &'a [Weighted],
    names: &'a [String],
    decision: &'a Decision,
    /// The model of most weight, members that are not worth adding included.
    most: usize,
    /// The plant alone, or with noise that is not stated.
    quiet: usize,
    law: Option<&'a Law>,
    /// The leading model beside the plant alone, over a horizon: on held-out data, on the fitted
    /// ones where there are none.
    compared: Option<Compared>,
    /// The leading model beside itself: what it leaves.
    left: Option<Compared>,
    /// Another recording, or blocks of the fitted ones, predicted with frozen parameters.
    unseen: HeldOutEvidence,
    /// Members that are there and not worth adding.
    unworthy: Vec<String>,
    /// Share of the signal below which nothing is worth adding.
    worth: f64,
}

fn fitted_model(model: &Model) -> FittedModel {
    FittedModel::new(model.problem.clone(), model.fit.clone(), model.noise.clone())
}

impl Shown<'_> {
    fn leader(&self) -> &Entry {
        &self.pool.entries[self.decision.leader]
    }

    fn bare(&self) -> &Entry {
        &self.pool.entries[self.quiet]
    }

    fn verdict(&self) -> Verdict {
        let is_quiet = matches!(
            self.decision.verdict,
            Verdict::None | Verdict::NoiseModel | Verdict::ParameterConflict | Verdict::InputTiming
        );
        match self.law {
            Some(Law { kind: Kind::Instead { is_of_time: false } | Kind::Larger { is_of_time: false }, .. }) => {
                Verdict::NotInCatalogue
            }
            Some(Law { kind: Kind::Larger { is_of_time: true }, .. }) => Verdict::CannotDecide,
            Some(Law { kind: Kind::Instead { is_of_time: true }, .. }) if !is_quiet => Verdict::CannotDecide,
            // energy that no law takes up and that moves nothing beyond the noise is noise
            Some(Law { kind: Kind::Coloured | Kind::Instead { .. }, .. })
                if is_quiet && self.leaves_more_than_noise() =>
            {
                Verdict::CannotDecide
            }
            Some(Law { kind: Kind::Coloured | Kind::Outliers | Kind::Instead { .. }, .. })
                if self.decision.verdict == Verdict::None =>
            {
                Verdict::NoiseModel
            }
            _ if !is_quiet && self.is_irrelevant() => Verdict::None,
            // a misfit that noise does not explain, and laws that were not compared
            _ if self.is_unfinished() => Verdict::CannotDecide,
            _ => self.decision.verdict,
        }
    }

    /// Free runs of the leading model miss by more than its noise explains.
    fn leaves_more_than_noise(&self) -> bool {
        self.left.as_ref().is_some_and(|left| left.relevance().is_some())
    }

    /// Nothing is found, and the search ended before its end although something is left.
    fn is_unfinished(&self) -> bool {
        self.decision.verdict == Verdict::None && self.pool.is_unfinished && self.leaves_more_than_noise()
    }

    /// Free runs show a misfit that noise cannot explain, and the leading model too little of it.
    fn is_irrelevant(&self) -> bool {
        self.compared.as_ref().is_some_and(|compared| !compared.is_worth_adding(self.worth))
    }

    /// Names are reported, be it beside a law that is larger.
    fn has_effects(&self) -> bool {
        let named = [Verdict::Named, Verdict::Sensor, Verdict::NotSeparable];
        named.contains(&self.verdict()) || self.is_smaller() && named.contains(&self.decision.verdict)
    }

    /// The names have less evidence than what they leave.
    fn is_smaller(&self) -> bool {
        self.law.is_some_and(|law| matches!(law.kind, Kind::Larger { .. }))
    }

    /// On held-out recordings, where there are any; else on blocks of the fitted ones.
    fn gain(&self) -> Option<Gain> {
        let both = self.leader().held_out.as_ref().zip(self.bare().held_out.as_ref());
        both.map(|(own, bare)| own.gain(bare)).or(self.unseen.gain)
    }

    fn status(&self) -> Status {
        match self.gain() {
            // a name is not confirmed where the plant runs away with it
            Some(gain) if self.runs_worse() && gain.status() == Status::Confirmed => Status::Unconfirmed,
            Some(gain) if gain.free_run_diverges() && gain.status() == Status::Confirmed => Status::Unconfirmed,
            Some(gain) => gain.status(),
            None => Status::Unconfirmed,
        }
    }

    /// A channel of a held-out recording is further from the data than without the names.
    fn runs_worse(&self) -> bool {
        self.compared.as_ref().is_some_and(|compared| compared.sites.iter().any(|site| site.is_worse))
    }

    fn input_timing(&self) -> Vec<InputTiming> {
        let Some(shift_samples) = shift_of(&self.leader().model.set) else { return Vec::new() };
        let shifts = |model: &&Weighted| model.members.iter().any(|(class, _)| *class == Class::Timing);
        let probability = self.models.iter().filter(shifts).map(|model| model.weight).sum();
        vec![InputTiming { shift_samples, probability }]
    }

    fn diagnosis(&self, notes: Vec<String>) -> Diagnosis {
        let (session, bare) = (self.session, &self.bare().model);
        let mut diagnosis = Diagnosis::cannot_decide(self.reason());
        diagnosis.verdict = self.verdict();
        diagnosis.compare = Compare { channels: self.unseen.compare.clone() };
        diagnosis.notes = notes;
        if self.has_effects() {
            let parts = self.leader().model.set.iter().flat_map(|own| own.parts().iter().map(move |part| (own, part)));
            diagnosis.effects = parts.map(|(own, part)| self.effect(own, part)).collect();
        }
        let has_plant = self.has_effects() || self.verdict() == Verdict::ParameterConflict;
        if has_plant && self.status() == Status::Confirmed {
            diagnosis.augmented_plant = Some(plant_file::write(&self.posterior()));
        }
        let readings = |held_out: &super::predict::HeldOut| held_out.terms.times_s.len();
        let count = session.samples + self.leader().held_out.as_ref().map_or(0, readings);
        diagnosis.total_evidence = Some((self.pool.score(&self.pool.entries[self.most]), count));
        diagnosis.located = self.located();
        diagnosis.figures = self.figures();
        match self.next() {
            Next::NothingOpen => {}
            Next::Scenario(text) => diagnosis.next_experiment = Some(text),
            Next::Never(why) => diagnosis.notes.push(why),
        }
        diagnosis.nominal = self.nominal();
        diagnosis.held_out = self.held_out();
        let compared = self.compared.as_ref().filter(|_| self.decision.leader != self.quiet);
        let relevance = compared.and_then(Compared::relevance);
        diagnosis.relevance_percent = relevance.map(|share| 100.0 * share);
        diagnosis.notes.extend(self.horizon());
        diagnosis.input_timing = self.input_timing();
        diagnosis.detection_limits = self.limits();
        let ratios = bare.problem.unknowns.iter().zip(&bare.fit.ratio);
        let unseen = ratios.filter(|(_, ratio)| **ratio > NOT_FOUND_RATIO);
        diagnosis.not_found = unseen.map(|(unknown, _)| unknown.name.clone()).collect();
        diagnosis.open = self.pool.open.iter().map(opened).collect();
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
}
