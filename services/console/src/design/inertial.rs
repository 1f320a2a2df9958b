//! `obsid design bp1a`: joint motion with the least bound, beside trajectory B under the same
//! limits.

use crate::{Failure, print};
use bench::design::inertial::{HardwareLimits, design, instants, plant_text, search, table, verify};
use bench::inertial::{Inertial, commanded};
use std::path::{Path, PathBuf};

/// Joint motion that tells more of the inertial parameters, within limits
#[derive(clap::Args)]
pub struct Arguments {
    /// TOML with joint_angle_max_rad, joint_rate_max_rad_s, base_rate_max_rad_s, torque_max_n_m
    /// (trajectory B's without it), and [slosh] with stroke_max_m, frequency_hz, damping_ratio,
    /// position_m
    #[arg(long)]
    limits: Option<PathBuf>,
    /// Descents: one from trajectory B, the others from random motions
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    starts: u32,
    /// Steps of a descent
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    iterations: u32,
    /// The same seed gives the same trajectory
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Records simulated with the motion that was found: their errors over what is promised
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    verify: u32,
    /// Where the plant file with the new motion goes
    #[arg(long)]
    out: Option<PathBuf>,
}

/// # Errors
/// See [`super::run`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let design = design(&Inertial::bp1a(), &limits(arguments.limits.as_deref())?);
    let start = commanded(&Inertial::bp1a().plant);
    let reference = design.assess_at(&start, instants(start.period_s, design.rate_hz));
    let reference = reference.ok_or_else(|| Failure::Run("trajectory B excites nothing".into()))?;
    let found = search(&design, &start, arguments.starts as usize, arguments.iterations as usize, arguments.seed);
    let (trajectory, assessment) =
        found.ok_or_else(|| Failure::Run("no trajectory was found that keeps these limits; widen them".into()))?;
    print(&table(&design, &reference, &assessment));
    if arguments.verify > 0 {
        let verified = verify(&design, &trajectory, &assessment, arguments.verify as usize, arguments.seed);
        let verified = verified.ok_or_else(|| Failure::Run("the motion that was found excites nothing".into()))?;
        print(&verified.lines(&design.limits));
    }
    let Some(out) = &arguments.out else { return Ok(()) };
    std::fs::write(out, plant_text(&trajectory)).map_err(|error| Failure::Run(format!("{}: {error}", out.display())))
}

fn limits(file: Option<&Path>) -> Result<HardwareLimits, Failure> {
    let Some(file) = file else { return Ok(HardwareLimits::default()) };
    let bad = |error: String| {
        Failure::Input(miette::miette!(
            help = "keys: joint_angle_max_rad, joint_rate_max_rad_s, base_rate_max_rad_s, torque_max_n_m, and [slosh] with \
                    stroke_max_m, frequency_hz, damping_ratio, position_m",
            "{}: {error}",
            file.display()
        ))
    };
    let text = crate::plants::utf8_text(file).map_err(|(error, _)| bad(error))?;
    let said: HardwareLimits = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
    let mut positive =
        vec![said.joint_angle_max_rad, said.joint_rate_max_rad_s, said.base_rate_max_rad_s, said.torque_max_n_m];
    positive.extend(said.slosh.iter().flat_map(|slosh| [slosh.stroke_max_m, slosh.frequency_hz, slosh.damping_ratio]));
    if !positive.iter().all(|limit| limit.is_finite() && *limit > 0.0) {
        return Err(bad("a limit, a frequency, a damping ratio must be a positive number".into()));
    }
    if said.slosh.is_some_and(|slosh| slosh.damping_ratio >= 1.0) {
        return Err(bad("damping_ratio must be below 1".into()));
    }
    if said.slosh.is_some_and(|slosh| !slosh.position_m.iter().all(|x| x.is_finite())) {
        return Err(bad("position_m must be two numbers".into()));
    }
    Ok(said)
}
