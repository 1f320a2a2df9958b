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
    let mut column = Column { candidate: candidate.clone(), raw: Vec::new(), step: 0.0 };
    column.candidate.directions.clear();
    for direction in 0..candidate.directions.len() {
        // a direction that does nothing (out of the plane) would make the others singular
        let Some((raw, step)) = along(engine, board, plant, theta, (candidate, direction), found) else { continue };
        column.candidate.directions.push(candidate.directions[direction].clone());
        column.step = column.step.max(step);
        column.raw.push(raw);
    }
    (!column.raw.is_empty()).then_some(column)
}

/// Column of one direction at an amplitude that is felt.
fn along(
    engine: &Engine<'_>,
    board: &Board,
    plant: &Plant,
    theta: &[f64],
    (candidate, direction): (&Candidate, usize),
    found: &[Gains],
) -> Option<(Vec<f64>, f64)> {
    let default = candidate.effect.parameters[0].default.abs();
    let mut step = if default > 0.0 { default.min(0.5 * candidate.high) } else { 1e-3 * candidate.high };
    let mut best: Option<(Vec<f64>, f64)> = None;
    for _ in 0..TRIES {
        let Some(change) = change(engine, board, plant, theta, candidate, (step, direction)) else {
            step *= 0.01;
            continue;
        };
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
        best = (size > 0.0).then_some((change, step));
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
    let (change, step) = best?;
    Some((change.iter().map(|d| -d / step).collect(), step))
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
