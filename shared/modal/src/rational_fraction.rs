//! Rational fraction polynomials with terms for the transient, on orthogonal polynomials.
//!
//! `A(iω) Y_i = B_i(iω) U + T_i(iω)`: A common to all channels, T_i takes up the motion at the
//! beginning and the end of the record (leakage), which a plain quotient Y/U turns into damping
//! errors of tens of per cent. Richardson & Formenti 1982; Pintelon & Schoukens 2012, ch. 6. Every
//! pass weighs the lines with `1/|A|` of the pass before (Sanathanan & Koerner 1963), which makes
//! the equation error an output error. Frequency responses are the case U = 1.
//!
//! Polynomials in s = iω are orthonormal over the lines by `Re Σ p̄ q` (Forsythe), so
//! `s P_k = Σ_j h_jk P_j` has real coefficients, and the zeros of `Σ a_k P_k` are eigenvalues of
//! the Hessenberg matrix h with `a` taken from its last column: no monomials, no loss of digits
//! with the order.

use crate::projection::{Basis, add, dot};
use crate::record::Record;
use faer::{Mat, c64};

/// Passes of the weighting.
const PASSES: usize = 20;

/// Orders of the fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orders {
    /// Of the denominator: two per mode.
    pub denominator: usize,
    /// Of the numerators: the held input and modes outside the band cost a few terms beyond the
    /// denominator's.
    pub numerator: usize,
    /// Of the transient.
    pub transient: usize,
}

impl Orders {
    /// Two states per mode, four numerator terms more, two transient terms more.
    #[must_use]
    pub fn of_modes(modes: usize) -> Self {
        Self { denominator: 2 * modes, numerator: 2 * modes + 4, transient: 2 * modes + 2 }
    }
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum RfpError {
    /// Fewer lines in the band than the unknowns need.
    TooFewLines { lines: usize, need: usize },
    /// The lines do not determine the polynomials, or the roots did not converge.
    NotDetermined { lines: usize },
}

impl std::fmt::Display for RfpError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooFewLines { lines, need } => write!(f, "{lines} spectral lines in the band, {need} needed"),
            Self::NotDetermined { lines } => write!(f, "{lines} spectral lines do not determine the polynomials"),
        }
    }
}

impl std::error::Error for RfpError {}

/// Poles of a record within a band \[Hz\], from its known inputs where it has any (continuous time,
/// 1/s; one of each pair).
///
/// # Errors
/// [`RfpError`] when the band holds too few lines.
///
/// Cost: lines × samples × channels for the spectra, passes × lines × channels × orders² for the
/// fit.
pub fn of_record(record: &Record, band_hz: (f64, f64), orders: Orders) -> Result<Vec<c64>, RfpError> {
    let samples = record.samples();
    let line_hz = record.sample_rate_hz / samples as f64;
    let first = ((band_hz.0 / line_hz).ceil() as usize).max(1);
    let last = ((band_hz.1 / line_hz).floor() as usize).min(samples / 2);
    let lines: Vec<usize> = (first..=last).collect();
    let omega: Vec<f64> = lines.iter().map(|k| 2.0 * std::f64::consts::PI * line_hz * *k as f64).collect();
    let spectra = |data: &[f64], width: usize| -> Vec<Vec<c64>> {
        (0..width).map(|c| spectrum(data.iter().skip(c).step_by(width).copied(), samples, &lines)).collect()
    };
    let mut known: Vec<(Vec<c64>, usize)> =
        spectra(&record.input, record.inputs).into_iter().map(|u| (u, orders.numerator)).collect();
    known.push((vec![c64::new(1.0, 0.0); lines.len()], orders.transient));
    denominator(&omega, &known, &spectra(&record.outputs, record.channels), orders.denominator)
}

/// Poles of frequency responses (one vector per channel over `frequency_hz`).
///
/// # Errors
/// [`RfpError`] when there are too few lines.
pub fn of_responses(frequency_hz: &[f64], responses: &[Vec<c64>], orders: Orders) -> Result<Vec<c64>, RfpError> {
    let omega: Vec<f64> = frequency_hz.iter().map(|f| 2.0 * std::f64::consts::PI * f).collect();
    let known = [(vec![c64::new(1.0, 0.0); omega.len()], orders.numerator)];
    denominator(&omega, &known, responses, orders.denominator)
}

/// Discrete Fourier transform at some lines.
fn spectrum(values: impl Iterator<Item = f64>, samples: usize, lines: &[usize]) -> Vec<c64> {
    let turn = |k: usize| {
        let (sine, cosine) = libm::sincos(-2.0 * std::f64::consts::PI * k as f64 / samples as f64);
        c64::new(cosine, sine)
    };
    let table: Vec<c64> = (0..samples).map(turn).collect();
    let mut sums = vec![c64::new(0.0, 0.0); lines.len()];
    for (t, y) in values.enumerate() {
        for (sum, line) in sums.iter_mut().zip(lines) {
            *sum += table[t * line % samples] * y;
        }
    }
    sums
}

