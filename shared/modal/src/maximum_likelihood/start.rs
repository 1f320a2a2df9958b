//! Poles to start from: a subspace method on the few combinations of channels that carry the
//! motion.
//!
//! Block rows look ahead over so many samples; a mode far below the sample rate hardly moves
//! meanwhile. So the rate is halved as often as the record lasts, inputs and outputs behind one
//! filter, which leaves their relation as it is, and the poles that explain most of the record at
//! its full rate are taken; the first that leave it white end the search.

use super::evaluation::{Evaluation, Outputs};
use super::{MlError, Model, correlation};
use crate::decimation::HalfBand;
use crate::gram::gram;
use crate::po_moesp::po_moesp;
use crate::record::Record;
use crate::ssi_cov::{Projection, Realisation, realise_by};
use faer::{Mat, Side, c64};
use std::borrow::Cow;

const BLOCK_ROWS: usize = 20;
/// Samples below which no rate is tried: less than two windows of past and future.
const SAMPLES_MIN: usize = 4 * BLOCK_ROWS;
/// States tried beyond those of the modes: bias, drift, and modes outside the request.
const SPARE_STATES: usize = 3;
/// Correlation of residuals (1: white) below which no slower rate can find a further mode.
const WHITE: f64 = 2.0;
/// Largest damping ratio of a pole that a fit starts from.
const START_DAMPING_RATIO_MAX: f64 = 0.5;

/// Continuous poles of `modes` oscillations: of every rate the least damped of the smallest order
/// that shows as many, of the rates the one whose poles leave the smallest residual.
///
/// # Errors
/// [`MlError::RecordTooShort`] below 80 samples, or with m inputs below `40 (m + l + 1) − 1`, l at
/// most one more than the modes: state the poles and [`fit`](super::fit) at once. [`MlError`] when
/// no order of any rate shows so many.
///
/// Cost: twice that of the full rate, and one linear least squares per rate.
pub fn start(record: &Record, modes: usize) -> Result<Vec<c64>, MlError> {
    // With inputs as many columns as rows, each a window of past and future long.
    let need = match record.inputs {
        0 => SAMPLES_MIN,
        inputs => 2 * BLOCK_ROWS * (inputs + record.channels.min(modes + 1) + 1) - 1,
    };
    if record.samples() < need {
        return Err(MlError::RecordTooShort { samples: record.samples(), need });
    }
    let reduced = reduced(record, modes + 1)?;
    // What moves already is part of the model here, whatever is fitted later.
    let model = Model::FREE;
    let outputs = Outputs::new(&reduced);
    let mut best: Option<(f64, Vec<c64>)> = None;
    let mut found = 0;
    let mut at_rate = Cow::Borrowed(&reduced);
    while at_rate.samples() >= SAMPLES_MIN {
        match of_rate(&at_rate, modes) {
            Ok(poles) => {
                let evaluation = Evaluation::new(&reduced, model, &outputs, &poles);
                let left: f64 = evaluation.squares.iter().sum();
                if best.as_ref().is_none_or(|(smallest, _)| left < *smallest) {
                    best = Some((left, poles));
                }
                if correlation(&evaluation.residuals) < WHITE {
                    break;
                }
            }
            Err(MlError::NoStart { found: here, .. }) => found = found.max(here),
            Err(error) => return Err(error),
        }
        at_rate = Cow::Owned(halved(&at_rate));
    }
    best.map(|(_, poles)| poles).ok_or(MlError::NoStart { found, asked: modes })
}

fn of_rate(record: &Record, modes: usize) -> Result<Vec<c64>, MlError> {
    let order_max = 2 * modes + SPARE_STATES;
    let realisation = if record.inputs > 0 {
        po_moesp(record, BLOCK_ROWS, order_max)
    } else {
        let all = gram(&record.outputs, record.channels, BLOCK_ROWS, &record.segments);
        realise_by(&all, order_max, Projection::Covariance)
    };
    let realisation = realisation.map_err(|_| MlError::NoStart { found: 0, asked: modes })?;
    let mut found = 0;
    for order in 2 * modes..=realisation.order_max().min(order_max) {
        let poles = oscillations(&realisation, order, record.sample_rate_hz);
        if poles.len() >= modes {
            return Ok(poles[..modes].to_vec());
        }
        found = found.max(poles.len());
    }
    Err(MlError::NoStart { found, asked: modes })
}

/// Every second sample of inputs and outputs behind one filter; segments of a driven record are of
/// no use to its method.
fn halved(record: &Record) -> Record {
    let (m, l) = (record.inputs, record.channels);
    let whole = std::iter::once(0..record.samples()).collect::<Vec<_>>();
    let mut next = Record { outputs: Vec::new(), input: Vec::new(), segments: Vec::new(), ..record.clone() };
    next.sample_rate_hz *= 0.5;
    let mut filter = HalfBand::new(m + l);
    let mut row = vec![0.0; m + l];
    for segment in if m > 0 { &whole } else { &record.segments } {
        filter.clear();
        let begin = next.samples();
        for t in segment.clone() {
            row[..m].copy_from_slice(&record.input[t * m..(t + 1) * m]);
            row[m..].copy_from_slice(&record.outputs[t * l..(t + 1) * l]);
            if let Some(output) = filter.push(&row) {
                next.input.extend(&output[..m]);
                next.outputs.extend(&output[m..]);
            }
        }
        next.segments.push(begin..next.samples());
    }
    next
}

/// Oscillations of one order, the least damped first.
fn oscillations(realisation: &Realisation, order: usize, sample_rate_hz: f64) -> Vec<c64> {
    let mut poles: Vec<(f64, c64)> = realisation
        .poles(order, sample_rate_hz)
        .iter()
        .filter(|pole| pole.eigenvalue.im > 0.0 && pole.damping_ratio.abs() < START_DAMPING_RATIO_MAX)
        .map(|pole| (pole.damping_ratio.abs(), pole.continuous()))
        .collect();
    poles.sort_by(|a, b| a.0.total_cmp(&b.0));
    poles.into_iter().map(|(_, pole)| pole).collect()
}

/// The `count` combinations of channels with most power.
fn reduced(record: &Record, count: usize) -> Result<Record, MlError> {
    let l = record.channels;
    if l <= count {
        return Ok(record.clone());
    }
    let mut power = Mat::<f64>::zeros(l, l);
    for row in record.outputs.chunks_exact(l) {
        for a in 0..l {
            for b in 0..=a {
                power[(a, b)] += row[a] * row[b];
            }
        }
    }
    let eigen = power.self_adjoint_eigen(Side::Lower).map_err(|_| MlError::NoSignal)?;
    let outputs = record.outputs.chunks_exact(l).flat_map(|row| {
        let eigen = &eigen;
        (l - count..l).map(move |k| row.iter().enumerate().map(|(c, y)| eigen.U()[(c, k)] * y).sum())
    });
    Ok(Record { channels: count, outputs: outputs.collect(), ..record.clone() })
}
