//! From the scenario to what the supervisor works with: plan, needs, what is known, what
//! experiments promise.

use crate::mode::{ExperimentPlan, Plan, ReplayPlan};
use crate::validation::Need;
use nalgebra::SVector;
use physics::appendage::{ChannelAmplitude, FreeDecay, Mode};
use physics::excitation::{FourierTrajectory, MomentumPlan};
use physics::momentum::ChannelSigma;
use physics::slosh::SloshParameters;
use physics::slosh_estimator::SloshSettings;
use physics::slosh_likelihood::{SloshHypothesis, SloshUnknowns};
use physics::slosh_plan::SloshPlan;
use plant_file::scenario::{
    self, ArmExperiment, ArmKnown, ModalExperiment, ModalKnown, Scenario, SloshExperiment, SloshKnown, Trajectory,
};
use runtime::RunConfig;
use telemetry::{Domain, Phase, parameters};

/// Pacing windows that a verdict may take after the end of its experiment.
const VERDICT_WINDOWS: u64 = 10;
/// Longest wait for a guard to hold, and dwell in SAFE [s].
const HOLD_TIMEOUT_S: f64 = 30.0;
const SAFE_DWELL_S: f64 = 5.0;

/// What is known of the arm's sensors and momentum in one phase.
#[derive(Clone, Debug)]
pub struct KnownArm {
    /// Angular momentum about the centre of mass [N m s].
    pub h_nms: f64,
    gyro_arw_deg_sqrt_h: f64,
    joint_rate_sigma_rad_s: f64,
    joint_angle_sigma_rad: f64,
}

impl KnownArm {
    fn new(known: &ArmKnown) -> Self {
        KnownArm {
            h_nms: known.h_cm_nms,
            gyro_arw_deg_sqrt_h: known.gyro_arw_deg_sqrt_h,
            joint_rate_sigma_rad_s: known.joint_rate_sigma_rad_s,
            joint_angle_sigma_rad: known.joint_angle_sigma_rad,
        }
    }

    /// Noise of one sample of a gyro that averages over `interval_s`, and of the joints with it.
    pub fn sigma(&self, interval_s: f64) -> ChannelSigma {
        let (rate, angle) = (self.joint_rate_sigma_rad_s, self.joint_angle_sigma_rad);
        ChannelSigma::from_data_sheet(self.gyro_arw_deg_sqrt_h, interval_s, rate, angle)
    }
}

/// The supervisor's view of a run.
#[derive(Clone, Debug)]
pub struct Mission {
    /// For the mode table.
    pub plan: Plan,
    /// Arm before capture; `None` where the scenario does not describe one.
    pub inertial: Option<KnownArm>,
    /// Arm with the target.
    pub mated: Option<KnownArm>,
    /// Spacecraft and tank; `None` where the scenario does not describe one.
    pub slosh: Option<SloshKnown>,
    /// Accelerometer array; a default where the scenario does not describe one.
    pub modal: ModalKnown,
    /// Length of a frame.
    pub frame_period_s: f64,
    /// By `Domain::code`: largest predicted sigma over its need at the end of the experiment before
    /// capture. Nothing is predicted of the mated one: its target is not known before it is
    /// grasped.
    pub predicted_sigma_over_need: [Option<f64>; 3],
    needs: [Need; 3],
    mated_need: Need,
}

impl Mission {
    /// # Errors
    /// A need for a parameter that the domain does not have.
    pub fn new(run: &RunConfig, scenario: &Scenario) -> Result<Self, String> {
        let stated =
            |domain, need: Option<&scenario::Need>| need.map_or(Ok(Need::default()), |need| need_of(domain, need));
        let needs = [
            stated(Domain::Inertial, scenario.inertial.as_ref().map(|arm| &arm.need))?,
            stated(Domain::Slosh, scenario.slosh.as_ref().map(|slosh| &slosh.need))?,
            stated(Domain::Modal, scenario.modal.as_ref().map(|modal| &modal.need))?,
        ];
        let frame_period_s = scenario.period_ns() as f64 * 1e-9;
        let predict = |domain: Domain, sigma: Option<Vec<(f64, f64)>>| {
            sigma.and_then(|sigma| over_need(&sigma, &needs[usize::from(domain.code())]))
        };
        Ok(Mission {
            plan: plan(run, scenario),
            inertial: scenario.inertial.as_ref().map(|arm| KnownArm::new(&arm.known)),
            mated: scenario.mated.as_ref().map(|arm| KnownArm::new(&arm.known)),
            slosh: scenario.slosh.as_ref().map(|slosh| slosh.known.clone()),
            modal: scenario.modal.as_ref().map(|modal| modal.known.clone()).unwrap_or_default(),
            frame_period_s,
            predicted_sigma_over_need: [
                predict(
                    Domain::Inertial,
                    scenario.inertial.as_ref().and_then(|arm| promised_by_arm(arm, frame_period_s)),
                ),
                predict(Domain::Slosh, scenario.slosh.as_ref().and_then(promised_by_slosh)),
                predict(Domain::Modal, scenario.modal.as_ref().and_then(promised_by_decay)),
            ],
            needs,
            mated_need: stated(Domain::Inertial, scenario.mated.as_ref().map(|arm| &arm.need))?,
        })
    }

