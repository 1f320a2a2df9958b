//! Least-squares complex exponential on free decays: one linear prediction for all channels and
//! segments.
//!
//! `y_i(n+p) = −Σ_k β_k y_i(n+k)` for every channel i; the roots of `z^p + Σ β_k z^k` hold the
//! poles of the structure among p. Brown, Allemang, Zimmerman & Mergeay 1979. The order has to be
//! far above two per mode: noise in the regressors bends the prediction, and only surplus roots
//! take it up (BP3A: damping error 47 % with p = 20, 0.17 % with 50, 0.09 % with 200). Which roots
//! are modes is decided by their share of the decay.
//!
//! Cost: p N l for the normal equations, O(p³) for solution and roots.

use crate::gram::gram;
use crate::participation::strongest;
use crate::record::Record;
use crate::ssi_cov::SsiError;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side, c64};

/// Added to the diagonal of the normal equations, relative to its mean: a decay without noise has
/// only as many independent regressors as states.
const JITTER: f64 = 1e-14;
const JITTER_MAX: f64 = 1e-9;
/// Roots beyond this damping ratio are not sought.
const ROOT_DAMPING_RATIO_MAX: f64 = 0.8;
/// Real roots above this are drifts that last, those below die out within some samples.
const SLOW: f64 = 0.5;

/// The `count` oscillations and drifts (imaginary part 0) that explain most, as continuous-time
/// poles [1/s], the strongest first.
///
/// # Errors
/// [`SsiError`] when no segment holds two orders of samples, or all are flat.
pub fn lsce(record: &Record, order: usize, count: usize) -> Result<Vec<c64>, SsiError> {
    let mut normal = Mat::<f64>::zeros(order + 1, order + 1);
    let mut columns = 0;
    for channel in 0..record.channels {
        let samples = record.channel(channel, 0..record.samples());
        let of_channel = gram(&samples, 1, (order + 1).div_ceil(2), &record.segments);
        normal += of_channel.matrix.submatrix(0, 0, order + 1, order + 1);
        columns = of_channel.columns;
    }
    let need = order as u64;
    if columns < need {
        return Err(SsiError::RecordTooShort { columns, need });
    }
    let mean = (0..order).map(|k| normal[(k, k)]).sum::<f64>() / order as f64;
    if mean.is_nan() || mean <= f64::MIN_POSITIVE {
        return Err(SsiError::NoSignal { largest_singular_value: mean });
    }
    let failed = SsiError::DecompositionFailed { rows: order };
    let beta = predictor(&mut normal, mean).ok_or(failed.clone())?;
    // Companion matrix of z^p + Σ β_k z^k (the prediction's sign is in the last column).
    let companion =
        Mat::from_fn(order, order, |r, c| if c + 1 == order { beta[(r, 0)] } else { f64::from(u8::from(r == c + 1)) });
    let roots = companion.eigenvalues().map_err(|_| failed)?;
    let candidates: Vec<c64> = roots.iter().filter_map(|z| continuous(*z, record.sample_rate_hz)).collect();
    Ok(strongest(record, &candidates, count))
}

/// Solution of the normal equations, with as little added to their diagonal as makes them positive.
fn predictor(normal: &mut Mat<f64>, mean: f64) -> Option<Mat<f64>> {
    let order = normal.nrows() - 1;
    let mut jitter = JITTER;
    while jitter <= JITTER_MAX {
        (0..order).for_each(|k| normal[(k, k)] += jitter * mean);
        if let Ok(factor) = normal.submatrix(0, 0, order, order).llt(Side::Lower) {
            return Some(factor.solve(normal.submatrix(0, order, order, 1)));
        }
        jitter *= 10.0;
    }
    None
}

/// The pole of an oscillation or of a slow real decay; `None` for one of a pair, an alternating
/// root, or a fast decay.
fn continuous(z: c64, sample_rate_hz: f64) -> Option<c64> {
    let magnitude = z.norm_sqr();
    if z.im < 0.0 || (z.im == 0.0 && z.re <= SLOW) || magnitude == 0.0 {
        return None;
    }
    let pole = c64::new(0.5 * libm::log(magnitude), libm::atan2(z.im, z.re)) * sample_rate_hz;
    (z.im == 0.0 || pole.re.abs() < ROOT_DAMPING_RATIO_MAX * pole.norm_sqr().sqrt()).then_some(pole)
}
