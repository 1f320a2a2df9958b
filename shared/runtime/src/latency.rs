//! Times in logarithmic buckets: fixed memory, 1/8 octave resolution.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

const BUCKETS: usize = 8 * 40;

/// Counts of times; percentiles are bucket middles (±5 %), the maximum is exact.
#[derive(Clone, Debug, PartialEq)]
pub struct LatencyHistogram {
    counts: Box<[u64; BUCKETS]>,
    total: u64,
    max_ns: u64,
}

impl Default for LatencyHistogram {
    fn default() -> Self {
        LatencyHistogram { counts: Box::new([0; BUCKETS]), total: 0, max_ns: 0 }
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
        self.max_ns = self.max_ns.max(latency_ns);
    }

    /// Latency \[µs\] that the fraction `p` of samples stays below; 0 without samples.
    #[must_use]
    pub fn percentile_us(&self, p: f64) -> f64 {
        let wanted = (p * self.total as f64).ceil() as u64;
        let mut below = 0;
        for (bucket, &count) in self.counts.iter().enumerate() {
            below += count;
            if count > 0 && below >= wanted {
                let [lower_us, upper_us] = limits_us(bucket);
                return 0.5 * (lower_us + upper_us);
            }
        }
        0.0
    }

    /// The longest \[µs\].
    #[must_use]
    pub fn max_us(&self) -> f64 {
        self.max_ns as f64 * 1e-3
    }

    /// How many were counted.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Becomes the same as `other`; takes no memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.counts.copy_from_slice(&other.counts[..]);
        (self.total, self.max_ns) = (other.total, other.max_ns);
    }

    /// Adds what another one counted.
    pub fn add(&mut self, other: &Self) {
        for (count, more) in self.counts.iter_mut().zip(other.counts.iter()) {
            *count += more;
        }
        self.total += other.total;
        self.max_ns = self.max_ns.max(other.max_ns);
    }

    /// Upper limit \[µs\] and count of every bucket that holds something, the shortest first.
    pub fn buckets(&self) -> impl Iterator<Item = (f64, u64)> + '_ {
        let filled = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        filled.map(|(bucket, &count)| (limits_us(bucket)[1], count))
    }
}

/// Lower and upper limit of a bucket \[µs\].
fn limits_us(bucket: usize) -> [f64; 2] {
    let of = |eighths: u64| ((eighths + bucket as u64 % 8) << (bucket / 8)) as f64 * 1e-3;
    [of(8), of(9)]
}

/// Filled buckets alone, so that a file of many histograms stays small.
#[derive(Serialize, Deserialize)]
struct Sparse {
    max_ns: u64,
    counts: Vec<(usize, u64)>,
}

impl Serialize for LatencyHistogram {
    /// Takes no memory: a partition writes it while it flies.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut object = to.serialize_struct("Sparse", 2)?;
        object.serialize_field("max_ns", &self.max_ns)?;
        object.serialize_field("counts", &Filled(&self.counts))?;
        object.end()
    }
}

struct Filled<'a>(&'a [u64; BUCKETS]);

impl Serialize for Filled<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.0.iter().enumerate().filter(|(_, count)| **count > 0))
    }
}

impl<'de> Deserialize<'de> for LatencyHistogram {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let Sparse { max_ns, counts } = Sparse::deserialize(from)?;
        let mut histogram = LatencyHistogram { max_ns, ..LatencyHistogram::default() };
        for (bucket, count) in counts {
            let place = histogram.counts.get_mut(bucket).ok_or_else(|| serde::de::Error::custom("no such bucket"))?;
            *place = count;
            histogram.total = histogram.total.saturating_add(count);
        }
        Ok(histogram)
    }
}

/// Times of a partition's frames, since a start or over several.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameTimes {
    /// From the send of a sample to the frame that takes it.
    pub latency: LatencyHistogram,
    /// Execution of a frame, its outputs sent.
    pub frame: LatencyHistogram,
    /// From the send of the newest sample of a frame until what the frame publishes is sent.
    pub end_to_end: LatencyHistogram,
    /// From the moment a frame is due (its tick is sent; of a source at `--speed` the clock) to its
    /// beginning.
    pub jitter: LatencyHistogram,
    /// Frames that ended later than their deadline.
    pub deadline_misses: u64,
    /// Whole periods by which frames began late, in real time.
    #[serde(default)]
    pub cycle_slips: u64,
}

impl FrameTimes {
    /// Becomes the same as `other`; takes no memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.latency.copy_from(&other.latency);
        self.frame.copy_from(&other.frame);
        self.end_to_end.copy_from(&other.end_to_end);
        self.jitter.copy_from(&other.jitter);
        (self.deadline_misses, self.cycle_slips) = (other.deadline_misses, other.cycle_slips);
    }

    /// Adds the times of another life.
    pub fn add(&mut self, other: &Self) {
        self.latency.add(&other.latency);
        self.frame.add(&other.frame);
        self.end_to_end.add(&other.end_to_end);
        self.jitter.add(&other.jitter);
        self.deadline_misses += other.deadline_misses;
        self.cycle_slips += other.cycle_slips;
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
        assert_eq!(histogram.max_us(), 1000.0);
    }

    #[test]
    fn two_histograms_added_are_the_histogram_of_both_also_through_a_file() {
        let [mut one, mut two, mut both] = [(); 3].map(|()| LatencyHistogram::default());
        for k in 1..200_u64 {
            let half = if k % 3 == 0 { &mut one } else { &mut two };
            half.record(k * k * 37);
            both.record(k * k * 37);
        }
        let back: LatencyHistogram = serde_json::from_str(&serde_json::to_string(&two).unwrap()).unwrap();
        assert_eq!(back, two);
        one.add(&back);
        assert_eq!(one, both);
        assert_eq!(both.buckets().map(|(_, count)| count).sum::<u64>(), both.total());
    }
}
