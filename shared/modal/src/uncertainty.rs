//! Standard deviations of frequency and damping of poles from covariance-driven subspace
//! identification.
//!
//! To first order a pole moves by `δz = q δH r = Σ_t e_t c_t`, with `e_t = q y_f(t)`,
//! `c_t = r y_p(t)`, where `H` is the future–past product,
//! `q = (χ U↑⁺ [rows below] − z χ U↑⁺ [rows above]) (I − U Uᵀ)` and `r = V S⁻¹ φ` (χ, φ the left
//! and right eigenvectors). Pintelon, Guillaume & Schoukens 2007; Reynders, Pintelon & De Roeck
//! 2008; Döhler & Mevel 2013. `q` is blind to the states, so `e_t` is the new part of the future
//! window: sensor noise on a free decay, innovations on an ambient record. In both cases `e_t` and
//! `e_{t+k}` are independent from k = i on, and `e_t c_{t+k}` and `c_t e_{t+k}` are never both
//! correlated, so that (Bartlett)
//!
//! `E|δz|² = Σ_{|k|<i} ρ_eē(k) S_cc̄(k)`, `E δz² = Σ_{|k|<i} ρ_ee(k) S_cc(k)`,
//! `S_xy(k) = Σ_t x_t y_{t+k}` over pairs of columns of the record.
//!
//! `S_c` is read from the Gram matrix and the tails of the segments. `ρ_e` has two forms. When the
//! residual outside the states is indistinguishable from white noise, `ρ_e` follows from its
//! covariance `Σ₀` alone, `ρ(k) = Σ_m q_{m+k} Σ₀ q_mᴴ`; this matters because `q` has zeros at the
//! poles, the sum over k nearly cancels, and a sampled `ρ_e` would leave mostly its own error.
//! Otherwise `ρ_e` is sampled.
//!
//! On a record with enough blocks the spread of `q H_b r` over the blocks gives a second,
//! assumption-free estimate that also sees non-stationary excitation. It is reported where it is
//! larger by more than chance: over B blocks of a stationary record its square is χ² of B − 1
//! degrees of freedom.
//!
//! Fails (too small) when an unmodelled mode biases the pole; too few blocks give no second
//! estimate.

use faer::{Accum, Mat, Par, Scale, c64};

use crate::adequacy::chi_square_tail;
use crate::gram::Gram;
use crate::pairs::PairCovariances;
use crate::ssi_cov::{Pole, Realisation};
use crate::stretch::Stretch;

/// A residual is called white when the mean square of its lagged correlations is below this many
/// times that of white noise, 1/Nc: with only 40 independent lags (one channel) the ratio scatters
/// by 0.22, so that 2 is more than four standard deviations.
const WHITENESS_RATIO_MAX: f64 = 2.0;
/// Probability that the spread over the blocks of a stationary record is reported. The larger of
/// both would be wider than the truth by `0.4 (2 (B − 1))^(−1/2)` on average, 6 % at 24 blocks.
const SPREAD_CHANCE: f64 = 0.01;

/// Standard deviations of one pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleDeviation {
    /// The residual beside the pole's states is white: the model is complete.
    pub complete: bool,
    pub sigma_frequency_hz: f64,
    pub sigma_damping: f64,
    /// Of the errors of frequency and damping; 0 if the moments do not determine it.
    pub correlation: f64,
    /// Least phase coherence of the pole over blocks of pairs, in deviations of chance; infinite
    /// where pairs were not chosen.
    pub coherence: f64,
}

impl PoleDeviation {
    /// Variance of frequency and damping relative to the one of an ambient record, which grows with
    /// ζ.
    ///
    /// `((σ_f/f)² + σ_ζ²) / ζ`. Without the division a choice by smallest deviation would prefer
    /// poles whose damping came out too low.
    #[must_use]
    pub fn relative_to_ideal(&self, pole: &Pole) -> f64 {
        relative_variance(self.sigma_frequency_hz / pole.frequency_hz, self.sigma_damping, pole.damping_ratio)
    }
}

/// `((σ_f/f)² + σ_ζ²) / ζ`.
pub(crate) fn relative_variance(sigma_frequency: f64, sigma_damping: f64, damping_ratio: f64) -> f64 {
    (sigma_frequency * sigma_frequency + sigma_damping * sigma_damping) / damping_ratio
}

