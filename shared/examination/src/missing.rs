//! Samples that an even clock owes and that are not there.
//!
//! An interval of `k + ½` to `k + 3/2` median intervals has room for k samples more. Counted is
//! what is absent between the first sample and the last; what was lost before or after leaves no
//! trace.

use channels::GAP_MEDIANS;
use estimation::quantiles::median;

/// Gaps in the stamps of one clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Missing {
    /// Intervals with room for a sample at least.
    pub gaps: usize,
    /// Samples that have room in them.
    pub samples: usize,
    /// `samples` over those that should be there.
    pub share: f64,
    /// Longest interval \[s\].
    pub longest_s: f64,
    /// Stamp at which it begins \[s\].
    pub longest_from_s: f64,
}

/// What is missing between ascending stamps \[s\]; `None` where nothing is, and below three stamps.
///
/// ```
/// let stamps: Vec<f64> = (0..100).filter(|k| k % 10 != 9).map(|k| 0.02 * f64::from(k)).collect();
/// let missing = examination::missing::missing(&stamps).unwrap();
/// assert_eq!((missing.gaps, missing.samples), (9, 9));
/// ```
#[must_use]
pub fn missing(stamps_s: &[f64]) -> Option<Missing> {
    let mut steps: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.len() < 2 {
        return None;
    }
    let interval = median(&mut steps);
    let mut found = Missing { gaps: 0, samples: 0, share: 0.0, longest_s: 0.0, longest_from_s: 0.0 };
    for pair in stamps_s.windows(2) {
        let step = pair[1] - pair[0];
        if step > GAP_MEDIANS * interval {
            found.gaps += 1;
            found.samples += (libm::round(step / interval) as usize).saturating_sub(1);
            if step > found.longest_s {
                (found.longest_s, found.longest_from_s) = (step, pair[0]);
            }
        }
    }
    found.share = found.samples as f64 / (stamps_s.len() + found.samples) as f64;
    (found.gaps > 0).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::missing;

    #[test]
    fn gaps_are_counted_with_what_has_room_in_them() {
        let lost = [3, 4, 5, 20, 40, 41];
        let stamps: Vec<f64> = (0..60).filter(|k| !lost.contains(k)).map(|k| 5.0 + 0.1 * f64::from(k)).collect();
        let found = missing(&stamps).unwrap();
        assert_eq!((found.gaps, found.samples), (3, 6));
        assert!((found.share - 0.1).abs() < 1e-12 && (found.longest_s - 0.4).abs() < 1e-9, "{found:?}");
        assert!((found.longest_from_s - 5.2).abs() < 1e-9);
        assert_eq!(missing(&[0.0, 1.0, 2.0, 3.0]), None);
        assert_eq!(missing(&[0.0, 1.0]), None);
    }
}
