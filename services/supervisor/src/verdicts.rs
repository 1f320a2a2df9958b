//! Verdicts on experiments without a model: every planned experiment leaves one, also when it was
//! skipped, broke off, gave no estimate, or was never reached.

use crate::mode::{Decision, Event, ModeMachine, OUT_OF_REACH, Plan, Situation, StepStatus};
use crate::validation::Missing;
use serde::{Deserialize, Serialize};
use telemetry::{Domain, Experiment, Phase, Reason};

/// The three domains before capture (or replayed), and the inertial one mated.
const SLOTS: usize = 4;
const MATED: usize = 3;

const fn slot(domain: Domain, phase: Phase) -> usize {
    if matches!(phase, Phase::Mated) { MATED } else { domain.code() as usize }
}

/// A verdict on an experiment without a model: its domain and phase, and why there is none.
pub type NoModel = (Domain, Phase, Missing);

/// Which experiments have their verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    given: [bool; SLOTS],
    /// The experiment being flown still owes one.
    owed: [bool; SLOTS],
}

impl Ledger {
    /// A verdict was given.
    pub fn note(&mut self, domain: Domain, phase: Phase) {
        self.given[slot(domain, phase)] = true;
        self.owed[slot(domain, phase)] = false;
    }

    /// Appends the verdicts due now on experiments that give no model to judge to `found`, which
    /// holds none.
    pub fn missing(
        &mut self,
        decision: Option<&Decision>,
        machine: &ModeMachine,
        plan: &Plan,
        situation: &Situation,
        found: &mut Vec<NoModel>,
    ) {
        let phase = if plan.replay.is_some() { Phase::Replay } else { Phase::PreCapture };
        let of_slot = |slot: usize| match slot {
            MATED => (Domain::Inertial, Phase::Mated),
            domain => (Domain::ALL[domain], phase),
        };
        for &domain in Domain::ALL.iter().filter(|_| plan.replay.is_none()) {
            let promised = situation.of(domain).predicted_sigma_over_need.unwrap_or(0.0);
            let skipped = machine.step_status(domain, situation) == StepStatus::NeedOutOfReach;
            if skipped && !self.given[slot(domain, phase)] {
                found.push((domain, phase, (Reason::OutOfReach, promised, OUT_OF_REACH)));
            }
        }
        if let Some(decision) = decision {
            let reason = match decision.event {
                Event::InputsLost => Reason::InputsLost,
                Event::PartitionLost => Reason::PartitionLost,
                _ => Reason::NoEstimate,
            };
            let broken = (0..SLOTS).filter(|&slot| self.owed[slot]).map(of_slot);
            found.extend(broken.map(|(domain, phase)| (domain, phase, (reason, 0.0, 0.0))));
            self.owed = flown(decision.experiment, plan);
        }
        for (domain, phase, _) in found.iter() {
            self.given[slot(*domain, *phase)] = true;
        }
        if decision.is_some_and(|decision| decision.ended) {
            let planned = planned(plan);
            for slot in (0..SLOTS).filter(|&slot| planned[slot] && !self.given[slot]) {
                let (domain, phase) = of_slot(slot);
                found.push((domain, phase, (Reason::NotReached, 0.0, 0.0)));
            }
        }
    }
}

/// Models that an experiment owes.
fn flown(experiment: Experiment, plan: &Plan) -> [bool; SLOTS] {
    match experiment {
        // a craft's arcs are judged together
        Experiment::None | Experiment::HeldOut => [false; SLOTS],
        Experiment::Inertial => [true, false, false, false],
        Experiment::Slosh => [false, true, false, false],
        Experiment::Modal => [false, false, true, false],
        Experiment::MatedInertial => [false, false, false, true],
        Experiment::Replay => planned(plan),
    }
}

