//! The stretch of a long recording that checks of pairs and spectra look at.
//!
//! Their cost grows with the samples, what they resolve with the square root. A correlation of n
//! samples scatters by `1/√n`, a phase or a lag likewise: at 10⁵ samples a channel that is 0.3 %,
//! below every material size of these checks. What shows in single samples (spikes, saturation,
//! gaps, jumps) and what changes over the record (segments) is looked for in all of them.

use std::borrow::Cow;

use channels::{Channel, Recording};

/// Samples of all channels together beyond which a stretch is taken: 130 000 rows of eight
/// channels.
const STRETCH_SAMPLES_MAX: usize = 1 << 20;
/// Places at which a stretch may begin, per length of one: a burst is cut by at most a quarter.
const PLACES_PER_STRETCH: usize = 4;

/// The recording, or of a long one the stretch in which its channels change most, each by its own
/// measure: the sum over channels of the stretch's share in `Σ (x_k − x_{k−1})²`.
pub fn liveliest(recording: &Recording) -> Cow<'_, Recording> {
    let samples: usize = recording.channels.iter().map(|c| c.value.len()).sum();
    let ends = |f: fn(&[f64]) -> Option<&f64>| recording.channels.iter().filter_map(move |c| f(&c.time_s).copied());
    let (start, end) =
        (ends(<[f64]>::first).fold(f64::INFINITY, f64::min), ends(<[f64]>::last).fold(f64::NEG_INFINITY, f64::max));
    if samples <= STRETCH_SAMPLES_MAX || end <= start {
        return Cow::Borrowed(recording);
    }
    let duration = (end - start) * STRETCH_SAMPLES_MAX as f64 / samples as f64;
    let hop = duration / PLACES_PER_STRETCH as f64;
    let places = libm::ceil((end - start - duration) / hop) as usize + 1;
    let begin = |place: usize| (start + place as f64 * hop).min(end - duration);
    let mut best = (0.0, 0);
    for place in 0..places {
        let share: f64 = recording.channels.iter().map(|c| liveliness(c, begin(place), duration)).sum();
        if share > best.0 {
            best = (share, place);
        }
    }
    let from = begin(best.1);
    let cut = |c: &Channel| {
        let rows = rows(c, from, duration);
        Channel {
            time_s: c.time_s[rows.clone()].to_vec(),
            value: c.value[rows].to_vec(),
            name: c.name.clone(),
            unit: c.unit.clone(),
            role: c.role,
        }
    };
    Cow::Owned(Recording { name: recording.name.clone(), channels: recording.channels.iter().map(cut).collect() })
}

fn rows(channel: &Channel, from: f64, duration: f64) -> core::ops::Range<usize> {
    let at = |time: f64| channel.time_s.partition_point(|t| *t < time);
    at(from)..at(from + duration)
}

/// Share of a channel's squared changes that lies in a stretch.
fn liveliness(channel: &Channel, from: f64, duration: f64) -> f64 {
    let changes = |x: &[f64]| x.windows(2).map(|w| (w[1] - w[0]) * (w[1] - w[0])).sum::<f64>();
    let all = changes(&channel.value);
    if all > 0.0 { changes(&channel.value[rows(channel, from, duration)]) / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{STRETCH_SAMPLES_MAX, liveliest};
    use channels::{Channel, Recording};

    #[test]
    fn a_long_recording_is_seen_where_it_moves_and_a_short_one_whole() {
        let channel = |n: usize| {
            let moves = |k: usize| if (n / 2..n / 2 + n / 20).contains(&k) { (0.1 * k as f64).sin() } else { 0.0 };
            Channel::new("a", "rad", (0..n).map(|k| 1e-3 * k as f64).collect(), (0..n).map(moves).collect())
        };
        let of = |n: usize| Recording { name: "r".into(), channels: vec![channel(n), channel(n)] };
        let short = of(1000);
        assert_eq!(*liveliest(&short), short);
        let long = of(STRETCH_SAMPLES_MAX);
        let seen = liveliest(&long);
        let [a, b] = &seen.channels[..] else { panic!() };
        assert_eq!(a.time_s, b.time_s);
        assert!(a.value.len().abs_diff(STRETCH_SAMPLES_MAX / 2) <= 1, "{}", a.value.len());
        let energy = |c: &Channel| c.value.iter().map(|v| v * v).sum::<f64>();
        assert!(energy(a) > 0.99 * energy(&long.channels[0]));
    }
}
