//! What physics was left out of a plant, according to recordings: compare, locate, name, model, show.
//!
//! Order of work: fit the nominal plant; maximise its noise; score every effect at every site under the stated and under the adapted
//! noise; let the best compete with two-sided likelihoods; fit them as physics; repeat with the enlarged plant, at most three
//! times; freeze everything and ask recordings that were not used. Nothing is named that the robust score vetoes or the held-out
//! recording refuses; a significant score whose model cannot be fitted is reported as that.
//!
//! Every loop is bounded by [`Options`]; what was cut is said.

mod evidence;
mod figures;
mod report;
mod verdict;

pub use report::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectReport, EvidenceCurve, Figures, ForceCell, ForceMap, HeldOut,
    HeldOutChannel, HeldOutKind, Nominal, Overlay, ParameterReport, Rival, Tile, Verdict, Where,
};

use crate::compete::{
    Contender, Nominal as NominalPlant, Outcome, Ranking, Refit, SET_MAX, Veto, compete, rank, weights,
};
use crate::filter::{NoiseModel, gains};
use crate::fit::Board;
use crate::fit::noise::{Search, maximise};
use crate::fit::{Engine, Fit, fit};
use crate::force_map::{self, ForceMap as ForceMapFound};
use crate::held_out::{BLOCK_S, Gain, Predictor, Status, block_s, blocks, free_run, gain};
use crate::problem::Problem;
use crate::score::{Column, Score, candidates, columns, cosine, event_of_sample, scores};
use plant::description::Plant;

/// Bounds and levels.
#[derive(Clone, Debug)]
pub struct Options {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    pub terms_max: usize,
    pub threads: usize,
    /// Effects that the catalogue is taken without.
    pub without: Vec<String>,
    /// Recordings to ask at the end, as a problem of the same plant.
    pub held_out: Option<Problem>,
    /// The same experiment once more, run by run: what physics does repeats, what noise does not.
    pub repeat: Option<Problem>,
    /// Largest work in steps of integration; beyond it grids are thinned and it is said.
    pub steps_max: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            alpha: 2e-3,
            terms_max: 3,
            threads: 1,
            without: Vec::new(),
            held_out: None,
            repeat: None,
            steps_max: 4e8,
        }
    }
}

/// Share of alpha for physics and sensors; the rest is the noise model's.
const NAME_SHARE: f64 = 0.5;
/// ΔBIC within which a rival is printed.
pub const RIVAL_SPAN: f64 = 12.0;
/// Parts of a recording, each of which is predicted from the others, where no other recording is given.
const FOLDS: usize = 8;

/// A plant that stands as the best so far.
struct Standing {
    plant: Plant,
    problem: Problem,
    fit: Fit,
    noise: NoiseModel,
    objective: f64,
}

/// One adopted effect.
#[derive(Clone)]
struct Adopted {
    column: Column,
    score: Score,
    /// Significance of the set it came with.
    p: f64,
    /// Square root of the likelihood ratio of that set.
    d: f64,
    weight: f64,
    rivals: Vec<Contested>,
}

/// An effect that could stand in the place of an adopted one.
#[derive(Clone)]
struct Contested {
    kind: &'static str,
    site: String,
    weight: f64,
    bic: f64,
    cosine: f64,
}

/// An effect that is significant and could not be fitted.
struct Unfitted {
    column: Column,
    score: Score,
    amplitude: f64,
    ratio: f64,
    p: f64,
}

/// Diagnoses `problem`. `progress` is told a phase and the share done.
pub fn diagnose(problem: &Problem, options: &Options, progress: &mut dyn FnMut(&str, f64)) -> Diagnosis {
    match run(problem, options, progress) {
        Ok(diagnosis) => diagnosis,
        Err(reason) => Diagnosis::cannot_decide(reason),
    }
}

