//! From the poles of a fraction to those of weighted least squares, and the noise of the residual.
//!
//! A rational fraction minimises an equation error; its poles are near those of the output error
//! but have no covariance of their own. Poles and weights `1/σ` are refined by turns until the
//! weights are those of the residual. Where that leads away from the fraction's modes, they are
//! kept, and the step of Gauss–Newton that the residual asks for is the error of the model. Where
//! residuals are correlated for no window, the model is not exact either: what it is wrong by
//! depends on the weights, and the distance from the fraction's poles shows it.

use super::leakage;
use super::lines::{Noise, ResponseLines};
use crate::lag_window::{LagWindow, WINDOWS, Window};
use crate::residual_correlation::are_of_windows;
use crate::separable::{Evaluation, search};
use faer::c64;

/// Rounds of weights from residuals and poles from weights.
const ROUNDS_MAX: usize = 12;
/// Rounds of weights of poles that are tried as they are.
const ROUNDS_OF_A_TRIAL: usize = 2;
/// Correlation of the residual that poles tried may leave, relative to that of the poles accepted.
const WORTH_REFINING: f64 = 0.5;
/// Frequencies of a mode above the lines, relative to the last line, from which it is sought: what
/// one beyond the last leaves within the lines the powers of s hold to (1/2)⁶.
const RATIOS_ABOVE: [f64; 3] = [1.1, 1.4, 1.8];
/// Times that the model of what lies above the lines is extended.
const ABOVE_ROUNDS: usize = 3;
/// Damping ratio from which it is sought.
const DAMPING_ABOVE: f64 = 0.01;
/// Relative change of a weight at which the rounds end.
const STEP_SETTLED: f64 = 1e-2;

/// A fit, the weights that its own residuals give, and what its poles miss of least squares.
pub(super) struct Fit {
    pub at: Evaluation,
    pub noise: Noise,
    /// Of (Re λ₁, Im λ₁, …): from the poles to the optimum of the linearised problem; zero at it.
    pub model_error: Vec<f64>,
    /// The window of segments that the lines are seen through.
    pub window: Option<Window>,
    /// The poles are those of the fraction.
    held: bool,
}

impl Fit {
    /// Neighbours with which the window correlates a line.
    pub fn reach(&self) -> usize {
        self.window.map_or(0, |window| window.of_neighbours().len() - 1)
    }

    /// Twice the negative log-likelihood of normal residuals, up to a constant.
    fn cost(&self) -> f64 {
        self.at.squares - 2.0 * self.noise.weights.iter().flatten().map(|w| libm::log(*w)).sum::<f64>()
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
        self.correlations.is_empty() || self.fit.window.is_some()
    }
}

/// The fit that a fraction with these `poles` leads to; `None` where the lines do not determine the
/// poles.
pub(super) fn refined(lines: &ResponseLines, poles: &[c64]) -> Option<Refined> {
    let own = |fit: &Fit| is_near(&fit.at.poles, poles);
    let plain = Refined::new(lines, settled(lines, poles).filter(own).or_else(|| held(lines, poles, ROUNDS_MAX))?);
    let (lines, mut plain) = with_modes_above(lines.clone(), plain);
    if plain.correlations.is_empty() {
        return Some(plain);
    }
    // What the model lacks correlates residuals, too, but not as a window does.
    for window in WINDOWS {
        let seen = lines.clone().seen_through(LagWindow::of(window, lines.segment_s()));
        let better = settled(&seen, &plain.fit.at.poles).filter(|fit| fit.cost() < plain.fit.cost());
        let Some(windowed) = better.map(|fit| Refined::new(&seen, Fit { window: Some(window), ..fit })) else {
            continue;
        };
        let (seen, windowed) = with_modes_above(seen, windowed);
        let expected = leakage::neighbours(&seen, window, &windowed.fit.at, &windowed.fit.noise);
        if are_of_windows(&windowed.correlations, &expected, seen.count()) {
            return Some(windowed);
        }
    }
    if !plain.fit.held {
        let apart = plain.fit.at.poles.iter().zip(poles).map(|(found, fraction)| found - fraction);
        plain.fit.model_error = apart.flat_map(|d| [d.re, d.im]).collect();
    }
    Some(plain)
}