/// Parts of a record, whose spread along it gives deviations.
#[derive(Clone, Copy)]
pub enum Blocks<'a> {
    /// Of whole windows; none when there are few.
    Windows(&'a [BlockProduct]),
    /// Of pairs of samples, at one rate.
    Pairs(&'a PairCovariances),
}

/// `H_b V` of a block of whole windows (il × n): all that first-order deviations ask of its
/// future–past product, because every `r` lies in the span of V.
#[derive(Clone, Debug)]
pub struct BlockProduct {
    columns: u64,
    future_past: Mat<f64>,
}

impl BlockProduct {
    /// Cost: 2 (il)² n.
    #[must_use]
    pub fn new(block: &Stretch, realisation: &Realisation) -> Self {
        let block_rows = realisation.u.nrows() / realisation.channels;
        Self { columns: block.columns(), future_past: block.product(block_rows, realisation.v.as_ref()) }
    }

    /// `F_kᵀ H_b r_k` for pairs of columns of `filters` (real and imaginary part) and the vectors
    /// `r_k = V along_k`.
    pub(crate) fn moves<'a>(&self, filters: &Mat<f64>, along: impl Iterator<Item = &'a [c64]>) -> Vec<c64> {
        let across = self.future_past.transpose() * filters;
        let of = |(k, along): (usize, &[c64])| {
            let parts = across.col_as_slice(2 * k).iter().zip(across.col_as_slice(2 * k + 1));
            along.iter().zip(parts).fold(c64::new(0.0, 0.0), |sum, (r, (re, im))| sum + c64::new(*re, *im) * r)
        };
        along.enumerate().map(of).collect()
    }
}

/// Factor from the sum of squares over the blocks about their mean to the variance over `columns`;
/// `None` where there are fewer than two.
pub(crate) fn spread_scale(blocks: &[BlockProduct], columns: u64) -> Option<f64> {
    let count = blocks.len() as f64;
    let in_blocks: u64 = blocks.iter().map(|block| block.columns).sum();
    (blocks.len() > 1).then(|| count / (count - 1.0) * columns as f64 / in_blocks as f64)
}

/// Second moments of a complex first-order deviation: `E|δz|²` and `E δz²`.
#[derive(Clone, Copy)]
struct Moments {
    absolute: f64,
    plain: c64,
}

/// Filters `q` (on the future) and `r` (on the past) of one pole.
struct Sensitivity {
    q: Vec<c64>,
    r: Vec<c64>,
    /// `S⁻¹ φ`: r in the columns of V.
    along: Vec<c64>,
}

/// Deviations of `poles`, in their order.
///
/// Cost per pole: 8 (il)² multiply-adds, in one matrix product for all poles; per block 2 il n.
#[must_use]
pub fn pole_deviations(
    gram: &Gram,
    blocks: Blocks<'_>,
    realisation: &Realisation,
    poles: &[&Pole],
    sample_rate_hz: f64,
) -> Vec<PoleDeviation> {
    let sensitivities: Vec<Sensitivity> = poles.iter().map(|pole| sensitivity(realisation, pole)).collect();
    let products = match blocks {
        Blocks::Windows(products) => products,
        Blocks::Pairs(lags) => {
            let moments = pair_moments(lags, gram.columns, &sensitivities);
            let both = poles.iter().zip(moments).zip(&sensitivities);
            return both
                .map(|((pole, moments), s)| PoleDeviation {
                    coherence: coherence(lags, &modal_filter(realisation, pole), &s.r),
                    ..deviation(pole, moments, sample_rate_hz)
                })
                .collect();
        }
    };
    let mut orders: Vec<usize> = poles.iter().map(|pole| pole.order).collect();
    orders.sort_unstable();
    orders.dedup();
    let of_orders: Vec<Residual> = orders.iter().map(|order| residual(gram, realisation, *order)).collect();
    let residuals: Vec<&Residual> = poles
        .iter()
        .map(|pole| &of_orders[orders.binary_search(&pole.order).expect("every order of a pole is in the list")])
        .collect();
    let bartlett = bartlett_moments(gram, &residuals, &sensitivities);
    let spread = block_moments(products, gram.columns, &sensitivities);
    poles
        .iter()
        .enumerate()
        .map(|(index, pole)| {
            let mut deviation = deviation(pole, bartlett[index], sample_rate_hz);
            deviation.complete = residuals[index].is_white();
            if let Some(spread) = &spread {
                let other = self::deviation(pole, spread[index], sample_rate_hz);
                let degrees = (products.len() - 1) as f64;
                deviation.sigma_frequency_hz =
                    unless_chance(deviation.sigma_frequency_hz, other.sigma_frequency_hz, degrees);
                deviation.sigma_damping = unless_chance(deviation.sigma_damping, other.sigma_damping, degrees);
            }
            deviation
        })
        .collect()
}

