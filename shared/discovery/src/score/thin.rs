//! Grids of shape parameters within the work.

use super::Candidate;
use dynamics::description::Plant;
use identification::fit::EstimationSession;

/// Share of all work for the grid points. Chosen, no derivation.
const GRID_WORK_SHARE: f64 = 0.04;

/// Bounds the work about `plant` at `theta`: every law stays, points of its grid are dropped.
pub(crate) fn thin(session: &EstimationSession<'_>, (plant, theta): (&Plant, &[f64]), list: &mut Vec<Candidate>) {
    let passes: usize = list.iter().map(|candidate| candidate.directions.len()).sum();
    let keep = session.work.affords(GRID_WORK_SHARE, session.pass_work(plant, theta)) / passes.max(1) as f64;
    if keep >= 1.0 {
        return;
    }
    session.work.leave_out("points of grids");
    let mut last: Option<Candidate> = None;
    let mut count = 0.0;
    list.retain(|candidate| {
        let fresh = last.as_ref().is_none_or(|last| !last.same_law(candidate));
        if fresh {
            last = Some(candidate.clone());
        }
        count += keep;
        let due = count >= 1.0;
        count -= if due { 1.0 } else { 0.0 };
        fresh || due
    });
}
