//! Standard deviations of the components of output-only mode shapes.
//!
//! With `U' = U + (I − U Uᵀ) δH V S⁻¹` (δH the error of the future–past product, n states kept) the
//! shape `ψ = C φ` of the pole z moves to first order by
//!
//! `δψ_c = q_c δH r`, `q_c = [e_c + X_c (U↑⁺ [rows below] − z U↑⁺ [rows above])] (I − U Uᵀ)`,
//! `X = C S_z`, `S_z = (z I − A + φ χ)⁻¹ − φ χ`, `r = V S⁻¹ φ`,
//!
//! where `S_z` is the reduced resolvent of the state matrix A (Kato 1995, section I.5), φ and χ the
//! right and left eigenvectors with `χ φ = 1`. A shape has a scale, set by a functional `wᴴ ψ = 1`:
//! `q̃_c = (q_c − ψ_c Σ_d w̄_d q_d)/(wᴴ ψ)`. With w the unit vector of the largest component m the
//! deviation of component m is zero; with w along the first channels the shapes of several setups
//! that share these channels have one scale ([`crate::setups`]). The filters have the form of those
//! of the pole (see [`crate::uncertainty`]); the moments follow from the same lagged sums, and the
//! larger of these and of the spread over the blocks is given.
//! Reynders, Pintelon & De Roeck 2008; Döhler & Mevel 2013.
//!
//! Cost per pole: 8 (il)² l multiply-adds. Fails (too small) as the deviations of the pole do:
//! where an unmodelled mode bends the shape.

use crate::gram::Gram;
use crate::ssi_cov::{Pole, Realisation};
use crate::uncertainty::{BlockProduct, Residual, along_states, past_moments, spread_scale};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

/// What holds the scale of a shape when its deviations are stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ShapeScale {
    /// The largest component is one.
    Largest,
    /// The least-squares amplitude over so many first channels, the references of a setup.
    FirstChannels(usize),
}

/// Filters of all components of one shape on the future, half × l, and of the state on the past.
struct ShapeFilters {
    re: Mat<f64>,
    im: Mat<f64>,
    r: Vec<c64>,
    /// r in the columns of V.
    along: Vec<c64>,
}

/// Standard deviations of real and imaginary part of every component of `pole.mode_shape`.
///
/// Empty where the resolvent does not exist: another pole of the order has the same eigenvalue.
#[must_use]
pub fn shape_deviations(
    gram: &Gram,
    blocks: &[BlockProduct],
    realisation: &Realisation,
    residual: &Residual,
    pole: &Pole,
    scale: ShapeScale,
) -> Vec<c64> {
    let filters = shape_filters(realisation, pole, scale);
    let finite = |part: &Mat<f64>| (0..part.ncols()).all(|c| part.col_as_slice(c).iter().all(|x| x.is_finite()));
    if !finite(&filters.re) || !finite(&filters.im) {
        return Vec::new();
    }
    let past = past_moments(gram, &filters.r);
    let white = white_variances(gram, residual, &filters, &past);
    let mut variances = white;
    if !residual.is_white() {
        for (variance, sampled) in variances.iter_mut().zip(sampled_variances(gram, &filters, &past)) {
            *variance = if sampled[0] + sampled[1] > variance[0] + variance[1] { sampled } else { *variance };
        }
    }
    if let Some(spread) = block_variances(blocks, gram.columns, &filters) {
        for (variance, spread) in variances.iter_mut().zip(spread) {
            *variance = [variance[0].max(spread[0]), variance[1].max(spread[1])];
        }
    }
    variances.iter().map(|[re, im]| c64::new(re.max(0.0).sqrt(), im.max(0.0).sqrt())).collect()
}