/// The lines with more powers of s, or the fit with a mode above the lines, whichever explains
/// more, while the residual is correlated over more lines than the window makes it and it pays for
/// its unknowns.
///
/// A mode near the last line is one pole; what all farther ones leave, the images of sampling among
/// them, the powers hold.
fn with_modes_above(mut lines: ResponseLines, mut found: Refined) -> (ResponseLines, Refined) {
    for _ in 0..ABOVE_ROUNDS {
        if found.correlations.len() <= found.fit.reach() || found.fit.held {
            break;
        }
        let more = lines.with_more_powers();
        let by_mode = with_mode_above(&lines, &found).map(|fit| (lines.clone(), fit));
        let by_powers = with_powers(&more, &found).map(|fit| (more, fit));
        let best = by_mode.into_iter().chain(by_powers).min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        let Some((of, (_, fit))) = best else { break };
        found = Refined::new(&of, Fit { window: found.fit.window, ..fit });
        lines = of;
    }
    (lines, found)
}

/// Cost and fit with the more powers of `lines`; `None` where they do not pay.
fn with_powers(lines: &ResponseLines, found: &Refined) -> Option<(f64, Fit)> {
    let poles = &found.fit.at.poles;
    let fit = settled(lines, poles).filter(|fit| is_near(&fit.at.poles, poles))?;
    let cost = fit.cost() + lines.price(2 * lines.outputs().len());
    (cost < found.fit.cost()).then_some((cost, fit))
}

/// Cost and fit with a mode above the lines; `None` where it does not pay.
fn with_mode_above(lines: &ResponseLines, found: &Refined) -> Option<(f64, Fit)> {
    let (poles, last) = (&found.fit.at.poles, lines.last());
    let price = lines.price(2 + 2 * lines.outputs().len());
    let of_ratio = |ratio: f64| {
        let above = c64::new(-DAMPING_ABOVE, 1.0) * (ratio * last);
        let start: Vec<c64> = poles.iter().copied().chain([above]).collect();
        let fit = settled(lines, &start)?;
        let stays = is_near(&fit.at.poles[..poles.len()], poles) && fit.at.poles[poles.len()].im > last;
        let cost = fit.cost() + price;
        (stays && cost < found.fit.cost()).then_some((cost, fit))
    };
    RATIOS_ABOVE.into_iter().filter_map(of_ratio).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Every pole within the half-power band of the one it was.
fn is_near(found: &[c64], started: &[c64]) -> bool {
    found.iter().zip(started).all(|(a, b)| (a - b).norm_sqr().sqrt() < -b.re)
}

/// Poles and weights in turn until the weights are those of the residuals.
fn settled(lines: &ResponseLines, poles: &[c64]) -> Option<Fit> {
    let columns = |poles: &[c64]| lines.columns(poles);
    let mut noise = lines.first_noise();
    let mut at = search(&columns, poles, lines.outputs(), &noise.weights)?;
    for _ in 0..ROUNDS_MAX {
        let next = lines.noise(&at, &noise.weights);
        let change = changed(&next.weights, &noise.weights);
        noise = next;
        at = search(&columns, &at.poles.clone(), lines.outputs(), &noise.weights)?;
        if change < STEP_SETTLED {
            break;
        }
    }
    let model_error = vec![0.0; 2 * at.poles.len()];
    Some(Fit { at, noise, model_error, window: None, held: false })
}

/// The poles as they are, the weights those of the residuals.
fn held(lines: &ResponseLines, poles: &[c64], rounds: usize) -> Option<Fit> {
    let evaluate = |weights: &[Vec<f64>]| Evaluation::new(lines.columns(poles), poles, lines.outputs(), weights);
    let mut noise = lines.first_noise();
    let mut at = evaluate(&noise.weights);
    for _ in 0..rounds {
        let next = lines.noise(&at, &noise.weights);
        let change = changed(&next.weights, &noise.weights);
        noise = next;
        at = evaluate(&noise.weights);
        if change < STEP_SETTLED {
            break;
        }
    }
    let (information, score) = at.information(&noise.weights);
    let model_error = crate::maximum_likelihood::solve(&information, &score, 0.0)?;
    Some(Fit { at, noise, model_error, window: None, held: true })
}

fn changed(new: &[Vec<f64>], old: &[Vec<f64>]) -> f64 {
    let change = |(new, old): (&f64, &f64)| (new / old - 1.0).abs();
    new.iter().flatten().zip(old.iter().flatten()).map(change).fold(0.0, f64::max)
}
