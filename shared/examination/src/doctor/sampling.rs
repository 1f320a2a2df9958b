//! How the samples of a channel relate to the rows: values that are held, channels that are late.

use super::content::is_input;
use super::{Check, Finding, Severity, short, usable};
use crate::delay::{Delay, delays};
use crate::held::held;
use crate::missing::missing;
use channels::{Channel, EvenClock, GAP_MEDIANS, Recording, Uniform};

/// Fewest rows of channels that are compared.
const ROWS_MIN: usize = 1024;
/// Rows without a sample that are looked at, per sample.
const ROWS_PER_SAMPLE_MAX: usize = 4;

/// A measured channel whose values stand for several rows.
pub fn held_values(channel: &Channel) -> Option<Finding> {
    let interval_s = channel.interval_s().filter(|_| !is_input(channel))?;
    let (skipped, values) = on_rows(channel)?;
    let found = held(&values)?;
    let (rate, logged) = (1.0 / (interval_s * found.rows_per_value), 1.0 / interval_s);
    Some(
        Finding::new(Check::Held, Severity::Warning, &channel.name, rate, "Hz")
            .because(format!(
                "each value stands for {} rows: updated at {} Hz, logged at {} Hz; the first fresh one is in row {}",
                short(found.rows_per_value),
                short(rate),
                short(logged),
                found.fresh_rows.first().map_or(0, |row| skipped + row + 1)
            ))
            .cure("use the rows with fresh values only: what lies above half the update rate is folded below it, and repeated above"),
    )
}

/// The values at the rows of their even clock, NaN where there is none, and how many samples lie
/// before the first of them; `None` for an uneven clock, on whose rows there would be holes at
/// distances that look like a clock of their own.
///
/// A clock with many more rows than samples shows in its longest stretch without a gap: a gap may
/// be as long as it likes.
fn on_rows(channel: &Channel) -> Option<(usize, Vec<f64>)> {
    if !channel.irregular() && missing(&channel.time_s).is_none() {
        return Some((0, channel.value.clone()));
    }
    let clock = EvenClock::of(&channel.time_s)?;
    if clock.missing() > ROWS_PER_SAMPLE_MAX * channel.value.len() {
        let stretch = channel.longest_stretch(GAP_MEDIANS);
        return Some((*stretch.first()?, stretch.iter().map(|row| channel.value[*row]).collect()));
    }
    let mut values = vec![f64::NAN; clock.rows.last()? + 1];
    for (row, value) in clock.rows.iter().zip(&channel.value) {
        values[*row] = *value;
    }
    Some((0, values))
}

/// Measured channels of one unit and one clock that are later than most of them; those of `held`
/// are late by their holding and stay out.
pub fn late(recording: &Recording, held: &[String]) -> Vec<Finding> {
    let channels = usable(recording, ROWS_MIN);
    let compared: Vec<(&Channel, Uniform)> = channels
        .into_iter()
        .filter(|c| !is_input(c) && !held.contains(&c.name) && !["", "-", "?"].contains(&c.unit.as_str()))
        .filter_map(|c| c.uniform().filter(|u| !u.interpolated).map(|u| (c, u)))
        .collect();
    let mut findings = Vec::new();
    let mut done = vec![false; compared.len()];
    for first in 0..compared.len() {
        if done[first] {
            continue;
        }
        let like = |k: &usize| {
            let ((a, x), (b, y)) = (&compared[first], &compared[*k]);
            a.unit == b.unit && (x.start_s, x.dt_s, x.value.len()) == (y.start_s, y.dt_s, y.value.len())
        };
        let group: Vec<usize> = (first..compared.len()).filter(like).collect();
        group.iter().for_each(|k| done[*k] = true);
        let values: Vec<&[f64]> = group.iter().map(|k| compared[*k].1.value.as_slice()).collect();
        let dt_s = compared[first].1.dt_s;
        for (k, delay) in group.iter().zip(delays(&values, dt_s)) {
            let others: Vec<&str> = group.iter().filter(|j| *j != k).map(|j| compared[*j].0.name.as_str()).collect();
            findings.extend(delay.map(|delay| late_by(compared[*k].0, &others, delay, dt_s)));
        }
    }
    findings
}

fn late_by(channel: &Channel, others: &[&str], delay: Delay, dt_s: f64) -> Finding {
    let way = if delay.delay_s > 0.0 { "later" } else { "earlier" };
    Finding::new(Check::Delay, Severity::Warning, &channel.name, delay.delay_s, "s")
        .with(others)
        .sigma(delay.sigma_s)
        .because(format!(
            "its phase against the other channels in {} is a straight line over frequency: {} samples {way}",
            channel.unit,
            short(delay.delay_s.abs() / dt_s)
        ))
        .cure("shift its stamps by that much; frequencies and damping stand, shapes and what relates channels do not")
}

