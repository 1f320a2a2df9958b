//! What a run came to, read from its recording: modes, estimates with verdicts, partitions, digest.

mod arm;
mod generations;
mod losses;
mod missing;
mod remarks;

use crate::scenario_run::{Finished, LinkKind, ScenarioRun};
use crate::{paper, truth};
pub use arm::ArmResults;
pub use generations::{Generation, JointOutcome, JointRow};
pub use losses::Loss;
use physics::mated::OFF_AXIS_SIGMAS;
use plant_file::scenario::ArmKnown;
use recording::{McapRecorder, RecordedRun, RecordingError};
use runtime::deaths::DeathRow;
use runtime::statistics::PartitionRow;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use supervisor::mode::Event;
use supervisor::{inertia, validation};
use telemetry::{
    AnyEstimate, COMPARISON_INERTIA, Domain, ESTIMATE_INERTIAL, ESTIMATE_MODAL, ESTIMATE_SLOSH, InertiaAgreement,
    InertiaComparison, InertialEstimate, MODE, Mode, ModeState, Phase, SloshStatus, VERDICT, Verdict,
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
    /// Distance from the truth, relative to it [%]; `None` where either is unknown.
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
    pub identifiability: Option<&'static str>,
    /// Inertial: what the sensors' systematic errors may have done, beside the noise's sigma (NaN:
    /// not known); none where the data sheet states no error.
    pub consider_sigma: Option<f64>,
    /// Mated, of a9: the centre of mass of link 2 and what it holds lies so many sigmas off the
    /// link's axis.
    pub off_axis_sigmas: Option<f64>,
}

impl ParameterRow {
    /// The remark printed behind the value in the table.
    #[must_use]
    pub fn remark(&self) -> String {
        let off_axis = self.off_axis_sigmas.map(|sigmas| match sigmas.abs() > OFF_AXIS_SIGMAS {
            true => format!("{:.0} sigma off the axis: holds a target, or joint 2 has an offset", sigmas.abs()),
            false => format!("{:.1} sigma off the axis: no target shows", sigmas.abs()),
        });
        let words = self.identifiability.map(str::to_string).into_iter().chain(off_axis);
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
    /// Of a run that flew one craft.
    pub joint: Option<JointOutcome>,
    pub partitions: Vec<PartitionRow>,
    /// Of processes, over all lives.
    pub deaths: Vec<DeathRow>,
    /// The file of `--record` is not whole.
    pub recording_loss: Option<Loss>,
    /// None when nothing was recorded.
    pub digest: Option<String>,
    pub wall_s: f64,
    pub link: LinkKind,
    /// Why the run did not get to its end.
    pub failure: Option<String>,
}

impl Outcome {
    /// Reads the results of `run` if it `recorded` any; of one that failed, what its recorder still
    /// wrote.
    #[must_use]
    pub fn read(run: &ScenarioRun, finished: Finished, recorded: bool) -> Self {
        let Finished { rows, deaths, wall_s, link, mut failure } = finished;
        let (mut modes, mut parameters, mut arm) = (Vec::new(), Vec::new(), ArmResults::default());
        let (mut comparisons, mut joint, mut digest) = (Vec::new(), None, None);
        let found = if recorded {
            recorded_results(run.config.results.as_ref().unwrap_or(&run.config.record), failure.is_some())
                .map_err(|error| error.explain())
        } else {
            Err("nothing was recorded".into())
        };
        match found {
            Ok((recorded, identity)) => {
                (modes, parameters) = results(run, &recorded);
                arm = ArmResults::read(run, &recorded);
                comparisons = recorded.of(COMPARISON_INERTIA).filter_map(|(_, sample)| comparison(sample)).collect();
                joint = JointOutcome::read(run, &recorded);
                digest = Some(identity);
            }
            Err(reason) => {
                // What ended the run says more than that its recording ends early.
                failure.get_or_insert(reason);
            }
        }
        let recording_loss = run.config.results.as_deref().and_then(Loss::of_recording);
        Outcome {
            modes,
            parameters,
            arm,
            comparisons,
            joint,
            partitions: rows,
            deaths,
            recording_loss,
            digest,
            wall_s,
            link,
            failure,
        }
    }

