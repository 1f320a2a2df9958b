//! Poles to start from: a subspace method on the few combinations of channels that carry the motion.

use super::MlError;
use crate::gram::gram;
use crate::po_moesp::po_moesp;
use crate::record::Record;
use crate::ssi_cov::{Projection, Realisation, realise_by};
use faer::{Mat, Side, c64};

/// Block rows: a tenth of a second at 200 Hz.
const BLOCK_ROWS: usize = 20;
/// States tried beyond those of the modes: bias, drift, and modes that are not asked for.
const SPARE_STATES: usize = 3;
/// Damping ratio above which an oscillation is none to start from.
const DAMPING_MAX: f64 = 0.5;

/// Continuous poles of `modes` oscillations, the least damped of the smallest order that shows as many.
///
/// # Errors
/// [`MlError`] when no order shows so many.
pub fn start(record: &Record, modes: usize) -> Result<Vec<c64>, MlError> {
    let reduced = reduced(record, modes + 1)?;
    let order_max = 2 * modes + SPARE_STATES;
    let realisation = if record.inputs > 0 {
        po_moesp(&reduced, BLOCK_ROWS, order_max)
    } else {
        let all = gram(&reduced.outputs, reduced.channels, BLOCK_ROWS, &reduced.segments);
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

/// Oscillations of one order, the least damped first.
fn oscillations(realisation: &Realisation, order: usize, sample_rate_hz: f64) -> Vec<c64> {
    let mut poles: Vec<(f64, c64)> = realisation
        .poles(order, sample_rate_hz)
        .iter()
        .filter(|pole| pole.eigenvalue.im > 0.0 && pole.damping_ratio.abs() < DAMPING_MAX)
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
