//! Fourier trajectories of the two joints with the least bound, beside trajectory B under the same
//! limits.
//!
//! One period as long as the record, a dozen harmonics: what trajectory B does with five of half
//! the length. Quasi-Newton descents from trajectory B and from random motions, each first within
//! limits drawn in by a few per cent, then checked on a grid of a sample each and drawn in further
//! until every limit holds there. Every draw is a function of the seed. The result is a plant file
//! that the simulator takes, the built-in arm with the new references.

mod verify;
mod words;

use super::minimise::minimise;
use crate::experiment_design::{ArmLimits, Assessment, Design, Tank};
use crate::inertial::{Inertial, planar_arm, sigma, truth};
use dynamics::noise::Stream;
use physics::excitation::{FourierJoint, FourierTrajectory};
use serde::Deserialize;
use std::sync::atomic::{AtomicUsize, Ordering};
pub use verify::{Verified, verify};
pub use words::{plant_text, table};

/// Of a trajectory that is designed; its period is the record.
const HARMONICS: usize = 12;
/// Numbers of a trajectory: an offset and two amplitudes per harmonic of each joint.
const NUMBERS: usize = 2 * (1 + 2 * HARMONICS);
/// Random starts: sigma of a rate's amplitude [rad/s], falling with the root of the harmonic, and
/// of the offsets [rad].
const START_RATE: f64 = 0.12;
const START_OFFSET: f64 = 1.2;
/// Limits are drawn in by so much in a descent, then more, until the fine grid is content.
const MARGINS: [f64; 5] = [0.01, 0.02, 0.03, 0.05, 0.08];
/// A descent has settled when a step gains this share of the bound.
const DESCENT_SETTLED: f64 = 1e-6;

/// A motion that was designed.
pub type Designed = FourierTrajectory<HARMONICS>;

/// What hardware allows; defaults are what trajectory B itself reaches, rounded up.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HardwareLimits {
    pub joint_angle_max_rad: f64,
    pub joint_rate_max_rad_s: f64,
    pub base_rate_max_rad_s: f64,
    pub torque_max_n_m: f64,
    pub slosh: Option<TankLimits>,
}

/// Propellant in the base; from the base's centre of mass.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TankLimits {
    pub stroke_max_m: f64,
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub position_m: [f64; 2],
}

impl Default for HardwareLimits {
    fn default() -> Self {
        Self {
            joint_angle_max_rad: 2.64,
            joint_rate_max_rad_s: 0.355,
            base_rate_max_rad_s: 0.405,
            torque_max_n_m: 20.0,
            slosh: None,
        }
    }
}

/// For the benchmark's arm and sensors.
pub fn design(bench: &Inertial<8, 9>, said: &HardwareLimits) -> Design {
    let tank = said.slosh.map(|slosh| Tank {
        arm: planar_arm(&bench.plant),
        position_m: slosh.position_m,
        frequency_hz: slosh.frequency_hz,
        damping_ratio: slosh.damping_ratio,
    });
    Design {
        alpha: truth(&bench.plant),
        h_nms: bench.settings.h_nms,
        sigma: sigma(&bench.plant),
        rate_hz: 1.0 / bench.plant.simulation.period_s,
        duration_s: bench.plant.simulation.duration_s,
        limits: ArmLimits {
            joint_angle_rad: said.joint_angle_max_rad,
            joint_rate_rad_s: said.joint_rate_max_rad_s,
            base_rate_rad_s: said.base_rate_max_rad_s,
            torque_n_m: said.torque_max_n_m,
            slosh_stroke_m: said.slosh.map_or(f64::INFINITY, |slosh| slosh.stroke_max_m),
        },
        tank,
    }
}

/// Instants of a grid as fine as the samples.
pub fn instants(period_s: f64, rate_hz: f64) -> usize {
    (period_s * rate_hz).round().max(1.0) as usize
}

