//! The last hypothesis: a law that no entry of the catalogue describes.

use super::decide::LEVEL;
use super::model::Ground;
use super::search::Pool;
use crate::unknown_law;
use identification::held_out::Status;

/// A smooth law over the states, beside or instead of the leading model.
pub(super) struct Law {
    /// It alone is ahead of the leading model.
    pub is_instead: bool,
    pub words: String,
}

/// The law that the leading model lacks, where its odds reach the level and parts of the recording
/// that it was not fitted to bear it out; `None` where nothing is left.
///
/// Cost: the maps of every place, twice where names lead.
pub(super) fn missing(ground: Ground<'_>, pool: &Pool) -> Option<Law> {
    let level = libm::log(LEVEL / (1.0 - LEVEL));
    let best = pool.best();
    let of = |place: usize| {
        let model = &pool.entries[place].model;
        let session = model.session(ground)?;
        let found = unknown_law::best(&session, &model.problem.plant, &model.fit.linearised, &model.fit.theta, &model.noise)?;
        let nats = 0.5 * found.evidence - libm::log(found.tried.max(1) as f64) - pool.log_m;
        let confirmed = found.held_out.status() == Status::Confirmed;
        Some((nats, found)).filter(|(nats, _)| *nats > level && confirmed)
    };
    let beside = of(best);
    if best == 0 {
        let (nats, found) = beside?;
        return Some(Law { is_instead: true, words: words(nats, &found) });
    }
    // a law alone that is ahead of the names
    match of(0) {
        Some((nats, found)) if nats > pool.log_odds(best) + level => {
            Some(Law { is_instead: true, words: words(nats, &found) })
        }
        _ => beside.map(|(nats, found)| Law { is_instead: false, words: format!("beside that, {}", words(nats, &found)) }),
    }
}

fn words(nats: f64, found: &unknown_law::UnknownLaw) -> String {
    let over = found.names.join(" and ");
    format!(
        "something acts at {} that no effect of the catalogue describes: a law smooth over {over} is {nats:.1} nats ahead",
        found.place.site
    )
}
