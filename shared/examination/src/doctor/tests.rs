//! Laws of the examination: silent on sound data, each fault found with the size it was given.

use core::f64::consts::PI;

use super::{Check, Finding, Severity, examine};
use crate::noise::Noise;
use channels::{Channel, Recording, Role};

fn channel(name: &str, unit: &str, time_s: &[f64], value: Vec<f64>) -> Channel {
    Channel { name: name.into(), unit: unit.into(), time_s: time_s.to_vec(), value, role: Role::Output }
}

fn even(n: usize, dt_s: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * dt_s).collect()
}

fn recording(channels: Vec<Channel>) -> Recording {
    Recording { name: "synthetic".into(), channels }
}

fn of(findings: &[Finding], check: Check) -> Option<&Finding> {
    findings.iter().find(|f| f.check == check)
}

/// A smooth broad-band angle and its exact rate: eight sines below 2 Hz.
fn motion(seed: u64) -> (impl Fn(f64) -> f64, impl Fn(f64) -> f64) {
    let mut noise = Noise::new(seed);
    let lines: Vec<(f64, f64, f64)> = (0..8)
        .map(|k| (0.3 * noise.normal(), 2.0 * PI * (0.11 + 0.23 * k as f64), 2.0 * PI * noise.uniform()))
        .collect();
    let other = lines.clone();
    (
        move |t: f64| lines.iter().map(|(a, w, p)| a * libm::sin(w * t + p)).sum(),
        move |t: f64| other.iter().map(|(a, w, p)| a * w * libm::cos(w * t + p)).sum(),
    )
}

#[test]
fn white_noise_raises_no_finding() {
    let time = even(600, 0.01);
    let mut alarms = Vec::new();
    for seed in 0..100 {
        let mut noise = Noise::new(seed);
        let channels = ["angle [rad]", "rate [rad/s]", "acceleration_x [m/s^2]", "torque [N*m]"]
            .iter()
            .map(|name| {
                let (name, unit) = name.split_once(" [").expect("has a unit");
                let mut c = channel(name, unit.trim_end_matches(']'), &time, noise.series(600, 1.0));
                c.role = Role::Unknown;
                c
            })
            .collect();
        alarms.extend(
            examine(&recording(channels)).into_iter().filter(|f| f.check != Check::NoSignal).map(|f| (seed, f)),
        );
    }
    // 26 checks at 1e-4 on 100 recordings: 0.26 alarms expected at most; more than 2 has a
    // probability of 0.2 %.
    assert!(alarms.len() <= 2, "{alarms:#?}");
}

#[test]
fn sound_measurements_at_irregular_times_raise_no_finding_but_that() {
    let mut alarms = Vec::new();
    for seed in 0..50 {
        let (angle, rate) = motion(seed);
        let mut noise = Noise::new(seed + 1000);
        let time: Vec<f64> = even(1200, 0.01).iter().map(|t| t + 0.006 * noise.uniform()).collect();
        let drive: Vec<f64> = noise.series(1200, 1.0);
        let channels = vec![
            channel("angle", "rad", &time, time.iter().map(|t| angle(*t) + 1e-3 * noise.normal()).collect()),
            channel("rate", "rad/s", &time, time.iter().map(|t| rate(*t) + 1e-3 * noise.normal()).collect()),
            Channel { role: Role::Input, ..channel("torque", "N*m", &time, drive) },
        ];
        let found = examine(&recording(channels));
        assert!(of(&found, Check::IrregularTime).is_some());
        alarms.extend(found.into_iter().filter(|f| f.check != Check::IrregularTime).map(|f| (seed, f)));
    }
    assert!(alarms.len() <= 2, "{alarms:#?}");
}

#[test]
fn sound_measurements_of_a_motion_raise_no_finding() {
    let mut alarms = Vec::new();
    for seed in 0..100 {
        let (angle, rate) = motion(seed);
        let time = even(1200, 0.01);
        let mut noise = Noise::new(seed + 1000);
        // Seeds divisible by four: no noise at all.
        let sigma = if seed % 4 == 0 { 0.0 } else { 1e-3 };
        let drive: Vec<f64> = noise.series(1200, 1.0);
        let channels = vec![
            channel("angle", "rad", &time, time.iter().map(|t| angle(*t) + sigma * noise.normal()).collect()),
            channel("rate", "rad/s", &time, time.iter().map(|t| rate(*t) + sigma * noise.normal()).collect()),
            Channel { role: Role::Input, ..channel("torque", "N*m", &time, drive) },
        ];
        alarms.extend(examine(&recording(channels)).into_iter().map(|f| (seed, f)));
    }
    assert!(alarms.len() <= 2, "{alarms:#?}");
}