/// The `spread` where a stationary record with the deviation `sampled` has one as large less often
/// than [`SPREAD_CHANCE`].
fn unless_chance(sampled: f64, spread: f64, degrees: f64) -> f64 {
    let ratio = spread / sampled;
    // Written so that a ratio that is not finite takes the spread.
    let is_chance = chi_square_tail(degrees * ratio * ratio, degrees) >= SPREAD_CHANCE;
    if is_chance { sampled } else { spread.max(sampled) }
}

/// `δμ = fs δz / z`, `δω = Re(μ̄ δμ)/ω`, `δζ = −Re(δμ)/ω − ζ δω/ω`: real parts of fixed multiples
/// of `δz`.
fn deviation(pole: &Pole, moments: Moments, sample_rate_hz: f64) -> PoleDeviation {
    let omega = 2.0 * std::f64::consts::PI * pole.frequency_hz;
    let zeta = pole.damping_ratio;
    let mu = c64::new(-zeta * omega, omega * (1.0 - zeta * zeta).max(0.0).sqrt());
    let per_z = c64::new(sample_rate_hz, 0.0) / pole.eigenvalue;
    let to_omega = mu.conj() * per_z / omega;
    let to_zeta = -per_z / omega - to_omega * (zeta / omega);
    // Var Re(a δz) = ½ (|a|² E|δz|² + Re(a² E δz²))
    let sigma = |a: c64| (0.5 * (a.norm_sqr() * moments.absolute + (a * a * moments.plain).re)).max(0.0).sqrt();
    let (sigma_omega, sigma_damping) = (sigma(to_omega), sigma(to_zeta));
    // Cov(Re(a δz), Re(b δz)) = ½ Re(a b̄ E|δz|² + a b E δz²)
    let both = to_omega * to_zeta.conj() * moments.absolute + to_omega * to_zeta * moments.plain;
    let correlation = 0.5 * both.re / (sigma_omega * sigma_damping);
    PoleDeviation {
        coherence: f64::INFINITY,
        complete: false,
        sigma_frequency_hz: sigma_omega / (2.0 * std::f64::consts::PI),
        sigma_damping,
        correlation: if correlation.abs() < 1.0 { correlation } else { 0.0 },
    }
}

fn sensitivity(realisation: &Realisation, pole: &Pole) -> Sensitivity {
    let (l, n) = (realisation.channels, pole.order);
    let half = realisation.u.nrows();
    // g = χ U↑⁺ = χ R⁻¹ Qᵀ
    let chi_r = realisation.solve_transposed(&pole.left);
    let g: Vec<c64> = (0..half - l).map(|row| combine(&realisation.q, row, &chi_r)).collect();
    let mut q = vec![c64::new(0.0, 0.0); half];
    for (row, g) in g.iter().enumerate() {
        q[row + l] += g;
        q[row] -= pole.eigenvalue * g;
    }
    for column in 0..n {
        let mut along = c64::new(0.0, 0.0);
        for (row, q) in q.iter().enumerate() {
            along += *q * realisation.u[(row, column)];
        }
        for (row, q) in q.iter_mut().enumerate() {
            *q -= along * realisation.u[(row, column)];
        }
    }
    let along = along_states(realisation, pole);
    let r = (0..half).map(|row| combine(&realisation.v, row, &along)).collect();
    Sensitivity { q, r, along }
}

/// `S⁻¹ φ`.
pub(crate) fn along_states(realisation: &Realisation, pole: &Pole) -> Vec<c64> {
    pole.right.iter().zip(&realisation.singular_values).map(|(phi, s)| *phi / *s).collect()
}

fn combine(matrix: &Mat<f64>, row: usize, weights: &[c64]) -> c64 {
    let mut sum = c64::new(0.0, 0.0);
    for (column, weight) in weights.iter().enumerate() {
        sum += *weight * matrix[(row, column)];
    }
    sum
}

/// Sensor noise as the residual outside the states shows it.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Covariance of one sample, l × l, row by row.
    pub covariance: Vec<f64>,
    /// Mean square of the lagged correlations relative to white noise.
    pub whiteness_ratio: f64,
}