/// `q̃_c` for every channel c, one a column.
fn shape_filters(realisation: &Realisation, pole: &Pole, scale: ShapeScale) -> ShapeFilters {
    let (l, n) = (realisation.channels, pole.order);
    let half = realisation.u.nrows();
    let u = realisation.u.get(.., ..n);
    let shape: Vec<c64> =
        (0..l).map(|c| (0..n).fold(c64::new(0.0, 0.0), |sum, k| sum + pole.right[k] * u[(c, k)])).collect();
    let resolved = resolvent(realisation, pole, &shape);
    // W = X R⁻¹ Qᵀ, transposed: (half − l) × l
    let of = |part: fn(&c64) -> f64| Mat::from_fn(n, l, |k, c| part(&resolved[c][k]));
    let q = realisation.q.get(.., ..n);
    let (w_re, w_im) = (q * of(|x| x.re), q * of(|x| x.im));
    let (mut re, mut im) = (Mat::<f64>::zeros(half, l), Mat::<f64>::zeros(half, l));
    let z = pole.eigenvalue;
    for c in 0..l {
        re[(c, c)] += 1.0;
        for row in 0..half - l {
            let (a, b) = (w_re[(row, c)], w_im[(row, c)]);
            re[(row + l, c)] += a;
            im[(row + l, c)] += b;
            re[(row, c)] -= z.re * a - z.im * b;
            im[(row, c)] -= z.re * b + z.im * a;
        }
    }
    for part in [&mut re, &mut im] {
        let inside = u.transpose() * &*part;
        *part -= u * inside;
    }
    rescale(&mut re, &mut im, &shape, &pole.mode_shape, scale);
    let along = along_states(realisation, pole);
    let r = (0..half)
        .map(|row| along.iter().enumerate().fold(c64::new(0.0, 0.0), |sum, (k, x)| sum + *x * realisation.v[(row, k)]))
        .collect();
    ShapeFilters { re, im, r, along }
}

/// `X_c R⁻¹` for every channel: rows of `C S_z` behind the triangle.
fn resolvent(realisation: &Realisation, pole: &Pole, shape: &[c64]) -> Vec<Vec<c64>> {
    let (l, n) = (realisation.channels, pole.order);
    let a = realisation.state_matrix(n);
    let shifted = Mat::from_fn(n, n, |i, j| {
        let diagonal = if i == j { pole.eigenvalue } else { c64::new(0.0, 0.0) };
        diagonal - c64::new(a[(i, j)], 0.0) + pole.right[i] * pole.left[j]
    });
    // Rows of C times the inverse: solve with the transpose.
    let mut rows = Mat::from_fn(n, l, |k, c| c64::new(realisation.u[(c, k)], 0.0));
    shifted.partial_piv_lu().solve_transpose_in_place(rows.as_mut());
    (0..l)
        .map(|c| {
            let x: Vec<c64> = (0..n).map(|k| rows[(k, c)] - shape[c] * pole.left[k]).collect();
            realisation.solve_transposed(&x)
        })
        .collect()
}

/// `w` for the shape `unit`.
fn functional(unit: &[c64], scale: ShapeScale) -> Vec<c64> {
    let nothing = c64::new(0.0, 0.0);
    match scale {
        ShapeScale::Largest => {
            let largest = (0..unit.len()).fold(0, |a, b| if unit[b].norm_sqr() > unit[a].norm_sqr() { b } else { a });
            (0..unit.len()).map(|c| if c == largest { c64::new(1.0, 0.0) } else { nothing }).collect()
        }
        ShapeScale::FirstChannels(count) => {
            let power: f64 = unit[..count].iter().map(c64::norm_sqr).sum();
            unit.iter().enumerate().map(|(c, psi)| if c < count { *psi / power } else { nothing }).collect()
        }
    }
}

/// From the shape as it comes to the shape with `wᴴ ψ = 1`.
fn rescale(re: &mut Mat<f64>, im: &mut Mat<f64>, shape: &[c64], unit: &[c64], scale: ShapeScale) {
    let zero = c64::new(0.0, 0.0);
    let weights = functional(unit, scale);
    let size = weights.iter().zip(shape).fold(zero, |sum, (w, psi)| sum + w.conj() * psi);
    for row in 0..re.nrows() {
        let along =
            weights.iter().enumerate().fold(zero, |sum, (c, w)| sum + w.conj() * c64::new(re[(row, c)], im[(row, c)]));
        for (c, unit) in unit.iter().enumerate() {
            let moved = (c64::new(re[(row, c)], im[(row, c)]) - *unit * along) / size;
            (re[(row, c)], im[(row, c)]) = (moved.re, moved.im);
        }
    }
}