fn run(problem: &Problem, options: &Options, progress: &mut dyn FnMut(&str, f64)) -> Result<Diagnosis, String> {
    progress("fit the nominal plant", 0.0);
    let engine = Engine::new(problem, options.threads).map_err(|error| error.to_string())?;
    let stated = fit(&engine, &problem.plant, &engine.prior(), &engine.noise, 4).map_err(|error| error.to_string())?;
    progress("noise of the nominal plant", 0.1);
    let mut notes = problem.notes.clone();
    if options.repeat.is_some() {
        notes.push("the repeated recording was read, but weighs nothing in this verdict yet".to_owned());
    }
    let nominal = standing(&engine, &stated)?;
    let nominal_objective = nominal.objective;
    let noise_p = verdict::noise_p(&engine, &stated, &nominal.fit, &nominal.noise, nominal.objective);
    let mut best = nominal;
    let mut adopted: Vec<Adopted> = Vec::new();
    let mut unfitted: Vec<Unfitted> = Vec::new();
    let mut screening = Screening::default();
    let mut smaller = Vec::new();
    // what noise of another kind gains on the standing plant
    let mut unknown_noise = 0.0;
    while adopted.len() < options.terms_max && unfitted.is_empty() {
        let done = adopted.len() as f64 / options.terms_max as f64;
        progress("score the catalogue", 0.2 + 0.6 * done);
        let own = Engine::like(&engine, &best.problem).map_err(|error| error.to_string())?;
        let found = screen(&own, &best, options, &mut notes);
        progress("compete", 0.25 + 0.6 * done);
        let step = step(&own, &best, &found, options.terms_max - adopted.len(), options);
        let first = adopted.is_empty();
        unfitted = step.unfitted;
        if first {
            screening = found;
        }
        let Some(refit) = step.refit else {
            unknown_noise = (best.objective - step.null).max(0.0);
            break;
        };
        // nearest first: without what this round adds, then its own smaller sets before that
        let mut nearest: Vec<(Vec<Adopted>, Standing)> = Vec::new();
        for (set, refit) in step.smaller {
            nearest.push((adopted.iter().cloned().chain(set).collect(), stand(&refit)));
        }
        if !adopted.is_empty() {
            nearest.push((adopted.clone(), best));
        }
        nearest.append(&mut smaller);
        smaller = nearest;
        best = stand(&refit);
        adopted.extend(step.adopted);
    }
    progress("held out", 0.85);
    let mut shown = held_out(problem, &engine, &stated, &best, adopted.is_empty(), options);
    let mut smaller = smaller.into_iter();
    while !adopted.is_empty() && status(shown.gain.as_ref()) != Status::Confirmed {
        // a term that held-out data do not bear takes no other with it
        let Some((set, standing)) = smaller.next() else { break };
        let again = held_out(problem, &engine, &stated, &standing, false, options);
        if status(again.gain.as_ref()) == Status::Confirmed {
            notes.push(format!(
                "held-out data confirm {} of {} effects that this recording asks for",
                set.len(),
                adopted.len()
            ));
            (adopted, best, shown) = (set, standing, again);
        }
    }
    progress("a force that no law describes", 0.95);
    let mut map = remainder(&engine, &best)?;
    if let Some(map) = &mut map {
        map.evidence -= unknown_noise;
    }
    progress("report", 1.0);
    Ok(verdict::conclude(&verdict::Findings {
        engine: &engine,
        stated: &stated,
        best: &best,
        adopted: &adopted,
        unfitted: &unfitted,
        screening: &screening,
        noise_p,
        map: map.as_ref(),
        explained: (nominal_objective - best.objective).max(0.0),
        shown,
        notes,
        alpha: options.alpha,
    }))
}

/// The map of force that the standing plant still lacks.
fn remainder(engine: &Engine<'_>, best: &Standing) -> Result<Option<ForceMapFound>, String> {
    let own = Engine::like(engine, &best.problem).map_err(|error| error.to_string())?;
    Ok(force_map::best(&own, &best.fit.board, &best.fit.theta, &best.noise))
}

