//! What a run came to, read from its recording: modes, estimates with verdicts, partitions, digest.

mod arm;
mod remarks;

use crate::launch::{Finished, LinkKind};
use crate::{paper, truth};
pub use arm::ArmResults;
use physics::mated::OFF_AXIS_SIGMAS;
use recording::{McapRecorder, RecordedRun, RecordingError};
use runtime::RunConfig;
use runtime::scenario::ArmKnown;
use runtime::statistics::PartitionRow;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use supervisor::mode::Event;
use supervisor::validation;
use telemetry::{
    Domain, ESTIMATE_INERTIAL, ESTIMATE_MODAL, ESTIMATE_SLOSH, Estimate, MODE, Mode, ModeState, Phase, Reason, VERDICT,
    Verdict,
};

/// One change of mode.
pub struct ModeRow {
    pub frame: u64,
    pub t_s: f64,
    pub from: &'static str,
    pub to: &'static str,
    pub cause: &'static str,
}

/// One number: what was simulated, what was found, what the paper found.
pub struct FoundNumber {
    pub name: &'static str,
    pub unit: &'static str,
    pub truth: Option<f64>,
    pub value: Option<f64>,
    pub sigma: Option<f64>,
    pub paper_error_percent: Option<f64>,
}

impl FoundNumber {
    #[must_use]
    pub fn error_percent(&self) -> Option<f64> {
        let (truth, value) = (self.truth?, self.value?);
        Some(100.0 * (value - truth).abs() / truth.abs())
    }

    /// Behind what `object` holds.
    fn append_to(&self, object: &mut Value) {
        object["name"] = json!(self.name);
        object["unit"] = json!(self.unit);
        object["truth"] = json!(self.truth);
        object["value"] = json!(self.value);
        object["sigma"] = json!(self.sigma);
        object["error_percent"] = json!(self.error_percent());
        object["paper_error_percent"] = json!(self.paper_error_percent);
    }
}

/// One parameter and what the supervisor says of its model.
pub struct ParameterRow {
    pub domain: Domain,
    pub phase: Phase,
    pub number: FoundNumber,
    pub complete: Option<bool>,
    pub adequate: Option<bool>,
    pub accepted: Option<bool>,
    pub reason: String,
    /// Modal: the channel on which the mode shows most, numbered from 1.
    pub dominant_channel: Option<u32>,
    /// With a prior: what the record did to the number.
    pub standing: Option<&'static str>,
    /// Inertial: what the sensors' systematic errors may have done, beside the noise's sigma (NaN: not known);
    /// none where the sheet states no error.
    pub consider_sigma: Option<f64>,
    /// Mated, of a9: the centre of mass of link 2 and what it holds lies so many sigmas off the link's axis.
    pub off_axis_sigmas: Option<f64>,
}

impl ParameterRow {
    /// What stands behind the number in the table.
    #[must_use]
    pub fn remark(&self) -> String {
        let off_axis = self.off_axis_sigmas.map(|sigmas| match sigmas.abs() > OFF_AXIS_SIGMAS {
            true => format!("{:.0} sigma off the axis: holds a target, or joint 2 has an offset", sigmas.abs()),
            false => format!("{:.1} sigma off the axis: no target shows", sigmas.abs()),
        });
        let words = self.standing.map(str::to_string).into_iter().chain(off_axis);
        words.collect::<Vec<_>>().join("; ")
    }
}

/// The inertia by the modes beside that by the momentum.
pub struct ComparisonRow {
    pub phase: Phase,
    pub agree: Option<bool>,
    /// Domain to be doubted.
    pub doubt: Option<Domain>,
    pub modal_kg_m2: Option<f64>,
    pub inertial_kg_m2: Option<f64>,
    /// Of the difference.
    pub sigma_kg_m2: Option<f64>,
    pub z: Option<f64>,
    pub reason: String,
}

