//! Fourier transform of a power of two, in place.

use core::f64::consts::TAU;
use faer::c64;

/// Replaces `x` by `X_k = Σ_j x_j e^{−2πi jk/n}`, n a power of two. Cost: n log₂ n / 2 butterflies.
pub(super) fn transform(x: &mut [c64]) {
    let n = x.len();
    assert!(n.is_power_of_two());
    let bits = n.trailing_zeros();
    for j in 0..n {
        let k = if bits == 0 { 0 } else { j.reverse_bits() >> (usize::BITS - bits) };
        if j < k {
            x.swap(j, k);
        }
    }
    let twiddles: Vec<c64> = (0..n / 2).map(|k| turn(-TAU * k as f64 / n as f64)).collect();
    let mut size = 2;
    while size <= n {
        let step = n / size;
        for block in x.chunks_exact_mut(size) {
            let (front, back) = block.split_at_mut(size / 2);
            for (k, (a, b)) in front.iter_mut().zip(back).enumerate() {
                let turned = *b * twiddles[k * step];
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        size *= 2;
    }
}

/// `e^{iφ}`.
pub(super) fn turn(phase: f64) -> c64 {
    let (sine, cosine) = libm::sincos(phase);
    c64::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_sum_that_defines_it() {
        let x: Vec<c64> = (0..16).map(|j| c64::new(f64::from(j * j % 7), f64::from(j % 3))).collect();
        let mut fast = x.clone();
        transform(&mut fast);
        for (k, found) in fast.iter().enumerate() {
            let term = |(j, x): (usize, &c64)| *x * turn(-TAU * (j * k) as f64 / 16.0);
            let sum = x.iter().enumerate().map(term).fold(c64::new(0.0, 0.0), |a, b| a + b);
            assert!((sum - *found).norm_sqr() < 1e-20);
        }
    }
}
