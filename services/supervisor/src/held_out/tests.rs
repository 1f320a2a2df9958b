//! Held-out simulation as laws: noise for a true model, more for a false one, nothing without data.

use super::*;
use crate::seeded_noise::SeededNoise;
use crate::specimen::closing;
use nalgebra::SVector;
use physics::momentum::{MomentumSample, predict_base_rate};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use telemetry::{ACCELEROMETERS_MAX, Domain, Estimate, Innovation, Sample, SloshEstimate};

const WINDOW: Window =
    Window { start_frame: 500, duration_frames: 6000, generation: 2, frame_period_s: 0.01, lead_frames: 0 };
const ALPHA: [f64; 8] = [110.7028, 105.7339, 48.1502, 44.0904, 44.0904, 18.9133, 18.9133, 39.6048];
const GYRO_RAD_S: f64 = 2.618e-4;

/// Noise of the gyro averaged over `interval_s`.
fn gyro_rad_s(interval_s: f64) -> f64 {
    GYRO_RAD_S * (0.01 / interval_s).sqrt()
}

fn estimate(domain: Domain, frame: u64, values: &[f64]) -> Estimate {
    let innovation = Innovation { generation: 2, ..closing(domain).innovation };
    let padded = core::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
    Estimate { frame, count: values.len() as u16, closing: 0, values: padded, innovation, ..closing(domain) }
}

/// Flies the whole window at 100 Hz with the arm of `ALPHA`; the estimate of frame 5000 says
/// `values`.
fn inertial(values: &[f64], capacity: usize, seed: u64) -> InertialHeldOut {
    let (mut noise, mut held_out) = (SeededNoise::new(seed), InertialHeldOut::new(capacity));
    held_out.begin(WINDOW);
    held_out.offer(&estimate(Domain::Inertial, 5000, values));
    for frame in 0..8000 {
        let t = frame as f64 * 0.01;
        let angle = [0.8 + 0.9 * libm::sin(0.21 * t), -1.2 + 0.8 * libm::cos(0.63 * t)];
        let rate = [0.9 * 0.21 * libm::cos(0.21 * t), -0.8 * 0.63 * libm::sin(0.63 * t)];
        let base = predict_base_rate(&SVector::from(ALPHA), 68.0, angle, rate).expect("positive inertia");
        let omega0_z_rad_s = base + GYRO_RAD_S * noise.normal();
        held_out.push(frame, 0.01, &MomentumSample { omega0_z_rad_s, joint_rate_rad_s: rate, joint_angle_rad: angle });
    }
    held_out
}

#[test]
fn a_true_inertial_model_leaves_the_noise_of_the_gyro() {
    for seed in 0..20 {
        let seen = inertial(&ALPHA, ROWS_MAX, seed).close(68.0, gyro_rad_s).expect("rows and a candidate");
        // Frames 5301 to 6499; the rms of 1199 normal numbers spreads by 2 %, five of that.
        assert_eq!(seen.count, 1199);
        assert!((seen.rms / seen.noise - 1.0).abs() < 0.1, "seed {seed}: {seen:?}");
        assert!(seen.signal_rms > 100.0 * seen.noise);
    }
}

#[test]
fn an_error_of_one_parameter_shows_in_the_held_out_error() {
    let mut wrong = ALPHA;
    wrong[7] *= 1.02;
    let (right, wrong) =
        (inertial(&ALPHA, ROWS_MAX, 1).close(68.0, gyro_rad_s), inertial(&wrong, ROWS_MAX, 1).close(68.0, gyro_rad_s));
    // 2 % of a8 moves the base rate by a few 1e-4 to 1e-3 rad/s.
    assert!(wrong.unwrap().rms > 2.0 * right.unwrap().rms, "{right:?} {wrong:?}");
}