#[test]
fn oscillations_decays_and_random_walks_are_one_segment() {
    let time = even(4000, 0.01);
    for seed in 0..25 {
        let mut noise = Noise::new(seed);
        let mut walk = 0.0;
        let channels: Vec<Vec<f64>> = vec![
            time.iter().map(|t| libm::sin(2.0 * PI * 1.3 * t)).collect(),
            time.iter().map(|t| libm::exp(-0.05 * t) * libm::sin(2.0 * PI * 1.3 * t) + 1e-3 * noise.normal()).collect(),
            (0..4000)
                .map(|_| {
                    walk += 0.01 * noise.normal();
                    walk
                })
                .collect(),
        ];
        for (k, value) in channels.into_iter().enumerate() {
            let segments = super::segments::propose(&recording(vec![channel("x", "m", &time, value)]));
            assert_eq!(segments.len(), 1, "seed {seed}, channel {k}: {segments:?}");
        }
    }
}

#[test]
fn rest_and_motion_are_cut_where_they_meet() {
    let time = even(4000, 0.01);
    let mut noise = Noise::new(3);
    let value = time.iter().map(|t| noise.normal() * if (15.0..25.0).contains(t) { 1.0 } else { 0.01 }).collect();
    let segments = super::segments::propose(&recording(vec![channel("acceleration_x", "m/s^2", &time, value)]));
    assert_eq!(segments.len(), 3, "{segments:?}");
    // Edges lie on blocks of 40 s / 160.
    assert!((segments[1].start_s - 15.0).abs() <= 0.25 && (segments[1].end_s - 25.0).abs() <= 0.25, "{segments:?}");
}

#[test]
fn lag_between_angle_and_rate_is_found_to_its_sigma() {
    for lag_s in [0.0123, -0.004, 0.0007] {
        let (angle, rate) = motion(7);
        let time = even(4000, 0.01);
        let mut noise = Noise::new(8);
        let channels = vec![
            channel("angle", "rad", &time, time.iter().map(|t| angle(*t) + 1e-4 * noise.normal()).collect()),
            channel("rate", "rad/s", &time, time.iter().map(|t| rate(*t - lag_s) + 1e-3 * noise.normal()).collect()),
        ];
        let findings = examine(&recording(channels));
        let lag = of(&findings, Check::Lag).unwrap_or_else(|| panic!("lag {lag_s}: {findings:#?}"));
        let sigma = lag.sigma.unwrap();
        assert!((lag.value - lag_s).abs() < 4.0 * sigma && sigma < 1e-4, "{lag:?}");
    }
}

#[test]
fn lag_scatters_as_its_sigma_says() {
    let mut z = Vec::new();
    for seed in 0..50 {
        let (angle, rate) = motion(seed);
        let time = even(2000, 0.01);
        let mut noise = Noise::new(seed + 500);
        let channels = vec![
            channel("angle", "rad", &time, time.iter().map(|t| angle(*t) + 3e-4 * noise.normal()).collect()),
            channel("rate", "rad/s", &time, time.iter().map(|t| rate(*t - 0.02) + 3e-3 * noise.normal()).collect()),
        ];
        let findings = examine(&recording(channels));
        let lag = of(&findings, Check::Lag).expect("two steps are found");
        z.push((lag.value - 0.02) / lag.sigma.unwrap());
    }
    let spread = identification::statistics::rms(&z);
    // Newey–West underestimates by some 10-20 % at this memory; 50 values scatter by 10 %.
    assert!((0.75..1.4).contains(&spread), "{spread}");
}