    /// Needs of a model of `domain` in `phase`; those after capture are stated apart.
    pub fn need(&self, domain: Domain, phase: Phase) -> &Need {
        match (domain, phase) {
            (Domain::Inertial, Phase::Mated) => &self.mated_need,
            _ => &self.needs[usize::from(domain.code())],
        }
    }

    /// The arm as known in `phase`. Before capture, one known only with a target serves as well.
    pub fn arm(&self, phase: Phase) -> Option<&KnownArm> {
        if phase == Phase::Mated { self.mated.as_ref() } else { self.inertial.as_ref().or(self.mated.as_ref()) }
    }
}

fn need_of(domain: Domain, stated: &scenario::Need) -> Result<Need, String> {
    let mut need = Need { held_out_rms: stated.held_out_rms, ..Need::default() };
    for (name, &percent) in &stated.sigma_percent {
        let index = parameters(domain).iter().position(|parameter| parameter.name == name);
        let index =
            index.ok_or_else(|| format!("need.sigma_percent.{name}: {domain} has no parameter of that name"))?;
        need.sigma_percent[index] = Some(percent);
    }
    Ok(need)
}

fn plan(run: &RunConfig, scenario: &Scenario) -> Plan {
    let capture = &scenario.capture;
    let experiment = |frames: u64| ExperimentPlan {
        duration_frames: frames,
        timeout_frames: frames + VERDICT_WINDOWS * run.window_frames,
        retries: 0,
    };
    let planned = |duration_s: Option<f64>| duration_s.map(|duration_s| experiment(scenario.frames(duration_s).max(1)));
    let replay = run.replay.as_ref().map(|replay| ReplayPlan {
        experiment: experiment(replay.frames.max(1)),
        domains: [Domain::Inertial, Domain::Slosh, Domain::Modal].map(|domain| replay.identifies(domain)),
    });
    Plan {
        modal: planned(scenario.modal.as_ref().map(|modal| modal.duration_s)),
        slosh: planned(scenario.slosh.as_ref().map(|slosh| slosh.duration_s)),
        inertial: planned(scenario.inertial.as_ref().map(|arm| arm.duration_s)),
        capture: capture.enabled,
        mated: planned(scenario.mated.as_ref().map(|arm| arm.duration_s)),
        replay,
        settle_frames: scenario.frames(capture.settle_s),
        hold_timeout_frames: scenario.frames(HOLD_TIMEOUT_S),
        capture_timeout_frames: scenario.frames(capture.contact_timeout_s),
        safe_dwell_frames: scenario.frames(SAFE_DWELL_S),
        accepted_age_limit_frames: scenario.frames(capture.model_age_limit_s),
        base_rate_limit_rad_s: capture.base_rate_limit_rad_s,
        operator_override: capture.operator_override,
    }
}

/// Largest predicted sigma over its need; `None` when no need is stated for what is predicted.
fn over_need(predicted: &[(f64, f64)], need: &Need) -> Option<f64> {
    let ratio =
        |(index, &(value, sigma)): (usize, &(f64, f64))| Some(100.0 * sigma / value.abs() / need.sigma_percent[index]?);
    predicted.iter().enumerate().filter_map(ratio).max_by(f64::total_cmp)
}