/// Noise maximised, parameters fitted under it, noise once more.
fn standing(engine: &Engine<'_>, stated: &Fit) -> Result<Standing, String> {
    let search = Search { sweeps: 8, colour: true, scan: true };
    let failed = || "the likelihood of the noise cannot be found".to_owned();
    let plant = &stated.plant;
    let (noise, _) = maximise(engine, &stated.board, &stated.theta, &[], &engine.noise, search).ok_or_else(failed)?;
    let adapted = fit(engine, plant, &stated.theta, &noise, 2).map_err(|error| error.to_string())?;
    let search = Search { scan: false, ..search };
    let (noise, objective) =
        maximise(engine, &adapted.board, &adapted.theta, &[], &noise, search).ok_or_else(failed)?;
    Ok(Standing { plant: plant.clone(), problem: engine.problem.clone(), fit: adapted, noise, objective })
}

/// Columns and their scores under stated and adapted noise.
#[derive(Default)]
struct Screening {
    columns: Vec<Column>,
    pairs: Vec<(Score, Score)>,
}

impl Screening {
    /// Score of a column under the adapted noise.
    fn score(&self, column: usize) -> Option<&Score> {
        self.pairs.iter().map(|(_, adapted)| adapted).find(|score| score.column == column)
    }
}

fn screen(engine: &Engine<'_>, best: &Standing, options: &Options, notes: &mut Vec<String>) -> Screening {
    let period_s = engine.timelines[0].period_s;
    let mut list = candidates(engine.problem, &best.plant, &best.fit.board.linears, period_s, &options.without);
    let steps: f64 = engine.timelines.iter().flat_map(|t| &t.events).map(|event| event.steps as f64).sum();
    let most = (options.steps_max / (2.0 * steps.max(1.0))) as usize;
    if list.len() > most.max(20) {
        // whole laws stay, points of their grids go
        let keep = most.max(20) as f64 / list.len() as f64;
        notes.push(format!("grids were thinned to {:.0} % to bound the work", 100.0 * keep));
        let mut seen: Vec<String> = Vec::new();
        let mut count = 0.0;
        list.retain(|candidate| {
            let name = format!("{}@{}", candidate.effect.kind, candidate.site);
            let fresh = !seen.contains(&name);
            if fresh {
                seen.push(name);
            }
            count += keep;
            let due = count >= 1.0;
            count -= if due { 1.0 } else { 0.0 };
            fresh || due
        });
    }
    let columns = columns(engine, &best.fit.board, &best.plant, &best.fit.theta, &list);
    let stated = scores(engine, &best.fit.board, &best.fit.theta, &engine.noise, &columns);
    let adapted = scores(engine, &best.fit.board, &best.fit.theta, &best.noise, &columns);
    let pairs = stated.into_iter().zip(adapted).filter_map(|(a, b)| Some((a?, b?))).collect();
    Screening { columns, pairs }
}

/// What one round of the search found.
#[derive(Default)]
struct Step {
    adopted: Vec<Adopted>,
    refit: Option<Refit>,
    unfitted: Vec<Unfitted>,
    /// Least objective of the plant without them that was met.
    null: f64,
    /// Smaller sets that stand too, larger ones first: for the case that held-out data do not confirm the one adopted.
    smaller: Vec<(Vec<Adopted>, Refit)>,
}