#[test]
fn clock_skew_units_sign_offset_and_scale_are_found_with_their_sizes() {
    let (angle, rate) = motion(11);
    let time = even(6000, 0.01);
    let with = |f: &dyn Fn(f64) -> f64, angle_factor: f64| {
        let mut noise = Noise::new(12);
        let channels = vec![
            channel(
                "angle",
                "rad",
                &time,
                time.iter().map(|t| angle_factor * angle(*t) + 1e-4 * noise.normal()).collect(),
            ),
            channel("rate", "rad/s", &time, time.iter().map(|t| f(*t) + 1e-3 * noise.normal()).collect()),
        ];
        examine(&recording(channels))
    };
    let skewed = with(&|t| rate(t * (1.0 - 500e-6)), 1.0);
    let skew = of(&skewed, Check::ClockSkew).expect("500 ppm");
    assert!((skew.value - 500e-6).abs() < 5.0 * skew.sigma.unwrap() && skew.sigma.unwrap() < 5e-5, "{skew:?}");
    let degrees = with(&|t| rate(t), 180.0 / PI);
    assert!(of(&degrees, Check::Units).is_some_and(|f| f.evidence.contains("degrees")), "{degrees:#?}");
    assert!(of(&with(&|t| -rate(t), 1.0), Check::Sign).is_some());
    let biased = with(&|t| rate(t) + 0.1, 1.0);
    assert!((of(&biased, Check::Offset).expect("0.1 rad/s").value - 0.1).abs() < 0.002);
    let scaled = with(&|t| 1.02 * rate(t), 1.0);
    assert!((of(&scaled, Check::Scale).expect("2 %").value - 1.0 / 1.02).abs() < 2e-3);
}

#[test]
fn a_rate_computed_from_a_noisy_or_rounded_angle_is_called_derived() {
    let (angle, _) = motion(21);
    let time = even(2000, 0.01);
    for (sigma, step) in [(1e-3, 0.0), (0.0, 1e-3)] {
        let mut noise = Noise::new(22);
        let a: Vec<f64> = time
            .iter()
            .map(|t| {
                let v = angle(*t) + sigma * noise.normal();
                if step > 0.0 { step * libm::round(v / step) } else { v }
            })
            .collect();
        // A central difference, then smoothed over five samples.
        let d: Vec<f64> =
            (0..2000).map(|i| if (1..1999).contains(&i) { (a[i + 1] - a[i - 1]) / 0.02 } else { 0.0 }).collect();
        let s: Vec<f64> = (0..2000)
            .map(|i| if (2..1998).contains(&i) { d[i - 2..=i + 2].iter().sum::<f64>() / 5.0 } else { d[i] })
            .collect();
        let findings = examine(&recording(vec![channel("angle", "rad", &time, a), channel("rate", "rad/s", &time, s)]));
        let derived = of(&findings, Check::Derived).unwrap_or_else(|| panic!("{findings:#?}"));
        assert_eq!((derived.channel.as_str(), derived.others[0].as_str()), ("rate", "angle"));
    }
}

#[test]
fn a_rate_filtered_recursively_from_an_angle_is_called_derived() {
    let (angle, _) = motion(23);
    let (time, mut noise) = (even(6000, 0.01), Noise::new(24));
    let a: Vec<f64> = time.iter().map(|t| angle(*t) + 1e-2 * noise.normal()).collect();
    let mut state = a[0];
    let rate: Vec<f64> = a
        .iter()
        .map(|v| {
            let r = (v - state) / 0.2;
            state += 0.01 * r;
            r
        })
        .collect();
    let findings = examine(&recording(vec![channel("angle", "rad", &time, a), channel("rate", "rad/s", &time, rate)]));
    assert!(of(&findings, Check::Derived).is_some(), "{findings:#?}");
}

#[test]
fn stamps_that_repeat_run_back_jitter_or_leave_gaps_are_counted() {
    let value = |n: usize| Noise::new(1).series(n, 1.0);
    let examine_time = |time: Vec<f64>| examine(&recording(vec![channel("x", "m", &time, value(time.len()))]));
    let mut twice = even(500, 0.01);
    twice[100] = twice[99];
    assert_eq!(of(&examine_time(twice), Check::DuplicateStamps).expect("one").value, 1.0);
    let runs: Vec<f64> = even(300, 0.01).into_iter().chain(even(300, 0.01)).collect();
    assert_eq!(of(&examine_time(runs), Check::BackwardStamps).expect("one").value, 1.0);
    let gap: Vec<f64> = even(500, 0.01).into_iter().filter(|t| !(1.0 - 1e-9..1.495).contains(t)).collect();
    assert_eq!(of(&examine_time(gap), Check::Gaps).expect("fifty").value, 50.0);
    let mut noise = Noise::new(5);
    let jitter: Vec<f64> = even(500, 0.01).iter().map(|t| t + 2e-4 * (noise.uniform() - 0.5)).collect();
    assert!(of(&examine_time(jitter), Check::Jitter).is_some());
}

