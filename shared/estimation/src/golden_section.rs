//! Minimum of a function of one variable by golden section (Kiefer 1953).

/// Inverse of the golden ratio.
pub const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// The middle of the bracket that `steps` steps leave of `[low, high]`: it holds the minimum of a
/// function with one.
///
/// Cost: `steps + 2` evaluations; the bracket shrinks by [`INVERSE_GOLDEN_RATIO`] at each.
pub fn minimise(low: f64, high: f64, steps: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut a, mut b) = (low, high);
    let (mut c, mut d) = (b - INVERSE_GOLDEN_RATIO * (b - a), a + INVERSE_GOLDEN_RATIO * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    for _ in 0..steps {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - INVERSE_GOLDEN_RATIO * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + INVERSE_GOLDEN_RATIO * (b - a);
            at_d = f(d);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_minimum_of_a_parabola_is_found_to_the_bracket_that_is_left() {
        for minimum in [-0.9, 0.0, 0.31, 1.7] {
            let found = minimise(-1.0, 2.0, 30, |x| (x - minimum) * (x - minimum));
            // 3 · 0.618³⁰ / 2
            assert!((found - minimum).abs() < 1e-6, "{minimum}: {found}");
        }
    }
}
