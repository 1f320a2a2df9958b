//! Planned work of a diagnosis: what its parts cost, from what is known of them so far.
//!
//! The unit is a round, one relinearisation of the nominal plant with its normal equations: its
//! cost is known before anything is computed, and what a part costs in rounds differs little from
//! plant to plant. A part that was met costs as much again; what the search may still spend bounds
//! what is planned for it.

use crate::diagnose::Phase;
use identification::fit::EstimationSession;
use identification::problem::Problem;
use identification::work::Work;
use std::sync::Arc;

/// Rounds that a part costs: medians over sealed cases of its own seed and the examples, rounded.
/// They move no answer.
const FIT_ROUNDS: f64 = 9.0;
const NOISE_ROUNDS: f64 = 10.0;
/// A set of effects compared, most of which end at their first fit; one that is fitted with its
/// noise and sharper signs, before any is known.
const SET_ROUNDS: f64 = 17.0;
pub(crate) const FITTED_SET_ROUNDS: f64 = 4.0 * SET_ROUNDS;
/// An expansion of a set of hypotheses without its fits, and the usual number of sets it proposes.
const EXPANSION_ROUNDS: f64 = 52.0;
const PROPOSALS: f64 = 8.1;
const UNKNOWN_LAW_ROUNDS: f64 = 7.0;
/// Channel metadata that are right, per problem.
const LABEL_ROUNDS: f64 = 12.0;
/// Share of the sets that an expansion proposes which is planned for before one is known, and of a
/// further expansion.
const UNKNOWN: f64 = 0.5;
const FURTHER: f64 = 0.25;

/// Planned work of the check of the channel metadata and of the search, of which nothing is known
/// but the size of the problem; `None` for a problem that no plant follows.
#[must_use]
pub fn planned(problem: &Problem, held_out: Option<&Problem>) -> Option<[f64; 2]> {
    let of = |problem: &Problem| Some(EstimationSession::new(problem, 1).ok()?.round_work());
    let (own, other) = (of(problem)?, held_out.and_then(of));
    let search: f64 = before().iter().sum();
    Some([LABEL_ROUNDS * (own + other.unwrap_or(0.0)), own * search])
}

/// Rounds of the phases before anything is known.
fn before() -> [f64; Phase::COUNT] {
    let mut rest = [0.0; Phase::COUNT];
    let mut set = |phase: Phase, rounds: f64| rest[phase as usize] = rounds;
    set(Phase::Fit, FIT_ROUNDS);
    set(Phase::Noise, NOISE_ROUNDS);
    set(Phase::Compare, EXPANSION_ROUNDS + UNKNOWN * PROPOSALS * SET_ROUNDS);
    set(Phase::UnknownLaw, UNKNOWN_LAW_ROUNDS);
    rest
}

/// The plan of one diagnosis.
pub(crate) struct Outline<'a> {
    progress: &'a mut dyn FnMut(Phase, f64),
    work: Arc<Work>,
    round: f64,
    /// Work of the phases that are not done.
    rest: [f64; Phase::COUNT],
}

impl<'a> Outline<'a> {
    pub fn new(session: &EstimationSession<'_>, progress: &'a mut dyn FnMut(Phase, f64)) -> Self {
        let round = session.round_work();
        Self { progress, work: session.work.clone(), round, rest: before().map(|rounds| round * rounds) }
    }

    /// `phase` begins: what was planned for it is done now, for earlier ones nothing is left.
    pub fn begin(&mut self, phase: Phase) {
        let now = core::mem::take(&mut self.rest[phase as usize]);
        self.rest[..phase as usize].fill(0.0);
        let room = (self.work.until(1.0) - self.work.spent()).max(0.0);
        let search = self.rest[Phase::Compare as usize];
        let all: f64 = self.rest.iter().sum();
        self.work.plan(now, all - search + search.min(room));
        (self.progress)(phase, self.work.share_planned());
    }

    /// The `k`th expansion of a pool begins, of which the dearest cost `dearest` so far; `open`
    /// others stand to be expanded.
    pub fn expansion(&mut self, k: usize, dearest: f64, open: usize) {
        let first = self.round * EXPANSION_ROUNDS;
        let others = open as f64;
        let after = match k {
            0 => self.round * UNKNOWN * PROPOSALS * SET_ROUNDS + others * first,
            _ => others.max(FURTHER) * dearest,
        };
        let room = (self.work.until(1.0) - self.work.spent()).max(0.0);
        self.work.plan(if k == 0 { first } else { dearest }, after.min(room) + self.round * UNKNOWN_LAW_ROUNDS);
    }
}
