//! How many modes a record holds, by likelihood: one more as long as it pays for its unknowns.

use crate::maximum_likelihood::{Fit, MlError, Model, Outputs, fit, start};
use crate::projection::dot;
use crate::record::Record;

/// Numbers of modes tried in vain before the search ends: two close modes may only pay together.
const IN_VAIN: usize = 2;
/// Least damping ratio in its standard deviations.
const SIGNIFICANCE: f64 = 3.0;

/// The fit whose `−2 ln L + unknowns · ln(samples · channels)` (Schwarz 1978) is smallest among 1 …
/// `modes_max` modes.
///
/// # Errors
/// [`MlError`] of one mode when no number of modes can be fitted.
pub fn fit_of_any_order(record: &Record, model: Model, modes_max: usize) -> Result<Fit, MlError> {
    let mut best: Option<(f64, Fit)> = None;
    let (mut first_error, mut in_vain) = (None, 0);
    let outputs = Outputs::new(record);
    for modes in 1..=modes_max {
        let found = start(record, modes).and_then(|start| fit(record, model, &start));
        match found {
            Ok(found) if resolved(&found) => {
                let criterion = criterion(&outputs, record.inputs, model, &found);
                if best.as_ref().is_none_or(|(smallest, _)| criterion < *smallest) {
                    best = Some((criterion, found));
                    in_vain = 0;
                    continue;
                }
            }
            Ok(_) => {}
            Err(error) => {
                first_error.get_or_insert(error);
            }
        }
        in_vain += 1;
        if in_vain > IN_VAIN {
            break;
        }
    }
    best.map(|(_, fit)| fit).ok_or(first_error.unwrap_or(MlError::NoStart { found: 0, asked: 1 }))
}

/// Every mode is significant against its own uncertainty.
pub(crate) fn resolved(fit: &Fit) -> bool {
    (0..fit.poles.len()).all(|k| {
        let sigma = fit.variances(k).1.sqrt();
        fit.damping_ratio(k) > SIGNIFICANCE * sigma
    })
}

/// `−2 ln L + unknowns · ln(samples · channels)`, variances at their best.
pub(crate) fn criterion(outputs: &Outputs, inputs: usize, model: Model, fit: &Fit) -> f64 {
    let (modes, channels) = (fit.poles.len(), outputs.channels.len());
    let unknowns = (2 * modes + channels * model.columns(modes, inputs)) as f64;
    let samples = outputs.present.len() as f64;
    // The likelihood is largest at RSS/N; the deviations of a fit are larger, by the freedom that
    // its unknowns took.
    let squares = fit.residuals.iter().map(|residual| dot(residual, residual) / samples).filter(|square| *square > 0.0);
    samples * squares.map(libm::log).sum::<f64>() + unknowns * libm::log(samples * channels as f64)
}