/// The next set of effects, if any stands, and those that are significant but could not be fitted.
fn step(engine: &Engine<'_>, best: &Standing, found: &Screening, room: usize, options: &Options) -> Step {
    let alpha = NAME_SHARE * options.alpha;
    let (board, theta) = (&best.fit.board, &best.fit.theta);
    let ranking = rank(engine, board, theta, &found.columns, &best.noise, room.min(SET_MAX));
    let nominal = NominalPlant { fit: &best.fit, noise: &best.noise, objective: best.objective };
    let mut outcome = compete(engine, &nominal, &found.columns, &ranking, alpha);
    let mut tried: Vec<Vec<usize>> = Vec::new();
    let better = |small: &Contender, large: &Contender| predicts_better(engine, small, large);
    while let Some(at) = outcome.best(alpha, ranking.tried, &better) {
        let contender = &outcome.contenders[at];
        let refit = contender.refit.clone().expect("only refitted sets stand");
        // once more from the other side: the nominal plant with the noise that suits the set
        if !tried.contains(&contender.subset.members)
            && let Some(null) = nominal_with(engine, best, &refit.noise)
            && null < outcome.null - 1.0
        {
            tried.push(contender.subset.members.clone());
            outcome.lower_null(null, ranking.tried, engine.samples);
            continue;
        }
        if contender.subset.members.iter().any(|c| vanishes(&refit, &found.columns[*c])) {
            // what was gained was the noise's, or the other members'
            outcome.contenders.remove(at);
            continue;
        }
        let adopted = adopt(found, &outcome, at, &ranking);
        let smaller = smaller(found, &outcome, at, &ranking, alpha);
        return Step { adopted, refit: Some(refit), unfitted: Vec::new(), null: outcome.null, smaller };
    }
    let lost = outcome.contenders.iter().filter(|c| {
        c.p < alpha && c.veto != Veto::Vetoed && c.refit.is_none() && c.bic < 0.0 && c.subset.members.len() == 1
    });
    let unfitted = lost.filter_map(|c| {
        let column = c.subset.members[0];
        let score = found.score(column)?.clone();
        let amplitude = c.subset.amplitudes[0].first().copied().unwrap_or(0.0);
        Some(Unfitted { column: found.columns[column].clone(), score, amplitude, ratio: c.ratio, p: c.p })
    });
    Step { unfitted: unfitted.collect(), null: outcome.null, ..Step::default() }
}

/// The best set of every size below that of contender `at` that stands.
fn smaller(
    found: &Screening,
    outcome: &Outcome,
    at: usize,
    ranking: &Ranking,
    alpha: f64,
) -> Vec<(Vec<Adopted>, Refit)> {
    let size = |c: &Contender| c.subset.members.len();
    let sizes = (1..size(&outcome.contenders[at])).rev();
    let best = sizes.filter_map(|own| outcome.contenders.iter().position(|c| size(c) == own && c.stands(alpha)));
    best.filter_map(|i| Some((adopt(found, outcome, i, ranking), outcome.contenders[i].refit.clone()?))).collect()
}

/// Parts of the recording are predicted from the others better by `large` than by `small`, by more than the standard error of blocks:
/// the rule of one standard error.
fn predicts_better(engine: &Engine<'_>, small: &Contender, large: &Contender) -> bool {
    let (Some(without), Some(with)) = (&small.refit, &large.refit) else { return false };
    let terms = |problem: &Problem, fit: &Fit| {
        let own = Engine::like(engine, problem).ok()?;
        block_terms(&own, &fit.board, &fit.theta, &with.noise)
    };
    let before = terms(&without.problem, &without.fit);
    let (Some(before), Some(after)) = (before, terms(&with.problem, &with.fit)) else { return false };
    let differences: Vec<(f64, f64)> = before.0.iter().zip(&after.0).map(|((t, a), (_, b))| (*t, b - a)).collect();
    let gain = blocks(&differences, block_s(engine));
    gain.loglik_gain > gain.gain_se
}

