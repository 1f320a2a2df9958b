//! In which rows of a table the excitation is on, from the measured forces and torques alone.
//!
//! 1. A channel's scatter is read from the quietest quarter of its steps from row to row (for white
//!    noise that quantile of the step's magnitude is 0.45 σ). A channel that spans less than six
//!    scatters either way is noise or a constant and excites nothing.
//! 2. A row is excited when a channel exceeds a twentieth of its own largest magnitude in the
//!    record, and six scatters.
//! 3. A quiet stretch shorter than a hundredth of the record, than ten rows or than a tenth of the
//!    excited stretch before it is a zero crossing and counts as excited.
//! 4. When less than a tenth of the record is quiet, there is nothing behind the excitation to look
//!    at: the record is operational, and no row is called excited.
//!
//! Fails on an excitation that cannot be distinguished from noise over more than three quarters of
//! a record (white or close to the sample rate): such a record counts as operational, which it is.

/// Part of the largest magnitude above which a channel is on.
const ON: f64 = 0.05;
/// Standard deviations no noise reaches.
const SCATTERS: f64 = 6.0;
/// Lower quartile of the magnitude of a step of white noise, in its standard deviation:
/// `√2 × 0.3186`.
const QUARTILE_OF_STEP: f64 = 0.4506;
/// Shortest quiet stretch, in parts of the record, in rows, and in parts of the excited stretch
/// before it.
const QUIET_PART: usize = 100;
const QUIET_ROWS: usize = 10;
const QUIET_OF_EXCITED: usize = 10;
/// Part of the record that has to be quiet.
const QUIET_TOTAL_PART: usize = 10;

/// What the channels say.
#[derive(Debug, PartialEq)]
pub(crate) struct Excitation {
    /// Per row.
    pub on: Vec<bool>,
    /// There is an excitation, and it hardly ever pauses.
    pub operational: bool,
}

impl Excitation {
    /// Of a record of `rows` rows.
    pub fn find<'a>(rows: usize, channels: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut on = vec![false; rows];
        for channel in channels {
            let Some(level) = level(channel) else { continue };
            on.iter_mut().zip(channel).for_each(|(on, value)| *on |= value.abs() > level);
        }
        bridge(&mut on);
        let quiet = on.iter().filter(|on| !**on).count();
        let operational = quiet * QUIET_TOTAL_PART < rows;
        if operational {
            on.fill(false);
        }
        Excitation { on, operational }
    }
}

/// Magnitude from which a channel is on; `None` when it never rises above its own scatter.
fn level(channel: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = channel.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    steps.sort_by(f64::total_cmp);
    let scatter = steps.get(steps.len() / 4)? / QUARTILE_OF_STEP;
    let (low, high) =
        channel.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
    let largest = high.max(-low);
    let rises = 0.5 * (high - low) > SCATTERS * scatter;
    rises.then(|| (ON * largest).max(SCATTERS * scatter))
}

/// Excited too: the quiet stretches that are only zero crossings. Rest before the first excitation
/// does not count.
fn bridge(on: &mut [bool]) {
    let shortest = (on.len() / QUIET_PART).max(QUIET_ROWS);
    let (mut start, mut excited) = (0, 0);
    while start < on.len() {
        let length = on[start..].iter().take_while(|row| **row == on[start]).count();
        if on[start] {
            excited = length;
        } else if excited > 0 && length < shortest.max(excited / QUIET_OF_EXCITED) {
            on[start..start + length].fill(true);
        }
        start += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform in ±1: SplitMix64.
    fn noise(n: usize) -> f64 {
        let mut z = (n as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(63) - 1.0
    }

    fn find(channels: &[Vec<f64>]) -> Excitation {
        Excitation::find(channels[0].len(), channels.iter().map(Vec::as_slice))
    }

    fn record(rows: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..rows).map(value).collect()
    }

    /// Rows that differ from `truth`.
    fn wrong(found: &Excitation, truth: impl Fn(usize) -> bool) -> usize {
        found.on.iter().enumerate().filter(|(n, on)| **on != truth(*n)).count()
    }

    #[test]
    fn a_measured_pulse_is_on_exactly_while_it_lasts_whatever_noise_lies_on_it_or_on_its_neighbour() {
        for sigma in [0.0, 1e-3, 0.05] {
            let pulse = record(1200, |n| if (300..500).contains(&n) { -2.0 } else { 0.0 } + sigma * noise(n));
            let beside = record(1200, |n| 0.4 + sigma * noise(n + 7777));
            let found = find(&[pulse, beside]);
            assert_eq!((wrong(&found, |n| (300..500).contains(&n)), found.operational), (0, false), "sigma {sigma}");
        }
    }

    #[test]
    fn zero_crossings_of_a_sine_do_not_chop_it_at_any_frequency() {
        for period in [20.0, 200.0, 3000.0] {
            let sine = |n: usize| {
                if (1000..7000).contains(&n) { (n as f64 * std::f64::consts::TAU / period).sin() } else { 0.0 }
            };
            let found = find(&[record(10_000, |n| sine(n) + 1e-3 * noise(n))]);
            // The ends of a slow sine are quiet: a twentieth of the amplitude is 0.8 % of a period.
            let ends = (0.02 * period) as usize + 2;
            assert!(wrong(&found, |n| (1000..7000).contains(&n)) <= ends && !found.operational, "period {period}");
        }
    }

    #[test]
    fn an_excitation_without_a_pause_is_operational_and_none_at_all_is_quiet() {
        for value in [
            (|n| (n as f64 / 40.0).sin()) as fn(usize) -> f64,
            |n| 1.0 + n as f64,
            |n| {
                if n < 950 { 1.0 } else { 0.0 }
            },
        ] {
            let found = find(&[record(1000, value)]);
            assert!(found.operational && found.on.iter().all(|on| !on));
        }
        for value in [noise as fn(usize) -> f64, |_| 0.0, |_| -3.0, |n| 5.0 + 0.1 * noise(n)] {
            let found = find(&[record(1000, value)]);
            assert!(!found.operational && found.on.iter().all(|on| !on));
        }
        assert!(find(&[vec![]]).on.is_empty());
    }

    #[test]
    fn blows_one_after_the_other_leave_the_decays_between_them() {
        let blow = |n: usize| (n % 400) < 3;
        let found = find(&[record(8000, |n| if blow(n) { 50.0 } else { 0.1 * noise(n) })]);
        assert_eq!((wrong(&found, blow), found.operational), (0, false));
    }

    #[test]
    fn rescaling_a_channel_changes_nothing() {
        let pulse = |scale: f64| find(&[record(900, |n| scale * (f64::from(n < 100) + 0.01 * noise(n)))]);
        assert_eq!(pulse(1.0), pulse(1e-9));
        assert_eq!(pulse(1.0), pulse(1e9));
    }
}
