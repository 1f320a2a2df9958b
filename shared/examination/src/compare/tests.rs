//! Laws of the comparison: each difference is named with its size, noise alone is called noise.

use core::f64::consts::PI;

use super::{Verdict, compare};
use crate::noise::Noise;
use channels::{Channel, Recording, Role};

fn recording(name: &str, time: &[f64], channels: &[(&str, Vec<f64>)]) -> Recording {
    let channels = channels
        .iter()
        .map(|(n, v)| Channel {
            name: (*n).into(),
            unit: "rad/s".into(),
            time_s: time.to_vec(),
            value: v.clone(),
            role: Role::Output,
        })
        .collect();
    Recording { name: name.into(), channels }
}

fn signal(t: f64) -> f64 {
    libm::sin(2.0 * PI * 0.23 * t)
        + 0.6 * libm::sin(2.0 * PI * 0.61 * t + 1.0)
        + 0.3 * libm::sin(2.0 * PI * 1.37 * t + 2.0)
}

fn judged(real: impl Fn(f64) -> f64, sigma: f64, seed: u64) -> super::ChannelComparison {
    let time: Vec<f64> = (0..4000).map(|i| i as f64 * 0.02).collect();
    let mut noise = Noise::new(seed);
    let real = time.iter().map(|t| real(*t) + sigma * noise.normal()).collect();
    let simulated = time.iter().map(|t| signal(*t)).collect();
    compare(&recording("real", &time, &[("rate", real)]), &recording("sim", &time, &[("rate", simulated)]))
        .channels
        .remove(0)
}

#[test]
fn white_noise_alone_is_called_noise() {
    let wrong: Vec<_> =
        (0..100).map(|seed| judged(signal, 0.05, seed)).filter(|c| c.verdict != Verdict::OnlyNoise).collect();
    // Three lists and four explanations at 1e-4 on 100 records: 0.07 expected; two have a
    // probability below 0.3 %.
    assert!(wrong.len() <= 1, "{wrong:#?}");
}

#[test]
fn equal_recordings_are_identical() {
    assert_eq!(judged(signal, 0.0, 0).verdict, Verdict::Identical);
}

#[test]
fn lag_gain_offset_and_sign_are_each_named_with_their_size() {
    let lag = judged(|t| signal(t - 0.0123), 0.002, 1);
    assert_eq!(lag.verdict, Verdict::Lag, "{lag:#?}");
    assert!((lag.lag_s - 0.0123).abs() < 4.0 * lag.lag_sigma_s && lag.lag_sigma_s < 1e-4, "{lag:#?}");
    assert!(lag.conclusion.contains("the rest is noise"), "{}", lag.conclusion);
    let gain = judged(|t| 1.07 * signal(t), 0.002, 2);
    assert_eq!(gain.verdict, Verdict::Scale);
    assert!((gain.scale - 1.07).abs() < 4.0 * gain.scale_sigma.max(1e-5), "{gain:#?}");
    let offset = judged(|t| signal(t) + 0.03, 0.002, 3);
    assert_eq!(offset.verdict, Verdict::Offset);
    assert!((offset.offset - 0.03).abs() < 4.0 * offset.offset_sigma);
    assert_eq!(judged(|t| -signal(t), 0.002, 4).verdict, Verdict::Sign);
}

#[test]
fn a_missing_mode_is_located_in_its_band_and_a_burst_in_its_window() {
    let band = judged(|t| signal(t) + 0.02 * libm::sin(2.0 * PI * 3.1 * t), 0.005, 5);
    assert_eq!(band.verdict, Verdict::Band, "{band:#?}");
    assert!(
        band.bands[0].low_hz < 3.1 && band.bands[0].high_hz > 3.1 && band.bands[0].high_hz < 6.0,
        "{:#?}",
        band.bands
    );
    let mut hit = Noise::new(99);
    let kicks: Vec<f64> = hit.series(4000, 0.1);
    let window =
        judged(|t| signal(t) + if (30.0..34.0).contains(&t) { kicks[(t / 0.02) as usize] } else { 0.0 }, 0.005, 6);
    assert_eq!(window.verdict, Verdict::Window, "{window:#?}");
    assert!(window.windows[0].start_s < 34.0 && window.windows[0].end_s > 30.0);
}