    /// What was to be delivered and was not; empty where the results are whole.
    #[must_use]
    pub fn losses(&self) -> Vec<Loss> {
        Loss::all(&self.partitions).into_iter().chain(self.recording_loss.clone()).collect()
    }

    /// The object that `--json` prints.
    #[must_use]
    pub fn json(&self) -> Value {
        let of = |domain: Domain| {
            self.parameters.iter().filter(|row| row.domain == domain).map(parameter_json).collect::<Vec<_>>()
        };
        let losses = self.losses();
        let mut object = json!({
            "completed": self.failure.is_none() && losses.is_empty(),
            "degraded": !losses.is_empty(),
            "loss": losses.iter().map(Loss::json).collect::<Vec<_>>(),
            "modes": self.modes.iter().map(|row| json!({
                "frame": row.frame, "t_s": row.t_s, "from": row.from, "to": row.to, "cause": row.cause,
            })).collect::<Vec<_>>(),
            "estimates": { "inertial": of(Domain::Inertial), "slosh": of(Domain::Slosh), "modal": of(Domain::Modal) },
            "comparisons": self.comparisons.iter().map(comparison_json).collect::<Vec<_>>(),
            "partitions": self.partitions.iter().map(|row| self.partition_json(row)).collect::<Vec<_>>(),
            "deaths": self.deaths.iter().map(death_json).collect::<Vec<_>>(),
            "digest": self.digest,
            "wall_s": self.wall_s,
        });
        for (name, rows) in self.arm.json() {
            object["estimates"][name] = rows;
        }
        for (name, found) in self.joint.iter().flat_map(JointOutcome::json) {
            object[name] = found;
        }
        if let Some(failure) = &self.failure {
            object["failure"] = json!(failure);
        }
        object
    }