/// The result of a run.
pub struct Outcome {
    pub modes: Vec<ModeRow>,
    pub parameters: Vec<ParameterRow>,
    /// From torques, and of the target.
    pub arm: ArmResults,
    /// What two estimates of one number say of each other.
    pub comparisons: Vec<ComparisonRow>,
    pub partitions: Vec<PartitionRow>,
    /// None when nothing was recorded.
    pub digest: Option<String>,
    pub wall_s: f64,
    pub link: LinkKind,
    /// Why the run did not get to its end.
    pub failure: Option<String>,
}

impl Outcome {
    /// Reads the results of `run` if it `recorded` any; of one that failed, what its recorder still wrote.
    #[must_use]
    pub fn read(run: &RunConfig, finished: Finished, recorded: bool) -> Self {
        let Finished { rows, wall_s, link, mut failure } = finished;
        let (mut modes, mut parameters, mut arm) = (Vec::new(), Vec::new(), ArmResults::default());
        let (mut comparisons, mut digest) = (Vec::new(), None);
        let found = if recorded {
            recorded_results(&run.record, failure.is_some()).map_err(|error| error.explain())
        } else {
            Err("nothing was recorded".into())
        };
        match found {
            Ok((recorded, identity)) => {
                (modes, parameters) = results(run, &recorded);
                arm = ArmResults::read(run, &recorded);
                comparisons = recorded.of(VERDICT).filter_map(|(_, verdict)| comparison(verdict)).collect();
                digest = Some(identity);
            }
            Err(reason) => {
                // What ended the run says more than that its recording ends early.
                failure.get_or_insert(reason);
            }
        }
        Outcome { modes, parameters, arm, comparisons, partitions: rows, digest, wall_s, link, failure }
    }

    /// The object that `--json` prints.
    #[must_use]
    pub fn json(&self) -> Value {
        let of = |domain: Domain| {
            self.parameters.iter().filter(|row| row.domain == domain).map(parameter_json).collect::<Vec<_>>()
        };
        let mut object = json!({
            "completed": self.failure.is_none(),
            "modes": self.modes.iter().map(|row| json!({
                "frame": row.frame, "t_s": row.t_s, "from": row.from, "to": row.to, "cause": row.cause,
            })).collect::<Vec<_>>(),
            "estimates": { "inertial": of(Domain::Inertial), "slosh": of(Domain::Slosh), "modal": of(Domain::Modal) },
            "comparisons": self.comparisons.iter().map(comparison_json).collect::<Vec<_>>(),
            "partitions": self.partitions.iter().map(|row| self.partition_json(row)).collect::<Vec<_>>(),
            "digest": self.digest,
            "wall_s": self.wall_s,
        });
        for (name, rows) in self.arm.json() {
            object["estimates"][name] = rows;
        }
        if let Some(failure) = &self.failure {
            object["failure"] = json!(failure);
        }
        object
    }

    fn partition_json(&self, row: &PartitionRow) -> Value {
        // In lockstep there is neither a wire nor a process: unknown, not zero.
        let wire = |value: f64| if self.link == LinkKind::Lockstep { Value::Null } else { json!(value) };
        json!({
            "name": row.name, "received": row.received, "lost": row.lost, "restarts": row.restarts,
            "given_up": row.given_up,
            "latency_us_p50": wire(row.latency_us_p50), "latency_us_p99": wire(row.latency_us_p99),
            "cpu_percent": wire(row.cpu_percent), "duplicates": row.duplicates, "bad": row.bad,
            "frames": row.frames, "frame_us_max": wire(row.frame_us_max), "cpu_s": wire(row.cpu_s),
        })
    }
}

/// The results in the file and their identity. A recorder that was killed leaves a file without its end: of a run that
/// `failed` the file is completed with what is readable.
fn recorded_results(path: &Path, failed: bool) -> Result<(RecordedRun, String), RecordingError> {
    let recorded = recording::read_mcap_topics(path, telemetry::is_result).or_else(|error| {
        if !failed {
            return Err(error);
        }
        McapRecorder::recover(path, |_, _, _| true)?.0.finish()?;
        recording::read_mcap_topics(path, telemetry::is_result)
    })?;
    let digest = recording::digest(&recorded)?;
    Ok((recorded, digest.hex))
}