#[test]
fn a_long_experiment_is_thinned_evenly_and_never_grows() {
    let held_out = inertial(&ALPHA, 100, 1);
    let frames: Vec<u64> = held_out.recorder.rows.iter().map(|row| row.0).collect();
    assert!(frames.len() <= 100 && frames.len() > 90, "{}", frames.len());
    assert!(frames.windows(2).all(|pair| pair[1] - pair[0] == 12), "1200 frames in 100 rows");
    assert_eq!(held_out.recorder.rows.capacity(), 100);
}

#[test]
fn only_the_newest_estimate_up_to_the_split_is_tested() {
    let mut recorder: Recorder<u8> = Recorder::new(10);
    recorder.begin(WINDOW);
    let mut offer = |frame, generation, status| {
        let mut offered = estimate(Domain::Inertial, frame, &ALPHA);
        (offered.innovation.generation, offered.status) = (generation, status);
        recorder.offer(&offered);
        recorder.candidate.map(|candidate| candidate.frame)
    };
    assert_eq!(offer(400, 2, 0), None, "before the experiment");
    assert_eq!(offer(900, 1, 0), None, "another experiment");
    assert_eq!(offer(900, 2, 7), None, "no estimate");
    assert_eq!(offer(1000, 2, 0), Some(1000));
    assert_eq!(offer(5300, 2, 0), Some(5300), "the split itself");
    assert_eq!(offer(5200, 2, 0), Some(5300), "late and older");
    assert_eq!(offer(5301, 2, 0), Some(5300), "has seen a held-out row");
}

#[test]
fn without_candidate_rows_or_positive_inertia_nothing_is_said() {
    let mut held_out = InertialHeldOut::new(100);
    assert_eq!(held_out.close(68.0, gyro_rad_s), None);
    held_out.begin(WINDOW);
    held_out.offer(&estimate(Domain::Inertial, 5000, &ALPHA));
    assert_eq!(held_out.close(68.0, gyro_rad_s), None);
    assert_eq!(inertial(&[-1.0; 8], 1000, 1).close(68.0, gyro_rad_s), None);
}

const BASE_MASS_KG: f64 = 1004.5;
const TANK: SloshParameters = SloshParameters { slosh_mass_kg: 28.7, stiffness_n_m: 0.16, damping_n_s_m: 0.03 };
const ACCELEROMETER_M_S2: f64 = 4.2e-4;

/// Made at the end of `frame`, where the slosh mass was in `state`.
fn slosh_estimate(frame: u64, values: &[f64], state: SloshState, accelerometer_bias_m_s2: f64) -> SloshEstimate {
    SloshEstimate {
        estimate: estimate(Domain::Slosh, frame, values),
        arc_end_s: (frame + 1) as f64 * 0.01,
        displacement_m: state.displacement_m,
        rate_m_s: state.velocity_m_s,
        accelerometer_bias_m_s2,
        ..SloshEstimate::zeroed_at(0)
    }
}

/// Burst and coast at 100 Hz; the estimate of `candidate_frame` says `values` and carries
/// the true slosh state after that frame. Force edges fall on multiples of 41.5 s.
fn slosh(values: [f64; 3], capacity: usize, candidate_frame: u64, lead_frames: u64, sigma: f64) -> SloshHeldOut {
    burst(values, capacity, candidate_frame, lead_frames, sigma, None)
}

