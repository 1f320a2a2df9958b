//! Poles to start from by a matched scan: the profile likelihood over frequency and damping of one
//! more mode beside those found.
//!
//! At a pole of the grid the mode's response to the inputs is two columns per input; what they
//! explain of the residuals is linear least squares. Unlike a subspace method the scan takes no
//! past output as a regressor, so noise that a controller feeds back biases nothing: a causal
//! response to the input is uncorrelated with the noise of the sample itself.
//!
//! Cost: 2 · inputs · (rank + 2) · 2 N multiply-adds per pole of the grid.

use super::{Evaluation, Feedthrough, Model, Outputs, basis};
use crate::projection::{Basis, dot};
use crate::record::Record;
use faer::c64;
use std::f64::consts::TAU;

/// Damping ratios of the grid. A mode at `r` times the damping of the grid keeps `4 r/(1 + r)²` of
/// its response's power: from 0.3 to 15 % at least 0.7.
const DAMPING_RATIOS: [f64; 2] = [0.01, 0.05];
/// Periods of the lowest frequency that the record holds.
const SCAN_PERIODS_MIN: f64 = 2.0;
/// Highest frequency relative to half the sample rate.
const BAND: f64 = 0.95;

/// The poles of the grid at which the log-likelihood gains most, locally, the best first; at most
/// `count`.
pub(crate) fn scan(record: &Record, model: Model, outputs: &Outputs, poles: &[c64], count: usize) -> Vec<c64> {
    let base = Evaluation::new(record, model, outputs, poles);
    let mut peaks: Vec<(f64, c64)> = Vec::new();
    for damping_ratio in DAMPING_RATIOS {
        let grid = frequencies(record, damping_ratio);
        let pole = |f: &f64| TAU * f * c64::new(-damping_ratio, (1.0 - damping_ratio * damping_ratio).sqrt());
        let gains: Vec<f64> = grid.iter().map(|f| gain(record, outputs, &base, pole(f))).collect();
        let at = |k: usize| gains.get(k).copied().unwrap_or(f64::NEG_INFINITY);
        let local = (0..grid.len()).filter(|k| at(*k) >= at(k.wrapping_sub(1)) && at(*k) > at(k + 1));
        peaks.extend(local.map(|k| (gains[k], pole(&grid[k]))));
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    peaks.into_iter().take(count).map(|(_, pole)| pole).collect()
}

/// From two periods in the record to just below half the sample rate, one half bandwidth or half a
/// line apart.
fn frequencies(record: &Record, damping_ratio: f64) -> Vec<f64> {
    let record_s = record.samples() as f64 / record.sample_rate_hz;
    let (mut f, mut all) = (SCAN_PERIODS_MIN / record_s, Vec::new());
    while f < 0.5 * BAND * record.sample_rate_hz {
        all.push(f);
        f += (damping_ratio * f).max(0.5 / record_s);
    }
    all
}

/// Gain in log-likelihood by a mode at `pole` that the inputs drive.
fn gain(record: &Record, outputs: &Outputs, base: &Evaluation, pole: c64) -> f64 {
    let rows = base.columns.rows;
    let mut columns = Vec::with_capacity(2 * record.inputs * rows);
    for m in 0..record.inputs {
        let u = record.input.iter().skip(m).step_by(record.inputs).copied();
        for half in basis::driven(record.sample_rate_hz, pole, u).chunks_exact(outputs.samples) {
            columns.extend(outputs.present.iter().map(|t| half[*t]));
        }
    }
    explained_by(columns, &base.basis, base)
}

/// Gain in log-likelihood, `Σ_i N/2 ln(RSS_i/RSS_i')`, by further columns over the rows present,
/// what `basis` explains of them taken out.
pub(crate) fn explained_by(mut columns: Vec<f64>, basis: &Basis, base: &Evaluation) -> f64 {
    let rows = base.columns.rows;
    columns.chunks_exact_mut(rows).for_each(|column| {
        basis.project_out(column);
    });
    let beside = Basis::new(columns, rows);
    let gains =
        base.residuals.iter().zip(&base.squares).filter(|(_, before)| **before > 0.0).map(|(residual, before)| {
            let explained = beside.along(residual);
            let left = (before - dot(&explained, &explained)).max(f64::MIN_POSITIVE);
            0.5 * rows as f64 * libm::log(before / left)
        });
    gains.sum()
}

/// The model with the other direct term.
pub(crate) fn other(model: Model) -> Model {
    let feedthrough = match model.feedthrough {
        Feedthrough::SameSample => Feedthrough::NextSample,
        Feedthrough::NextSample => Feedthrough::SameSample,
    };
    Model { feedthrough, ..model }
}
