//! Every effect at every site with its score: grids first, then the best numbers of what looks promising.

use super::{Options, Standing};
use crate::compete::subsets::ladder;
use crate::score::refine::refined;
use crate::score::{
    Candidate, Column, Lines, Orders, Score, Scorer, candidates, columns, instants, lines, noise_free, orders,
};
use identification::filter::NoiseModel;
use identification::fit::{Board, Engine};

/// Noise this many times as large as stated may have swallowed something.
const GROWN: f64 = 3.0;

/// Columns and their scores under the adapted noise.
#[derive(Default)]
pub(super) struct Screening {
    pub columns: Vec<Column>,
    pub scores: Vec<Score>,
}

impl Screening {
    /// Score of a column.
    pub fn score(&self, column: usize) -> Option<&Score> {
        self.scores.iter().find(|score| score.column == column)
    }
}

/// `look` along the trajectory of `best`: where a loop feeds its sensors' noise back, of the loop without that noise.
pub(super) fn in_a_quiet_loop<T>(
    engine: &Engine<'_>,
    best: &Standing,
    look: impl FnOnce((&Engine<'_>, &Board)) -> T,
) -> T {
    let (board, theta) = (&best.fit.board, &best.fit.theta);
    let loops = noise_free(engine.problem, &best.plant, theta, &best.noise.sensor_sigma);
    let loops = loops.as_ref().and_then(|problem| {
        let own = Engine::at_other_values(engine, problem).ok()?;
        let board = Board::new(&own, &best.plant, theta, &best.fit.noise).ok()?;
        Some((own, board))
    });
    look(loops.as_ref().map_or((engine, board), |(engine, board)| (engine, board)))
}

pub(super) fn screen(engine: &Engine<'_>, best: &Standing, options: &Options) -> Screening {
    in_a_quiet_loop(engine, best, |along| screen_along(engine, along, best, options))
}

fn screen_along(engine: &Engine<'_>, along: (&Engine<'_>, &Board), best: &Standing, options: &Options) -> Screening {
    let (board, theta) = (&best.fit.board, &best.fit.theta);
    let period_s = engine.timelines[0].period_s;
    let stated = quieter(engine, best);
    let (lines, orders) = longest(engine, best);
    let noise = stated.as_ref().unwrap_or(&best.noise);
    let jumps = instants((engine, board), along, &best.plant, theta, noise);
    let found = (&lines, &orders[..], &jumps);
    let mut list = candidates(engine.problem, &best.plant, &board.linears, period_s, found, &options.without);
    thin(engine, best, &mut list);
    let mut all = columns(along, &best.plant, theta, &list);
    let Some(scorer) = Scorer::new(engine, board, theta, &best.noise) else {
        return Screening { columns: all, scores: Vec::new() };
    };
    let mut found = scored(&scorer, &all);
    let mut finer = refined(&scorer, along, &best.plant, theta, (&all, &found));
    if let Some(scorer) = stated.and_then(|stated| Scorer::new(engine, board, theta, &stated)) {
        // noise that has swallowed an effect hides its numbers too: of a fault that begins and ends it leaves two instants
        let found = scored(&scorer, &all);
        finer.extend(refined(&scorer, along, &best.plant, theta, (&all, &found)));
    }
    found.extend(scored(&scorer, &finer).into_iter().map(|own| Score { column: own.column + all.len(), ..own }));
    all.extend(finer);
    Screening { columns: all, scores: found }
}

fn scored(scorer: &Scorer<'_, '_>, columns: &[Column]) -> Vec<Score> {
    scorer.scores(columns).into_iter().flatten().collect()
}

/// The last rung of the ladder, all noise as stated, at the size that the innovations then have; `None` where it is the adapted noise.
fn quieter(engine: &Engine<'_>, best: &Standing) -> Option<NoiseModel> {
    let (found, stated) = (&best.noise, &engine.noise);
    let sizes = |noise: &NoiseModel| [noise.input_sigma.clone(), noise.sensor_sigma.clone()].concat();
    let louder = sizes(found).iter().zip(&sizes(stated)).any(|(sigma, stated)| *sigma > GROWN * stated);
    let grown = louder || found.jitter_s.iter().any(|jitter| *jitter > 0.0);
    let noise = ladder(engine, &best.noise).pop().filter(|_| grown)?;
    let normal = best.fit.board.normal(engine, &best.fit.theta, &noise, &[])?;
    let scale = (normal.chi2 / engine.samples.max(1) as f64).sqrt();
    Some(noise.louder(scale))
}

/// Lines of the innovations of the longest run, and orders at which they repeat over a joint.
fn longest(engine: &Engine<'_>, best: &Standing) -> (Lines, Vec<Orders>) {
    let runs = best.fit.board.linears.iter().zip(engine.timelines.iter());
    let Some((linear, timeline)) = runs.max_by_key(|(linear, _)| linear.nu.len()) else { return Default::default() };
    let sigma = &engine.noise.sensor_sigma;
    (lines(linear, timeline, sigma.len()), orders(linear, timeline, &best.plant, sigma))
}

/// Share of all work that the points of the grids may take.
const GRIDS: f64 = 0.04;

/// Bounds the work: whole laws stay, points of their grids go.
fn thin(engine: &Engine<'_>, best: &Standing, list: &mut Vec<Candidate>) {
    let passes: usize = list.iter().map(|candidate| candidate.directions.len()).sum();
    let keep = engine.work.affords(GRIDS, engine.pass_work(&best.plant, &best.fit.theta)) / passes.max(1) as f64;
    if keep >= 1.0 {
        return;
    }
    engine.work.leave_out("points of grids");
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
