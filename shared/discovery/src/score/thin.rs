//! Grids of shape parameters within the work.

use super::Candidate;
use dynamics::description::Plant;
use dynamics::effect::Law;
use identification::fit::EstimationSession;

/// Share of all work for the grid points. Chosen, no derivation.
const GRID_WORK_SHARE: f64 = 0.06;
/// Passes that a direction takes, about: of a law whose reading alone changes, of one that forces
/// the linear model, of one that is run at a few amplitudes.
const READING_PASSES: f64 = 0.25;
const FORCED_PASSES: f64 = 0.5;
const RUN_PASSES: f64 = 1.5;

/// Bounds the work about `plant` at `theta`: every law stays, and has as many points of its grid as
/// any other one, or all of them.
pub(crate) fn thin(session: &EstimationSession<'_>, (plant, theta): (&Plant, &[f64]), list: &mut Vec<Candidate>) {
    let room = session.work.affords(GRID_WORK_SHARE, session.pass_work(plant, theta));
    let laws: Vec<f64> = list.chunk_by(|a, b| a.same_law(b)).map(|points| points.iter().map(passes).sum()).collect();
    if laws.iter().sum::<f64>() <= room {
        return;
    }
    session.work.leave_out("points of grids");
    let most = fair(&laws, room);
    let keep: Vec<f64> = laws.iter().map(|own| (most / own).min(1.0)).collect();
    let (mut law, mut count) = (0, 0.0);
    let mut last: Option<Candidate> = None;
    list.retain(|candidate| {
        let fresh = last.as_ref().is_none_or(|last| !last.same_law(candidate));
        if fresh {
            (law, count) = (law + usize::from(last.is_some()), 0.0);
            last = Some(candidate.clone());
        }
        count += keep[law];
        let due = count >= 1.0;
        count -= if due { 1.0 } else { 0.0 };
        fresh || due
    });
}

fn passes(candidate: &Candidate) -> f64 {
    let each = match candidate.effect.law {
        Law::Sensor(_) => READING_PASSES,
        Law::Coordinate(_) | Law::Body(_) | Law::Actuator(_) if candidate.effect.hidden_states == 0 => FORCED_PASSES,
        _ => RUN_PASSES,
    };
    each * candidate.directions.len() as f64
}

/// The size to which larger ones are cut so that all together have `room`.
fn fair(sizes: &[f64], room: f64) -> f64 {
    let mut sorted = sizes.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut left = room;
    for (place, size) in sorted.iter().enumerate() {
        let each = left / (sorted.len() - place) as f64;
        if *size > each {
            return each;
        }
        left -= size;
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::fair;

    #[test]
    fn large_grids_are_cut_to_one_size_and_small_ones_stay_whole() {
        let sizes = [3.0, 100.0, 1.0, 40.0];
        let most = fair(&sizes, 44.0);
        assert_eq!(most, 20.0);
        assert_eq!(sizes.iter().map(|size| size.min(most)).sum::<f64>(), 44.0);
        assert_eq!(fair(&sizes, 1e3), f64::INFINITY);
    }
}
