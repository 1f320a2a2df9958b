//! Effects of low significance that another recording confirms.
//!
//! An effect that one recording shows too weakly may be certain in another. Where no effect is
//! accepted and a recording is held out, the search is repeated at the higher level `s`. Its result
//! must be confirmed by data that had no part in it, all parameters frozen, at a level `q`. Where
//! no physics is unmodelled, and the frozen plant predicts as well as it is known, that happens
//! with probability `s q`, which is [`ALPHA_SHARE_CONFIRMED`] of alpha.

use super::held_out_selection::{HeldOutSelection, select_on_held_out};
use super::search::{SearchResult, searched};
use super::{ALPHA_SHARE_CONFIRMED, ALPHA_SHARE_IDENTIFIED, Options};
use crate::compete::FittedModel;
use crate::outline::Outline;
use examination::doctor::probability;
use identification::fit::{EstimationSession, Fit};
use identification::held_out::Status;
use identification::problem::Problem;

/// Level of the second search: probability that it finds an effect where none is missing. A larger
/// one needs a smaller level of confirmation; chosen, no derivation.
const SUSPICION_LEVEL: f64 = 0.1;

/// The effect of low significance and the held-out evidence, where held-out data confirm it; the
/// scores of the catalogue are those found on the recording `alone`.
///
/// Cost: a search without its scores, and a prediction of the held-out recording for each rival.
pub(super) fn confirmed(
    problem: &Problem,
    (session, stated): (&EstimationSession<'_>, &Fit),
    (nominal, alone): (&FittedModel, &SearchResult),
    (options, outline): (&Options, &mut Outline<'_>),
    notes: &mut Vec<String>,
) -> Option<(SearchResult, HeldOutSelection)> {
    let easier = Options {
        alpha: SUSPICION_LEVEL / ALPHA_SHARE_IDENTIFIED,
        terms_max: options.terms_max.min(1),
        ..options.clone()
    };
    let mut found = searched(session, (nominal.clone(), alone.screening.clone()), &easier, outline).ok()?;
    // Bonferroni over the rivals: the best of several confirmations occurs by chance more often
    let chances = 1 + found.rivals.len();
    let mut own = Vec::new();
    let selection = select_on_held_out(problem, (session, stated), &mut found, options, &mut own);
    let level = ALPHA_SHARE_CONFIRMED * options.alpha / SUSPICION_LEVEL / chances as f64;
    let gain = selection.evidence.gain.filter(|gain| gain.status() == Status::Confirmed)?;
    let p = found.adopted.first().filter(|_| gain.interval(2.0 * level)[0] > 0.0)?.p;
    notes.append(&mut own);
    notes.push(format!("suspected on this recording alone ({}); held-out data confirm it", probability(p)));
    Some((found, selection))
}
