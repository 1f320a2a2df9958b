//! Covariance-driven stochastic subspace identification: all model orders from one factorisation.
//!
//! The future–past product `H = Y_f Y_pᵀ` (il × il) is read from the Gram matrix; `H = U S Vᵀ`
//! gives the observability matrix of every order n as the first n columns of `U`. With the
//! shortened matrices `U↑` (last block row missing) and `U↓` (first block row missing) and
//! `U↑ = Q R`, the state matrix of order n is `A_n = R_n⁻¹ (Qᵀ U↓)_n` with leading n × n blocks.
//! Peeters & De Roeck 1999; Döhler & Mevel 2012 (all orders from one QR).
//!
//! A constant accelerometer bias is one more state with its pole at z = 1. The mean of a short
//! decay is never subtracted: that would bend the decay itself (a damping error of 17 % against
//! 0.15 % with the constant kept as a state).

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, c64};

use crate::gram::Gram;
use crate::mac::{modal_phase_collinearity, normalised};

/// Singular values below this part of the largest are rounding, not signal: `ε` times the growth of
/// a 400-term product, squared data.
const RANK_FLOOR: f64 = 1e-14;

/// From this size on the leading singular vectors are iterated instead of decomposing everything.
const SUBSPACE_ROWS_MIN: usize = 450;
/// Vectors iterated beyond the largest order.
const SUBSPACE_SPARE: usize = 20;
/// Each pass reduces the error by the square of the ratio of singular values: a state ten times
/// above the rest is exact to 1e-8.
const SUBSPACE_PASSES: usize = 3;

/// Why no realisation came out.
#[derive(Clone, Debug, PartialEq)]
pub enum SsiError {
    /// The record fills fewer columns than the requested states need.
    RecordTooShort { columns: u64, need: u64 },
    /// All singular values vanish: the channels are flat.
    NoSignal { largest_singular_value: f64 },
    /// The singular value decomposition did not converge.
    DecompositionFailed { rows: usize },
}

impl std::fmt::Display for SsiError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::RecordTooShort { columns, need } => write!(f, "record fills {columns} Hankel columns, {need} needed"),
            Self::NoSignal { largest_singular_value } => {
                write!(f, "no signal: largest singular value {largest_singular_value:e}")
            }
            Self::DecompositionFailed { rows } => write!(f, "decomposition of a {rows}-row matrix did not converge"),
        }
    }
}

impl std::error::Error for SsiError {}

/// Singular vectors of the future–past product and the shift equation of all orders.
#[derive(Clone, Debug)]
pub struct Realisation {
    pub(crate) channels: usize,
    pub(crate) u: Mat<f64>,
    pub(crate) v: Mat<f64>,
    pub(crate) singular_values: Vec<f64>,
    pub(crate) q: Mat<f64>,
    r: Mat<f64>,
    shift: Mat<f64>,
}

/// One eigenvalue of one order, with the eigenvectors its first-order perturbation needs.
#[derive(Clone, Debug)]
pub struct Pole {
    pub order: usize,
    /// Discrete-time eigenvalue at the sample rate of the record.
    pub eigenvalue: c64,
    pub frequency_hz: f64,
    /// Negative for a growing mode.
    pub damping_ratio: f64,
    /// Complex shape per channel, largest component 1.
    pub mode_shape: Vec<c64>,
    pub phase_collinearity: f64,
    /// Part of each channel in the squared shape; sums to 1.
    pub channel_share: Vec<f64>,
    pub(crate) right: Vec<c64>,
    pub(crate) left: Vec<c64>,
}

/// The factorised matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// The future–past product `H = Y_f Y_pᵀ` (SSI-COV).
    Covariance,
    /// The future projected on the past, `Y_f Y_pᵀ (Y_p Y_pᵀ)⁻¹ Y_p` (SSI-DATA, unweighted): with
    /// `Y_p Y_pᵀ = L Lᵀ` its left singular vectors and singular values are those of `H L⁻ᵀ`, so
    /// that the Gram matrix serves and no QR of the data is needed.
    Data,
}

/// Factorises the future–past product for all orders up to `order_max`.
///
/// # Errors
/// [`SsiError`] when the record is shorter than the states need, is flat, or the decomposition
/// fails.
///
/// Cost: O((il)³) for the singular value decomposition. Memory: a few (il)² matrices.
pub fn realise(gram: &Gram, order_max: usize) -> Result<Realisation, SsiError> {
    realise_by(gram, order_max, Projection::Covariance)
}

