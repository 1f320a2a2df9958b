//! Latency in logarithmic buckets: fixed memory, 1/8 octave resolution.

const BUCKETS: usize = 8 * 40;

/// Counts of latencies; percentiles are bucket middles (±5 %).
#[derive(Clone, Debug)]
pub struct LatencyHistogram {
    counts: Box<[u64; BUCKETS]>,
    total: u64,
}

impl Default for LatencyHistogram {
    fn default() -> Self {
        LatencyHistogram { counts: Box::new([0; BUCKETS]), total: 0 }
    }
}

impl LatencyHistogram {
    /// Counts one latency \[ns\]; below 8 ns as 8 ns, beyond the last bucket in the last.
    pub fn record(&mut self, latency_ns: u64) {
        let octave = u64::from(latency_ns.max(8).ilog2());
        let eighth = (latency_ns.max(8) >> (octave - 3)) & 7;
        let bucket = (8 * (octave - 3) + eighth) as usize;
        self.counts[bucket.min(BUCKETS - 1)] += 1;
        self.total += 1;
    }

    /// Latency \[µs\] that the fraction `p` of samples stays below; 0 without samples.
    #[must_use]
    pub fn percentile_us(&self, p: f64) -> f64 {
        let wanted = (p * self.total as f64).ceil() as u64;
        let mut below = 0;
        for (bucket, &count) in self.counts.iter().enumerate() {
            below += count;
            if count > 0 && below >= wanted {
                let lower = ((8 + bucket as u64 % 8) << (bucket / 8)) as f64;
                let upper = ((9 + bucket as u64 % 8) << (bucket / 8)) as f64;
                return 0.5e-3 * (lower + upper);
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::LatencyHistogram;

    #[test]
    fn percentiles_are_within_a_bucket_of_the_truth() {
        let mut histogram = LatencyHistogram::default();
        for latency_us in 1..=1000_u64 {
            histogram.record(latency_us * 1000);
        }
        for (p, truth_us) in [(0.5, 500.0), (0.99, 990.0)] {
            let found = histogram.percentile_us(p);
            assert!((found / truth_us - 1.0_f64).abs() < 0.125, "{found} for {truth_us}"); // bucket width 1/8
        }
    }
}