#[test]
fn the_difference_follows_the_input_that_was_left_out() {
    let time: Vec<f64> = (0..4000).map(|i| i as f64 * 0.02).collect();
    let mut noise = Noise::new(7);
    let (heater, wheel) = (noise.series(4000, 1.0), noise.series(4000, 1.0));
    let real = time.iter().enumerate().map(|(i, t)| signal(*t) + 0.02 * heater[i] + 0.01 * noise.normal()).collect();
    let simulated = time.iter().map(|t| signal(*t)).collect();
    let all = compare(
        &recording("real", &time, &[("rate", real), ("heater", heater), ("wheel", wheel)]),
        &recording("sim", &time, &[("rate", simulated)]),
    );
    let rate = &all.channels[0];
    assert_eq!(rate.coherence.iter().map(|c| c.channel.as_str()).collect::<Vec<_>>(), ["heater"]);
    // 0.02²/(0.02² + 0.01²) = 0.8; the estimate scatters by a few percent.
    assert!((rate.coherence[0].share - 0.8).abs() < 0.06, "{:#?}", rate.coherence);
    assert_eq!(all.unmatched.len(), 2);
}

#[test]
fn other_stamps_are_interpolated_and_said_so_and_lonely_channels_get_their_nearest_names() {
    let (a, b): (Vec<f64>, Vec<f64>) =
        ((0..2000).map(|i| i as f64 * 0.02).collect(), (0..5000).map(|i| 0.003 + i as f64 * 0.009).collect());
    let real = recording("real", &a, &[("rate", a.iter().map(|t| signal(*t)).collect()), ("angel", vec![0.0; 2000])]);
    let simulated =
        recording("sim", &b, &[("rate", b.iter().map(|t| signal(*t)).collect()), ("angle", vec![0.0; 5000])]);
    let all = compare(&real, &simulated);
    assert!(all.channels[0].resampling.contains("cubic"));
    // Cubic interpolation at 9 ms of at most 1.4 Hz: (2 pi 1.4 0.009)^4 · 3/128 of 0.3, some 1e-6.
    assert!(all.channels[0].rms < 1e-5, "{}", all.channels[0].rms);
    assert_eq!(all.unmatched[0].nearest[0], "angle");
}

/// Stamps off an even clock by up to half a step, as [0.4, 1.6] of an interval.
fn irregular(n: usize, dt_s: f64, seed: u64) -> Vec<f64> {
    let mut noise = Noise::new(seed);
    let mut t = 0.0;
    (0..n)
        .map(|_| {
            t += dt_s * (0.4 + 1.2 * noise.uniform());
            t
        })
        .collect()
}

#[test]
fn irregular_stamps_without_a_gap_are_used_to_the_last_sample_and_their_noise_is_called_noise() {
    let wrong: Vec<_> = (0..100)
        .map(|seed| {
            let (time, mut noise) = (irregular(4000, 0.02, seed), Noise::new(seed + 1000));
            let real = time.iter().map(|t| signal(*t) + 0.05 * noise.normal()).collect();
            let simulated = time.iter().map(|t| signal(*t)).collect();
            compare(&recording("real", &time, &[("rate", real)]), &recording("sim", &time, &[("rate", simulated)]))
                .channels
                .remove(0)
        })
        .inspect(|c| assert_eq!(c.samples, 4000, "{}", c.resampling))
        .filter(|c| c.verdict != Verdict::OnlyNoise || (c.noise_sigma.unwrap_or(0.0) / 0.05 - 1.0).abs() > 0.1)
        .collect();
    // As on even stamps: 0.07 expected.
    assert!(wrong.len() <= 1, "{wrong:#?}");
}

#[test]
fn a_lag_between_irregular_stamps_is_found_to_its_sigma() {
    let (time, other) = (irregular(4000, 0.02, 1), irregular(9000, 0.009, 2));
    let mut noise = Noise::new(3);
    let real = time.iter().map(|t| signal(t - 0.0123) + 0.002 * noise.normal()).collect();
    let simulated = other.iter().map(|t| signal(*t)).collect();
    let all = compare(&recording("real", &time, &[("rate", real)]), &recording("sim", &other, &[("rate", simulated)]));
    let c = &all.channels[0];
    assert_eq!(c.verdict, Verdict::Lag, "{c:#?}");
    assert!((c.lag_s - 0.0123).abs() < 4.0 * c.lag_sigma_s && c.lag_sigma_s < 1e-4, "{c:#?}");
}

#[test]
fn one_lost_sample_cuts_nothing_and_a_gap_does_and_how_much_was_used_is_said() {
    let time: Vec<f64> = (0..4000).map(|i| i as f64 * 0.02).collect();
    let simulated = recording("sim", &time, &[("rate", time.iter().map(|t| signal(*t)).collect())]);
    let without = |lost: &dyn Fn(usize) -> bool| {
        let kept: Vec<f64> = (0..4000).filter(|i| !lost(*i)).map(|i| time[i]).collect();
        let value = kept.iter().map(|t| signal(*t)).collect();
        compare(&recording("real", &kept, &[("rate", value)]), &simulated).channels.remove(0)
    };
    let seldom = without(&|i| i % 7 == 3);
    assert_eq!(seldom.samples, 3429);
    assert!(seldom.resampling.contains("all 3429 recorded samples used"), "{}", seldom.resampling);
    let gap = without(&|i| (1000..1050).contains(&i));
    assert_eq!((gap.samples, gap.verdict), (2950, Verdict::Identical));
    assert!(gap.resampling.contains("2950 of 3950 recorded samples used"), "{}", gap.resampling);
}