impl Residual {
    /// The whiteness ratio of the residuals is below `WHITENESS_RATIO_MAX`.
    #[must_use]
    pub fn is_white(&self) -> bool {
        self.whiteness_ratio < WHITENESS_RATIO_MAX
    }
}

/// Residual of the past outside the first `order` states, `(I − U Uᵀ) G_pp (I − U Uᵀ) / Nc
/// = (G_pp − U Dᵀ − D Uᵀ) / Nc`, `D = G_pp U − ½ U Uᵀ G_pp U`, one block column at a time.
///
/// Cost: 4 n (il)².
#[must_use]
pub fn residual(gram: &Gram, realisation: &Realisation, order: usize) -> Residual {
    let (l, half, i) = (gram.channels, gram.half(), gram.block_rows);
    let u = realisation.u.get(.., ..order);
    let past = gram.matrix.submatrix(0, 0, half, half);
    let across = past * u;
    let d = &across - u * (u.transpose() * &across * Scale(0.5));
    let left = Mat::from_fn(half, 2 * order, |row, k| if k < order { u[(row, k)] } else { d[(row, k - order)] });
    let right = Mat::from_fn(half, 2 * order, |row, k| if k < order { d[(row, k)] } else { u[(row, k - order)] });
    let scale = half as f64 / ((half - order) as f64 * gram.columns as f64);
    let mut covariance = vec![0.0; l * l];
    let mut squares = vec![0.0; l * l];
    for block in 0..i {
        // By symmetry from the diagonal down.
        let (at, rows) = (block * l, half - block * l);
        let mut outside = past.submatrix(at, at, rows, l).to_owned();
        let (left, right) = (left.submatrix(at, 0, rows, 2 * order), right.submatrix(at, 0, l, 2 * order));
        faer::linalg::matmul::matmul(outside.as_mut(), Accum::Add, left, right.transpose(), -1.0, Par::Seq);
        for b in 0..l {
            let mut blocks = outside.col_as_slice(b).chunks_exact(l);
            let own = blocks.next().unwrap_or(&[]);
            covariance.iter_mut().skip(b).step_by(l).zip(own).for_each(|(sum, x)| *sum += scale / i as f64 * x);
            let squares = &mut squares[b * l..(b + 1) * l];
            blocks.for_each(|below| squares.iter_mut().zip(below).for_each(|(sum, x)| *sum += x * x));
        }
    }
    let inverse: Vec<f64> = (0..l).map(|a| 1.0 / covariance[a * l + a]).collect();
    let weighted = |(k, sum): (usize, &f64)| sum * inverse[k / l] * inverse[k % l];
    let lagged = 2.0 * scale * scale * squares.iter().enumerate().map(weighted).sum::<f64>();
    let pairs = (half * (half - l)) as f64;
    // The projection itself leaves correlations of mean square n / (il)².
    let expected = 1.0 / gram.columns as f64 + order as f64 / (half * half) as f64;
    Residual { covariance, whiteness_ratio: lagged / pairs / expected }
}

fn bartlett_moments(gram: &Gram, residuals: &[&Residual], sensitivities: &[Sensitivity]) -> Vec<Moments> {
    let (l, half) = (gram.channels, gram.half());
    let columns = 4 * sensitivities.len();
    let mut filters = Mat::<f64>::zeros(half, columns);
    for (index, s) in sensitivities.iter().enumerate() {
        for row in 0..half {
            filters[(row, 4 * index)] = s.q[row].re;
            filters[(row, 4 * index + 1)] = s.q[row].im;
            filters[(row, 4 * index + 2)] = s.r[row].re;
            filters[(row, 4 * index + 3)] = s.r[row].im;
        }
    }
    let product = gram.matrix.submatrix(0, 0, 2 * half, half) * &filters;
    let coloured: Vec<Vec<c64>> =
        sensitivities.iter().zip(residuals).map(|(s, residual)| coloured(&s.q, &residual.covariance, l)).collect();
    let zero = Moments { absolute: 0.0, plain: c64::new(0.0, 0.0) };
    let (mut white, mut sampled) = (vec![zero; sensitivities.len()], vec![zero; sensitivities.len()]);
    let overhangs: Vec<Vec<Vec<c64>>> = sensitivities.iter().map(|s| last_columns(gram, &s.r)).collect();
    for k in 0..gram.block_rows {
        let twice = if k == 0 { 1.0 } else { 2.0 };
        for (index, s) in sensitivities.iter().enumerate() {
            let (mut c_abs, mut c_plain) = lag_sums(&filters, &product, (4 * index + 2, k * l));
            for overhang in &overhangs[index] {
                let (abs, plain) = beyond_the_last_column(overhang, gram.block_rows, k);
                c_abs -= abs;
                c_plain -= plain;
            }
            let (e_abs, e_plain) = lag_sums(&filters, &product, (4 * index, k * l));
            let per_column = twice / gram.columns as f64;
            sampled[index].absolute += per_column * (e_abs * c_abs).re;
            sampled[index].plain += e_plain * c_plain * per_column;
            let (e_abs, e_plain) = white_lag(&s.q[k * l..], &coloured[index]);
            white[index].absolute += twice * (e_abs * c_abs).re;
            white[index].plain += e_plain * c_plain * twice;
        }
    }
    (0..sensitivities.len())
        .map(|index| {
            let sampled_is_larger = sampled[index].absolute > white[index].absolute;
            if sampled_is_larger && !residuals[index].is_white() { sampled[index] } else { white[index] }
        })
        .collect()
}

