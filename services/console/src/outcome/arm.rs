//! What the arm's experiments say beside the momentum's parameters: the same parameters from motion
//! and torques, and the parameters of the target.

use super::{FoundNumber, arm_known, remarks};
use crate::scenario_run::ScenarioRun;
use crate::{paper, truth};
use recording::RecordedRun;
use serde_json::{Value, json};
use telemetry::{Domain, ESTIMATE_INERTIAL_TORQUE, ESTIMATE_TARGET, InertialEstimate, Phase, TargetEstimate};

/// Of mass, centre of mass and inertia.
const TARGET: [(&str, &str); 4] = [("m_t", "kg"), ("x_t", "m"), ("y_t", "m"), ("I_t", "kg m^2")];

/// One number; without a value the `remark` says why.
pub struct ArmRow {
    /// The phase, or whose word it is.
    pub of: &'static str,
    pub number: FoundNumber,
    pub remark: &'static str,
    /// As of [`super::ParameterRow`].
    pub consider_sigma: Option<f64>,
}

impl ArmRow {
    fn json(&self, key: &str) -> Value {
        let mut object = json!({ key: self.of });
        self.number.append_to(&mut object);
        object["remark"] = json!(self.remark);
        if let Some(sigma) = self.consider_sigma {
            object["consider_sigma"] = json!(sigma);
        }
        object
    }
}

/// Of a whole run.
#[derive(Default)]
pub struct ArmResults {
    /// The arm's parameters from motion and torques.
    pub torques: Vec<ArmRow>,
    /// The target as it states itself, as it was identified, or as both together say.
    pub target: Vec<ArmRow>,
}

impl ArmResults {
    /// The last closing estimate of each phase from torques, and that of the target, out of a
    /// recorded run.
    #[must_use]
    pub fn read(run: &ScenarioRun, recorded: &RecordedRun) -> Self {
        let of_phase = |phase: Phase| {
            let all = recorded.of(ESTIMATE_INERTIAL_TORQUE).map(|(_, estimate)| estimate);
            let last = all.filter(|found| found.estimate.closing == 1 && found.estimate.phase == phase.code()).last();
            last.map_or_else(Vec::new, |found| torque_rows(run, phase, found))
        };
        let torques = Phase::ALL.iter().flat_map(|&phase| of_phase(phase)).collect();
        let truth = truth::target(run);
        let target = recorded.of(ESTIMATE_TARGET).flat_map(|(_, found)| target_rows(truth, found)).collect();
        Self { torques, target }
    }

    /// As `estimates` of the object that `--json` prints.
    #[must_use]
    pub fn json(&self) -> [(&'static str, Value); 2] {
        let list = |rows: &[ArmRow], key| Value::Array(rows.iter().map(|row| row.json(key)).collect());
        [("inertial_torque", list(&self.torques, "phase")), ("target", list(&self.target, "origin"))]
    }
}

fn torque_rows(run: &ScenarioRun, phase: Phase, sample: &InertialEstimate) -> Vec<ArmRow> {
    let found = &sample.estimate;
    let truth = truth::parameters(run, Domain::Inertial, phase);
    let known = arm_known(run, phase);
    let valid = found.status == 0;
    let remark = if valid { "" } else { telemetry::status_text(Domain::Inertial, found.status) };
    // of what was not found one row says why
    let count = if valid { usize::from(found.count) } else { 1 };
    let row = |i: usize| ArmRow {
        of: phase.text(),
        number: FoundNumber {
            name: telemetry::parameters(Domain::Inertial)[i].name,
            unit: telemetry::parameters(Domain::Inertial)[i].unit,
            truth: truth.get(i).copied(),
            value: valid.then(|| found.values[i]),
            sigma: valid.then(|| found.covariance[i][i].sqrt()),
            paper_error_percent: paper::torque_error_percent(phase, i),
        },
        remark,
        consider_sigma: known.filter(|_| valid).and_then(|known| remarks::consider_sigma(known, sample, i)),
    };
    (0..count.min(telemetry::parameters(Domain::Inertial).len())).map(row).collect()
}

fn target_rows(truth: Option<[f64; 4]>, found: &TargetEstimate) -> Vec<ArmRow> {
    let of = match found.origin {
        0 => "stated",
        1 => "identified",
        _ => "fused",
    };
    let has_values = found.status != telemetry::TARGET_NOT_SOLVED;
    let row = |(i, &(name, unit)): (usize, &(&'static str, &'static str))| ArmRow {
        of,
        number: FoundNumber {
            name,
            unit,
            // what is stated is stated in the target's own frame; mass and inertia are the same in
            // every frame
            truth: truth.filter(|_| found.origin > 0 || i == 0 || i == 3).map(|truth| truth[i]),
            value: has_values.then(|| found.values[i]),
            sigma: has_values.then(|| found.covariance[i][i].sqrt()),
            paper_error_percent: None,
        },
        remark: telemetry::target_status_text(found.status),
        consider_sigma: None,
    };
    TARGET.iter().enumerate().map(row).take(if has_values { 4 } else { 1 }).collect()
}
