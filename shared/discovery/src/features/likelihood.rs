//! Likelihood of residual features under a plant, its unknowns' priors and discrepancies of unknown
//! size.
//!
//! `r = features measured − features of the plant ~ N(0, C)`, `C = diag(σ² + τ_g²) + J P Jᵀ`. The
//! three terms are the measurement errors, the discrepancy of any low-order model (one τ for
//! frequencies, one for damping ratios, one for shapes, by maximum likelihood), and the priors of
//! the plant's parameters (J: derivatives of the features by them, P: their variances). With few
//! modes τ decides what is significant: a plant that misses every mode by a per cent is not refuted
//! by peaks known to a millionth, but a change that removes the misses is significant.
//!
//! C is a diagonal and a few columns, and is solved as such (Woodbury): a likelihood costs rows ×
//! columns².

use estimation::golden_section;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Kind of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// ln f.
    Frequency,
    /// ln ζ.
    Damping,
    /// Components of the shape of length 1 across the measured one.
    Shape,
}

impl Group {
    /// All groups, in the order of [`Each`].
    pub const ALL: [Self; 3] = [Self::Frequency, Self::Damping, Self::Shape];

    /// Least and largest ln τ. A plant's damping ratio is never trusted to better than 5 %, its
    /// shape to better than 1 % of its length.
    fn ln_tau(self) -> [f64; 2] {
        match self {
            Self::Frequency => [-12.0, 0.0],
            Self::Damping => [-3.0, 1.5],
            Self::Shape => [-4.6, 0.0],
        }
    }

    /// Plural noun of its features in the report.
    pub fn words(self) -> &'static str {
        match self {
            Self::Frequency => "frequencies",
            Self::Damping => "damping ratios",
            Self::Shape => "shapes",
        }
    }
}

/// One value for each group, in the order of [`Group::ALL`].
pub(super) type Each = [f64; 3];

/// Measured features with what is known about them.
#[derive(Clone)]
pub(super) struct Evidence {
    pub sigma: Vec<f64>,
    pub group: Vec<Group>,
    /// Derivatives of the features by unknowns times their prior sigmas: features × unknowns.
    pub prior: DMatrix<f64>,
}

/// Value of the likelihood for one residual.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likelihood {
    /// −2 ln L without constants.
    pub objective: f64,
    pub tau: Each,
    /// Root mean square of the residual behind the nominal unknowns.
    pub rms: Each,
}

/// Factorised covariance C for one τ.
pub(super) struct Factor {
    /// 1 / diagonal.
    inverse: DVector<f64>,
    /// D⁻¹ P.
    weighted: DMatrix<f64>,
    /// Of 1 + Pᵀ D⁻¹ P.
    middle: Option<Cholesky<f64, Dyn>>,
    log_determinant: f64,
}

impl Factor {
    /// `C⁻¹ r` by Woodbury's identity, O(rows × columns).
    pub fn solve(&self, r: &DVector<f64>) -> DVector<f64> {
        let own = self.inverse.component_mul(r);
        match &self.middle {
            Some(middle) => own - &self.weighted * middle.solve(&(self.weighted.transpose() * r)),
            None => own,
        }
    }

    /// `aᵀ C⁻¹ b`.
    pub fn form(&self, a: &[f64], b: &[f64]) -> f64 {
        DVector::from_row_slice(a).dot(&self.solve(&DVector::from_row_slice(b)))
    }
}

impl Evidence {
    /// C for the discrepancies `tau` of each group, factorised: O(rows × columns²).
    pub fn factor(&self, tau: &Each) -> Factor {
        let n = self.sigma.len();
        let diagonal = |i: usize| {
            let tau = tau[self.group[i] as usize];
            self.sigma[i] * self.sigma[i] + tau * tau
        };
        let inverse = DVector::from_fn(n, |i, _| 1.0 / diagonal(i));
        let mut log_determinant: f64 = -inverse.iter().map(|d| libm::log(*d)).sum::<f64>();
        let mut weighted = self.prior.clone();
        weighted.row_iter_mut().zip(&inverse).for_each(|(mut row, d)| row *= *d);
        let columns = self.prior.ncols();
        let middle = (columns > 0).then(|| {
            let matrix = DMatrix::identity(columns, columns) + self.prior.transpose() * &weighted;
            Cholesky::new(matrix).expect("one and a sum of squares is positive definite")
        });
        if let Some(middle) = &middle {
            log_determinant += 2.0 * middle.l_dirty().diagonal().iter().map(|d| libm::log(*d)).sum::<f64>();
        }
        Factor { inverse, weighted, middle, log_determinant }
    }

