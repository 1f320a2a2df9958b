//! Inputs that answer to outputs: a controller's law posing as a measured input.
//!
//! Two proofs. (1) The law itself: u is a function of y_k, y_(k-1), y_(k-2), their sum and a cube,
//! with a residual below what the noise of y would leave if u had not been computed from the
//! *measured* y (the argument of `derived`). (2) The direction in time: the part of u that its own
//! past of 48 samples does not predict is predicted by the past of y. An open-loop command knows
//! nothing of the noise in y; a plant's answer y follows u and helps with neither.

use super::content::is_input;
use super::derived::{OwnNoise, own_noise_below};
use super::{Check, FALSE_ALARM, Finding, Severity, quantity, short, usable};
use channels::{Channel, Recording, Uniform, common_grid};
use identification::statistics::{LeastSquares, deviation, fisher_tail, least_squares, mean, rms};

/// Past samples of the input, and of the outputs, that predict the input.
const OWN_LAGS: usize = 48;
const OUTPUT_LAGS: usize = 3;
/// Rows of the regression on the past; longer recordings are thinned evenly.
const FEEDBACK_ROWS_MAX: usize = 12_000;
/// Share of the unpredicted part of u that the outputs' past must predict.
const SHARE_MIN: f64 = 0.5;
const OUTPUTS_MAX: usize = 12;

/// Inputs that depend on earlier outputs: a feedback loop was closed during the recording.
pub fn examine(recording: &Recording) -> Vec<Finding> {
    let channels = usable(recording, 200);
    let outputs: Vec<&Channel> = channels.iter().copied().filter(|c| !is_input(c)).take(OUTPUTS_MAX).collect();
    let inputs: Vec<&Channel> = channels.iter().copied().filter(|c| is_input(c)).collect();
    let alpha = FALSE_ALARM / (2 * inputs.len().max(1) * outputs.len().max(1)) as f64;
    let mut findings = Vec::new();
    for input in inputs {
        let mut best: Option<Finding> = None;
        for output in &outputs {
            let Some((u, y)) = common_grid(input, output, 200) else { continue };
            let found = law(input, output, &u, &y, alpha).or_else(|| direction(input, output, &u, &y, alpha));
            if let Some(finding) = found
                && best.as_ref().is_none_or(|b| finding.value > b.value)
            {
                best = Some(finding);
            }
        }
        findings.extend(best);
    }
    findings
}

fn rows(n: usize, first: usize) -> Vec<usize> {
    (first..n).step_by((n - first).div_ceil(FEEDBACK_ROWS_MAX)).collect()
}

/// Position or rate: a force reaches it only through time. An accelerometer holds the force of the
/// same instant, which looks like feedback and is not.
fn moves(output: &Channel) -> bool {
    quantity::of_channel(output)
        .is_some_and(|q| matches!(q.kind, quantity::Kind::Angle | quantity::Kind::Length) && q.order < 2)
}

