//! Covariance-driven stochastic subspace identification: all model orders from one factorisation.
//!
//! The future–past product `H = Y_f Y_pᵀ` (il × il) is read from the Gram matrix; `H = U S Vᵀ` gives the observability matrix of every
//! order n as the first n columns of `U`. With the shortened matrices `U↑` (last block row missing) and `U↓` (first block row missing) and
//! `U↑ = Q R`, the state matrix of order n is `A_n = R_n⁻¹ (Qᵀ U↓)_n` with leading n × n blocks.
//! Peeters & De Roeck 1999; Döhler & Mevel 2012 (all orders from one QR).
//!
//! A constant accelerometer bias is one more state with its pole at z = 1. The mean of a short decay is never subtracted: that
//! would bend the decay itself (a damping error of 17 % against 0.15 % with the constant kept as a state).

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, c64};

use crate::mac::modal_phase_collinearity;
use crate::streaming::Gram;

/// Singular values below this part of the largest are rounding, not signal: `ε` times the growth of a 400-term product, squared data.
const RANK_FLOOR: f64 = 1e-14;

/// Why no realisation came out.
#[derive(Clone, Debug, PartialEq)]
pub enum SsiError {
    /// The record fills fewer columns than the states asked for need.
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

/// Factorises the future–past product for all orders up to `order_max`.
///
/// # Errors
/// [`SsiError`] when the record is shorter than the states need, is flat, or the decomposition fails.
///
/// Cost: O((il)³) for the singular value decomposition. Memory: a few (il)² matrices.
pub fn realise(gram: &Gram, order_max: usize) -> Result<Realisation, SsiError> {
    let (l, half) = (gram.channels, gram.half());
    let need = 2 * order_max.min(half - l) as u64;
    if gram.columns < need {
        return Err(SsiError::RecordTooShort { columns: gram.columns, need });
    }
    let future_past = gram.matrix.submatrix(half, 0, half, half);
    let svd = future_past.svd().map_err(|_| SsiError::DecompositionFailed { rows: half })?;
    let largest = svd.S().column_vector()[0];
    if !largest.is_finite() {
        return Err(SsiError::DecompositionFailed { rows: half });
    }
    if largest <= f64::MIN_POSITIVE {
        return Err(SsiError::NoSignal { largest_singular_value: largest });
    }
    let singular_values: Vec<f64> = (0..order_max.min(half - l))
        .map(|k| svd.S().column_vector()[k])
        .take_while(|s| *s > RANK_FLOOR * largest)
        .collect();
    let m = singular_values.len();
    let u = svd.U().get(.., ..m).to_owned();
    let v = svd.V().get(.., ..m).to_owned();
    let (upper, lower) = (u.get(..half - l, ..), u.get(l.., ..));
    let qr = upper.qr();
    let q = qr.compute_thin_Q();
    let r = qr.thin_R().to_owned();
    let shift = q.transpose() * lower;
    Ok(Realisation { channels: l, u, v, singular_values, q, r, shift })
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

    /// Poles of order `order`, one of each complex pair, in order of frequency; real poles come with frequency of their decay.
    ///
    /// An order whose eigenvectors are not independent gives no poles.
    #[must_use]
    pub fn poles(&self, order: usize, sample_rate_hz: f64) -> Vec<Pole> {
        assert!(order >= 1);
        assert!(order <= self.order_max());
        let mut a = self.shift.get(..order, ..order).to_owned();
        let r = self.r.get(..order, ..order);
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(r, a.as_mut(), faer::Par::Seq);
        if !all_finite(a.as_ref()) {
            return Vec::new();
        }
        let Ok(eigen) = a.eigen() else { return Vec::new() };
        let right = eigen.U();
        let left = right.partial_piv_lu().solve(Mat::<c64>::identity(order, order));
        let mut poles: Vec<Pole> = (0..order)
            .filter(|&k| eigen.S().column_vector()[k].im >= 0.0)
            .filter_map(|k| {
                let right: Vec<c64> = (0..order).map(|row| right[(row, k)]).collect();
                let left: Vec<c64> = (0..order).map(|column| left[(k, column)]).collect();
                self.pole(order, eigen.S().column_vector()[k], right, left, sample_rate_hz)
            })
            .collect();
        poles.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        poles
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

fn normalised(shape: impl Iterator<Item = c64>) -> Vec<c64> {
    let shape: Vec<c64> = shape.collect();
    let largest =
        shape.iter().copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm_sqr() > a.norm_sqr() { b } else { a });
    if largest.norm_sqr() > 0.0 { shape.into_iter().map(|psi| psi / largest).collect() } else { shape }
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
