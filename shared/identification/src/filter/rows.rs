//! Rows of numbers in fours, as long as z: sums and products that the processor takes several of at
//! once.

/// Rows are whole fours of numbers.
pub(super) const QUAD: usize = 4;

/// `$f`, compiled for the size of z.
macro_rules! by_size {
    ($size:expr, $f:ident) => {
        match $size.div_ceil($crate::filter::rows::QUAD) {
            0 | 1 => $f::<[f64; 4]>,
            2 => $f::<[f64; 8]>,
            3 => $f::<[f64; 12]>,
            4 => $f::<[f64; 16]>,
            5 => $f::<[f64; 20]>,
            6 => $f::<[f64; 24]>,
            _ => $f::<Vec<f64>>,
        }
    };
}
pub(super) use by_size;

/// Numbers beside each other, one for every entry of z.
pub(super) trait Row {
    fn zeros(size: usize) -> Self;
    fn numbers(&self) -> &[f64];
    fn numbers_mut(&mut self) -> &mut [f64];
    /// The numbers, out of their place: they come back when they are done.
    fn taken(&mut self) -> Self;
}

impl<const S: usize> Row for [f64; S] {
    fn zeros(_: usize) -> Self {
        [0.0; S]
    }

    #[inline(always)]
    fn numbers(&self) -> &[f64] {
        self
    }

    #[inline(always)]
    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    #[inline(always)]
    fn taken(&mut self) -> Self {
        *self
    }
}

impl Row for Vec<f64> {
    fn zeros(size: usize) -> Self {
        vec![0.0; size]
    }

    #[inline(always)]
    fn numbers(&self) -> &[f64] {
        self
    }

    #[inline(always)]
    fn numbers_mut(&mut self) -> &mut [f64] {
        self
    }

    #[inline(always)]
    fn taken(&mut self) -> Self {
        core::mem::take(self)
    }
}

/// `sum += factor · x`.
#[inline(always)]
pub(super) fn add(sum: &mut [f64], factor: f64, x: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

/// `sum += Σ shareᵢ · rowᵢ`: as many numbers at once as the processor has room for; shares that are
/// zero cost nothing.
#[inline(always)]
pub(super) fn combine<R: Row>(sum: &mut [f64], shares: &[f64], rows: &[R]) {
    let mut at = 0;
    while at + 4 * QUAD <= sum.len() {
        stretch::<4, R>(sum, shares, rows, at);
        at += 4 * QUAD;
    }
    if at + 2 * QUAD <= sum.len() {
        stretch::<2, R>(sum, shares, rows, at);
        at += 2 * QUAD;
    }
    if at + QUAD <= sum.len() {
        stretch::<1, R>(sum, shares, rows, at);
    }
}

/// [`combine`] of the `Q` fours of numbers from `at` on.
#[inline(always)]
fn stretch<const Q: usize, R: Row>(sum: &mut [f64], shares: &[f64], rows: &[R], at: usize) {
    let sum = &mut sum[at..at + Q * QUAD];
    let mut sums = [[0.0; QUAD]; Q];
    sums.iter_mut().zip(sum.chunks_exact(QUAD)).for_each(|(own, sum)| own.copy_from_slice(sum));
    for (share, row) in shares.iter().zip(rows).filter(|(share, _)| **share != 0.0) {
        for (own, x) in sums.iter_mut().zip(row.numbers()[at..at + Q * QUAD].chunks_exact(QUAD)) {
            for (own, x) in own.iter_mut().zip(x) {
                *own += share * x;
            }
        }
    }
    sum.chunks_exact_mut(QUAD).zip(&sums).for_each(|(sum, own)| sum.copy_from_slice(own));
}

#[inline(always)]
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; QUAD];
    for (a, b) in a.chunks_exact(QUAD).zip(b.chunks_exact(QUAD)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