/// As [`realise`], of a projection.
///
/// # Errors
/// As [`realise`].
pub fn realise_by(gram: &Gram, order_max: usize, projection: Projection) -> Result<Realisation, SsiError> {
    let (l, half) = (gram.channels, gram.half());
    let need = 2 * order_max.min(half - l) as u64;
    if gram.columns < need {
        return Err(SsiError::RecordTooShort { columns: gram.columns, need });
    }
    let of_references = gram.of_references();
    let future_past = match &of_references {
        Some(matrix) => matrix.as_ref(),
        None => gram.matrix.submatrix(half, 0, half, half),
    };
    match projection {
        Projection::Covariance => Realisation::from_column_space(future_past, l, order_max),
        Projection::Data => {
            let factor = past_factor(gram)?;
            // (H L⁻ᵀ)ᵀ = L⁻¹ Hᵀ
            let mut whitened = future_past.transpose().to_owned();
            faer::linalg::triangular_solve::solve_lower_triangular_in_place(
                factor.as_ref(),
                whitened.as_mut(),
                faer::Par::Seq,
            );
            let mut realisation = Realisation::from_column_space(whitened.transpose(), l, order_max)?;
            // Filters on the past act on L⁻¹ of it.
            let upper = factor.transpose();
            faer::linalg::triangular_solve::solve_upper_triangular_in_place(
                upper,
                realisation.v.as_mut(),
                faer::Par::Seq,
            );
            Ok(realisation)
        }
    }
}

/// Cholesky factor of `Y_p Y_pᵀ`. A record with less noise than rounding gets as much as its
/// largest row has of that.
fn past_factor(gram: &Gram) -> Result<Mat<f64>, SsiError> {
    let half = gram.half();
    let past = gram.matrix.submatrix(0, 0, half, half);
    let largest = (0..half).map(|k| past[(k, k)]).fold(0.0, f64::max);
    if largest.is_nan() || largest <= f64::MIN_POSITIVE {
        return Err(SsiError::NoSignal { largest_singular_value: largest });
    }
    let mut floor = 0.0;
    for _ in 0..4 {
        let raised = Mat::from_fn(half, half, |a, b| past[(a, b)] + if a == b { floor * largest } else { 0.0 });
        if let Ok(factor) = raised.llt(faer::Side::Lower) {
            return Ok(factor.L().to_owned());
        }
        floor = if floor == 0.0 { RANK_FLOOR } else { 10.0 * floor };
    }
    Err(SsiError::DecompositionFailed { rows: half })
}

impl Realisation {
    /// From a matrix whose column space is that of the observability matrix (i block rows of
    /// `channels` rows).
    pub(crate) fn from_column_space(h: MatRef<'_, f64>, channels: usize, order_max: usize) -> Result<Self, SsiError> {
        let (l, half) = (channels, h.nrows());
        let failed = SsiError::DecompositionFailed { rows: half };
        let basis = (half >= SUBSPACE_ROWS_MIN && 4 * (order_max + SUBSPACE_SPARE) < half)
            .then(|| leading_columns(h, order_max + SUBSPACE_SPARE));
        let svd = match &basis {
            Some(basis) => (basis.transpose() * h).thin_svd(),
            None => h.thin_svd(),
        };
        let svd = svd.map_err(|_| failed.clone())?;
        let largest = svd.S().column_vector()[0];
        if !largest.is_finite() {
            return Err(failed);
        }
        if largest <= f64::MIN_POSITIVE {
            return Err(SsiError::NoSignal { largest_singular_value: largest });
        }
        let available = order_max.min(half - l).min(svd.S().column_vector().nrows());
        let singular_values: Vec<f64> =
            (0..available).map(|k| svd.S().column_vector()[k]).take_while(|s| *s > RANK_FLOOR * largest).collect();
        let m = singular_values.len();
        let u = svd.U().get(.., ..m).to_owned();
        let u = basis.map_or(u.clone(), |basis| basis * &u);
        let v = svd.V().get(.., ..m).to_owned();
        Ok(Self::from_observability(u, v, singular_values, l))
    }

    /// The shift equation of all orders from one QR of the shortened observability matrix.
    pub(crate) fn from_observability(u: Mat<f64>, v: Mat<f64>, singular_values: Vec<f64>, channels: usize) -> Self {
        let half = u.nrows();
        let (upper, lower) = (u.get(..half - channels, ..), u.get(channels.., ..));
        let qr = upper.qr();
        let q = qr.compute_thin_Q();
        let r = qr.thin_R().to_owned();
        let shift = q.transpose() * lower;
        Self { channels, u, v, singular_values, q, r, shift }
    }
}

impl Pole {
    /// The continuous-time pole [1/s].
    #[must_use]
    pub fn continuous(&self) -> c64 {
        let omega = 2.0 * std::f64::consts::PI * self.frequency_hz;
        let across = (1.0 - self.damping_ratio * self.damping_ratio).max(0.0).sqrt();
        c64::new(-self.damping_ratio * omega, omega * across)
    }
}