#[test]
fn saturation_is_found_and_the_top_of_a_rounded_sine_is_not_taken_for_it() {
    let time = even(2000, 0.01);
    let sine = |t: f64| libm::sin(2.0 * PI * 0.31 * t);
    let clipped = time.iter().map(|t| sine(*t).clamp(-0.8, 0.8)).collect();
    let found = examine(&recording(vec![channel("angle", "rad", &time, clipped)]));
    assert!(of(&found, Check::Saturation).is_some(), "{found:#?}");
    let rounded = time.iter().map(|t| 1e-3 * libm::round(1e3 * sine(*t))).collect();
    let silent = examine(&recording(vec![channel("angle", "rad", &time, rounded)]));
    assert!(of(&silent, Check::Saturation).is_none());
    assert!((of(&silent, Check::Quantisation).expect("a thousandth").value - 1e-3).abs() < 1e-9);
}

#[test]
fn a_spike_is_counted_and_a_step_is_not() {
    let time = even(1000, 0.01);
    let mut noise = Noise::new(9);
    let clean: Vec<f64> = time.iter().map(|t| libm::sin(*t) + 1e-3 * noise.normal()).collect();
    let mut spiked = clean.clone();
    spiked[400] += 0.05;
    spiked[700] -= 0.05;
    let found = examine(&recording(vec![channel("x", "m", &time, spiked)]));
    assert_eq!(of(&found, Check::Spikes).expect("two").value, 2.0);
    let stepped = clean.iter().enumerate().map(|(i, v)| if i < 500 { *v } else { v + 0.5 }).collect();
    assert!(of(&examine(&recording(vec![channel("x", "m", &time, stepped)])), Check::Spikes).is_none());
}

#[test]
fn a_spectrum_that_goes_on_beyond_nyquist_is_called_aliased_and_a_floor_is_not() {
    let time = even(8000, 0.01);
    let mut noise = Noise::new(31);
    let mut state = 0.0;
    // First-order noise with its corner at a fifth of the Nyquist frequency: some 14 dB down at the
    // top.
    let coloured = (0..8000)
        .map(|_| {
            state = 0.6 * state + noise.normal();
            state
        })
        .collect();
    assert!(of(&examine(&recording(vec![channel("x", "m", &time, coloured)])), Check::Aliasing).is_some());
    let floor = time.iter().map(|t| libm::sin(3.0 * t) + 0.3 * noise.normal()).collect();
    assert!(of(&examine(&recording(vec![channel("x", "m", &time, floor)])), Check::Aliasing).is_none());
}

/// Tumbling about all axes: rate, and a field fixed in space seen from the body.
fn tumbling(n: usize, dt: f64) -> ([Vec<f64>; 3], [Vec<f64>; 3]) {
    let (mut omega, mut field): ([Vec<f64>; 3], [Vec<f64>; 3]) = Default::default();
    let mut v = [0.3, -0.5, 0.8];
    let rate = |t: f64| [0.5 * libm::sin(0.9 * t), 0.7 * libm::cos(0.6 * t + 1.0), 0.4 + 0.3 * libm::sin(1.3 * t)];
    let slope =
        |w: [f64; 3], v: [f64; 3]| [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]];
    for i in 0..n {
        let t = i as f64 * dt;
        for a in 0..3 {
            omega[a].push(rate(t)[a]);
            field[a].push(v[a]);
        }
        // Midpoint rule: error of order dt² per unit time, far below the axes' differences.
        let half: [f64; 3] = core::array::from_fn(|a| v[a] + 0.5 * dt * slope(rate(t), v)[a]);
        let s = slope(rate(t + 0.5 * dt), half);
        v = core::array::from_fn(|a| v[a] + dt * s[a]);
    }
    (omega, field)
}