/// The members of contender `at` with their rivals: sets of the same size that differ from it in that member alone.
fn adopt(found: &Screening, outcome: &Outcome, at: usize, ranking: &Ranking) -> Vec<Adopted> {
    let winner = &outcome.contenders[at];
    let law = |a: usize, b: usize| found.columns[a].candidate.same_law(&found.columns[b].candidate);
    let members = &winner.subset.members;
    let on_rung = ranking.sizes[members.len() - 1]
        .iter()
        .filter(|s| s.members.iter().zip(members).all(|(a, b)| law(*a, *b)))
        .map(|s| s.bic)
        .fold(f64::INFINITY, f64::min);
    let on_rung = if on_rung.is_finite() { on_rung } else { winner.bic };
    // likelihoods where they were taken, else the rung's word, relative to the winner's own at the same depth
    let deep = outcome.contenders.iter().map(|c| (&c.subset.members, c.bic - winner.bic));
    let shallow = ranking.sizes[members.len() - 1].iter().map(|s| (&s.members, s.bic - on_rung));
    let all: Vec<(&Vec<usize>, f64)> = deep.chain(shallow).filter(|(set, _)| set.len() == members.len()).collect();
    let mut list = Vec::with_capacity(members.len());
    for own in members {
        let others: Vec<usize> = members.iter().copied().filter(|m| m != own).collect();
        let mut contested: Vec<(usize, f64)> = Vec::new();
        for (set, bic) in &all {
            let rest: Vec<usize> = set.iter().copied().filter(|s| !others.iter().any(|o| law(*s, *o))).collect();
            let [instead] = rest[..] else { continue };
            let known = contested.iter().any(|(c, _)| law(*c, instead));
            if !law(instead, *own) && !known && *bic <= RIVAL_SPAN {
                contested.push((instead, bic.max(0.0)));
            }
        }
        let mut bic = vec![0.0];
        bic.extend(contested.iter().map(|(_, bic)| *bic));
        let weights = weights(&bic, RIVAL_SPAN);
        let Some(score) = found.score(*own) else { continue };
        let rivals = contested.iter().zip(&weights[1..]).map(|((column, bic), weight)| Contested {
            kind: found.columns[*column].candidate.effect.kind,
            site: found.columns[*column].candidate.site.to_string(),
            weight: *weight,
            bic: *bic,
            cosine: found.score(*column).map_or(0.0, |other| cosine(score, other)),
        });
        let rivals = rivals.collect();
        let (p, d) = (winner.p, winner.ratio.max(0.0).sqrt());
        list.push(Adopted {
            column: found.columns[*own].clone(),
            score: score.clone(),
            p,
            d,
            weight: weights[0],
            rivals,
        });
    }
    list
}

fn stand(refit: &Refit) -> Standing {
    Standing {
        plant: refit.plant.clone(),
        problem: refit.problem.clone(),
        fit: refit.fit.clone(),
        noise: refit.noise.clone(),
        objective: refit.objective,
    }
}

/// Least objective of the standing plant from another start of the noise, its parameters fitted again under it.
fn nominal_with(engine: &Engine<'_>, best: &Standing, noise: &NoiseModel) -> Option<f64> {
    let search = Search { sweeps: 2, colour: true, scan: false };
    let (noise, objective) = maximise(engine, &best.fit.board, &best.fit.theta, &[], noise, search)?;
    let again = fit(engine, &best.plant, &best.fit.theta, &noise, 2).ok();
    let refitted = again.and_then(|again| maximise(engine, &again.board, &again.theta, &[], &noise, search));
    Some(refitted.map_or(objective, |(_, refitted)| refitted.min(objective)))
}

/// The amplitude of an effect is within two of its standard errors of nothing.
fn vanishes(refit: &Refit, column: &Column) -> bool {
    let effect = column.candidate.effect;
    let prefix = format!("effect.{}@{}.", effect.kind, column.candidate.site);
    let amplitudes = effect.parameters.iter().take(effect.amplitudes.max(1)).map(|p| format!("{prefix}{}", p.name));
    let place = |name: String| refit.problem.unknowns.iter().position(|unknown| unknown.parameter == name);
    let mut found = amplitudes.filter_map(place);
    !found.any(|at| refit.fit.theta[at].abs() > 2.0 * refit.fit.sigma[at])
}

/// What held-out data say: kind, free runs before and after, gain, and whiteness.
struct Shown {
    kind: HeldOutKind,
    before: Vec<crate::held_out::ChannelFit>,
    after: Vec<crate::held_out::ChannelFit>,
    gain: Option<Gain>,
    compare: Vec<crate::held_out::ChannelFit>,
    overlays: Vec<Overlay>,
}