#[test]
fn units_of_different_quantities_are_not_compared_and_a_number_without_unit_is() {
    let time: Vec<f64> = (0..500).map(|i| i as f64 * 0.02).collect();
    let of = |unit: &str| {
        let mut one = recording(unit, &time, &[("rate", time.iter().map(|t| signal(*t)).collect())]);
        one.channels[0].unit = unit.into();
        one
    };
    let verdict = |a: &str, b: &str| compare(&of(a), &of(b)).channels.remove(0);
    let apart = verdict("kg", "rad");
    assert_eq!((apart.verdict, apart.fit_percent), (Verdict::Units, None));
    assert!(apart.conclusion.contains("recorded in kg, simulated in rad"), "{}", apart.conclusion);
    for (a, b) in [("N*m", "Nm"), ("rad", ""), ("-", "rad"), ("m/s^2", "m/s2")] {
        assert_eq!(verdict(a, b).verdict, Verdict::Identical, "{a} {b}");
    }
}

#[test]
fn recordings_without_a_common_time_are_told_so_with_what_lies_between() {
    let at = |from: f64| -> Vec<f64> { (0..500).map(|i| from + i as f64 * 0.02).collect() };
    let of = |from: f64| recording("one", &at(from), &[("rate", at(0.0).iter().map(|t| signal(*t)).collect())]);
    for (real, simulated, cure) in [
        (1.7e9, 0.0, "take 1700000000 s off the recorded stamps"),
        (0.0, 1.7e9, "take 1700000000 s off the simulated stamps"),
    ] {
        let apart = compare(&of(real), &of(simulated)).channels.remove(0);
        assert_eq!(apart.verdict, Verdict::NoCommonTime);
        assert!(apart.conclusion.contains(cure), "{}", apart.conclusion);
    }
    assert_eq!(compare(&of(0.0), &of(9.8)).channels[0].verdict, Verdict::TooShort);
}

#[test]
fn a_recorded_channel_that_never_changes_has_no_fit() {
    // the mean of many equal numbers is off by rounding, and their deviation is not zero
    let still = judged(|_| 0.06981317007977318, 0.0, 1);
    assert_eq!((still.verdict, still.fit_percent, still.lag_fit_percent), (Verdict::Constant, None, None));
    assert!(still.conclusion.contains("undefined"), "{}", still.conclusion);
    let time: Vec<f64> = (0..500).map(|i| i as f64 * 0.02).collect();
    let of = |value: f64| recording("one", &time, &[("rate", vec![value; 500])]);
    let both = compare(&of(0.3), &of(0.1)).channels.remove(0);
    assert_eq!((both.verdict, both.fit_percent), (Verdict::Offset, None), "{both:#?}");
}

#[test]
fn channels_that_have_nothing_to_do_with_each_other_are_called_unrelated() {
    // another tone, ten times as large: a gain near zero takes away nearly all of the difference
    // and explains nothing
    let other = judged(|t| 0.1 * libm::sin(2.0 * PI * 4.7 * t + 0.4), 0.002, 8);
    assert_eq!(other.verdict, Verdict::Unrelated, "{other:#?}");
    assert!(other.conclusion.contains("unrelated"), "{}", other.conclusion);
    let half = judged(|t| 0.089 * signal(t), 0.002, 9);
    assert_eq!(half.verdict, Verdict::Scale, "a true gain of 0.089 stays one: {half:#?}");
}

#[test]
fn friction_in_the_band_of_the_motion_is_no_band() {
    // a swing that decays against one that does not: the difference has the swing's own frequency
    let time: Vec<f64> = (0..4000).map(|i| i as f64 * 0.02).collect();
    let mut noise = Noise::new(11);
    let swing = |t: f64, decay: f64| libm::exp(-decay * t) * libm::cos(2.0 * PI * 0.8 * t);
    let real = time.iter().map(|t| swing(*t, 0.05) + 0.002 * noise.normal()).collect();
    let simulated = time.iter().map(|t| swing(*t, 0.0)).collect();
    let one = compare(&recording("real", &time, &[("angle", real)]), &recording("sim", &time, &[("angle", simulated)]));
    assert_ne!(one.channels[0].verdict, Verdict::Band, "{}", one.channels[0].conclusion);
    assert!(one.channels[0].conclusion.contains("0.") && !one.channels[0].bands.is_empty());
}