#[test]
fn turned_and_mirrored_gyro_axes_are_named_and_right_ones_are_not() {
    let (omega, field) = tumbling(3000, 0.01);
    let time = even(3000, 0.01);
    let mut noise = Noise::new(41);
    let mut with = |source: [usize; 3], sign: [f64; 3]| {
        let mut channels = Vec::new();
        for a in 0..3 {
            let name = ["x", "y", "z"][a];
            let gyro = omega[source[a]].iter().map(|v| sign[a] * v + 1e-3 * noise.normal()).collect();
            channels.push(channel(&format!("rate_{name}"), "rad/s", &time, gyro));
            channels.push(channel(
                &format!("magnetic_field_{name}"),
                "T",
                &time,
                field[a].iter().map(|v| v + 1e-3 * noise.normal()).collect(),
            ));
        }
        examine(&recording(channels))
    };
    assert!(of(&with([0, 1, 2], [1.0; 3]), Check::Axes).is_none());
    let turned = with([1, 0, 2], [1.0, 1.0, -1.0]);
    assert!(
        of(&turned, Check::Axes).is_some_and(|f| f.evidence.contains("turned (x <- y, y <- x, z <- -z)")),
        "{turned:#?}"
    );
    let mirrored = with([0, 1, 2], [1.0, -1.0, 1.0]);
    assert!(of(&mirrored, Check::Axes).is_some_and(|f| f.evidence.contains("mirrored")), "{mirrored:#?}");
}

/// `y' = -y/2 + u + w`, measured with noise; u from the law given the last measured y.
fn loop_of(n: usize, seed: u64, law: impl Fn(f64, f64, &mut Noise) -> f64) -> (Vec<f64>, Vec<f64>) {
    let mut noise = Noise::new(seed);
    let (mut x, mut v, mut u, mut y) = (0.0, 0.0, Vec::new(), Vec::new());
    let mut previous = 0.0;
    for _ in 0..n {
        let measured = x + 1e-2 * noise.normal();
        let command = law(measured, (measured - previous) / 0.05, &mut noise);
        previous = measured;
        u.push(command);
        y.push(measured);
        v += 0.05 * (command - 0.3 * v + 0.5 * noise.normal());
        x += 0.05 * v;
    }
    (u, y)
}

#[test]
fn a_pd_law_is_called_feedback_and_an_open_loop_command_is_not() {
    let examine_loop = |u: Vec<f64>, y: Vec<f64>| {
        let time = even(u.len(), 0.05);
        examine(&recording(vec![
            Channel { role: Role::Input, ..channel("torque", "N*m", &time, u) },
            channel("angle", "rad", &time, y),
        ]))
    };
    let (u, y) = loop_of(3000, 51, |y, rate, _| -2.0 * y - 0.8 * rate);
    let found = examine_loop(u, y);
    assert!(of(&found, Check::Feedback).is_some_and(|f| f.value > 0.99), "{found:#?}");
    for seed in 0..40 {
        let (u, y) = loop_of(1200, seed, |_, _, noise| noise.normal());
        let silent = examine_loop(u, y);
        assert!(of(&silent, Check::Feedback).is_none(), "{silent:#?}");
    }
}

#[test]
fn one_sine_excites_with_order_two_and_noise_is_enough() {
    let time = even(2000, 0.05);
    let sine = Channel {
        role: Role::Input,
        ..channel("force", "N", &time, time.iter().map(|t| libm::sin(0.7 * t)).collect())
    };
    assert_eq!(of(&examine(&recording(vec![sine])), Check::Excitation).expect("order 2").value, 2.0);
}

#[test]
fn a_record_of_a_few_samples_is_not_called_sound_and_one_of_ten_is_long_enough() {
    for (n, few) in [(1, true), (2, true), (5, true), (9, true), (10, false)] {
        let time = even(n, 0.1);
        let found = examine(&recording(vec![
            channel("x", "m", &time, Noise::new(n as u64).series(n, 1.0)),
            Channel { role: Role::Input, ..channel("force", "N", &time, vec![1.0; n]) },
        ]));
        let told = of(&found, Check::FewSamples);
        assert_eq!(
            told.is_some_and(|f| f.severity == Severity::Warning && f.others.is_empty()),
            few,
            "{n}: {found:#?}"
        );
    }
}

