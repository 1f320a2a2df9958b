//! How long the line takes there and back, and when a message counts as lost.

/// Before the first measurement \[ms\].
const FIRST_MS: f64 = 1000.0;
/// Bounds of the time-out \[ms\]: a line is faster than a look at it, and is tried again within
/// seconds once it is back.
const LEAST_MS: f64 = 100.0;
const MOST_MS: f64 = 5000.0;

/// Round-trip time as RFC 6298 estimates it.
#[derive(Clone, Copy, Debug, Default)]
pub struct RoundTrip {
    /// Smoothed, and its mean deviation \[ms\].
    estimate: Option<(f64, f64)>,
    /// Time of the last answer \[ms\].
    answered_ms: Option<u64>,
}

impl RoundTrip {
    /// Takes the round trip of a message. Answers repeat the time of the message that they answer,
    /// so that one that was sent again is no exception (RFC 7323).
    pub fn measure(&mut self, sent_ms: u64, now_ms: u64) {
        self.answered_ms = Some(now_ms);
        let elapsed_ms = now_ms.saturating_sub(sent_ms) as f64;
        self.estimate = Some(match self.estimate {
            None => (elapsed_ms, elapsed_ms / 2.0),
            Some((smoothed_ms, deviation_ms)) => (
                smoothed_ms + (elapsed_ms - smoothed_ms) / 8.0,
                deviation_ms + ((elapsed_ms - smoothed_ms).abs() - deviation_ms) / 4.0,
            ),
        });
    }

    /// After so long without an answer a message is sent again \[ms\]. It was sent `times` times,
    /// the last time at `sent_ms`: twice as long each time, unless there has been any answer since,
    /// for then the line is not away.
    pub fn time_out_ms(&self, times: u32, sent_ms: u64) -> u64 {
        let is_there = self.answered_ms.is_some_and(|answered_ms| answered_ms >= sent_ms);
        let doublings = if is_there { 0 } else { times.saturating_sub(1).min(16) };
        let first_ms = self.estimate.map_or(FIRST_MS, |(smoothed_ms, deviation_ms)| smoothed_ms + 4.0 * deviation_ms);
        let doubled_ms = first_ms.max(LEAST_MS) * f64::from(1_u32 << doublings);
        doubled_ms.min(MOST_MS) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::RoundTrip;

    #[test]
    fn the_time_out_follows_the_line_and_doubles_up_to_its_bound() {
        let mut line = RoundTrip::default();
        assert_eq!(line.time_out_ms(1, 0), 1000);
        (0..100).for_each(|k| line.measure(k, k + 600));
        assert!((600..700).contains(&line.time_out_ms(1, 1000)), "{line:?}");
        assert_eq!(line.time_out_ms(2, 1000), 2 * line.time_out_ms(1, 1000));
        assert_eq!(line.time_out_ms(60, 1000), 5000);
        assert_eq!(line.time_out_ms(60, 699), line.time_out_ms(1, 1000), "an answer came since");
        (0..100).for_each(|k| line.measure(k, k + 1));
        assert_eq!(line.time_out_ms(1, 1000), 100);
    }
}