fn held_out(
    problem: &Problem,
    engine: &Engine<'_>,
    stated: &Fit,
    best: &Standing,
    nothing: bool,
    options: &Options,
) -> Shown {
    let nominal = Predictor { plant: &stated.plant, theta: &stated.theta, noise: &engine.noise };
    let compare = free_run(engine, nominal);
    let none = |compare| {
        let (before, after, overlays) = (Vec::new(), Vec::new(), Vec::new());
        Shown { kind: HeldOutKind::None, before, after, gain: None, compare, overlays }
    };
    if nothing {
        return none(compare);
    }
    let shown = match &options.held_out {
        Some(other) => on_recording(other, engine, stated, best, options),
        None => on_blocks(problem, engine, stated, best, options),
    };
    match shown {
        Some((kind, before, after, gain, overlays)) => Shown { kind, before, after, gain, compare, overlays },
        None => none(compare),
    }
}

/// Time and log-likelihood of every instant.
type Terms = Vec<(f64, f64)>;
type Free = Vec<crate::held_out::ChannelFit>;
type ShownParts = (HeldOutKind, Free, Free, Option<Gain>, Vec<Overlay>);

/// Parameters as fitted; those of single recordings at their priors.
fn on_recording(
    other: &Problem,
    engine: &Engine<'_>,
    stated: &Fit,
    best: &Standing,
    options: &Options,
) -> Option<ShownParts> {
    let before_problem = other.with_plant(&stated.plant);
    let after_problem = other.with_plant(&best.plant);
    let before = Engine::new(&before_problem, options.threads).ok()?;
    let after = Engine::like(&before, &after_problem).ok()?;
    let theta_before = carried(&before, &engine.problem.unknowns, &stated.theta);
    let theta_after = carried(&after, &best.problem.unknowns, &best.fit.theta);
    compare_on(HeldOutKind::Recording, (&before, stated, &theta_before), (&after, best, &theta_after))
}

/// Values of shared unknowns of the same name; those of single recordings and segments belong to theirs and stand at their priors.
fn carried(engine: &Engine<'_>, unknowns: &[crate::problem::Unknown], theta: &[f64]) -> Vec<f64> {
    let mut carried = engine.start_from(unknowns, theta);
    let parameters = engine.problem.plant.parameters();
    for (value, unknown) in carried.iter_mut().zip(&engine.problem.unknowns) {
        if parameters.iter().any(|p| p.name == unknown.parameter && p.scope != plant::description::Scope::Shared) {
            *value = unknown.prior;
        }
    }
    carried
}

/// Blocks of the record, each predicted with parameters from the others: linear in what leaving a block out changes.
fn on_blocks(
    problem: &Problem,
    engine: &Engine<'_>,
    stated: &Fit,
    best: &Standing,
    options: &Options,
) -> Option<ShownParts> {
    let after_engine = Engine::like(engine, &best.problem).ok()?;
    let before = block_terms(engine, &stated.board, &stated.theta, &best.noise)?;
    let after = block_terms(&after_engine, &best.fit.board, &best.fit.theta, &best.noise)?;
    let differences: Vec<(f64, f64)> = before.0.iter().zip(&after.0).map(|((t, a), (_, b))| (*t, b - a)).collect();
    let gain = blocks(&differences, block_s(engine));
    let (_, test) = problem.split(1.0 - 1.0 / FOLDS as f64);
    let test_before = Engine::new(&test, options.threads).ok()?;
    let augmented = test.with_plant(&best.plant);
    let test_after = Engine::like(&test_before, &augmented).ok()?;
    let nominal = Predictor { plant: &stated.plant, theta: &before.1, noise: &best.noise };
    let with = Predictor { plant: &best.plant, theta: &after.1, noise: &best.noise };
    let overlays = figures::overlays((&test_before, nominal), (&test_after, with));
    Some((HeldOutKind::Blocks, free_run(&test_before, nominal), free_run(&test_after, with), Some(gain), overlays))
}