#[test]
fn a_channel_that_never_changes_is_a_warning() {
    let time = even(200, 0.1);
    for (name, unit) in [("angle", "rad"), ("force", "N")] {
        let found =
            examine(&recording(vec![Channel { role: Role::Unknown, ..channel(name, unit, &time, vec![4.0; 200]) }]));
        assert!(of(&found, Check::Constant).is_some_and(|f| f.severity == Severity::Warning), "{found:#?}");
    }
}

#[test]
fn bad_records_never_panic() {
    for n in [0, 1, 2, 5, 9, 40] {
        let time = even(n, 0.1);
        let mut value: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let _ = examine(&recording(vec![
            channel("x", "m", &time, value.clone()),
            channel("v", "m/s", &time, vec![0.0; n]),
        ]));
        if n > 2 {
            value[1] = f64::NAN;
            let _ = examine(&recording(vec![channel("x", "m", &time, value)]));
        }
    }
    let _ = examine(&recording(Vec::new()));
    let _ = examine(&recording(vec![channel("x", "m", &vec![1.0; 100], vec![1.0; 100])]));
}

#[test]
fn a_channel_and_its_scaled_copy_are_called_copied_whichever_comes_first() {
    let time = even(3000, 0.02);
    let mut noise = Noise::new(17);
    let angle: Vec<f64> =
        time.iter().map(|t| libm::sin(2.0 * t) + 0.3 * libm::cos(9.1 * t) + 0.002 * noise.normal()).collect();
    let twice: Vec<f64> = angle.iter().map(|v| 2.0 * v).collect();
    for (first, second) in [(&angle, &twice), (&twice, &angle)] {
        let found = examine(&recording(vec![
            channel("one", "rad", &time, first.clone()),
            channel("two", "rad", &time, second.clone()),
        ]));
        let copied = of(&found, Check::Copied).expect("a copy");
        assert_eq!((copied.channel.as_str(), copied.others[0].as_str()), ("two", "one"));
        assert!(of(&found, Check::Derived).is_none(), "{found:#?}");
    }
}

#[test]
fn of_many_channels_each_is_compared_with_those_near_it_and_that_is_said() {
    let time = even(64, 0.01);
    let mut noise = Noise::new(3);
    let mut channels: Vec<Channel> =
        (0..300).map(|k| channel(&format!("q_{k}"), "V", &time, noise.series(64, 1.0))).collect();
    let twice = channels[7].value.iter().map(|value| 2.0 * value + 1.0).collect();
    channels.push(channel("far", "V", &time, twice));
    let findings = examine(&recording(channels));
    let copied = of(&findings, Check::Copied).expect("the copy of a channel far from it");
    assert_eq!((copied.channel.as_str(), copied.others[0].as_str()), ("far", "q_7"));
    let note = of(&findings, Check::Derived).expect("what was not compared");
    assert!(note.severity == Severity::Note && note.evidence.contains("301 channels are too many"), "{note:?}");
}

#[test]
fn progress_never_falls_and_ends_at_one() {
    let time = even(600, 0.02);
    let value = |f: f64| time.iter().map(|t| libm::sin(f * t)).collect::<Vec<f64>>();
    let channels = vec![channel("angle", "rad", &time, value(2.0)), channel("rate", "rad/s", &time, value(3.0))];
    let mut told = Vec::new();
    let with = super::examine_with(&recording(channels.clone()), &mut |share| told.push(share));
    assert_eq!(with, examine(&recording(channels)));
    assert!(told.windows(2).all(|w| w[1] >= w[0]) && told.last() == Some(&1.0), "{told:?}");
}

#[test]
fn a_p_value_has_two_digits_and_below_a_millionth_of_a_millionth_none() {
    let written = [0.0, 9.9e-13, 1.0e-12, 1.24e-8, 0.0124, 0.404, 1.0, f64::NAN].map(super::p_value);
    assert_eq!(written, ["< 1e-12", "< 1e-12", "1.0e-12", "1.2e-8", "0.012", "0.40", "1.0", "–"]);
    assert_eq!(super::probability(1e-40), "p < 1e-12");
    assert_eq!(super::probability(0.25), "p = 0.25");
}
