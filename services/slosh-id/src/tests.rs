//! Laws of the partition: late starts, gaps, restarts, operational thrust, and that it takes no
//! memory.

use super::*;
use physics::slosh::{SloshPropagator, SloshState};
use runtime::sys::{CountingAllocator, allocations};
use telemetry::{Estimate, Identifiability, PARAMETERS_MAX};
use zerocopy::IntoBytes;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

const TRUTH: SloshParameters = SloshParameters { slosh_mass_kg: 28.7, stiffness_n_m: 0.16, damping_n_s_m: 0.03 };
const BASE_MASS_KG: f64 = 1004.5;
const INTERVAL_S: f64 = 0.5;
const VRW_M_S_SQRT_H: f64 = 0.008;

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

/// A tank expected 20 % too heavy, 20 % too stiff, half as damped; sigmas that allow for it.
fn known(starts_at_rest: bool) -> SloshKnown {
    SloshKnown {
        m_0_kg: BASE_MASS_KG,
        axis: plant_file::scenario::Axis::X,
        accelerometer_vrw_m_s_sqrt_h: VRW_M_S_SQRT_H,
        interval_s: INTERVAL_S,
        expected: Some([34.4, 0.192, 0.015]),
        expected_sigma: Some([6.0, 0.03, 0.02]),
        starts_at_rest: Some(starts_at_rest),
    }
}

/// Two cycles of the burst, then coasting.
fn burst(t_s: f64) -> f64 {
    match t_s {
        t if t >= 166.0 => 0.0,
        t if t % 83.0 < 41.5 => 44.0,
        _ => -44.0,
    }
}

/// Station keeping: half a second of 22 N every 100 s, to and fro in turn.
fn station_keeping(t_s: f64) -> f64 {
    let pulse = (t_s / 100.0) as u64;
    let sign = if pulse.is_multiple_of(2) { 22.0 } else { -22.0 };
    if t_s - 100.0 * pulse as f64 >= INTERVAL_S { 0.0 } else { sign }
}

/// What sensor and thrusters say, sample by sample.
fn record(seconds: f64, force: fn(f64) -> f64, seed: u64) -> Vec<(Imu, Actuators)> {
    let mut motion = SloshPropagator::new(TRUTH, BASE_MASS_KG, SloshState::default());
    let sigma = VRW_M_S_SQRT_H / 60.0 / INTERVAL_S.sqrt();
    let sample = |k: u64| {
        let t_s = k as f64 * INTERVAL_S;
        let (mut imu, mut actuators) = (Imu::zeroed_at((t_s * 1e9) as u64), Actuators::zeroed_at((t_s * 1e9) as u64));
        (imu.interval_s, imu.valid) = (INTERVAL_S, 0b1000);
        actuators.force_b_n[0] = force(t_s);
        imu.acceleration_b_m_s2[0] = motion.step(INTERVAL_S, force(t_s)) + sigma * normal(1_000_000 * seed + k);
        (imu, actuators)
    };
    (0..(seconds / INTERVAL_S) as u64).map(sample).collect()
}

fn begun(known: SloshKnown) -> SloshId {
    let mut partition = SloshId::new(Some(known), true);
    partition.begin(0);
    partition
}

fn feed(partition: &mut SloshId, samples: &[(Imu, Actuators)]) {
    for (imu, actuators) in samples {
        partition.take(&[*imu], &[*actuators]);
    }
}

/// Largest error of mass, stiffness, damping in their stated standard deviations.
fn worst_z(estimate: &Estimate) -> f64 {
    let truth = [TRUTH.slosh_mass_kg, TRUTH.stiffness_n_m, TRUTH.damping_n_s_m];
    let z = |i: usize| ((estimate.values[i] - truth[i]) / estimate.covariance[i][i].sqrt()).abs();
    (0..PARAMETERS).map(z).fold(0.0, f64::max)
}

fn identifiability(estimate: &Estimate) -> [Identifiability; 3] {
    [0, 1, 2].map(|i| Identifiability::from_code(estimate.identifiability[i]).expect("a known code"))
}

#[test]
fn a_burst_identifies_all_three_whatever_the_prior_and_the_innovation_is_that_of_the_sensor() {
    let samples = record(600.0, burst, 1);
    let mut partition = begun(known(true));
    let (mut squares, mut variances, mut count) = (0.0, 0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        feed(&mut partition, &[*sample]);
        if k >= 400 && k % 4 == 0 {
            let said = partition.estimate(0, 0, false).estimate.innovation;
            assert!(said.variance > 0.0 || k == 400, "only the first estimate has none before it");
            if k == 400 {
                continue;
            }
            squares += said.innovation * said.innovation / said.variance;
            (variances, count) = (variances + said.variance, count + 1.0);
        }
    }
    let estimate = partition.estimate(0, 0, true).estimate;
    assert_eq!((estimate.status, identifiability(&estimate)), (0, [Identifiability::Identified; 3]));
    assert!(worst_z(&estimate) < 3.5, "{:?}", estimate.values);
    // 200 unit normal squares: their mean spreads by 0.1; a fitted parameter widens little after
    // 200 s.
    assert!((squares / count - 1.0_f64).abs() < 0.4, "{}", squares / count);
    assert!(variances / count > 1.0 && variances / count < 1.2, "{}", variances / count);
}

