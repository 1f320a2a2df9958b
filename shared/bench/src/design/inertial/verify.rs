//! Whether a designed motion keeps its promise: records flown in closed loop with all noises by the
//! simulator, which knows nothing of the design.

use super::{Designed, plant_text};
use crate::campaign::{Benchmark, Campaign, Parameter, statistics};
use crate::experiment_design::{ArmLimits, Assessment, Design};
use crate::inertial::{Inertial, truth};
use crate::report::MethodReport;
use std::fmt::Write;

/// Instants per sample on which the propellant is looked at: its oscillation is not tied to the
/// samples.
const INSTANTS_PER_SAMPLE: f64 = 4.0;
const METHOD: &str = "momentum-wls-bc";

/// What the simulated records came to.
pub struct Verified {
    /// Errors of the weighted fit over the sigmas that were promised.
    pub report: MethodReport,
    pub trials: usize,
    /// Reached by the simulated arm; the propellant by the design's own equations on a finer grid.
    pub peaks: ArmLimits,
}

/// Flies `trajectory` `trials` times; `None`: on the propellant's grid it excites nothing.
pub fn verify(
    design: &Design,
    trajectory: &Designed,
    promised: &Assessment,
    trials: usize,
    seed: u64,
) -> Option<Verified> {
    let plant = plant_file::parse("designed", &plant_text(trajectory));
    let plant = plant.expect("the benchmark's own plant, but for the motion's finite numbers").plant;
    let bench = Inertial::bp1a().flying(plant).only(&[METHOD]);
    let truth = truth::<8>(&bench.plant);
    let bound = |i: usize| promised.relative_sigma[i] * truth[i].abs();
    let names = ["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8"];
    let parameters: Vec<Parameter> =
        (0..8).map(|i| Parameter { name: names[i], truth: truth[i], bound: bound(i) }).collect();
    let answers = Campaign::new(trials, seed).run(&bench, &|| ());
    let report =
        statistics(bench.methods(), &parameters, &answers).pop().expect("one method is asked, one report given");
    Some(Verified { report, trials, peaks: peaks(design, trajectory, &bench)? })
}

fn peaks(design: &Design, trajectory: &Designed, bench: &Inertial<8, 9>) -> Option<ArmLimits> {
    let flown = bench.perfect();
    let largest = |of: &dyn Fn(usize) -> [f64; 2]| {
        (0..flown.len()).flat_map(of).fold(0.0_f64, |largest, value| largest.max(value.abs()))
    };
    let instants = (INSTANTS_PER_SAMPLE * trajectory.period_s * design.rate_hz).round() as usize;
    Some(ArmLimits {
        joint_angle_rad: largest(&|k| flown[k].motion.joint_angle_rad),
        joint_rate_rad_s: largest(&|k| flown[k].motion.joint_rate_rad_s),
        base_rate_rad_s: largest(&|k| [flown[k].motion.omega0_z_rad_s, 0.0]),
        torque_n_m: largest(&|k| flown[k].torque_n_m),
        slosh_stroke_m: design.assess_at(trajectory, instants)?.peaks.slosh_stroke_m,
    })
}

impl Verified {
    /// Lines under the table of the design.
    pub fn lines(&self, limits: &ArmLimits) -> String {
        let mut text = format!("\nsimulated, {} records in closed loop\n{:<12}", self.trials, "RMSE");
        let percent = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.4}"));
        self.report.parameters.iter().for_each(|row| text.push_str(&format!("{:>9}", percent(row.rmse_percent))));
        let _ = write!(text, "\n{:<12}", "over promise");
        let ratio = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
        self.report.parameters.iter().for_each(|row| text.push_str(&format!("{:>9}", ratio(row.rmse_over_crlb))));
        let (mean, sd) = (self.report.geomean_rmse_over_crlb, self.report.geomean_sd);
        let sd = ratio(mean.zip(sd).map(|(mean, sd)| mean * sd));
        let _ = writeln!(text, "\ngeometric mean {} +- {sd}", ratio(mean));
        let names = ["joint angle", "joint rate", "base rate", "torque", "slosh stroke"];
        let shares = self.peaks.values().into_iter().zip(limits.values()).zip(names);
        for ((peak, limit), name) in shares.filter(|((_, limit), _)| limit.is_finite()) {
            let _ = writeln!(text, "{name:<14}{:>8.2} % of its limit", 100.0 * peak / limit);
        }
        text
    }
}