/// The best of all descents; on all cores, the same on any number of them.
pub fn search(
    design: &Design,
    b: &FourierTrajectory,
    starts: usize,
    iterations: usize,
    seed: u64,
) -> Option<(Designed, Assessment)> {
    let stream = Stream::new(seed, "design.bp1a");
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= starts {
                return done;
            }
            let start =
                if index == 0 { repeated(b, design.duration_s) } else { random(&stream, index, design.duration_s) };
            done.extend(descend(design, &start, iterations).map(|found| (index, found)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get).min(starts);
    let mut all: Vec<(usize, (Designed, Assessment))> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a worker only computes")).collect()
    });
    all.sort_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, found)| found).min_by(|a, b| a.1.relative_rms().total_cmp(&b.1.relative_rms()))
}

/// Least bound near `start` that keeps every limit at every sample; `None`: no margin was enough.
fn descend(design: &Design, start: &Designed, iterations: usize) -> Option<(Designed, Assessment)> {
    let mut numbers = numbers(start);
    for (k, margin) in MARGINS.into_iter().enumerate() {
        let inside = design.tightened(1.0 - margin);
        let value =
            |numbers: &[f64]| inside.assess(&trajectory(numbers, design.duration_s)).map(|found| inside.cost(&found));
        // later descents only mend what is left
        let steps = if k == 0 { iterations } else { iterations.div_ceil(4) };
        (numbers, _) = minimise(numbers, steps, DESCENT_SETTLED, &value)?;
        let found = trajectory(&numbers, design.duration_s);
        let checked = design.assess_at(&found, instants(found.period_s, design.rate_hz))?;
        if design.violations(&checked).iter().all(|over| *over == 0.0) {
            return Some((found, checked));
        }
    }
    None
}

/// Offset, then cosine and sine amplitudes, joint by joint; offsets in units of the period's first
/// angle.
fn numbers(of: &Designed) -> Vec<f64> {
    let joint = |joint: &FourierJoint<HARMONICS>| {
        let first = joint.offset_rad * OFFSET_UNIT;
        core::iter::once(first).chain(joint.cosine_rate_rad_s).chain(joint.sine_rate_rad_s).collect::<Vec<_>>()
    };
    of.joints.iter().flat_map(joint).collect()
}

/// Offsets in a descent count in tens of rad: so they weigh like amplitudes in rad/s.
const OFFSET_UNIT: f64 = 0.1;

fn trajectory(numbers: &[f64], period_s: f64) -> Designed {
    assert_eq!(numbers.len(), NUMBERS);
    let joint = |joint: usize| {
        let own = &numbers[joint * NUMBERS / 2..];
        FourierJoint {
            offset_rad: own[0] / OFFSET_UNIT,
            cosine_rate_rad_s: core::array::from_fn(|k| own[1 + k]),
            sine_rate_rad_s: core::array::from_fn(|k| own[1 + HARMONICS + k]),
        }
    };
    FourierTrajectory { period_s, joints: [joint(0), joint(1)] }
}

/// A trajectory of a shorter period that divides `period_s`, as one of that period.
fn repeated(of: &FourierTrajectory, period_s: f64) -> Designed {
    let times = (period_s / of.period_s).round().max(1.0) as usize;
    let spread = |amplitudes: &[f64]| {
        core::array::from_fn(|k| {
            if (k + 1).is_multiple_of(times) {
                amplitudes.get((k + 1) / times - 1).copied().unwrap_or(0.0)
            } else {
                0.0
            }
        })
    };
    let joints = of.joints.map(|joint| FourierJoint {
        offset_rad: joint.offset_rad,
        cosine_rate_rad_s: spread(&joint.cosine_rate_rad_s),
        sine_rate_rad_s: spread(&joint.sine_rate_rad_s),
    });
    FourierTrajectory { period_s, joints }
}

