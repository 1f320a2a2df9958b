//! A suspicion that another recording confirms.
//!
//! What one recording shows too weakly to be named may be there in another. Where nothing stands and a recording is held out, the search is taken
//! once more at the level `s` of a suspicion, and what it finds must be borne out by data that had no part in it, its numbers frozen, at a level
//! `q`: where nothing is missing, and the frozen plant predicts as well as it is known, that happens with probability `s q`, which is
//! [`CONFIRMED_SHARE`] of alpha.

use super::judged::{Judged, judged};
use super::search::{Found, searched};
use super::{CONFIRMED_SHARE, NAME_SHARE, Options, Standing};
use identification::fit::{EstimationSession, Fit};
use identification::held_out::Status;
use identification::problem::Problem;

/// Probability of a suspicion where nothing is missing.
const SUSPICION: f64 = 0.1;

/// The suspicion and what held-out data say of it, where they confirm it; the catalogue's scores are those that were found of the recording `alone`.
///
/// Cost: a search but for its scores, and a prediction of the held-out recording for each rival.
pub(super) fn confirmed(
    problem: &Problem,
    (session, stated): (&EstimationSession<'_>, &Fit),
    (nominal, alone): (&Standing, &Found),
    options: &Options,
    notes: &mut Vec<String>,
) -> Option<(Found, Judged)> {
    let easier = Options { alpha: SUSPICION / NAME_SHARE, terms_max: options.terms_max.min(1), ..options.clone() };
    let mut found = searched(session, (nominal.clone(), alone.screening.clone()), &easier, &mut |_, _| {}).ok()?;
    // the best of several confirmations is one by chance more often
    let chances = 1 + found.rivals.len();
    let mut own = Vec::new();
    let judged = judged(problem, (session, stated), &mut found, options, &mut own);
    let level = CONFIRMED_SHARE * options.alpha / SUSPICION / chances as f64;
    let gain = judged.shown.gain.filter(|gain| gain.status() == Status::Confirmed)?;
    let p = found.adopted.first().filter(|_| gain.interval(2.0 * level)[0] > 0.0)?.p;
    notes.append(&mut own);
    notes.push(format!("suspected of this recording alone (p = {p:.1e}); what was held out confirms it"));
    Some((found, judged))
}