#[cfg(test)]
mod tests {
    use super::super::{Check, Finding, examine};
    use crate::noise::Noise;
    use channels::{Channel, Recording};

    /// Accelerations of three places in 120 s at 50 Hz, broad in frequency, each with noise of its
    /// own.
    fn motion(seed: u64) -> Vec<Vec<f64>> {
        let mut noise = Noise::new(seed);
        let (mut x, mut v) = ([0.0; 2], [0.0; 2]);
        let mut places = vec![Vec::new(); 3];
        for _ in 0..6000 {
            for (k, stiffness) in [0.04, 0.3].into_iter().enumerate() {
                v[k] += noise.normal() - stiffness * x[k] - 0.05 * v[k];
                x[k] += v[k];
            }
            places[0].push(x[0] + x[1]);
            places[1].push(0.7 * x[0] - x[1]);
            places[2].push(x[0] + 0.2 * x[1]);
        }
        places.iter_mut().flatten().for_each(|value| *value += 0.1 * noise.normal());
        places
    }

    fn recording(places: &[Vec<f64>]) -> Recording {
        let channel = |(k, value): (usize, &Vec<f64>)| {
            let time_s = (0..value.len()).map(|i| 0.02 * i as f64).collect();
            Channel::new(["a", "b", "c"][k], "m/s^2", time_s, value.clone())
        };
        Recording { name: "rig".into(), channels: places.iter().enumerate().map(channel).collect() }
    }

    fn of(findings: &[Finding], check: Check) -> Vec<&Finding> {
        findings.iter().filter(|f| f.check == check).collect()
    }

    #[test]
    fn a_channel_that_is_held_is_told_with_its_rate_and_is_not_called_late_or_coarse() {
        let mut places = motion(11);
        let fresh = places[1].clone();
        (0..fresh.len()).for_each(|k| places[1][k] = fresh[k - k % 4]);
        let findings = examine(&recording(&places));
        let [held] = of(&findings, Check::Held)[..] else { panic!("{findings:#?}") };
        assert_eq!(held.channel, "b");
        assert!((held.value - 12.5).abs() < 1e-9, "{held:?}");
        assert!(of(&findings, Check::Delay).is_empty() && of(&findings, Check::Quantisation).is_empty());
    }

    #[test]
    fn a_channel_that_is_late_is_told_by_how_much_and_sound_ones_are_not() {
        let mut places = motion(12);
        let sound = examine(&recording(&places));
        assert!(of(&sound, Check::Delay).is_empty() && of(&sound, Check::Held).is_empty(), "{sound:#?}");
        places[2].rotate_right(6);
        let findings = examine(&recording(&places));
        let [late] = of(&findings, Check::Delay)[..] else { panic!("{findings:#?}") };
        assert_eq!((late.channel.as_str(), late.others.len()), ("c", 2));
        assert!((late.value - 0.12).abs() < 4.0 * late.sigma.unwrap() + 1e-3, "{late:?}");
    }

    #[test]
    fn a_gap_of_ten_years_is_a_gap_and_costs_no_more_than_its_samples() {
        let mut recording = recording(&motion(14));
        for channel in &mut recording.channels {
            channel.time_s[3000..].iter_mut().for_each(|time| *time += 3e8);
        }
        let findings = examine(&recording);
        let [gaps] = of(&findings, Check::Gaps)[..] else { panic!("{findings:#?}") };
        assert!(gaps.evidence.starts_with("1 gap(s) in 3 channels"), "{gaps:?}");
        assert!(of(&findings, Check::IrregularTime).is_empty(), "{findings:#?}");
    }

    #[test]
    fn gaps_of_several_channels_are_one_finding_and_lost_rows_leave_the_clock_even() {
        let mut recording = recording(&motion(13));
        for (k, channel) in recording.channels.iter_mut().enumerate() {
            let kept: Vec<usize> = (0..channel.value.len()).filter(|i| (i + k) % 10 != 9).collect();
            channel.time_s = kept.iter().map(|i| channel.time_s[*i]).collect();
            channel.value = kept.iter().map(|i| channel.value[*i]).collect();
        }
        let findings = examine(&recording);
        let [gaps] = of(&findings, Check::Gaps)[..] else { panic!("{findings:#?}") };
        assert!(gaps.evidence.starts_with("1799 gap(s) in 3 channels, 1799 samples missing"), "{gaps:?}");
        assert!(of(&findings, Check::IrregularTime).is_empty(), "{findings:#?}");
    }
}
