//! `obsid design bp1a`: Fourier trajectories of the two joints with the least bound, beside trajectory B under the same limits.
//!
//! The search is an evolution strategy with one parent and the one-fifth rule, restarted; every draw is a function of the seed. It is local:
//! started in the corner of three limits where trajectory B lies, it gains one or two per cent. Its result
//! is a plant file that `obsid simulate` and `obsid plant` take, the built-in arm with the new references.

use crate::bench::inertial::{Inertial, commanded, sigma, truth};
use crate::plant_file::BUILT_IN;
use crate::{Failure, print};
use physics::excitation::{FourierTrajectory, HARMONICS};
use physics::experiment_design::{ArmLimits, Assessment, Design};
use plant::noise::Stream;
use serde::Deserialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Numbers of a trajectory: an offset and two amplitudes per harmonic of each joint.
const NUMBERS: usize = 2 * (1 + 2 * HARMONICS);
/// First step: rad/s of the amplitudes, ten times that in rad of the offsets.
const FIRST_STEP: f64 = 0.02;
const OFFSET_STEPS: f64 = 10.0;

/// Joint motion that tells more of the inertial parameters, within limits
#[derive(clap::Args)]
pub struct Arguments {
    /// TOML with joint_angle_max_rad, joint_rate_max_rad_s, base_rate_max_rad_s, torque_max_n_m; trajectory B's without it
    #[arg(long)]
    limits: Option<PathBuf>,
    /// Trajectories looked at
    #[arg(long, default_value_t = 40_000)]
    evaluations: u32,
    /// The same seed gives the same trajectory
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where the plant file with the new motion goes
    #[arg(long)]
    out: Option<PathBuf>,
}

/// What hardware allows; defaults are what trajectory B itself reaches, rounded up.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct LimitsFile {
    joint_angle_max_rad: f64,
    joint_rate_max_rad_s: f64,
    base_rate_max_rad_s: f64,
    torque_max_n_m: f64,
}

impl Default for LimitsFile {
    fn default() -> Self {
        Self {
            joint_angle_max_rad: 2.64,
            joint_rate_max_rad_s: 0.355,
            base_rate_max_rad_s: 0.405,
            torque_max_n_m: 20.0,
        }
    }
}

/// # Errors
/// See [`super::run`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = limits(arguments.limits.as_deref())?;
    let bench = Inertial::bp1a();
    let design = Design {
        alpha: truth(&bench.plant),
        h_nms: bench.settings.h_nms,
        sigma: sigma(&bench.plant),
        rate_hz: 1.0 / bench.plant.simulation.period_s,
        duration_s: bench.plant.simulation.duration_s,
        limits,
    };
    let start = commanded(&bench.plant);
    let (found, assessment) = search(&design, &start, arguments.evaluations, arguments.seed)
        .ok_or_else(|| Failure::Run("no trajectory keeps these limits; widen them".into()))?;
    let reference = design.assess(&start).ok_or_else(|| Failure::Run("trajectory B excites nothing".into()))?;
    print(&table(&design, &reference, &assessment));
    let Some(out) = &arguments.out else { return Ok(()) };
    std::fs::write(out, plant_text(&found)).map_err(|error| Failure::Run(format!("{}: {error}", out.display())))
}

fn limits(file: Option<&Path>) -> Result<ArmLimits, Failure> {
    let said = match file {
        None => LimitsFile::default(),
        Some(file) => {
            let bad = |error: String| {
                Failure::Input(miette::miette!(
                    help = "keys: joint_angle_max_rad, joint_rate_max_rad_s, base_rate_max_rad_s, torque_max_n_m",
                    "{}: {error}",
                    file.display()
                ))
            };
            let text = std::fs::read_to_string(file).map_err(|error| bad(error.to_string()))?;
            let said: LimitsFile = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
            let all =
                [said.joint_angle_max_rad, said.joint_rate_max_rad_s, said.base_rate_max_rad_s, said.torque_max_n_m];
            if !all.iter().all(|limit| limit.is_finite() && *limit > 0.0) {
                return Err(bad("a limit must be a positive number".into()));
            }
            said
        }
    };
    Ok(ArmLimits {
        joint_angle_rad: said.joint_angle_max_rad,
        joint_rate_rad_s: said.joint_rate_max_rad_s,
        base_rate_rad_s: said.base_rate_max_rad_s,
        torque_n_m: said.torque_max_n_m,
    })
}

/// One evolution from `start`; the best trajectory that keeps every limit.
fn search(
    design: &Design,
    start: &FourierTrajectory,
    evaluations: u32,
    seed: u64,
) -> Option<(FourierTrajectory, Assessment)> {
    const GROW: f64 = 1.22; // one success in five keeps the step
    let stream = Stream::new(seed, "design.bp1a");
    let mut parent = *start;
    let keeps = |found: &Assessment| design.violations(found).iter().all(|over| *over == 0.0);
    let first = design.assess(&parent);
    let mut parent_cost = first.as_ref().map_or(f64::INFINITY, |found| design.cost(found));
    let mut best = first.filter(keeps).map(|found| (parent_cost, parent, found));
    let mut step = FIRST_STEP;
    for evaluation in 0..evaluations {
        let draw = u64::from(evaluation) * NUMBERS as u64;
        let child = moved(&parent, |i| step * stream.normal(draw + i as u64));
        let Some(found) = design.assess(&child) else { continue };
        let cost = design.cost(&found);
        // The penalty leads inside; once there, no step leads out again.
        let kept = keeps(&found);
        if kept && best.as_ref().is_none_or(|(least, ..)| cost < *least) {
            if best.is_none() {
                parent_cost = f64::INFINITY;
            }
            best = Some((cost, child, found));
        }
        if cost < parent_cost && (kept || best.is_none()) {
            (parent, parent_cost) = (child, cost);
            step *= GROW;
        } else {
            step *= GROW.powf(-0.25);
        }
        if step < 1e-5 {
            step = FIRST_STEP; // it has settled: look further away
        }
    }
    best.map(|(_, trajectory, found)| (trajectory, found))
}