fn random(stream: &Stream, index: usize, period_s: f64) -> Designed {
    let numbers: Vec<f64> = (0..NUMBERS)
        .map(|i| {
            let draw = stream.normal((index * NUMBERS + i) as u64);
            match i % (NUMBERS / 2) {
                0 => START_OFFSET * OFFSET_UNIT * draw,
                k => START_RATE * draw / (((k - 1) % HARMONICS + 1) as f64).sqrt(),
            }
        })
        .collect();
    trajectory(&numbers, period_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertial::commanded;

    #[test]
    fn a_short_search_already_beats_trajectory_b_within_its_limits_and_its_records_are_as_good_as_promised() {
        let bench = Inertial::bp1a();
        let (design, b) = (design(&bench, &HardwareLimits::default()), commanded(&bench.plant));
        let (motion, found) = search(&design, &b, 2, 60, 1).expect("within the limits");
        assert_eq!(design.violations(&found), [0.0; crate::experiment_design::LIMITS]);
        let flown = verify::verify(&design, &motion, &found, 60, 1).expect("exciting");
        let ratio = flown.report.geomean_rmse_over_crlb.expect("every record has an answer");
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}"); // 60 records spread it by 0.03
        for (peak, limit) in flown.peaks.values().into_iter().zip(design.limits.values()) {
            // the controllers follow the motion to a few mrad, and their torques carry what that
            // needs
            assert!(peak < 1.02 * limit, "{peak} of {limit}");
        }
        let reference = design.assess_at(&b, 3000).expect("exciting").relative_rms();
        assert!(found.relative_rms() < 0.9 * reference, "{} {reference}", found.relative_rms());
    }

    #[test]
    fn a_tank_that_must_not_be_shaken_is_not_shaken() {
        let slosh = TankLimits { stroke_max_m: 0.007, frequency_hz: 0.5, damping_ratio: 0.02, position_m: [-0.4, 0.1] };
        let bench = Inertial::bp1a();
        let b = repeated(&commanded(&bench.plant), 60.0);
        let design = design(&bench, &HardwareLimits { slosh: Some(slosh), ..HardwareLimits::default() });
        let before = design.assess_at(&b, 6000).expect("exciting");
        assert!(before.peaks.slosh_stroke_m > 0.008, "trajectory B shakes it: {}", before.peaks.slosh_stroke_m);
        let (motion, found) = descend(&design, &b, 40).expect("within the limits");
        assert_eq!(design.violations(&found), [0.0; crate::experiment_design::LIMITS]);
        let finer = design.assess_at(&motion, 24_000).expect("exciting");
        // between two samples a stroke of half a hertz moves by a tenth of a per cent
        assert!(finer.peaks.slosh_stroke_m < 1.001 * slosh.stroke_max_m, "{}", finer.peaks.slosh_stroke_m);
    }

    #[test]
    fn the_plant_file_that_is_written_commands_the_trajectory_that_was_found_and_keeps_its_promise() {
        let bench = Inertial::bp1a();
        let wanted = random(&Stream::new(1, "test"), 1, 60.0);
        let plant = plant_file::parse("designed", &plant_text(&wanted)).expect("a plant file").plant;
        for (controller, wanted) in plant.controllers.iter().zip(&wanted.joints) {
            let dynamics::description::SignalKind::Fourier { offset, period_s, sine, cosine } =
                &controller.reference[0].kind
            else {
                panic!("{:?}", controller.reference);
            };
            assert!((offset.value - wanted.offset_rad).abs() < 1e-6 && period_s.value == 60.0); // six decimals
            for k in 0..HARMONICS {
                assert!((sine[k].value - wanted.cosine_rate_rad_s[k]).abs() < 1e-6);
                assert!((cosine[k].value - wanted.sine_rate_rad_s[k]).abs() < 1e-6);
            }
        }
        assert_eq!(plant.simulation.period_s, bench.plant.simulation.period_s);
    }

    #[test]
    fn trajectory_b_as_one_long_period_is_the_same_motion() {
        let b = commanded(&Inertial::bp1a().plant);
        let long = repeated(&b, 60.0);
        for t in [0.0, 13.7, 44.1] {
            let (one, two) = (b.at(t), long.at(t));
            for joint in 0..2 {
                assert!((one.angle_rad[joint] - two.angle_rad[joint]).abs() < 1e-12);
                assert!((one.rate_rad_s[joint] - two.rate_rad_s[joint]).abs() < 1e-12);
            }
        }
    }
}