/// Log-likelihood of every instant with parameters from the other folds, and the parameters without the last fold.
fn block_terms(engine: &Engine<'_>, board: &Board, theta: &[f64], noise: &NoiseModel) -> Option<(Terms, Vec<f64>)> {
    let normal = board.normal(engine, theta, noise, &[])?;
    let events = event_of_sample(engine);
    let instants = events.last().map_or(0, |last| last + 1);
    let times: Vec<f64> = instants_s(engine);
    let fold = |event: usize| event * FOLDS / instants.max(1);
    let n = normal.unknowns;
    let mut sum = half_log_determinants(engine, board, noise)?;
    let mut last = theta.to_vec();
    for k in 0..FOLDS {
        let own: Vec<usize> = (0..events.len()).filter(|s| fold(events[*s]) == k).collect();
        let (mut matrix, mut right) = (normal.matrix.clone(), normal.right.clone());
        for i in 0..n {
            for j in 0..n {
                matrix[(i, j)] -= own.iter().map(|s| normal.columns[i][*s] * normal.columns[j][*s]).sum::<f64>();
            }
            right[i] -= own.iter().map(|s| normal.columns[i][*s] * normal.r[*s]).sum::<f64>();
        }
        let step = if n > 0 { nalgebra::Cholesky::new(matrix)?.solve(&right) } else { right };
        for s in own {
            let r = normal.r[s] - (0..n).map(|i| normal.columns[i][s] * step[i]).sum::<f64>();
            sum[events[s]] -= 0.5 * r * r;
        }
        if k + 1 == FOLDS {
            for (i, unknown) in engine.problem.unknowns.iter().enumerate() {
                last[i] = (theta[i] + step[i] * unknown.sigma).clamp(unknown.low, unknown.high);
            }
        }
    }
    Some((times.into_iter().zip(sum).collect(), last))
}

/// `−½ ln |S|` of every instant.
fn half_log_determinants(engine: &Engine<'_>, board: &Board, noise: &NoiseModel) -> Option<Vec<f64>> {
    let mut list = Vec::new();
    for (linear, timeline) in board.linears.iter().zip(engine.timelines.iter()) {
        let found = gains(linear, timeline, noise)?;
        for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
            let factor = &found.factor[found.factor_first[k]..];
            list.push(-(0..event.count).map(|i| libm::log(factor[i * event.count + i])).sum::<f64>());
        }
    }
    Some(list)
}

/// Time of every instant, runs one behind the other.
fn instants_s(engine: &Engine<'_>) -> Vec<f64> {
    let mut times = Vec::new();
    let mut origin = 0.0;
    for timeline in engine.timelines.iter() {
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        times.extend(timeline.events.iter().filter(|event| event.count > 0).map(|event| origin + event.t_s - first));
        origin += timeline.events.last().map_or(0.0, |event| event.t_s - first) + 10.0 * BLOCK_S;
    }
    times
}

fn compare_on(
    kind: HeldOutKind,
    (before, stated, theta_before): (&Engine<'_>, &Fit, &[f64]),
    (after, best, theta_after): (&Engine<'_>, &Standing, &[f64]),
) -> Option<ShownParts> {
    // one noise for both, the augmented plant's: else the gain is that of a noise model
    let nominal = Predictor { plant: &stated.plant, theta: theta_before, noise: &best.noise };
    let augmented = Predictor { plant: &best.plant, theta: theta_after, noise: &best.noise };
    let gain = gain(before, nominal, (after, augmented));
    let overlays = figures::overlays((before, nominal), (after, augmented));
    Some((kind, free_run(before, nominal), free_run(after, augmented), gain, overlays))
}

/// Standing of all adopted effects together.
fn status(gain: Option<&Gain>) -> Status {
    gain.map_or(Status::Unconfirmed, Gain::status)
}

#[cfg(test)]
mod tests;
