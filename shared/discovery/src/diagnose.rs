//! What physics was left out of a plant, according to recordings: compare, locate, name, model, show.
//!
//! Order of work: fit the nominal plant; maximise its noise; score every effect at every site under the stated and under the adapted
//! noise; let the best compete with two-sided likelihoods; fit them as physics; repeat with the enlarged plant, at most three
//! times; freeze everything and ask recordings that were not used. Nothing is named that the robust score vetoes or the held-out
//! recording refuses; a significant score whose model cannot be fitted is reported as that.
//!
//! Every loop is bounded by [`Options`]; what was cut is said.

mod evidence;
mod report;
mod verdict;

pub use report::{
    DetectionLimit, Diagnosis, EffectReport, HeldOut, HeldOutChannel, HeldOutKind, Nominal, ParameterReport, Rival,
    Verdict, Where,
};

use crate::compete::{Contender, Limits, Pair, Refit, Veto, contenders, pair, refit, weights};
use crate::filter::NoiseModel;
use crate::fit::Board;
use crate::fit::noise::{Search, maximise};
use crate::fit::{Engine, Fit, fit};
use crate::held_out::{BLOCK_S, Gain, Predictor, Status, blocks, free_run, gain};
use crate::problem::Problem;
use crate::score::{Column, Score, candidates, columns, event_of_sample, scores};
use crate::statistics::chi_squared_tail;
use plant::description::Plant;

/// Bounds and levels.
#[derive(Clone, Debug)]
pub struct Options {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    pub terms_max: usize,
    pub linear_max: usize,
    pub refit_max: usize,
    pub threads: usize,
    /// Effects that the catalogue is taken without.
    pub without: Vec<String>,
    /// Recordings to ask at the end, as problems of the same plant.
    pub held_out: Option<Problem>,
    /// Largest work in steps of integration; beyond it grids are thinned and it is said.
    pub steps_max: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            alpha: 2e-3,
            terms_max: 3,
            linear_max: 8,
            refit_max: 4,
            threads: 1,
            without: Vec::new(),
            held_out: None,
            steps_max: 4e8,
        }
    }
}

