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
const SCREEN_ROUNDS: f64 = 55.0;
const RANK_ROUNDS: f64 = 9.0;
/// A set of effects compared; the fits that complete the best one and its next rivals, in sets.
pub(crate) const SET_ROUNDS: f64 = 17.0;
pub(crate) const COMPLETION_SETS: f64 = 4.0;
/// Sets of a shortlist where an effect is missing.
const SHORTLIST_SETS: f64 = 5.0;
/// A prediction of other data; of parts of the recording itself.
const HELD_OUT_ROUNDS: f64 = 11.0;
const BLOCKS_ROUNDS: f64 = 2.0;
/// One-parameter laws in the place of a set.
const LAW_ROUNDS: f64 = 19.0;
const UNKNOWN_LAW_ROUNDS: f64 = 7.0;
/// An entry of the menu of experiments, and their usual number.
const EXPERIMENT_ROUNDS: f64 = 10.0;
const MENU: f64 = 10.0;
/// Channel metadata that are right, per problem.
const LABEL_ROUNDS: f64 = 12.0;
/// The same of a set that is fitted with its noise and sharper signs, before any is known.
pub const FITTED_SET_ROUNDS: f64 = 4.0 * SET_ROUNDS;
/// An expansion of a set of hypotheses without its fits, and their usual number.
const EXPANSION_ROUNDS: f64 = 52.0;
const PROPOSALS: f64 = 8.1;
/// How much of a search for an effect is planned for before anything is known, where the noise is
/// as stated, where it is not, and of a further round.
const UNKNOWN: f64 = 0.5;
const AS_STATED: f64 = 0.05;
const NOT_AS_STATED: f64 = 0.7;
const FURTHER: f64 = 0.25;
/// p value of the noise from which it counts as stated.
const NOISE_LEVEL: f64 = 0.01;

/// Planned work of the check of the channel metadata and of the search, of which nothing is known
/// but the size of the problem; `None` for a problem that no plant follows.
#[must_use]
pub fn planned(problem: &Problem, held_out: Option<&Problem>) -> Option<[f64; 2]> {
    let of = |problem: &Problem| Some(EstimationSession::new(problem, 1).ok()?.round_work());
    let (own, other) = (of(problem)?, held_out.and_then(of));
    let search: f64 = before(other.is_some()).iter().sum();
    Some([LABEL_ROUNDS * (own + other.unwrap_or(0.0)), own * search])
}

/// Rounds of the phases before anything is known.
fn before(has_held_out: bool) -> [f64; Phase::COUNT] {
    let mut rest = [0.0; Phase::COUNT];
    let mut set = |phase: Phase, rounds: f64| rest[phase as usize] = rounds;
    let compare = RANK_ROUNDS + UNKNOWN * (SHORTLIST_SETS + COMPLETION_SETS) * SET_ROUNDS;
    set(Phase::Fit, FIT_ROUNDS);
    set(Phase::Noise, NOISE_ROUNDS);
    set(Phase::Score, SCREEN_ROUNDS);
    set(Phase::Compare, compare);
    set(Phase::SearchAgain, UNKNOWN * (SCREEN_ROUNDS + RANK_ROUNDS));
    set(Phase::HeldOut, if has_held_out { HELD_OUT_ROUNDS } else { BLOCKS_ROUNDS });
    set(Phase::OneParameterLaw, UNKNOWN * LAW_ROUNDS);
    set(Phase::UnknownLaw, UNKNOWN_LAW_ROUNDS);
    rest
}

/// What a round of the search has found, as far as what follows depends on it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    pub adopted: usize,
    /// Another round follows.
    pub goes_on: bool,
    /// Sets that held-out data may prefer.
    pub others: usize,
    /// Entries of the menu of experiments, where one is needed.
    pub experiments: usize,
}

/// The plan of one diagnosis.
pub(crate) struct Outline<'a> {
    progress: &'a mut dyn FnMut(Phase, f64),
    work: Arc<Work>,
    round: f64,
    /// Work of the phases that are not done.
    rest: [f64; Phase::COUNT],
    /// Work at the beginning of each phase that was met last.
    begun: [f64; Phase::COUNT],
    has_held_out: bool,
    /// Phases are those of a part: none is said.
    is_within: bool,
}

