//! From the poles of a fraction to those of weighted least squares, and the noise of the residual.
//!
//! A rational fraction minimises an equation error; its poles are near those of the output error
//! but have no covariance of their own. Poles and weights `1/σ` are refined by turns until the
//! weights are those of the residual. Where that leads away from the fraction's modes, they are
//! kept, and the step of Gauss–Newton that the residual asks for is the error of the model. Where
//! residuals are correlated for no window, the model is not exact either: what it is wrong by
//! depends on the weights, and the distance from the fraction's poles shows it.

use super::lines::ResponseLines;
use crate::lag_window::LagWindow;
use crate::residual_correlation::are_of_hann_windows;
use crate::separable::{Evaluation, search};
use faer::c64;

/// Rounds of weights from residuals and poles from weights.
const ROUNDS_MAX: usize = 12;
/// Rounds of weights of poles that are tried as they are.
const ROUNDS_OF_A_TRIAL: usize = 2;
/// Correlation of the residual that poles tried may leave, relative to that of the poles accepted.
const WORTH_REFINING: f64 = 0.5;
/// Relative change of a weight at which the rounds end.
const STEP_SETTLED: f64 = 1e-2;

/// A fit, the weights that its own residuals give, and what its poles miss of least squares.
pub(super) struct Fit {
    pub at: Evaluation,
    pub weights: Vec<Vec<f64>>,
    /// Of (Re λ₁, Im λ₁, …): from the poles to the optimum of the linearised problem; zero at it.
    pub model_error: Vec<f64>,
    /// Seen through the window of segments.
    pub windowed: bool,
    /// The poles are those of the fraction.
    held: bool,
}

impl Fit {
    /// Twice the negative log-likelihood of normal residuals, up to a constant.
    fn cost(&self) -> f64 {
        self.at.squares - 2.0 * self.weights.iter().flatten().map(|w| libm::log(*w)).sum::<f64>()
    }
}

/// A fit and what its residual says of the model.
pub(super) struct Refined {
    pub fit: Fit,
    /// Of neighbouring lines; empty where they are white.
    pub correlations: Vec<c64>,
}

impl Refined {
    fn new(lines: &ResponseLines, fit: Fit) -> Self {
        Self { correlations: lines.correlations(&fit.at), fit }
    }

    /// `Σ |ρ|²` of neighbouring lines.
    fn correlated(&self) -> f64 {
        self.correlations.iter().map(|rho| rho.norm_sqr()).sum()
    }

    /// Whether the fraction with these poles, as they are, leaves so much less in the residual that
    /// refining them is worth the work.
    pub fn is_worse_than(&self, lines: &ResponseLines, poles: &[c64]) -> bool {
        let other = held(lines, poles, ROUNDS_OF_A_TRIAL).map(|fit| Refined::new(lines, fit));
        other.is_some_and(|other| other.correlated() < WORTH_REFINING * self.correlated())
    }

    /// The residual is noise alone: white, or as windows make it.
    pub fn is_noise(&self) -> bool {
        self.correlations.is_empty() || self.fit.windowed
    }
}

/// The fit that a fraction with these `poles` leads to; `None` where the lines do not determine the
/// poles.
pub(super) fn refined(lines: &ResponseLines, poles: &[c64]) -> Option<Refined> {
    let own = |fit: &Fit| is_near(&fit.at.poles, poles);
    let mut plain = Refined::new(lines, settled(lines, poles).filter(own).or_else(|| held(lines, poles, ROUNDS_MAX))?);
    if plain.correlations.is_empty() {
        return Some(plain);
    }
    // What the model lacks correlates residuals, too, but not as a window does.
    let seen = lines.clone().seen_through(LagWindow::Hann(lines.segment_s()));
    if let Some(windowed) = settled(&seen, &plain.fit.at.poles).filter(|fit| fit.cost() < plain.fit.cost()) {
        let windowed = Refined::new(&seen, Fit { windowed: true, ..windowed });
        if are_of_hann_windows(&windowed.correlations, seen.count()) {
            return Some(windowed);
        }
    }
    if !plain.fit.held {
        let apart = plain.fit.at.poles.iter().zip(poles).map(|(found, fraction)| found - fraction);
        plain.fit.model_error = apart.flat_map(|d| [d.re, d.im]).collect();
    }
    Some(plain)
}

/// Every pole within the half-power band of the one it was.
fn is_near(found: &[c64], started: &[c64]) -> bool {
    found.iter().zip(started).all(|(a, b)| (a - b).norm_sqr().sqrt() < -b.re)
}

/// Poles and weights in turn until the weights are those of the residuals.
fn settled(lines: &ResponseLines, poles: &[c64]) -> Option<Fit> {
    let columns = |poles: &[c64]| lines.columns(poles);
    let mut weights = lines.first_weights();
    let mut at = search(&columns, poles, lines.outputs(), &weights)?;
    for _ in 0..ROUNDS_MAX {
        let next = lines.weights(&at, &weights);
        let change = changed(&next, &weights);
        weights = next;
        at = search(&columns, &at.poles.clone(), lines.outputs(), &weights)?;
        if change < STEP_SETTLED {
            break;
        }
    }
    let model_error = vec![0.0; 2 * at.poles.len()];
    Some(Fit { at, weights, model_error, windowed: false, held: false })
}

/// The poles as they are, the weights those of the residuals.
fn held(lines: &ResponseLines, poles: &[c64], rounds: usize) -> Option<Fit> {
    let evaluate = |weights: &[Vec<f64>]| Evaluation::new(lines.columns(poles), poles, lines.outputs(), weights);
    let mut weights = lines.first_weights();
    let mut at = evaluate(&weights);
    for _ in 0..rounds {
        let next = lines.weights(&at, &weights);
        let change = changed(&next, &weights);
        weights = next;
        at = evaluate(&weights);
        if change < STEP_SETTLED {
            break;
        }
    }
    let (information, score) = at.information(&weights);
    let model_error = crate::maximum_likelihood::solve(&information, &score, 0.0)?;
    Some(Fit { at, weights, model_error, windowed: false, held: true })
}

fn changed(new: &[Vec<f64>], old: &[Vec<f64>]) -> f64 {
    let change = |(new, old): (&f64, &f64)| (new / old - 1.0).abs();
    new.iter().flatten().zip(old.iter().flatten()).map(change).fold(0.0, f64::max)
}