/// `(S_cc̄(k), S_cc(k))` of `c_t = r y_p(t)` for the lags k < i, over the columns of the record.
pub(crate) fn past_moments(gram: &Gram, r: &[c64]) -> Vec<(c64, c64)> {
    let (l, half) = (gram.channels, gram.half());
    let filters = Mat::from_fn(half, 2, |row, part| if part == 0 { r[row].re } else { r[row].im });
    let product = gram.matrix.submatrix(0, 0, 2 * half, half) * &filters;
    let overhangs = last_columns(gram, r);
    (0..gram.block_rows)
        .map(|k| {
            let (mut absolute, mut plain) = lag_sums(&filters, &product, (0, k * l));
            for overhang in &overhangs {
                let (abs, both) = beyond_the_last_column(overhang, gram.block_rows, k);
                absolute -= abs;
                plain -= both;
            }
            (absolute, plain)
        })
        .collect()
}

/// `c_t` of the columns that reach into the tails, newest first: per segment
/// `t = N − i, N − i − 1, …`.
fn last_columns(gram: &Gram, r: &[c64]) -> Vec<Vec<c64>> {
    let (l, i) = (gram.channels, gram.block_rows);
    let columns = gram.tails.iter().map(|(samples, tail)| {
        let kept = (*samples).min(tail.len() as u64 / l as u64) as usize;
        (0..(kept + 1).saturating_sub(i))
            .map(|late| {
                let mut c = c64::new(0.0, 0.0);
                for block in 0..i {
                    let newest = late + i - 1 - block;
                    for channel in 0..l {
                        c += r[block * l + channel] * tail[newest * l + channel];
                    }
                }
                c
            })
            .collect()
    });
    columns.collect()
}

/// Products `c_t c_{t+k}` whose second factor lies beyond the last of the Nc columns.
fn beyond_the_last_column(newest_first: &[c64], block_rows: usize, k: usize) -> (c64, c64) {
    let (mut absolute, mut plain) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
    // Column N − i − late; the last of the record's columns is N − 2i, late = i.
    for late in block_rows..(block_rows + k).min(newest_first.len()) {
        let (c, ahead) = (newest_first[late], newest_first[late - k]);
        absolute += c * ahead.conj();
        plain += c * ahead;
    }
    (absolute, plain)
}

/// `Σ₀ q_m` of every block.
fn coloured(q: &[c64], covariance: &[f64], l: usize) -> Vec<c64> {
    let of = |(k, _): (usize, &c64)| {
        let block = k / l * l;
        (0..l).fold(c64::new(0.0, 0.0), |sum, b| sum + q[block + b] * covariance[k % l * l + b])
    };
    q.iter().enumerate().map(of).collect()
}

/// `(Σ_m q_{m+k} Σ₀ q_mᴴ, Σ_m q_{m+k} Σ₀ q_mᵀ)` of `q` from block k on and `Σ₀ q`.
fn white_lag(later: &[c64], coloured: &[c64]) -> (c64, c64) {
    let (mut absolute, mut plain) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
    for (later, coloured) in later.iter().zip(coloured) {
        absolute += later * coloured.conj();
        plain += later * coloured;
    }
    (absolute, plain)
}