fn planned(plan: &Plan) -> [bool; SLOTS] {
    if let Some(replay) = plan.replay {
        let [inertial, slosh, modal] = replay.domains;
        return [inertial, slosh, modal, false];
    }
    let mated = plan.capture && plan.mated.is_some();
    [plan.inertial.is_some(), plan.slosh.is_some(), plan.modal.is_some(), mated]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::{ExperimentPlan, Stimulus};
    use telemetry::ModeState;

    const WINDOW: u64 = 10;

    fn plan() -> Plan {
        let experiment = Some(ExperimentPlan { duration_frames: 100, timeout_frames: 200, retries: 0 });
        Plan {
            modal: experiment,
            slosh: experiment,
            inertial: experiment,
            capture: true,
            mated: experiment,
            replay: None,
            settle_frames: 10,
            hold_timeout_frames: 50,
            capture_timeout_frames: 50,
            safe_dwell_frames: 10,
            accepted_age_limit_frames: 1000,
            base_rate_limit_rad_s: 1.0,
            operator_override: false,
        }
    }

    /// Flies `plan` in what `situation` says; nobody ever delivers an estimate.
    fn fly(plan: Plan, situation: impl Fn(ModeState) -> Situation) -> Vec<(Domain, Phase, Reason)> {
        let (mut machine, mut ledger) = (ModeMachine::new(plan, WINDOW), Ledger::default());
        let mut said = Vec::new();
        for frame in 0..5000 {
            let stimuli = if frame == 0 { vec![Stimulus::Start] } else { Vec::new() };
            let seen = situation(machine.state());
            let decision = machine.evaluate(frame, &stimuli, &seen);
            let mut missing = Vec::new();
            ledger.missing(decision.as_ref(), &machine, &plan, &seen, &mut missing);
            said.extend(missing.iter().map(|&(domain, phase, (reason, ..))| (domain, phase, reason)));
            if machine.ended() {
                return said;
            }
        }
        panic!("the run did not end");
    }

    fn alive() -> Situation {
        let mut situation = Situation { base_rate_rad_s: 0.1, ..Situation::default() };
        for domain in &mut situation.domains {
            domain.inputs_alive = true;
        }
        situation
    }

    #[test]
    fn every_planned_experiment_that_gives_no_model_leaves_exactly_one_verdict_with_its_reason() {
        use {Domain::*, Phase::*};
        let said = fly(plan(), |state| {
            let mut situation = alive();
            situation.of_mut(Modal).inputs_alive = state != ModeState::PreCaptureModal;
            situation.of_mut(Slosh).predicted_sigma_over_need = Some(7.0);
            situation
        });
        let expected = [
            (Slosh, PreCapture, Reason::OutOfReach),
            (Modal, PreCapture, Reason::InputsLost),
            (Inertial, PreCapture, Reason::NoEstimate),
            (Inertial, Mated, Reason::NotReached),
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn a_lost_source_breaks_off_what_is_flown_and_the_rest_is_not_reached() {
        let said = fly(plan(), |state| Situation { source_lost: state == ModeState::PreCaptureSlosh, ..alive() });
        let reasons: Vec<Reason> = said.iter().map(|verdict| verdict.2).collect();
        assert_eq!(said[1].0, Domain::Slosh);
        assert_eq!(reasons, [Reason::NoEstimate, Reason::PartitionLost, Reason::NotReached, Reason::NotReached]);
    }

    #[test]
    fn what_was_judged_is_not_judged_again_and_what_is_not_planned_never() {
        let only_modal = Plan { slosh: None, inertial: None, mated: None, capture: false, ..plan() };
        let mut ledger = Ledger::default();
        let mut machine = ModeMachine::new(only_modal, WINDOW);
        let begun = machine.evaluate(0, &[Stimulus::Start], &alive()).unwrap();
        let mut missing = Vec::new();
        ledger.missing(Some(&begun), &machine, &only_modal, &alive(), &mut missing);
        ledger.note(Domain::Modal, Phase::PreCapture);
        let judged = Stimulus::Verdict { domain: Domain::Modal, generation: 1, accepted: true };
        let ended = machine.evaluate(130, &[judged], &alive()).unwrap();
        assert!(ended.ended);
        ledger.missing(Some(&ended), &machine, &only_modal, &alive(), &mut missing);
        assert_eq!(missing, []);
    }
}
