//! Quantiles of a sample by linear interpolation between its order statistics.
//!
//! Of n values in ascending order, quantile `q` lies at position `q (n − 1)`, counted from zero
//! (definition 7 of Hyndman and Fan 1996); the median of an even number is therefore half way
//! between the two in the middle. Where a result has to be one of the values themselves, take an
//! order statistic instead.

/// Median; reorders its argument. Zero of an empty slice.
#[must_use]
pub fn median(x: &mut [f64]) -> f64 {
    quantile(x, 0.5)
}

/// Quantile `q` in [0, 1] by linear interpolation; reorders its argument. Zero of an empty slice.
///
/// NaN sorts by its sign to either end and counts as a value. Cost: O(n log n), no allocation.
#[must_use]
pub fn quantile(x: &mut [f64], q: f64) -> f64 {
    if x.is_empty() {
        return 0.0;
    }
    // Values that compare equal in this order have the same bits: an unstable sort changes nothing.
    x.sort_unstable_by(f64::total_cmp);
    let at = q.clamp(0.0, 1.0) * (x.len() - 1) as f64;
    let (low, part) = (libm::floor(at) as usize, at - libm::floor(at));
    x[low] + part * (x[(low + 1).min(x.len() - 1)] - x[low])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_lies_between_its_neighbours_in_any_order_of_the_values() {
        assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 0.5), 2.5);
        assert_eq!(median(&mut [9.0, 1.0, 5.0]), 5.0);
        for (q, expected) in [(-1.0, 1.0), (0.0, 1.0), (0.25, 2.0), (0.9, 4.6), (1.0, 5.0), (2.0, 5.0)] {
            let found = quantile(&mut [5.0, 2.0, 4.0, 1.0, 3.0], q);
            assert!((found - expected).abs() <= 4.0 * f64::EPSILON, "{q}: {found}"); // rounding of q (n - 1)
        }
    }

    #[test]
    fn one_value_is_every_quantile_and_none_gives_zero() {
        for q in [0.0, 0.3, 1.0] {
            assert_eq!(quantile(&mut [7.0], q), 7.0);
            assert_eq!(quantile(&mut [], q), 0.0);
        }
    }
}
