//! How much of a misfit is taken as noise: hypotheses from adapted to stated noise.
//!
//! Large disturbances hide slow evidence, small ones overrate it. The whitened normal equations of
//! a map's columns are therefore taken under a few hypotheses, and the common scale of the noise is
//! maximised in closed form:
//!
//! ```text
//! −2 ln p = min over hypotheses of  n ln(χ²/n) + n + ln|S|
//! ```

use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Normal};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Shares of the way from adapted to stated noise: of the inputs, of the colour and jitter of the
/// sensors, of their size. Chosen, no derivation; the last hypothesis is all noise as stated.
const HYPOTHESIS_SHARES: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [0.3, 0.0, 0.0],
    [0.6, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.5, 1.0, 0.0],
    [1.0, 1.0, 0.0],
    [1.0, 1.0, 1.0],
];

/// A noise hypothesis with the normal equations of k columns, unknowns projected off.
pub(crate) struct NoiseHypothesis {
    pub noise: NoiseModel,
    log_determinant: f64,
    /// k × k.
    pub reduced: DMatrix<f64>,
    pub reduced_right: DVector<f64>,
    pub reduced_chi2: f64,
}

impl NoiseHypothesis {
    /// Hypothesis of `noise` from normal equations that hold the columns; `None` where they are not
    /// positive.
    pub fn of(session: &EstimationSession<'_>, theta: &[f64], normal: Normal, noise: &NoiseModel) -> Option<Self> {
        let (u, width) = (normal.unknowns, normal.right.len() - normal.unknowns);
        let chi2 = normal.chi2 + identification::fit::prior_chi2(session, theta);
        let log_determinant = normal.objective - chi2 + session.disturbance_price(noise);
        let (matrix, right) = (normal.matrix, normal.right);
        let factor = Cholesky::new(matrix.view((0, 0), (u, u)).into_owned())?;
        let across = factor.l().solve_lower_triangular(&matrix.view((0, u), (u, width)).into_owned())?;
        let own = factor.l().solve_lower_triangular(&right.rows(0, u).into_owned())?;
        let reduced = matrix.view((u, u), (width, width)) - across.tr_mul(&across);
        let reduced_right = right.rows(u, width) - across.tr_mul(&own);
        Some(Self { noise: noise.clone(), log_determinant, reduced, reduced_right, reduced_chi2: chi2 - own.dot(&own) })
    }

    /// `ln B` of each column alone, in standard deviations of its prior: `½ g²/(1 + m) − ½ ln(1 + m)`
    /// with g and m the score and the information of the projected column.
    pub fn ratings(&self) -> Vec<f64> {
        let of = |k: usize| {
            let (g, m) = (self.reduced_right[k], self.reduced[(k, k)].max(0.0));
            0.5 * g * g / (1.0 + m) - 0.5 * libm::log1p(m)
        };
        (0..self.reduced_right.len()).map(of).collect()
    }

    /// `−2 ln p` for the residual sum of squares `chi2` over `samples`: `n ln(χ²/n) + n + ln|S|`,
    /// scale of the noise maximised.
    pub fn at(&self, chi2: f64, samples: f64) -> f64 {
        samples * libm::log(chi2.max(f64::MIN_POSITIVE) / samples) + samples + self.log_determinant
    }
}

/// Noise from adapted to stated, geometrically; a variance below the stated one stays, and
/// hypotheses are scaled as a whole.
pub(super) fn noise_hypotheses(session: &EstimationSession<'_>, adapted: &NoiseModel) -> Vec<NoiseModel> {
    let jitters = adapted.jitter_s.iter().any(|jitter| *jitter > 0.0);
    let coloured = jitters || adapted.pole.iter().any(|pole| pole.abs() > 0.05);
    let mut noises: Vec<NoiseModel> = Vec::new();
    for [inputs, colour, sizes] in HYPOTHESIS_SHARES {
        if colour == 0.0 && inputs > 0.0 && !coloured {
            continue;
        }
        let mut noise = adapted.clone();
        let lower_variance = |found: &mut [f64], stated: &[f64], share: f64| {
            found.iter_mut().zip(stated).for_each(|(sigma, stated)| {
                *sigma = libm::exp((1.0 - share) * libm::log(*sigma) + share * libm::log(stated.min(*sigma)));
            });
        };
        lower_variance(&mut noise.input_sigma, &session.noise.input_sigma, inputs);
        lower_variance(&mut noise.sensor_sigma, &session.noise.sensor_sigma, sizes);
        noise.pole.iter_mut().chain(&mut noise.jitter_s).for_each(|number| *number *= 1.0 - colour);
        if !noises.contains(&noise) {
            noises.push(noise);
        }
    }
    noises
}