fn moved(parent: &FourierTrajectory, draw: impl Fn(usize) -> f64) -> FourierTrajectory {
    let mut child = *parent;
    for (j, joint) in child.joints.iter_mut().enumerate() {
        let first = j * (1 + 2 * HARMONICS);
        joint.offset_rad += OFFSET_STEPS * draw(first);
        for k in 0..HARMONICS {
            joint.cosine_rate_rad_s[k] += draw(first + 1 + k);
            joint.sine_rate_rad_s[k] += draw(first + 1 + HARMONICS + k);
        }
    }
    child
}

fn table(design: &Design, reference: &Assessment, found: &Assessment) -> String {
    let mut text = format!("bp1a, {} s, bound of each parameter in %\n\n{:<12}", design.duration_s, "");
    (1..=8).for_each(|i| text.push_str(&format!("{:>9}", format!("a{i}"))));
    let rms = |of: &Assessment| 100.0 * (of.relative_sigma.norm_squared() / 8.0).sqrt();
    for (name, of) in [("trajectory B", reference), ("designed", found)] {
        let _ = write!(text, "{:>9}\n{name:<12}", if name == "designed" { "" } else { "RMS" });
        of.relative_sigma.iter().for_each(|sigma| text.push_str(&format!("{:>9.4}", 100.0 * sigma)));
        let _ = write!(text, "{:>9.4}", rms(of));
    }
    let _ = writeln!(text, "\n\n{:<22}{:>12}{:>12}{:>12}", "largest", "trajectory B", "designed", "limit");
    let rows = [
        (
            "joint angle [rad]",
            reference.peaks.joint_angle_rad,
            found.peaks.joint_angle_rad,
            design.limits.joint_angle_rad,
        ),
        (
            "joint rate [rad/s]",
            reference.peaks.joint_rate_rad_s,
            found.peaks.joint_rate_rad_s,
            design.limits.joint_rate_rad_s,
        ),
        (
            "base rate [rad/s]",
            reference.peaks.base_rate_rad_s,
            found.peaks.base_rate_rad_s,
            design.limits.base_rate_rad_s,
        ),
        ("torque [N m]", reference.peaks.torque_n_m, found.peaks.torque_n_m, design.limits.torque_n_m),
    ];
    for (name, reference, found, limit) in rows {
        let _ = writeln!(text, "{name:<22}{reference:>12.3}{found:>12.3}{limit:>12.3}");
    }
    text
}

/// The built-in arm with the references of `trajectory`, controller by controller.
fn plant_text(trajectory: &FourierTrajectory) -> String {
    let (_, text) = BUILT_IN.iter().find(|(name, _)| *name == "free_floating_arm").expect("the arm is built in");
    let (mut joint, mut out) = (0, String::new());
    let list = |values: &[f64; HARMONICS]| values.map(|value| format!("{value:.6}")).join(", ");
    for line in text.lines() {
        let coefficients = trajectory.joints.get(joint);
        let replaced = match (line.split_once(" = ").map(|(key, _)| key), coefficients) {
            (Some("offset"), Some(joint)) => format!("offset = \"{:.6} rad\"", joint.offset_rad),
            (Some("sine"), Some(joint)) => {
                format!("sine = {{ unit = \"rad/s\", values = [{}] }}", list(&joint.cosine_rate_rad_s))
            }
            (Some("cosine"), Some(of)) => {
                joint += 1;
                format!("cosine = {{ unit = \"rad/s\", values = [{}] }}", list(&of.sine_rate_rad_s))
            }
            _ => line.to_owned(),
        };
        out.push_str(&replaced);
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::inertial::Inertial;

    fn design() -> (Design, FourierTrajectory) {
        let bench = Inertial::bp1a();
        let design = Design {
            alpha: truth(&bench.plant),
            h_nms: bench.settings.h_nms,
            sigma: sigma(&bench.plant),
            rate_hz: 100.0,
            duration_s: 60.0,
            limits: limits(None).expect("defaults"),
        };
        (design, commanded(&bench.plant))
    }

    #[test]
    fn a_short_search_already_beats_trajectory_b_within_its_limits() {
        let (design, start) = design();
        let (_, found) = search(&design, &start, 4000, 1).expect("within the limits");
        assert_eq!(design.violations(&found), [0.0; 4]);
        assert!(design.cost(&found) < design.cost(&design.assess(&start).expect("exciting")) - 0.005);
    }

    #[test]
    fn the_plant_file_that_is_written_commands_the_trajectory_that_was_found() {
        let (_, start) = design();
        let wanted = moved(&start, |i| 1e-3 * i as f64);
        let plant = plant::file::parse("designed", &plant_text(&wanted)).expect("a plant file").plant;
        let read = commanded(&plant);
        for (read, wanted) in read.joints.iter().zip(&wanted.joints) {
            assert!((read.offset_rad - wanted.offset_rad).abs() < 1e-6);
            for k in 0..HARMONICS {
                assert!((read.cosine_rate_rad_s[k] - wanted.cosine_rate_rad_s[k]).abs() < 1e-6); // six decimals
                assert!((read.sine_rate_rad_s[k] - wanted.sine_rate_rad_s[k]).abs() < 1e-6);
            }
        }
    }
}
