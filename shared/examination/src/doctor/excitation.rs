//! Whether the inputs move enough, and independently, for parameters to be found.
//!
//! Order of persistence: number of eigenvalues of the lagged covariance (24 lags, spaced by a
//! quarter of the input's own memory) above a thousandth of the largest. One sine has order 2: it
//! fixes one complex gain, two parameters. No plant is known here; which parameters suffer is said
//! by the plant's own regressor.

use nalgebra::DMatrix;

use super::content::is_input;
use super::{Check, Finding, Severity, short, usable};
use channels::{Channel, Recording, Uniform, common_grid};
use identification::statistics::{correlation_length, mean};

/// Lags of the covariance whose eigenvalues are counted.
const EXCITATION_LAGS: usize = 24;
/// Power of a direction relative to the strongest, 30 dB down.
const POWER_SHARE: f64 = 1e-3;
/// Below this order two complex gains cannot be told apart.
const ORDER_MIN: usize = 4;

/// Order of persistent excitation of each input, and inputs that are collinear.
pub fn examine(recording: &Recording) -> Vec<Finding> {
    let inputs: Vec<&Channel> = usable(recording, 4 * EXCITATION_LAGS).into_iter().filter(|c| is_input(c)).collect();
    let mut findings: Vec<Finding> = inputs.iter().filter_map(|c| order(c)).collect();
    findings.extend(collinear(&inputs));
    findings
}

fn order(channel: &Channel) -> Option<Finding> {
    let u = channel.uniform()?;
    let n = u.value.len();
    let spacing = (libm::round(correlation_length(&u.value) / 4.0) as usize).clamp(1, n / (3 * EXCITATION_LAGS));
    let (m, reach) = (mean(&u.value), spacing * (EXCITATION_LAGS - 1));
    let covariance = DMatrix::from_fn(EXCITATION_LAGS, EXCITATION_LAGS, |i, j| {
        (reach..n).map(|k| (u.value[k - i * spacing] - m) * (u.value[k - j * spacing] - m)).sum::<f64>()
    });
    let eigenvalues = covariance.symmetric_eigenvalues();
    let order = eigenvalues.iter().filter(|v| **v > POWER_SHARE * eigenvalues.max()).count();
    (order < ORDER_MIN).then(|| {
        Finding::new(Check::Excitation, Severity::Warning, &channel.name, order as f64, "-")
            .because(format!(
                "persistently exciting of order {order} ({EXCITATION_LAGS} lags of {} s, 30 dB): {} of a linear plant can be found through it",
                short(spacing as f64 * u.dt_s), if order <= 2 { "two parameters (one complex gain)" } else { "three parameters" }
            ))
            .cure("add frequencies or amplitudes (multisine, pulses of several lengths), or hold the other parameters at their priors")
    })
}

fn collinear(inputs: &[&Channel]) -> Option<Finding> {
    if inputs.len() < 2 {
        return None;
    }
    let grids: Vec<Uniform> =
        inputs[1..].iter().filter_map(|c| common_grid(inputs[0], c, 4 * EXCITATION_LAGS).map(|(_, u)| u)).collect();
    let first = inputs[0].uniform()?;
    let mut columns = vec![first.value];
    columns.extend(grids.into_iter().map(|u| u.value));
    let n = columns.iter().map(Vec::len).min()?;
    let unit: Vec<Vec<f64>> = columns
        .iter()
        .map(|c| {
            let m = mean(&c[..n]);
            let norm = c[..n].iter().map(|v| (v - m) * (v - m)).sum::<f64>().sqrt();
            c[..n].iter().map(|v| if norm > 0.0 { (v - m) / norm } else { 0.0 }).collect()
        })
        .collect();
    let gram =
        DMatrix::from_fn(unit.len(), unit.len(), |i, j| unit[i].iter().zip(&unit[j]).map(|(a, b)| a * b).sum::<f64>());
    let least = gram.symmetric_eigenvalues().min();
    (least < POWER_SHARE).then(|| {
        let others: Vec<&str> = inputs[1..].iter().map(|c| c.name.as_str()).collect();
        Finding::new(Check::Excitation, Severity::Warning, &inputs[0].name, least, "-")
            .with(&others)
            .because(format!(
                "the inputs move together: {} of their joint power is left in one combination",
                short(least)
            ))
            .cure("drive them one after the other, or with different signals; only a sum of their effects can be found")
    })
}
