//! Small matrices by rows, in place and without memory of their own.

/// Lower Cholesky factor of the symmetric `a` (n × n) in its place; false where it is not positive.
#[inline(always)]
pub(super) fn cholesky(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let left = a[i * n + j] - known;
            if i == j && !(left > 0.0 && left.is_finite()) {
                return false;
            }
            a[i * n + j] = if i == j { left.sqrt() } else { left / a[j * n + j] };
        }
    }
    true
}

/// `b ← (L L')⁻¹ b`, b of `width` columns.
#[inline(always)]
pub(super) fn solve(factor: &[f64], n: usize, b: &mut [f64], width: usize) {
    for i in 0..n {
        let (known, rest) = b.split_at_mut(i * width);
        let own = &mut rest[..width];
        for (share, row) in factor[i * n..i * n + i].iter().zip(known.chunks_exact(width)) {
            subtract(own, *share, row);
        }
        let diagonal = factor[i * n + i];
        own.iter_mut().for_each(|own| *own /= diagonal);
    }
    for i in (0..n).rev() {
        let (head, known) = b.split_at_mut((i + 1) * width);
        let own = &mut head[i * width..];
        for (j, row) in (i + 1..n).zip(known.chunks_exact(width)) {
            subtract(own, factor[j * n + i], row);
        }
        let diagonal = factor[i * n + i];
        own.iter_mut().for_each(|own| *own /= diagonal);
    }
}

#[inline(always)]
fn subtract(own: &mut [f64], share: f64, row: &[f64]) {
    own.iter_mut().zip(row).for_each(|(own, x)| *own -= share * x);
}

/// `out += a b`: a of `inner` columns, b and out by rows of their own widths, as many columns as
/// both have. Zeros of `a` cost nothing.
#[inline(always)]
pub(super) fn add_product(a: &[f64], inner: usize, (b, width): (&[f64], usize), (out, wide): (&mut [f64], usize)) {
    for (out, a) in out.chunks_exact_mut(wide).zip(a.chunks_exact(inner)) {
        for (share, row) in a.iter().zip(b.chunks_exact(width)).filter(|(share, _)| **share != 0.0) {
            out.iter_mut().zip(row).for_each(|(out, x)| *out += share * x);
        }
    }
}
