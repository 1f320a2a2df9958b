//! Inner product of two columns.

/// `aᵀ b` in four partial sums, always the same ones: the order of addition is part of the result.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let chunks = a.len() / 4;
    for k in 0..chunks {
        for (l, sum) in sums.iter_mut().enumerate() {
            *sum += a[4 * k + l] * b[4 * k + l];
        }
    }
    let rest: f64 = (4 * chunks..a.len()).map(|i| a[i] * b[i]).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
