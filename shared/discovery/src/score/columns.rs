//! Columns of candidates by passes at finite amplitude.

use super::Candidate;
use crate::filter::{Gains, gains, whiten};
use crate::fit::board::dot;
use crate::fit::{Board, Engine, parallel};
use plant::description::Plant;

/// One candidate with what it does to the innovations.
#[derive(Clone, Debug)]
pub struct Column {
    pub candidate: Candidate,
    /// `−∂ν/∂amplitude` per direction.
    pub raw: Vec<Vec<f64>>,
    /// Amplitude of the pass.
    pub step: f64,
}

/// Whitened size of the change that a pass aims at: small beside curvature, large beside rounding.
const TARGET: f64 = 2.0;
const TRIES: usize = 4;

/// Columns of all candidates that change anything, in their order.
pub fn columns(
    engine: &Engine<'_>,
    board: &Board,
    plant: &Plant,
    theta: &[f64],
    candidates: &[Candidate],
) -> Vec<Column> {
    let found: Option<Vec<Gains>> = (board.linears.iter().zip(engine.timelines.iter()))
        .map(|(linear, timeline)| gains(linear, timeline, &linear.noise))
        .collect();
    let Some(found) = found else { return Vec::new() };
    let list =
        parallel(candidates.len(), engine.threads, |i| column(engine, board, plant, theta, &candidates[i], &found));
    list.into_iter().flatten().collect()
}

fn column(
    engine: &Engine<'_>,
    board: &Board,
    plant: &Plant,
    theta: &[f64],
    candidate: &Candidate,
    found: &[Gains],
) -> Option<Column> {
    let mut step = candidate.effect.parameters[0].default.abs().min(0.5 * candidate.high);
    let mut best: Option<(Vec<f64>, f64)> = None;
    for _ in 0..TRIES {
        match change(engine, board, plant, theta, candidate, (step, 0)) {
            None => step *= 0.01,
            Some(change) => {
                let mut white = change.clone();
                for (run, linear) in board.linears.iter().enumerate() {
                    let range = engine.offsets[run]..engine.offsets[run] + linear.nu.len();
                    whiten(linear, &engine.timelines[run], &found[run], &mut [&mut white[range]]);
                }
                let size = dot(&white, &white).sqrt();
                if !size.is_finite() {
                    step *= 0.01;
                    continue;
                }
                best = Some((change, step));
                if (0.02 * TARGET..5.0 * TARGET).contains(&size) {
                    break;
                }
                let factor = if size > 0.0 { (TARGET / size).clamp(1e-4, 1e3) } else { 1e3 };
                let next = (step * factor).min(0.5 * candidate.high);
                if next == step {
                    break;
                }
                step = next;
            }
        }
    }
    let (first, step) = best?;
    let mut raw = vec![first.iter().map(|d| -d / step).collect::<Vec<f64>>()];
    for direction in 1..candidate.directions.len() {
        let change = change(engine, board, plant, theta, candidate, (step, direction))?;
        raw.push(change.iter().map(|d| -d / step).collect());
    }
    // a direction that does nothing would make the others singular
    let keep: Vec<bool> = raw.iter().map(|c| dot(c, c) > 0.0).collect();
    if !keep.iter().any(|k| *k) {
        return None;
    }
    let mut candidate = candidate.clone();
    let mut at = 0;
    candidate.directions.retain(|_| {
        at += 1;
        keep[at - 1]
    });
    at = 0;
    raw.retain(|_| {
        at += 1;
        keep[at - 1]
    });
    Some(Column { candidate, raw, step })
}

/// Change of the innovations at one amplitude in one direction.
fn change(
    engine: &Engine<'_>,
    board: &Board,
    plant: &Plant,
    theta: &[f64],
    candidate: &Candidate,
    (step, direction): (f64, usize),
) -> Option<Vec<f64>> {
    let mut with = plant.clone();
    with.add_effect(candidate.effect.kind, &candidate.site, &candidate.values(step, direction)).ok()?;
    let nu = engine.innovations(&with, theta, &board.linears, &|_| true)?;
    let mut change: Vec<f64> = nu.iter().zip(&board.nu).map(|(a, b)| a - b).collect();
    change.iter_mut().for_each(|c| {
        if !c.is_finite() {
            *c = f64::NAN
        }
    });
    Some(change)
}