/// The same with one accelerometer sample lost.
fn burst(
    values: [f64; 3],
    capacity: usize,
    candidate_frame: u64,
    lead_frames: u64,
    sigma: f64,
    lost: Option<u64>,
) -> SloshHeldOut {
    let window = Window { start_frame: 0, duration_frames: 60_000, generation: 2, frame_period_s: 0.01, lead_frames };
    let mut held_out = SloshHeldOut::new(capacity, BASE_MASS_KG, sigma * 0.1);
    held_out.begin(window);
    let (mut noise, mut truth) = (SeededNoise::new(4), SloshPropagator::new(TANK, BASE_MASS_KG, SloshState::default()));
    for frame in 0..60_000 {
        let force_n = if frame < 16_600 { 44.0 * (1.0 - 2.0 * ((frame / 4150) % 2) as f64) } else { 0.0 };
        let acceleration = truth.step(0.01, force_n) + sigma * noise.normal();
        let acceleration = if lost == Some(frame) { f64::NAN } else { acceleration };
        held_out.push(frame, frame as f64 * 0.01, 0.01, force_n, acceleration);
        if frame == candidate_frame {
            let state = truth.state();
            held_out.offer(&slosh_estimate(frame, &values, state, 0.0));
        }
    }
    held_out
}

const TRUE_TANK: [f64; 3] = [28.7, 0.16, 0.03];

#[test]
fn a_true_slosh_model_runs_free_to_rounding_whatever_is_merged() {
    for (capacity, candidate_frame) in [(4096, 47_990), (1000, 47_990), (333, 47_123), (4096, 48_000)] {
        let seen = slosh(TRUE_TANK, capacity, candidate_frame, 1000, 0.0).close().expect("covered");
        // Force zero behind the split: merging is exact. 12 000 steps of rounding on accelerations
        // of 1e-2.
        assert!(seen.rms < 1e-12, "{capacity} rows: {seen:?}");
        assert!(seen.signal_rms > 1e-3, "{seen:?}");
    }
}

#[test]
fn a_noisy_slosh_record_leaves_the_noise_of_the_merged_sums() {
    let seen = slosh(TRUE_TANK, 1300, 47_990, 1000, ACCELEROMETER_M_S2).close().expect("covered");
    // 13 000 frames in 1300 rows: ten samples a row. 1200 rows spread the rms by 2 %, five of that.
    assert!((seen.noise / (ACCELEROMETER_M_S2 / 10.0_f64.sqrt()) - 1.0).abs() < 1e-9, "{seen:?}");
    assert!((seen.rms / seen.noise - 1.0).abs() < 0.1, "{seen:?}");
}

#[test]
fn a_wrong_stiffness_runs_out_of_phase() {
    let seen = slosh([28.7, 0.168, 0.03], 1000, 47_990, 1000, 0.0).close().expect("covered");
    // 5 % of k is 2.5 % of the frequency: 0.22 rad after 120 s, and 5 % more amplitude.
    assert!(seen.rms > 0.05 * seen.signal_rms, "{seen:?}");
}

#[test]
fn a_slosh_record_with_a_gap_is_not_run() {
    for lost in [50_001, 50_130] {
        assert_eq!(burst(TRUE_TANK, 1300, 47_990, 1000, 0.0, Some(lost)).close(), None);
        assert_eq!(burst(TRUE_TANK, 4096, 47_990, 1000, 0.0, Some(lost)).close(), None);
    }
}

#[test]
fn a_slosh_estimate_older_than_the_rows_is_not_run() {
    assert_eq!(slosh(TRUE_TANK, 1000, 40_000, 1000, 0.0).close(), None);
    assert_eq!(slosh([-1.0, 0.16, 0.03], 1000, 47_990, 1000, 0.0).close(), None);
}

const MODES_HZ: [f64; 4] = [0.63, 0.0078, 2.4, 0.0052];
const ROW_SIGMA_M_S2: f64 = 3.1e-4;

/// Ten seconds of free decay at 200 Hz.
fn modal(values: &[f64], capacity: usize, seed: u64, lost: Option<u64>) -> ModalHeldOut {
    decay(1000, values, capacity, seed, lost)
}