    fn partition_json(&self, row: &PartitionRow) -> Value {
        // In lockstep there is neither a wire nor a process: unknown, not zero.
        let in_lockstep = self.link == LinkKind::Lockstep;
        let wire = |value: f64| if in_lockstep { Value::Null } else { json!(value) };
        let hardening = if in_lockstep { Value::Null } else { json!(row.hardening) };
        json!({
            "name": row.name, "received": row.received, "lost": row.lost, "restarts": row.restarts,
            "given_up": row.given_up,
            "latency_us_p50": wire(row.latency_us_p50), "latency_us_p99": wire(row.latency_us_p99),
            "cpu_percent": wire(row.cpu_percent), "duplicates": row.duplicates, "bad": row.bad,
            "frames": row.frames, "frame_us_max": wire(row.frame_us_max), "cpu_s": wire(row.cpu_s),
            "allocations_after_start": wire(row.allocations_after_start as f64),
            "hardening": hardening, "cpu_window": Some(&row.cpu_window).filter(|window| !window.is_empty()),
        })
    }
}

fn death_json(death: &DeathRow) -> Value {
    json!({
        "partition": death.partition, "epoch": death.epoch, "cause": death.cause, "t_s": death.t_s,
        "detect_ms": death.detect_ms, "recover_ms": death.recover_ms,
    })
}

/// The results in the file and their identity. A recorder that was killed leaves a file without its
/// end: of a run that `failed` the file is completed with what is readable.
pub(crate) fn recorded_results(path: &Path, failed: bool) -> Result<(RecordedRun, String), RecordingError> {
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

fn results(run: &ScenarioRun, recorded: &RecordedRun) -> (Vec<ModeRow>, Vec<ParameterRow>) {
    let period_s = run.scenario.period_ns() as f64 * 1e-9;
    let modes = recorded.of(MODE).map(|(_, mode)| mode_row(mode, period_s)).collect();
    let verdicts: Vec<&Verdict> = recorded.of(VERDICT).map(|(_, verdict)| verdict).collect();
    let mut parameters = Vec::new();
    for &domain in Domain::ALL {
        for &phase in Phase::ALL {
            let estimate = last_closing(recorded, domain, phase);
            let verdict = verdicts.iter().rfind(|v| v.domain == domain.code() && v.phase == phase.code()).copied();
            parameters.extend(parameter_rows(run, domain, phase, estimate, verdict));
        }
    }
    (modes, parameters)
}

/// The estimate with which the last experiment of `domain` in `phase` was closed.
fn last_closing(recorded: &RecordedRun, domain: Domain, phase: Phase) -> Option<AnyEstimate<'_>> {
    let is_it = |any: &AnyEstimate<'_>| any.common().closing == 1 && any.common().phase == phase.code();
    match domain {
        Domain::Inertial => {
            recorded.of(ESTIMATE_INERTIAL).map(|(_, one)| AnyEstimate::Inertial(one)).filter(is_it).last()
        }
        Domain::Slosh => recorded.of(ESTIMATE_SLOSH).map(|(_, one)| AnyEstimate::Slosh(one)).filter(is_it).last(),
        Domain::Modal => recorded.of(ESTIMATE_MODAL).map(|(_, one)| AnyEstimate::Modal(one)).filter(is_it).last(),
    }
}

fn comparison(sample: &InertiaComparison) -> Option<ComparisonRow> {
    let agreement = InertiaAgreement::from_code(sample.agreement)?;
    let compared = agreement.is_comparison();
    Some(ComparisonRow {
        phase: Phase::from_code(sample.phase)?,
        agree: compared.then_some(agreement == InertiaAgreement::Agree),
        doubt: match agreement {
            InertiaAgreement::ModalDoubted => Some(Domain::Modal),
            InertiaAgreement::InertialDoubted => Some(Domain::Inertial),
            _ => None,
        },
        modal_kg_m2: compared.then_some(sample.modal_inertia_kg_m2),
        inertial_kg_m2: compared.then_some(sample.inertial_inertia_kg_m2),
        sigma_kg_m2: compared.then_some(sample.difference_sigma_kg_m2),
        z: compared.then_some(sample.z),
        reason: inertia::explain(sample),
    })
}

fn comparison_json(row: &ComparisonRow) -> Value {
    json!({
        "of": "inertia", "phase": row.phase.text(), "agree": row.agree, "doubt": row.doubt.map(Domain::text),
        "modal_kg_m2": row.modal_kg_m2, "inertial_kg_m2": row.inertial_kg_m2, "sigma_kg_m2": row.sigma_kg_m2, "z": row.z,
        "reason": row.reason,
    })
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
    run: &ScenarioRun,
    domain: Domain,
    phase: Phase,
    estimate: Option<AnyEstimate<'_>>,
    verdict: Option<&Verdict>,
) -> Vec<ParameterRow> {
    if estimate.is_none() && verdict.is_none() {
        return Vec::new();
    }
    let truth = truth::parameters(run, domain, phase);
    let valid = estimate.filter(|estimate| estimate.common().status == 0);
    let count = valid.map_or(0, |estimate| usize::from(estimate.common().count));
    let names = telemetry::parameters(domain);
    let known = arm_known(run, phase);
    let row = |i: usize| {
        let found = valid.filter(|_| i < count);
        let arm = found.and_then(|found| Some((known?, inertial(found)?)));
        ParameterRow {
            domain,
            phase,
            number: FoundNumber {
                name: names[i].name,
                unit: names[i].unit,
                truth: truth.get(i).copied(),
                value: found.map(|found| found.common().values[i]),
                sigma: found.map(|found| found.common().covariance[i][i].sqrt()),
                paper_error_percent: paper::error_percent(domain, phase, i),
            },
            complete: verdict.map(|verdict| verdict.complete == 1),
            adequate: verdict.and_then(|verdict| (verdict.adequate < 2).then_some(verdict.adequate == 1)),
            accepted: verdict.map(|verdict| verdict.accepted == 1),
            reason: reason(estimate, verdict),
            dominant_channel: found.and_then(|found| dominant_channel(found, i)),
            identifiability: match arm {
                Some((known, sample)) => remarks::arm_identifiability(known, &sample.estimate, i),
                None => found
                    .filter(|_| domain == Domain::Slosh)
                    .and_then(|slosh| remarks::identifiability(slosh.common(), i)),
            },
            consider_sigma: arm.and_then(|(known, sample)| remarks::consider_sigma(known, sample, i)),
            off_axis_sigmas: arm.and_then(|(known, sample)| remarks::off_axis(known, sample, i)),
        }
    };
    let expected = if truth.is_empty() { count.max(usize::from(count == 0)) } else { truth.len().max(count) };
    (0..expected.min(names.len())).map(row).collect()
}

fn inertial(estimate: AnyEstimate<'_>) -> Option<&InertialEstimate> {
    if let AnyEstimate::Inertial(sample) = estimate { Some(sample) } else { None }
}

/// Of the mode to which parameter `i` belongs.
fn dominant_channel(estimate: AnyEstimate<'_>, i: usize) -> Option<u32> {
    let AnyEstimate::Modal(sample) = estimate else { return None };
    Some(sample.modes[i / 2].dominant_channel.into())
}

/// Prior knowledge of the arm's estimator, chosen as the estimator does.
fn arm_known(run: &ScenarioRun, phase: Phase) -> Option<&ArmKnown> {
    let scenario = &run.scenario;
    let arm = scenario.inertial.as_ref().filter(|_| phase != Phase::Mated).or(scenario.mated.as_ref());
    arm.map(|arm| &arm.known)
}

/// The supervisor's words, and the estimator's when it has no estimate.
fn reason(estimate: Option<AnyEstimate<'_>>, verdict: Option<&Verdict>) -> String {
    let mut text = verdict.map_or("no verdict".into(), validation::explain);
    let Some(estimate) = estimate.filter(|estimate| estimate.common().status != 0) else { return text };
    let status = telemetry::status_text(estimate.domain(), estimate.common().status);
    if !text.contains(status) {
        let _ = write!(text, ": {status}");
    }
    let figures = status_figures(estimate);
    if figures != [0.0; 2] {
        let _ = write!(text, " ({}, {})", figures[0], figures[1]);
    }
    text
}

/// The figures that prove a status, 0 where it has none.
fn status_figures(estimate: AnyEstimate<'_>) -> [f64; 2] {
    match estimate {
        AnyEstimate::Inertial(_) => [0.0; 2],
        AnyEstimate::Modal(modal) => [modal.record_samples as f64, modal.record_samples_needed as f64],
        AnyEstimate::Slosh(slosh) => match SloshStatus::from_code(slosh.estimate.status as u16) {
            Some(SloshStatus::ArcTooShort | SloshStatus::Fragmented) => {
                [slosh.arc_blocks as f64, slosh.arc_blocks_needed as f64]
            }
            Some(SloshStatus::NoSloshFound) => [slosh.slosh_gain, slosh.slosh_gain_needed],
            Some(SloshStatus::NotConverged) => [slosh.iterations as f64, slosh.step_sigma],
            Some(SloshStatus::ModeNotResolved) => [slosh.block_phase_rad, slosh.block_phase_max_rad],
            _ => [0.0; 2],
        },
    }
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
    if let Some(identifiability) = row.identifiability {
        object["identifiability"] = json!(identifiability);
    }
    if let Some(sigma) = row.consider_sigma {
        object["consider_sigma"] = json!(sigma);
    }
    if let Some(sigmas) = row.off_axis_sigmas {
        object["off_axis_sigmas"] = json!(sigmas);
    }
    object
}