/// Shares of alpha: physics and sensors; the noise model.
const NAME_SHARE: f64 = 0.5;
const PAIR_SHARE: f64 = 0.25;
/// A pair is taken at once where it beats the best single effect by this in BIC; else effects are added one by one.
const PAIR_MARGIN: f64 = 20.0;
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
struct Adopted {
    column: Column,
    contender: Contender,
    rivals: Vec<(Column, Contender)>,
    refit: Refit,
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
    let nominal = standing(&engine, &stated)?;
    let noise_p = verdict::noise_p(&engine, &stated, &nominal.fit, &nominal.noise, nominal.objective);
    let mut best = nominal;
    let mut adopted: Vec<Adopted> = Vec::new();
    let mut unfitted: Vec<(Column, Contender)> = Vec::new();
    let mut screening = Screening::default();
    for term in 0..options.terms_max {
        if adopted.len() >= options.terms_max {
            break;
        }
        progress("score the catalogue", 0.2 + 0.2 * term as f64);
        let own = Engine::like(&engine, &best.problem).map_err(|error| error.to_string())?;
        let found = screen(&own, &best, options, &mut notes);
        progress("compete", 0.3 + 0.2 * term as f64);
        let step = step(&own, &best, &found, options);
        if term == 0 {
            screening = found;
        }
        unfitted.extend(step.1);
        // terms that only together beat what is there
        let both = (adopted.is_empty() && unfitted.is_empty()).then(|| two(&own, &best, &screening, options)).flatten();
        let single = step.0.as_ref().map_or(0.0, |next| next.contender.bic);
        if let Some(both) = both.filter(|both| both[0].contender.bic < single - PAIR_MARGIN) {
            best = stand(&both[0].refit);
            adopted.extend(both);
            continue;
        }
        let Some(next) = step.0 else { break };
        best = stand(&next.refit);
        adopted.push(next);
    }
    progress("held out", 0.9);
    let shown = held_out(problem, &engine, &stated, &best, adopted.is_empty(), options);
    progress("report", 1.0);
    Ok(verdict::conclude(&verdict::Findings {
        engine: &engine,
        stated: &stated,
        best: &best,
        adopted: &adopted,
        unfitted: &unfitted,
        screening: &screening,
        noise_p,
        shown,
        notes,
        alpha: options.alpha,
    }))
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

/// The next effect, if any stands, and those that are significant but could not be fitted.
fn step(
    engine: &Engine<'_>,
    best: &Standing,
    found: &Screening,
    options: &Options,
) -> (Option<Adopted>, Vec<(Column, Contender)>) {
    let alpha = NAME_SHARE * options.alpha;
    let limits = Limits { linear_max: options.linear_max, refit_max: options.refit_max };
    let null = (&best.noise, best.objective);
    let mut list = contenders(engine, &best.fit, &found.columns, &found.pairs, null, alpha, limits);
    if !list.iter().any(|c| c.p < 10.0 * alpha) {
        return (None, Vec::new());
    }
    let samples = libm::log(engine.samples as f64);
    let mut null = best.objective;
    for contender in list.iter_mut().filter(|c| c.p < 10.0 * alpha).take(limits.refit_max) {
        let column = &found.columns[contender.column];
        null = null.min(nominal_with(engine, best, &contender.noise).unwrap_or(null));
        if null + contender.ratio < best.objective {
            continue;
        }
        contender.refit = refit(engine, &best.fit, column, contender, null);
        if let Some(refit) = &contender.refit {
            // the noise found with the effect may be the better one without it, too
            null = null.min(nominal_with(engine, best, &refit.noise).unwrap_or(null));
            if vanishes(refit, column) {
                // what was gained was the noise's
                (contender.refit, contender.ratio) = (None, 0.0);
                continue;
            }
            let ratio = null - refit.objective;
            // a refit that lost most of what the line promised has not converged
            if ratio < 0.5 * contender.ratio {
                contender.refit = None;
                continue;
            }
            contender.ratio = ratio;
            let tried = found.columns.len().max(1) as f64;
            contender.p = (chi_squared_tail(ratio, refit.free as f64) * tried).min(1.0);
            contender.bic = refit.free as f64 * samples - ratio;
        }
    }
    // ratios that were taken before the null was found to be better
    for contender in &mut list {
        let over = (best.objective - null).max(0.0);
        let freedom = contender.refit.as_ref().map_or(contender.score.freedom, |refit| refit.free) as f64;
        contender.ratio = match &contender.refit {
            Some(refit) => null - refit.objective,
            None => (contender.ratio - over).max(0.0),
        };
        let tried = found.columns.len().max(1) as f64;
        contender.p = (chi_squared_tail(contender.ratio.max(0.0), freedom) * tried).min(1.0);
        contender.bic = freedom * samples - contender.ratio;
    }
    list.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let stands = |c: &Contender| c.p < alpha && c.veto != Veto::Vetoed;
    let of = |c: &Contender| found.columns[c.column].clone();
    let unfitted = list.iter().filter(|c| stands(c) && c.refit.is_none()).map(|c| (of(c), c.clone())).collect();
    let Some(at) = list.iter().position(|c| stands(c) && c.refit.is_some() && c.bic < 0.0) else {
        return (None, unfitted);
    };
    let mut contender = list.remove(at);
    let refit = contender.refit.take().expect("only contenders with a refit are taken");
    let rivals = list.into_iter().map(|c| (found.columns[c.column].clone(), c)).collect();
    (Some(Adopted { column: found.columns[contender.column].clone(), contender, rivals, refit }), Vec::new())
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

/// A pair of effects as two adopted ones with one refit.
fn two(engine: &Engine<'_>, best: &Standing, found: &Screening, options: &Options) -> Option<[Adopted; 2]> {
    let alpha = PAIR_SHARE * options.alpha;
    let limits = Limits { linear_max: options.linear_max, refit_max: options.refit_max };
    let null = (&best.noise, best.objective);
    let Pair { columns, scores, refit, p, bic, .. } =
        pair(engine, &best.fit, &found.columns, &found.pairs, null, alpha, limits)?;
    if columns.iter().any(|column| vanishes(&refit, &found.columns[*column])) {
        return None;
    }
    let again = nominal_with(engine, best, &refit.noise)?.min(best.objective);
    let ratio = again - refit.objective;
    let tried = (found.columns.len() * found.columns.len()) as f64;
    if chi_squared_tail(ratio.max(0.0), refit.free as f64) * tried > alpha {
        return None;
    }
    let adopt = |k: usize| Adopted {
        column: found.columns[columns[k]].clone(),
        contender: Contender {
            column: columns[k],
            score: scores[k].clone(),
            ratio,
            p,
            amplitude: scores[k].amplitude.clone(),
            noise: refit.noise.clone(),
            veto: Veto::Silent,
            refit: None,
            bic,
            cosine: 1.0,
        },
        rivals: Vec::new(),
        refit: refit.clone(),
    };
    Some([adopt(0), adopt(1)])
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
    let none = |compare| Shown { kind: HeldOutKind::None, before: Vec::new(), after: Vec::new(), gain: None, compare };
    if nothing {
        return none(compare);
    }
    let shown = match &options.held_out {
        Some(other) => on_recording(other, engine, stated, best, options),
        None => on_blocks(problem, engine, stated, best, options),
    };
    match shown {
        Some((kind, before, after, gain)) => Shown { kind, before, after, gain, compare },
        None => none(compare),
    }
}

/// Time and log-likelihood of every instant.
type Terms = Vec<(f64, f64)>;
type ShownParts = (HeldOutKind, Vec<crate::held_out::ChannelFit>, Vec<crate::held_out::ChannelFit>, Option<Gain>);

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
    let theta_before = before.start_from(&engine.problem.unknowns, &stated.theta);
    let theta_after = after.start_from(&best.problem.unknowns, &best.fit.theta);
    compare_on(HeldOutKind::Recording, (&before, stated, &theta_before), (&after, best, &theta_after))
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
    let gain = blocks(&differences, BLOCK_S.max(4.0 * engine.timelines[0].period_s));
    let (_, test) = problem.split(1.0 - 1.0 / FOLDS as f64);
    let test_before = Engine::new(&test, options.threads).ok()?;
    let augmented = test.with_plant(&best.plant);
    let test_after = Engine::like(&test_before, &augmented).ok()?;
    let nominal = Predictor { plant: &stated.plant, theta: &before.1, noise: &best.noise };
    let with = Predictor { plant: &best.plant, theta: &after.1, noise: &best.noise };
    Some((HeldOutKind::Blocks, free_run(&test_before, nominal), free_run(&test_after, with), Some(gain)))
}

/// Log-likelihood of every instant with parameters from the other folds, and the parameters without the last fold.
fn block_terms(engine: &Engine<'_>, board: &Board, theta: &[f64], noise: &NoiseModel) -> Option<(Terms, Vec<f64>)> {
    let normal = board.normal(engine, theta, noise, &[])?;
    let events = event_of_sample(engine);
    let instants = events.last().map_or(0, |last| last + 1);
    let times: Vec<f64> = instants_s(engine);
    let fold = |event: usize| event * FOLDS / instants.max(1);
    let n = normal.unknowns;
    let mut sum = vec![0.0; instants];
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
    Some((kind, free_run(before, nominal), free_run(after, augmented), gain))
}

/// Standing of all adopted effects together.
fn status(gain: Option<&Gain>) -> Status {
    gain.map_or(Status::Unconfirmed, Gain::status)
}

/// Rivals within the span of the adopted one, with weights.
fn equivalence(adopted: &Adopted) -> Vec<(String, String, f64, f64)> {
    let mut bic = vec![adopted.contender.bic];
    bic.extend(adopted.rivals.iter().map(|(_, c)| c.bic));
    let weights = weights(&bic, RIVAL_SPAN);
    let name = |column: &Column| (column.candidate.effect.kind.to_owned(), column.candidate.site.to_string());
    let mut list = Vec::new();
    for (i, weight) in weights.iter().enumerate() {
        let (column, contender) = if i == 0 {
            (&adopted.column, &adopted.contender)
        } else {
            (&adopted.rivals[i - 1].0, &adopted.rivals[i - 1].1)
        };
        let (kind, site) = name(column);
        if i == 0 || *weight > 0.0 {
            list.push((kind, site, *weight, contender.bic - bic[0]));
        }
    }
    list
}

#[cfg(test)]
mod tests;
