//! Past-output MOESP: a state space from known inputs and outputs, by the block-Hankel Gram matrix
//! of both.
//!
//! `[1; U_f; W_p; Y_f] = L Q` with `W_p` the past of inputs and outputs; the column space of `L₃₂`
//! (future outputs by past, what the future inputs explain taken out) is that of the observability
//! matrix. Verhaegen 1994. The triangle L is the Cholesky factor of the Gram matrix, so the long
//! data matrix is never formed. A constant row takes up the bias of the sensors; as block rows of
//! their own its copies would be linearly dependent.
//!
//! Fails (biased) when feedback closes around the structure and the noise is large: past noise is
//! then in the future input. Cost: the Gram matrix, then O((i (2 m + 2 l))³/3).

use crate::gram::gram;
use crate::record::Record;
use crate::ssi_cov::{Realisation, SsiError};
use faer::{Mat, Side};

/// Added to the diagonal of the Gram matrix scaled to ones: white noise at 1e-7 of each row.
const JITTER: f64 = 1e-14;

/// Observability matrix of every order up to `order_max` with `block_rows` rows of all outputs.
///
/// # Errors
/// [`SsiError`] when the record is too short or flat.
pub fn po_moesp(record: &Record, block_rows: usize, order_max: usize) -> Result<Realisation, SsiError> {
    let (m, l) = (record.inputs, record.channels);
    let width = m + l;
    let joint: Vec<f64> = record
        .outputs
        .chunks_exact(l)
        .enumerate()
        .flat_map(|(t, y)| record.input[t * m..(t + 1) * m].iter().chain(y).copied())
        .collect();
    let rows = 2 * block_rows * width;
    let whole = 0..record.samples();
    let gram = gram(&joint, width, block_rows, std::slice::from_ref(&whole));
    if gram.columns < rows as u64 {
        return Err(SsiError::RecordTooShort { columns: gram.columns, need: rows as u64 });
    }
    let order = row_order(m, l, block_rows);
    let sums = window_sums(&joint, width, 2 * block_rows);
    let entry = |a: Option<usize>, b: Option<usize>| match (a, b) {
        (Some(a), Some(b)) => gram.matrix[(a, b)],
        (Some(a), None) | (None, Some(a)) => sums[a],
        (None, None) => gram.columns as f64,
    };
    let scale: Vec<f64> = order.iter().map(|a| 1.0 / entry(*a, *a).max(f64::MIN_POSITIVE).sqrt()).collect();
    let matrix = Mat::from_fn(order.len(), order.len(), |p, q| {
        entry(order[p], order[q]) * scale[p] * scale[q] + if p == q { JITTER } else { 0.0 }
    });
    let failed = SsiError::DecompositionFailed { rows: order.len() };
    let factor = matrix.llt(Side::Lower).map_err(|_| failed.clone())?;
    let (inputs, past, future) = (1 + block_rows * m, block_rows * width, block_rows * l);
    // One scale for all future outputs, so that the shift between block rows stays one.
    let l_32 = Mat::from_fn(future, past, |r, c| {
        let row = inputs + past + r;
        factor.L()[(row, inputs + c)] / scale[row]
    });
    Realisation::from_column_space(l_32.as_ref(), l, order_max)
}

/// Rows of the Gram matrix in the order 1, future inputs, past inputs and outputs, future outputs;
/// `None` is the constant.
fn row_order(m: usize, l: usize, block_rows: usize) -> Vec<Option<usize>> {
    let width = m + l;
    let mut order = vec![None];
    let future = block_rows..2 * block_rows;
    order.extend(future.clone().flat_map(|b| (0..m).map(move |k| Some(b * width + k))));
    order.extend((0..block_rows * width).map(Some));
    order.extend(future.flat_map(|b| (0..l).map(move |k| Some(b * width + m + k))));
    order
}

/// Sum over all columns of each row of the block-Hankel matrix.
fn window_sums(joint: &[f64], width: usize, block_rows: usize) -> Vec<f64> {
    let samples = joint.len() / width;
    let columns = samples - block_rows + 1;
    let mut sums = vec![0.0; block_rows * width];
    for row in joint[..columns * width].chunks_exact(width) {
        sums[..width].iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
    for p in 1..block_rows {
        for k in 0..width {
            sums[p * width + k] =
                sums[(p - 1) * width + k] - joint[(p - 1) * width + k] + joint[(p - 1 + columns) * width + k];
        }
    }
    sums
}