/// `½ (E|δ|² ± Re E δ²)`: variances of real and imaginary part.
fn parts(absolute: f64, plain: f64) -> [f64; 2] {
    [0.5 * (absolute + plain), 0.5 * (absolute - plain)]
}

/// Variances where the residual outside the states is white noise of the covariance found.
fn white_variances(gram: &Gram, residual: &Residual, filters: &ShapeFilters, past: &[(c64, c64)]) -> Vec<[f64; 2]> {
    let (l, half) = (gram.channels, gram.half());
    let mut coloured = [vec![0.0; half], vec![0.0; half]];
    (0..l)
        .map(|c| {
            let (a, b) = (filters.re.col_as_slice(c), filters.im.col_as_slice(c));
            for (out, part) in coloured.iter_mut().zip([a, b]) {
                for (out, part) in out.chunks_exact_mut(l).zip(part.chunks_exact(l)) {
                    for (k, out) in out.iter_mut().enumerate() {
                        *out = part.iter().enumerate().map(|(j, x)| x * residual.covariance[k * l + j]).sum();
                    }
                }
            }
            let (mut absolute, mut plain) = (0.0, 0.0);
            for (k, (c_abs, c_plain)) in past.iter().enumerate() {
                let lagged = |x: &[f64], y: &[f64]| -> f64 { x[k * l..].iter().zip(y).map(|(x, y)| x * y).sum() };
                let (rr, ii) = (lagged(a, &coloured[0]), lagged(b, &coloured[1]));
                let (ri, ir) = (lagged(a, &coloured[1]), lagged(b, &coloured[0]));
                let twice = if k == 0 { 1.0 } else { 2.0 };
                absolute += twice * ((rr + ii) * c_abs.re - (ir - ri) * c_abs.im);
                plain += twice * ((rr - ii) * c_plain.re - (ri + ir) * c_plain.im);
            }
            parts(absolute, plain)
        })
        .collect()
}

/// Variances from the lagged sums of the record itself:
/// `Σ_k w_k a G_k b = a G [Σ_k w_k b shifted by k]`, all weights before one product with G.
fn sampled_variances(gram: &Gram, filters: &ShapeFilters, past: &[(c64, c64)]) -> Vec<[f64; 2]> {
    let (l, half) = (gram.channels, gram.half());
    let mut weighted = Mat::<f64>::zeros(2 * half, 4 * l);
    for (k, (c_abs, c_plain)) in past.iter().enumerate() {
        let twice = if k == 0 { 1.0 } else { 2.0 };
        let (c_abs, c_plain) = (*c_abs * twice, *c_plain * twice);
        for c in 0..l {
            let (a, b) = (filters.re.col_as_slice(c), filters.im.col_as_slice(c));
            // Re(c x G_k xᴴ) and Re(p x G_k xᵀ), x = a + j b, ordered by the factor on the left.
            let rows =
                [[c_abs.re, c_abs.im], [-c_abs.im, c_abs.re], [c_plain.re, -c_plain.im], [-c_plain.im, -c_plain.re]];
            for (set, [of_a, of_b]) in rows.iter().enumerate() {
                let out = &mut weighted.col_as_slice_mut(4 * c + set)[k * l..k * l + half];
                for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
                    *out += of_a * a + of_b * b;
                }
            }
        }
    }
    let product = gram.matrix.submatrix(0, 0, half, 2 * half) * &weighted;
    let dot =
        |a: &[f64], column: usize| -> f64 { a.iter().zip(product.col_as_slice(column)).map(|(a, p)| a * p).sum() };
    (0..l)
        .map(|c| {
            let (a, b) = (filters.re.col_as_slice(c), filters.im.col_as_slice(c));
            let absolute = dot(a, 4 * c) + dot(b, 4 * c + 1);
            let plain = dot(a, 4 * c + 2) + dot(b, 4 * c + 3);
            parts(absolute / gram.columns as f64, plain / gram.columns as f64)
        })
        .collect()
}