fn results(run: &RunConfig, recorded: &RecordedRun) -> (Vec<ModeRow>, Vec<ParameterRow>) {
    let period_s = run.scenario.period_ns() as f64 * 1e-9;
    let modes = recorded.of(MODE).map(|(_, mode)| mode_row(mode, period_s)).collect();
    let verdicts: Vec<&Verdict> = recorded.of(VERDICT).map(|(_, verdict)| verdict).collect();
    let mut parameters = Vec::new();
    for (domain, topic) in
        [(Domain::Inertial, ESTIMATE_INERTIAL), (Domain::Slosh, ESTIMATE_SLOSH), (Domain::Modal, ESTIMATE_MODAL)]
    {
        for &phase in Phase::ALL {
            let of_phase = |code: u16| code == phase.code();
            let estimate =
                recorded.of(topic).map(|(_, estimate)| estimate).filter(|e| e.closing == 1 && of_phase(e.phase)).last();
            let verdict =
                verdicts.iter().rfind(|v| v.domain == domain.code() && of_phase(v.phase) && !compares(v)).copied();
            parameters.extend(parameter_rows(run, domain, phase, estimate, verdict));
        }
    }
    (modes, parameters)
}

fn compares(verdict: &Verdict) -> bool {
    Reason::from_code(verdict.reason).is_some_and(Reason::compares)
}

fn comparison(verdict: &Verdict) -> Option<ComparisonRow> {
    let reason = Reason::from_code(verdict.reason).filter(|reason| reason.compares())?;
    let compared = !matches!(reason, Reason::SeparateBodies | Reason::InertiaNotFound);
    Some(ComparisonRow {
        phase: Phase::from_code(verdict.phase)?,
        agree: compared.then_some(reason == Reason::InertiaAgrees),
        doubt: match reason {
            Reason::InertiaModalDoubted => Some(Domain::Modal),
            Reason::InertiaInertialDoubted => Some(Domain::Inertial),
            _ => None,
        },
        modal_kg_m2: compared.then_some(verdict.held_out_rms),
        inertial_kg_m2: compared.then_some(verdict.held_out_noise),
        sigma_kg_m2: compared.then_some(verdict.held_out_count),
        z: compared.then_some(verdict.measured),
        reason: validation::explain(verdict),
    })
}

fn comparison_json(row: &ComparisonRow) -> Value {
    json!({
        "of": "inertia", "phase": row.phase.text(), "agree": row.agree, "doubt": row.doubt.map(Domain::text),
        "modal_kg_m2": row.modal_kg_m2, "inertial_kg_m2": row.inertial_kg_m2, "sigma_kg_m2": row.sigma_kg_m2, "z": row.z,
        "reason": row.reason,
    })
}

/// Frames that a run will have, about.
#[must_use]
pub fn frames_expected(run: &RunConfig) -> u64 {
    let scenario = &run.scenario;
    let between = 3 * run.window_frames;
    if let Some(replay) = &run.replay {
        return replay.frames + 2 * between;
    }
    let durations = [
        scenario.modal.as_ref().map(|modal| modal.duration_s),
        scenario.slosh.as_ref().map(|slosh| slosh.duration_s),
        scenario.inertial.as_ref().map(|arm| arm.duration_s),
        scenario
            .mated
            .as_ref()
            .filter(|_| scenario.capture.enabled)
            .map(|arm| arm.duration_s + scenario.capture.settle_s),
    ];
    durations.iter().flatten().map(|&duration_s| scenario.frames(duration_s) + between).sum::<u64>() + 2 * between
}

fn mode_row(mode: &Mode, period_s: f64) -> ModeRow {
    let text = |code: u16| ModeState::from_code(code).map_or("?", ModeState::text);
    ModeRow {
        frame: mode.effective_frame,
        t_s: mode.effective_frame as f64 * period_s,
        from: text(mode.previous),
        to: text(mode.state),
        cause: Event::from_code(mode.event).map_or("?", Event::text),
    }
}