/// Free decay of `duration_frames` at 200 Hz, three channels with a constant each; `lost` row is
/// NaN.
fn decay(duration_frames: u64, values: &[f64], capacity: usize, seed: u64, lost: Option<u64>) -> ModalHeldOut {
    let mut noise = SeededNoise::new(seed);
    let mut held_out = ModalHeldOut::new(capacity, 3, ROW_SIGMA_M_S2);
    let window = Window { start_frame: 0, duration_frames, generation: 2, frame_period_s: 0.01, lead_frames: 0 };
    held_out.begin(window, 0..3);
    held_out.offer(&estimate(Domain::Modal, duration_frames * 4 / 5, values));
    for row in 0..2 * duration_frames {
        let time_s = row as f64 * 0.005;
        let mut accelerations = [0.0; ACCELEROMETERS_MAX];
        for (channel, value) in accelerations[..3].iter_mut().enumerate() {
            *value = 0.01 * channel as f64 + ROW_SIGMA_M_S2 * noise.normal();
            for (k, mode) in MODES_HZ.chunks(2).enumerate() {
                let omega = 2.0 * core::f64::consts::PI * mode[0];
                let damped = omega * (1.0 - mode[1] * mode[1]).sqrt();
                let decay = libm::exp(-mode[1] * omega * time_s);
                *value += 0.05 * decay * libm::cos(damped * time_s + (channel * (k + 1)) as f64);
            }
        }
        if lost == Some(row) {
            accelerations[1] = f64::NAN;
        }
        held_out.push(row / 2, time_s, 0.005, &accelerations);
    }
    held_out
}

#[test]
fn true_poles_leave_the_noise_of_the_accelerometers() {
    for (seed, capacity) in [(1, 1000), (2, 1000), (3, 200)] {
        let held_out = modal(&MODES_HZ, capacity, seed, None);
        let seen = held_out.close().expect("two modes, even rows");
        // Frames 801 to 999, two rows each, thinned by two in the small memory; 600 values spread
        // by 3 %.
        assert_eq!(seen.count, if capacity == 1000 { 398 * 3 } else { 199 * 3 });
        assert!((seen.rms / ROW_SIGMA_M_S2 - 1.0).abs() < 0.15, "{seen:?}");
        assert!(seen.signal_rms > 50.0 * seen.noise, "{seen:?}");
        assert!(held_out.recorder.rows.iter().all(|row| row.0 > 800));
    }
}

#[test]
fn one_second_of_a_five_second_decay_is_enough_to_tell() {
    // The first mode turns 0.63 times in it; refitted, 3 % of both frequencies still leave twice
    // the noise.
    let (right, wrong) =
        (decay(500, &MODES_HZ, 1000, 1, None), decay(500, &[0.649, 0.0078, 2.472, 0.0052], 1000, 1, None));
    let (right, wrong) = (right.close().unwrap(), wrong.close().unwrap());
    assert!((right.rms / ROW_SIGMA_M_S2 - 1.0).abs() < 0.15, "{right:?}"); // 594 values spread by 3 %
    assert!(wrong.rms > 2.0 * wrong.noise, "{wrong:?}");
}

#[test]
fn a_frequency_off_by_one_per_cent_leaves_more_than_noise() {
    let seen = modal(&[0.63, 0.0078, 2.424, 0.0052], 1000, 1, None).close().unwrap();
    // 2 s at 0.024 Hz: 0.3 rad of phase from end to end, a tenth of the amplitude after the refit.
    assert!(seen.rms > 3.0 * seen.noise, "{seen:?}");
}

#[test]
fn a_record_with_a_gap_or_a_model_without_modes_is_not_refitted() {
    assert_eq!(modal(&MODES_HZ, 1000, 1, Some(1800)).close(), None);
    assert!(modal(&MODES_HZ, 1000, 1, Some(300)).close().is_some(), "a loss before the split is no loss");
    assert_eq!(modal(&[], 1000, 1, None).close(), None);
}