    /// Evidence of some of the features.
    pub fn part(&self, rows: &[usize]) -> Self {
        Self {
            sigma: rows.iter().map(|k| self.sigma[*k]).collect(),
            group: rows.iter().map(|k| self.group[*k]).collect(),
            prior: self.prior.select_rows(rows),
        }
    }

    /// With further directions of known variance: their columns times their deviations.
    pub fn with_columns(&self, columns: &DMatrix<f64>) -> Self {
        let (own, more) = (self.prior.ncols(), columns.ncols());
        let prior = DMatrix::from_fn(self.sigma.len(), own + more, |i, j| {
            if j < own { self.prior[(i, j)] } else { columns[(i, j - own)] }
        });
        Self { prior, ..self.clone() }
    }

    /// Some feature belongs to `group`.
    pub fn has(&self, group: Group) -> bool {
        self.group.contains(&group)
    }

    /// Number of features of `group`.
    pub fn count(&self, group: Group) -> usize {
        self.group.iter().filter(|of| **of == group).count()
    }

    /// `−2 ln L` of `residual` for the discrepancies `tau`, without constants.
    pub fn at(&self, residual: &[f64], tau: &Each) -> f64 {
        let factor = self.factor(tau);
        factor.form(residual, residual) + factor.log_determinant
    }

    /// Maximum-likelihood τ of every group by a grid and golden section, in turn: where no prior
    /// couples the groups, once is exact.
    pub fn best(&self, residual: &[f64]) -> Likelihood {
        const GRID: i32 = 24;
        let mut tau: Each = Group::ALL.map(|group| libm::exp(group.ln_tau()[0]));
        let groups: Vec<Group> = Group::ALL.into_iter().filter(|group| self.has(*group)).collect();
        let sweeps = if groups.len() > 1 && self.prior.ncols() > 0 { 2 } else { 1 };
        for group in (0..sweeps).flat_map(|_| groups.iter()) {
            let [low, high] = group.ln_tau();
            let value = |ln_tau: f64| {
                let mut at = tau;
                at[*group as usize] = libm::exp(ln_tau);
                self.at(residual, &at)
            };
            let at = |k: i32| low + (high - low) * f64::from(k) / f64::from(GRID);
            let values: Vec<f64> = (0..=GRID).map(|k| value(at(k))).collect();
            let least = (0..=GRID).min_by(|a, b| values[*a as usize].total_cmp(&values[*b as usize])).unwrap_or(0);
            let ln_tau = golden_section::minimise(at((least - 1).max(0)), at((least + 1).min(GRID)), 20, &value);
            tau[*group as usize] = libm::exp(ln_tau);
        }
        Likelihood { objective: self.at(residual, &tau), tau, rms: self.rms(residual, &tau) }
    }

    /// Residual once the nominal unknowns are estimated.
    pub fn left(&self, residual: &[f64], tau: &Each) -> Vec<f64> {
        let r = DVector::from_row_slice(residual);
        let taken = &self.prior * (self.prior.transpose() * self.factor(tau).solve(&r));
        (r - taken).iter().copied().collect()
    }

    fn rms(&self, residual: &[f64], tau: &Each) -> Each {
        let left = self.left(residual, tau);
        Group::ALL.map(|group| self.rms_of(&left, group))
    }

    /// Root mean square over the features of one group.
    pub fn rms_of(&self, residual: &[f64], group: Group) -> f64 {
        let own: Vec<f64> = residual.iter().zip(&self.group).filter(|(_, g)| **g == group).map(|(r, _)| *r).collect();
        if own.is_empty() { 0.0 } else { identification::statistics::rms(&own) }
    }

    /// Cosine between two directions behind the nominal unknowns.
    pub fn cosine(&self, a: &[f64], b: &[f64], tau: &Each) -> f64 {
        let factor = self.factor(tau);
        let size = (factor.form(a, a) * factor.form(b, b)).sqrt();
        if size > 0.0 { factor.form(a, b) / size } else { 0.0 }
    }
}