impl<'a> Outline<'a> {
    pub fn new(session: &EstimationSession<'_>, has_held_out: bool, progress: &'a mut dyn FnMut(Phase, f64)) -> Self {
        let round = session.round_work();
        let rest = before(has_held_out).map(|rounds| round * rounds);
        let begun = [0.0; Phase::COUNT];
        Self { progress, work: session.work.clone(), round, rest, begun, has_held_out, is_within: false }
    }

    /// `phase` begins: what was planned for it is done now, for earlier ones nothing is left.
    pub fn begin(&mut self, phase: Phase) {
        self.begun[phase as usize] = self.work.spent();
        if self.is_within {
            return;
        }
        let now = core::mem::take(&mut self.rest[phase as usize]);
        let is_of_round = matches!(phase, Phase::Score | Phase::Compare);
        let passed = if is_of_round { Phase::Score as usize } else { phase as usize };
        self.rest[..passed].fill(0.0);
        let room = (self.work.until(1.0) - self.work.spent()).max(0.0);
        let search = [Phase::Score, Phase::Compare, Phase::SearchAgain, Phase::LowSignificance];
        let of_search: f64 = search.iter().map(|phase| self.rest[*phase as usize]).sum();
        let all: f64 = self.rest.iter().sum();
        self.work.plan(now, all - of_search + of_search.min(room));
        (self.progress)(phase, self.work.share_planned());
    }

    /// The noise of the nominal plant has the p value `p` as stated: whether an effect is likely.
    pub fn noise_found(&mut self, p: f64) {
        let likely = if p > NOISE_LEVEL { AS_STATED } else { NOT_AS_STATED };
        let sets = (SHORTLIST_SETS + COMPLETION_SETS) * SET_ROUNDS;
        self.rest[Phase::Compare as usize] = self.round * (RANK_ROUNDS + likely * sets);
        self.rest[Phase::SearchAgain as usize] = self.round * likely * (SCREEN_ROUNDS + RANK_ROUNDS);
        self.rest[Phase::OneParameterLaw as usize] = self.round * likely * LAW_ROUNDS;
        self.rest[Phase::Report as usize] = self.round * likely * FURTHER * MENU * EXPERIMENT_ROUNDS;
    }

    /// A round of the search has ended with all of `found`.
    pub fn round_ended(&mut self, found: &Found) {
        let Found { adopted, goes_on, others, experiments } = *found;
        let [score, compare, end] =
            [self.begun[Phase::Score as usize], self.begun[Phase::Compare as usize], self.work.spent()];
        let round = self.round;
        let mut set = |phase: Phase, work: f64| self.rest[phase as usize] = work;
        set(Phase::Score, if goes_on { compare - score } else { 0.0 });
        set(Phase::Compare, if goes_on { round * RANK_ROUNDS + FURTHER * (end - compare) } else { 0.0 });
        let earlier = adopted.saturating_sub(1) as f64;
        set(Phase::SearchAgain, FURTHER * earlier * (end - score));
        let each = if self.has_held_out { HELD_OUT_ROUNDS } else { BLOCKS_ROUNDS };
        let parts = if adopted > 1 { 2 * adopted } else { 0 };
        set(Phase::HeldOut, round * each * (1 + others + parts) as f64);
        let again = RANK_ROUNDS + UNKNOWN * SHORTLIST_SETS * SET_ROUNDS;
        set(Phase::LowSignificance, if adopted == 0 && self.has_held_out { round * again } else { 0.0 });
        let laws = if adopted > 1 { 1 + 2 * adopted } else { adopted };
        set(Phase::OneParameterLaw, round * LAW_ROUNDS * laws as f64);
        set(Phase::Report, round * EXPERIMENT_ROUNDS * experiments as f64);
    }

    /// Another search is a part of the phase that was begun.
    pub fn within<T>(&mut self, look: impl FnOnce(&mut Self) -> T) -> T {
        self.is_within = true;
        let found = look(self);
        self.is_within = false;
        found
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