fn parameter_rows(
    run: &RunConfig,
    domain: Domain,
    phase: Phase,
    estimate: Option<&Estimate>,
    verdict: Option<&Verdict>,
) -> Vec<ParameterRow> {
    if estimate.is_none() && verdict.is_none() {
        return Vec::new();
    }
    let truth = truth::parameters(run, domain, phase);
    let found = estimate.filter(|estimate| estimate.status == 0).map_or(0, |estimate| usize::from(estimate.count));
    let names = telemetry::parameters(domain);
    let arm = arm_known(run, phase).filter(|_| domain == Domain::Inertial);
    let row = |i: usize| {
        let found = estimate.filter(|_| i < found);
        ParameterRow {
            domain,
            phase,
            number: FoundNumber {
                name: names[i].name,
                unit: names[i].unit,
                truth: truth.get(i).copied(),
                value: found.map(|estimate| estimate.values[i]),
                sigma: found.map(|estimate| estimate.covariance[i][i].sqrt()),
                paper_error_percent: paper::error_percent(domain, phase, i),
            },
            complete: verdict.map(|verdict| verdict.complete == 1),
            adequate: verdict.and_then(|verdict| (verdict.adequate < 2).then_some(verdict.adequate == 1)),
            accepted: verdict.map(|verdict| verdict.accepted == 1),
            reason: reason(estimate, verdict),
            dominant_channel: found
                .filter(|_| domain == Domain::Modal)
                .map(|estimate| estimate.auxiliary[i / 2] as u32),
            standing: found.and_then(|estimate| match domain {
                Domain::Slosh => remarks::slosh_standing(estimate, i),
                Domain::Inertial => remarks::arm_standing(arm?, estimate, i),
                Domain::Modal => None,
            }),
            consider_sigma: found.and_then(|estimate| remarks::consider_sigma(arm?, estimate, i)),
            off_axis_sigmas: found.and_then(|estimate| remarks::off_axis(arm?, estimate, i)),
        }
    };
    let expected = if truth.is_empty() { found.max(usize::from(found == 0)) } else { truth.len().max(found) };
    (0..expected.min(names.len())).map(row).collect()
}

/// What the estimator of the arm was told: as it chooses it itself.
fn arm_known(run: &RunConfig, phase: Phase) -> Option<&ArmKnown> {
    let scenario = &run.scenario;
    let arm = scenario.inertial.as_ref().filter(|_| phase != Phase::Mated).or(scenario.mated.as_ref());
    arm.map(|arm| &arm.known)
}

/// The supervisor's words, and the estimator's when it has no estimate.
fn reason(estimate: Option<&Estimate>, verdict: Option<&Verdict>) -> String {
    let mut text = verdict.map_or("no verdict".into(), validation::explain);
    if let Some((estimate, domain)) = estimate.and_then(|e| Some((e, Domain::from_code(e.domain)?)))
        && estimate.status != 0
    {
        let status = telemetry::status_text(domain, estimate.status);
        if !text.contains(status) {
            let _ = write!(text, ": {status}");
        }
        let numbers = [estimate.auxiliary[10], estimate.auxiliary[11]];
        if numbers.iter().any(|number| *number != 0.0) {
            let _ = write!(text, " ({}, {})", numbers[0], numbers[1]);
        }
    }
    text
}

fn parameter_json(row: &ParameterRow) -> Value {
    let mut object = json!({ "phase": row.phase.text() });
    row.number.append_to(&mut object);
    object["complete"] = json!(row.complete);
    object["adequate"] = json!(row.adequate);
    object["accepted"] = json!(row.accepted);
    object["reason"] = json!(row.reason);
    if let Some(channel) = row.dominant_channel {
        object["dominant_channel"] = json!(channel);
    }
    if let Some(standing) = row.standing {
        object["standing"] = json!(standing);
    }
    if let Some(sigma) = row.consider_sigma {
        object["consider_sigma"] = json!(sigma);
    }
    if let Some(sigmas) = row.off_axis_sigmas {
        object["off_axis_sigmas"] = json!(sigmas);
    }
    object
}