/// Prior value and promised sigma per parameter, from the Cramér–Rao bound along the reference
/// trajectory with one sample a frame. The prior may be off by a factor of two, and the promise
/// with it: see `guards::OUT_OF_REACH`.
fn promised_by_arm(arm: &ArmExperiment, frame_period_s: f64) -> Option<Vec<(f64, f64)>> {
    if arm.known.prior.len() != 8 || arm.trajectory != Trajectory::B {
        return None;
    }
    let alpha = SVector::<f64, 8>::from_column_slice(&arm.known.prior);
    let plan = MomentumPlan {
        h_nms: arm.known.h_cm_nms,
        sigma_h_nms: arm.known.h_cm_sigma_nms,
        duration_s: arm.duration_s,
        rate_hz: 1.0 / frame_period_s,
    };
    let sigma = KnownArm::new(&arm.known).sigma(frame_period_s);
    let promised = physics::excitation::predicted_sigma(&alpha, &FourierTrajectory::trajectory_b(), &plan, &sigma)?;
    Some(alpha.iter().copied().zip(promised.iter().copied()).collect())
}

/// The same for a sine of thrust, at the tank that is expected.
fn promised_by_slosh(slosh: &SloshExperiment) -> Option<Vec<(f64, f64)>> {
    let [m_s, k_s, c_s] = slosh.known.expected?;
    let hypothesis = SloshHypothesis {
        parameters: SloshParameters { slosh_mass_kg: m_s, stiffness_n_m: k_s, damping_n_s_m: c_s },
        ..SloshHypothesis::default()
    };
    let unknowns = if slosh.known.starts_at_rest == Some(true) {
        SloshUnknowns::Parameters
    } else {
        SloshUnknowns::ParametersStateBias
    };
    let plan = SloshPlan {
        amplitude_n: slosh.force_amplitude_n,
        frequency_hz: slosh.force_frequency_hz,
        duration_s: slosh.duration_s,
        interval_s: slosh.known.interval_s,
        velocity_random_walk_m_s_per_sqrt_s: slosh.known.accelerometer_vrw_m_s_sqrt_h / 60.0,
    };
    let settings = SloshSettings { base_mass_kg: slosh.known.m_0_kg, unknowns };
    let promised = physics::slosh_plan::predicted_sigma(&hypothesis, &settings, &plan)?;
    Some([m_s, k_s, c_s].into_iter().zip(promised.iter().copied()).collect())
}

/// The same for the free decay behind the pulse, as if one channel showed the expected amplitude:
/// the others only help.
fn promised_by_decay(modal: &ModalExperiment) -> Option<Vec<(f64, f64)>> {
    let known = &modal.known;
    let [first, second] = known.expected[..] else { return None };
    let modes = [first, second].map(|[frequency_hz, damping_ratio]| Mode { frequency_hz, damping_ratio });
    let amplitude = ChannelAmplitude { cosine_m_s2: [known.expected_amplitude_m_s2; 2], sine_m_s2: [0.0; 2] };
    let decay = FreeDecay {
        samples: ((modal.duration_s - modal.pulse_s) * known.rate_hz) as u32,
        rate_hz: known.rate_hz,
        sigma_m_s2: known.accelerometer_sigma_m_s2,
    };
    let promised = physics::appendage::predicted_sigma(&modes, &[amplitude], &decay)?;
    let pairs = |(mode, sigma): (&Mode, &Mode)| {
        [(mode.frequency_hz, sigma.frequency_hz), (mode.damping_ratio, sigma.damping_ratio)]
    };
    Some(modes.iter().zip(&promised).flat_map(pairs).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_need_for_an_unknown_parameter_is_refused_by_name() {
        let stated = scenario::Need { sigma_percent: [("m_x".to_string(), 1.0)].into(), held_out_rms: None };
        assert!(need_of(Domain::Slosh, &stated).unwrap_err().contains("m_x"));
    }

    #[test]
    fn an_experiment_that_cannot_meet_its_need_promises_more_than_one() {
        let need = need_of(
            Domain::Slosh,
            &scenario::Need { sigma_percent: [("c_s".to_string(), 1.0)].into(), held_out_rms: None },
        )
        .unwrap();
        let ratio = over_need(&[(28.7, 0.1), (0.16, 1e-3), (0.03, 6e-4)], &need).unwrap();
        assert!((ratio - 2.0).abs() < 1e-12); // 2 % of 0.03 against a need of 1 %
        assert!(ratio > 1.0);
    }
}