#[test]
fn a_late_start_leaves_the_state_unknown_and_the_answer_honest() {
    let samples = record(900.0, burst, 2);
    let from = 120; // 60 s of thrust not seen
    let mut honest = begun(known(true));
    feed(&mut honest, &samples[from..]);
    let estimate = honest.estimate(0, 0, true).estimate;
    assert!(estimate.status == 0 && worst_z(&estimate) < 3.5, "{:?}", estimate.values);
    // Red where the rest is believed that is not there.
    let mut fooled = begun(known(true));
    fooled.state.begin_ns = samples[from].0.header.t_meas_ns;
    feed(&mut fooled, &samples[from..]);
    let estimate = fooled.estimate(0, 0, true).estimate;
    assert!(estimate.status != 0 || worst_z(&estimate) > 10.0, "{:?}", estimate.values);
}

#[test]
fn a_gap_under_thrust_is_survived() {
    let samples = record(900.0, burst, 3);
    let mut partition = begun(known(true));
    feed(&mut partition, &samples[..140]);
    feed(&mut partition, &samples[220..]); // 40 s of thrust not seen
    let estimate = partition.estimate(0, 0, true).estimate;
    assert!(estimate.status == 0 && worst_z(&estimate) < 3.5, "{:?}", estimate.values);
}

#[test]
fn killed_anywhere_and_restarted_says_the_same_bytes() {
    let samples = record(300.0, burst, 4);
    let said = |killed_at: Option<usize>| {
        let (mut partition, mut all) = (begun(known(true)), Vec::new());
        for (k, sample) in samples.iter().enumerate() {
            if killed_at == Some(k) {
                let mut state = Vec::new();
                partition.save(&mut state).unwrap();
                partition = SloshId::new(Some(known(true)), true);
                partition.restore(&state).unwrap();
            }
            feed(&mut partition, &[*sample]);
            if k % 100 == 99 {
                all.extend_from_slice(partition.estimate(k as u64, 0, false).as_bytes());
            }
        }
        all
    };
    let undisturbed = said(None);
    for killed_at in [1, 99, 100, 250, 599] {
        assert!(said(Some(killed_at)) == undisturbed, "killed at {killed_at}");
    }
}

#[test]
fn station_keeping_identifies_what_it_excites_and_keeps_the_prior_of_the_rest() {
    let (mut honest, mut identified, mut kept) = (0, 0, 0);
    for seed in 0..10 {
        let mut partition = begun(known(true));
        feed(&mut partition, &record(4000.0, station_keeping, 10 + seed));
        let estimate = partition.estimate(0, 0, true).estimate;
        assert_eq!(estimate.status, 0);
        honest += u32::from(worst_z(&estimate) < 3.0);
        identified += u32::from(identifiability(&estimate).contains(&Identifiability::Identified));
        kept += u32::from(identifiability(&estimate).contains(&Identifiability::PriorKept));
    }
    // Three numbers of ten records within three sigma: 99.7 % each.
    assert!(honest >= 9, "{honest}");
    assert!(identified + kept >= 10, "{identified} {kept}");
}

#[test]
fn without_excitation_the_prior_is_the_answer_and_nothing_was_excited() {
    for starts_at_rest in [true, false] {
        let mut partition = begun(known(starts_at_rest));
        feed(&mut partition, &record(2000.0, |_| 0.0, 5));
        let estimate = partition.estimate(0, 0, true).estimate;
        assert_eq!((estimate.status, identifiability(&estimate)), (0, [Identifiability::NotExcited; 3]));
        assert_eq!(estimate.values[..3], known(true).expected.unwrap());
        assert_eq!(estimate.covariance[0][0], 36.0);
    }
}

#[test]
fn without_a_prior_a_craft_that_is_not_pushed_shows_no_slosh() {
    let mut partition = begun(SloshKnown { expected_sigma: None, ..known(true) });
    feed(&mut partition, &record(600.0, |_| 0.0, 6));
    let said = partition.estimate(0, 0, true);
    assert_eq!(said.estimate.status, u32::from(SloshStatus::NoSloshFound.code()));
    assert!(said.slosh_gain < said.slosh_gain_needed, "{} of {}", said.slosh_gain, said.slosh_gain_needed);
    assert_eq!(said.estimate.identifiability, [Identifiability::NoPrior.code(); PARAMETERS_MAX]);
}

#[test]
fn no_sample_estimate_or_new_experiment_takes_memory() {
    let samples = record(1500.0, burst, 7); // more than the arc holds at once
    let mut partition = begun(known(true));
    let before = allocations();
    for _ in 0..2 {
        partition.begin(0);
        for (k, sample) in samples.iter().enumerate() {
            feed(&mut partition, core::slice::from_ref(sample));
            if k % 500 == 499 {
                std::hint::black_box(partition.estimate(0, 0, false));
            }
        }
    }
    assert_eq!(allocations() - before, 0);
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert!(allocations() > before, "the counter counts");
}