/// Orthonormal polynomials over the lines and their recurrence.
struct Polynomials {
    /// Values of P₀, P₁, … at every line.
    values: Vec<Vec<c64>>,
    /// `s P_k = Σ_j h[j][k] P_j`, s in units of the largest line.
    recurrence: Mat<f64>,
}

impl Polynomials {
    fn new(s: &[c64], degree: usize) -> Option<Self> {
        let flat = |p: &[c64]| -> Vec<f64> { p.iter().flat_map(|x| [x.re, x.im]).collect() };
        let mut recurrence = Mat::zeros(degree + 1, degree);
        let mut values = vec![vec![c64::new(1.0 / (s.len() as f64).sqrt(), 0.0); s.len()]];
        let mut stacked = vec![flat(&values[0])];
        for k in 0..degree {
            let next: Vec<c64> = s.iter().zip(&values[k]).map(|(s, p)| s * p).collect();
            let mut next = flat(&next);
            let before = dot(&next, &next).sqrt();
            for _ in 0..2 {
                for (j, p) in stacked.iter().enumerate() {
                    let along = dot(p, &next);
                    add(&mut next, -along, p);
                    recurrence[(j, k)] += along;
                }
            }
            let length = dot(&next, &next).sqrt();
            if length.is_nan() || length < 1e-12 * before {
                return None;
            }
            next.iter_mut().for_each(|x| *x /= length);
            recurrence[(k + 1, k)] = length;
            values.push(next.chunks_exact(2).map(|x| c64::new(x[0], x[1])).collect());
            stacked.push(next);
        }
        Some(Self { values, recurrence })
    }

    /// Zeros of `P_n + Σ_{k<n} a_k P_k`.
    fn zeros(&self, a: &[f64]) -> Option<Vec<c64>> {
        let n = a.len();
        let matrix = Mat::from_fn(n, n, |r, c| {
            self.recurrence[(r, c)] - if c + 1 == n { self.recurrence[(n, n - 1)] * a[r] } else { 0.0 }
        });
        matrix.eigenvalues().ok()
    }
}

/// Zeros of A with positive imaginary part, in order of frequency.
fn denominator(
    omega: &[f64],
    known: &[(Vec<c64>, usize)],
    outputs: &[Vec<c64>],
    order: usize,
) -> Result<Vec<c64>, RfpError> {
    let lines = omega.len();
    let linear: usize = known.iter().map(|(_, degree)| degree + 1).sum();
    let need = (linear + order).div_ceil(2) + 1;
    if lines < need {
        return Err(RfpError::TooFewLines { lines, need });
    }
    let undetermined = RfpError::NotDetermined { lines };
    if outputs.iter().flatten().all(|y| y.norm_sqr() == 0.0) {
        return Err(undetermined);
    }
    let scale = omega[lines - 1];
    let s: Vec<c64> = omega.iter().map(|omega| c64::new(0.0, omega / scale)).collect();
    let degree = known.iter().map(|(_, degree)| *degree).fold(order, usize::max);
    let polynomials = Polynomials::new(&s, degree).ok_or_else(|| undetermined.clone())?;
    let mut weights = vec![1.0; lines];
    let mut a = vec![0.0; order];
    for _ in 0..PASSES {
        a = pass(&polynomials, known, outputs, &weights, order);
        for (line, weight) in weights.iter_mut().enumerate() {
            let head = polynomials.values[order][line];
            let sum = a.iter().zip(&polynomials.values).fold(head, |sum, (a, p)| sum + p[line] * *a);
            *weight = 1.0 / sum.norm_sqr().sqrt().max(f64::MIN_POSITIVE);
        }
    }
    let zeros = polynomials.zeros(&a).ok_or(undetermined)?;
    let mut poles: Vec<c64> = zeros.into_iter().filter(|zero| zero.im > 0.0).map(|zero| zero * scale).collect();
    poles.sort_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
    Ok(poles)
}

/// One weighted least squares: coefficients of `P_0 … P_{n−1}` with that of `P_n` one.
fn pass(
    polynomials: &Polynomials,
    known: &[(Vec<c64>, usize)],
    outputs: &[Vec<c64>],
    weights: &[f64],
    order: usize,
) -> Vec<f64> {
    let rows = 2 * weights.len();
    let column = |signal: &[c64], degree: usize| -> Vec<f64> {
        let values = signal.iter().zip(&polynomials.values[degree]).zip(weights);
        values.flat_map(|((x, p), w)| [(x * p).re * w, (x * p).im * w]).collect()
    };
    let linear: Vec<f64> =
        known.iter().flat_map(|(signal, degree)| (0..=*degree).flat_map(|k| column(signal, k))).collect();
    let linear = Basis::new(linear, rows);
    // Channel under channel, what the numerators explain taken out.
    let stacked = |degree: usize| -> Vec<f64> {
        let of_channel = |y: &Vec<c64>| {
            let mut of_channel = column(y, degree);
            linear.project_out(&mut of_channel);
            of_channel
        };
        outputs.iter().flat_map(of_channel).collect()
    };
    let below = Basis::new((0..order).flat_map(&stacked).collect(), rows * outputs.len());
    let mut leading = stacked(order);
    let parts = below.project_out(&mut leading);
    below.coefficients(parts).into_iter().map(|a| -a).collect()
}