#[test]
fn any_number_of_modes_is_tested_and_a_missing_one_shows() {
    // Two true modes and a third that is not there: two more unknowns a channel, which the residual
    // is corrected for.
    let third = [&MODES_HZ[..], &[5.0, 0.01]].concat();
    let (three, one) = (modal(&third, 1000, 1, None).close(), modal(&MODES_HZ[..2], 1000, 1, None).close());
    let (three, one) = (three.expect("three modes"), one.expect("one mode"));
    assert!((three.rms / ROW_SIGMA_M_S2 - 1.0).abs() < 0.1, "{three:?}"); // 1194 values spread by 2 %
    assert!(one.rms > 20.0 * one.noise, "{one:?}"); // the second mode has decayed to 0.03 m/s²
}

#[test]
fn channels_that_are_not_used_are_not_tested() {
    let mut held_out = ModalHeldOut::new(1000, 2, ROW_SIGMA_M_S2);
    held_out.begin(Window { start_frame: 0, ..WINDOW }, [2, 0].into_iter());
    let mut row = [f64::NAN; ACCELEROMETERS_MAX];
    (row[0], row[2]) = (1.0, 3.0);
    held_out.push(5000, 50.0, 0.005, &row);
    assert_eq!(held_out.accelerations_m_s2, [3.0, 1.0]);
}

#[test]
fn whatever_the_rate_the_rows_are_spread_over_the_whole_of_what_is_held_out() {
    // 1200 frames of 10 ms are held out; samples at 1 kHz, 100 Hz and 1 Hz into 100 rows.
    for (per_frame, every_frames) in [(10, 1), (1, 1), (1, 100)] {
        let interval_s = 0.01 * every_frames as f64 / per_frame as f64;
        let mut held_out = InertialHeldOut::new(100);
        held_out.begin(WINDOW);
        for frame in (0..8000).step_by(every_frames) {
            for _ in 0..per_frame {
                held_out.push(frame, interval_s, &MomentumSample::default());
            }
        }
        let frames: Vec<u64> = held_out.recorder.rows.iter().map(|row| row.0).collect();
        assert!(frames.len() >= if every_frames == 1 { 90 } else { 11 }, "{interval_s} s: {frames:?}");
        let spacing = if every_frames == 1 { 12 } else { 100 };
        assert!(frames.windows(2).all(|pair| pair[1] - pair[0] == spacing), "{interval_s} s: {frames:?}");
        assert!(frames[frames.len() - 1] + spacing >= 6500, "{interval_s} s: {frames:?}");
    }
}

#[test]
fn a_bias_that_the_estimator_knows_is_no_error_of_the_slosh_model() {
    let biased = |known: f64| {
        let window = Window { start_frame: 0, lead_frames: 1000, ..WINDOW };
        let mut held_out = SloshHeldOut::new(1500, BASE_MASS_KG, 0.0);
        held_out.begin(window);
        let mut truth = SloshPropagator::new(TANK, BASE_MASS_KG, SloshState::default());
        for frame in 0..6000 {
            let force_n = 44.0 * libm::sin(0.5 * frame as f64 * 0.01);
            let measured = truth.step(0.01, force_n) + 2e-3;
            held_out.push(frame, frame as f64 * 0.01, 0.01, force_n, measured);
            if frame == 4799 {
                let state = truth.state();
                held_out.offer(&slosh_estimate(frame, &TRUE_TANK, state, known));
            }
        }
        held_out.close().expect("covered").rms
    };
    // The force is held within a sample and the sums are merged by two: errors of rounding and of
    // merging.
    assert!(biased(2e-3) < 1e-5, "{}", biased(2e-3));
    assert!((biased(0.0) / 2e-3 - 1.0).abs() < 1e-2, "{}", biased(0.0));
}

#[test]
fn a_restored_recorder_says_what_the_saved_one_would() {
    let held_out = slosh(TRUE_TANK, 333, 47_123, 1000, ACCELEROMETER_M_S2);
    let bytes = postcard::to_allocvec(&held_out).unwrap();
    let restored: SloshHeldOut = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(held_out, restored);
    assert_eq!(held_out.close(), restored.close());
}
