//! Laws of the partition: which rows count, which are tested, and what it says when it has no
//! estimate.

use super::*;
use plant_file::scenario::AppendageKnown;
use telemetry::IdentifiedMode;

#[global_allocator]
static ALLOCATOR: runtime::sys::CountingAllocator = runtime::sys::CountingAllocator;

const SIGMA_M_S2: f64 = 3.1e-4;
const CHANNELS: usize = 3;

/// Unit normal: SplitMix64 and twelve uniforms.
fn normal(seed: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = (12 * seed + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53)
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

/// A pulse of a second, then the free decay of `modes` (frequency, damping, growth of damping with
/// amplitude).
struct Case {
    rate_hz: f64,
    seconds: f64,
    modes: Vec<(f64, f64)>,
    /// Of the damping, per m/s² of amplitude.
    growth: f64,
    /// Noise of the measured torque.
    torque_sigma_nm: f64,
    /// 1 throughout, as a vehicle may say, or only during the pulse.
    excited: fn(f64) -> bool,
}

impl Case {
    fn new(modes: usize) -> Self {
        let all = [1.5611, 6.4844, 17.67, 25.0, 40.0, 60.0];
        Case {
            rate_hz: 200.0,
            seconds: 6.0,
            modes: all[..modes].iter().map(|f| (*f, 0.008)).collect(),
            growth: 0.0,
            torque_sigma_nm: 0.0,
            excited: |t_s| t_s < 1.0,
        }
    }

    fn run(&self, known: ModalKnown) -> ModalId {
        let mut partition = ModalId { state: State::default(), known, replays: true, due: None };
        let mut amplitude = vec![0.2; self.modes.len()];
        for n in 0..(self.seconds * self.rate_hz) as u64 {
            let t_s = n as f64 / self.rate_hz;
            let mut command = Actuators::zeroed_at((t_s * 1e9) as u64);
            command.torque_b_nm[2] = f64::from(t_s < 1.0) * 2.0 + self.torque_sigma_nm * normal(1_000_000 + n);
            (command.excited, command.interval_s) = (u64::from((self.excited)(t_s)), 1.0 / self.rate_hz);
            partition.take_commands(&[command]);
            let mut batch = Accelerometers::zeroed_at((t_s * 1e9).round() as u64);
            (batch.count, batch.channels, batch.interval_ns) = (1, CHANNELS as u32, (1e9 / self.rate_hz) as u64);
            for (channel, value) in batch.acceleration_m_s2[0].iter_mut().enumerate().take(CHANNELS) {
                *value = SIGMA_M_S2 * normal(n * CHANNELS as u64 + channel as u64);
                for (k, (mode, amplitude)) in self.modes.iter().zip(&amplitude).enumerate() {
                    let phase = 2.0 * core::f64::consts::PI * mode.0 * (t_s - 1.0);
                    let shape = f64::sin(1.1 * ((k + 1) * (channel + 1)) as f64 + 0.3 * k as f64);
                    *value += f64::from(t_s >= 1.0) * shape * amplitude * phase.cos();
                }
            }
            partition.take_batch(&batch);
            for (mode, amplitude) in self.modes.iter().zip(&mut amplitude).filter(|_| t_s >= 1.0) {
                let damping = mode.1 + self.growth * *amplitude;
                *amplitude *= (-damping * 2.0 * core::f64::consts::PI * mode.0 / self.rate_hz).exp();
            }
        }
        partition
    }

    fn estimate(&self) -> Estimate {
        self.sample().estimate
    }

    fn sample(&self) -> ModalEstimate {
        self.run(known(&[])).estimate(0, true)
    }
}

fn known(channels: &[usize]) -> ModalKnown {
    ModalKnown { accelerometer_sigma_m_s2: SIGMA_M_S2, channels: channels.to_vec(), ..ModalKnown::default() }
}

/// Distance of the mean NIS from one, in its standard deviations.
fn nis_z(estimate: &Estimate) -> f64 {
    (estimate.nis_mean - 1.0) * (0.5 * estimate.nis_count).sqrt()
}

#[test]
fn a_decay_of_one_to_six_modes_is_found_and_its_innovations_are_the_sensor_noise() {
    for modes in 1..=6 {
        for rate_hz in [200.0, 1000.0] {
            let case = Case { rate_hz, ..Case::new(modes) };
            let estimate = case.estimate();
            assert_eq!((estimate.status, usize::from(estimate.count)), (0, 2 * modes), "{modes} modes, {rate_hz} Hz");
            assert!(nis_z(&estimate).abs() < 4.5, "{modes} modes, {rate_hz} Hz: {}", nis_z(&estimate));
            let innovation = estimate.innovation;
            assert_eq!((innovation.accepted, innovation.gate), (1, 5.0));
            assert_eq!(innovation.variance, SIGMA_M_S2 * SIGMA_M_S2);
            // The rows tested reach to the end of the segment.
            assert!(innovation.t_ns as f64 > 5.9e9, "{}", innovation.t_ns);
        }
    }
}

#[test]
fn a_measured_torque_that_is_never_zero_leaves_the_decay_free_and_an_announced_silence_is_none() {
    let noisy = Case { torque_sigma_nm: 1e-3, ..Case::new(2) }.estimate();
    let silent = Case { excited: |_| true, ..Case::new(2) }.estimate();
    let exact = Case::new(2).estimate();
    assert_eq!((exact.status, exact.count), (0, 4));
    assert_eq!((noisy.values, noisy.nis_mean), (exact.values, exact.nis_mean));
    assert_eq!((silent.values, silent.nis_mean), (exact.values, exact.nis_mean));
}

#[test]
fn damping_that_depends_on_amplitude_is_seen_however_long_the_record() {
    for seconds in [6.0, 60.0] {
        let estimate = Case { seconds, growth: 0.02, ..Case::new(1) }.estimate();
        assert!(estimate.status == 0 && nis_z(&estimate) > 10.0, "{seconds} s: {}", nis_z(&estimate));
        let linear = Case { seconds, ..Case::new(1) }.estimate();
        assert!(nis_z(&linear).abs() < 4.5, "{seconds} s: {}", nis_z(&linear));
    }
}

#[test]
fn a_record_without_an_answer_says_why() {
    let status = |case: &Case, channels: &[usize]| {
        let estimate = case.run(known(channels)).estimate(0, true);
        (estimate.estimate.status, estimate.record_samples, estimate.record_samples_needed)
    };
    assert_eq!(status(&Case { seconds: 0.0, ..Case::new(1) }, &[]).0, 1);
    assert_eq!(status(&Case::new(1), &[9]).0, 1);
    let (short, samples, need) = status(&Case { seconds: 1.1, ..Case::new(1) }, &[]);
    assert!(short == 2 && samples == 20 && need > 100, "{short} {samples} {need}");
    let rest = Case { modes: Vec::new(), ..Case::new(1) };
    assert_eq!(status(&rest, &[]).0, 3);
    assert_eq!(status(&Case { excited: |_| true, torque_sigma_nm: 1e-3, ..Case::new(1) }, &[]).0, 6);
    let mut flat = ModalId { state: State::default(), known: known(&[]), replays: true, due: None };
    for n in 0..400 {
        let mut batch = Accelerometers::zeroed_at(n * 5_000_000);
        (batch.count, batch.channels, batch.interval_ns) = (1, 2, 5_000_000);
        flat.take_batch(&batch);
    }
    assert_eq!(flat.estimate(0, true).estimate.status, 4);
}

#[test]
fn the_dominant_channel_is_numbered_as_in_the_file_and_covariances_are_possible() {
    let all = Case::new(1).run(known(&[])).estimate(0, true).modes[0].dominant_channel;
    let alone = Case::new(1).run(known(&[3])).estimate(0, true);
    assert_eq!(alone.modes[0].dominant_channel, 3);
    assert!((1..=3).contains(&all));
    let covariance = Case::new(2).estimate().covariance;
    for i in 0..4 {
        for j in 0..4 {
            assert_eq!(covariance[i][j], covariance[j][i]);
            assert!(i == j || covariance[i][j] * covariance[i][j] < covariance[i][i] * covariance[j][j]);
        }
    }
}

/// What is said of the modes found.
fn named(sample: &ModalEstimate) -> &[IdentifiedMode] {
    &sample.modes[..usize::from(sample.estimate.count) / 2]
}

/// Identities of modes of which nothing else is said.
fn identities(sample: &ModalEstimate) -> Vec<u32> {
    for mode in named(sample) {
        assert_eq!(notes(mode), [0; 4], "{mode:?}");
    }
    named(sample).iter().map(|mode| mode.identity).collect()
}

/// Pulse nulled, record short, close modes, input leaks.
fn notes(mode: &IdentifiedMode) -> [u16; 4] {
    [mode.pulse_nulled, mode.record_short, mode.close_modes, mode.input_leaks]
}

#[test]
fn modes_keep_their_numbers_from_answer_to_answer_over_a_restart_and_in_the_next_experiment() {
    let mut partition = Case { seconds: 4.0, ..Case::new(2) }.run(known(&[]));
    for _ in 0..2 {
        assert_eq!(identities(&partition.estimate(0, false)), [1, 2]);
    }
    let mut bytes = Vec::new();
    partition.save(&mut bytes).unwrap();
    let mut restored = ModalId { state: State::default(), known: known(&[]), replays: true, due: None };
    restored.restore(&bytes).unwrap();
    assert_eq!(identities(&restored.estimate(0, false)), [1, 2]);
    // Another record of the same structure shows one mode more, a third without the first.
    let mut next = |modes: Vec<(f64, f64)>, skip: usize| {
        let mut next = Case { modes, ..Case::new(2) }.run(known(&[]));
        next.state.tracker = restored.state.tracker.take();
        let numbers: Vec<u32> = named(&next.estimate(0, true)).iter().map(|mode| mode.identity).collect();
        restored.state.tracker = next.state.tracker.take();
        numbers[skip..].to_vec()
    };
    assert_eq!(next(vec![(1.5611, 0.008), (6.4844, 0.008), (17.67, 0.008)], 0), [1, 2, 3]);
    assert_eq!(next(vec![(1.5611, 0.008)], 0), [1]);
    assert_eq!(next(vec![(1.5611, 0.008), (6.4844, 0.008), (17.67, 0.008)], 1), [2, 3]);
}

#[test]
fn what_to_beware_of_stands_beside_the_mode_it_is_about() {
    let said = |case: &Case| named(&case.sample()).iter().map(notes).collect::<Vec<_>>();
    let (nothing, [pulse_nulled, close, leaks]) = ([0; 4], [[1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
    // One second of torque and a mode at 1.02 Hz: 6 % of the largest decay are left.
    assert_eq!(said(&Case { modes: vec![(1.02, 0.008), (6.4844, 0.008)], ..Case::new(2) }), [pulse_nulled, nothing]);
    assert_eq!(said(&Case { growth: 0.02, ..Case::new(1) }), [leaks]);
    assert_eq!(said(&Case { modes: vec![(4.5, 0.02), (4.8, 0.02)], seconds: 12.0, ..Case::new(2) }), [close; 2]);
    // An alternating torque is no pulse.
    let mut pulse = Pulse::default();
    for n in 0..100 {
        let mut command = Actuators::zeroed_at(0);
        (command.interval_s, command.torque_b_nm[2]) = (0.01, if n % 2 == 0 { 1.0 } else { -0.5 });
        pulse.excited(&command);
    }
    assert_eq!(pulse.length_s(), None);
}

#[test]
fn rows_of_a_decay_take_no_memory_after_the_first() {
    let mut partition = Case { seconds: 1.5, ..Case::new(2) }.run(known(&[]));
    let mut batch = Accelerometers::zeroed_at(0);
    (batch.count, batch.channels, batch.interval_ns) = (1, CHANNELS as u32, 5_000_000);
    let before = runtime::sys::allocations();
    let mut t_ns = 1_500_000_000;
    for n in 0..20_000 {
        batch.header.t_meas_ns = t_ns;
        batch.acceleration_m_s2[0][..CHANNELS].copy_from_slice(&[normal(n), 0.0, 1.0]);
        // One list of channels a batch.
        partition.take_batch(&batch);
        t_ns += 5_000_000;
    }
    assert_eq!(runtime::sys::allocations() - before, 0);
}

#[test]
fn rows_before_and_behind_a_blow_and_a_gap_take_no_memory_after_the_first() {
    let mut partition = ModalId { state: State::default(), known: known(&[]), replays: true, due: None };
    let mut batch = Accelerometers::zeroed_at(0);
    (batch.count, batch.channels, batch.interval_ns) = (1, CHANNELS as u32, 5_000_000);
    let (mut before, mut t_ns) = (0, 0);
    for n in 0..6000 {
        // Three blows of a slow mode out of a rest, and gaps between.
        let since = (n % 2000) as f64 - 800.0;
        let decay = if since < 0.0 { 0.0 } else { (-0.003 * since).exp() * (0.2 * since).cos() };
        let rows = [decay, 0.5 * decay, -decay].map(|y| y + SIGMA_M_S2 * normal(n));
        batch.header.t_meas_ns = t_ns;
        batch.acceleration_m_s2[0][..CHANNELS].copy_from_slice(&rows);
        partition.take_batch(&batch);
        t_ns += if n % 2000 == 1999 { 500_000_000 } else { 5_000_000 };
        if n == 0 {
            before = runtime::sys::allocations();
        }
    }
    assert_eq!(runtime::sys::allocations() - before, 0);
}

#[test]
fn told_of_the_appendage_it_gives_the_inertia_that_the_modes_imply_and_at_most_five_modes() {
    let told = |case: &Case| {
        let appendage = Some(AppendageKnown {
            // The benchmark's, 3 % off.
            inertia_kg_m2: 183.0,
            inertia_relative_sd: 0.05,
            coupling_sqrt_kg_m: [10.231_943_38, 2.121_261_81],
            coupling_relative_sd: 0.0,
            locked: [[1.001_027_19, 0.005], [6.273_330_30, 0.008]],
            arm_angle_rad: None,
        });
        case.run(ModalKnown { appendage, ..known(&[]) }).estimate(0, true)
    };
    let given = |sample: &ModalEstimate| (sample.hub_inertia_kg_m2, sample.hub_inertia_sigma_kg_m2);
    for modes in [2, 3, 6] {
        let sample = told(&Case::new(modes));
        let found = usize::from(sample.estimate.count);
        assert_eq!((sample.estimate.status, found), (0, 2 * modes.min(MODES_WITH_INERTIA)));
        let (inertia, sigma) = given(&sample);
        // Of 1.5611 and 6.4844 Hz instead of 1.56109992 and 6.48442584: 177.50 within a thousandth
        // of a sigma.
        assert!(sigma > 0.0 && sigma < 1.0 && (inertia - 177.50).abs() < 4.0 * sigma, "{modes}: {inertia} ± {sigma}");
    }
    assert_eq!(
        given(&told(&Case { modes: vec![(1.5611, 0.008)], ..Case::new(1) })),
        (0.0, 0.0),
        "one mode says nothing"
    );
    assert_eq!(given(&Case::new(2).sample()), (0.0, 0.0), "nor does a geometry that is not known");
}