/// Spread of `q̃ H_b r` over the blocks, scaled to the whole record; `None` without blocks.
fn block_variances(blocks: &[BlockProduct], columns: u64, filters: &ShapeFilters) -> Option<Vec<[f64; 2]>> {
    let scale = spread_scale(blocks, columns)?;
    let (count, l) = (blocks.len() as f64, filters.re.ncols());
    let part = |k: usize| if k.is_multiple_of(2) { &filters.re } else { &filters.im };
    let pairs = Mat::from_fn(filters.re.nrows(), 2 * l, |row, k| part(k)[(row, k / 2)]);
    let along = || std::iter::repeat_n(&filters.along[..], l);
    let moves: Vec<Vec<c64>> = blocks.iter().map(|block| block.moves(&pairs, along())).collect();
    let variance = |c: usize, part: fn(&c64) -> f64| {
        let mean = moves.iter().map(|m| part(&m[c])).sum::<f64>() / count;
        scale * moves.iter().map(|m| (part(&m[c]) - mean) * (part(&m[c]) - mean)).sum::<f64>()
    };
    Some((0..l).map(|c| [variance(c, |x| x.re), variance(c, |x| x.im)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gram::output_gram;
    use crate::record::Record;
    use crate::ssi_cov::realise;
    use crate::test_noise::Noise;

    /// Two decaying modes on three channels without noise: a product of exact rank four.
    fn gram_of_decays() -> Gram {
        let shapes = [[1.0, 0.6, -0.3], [-0.4, 1.0, 0.7]];
        let outputs = (0..400).flat_map(|t| {
            let t = f64::from(t);
            let decay = move |k: usize| {
                let (rate, turn) = ([0.01, 0.02][k], [0.3, 0.8][k]);
                libm::exp(-rate * t) * libm::cos(turn * t)
            };
            (0..3).map(move |c| (0..2).map(|k| shapes[k][c] * decay(k)).sum::<f64>())
        });
        output_gram(&Record::of_outputs(1.0, 3, outputs.collect()), 8)
    }

    #[test]
    fn the_filters_are_the_derivative_of_the_shape_by_the_future_past_product() {
        let gram = gram_of_decays();
        let exact = realise(&gram, 4).unwrap();
        let mut noise = Noise::new(5);
        let half = gram.half();
        let direction = Mat::from_fn(half, half, |_, _| noise.normal());
        let step = 1e-7;
        let mut moved = gram.clone();
        for row in 0..half {
            for column in 0..half {
                moved.matrix[(half + row, column)] += step * direction[(row, column)];
            }
        }
        let shifted = realise(&moved, 4).unwrap();
        for (pole, after) in exact.poles(4, 1.0).iter().zip(shifted.poles(4, 1.0)) {
            let filters = shape_filters(&exact, pole, ShapeScale::Largest);
            let by = |part: fn(&c64) -> f64| -> Vec<f64> {
                (0..half).map(|row| (0..half).map(|k| direction[(row, k)] * part(&filters.r[k])).sum()).collect()
            };
            let (re, im) = (by(|x| x.re), by(|x| x.im));
            for c in 0..3 {
                let predicted = (0..half).fold(c64::new(0.0, 0.0), |sum, row| {
                    sum + c64::new(filters.re[(row, c)], filters.im[(row, c)]) * c64::new(re[row], im[row])
                });
                let seen = (after.mode_shape[c] - pole.mode_shape[c]) / step;
                // Second order in the step, 1e-7 of condition numbers of some hundred.
                let size = 1e-3 * (1.0 + predicted.norm_sqr().sqrt());
                assert!((seen - predicted).norm_sqr().sqrt() < size, "{c}: {seen:?} for {predicted:?}");
            }
        }
    }
}