impl Realisation {
    /// Largest order that carries signal.
    #[must_use]
    pub fn order_max(&self) -> usize {
        self.singular_values.len()
    }

    /// Leading singular values of the future–past product.
    #[must_use]
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// Poles of order `order`, one of each complex pair, in order of frequency; real poles come
    /// with frequency of their decay.
    ///
    /// An order whose eigenvectors are not independent gives no poles.
    #[must_use]
    pub fn poles(&self, order: usize, sample_rate_hz: f64) -> Vec<Pole> {
        assert!(order >= 1);
        assert!(order <= self.order_max());
        let a = self.state_matrix(order);
        if !all_finite(a.as_ref()) {
            return Vec::new();
        }
        let Ok(eigen) = a.eigen() else { return Vec::new() };
        let right = eigen.U();
        let one_of_each_pair: Vec<usize> = (0..order).filter(|&k| eigen.S().column_vector()[k].im >= 0.0).collect();
        // Rows of the inverse: Uᵀ x = e_k.
        let mut left = Mat::<c64>::zeros(order, one_of_each_pair.len());
        for (column, &k) in one_of_each_pair.iter().enumerate() {
            left[(k, column)] = c64::new(1.0, 0.0);
        }
        right.partial_piv_lu().solve_transpose_in_place(left.as_mut());
        let mut poles: Vec<Pole> = one_of_each_pair
            .iter()
            .enumerate()
            .filter_map(|(column, &k)| {
                let right: Vec<c64> = right.col(k).iter().copied().collect();
                let left: Vec<c64> = left.col(column).iter().copied().collect();
                self.pole(order, eigen.S().column_vector()[k], right, left, sample_rate_hz)
            })
            .collect();
        poles.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        poles
    }

    /// `A_n = R_n⁻¹ (Qᵀ U↓)_n`.
    pub(crate) fn state_matrix(&self, order: usize) -> Mat<f64> {
        let mut a = self.shift.get(..order, ..order).to_owned();
        let r = self.r.get(..order, ..order);
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(r, a.as_mut(), faer::Par::Seq);
        a
    }

    fn pole(&self, order: usize, z: c64, right: Vec<c64>, left: Vec<c64>, sample_rate_hz: f64) -> Option<Pole> {
        let usable = right.iter().chain(&left).all(|x| x.re.is_finite() && x.im.is_finite());
        let magnitude = z.norm_sqr();
        if !usable || magnitude == 0.0 || !magnitude.is_finite() {
            return None;
        }
        // μ = fs ln z
        let mu = c64::new(0.5 * libm::log(magnitude), libm::atan2(z.im, z.re)) * sample_rate_hz;
        let omega = mu.norm_sqr().sqrt();
        let mode_shape = normalised((0..self.channels).map(|c| {
            let mut psi = c64::new(0.0, 0.0);
            for (n, phi) in right.iter().enumerate() {
                psi += *phi * self.u[(c, n)];
            }
            psi
        }));
        let total: f64 = mode_shape.iter().map(c64::norm_sqr).sum();
        Some(Pole {
            order,
            eigenvalue: z,
            frequency_hz: omega / (2.0 * std::f64::consts::PI),
            damping_ratio: if omega > 0.0 { -mu.re / omega } else { 0.0 },
            phase_collinearity: modal_phase_collinearity(&mode_shape),
            channel_share: mode_shape.iter().map(|psi| psi.norm_sqr() / total).collect(),
            mode_shape,
            right,
            left,
        })
    }
}

/// Orthonormal columns that hold the leading left singular vectors of `h` (block power iteration
/// from a fixed start).
fn leading_columns(h: MatRef<'_, f64>, count: usize) -> Mat<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let start = Mat::from_fn(h.ncols(), count, |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    let mut basis = (h * &start).qr().compute_thin_Q();
    for _ in 0..SUBSPACE_PASSES {
        let across = (h.transpose() * &basis).qr().compute_thin_Q();
        basis = (h * &across).qr().compute_thin_Q();
    }
    basis
}

fn all_finite(a: MatRef<'_, f64>) -> bool {
    (0..a.ncols()).all(|c| (0..a.nrows()).all(|r| a[(r, c)].is_finite()))
}

impl Realisation {
    /// `x R_n⁻¹` for a row vector `x` of length n.
    pub(crate) fn solve_transposed(&self, x: &[c64]) -> Vec<c64> {
        let mut solved = x.to_vec();
        for k in 0..x.len() {
            for j in 0..k {
                let known = solved[j];
                solved[k] -= known * self.r[(j, k)];
            }
            solved[k] /= self.r[(k, k)];
        }
        solved
    }
}