/// `(x G_k xᴴ, x G_k xᵀ)` for the complex filter in columns `at`, `at + 1`, from the product of the
/// Gram matrix with the filters: row `shift` of it is block row k, and `G_kᵀ` lies below it.
fn lag_sums(filters: &Mat<f64>, product: &Mat<f64>, (at, shift): (usize, usize)) -> (c64, c64) {
    let dot = |a: usize, b: usize| -> f64 {
        let (a, b) = (product.col_as_slice(a), filters.col_as_slice(b));
        a[shift..].iter().zip(b).map(|(a, b)| a * b).sum()
    };
    let (rr, ri, ir, ii) = (dot(at, at), dot(at, at + 1), dot(at + 1, at), dot(at + 1, at + 1));
    (c64::new(rr + ii, ir - ri), c64::new(rr - ii, ri + ir))
}

/// Spread of `q H_b r` over the blocks, scaled to the whole record; `None` without blocks.
fn block_moments(blocks: &[BlockProduct], columns: u64, sensitivities: &[Sensitivity]) -> Option<Vec<Moments>> {
    let scale = spread_scale(blocks, columns)?;
    let parts = |k: usize, row: usize| {
        if k.is_multiple_of(2) { sensitivities[k / 2].q[row].re } else { sensitivities[k / 2].q[row].im }
    };
    let filters = Mat::from_fn(blocks[0].future_past.nrows(), 2 * sensitivities.len(), |row, k| parts(k, row));
    let along = || sensitivities.iter().map(|s| &s.along[..]);
    let of_blocks: Vec<Vec<c64>> = blocks.iter().map(|block| block.moves(&filters, along())).collect();
    let moves = |k: usize| of_blocks.iter().map(|block| block[k]).collect::<Vec<_>>();
    Some((0..sensitivities.len()).map(|k| scatter(&moves(k), scale)).collect())
}

/// The spread over blocks of pairs, which sees what the choice of pairs does. It is the only
/// evidence there, so that its own uncertainty counts: the error in units of the deviation is a
/// Student variable of B − 1 degrees of freedom, of variance (B − 1) / (B − 3).
fn pair_moments(pairs: &PairCovariances, columns: u64, sensitivities: &[Sensitivity]) -> Vec<Moments> {
    let count = pairs.blocks.len() as f64;
    let in_blocks: f64 = pairs.blocks.iter().map(|block| block.samples).sum();
    let scale = count / (count - 1.0) * columns as f64 / in_blocks * (count - 1.0) / (count - 3.0);
    let moves = |s: &Sensitivity| pairs.blocks.iter().map(|block| block.bilinear(&s.q, &s.r)).collect::<Vec<_>>();
    sensitivities.iter().map(|s| scatter(&moves(s), scale)).collect()
}

/// `χ Uᵀ`, which takes the coordinate of the pole out of the future.
fn modal_filter(realisation: &Realisation, pole: &Pole) -> Vec<c64> {
    (0..realisation.u.nrows()).map(|row| combine(&realisation.u, row, &pole.left)).collect()
}

/// How surely the pole is no chance product of the pairs chosen: `x_b = χ Uᵀ H_b V S⁻¹ φ` of the
/// blocks has the mean 1. That of a mode is its power in the block, real and positive; that of
/// chance scatters over the complex plane, so that the imaginary parts alone show its deviation,
/// `B / (Σ (Im x_b)²)^(1/2)`.
fn coherence(pairs: &PairCovariances, filter: &[c64], r: &[c64]) -> f64 {
    let products: Vec<c64> = pairs.blocks.iter().map(|block| block.bilinear(filter, r)).collect();
    let total: f64 = products.iter().map(|x| x.re).sum();
    let across = products.iter().map(|x| x.im * x.im).sum::<f64>().sqrt();
    if across > 0.0 { total / across } else { f64::INFINITY }
}

/// Second moments of `moves` about their mean, summed and scaled.
fn scatter(moves: &[c64], scale: f64) -> Moments {
    let mean = moves.iter().fold(c64::new(0.0, 0.0), |sum, x| sum + x) / moves.len() as f64;
    let mut moments = Moments { absolute: 0.0, plain: c64::new(0.0, 0.0) };
    for x in moves {
        let d = x - mean;
        moments.absolute += scale * d.norm_sqr();
        moments.plain += d * d * scale;
    }
    moments
}