/// `u_k = h_0 y_k + h_1 y_(k-1) + h_2 y_(k-2) + k_i Σ y + k_3 y³ + c` on the samples where u is not
/// at its limits.
fn law(input: &Channel, output: &Channel, u: &Uniform, y: &Uniform, alpha: f64) -> Option<Finding> {
    let OwnNoise { sigma, freedom: noise_freedom, share_max } =
        own_noise_below(&y.value, 0.5).filter(|_| moves(output))?;
    let (low, high) = u.value.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let limited = |v: f64| v == low || v == high;
    let rows: Vec<usize> = rows(u.value.len(), 2).into_iter().filter(|&k| !limited(u.value[k])).collect();
    if rows.len() < 100 {
        return None;
    }
    let centre = mean(&y.value);
    let sum: Vec<f64> = y
        .value
        .iter()
        .scan(0.0, |s, v| {
            *s += v - centre;
            Some(*s)
        })
        .collect();
    let pick = |f: &dyn Fn(usize) -> f64| rows.iter().map(|&k| f(k)).collect::<Vec<f64>>();
    let columns = vec![
        pick(&|k| y.value[k] - centre),
        pick(&|k| y.value[k - 1] - centre),
        pick(&|k| y.value[k - 2] - centre),
        pick(&|k| sum[k]),
        pick(&|k| (y.value[k] - centre) * (y.value[k] - centre) * (y.value[k] - centre)),
        vec![1.0; rows.len()],
    ];
    let fit = least_squares(&columns, &pick(&|k| u.value[k]), 0)?;
    let gain = fit.coefficients[..3].iter().map(|h| h * h).sum::<f64>().sqrt();
    let freedom = (rows.len() - fit.rank) as f64;
    let share = fit.residual.iter().map(|e| e * e).sum::<f64>() / freedom / (sigma * gain).powi(2).max(1e-300);
    if fit.r2 < 0.5 || share > share_max || fisher_tail(1.0 / share, noise_freedom, freedom) > alpha {
        return None;
    }
    Some(report(
        input,
        output,
        u,
        &fit,
        fit.r2,
        format!(
            "residual {} {} where an independent command would keep {}",
            short(rms(&fit.residual)),
            input.unit,
            short(sigma * gain)
        ),
    ))
}

/// The past of y predicts what the past of u does not.
fn direction(input: &Channel, output: &Channel, u: &Uniform, y: &Uniform, alpha: f64) -> Option<Finding> {
    let own = OWN_LAGS.min(u.value.len() / 12);
    let rows = rows(u.value.len(), own);
    let (mu, my) = (mean(&u.value), mean(&y.value));
    let lagged = |x: &[f64], m: f64, lag: usize| rows.iter().map(|&k| x[k - lag] - m).collect::<Vec<f64>>();
    let target = lagged(&u.value, mu, 0);
    let mut columns: Vec<Vec<f64>> = (1..=own).map(|lag| lagged(&u.value, mu, lag)).collect();
    let alone = least_squares(&columns, &target, 0)?;
    // A command that its own past fixes (a sine, a profile of steps held for long) has no news for
    // which y could be the reason.
    if rms(&alone.residual) < 0.03 * deviation(&u.value) {
        return None;
    }
    columns.extend((1..=OUTPUT_LAGS).map(|lag| lagged(&y.value, my, lag)));
    let both = least_squares(&columns, &target, 0)?;
    let (before, after) = (rms(&alone.residual).powi(2), rms(&both.residual).powi(2));
    let share = 1.0 - after / before;
    let freedom = (rows.len() - both.rank) as f64;
    let f = (before - after) / after.max(1e-300) * freedom / OUTPUT_LAGS as f64;
    if share < SHARE_MIN || fisher_tail(f, OUTPUT_LAGS as f64, freedom) > alpha {
        return None;
    }
    let law = LeastSquares { coefficients: both.coefficients[own..].to_vec(), ..both };
    Some(report(
        input,
        output,
        u,
        &law,
        share,
        format!(
            "the last {OUTPUT_LAGS} samples of {} predict {} % of what {own} past samples of {} do not",
            output.name,
            short(100.0 * share),
            input.name
        ),
    ))
}

fn report(input: &Channel, output: &Channel, u: &Uniform, fit: &LeastSquares, value: f64, how: String) -> Finding {
    let h = &fit.coefficients;
    let (proportional, rate) = (h[0] + h[1] + h[2], -(h[1] + 2.0 * h[2]) * u.dt_s);
    Finding::new(Check::Feedback, Severity::Warning, &input.name, value, "-")
        .with(&[&output.name])
        .because(format!(
            "{} answers to {}: about {} {} per {} and {} per ({})/s (R2 = {}); {how}",
            input.name, output.name, short(proportional), input.unit, output.unit, short(rate), output.unit, short(value)
        ))
        .cure("closed loop: the input carries the sensor's noise. Fit with the loop in the model, or with an instrument (the reference), never by regression on this input")
}
