//! The mode table as laws.

use super::*;
use crate::seeded_noise::SeededNoise;

const WINDOW: u64 = 100;

fn experiment(duration_frames: u64) -> ExperimentPlan {
    ExperimentPlan { duration_frames, timeout_frames: duration_frames + 500, retries: 0 }
}

fn full_plan() -> Plan {
    Plan {
        modal: Some(experiment(500)),
        slosh: Some(experiment(6000)),
        inertial: Some(experiment(3000)),
        capture: true,
        mated: Some(experiment(3000)),
        replay: None,
        settle_frames: 200,
        hold_timeout_frames: 1000,
        capture_timeout_frames: 800,
        safe_dwell_frames: 300,
        accepted_age_limit_frames: 20_000,
        base_rate_limit_rad_s: 0.8,
        operator_override: false,
    }
}

fn calm() -> Situation {
    let mut situation = Situation { base_rate_rad_s: 0.25, ..Situation::default() };
    for domain in Domain::ALL {
        situation.of_mut(*domain).inputs_alive = true;
    }
    situation
}

/// Flies `plan`: every experiment gets its verdict after its duration plus two windows, contact
/// comes 50 frames after CAPTURE takes effect. `judge` says whether a domain's model is accepted.
/// Ends with the run, or after `frames_max`.
fn fly(plan: Plan, situation: Situation, judge: impl Fn(Domain) -> bool, frames_max: u64) -> Vec<Decision> {
    let (mut machine, mut situation) = (ModeMachine::new(plan, WINDOW), situation);
    let mut decisions: Vec<Decision> = Vec::new();
    for frame in 0..frames_max {
        let mut stimuli = if frame == 0 { vec![Stimulus::Start] } else { Vec::new() };
        for domain in &mut situation.domains {
            domain.accepted_age_frames = domain.accepted_age_frames.map(|age| age + 1);
        }
        if let Some(last) = decisions.last() {
            if last.experiment != Experiment::None && frame == last.effective_frame + last.duration_frames + 2 * WINDOW
            {
                let domains = match (last.to, plan.replay) {
                    (_, Some(replay)) => replay.domains,
                    (ModeState::PreCaptureModal, _) => [false, false, true],
                    (ModeState::PreCaptureSlosh, _) => [false, true, false],
                    _ => [true, false, false],
                };
                for domain in Domain::ALL.iter().filter(|domain| domains[usize::from(domain.code())]) {
                    let accepted = judge(*domain);
                    stimuli.push(Stimulus::Verdict { domain: *domain, generation: last.generation, accepted });
                    situation.of_mut(*domain).accepted_age_frames = accepted.then_some(2 * WINDOW);
                }
            }
            let touching = last.to == ModeState::Capture && frame == last.effective_frame + 50;
            situation.contact = touching.then_some(ContactMeasure { statistic: 30.0, limit: 17.0 });
        }
        decisions.extend(machine.evaluate(frame, &stimuli, &situation));
        if machine.ended() {
            break;
        }
    }
    decisions
}

fn visited(decisions: &[Decision]) -> Vec<ModeState> {
    decisions.iter().map(|decision| decision.to).collect()
}

#[test]
fn every_state_and_event_has_a_row_and_the_last_one_is_unguarded() {
    assert_eq!(TABLE.len(), ModeState::ALL.len());
    for state in ModeState::ALL {
        assert_eq!(TABLE.iter().filter(|block| block.state == *state).count(), 1, "{state}");
        for event in Event::ALL {
            let rows: Vec<&Row> = block(*state).rows.iter().filter(|row| row.events.contains(&event)).collect();
            let (last, guarded) = rows.split_last().unwrap_or_else(|| panic!("{state}, {}: no row", event.text()));
            assert_eq!(last.guard, Guard::Always, "{state}, {}", event.text());
            // A row behind an unguarded one could never be taken.
            assert!(guarded.iter().all(|row| row.guard != Guard::Always), "{state}, {}", event.text());
        }
    }
}

#[test]
fn the_default_scenario_passes_every_state_in_order_and_ends() {
    use ModeState::*;
    let decisions = fly(full_plan(), calm(), |_| true, 100_000);
    let expected = [
        PreCaptureModal,
        PreCaptureSlosh,
        PreCaptureInertial,
        ApproachHold,
        Capture,
        MatedSettle,
        MatedInertial,
        Standby,
    ];
    assert_eq!(visited(&decisions), expected);
    assert_eq!(
        decisions.iter().map(|d| d.ended).collect::<Vec<_>>(),
        [false, false, false, false, false, false, false, true]
    );
    assert_eq!(decisions.iter().map(|d| d.generation).collect::<Vec<_>>(), [1, 2, 3, 3, 3, 3, 4, 4]);
    let contact = decisions[5];
    assert_eq!((contact.event, contact.measured, contact.limit), (Event::ContactSeen, 30.0, 17.0));
    // The settling time runs from the frame in which MATED.SETTLE takes effect.
    assert_eq!(decisions[6].frame, contact.effective_frame + 200);
    assert!(decisions.iter().all(|d| d.effective_frame == d.frame + WINDOW));
}

#[test]
fn a_scenario_without_slosh_skips_it_and_captures_with_an_override_only() {
    use ModeState::*;
    let mut plan = Plan { slosh: None, ..full_plan() };
    let without = visited(&fly(plan, calm(), |_| true, 100_000));
    assert_eq!(without, [PreCaptureModal, PreCaptureInertial, ApproachHold, Standby]);
    plan.operator_override = true;
    let with = visited(&fly(plan, calm(), |_| true, 100_000));
    assert_eq!(with[2..], [ApproachHold, Capture, MatedSettle, MatedInertial, Standby]);
}

#[test]
fn a_refused_model_is_repeated_as_often_as_planned_and_then_bars_capture() {
    use ModeState::*;
    let mut plan = full_plan();
    plan.slosh = Some(ExperimentPlan { retries: 2, ..experiment(600) });
    let decisions = fly(plan, calm(), |domain| domain != Domain::Slosh, 100_000);
    let expected =
        [PreCaptureModal, PreCaptureSlosh, PreCaptureSlosh, PreCaptureSlosh, PreCaptureInertial, ApproachHold, Standby];
    assert_eq!(visited(&decisions), expected);
    let last = decisions.last().unwrap();
    assert_eq!((last.event, last.ended), (Event::Timeout, true));
}

#[test]
fn a_model_older_than_its_limit_bars_capture() {
    // Inertial flies last: the slosh model waits for its 3000 frames, the two windows of the
    // verdict and two more.
    let mut plan = Plan { accepted_age_limit_frames: 3000, ..full_plan() };
    assert!(!visited(&fly(plan, calm(), |_| true, 100_000)).contains(&ModeState::Capture));
    plan.accepted_age_limit_frames = 4000;
    assert!(visited(&fly(plan, calm(), |_| true, 100_000)).contains(&ModeState::Capture));
}

#[test]
fn a_replay_flies_one_experiment_and_waits_for_every_domain() {
    let replay = ReplayPlan { experiment: experiment(1000), domains: [true, true, false] };
    let plan = Plan { replay: Some(replay), ..full_plan() };
    // A recording's rate is unknown and its sensors are silent until it is played.
    let nothing_known = Situation { base_rate_rad_s: f64::NAN, ..Situation::default() };
    let decisions = fly(plan, nothing_known, |_| true, 100_000);
    assert_eq!(visited(&decisions), [ModeState::PreCaptureSlosh, ModeState::Standby]);
    assert_eq!(decisions[0].experiment, Experiment::Replay);
    assert!(decisions[1].ended);

    let mut machine = ModeMachine::new(plan, WINDOW);
    machine.evaluate(0, &[Stimulus::Start], &nothing_known);
    let verdict = |domain| Stimulus::Verdict { domain, generation: 1, accepted: true };
    assert_eq!(machine.evaluate(1200, &[verdict(Domain::Inertial)], &nothing_known), None);
    assert!(machine.evaluate(1201, &[verdict(Domain::Slosh)], &nothing_known).is_some());
}

#[test]
fn needs_that_are_met_or_out_of_reach_are_not_flown() {
    let mut situation = calm();
    situation.of_mut(Domain::Modal).sigma_over_need = Some(0.9);
    situation.of_mut(Domain::Slosh).predicted_sigma_over_need = Some(3.1);
    let machine = ModeMachine::new(full_plan(), WINDOW);
    assert_eq!(machine.step_status(Domain::Modal, &situation), StepStatus::NeedMet);
    assert_eq!(machine.step_status(Domain::Slosh, &situation), StepStatus::NeedOutOfReach);
    assert_eq!(visited(&fly(full_plan(), situation, |_| true, 100_000))[0], ModeState::PreCaptureInertial);
    // The prior behind a prediction may be off by two: what misses the need by less is flown.
    situation.of_mut(Domain::Slosh).predicted_sigma_over_need = Some(2.9);
    assert_eq!(machine.step_status(Domain::Slosh, &situation), StepStatus::Open);
}

#[test]
fn a_base_rate_above_its_limit_holds_the_plan_until_it_falls_or_the_wait_is_over() {
    let fast = Situation { base_rate_rad_s: 0.9, ..calm() };
    let mut machine = ModeMachine::new(full_plan(), WINDOW);
    for frame in 0..500 {
        let start = if frame == 0 { &[Stimulus::Start][..] } else { &[] };
        assert_eq!(machine.evaluate(frame, start, &fast), None);
    }
    let decision = machine.evaluate(500, &[], &calm()).unwrap();
    assert_eq!((decision.to, decision.measured, decision.limit), (ModeState::PreCaptureModal, 0.25, 0.8));
    // Never calm: four steps, one hold each.
    let decisions = fly(full_plan(), fast, |_| true, 100_000);
    assert_eq!(visited(&decisions), [ModeState::Standby]);
    assert!(decisions[0].ended);
    assert_eq!(decisions[0].frame, 4 * 1000);
}

#[test]
fn a_verdict_of_another_generation_or_domain_changes_nothing() {
    let (mut machine, situation) = (ModeMachine::new(full_plan(), WINDOW), calm());
    machine.evaluate(0, &[Stimulus::Start], &situation).unwrap();
    let verdict = |domain, generation| Stimulus::Verdict { domain, generation, accepted: true };
    assert_eq!(machine.evaluate(700, &[verdict(Domain::Modal, 0)], &situation), None);
    assert_eq!(machine.evaluate(701, &[verdict(Domain::Slosh, 1)], &situation), None);
    assert_eq!(machine.evaluate(702, &[verdict(Domain::Modal, 1)], &situation).unwrap().to, ModeState::PreCaptureSlosh);
}

#[test]
fn nothing_but_urgent_events_acts_before_a_decision_takes_effect() {
    let (mut machine, situation) = (ModeMachine::new(full_plan(), WINDOW), calm());
    machine.evaluate(0, &[Stimulus::Start], &situation).unwrap();
    let mut silent = situation;
    silent.of_mut(Domain::Modal).inputs_alive = false;
    assert_eq!(machine.evaluate(99, &[Stimulus::OperatorResume], &silent), None);
    assert_eq!(machine.clone().evaluate(100, &[], &silent).unwrap().event, Event::InputsLost);
    assert_eq!(machine.evaluate(99, &[Stimulus::SafeCommand], &silent).unwrap().to, ModeState::Safe);
}

#[test]
fn a_lost_partition_costs_its_experiment_before_capture_and_the_run_after_it() {
    use ModeState::*;
    let (mut machine, mut situation) = (ModeMachine::new(full_plan(), WINDOW), calm());
    machine.evaluate(0, &[Stimulus::Start], &situation).unwrap();
    situation.of_mut(Domain::Modal).lost = true;
    let lost = machine.evaluate(50, &[], &situation).unwrap();
    assert_eq!((lost.to, lost.event, lost.experiment), (Standby, Event::PartitionLost, Experiment::None));
    // Another decision needs the first one in force; then the plan goes on without the modal
    // experiment.
    assert_eq!(machine.evaluate(149, &[], &situation), None);
    assert_eq!(machine.evaluate(150, &[], &situation).unwrap().to, PreCaptureSlosh);
    situation.source_lost = true;
    assert_eq!(machine.evaluate(151, &[], &situation).unwrap().to, Safe);
    for state in [Capture, MatedSettle, MatedInertial] {
        let mut machine = ModeMachine::new(full_plan(), WINDOW);
        (machine.state, machine.running) = (state, true);
        let mut situation = calm();
        situation.of_mut(Domain::Inertial).lost = true;
        assert_eq!(machine.evaluate(10, &[], &situation).unwrap().to, Safe, "{state}");
    }
}

#[test]
fn safe_is_left_by_the_operator_only_and_otherwise_ends_the_run() {
    let (mut machine, situation) = (ModeMachine::new(full_plan(), WINDOW), calm());
    machine.evaluate(0, &[Stimulus::Start], &situation).unwrap();
    machine.evaluate(200, &[Stimulus::SafeCommand], &situation).unwrap();
    let mut resumed = machine.clone();
    assert_eq!(resumed.evaluate(300, &[Stimulus::OperatorResume], &situation).unwrap().to, ModeState::Standby);
    // The modal experiment was tried once; the plan goes on with slosh.
    assert_eq!(resumed.evaluate(400, &[], &situation).unwrap().to, ModeState::PreCaptureSlosh);
    let ends: Vec<Decision> = (201..2000).filter_map(|frame| machine.evaluate(frame, &[], &situation)).collect();
    assert_eq!(ends.len(), 1);
    assert_eq!((ends[0].to, ends[0].ended, ends[0].frame), (ModeState::Safe, true, 300 + 300));
}

#[test]
fn contact_before_capture_is_commanded_makes_safe_and_none_in_capture_too() {
    let contact = Some(ContactMeasure { statistic: 20.0, limit: 17.0 });
    for (state, contact) in [(ModeState::ApproachHold, contact), (ModeState::Capture, None)] {
        let mut machine = ModeMachine::new(full_plan(), WINDOW);
        (machine.state, machine.running) = (state, true);
        let decision = machine.evaluate(800, &[], &Situation { contact, ..calm() }).unwrap();
        assert_eq!(decision.to, ModeState::Safe, "{state}");
    }
}

#[test]
fn contact_after_the_command_and_before_it_is_in_force_is_a_collision() {
    let mut machine = ModeMachine::new(Plan { operator_override: true, ..full_plan() }, WINDOW);
    (machine.state, machine.running) = (ModeState::ApproachHold, true);
    assert_eq!(machine.evaluate(0, &[], &calm()).unwrap().to, ModeState::Capture);
    let touched = Situation { contact: Some(ContactMeasure { statistic: 20.0, limit: 17.0 }), ..calm() };
    assert_eq!(machine.clone().evaluate(WINDOW - 1, &[], &touched).unwrap().to, ModeState::Safe);
    assert_eq!(machine.evaluate(WINDOW, &[], &touched).unwrap().to, ModeState::MatedSettle);
}

fn random_situation(noise: &mut SeededNoise) -> Situation {
    let mut often = |probability: f64| noise.uniform() < probability;
    let mut situation = Situation { base_rate_rad_s: if often(0.2) { 0.9 } else { 0.2 }, ..Situation::default() };
    situation.source_lost = often(0.01);
    situation.contact = often(0.2).then_some(ContactMeasure { statistic: 20.0, limit: 17.0 });
    for domain in &mut situation.domains {
        domain.inputs_alive = often(0.95);
        domain.lost = often(0.02);
        domain.accepted_age_frames = often(0.7).then_some(100);
        domain.sigma_over_need = often(0.1).then_some(0.5);
        domain.predicted_sigma_over_need = often(0.1).then_some(4.0);
    }
    situation
}

fn random_stimuli(noise: &mut SeededNoise, generation: u32) -> Vec<Stimulus> {
    let count = (noise.uniform() * 3.0) as usize;
    (0..count)
        .map(|_| match (noise.uniform() * 8.0) as u32 {
            0 => Stimulus::SafeCommand,
            1 => Stimulus::OperatorResume,
            2 => Stimulus::OperatorOverride,
            3 => Stimulus::Start,
            draw => Stimulus::Verdict {
                domain: Domain::ALL[(noise.uniform() * 3.0) as usize],
                generation: generation - u32::from(noise.uniform() < 0.2 && generation > 0),
                accepted: draw % 2 == 0,
            },
        })
        .collect()
}

fn random_plan(noise: &mut SeededNoise) -> Plan {
    let mut often = |probability: f64| noise.uniform() < probability;
    let mut plan = full_plan();
    let mut maybe = |planned: &mut Option<ExperimentPlan>| {
        let retries = u32::from(often(0.3));
        *planned = often(0.8).then_some(ExperimentPlan { retries, duration_frames: 30, timeout_frames: 60 });
    };
    for planned in [&mut plan.modal, &mut plan.slosh, &mut plan.inertial, &mut plan.mated] {
        maybe(planned);
    }
    plan.capture = often(0.8);
    let replay = ReplayPlan { experiment: experiment(30), domains: [often(0.5), often(0.5), often(0.5)] };
    plan.replay = often(0.1).then_some(replay);
    (plan.settle_frames, plan.hold_timeout_frames) = (10, 20);
    (plan.capture_timeout_frames, plan.safe_dwell_frames) = (20, 20);
    plan
}

#[test]
fn random_sequences_never_excite_outside_experiments_and_always_come_to_an_end() {
    const WINDOW: u64 = 3;
    let mut seen = [0_u64; 9];
    for seed in 0..100_000 {
        let mut noise = SeededNoise::new(seed);
        let mut machine = ModeMachine::new(random_plan(&mut noise), WINDOW);
        let mut frame = 0;
        for _ in 0..40 {
            frame += 1 + (noise.uniform() * 30.0) as u64;
            let (stimuli, situation) = (random_stimuli(&mut noise, machine.generation), random_situation(&mut noise));
            let before = machine.clone();
            let decision = machine.evaluate(frame, &stimuli, &situation);
            check_decision(&before, decision, &situation, seed);
            seen[usize::from(machine.state().code())] += 1;
            // One evaluation leads to SAFE from wherever the machine stands, also before a decision
            // takes effect.
            let mut stopped = machine.clone();
            stopped.evaluate(frame, &[Stimulus::SafeCommand], &situation);
            assert_eq!(stopped.state(), ModeState::Safe, "seed {seed}");
        }
        // Left alone, whatever is measured, the run ends: at most 2 attempts at 4 experiments, 5
        // holds, and the rest.
        let situation = random_situation(&mut noise);
        machine.evaluate(frame + 1, &[Stimulus::Start], &situation);
        let mut decisions = 0;
        for later in frame + 2..frame + 2 + 1200 {
            decisions += u32::from(machine.evaluate(later, &[], &situation).is_some());
            if machine.ended() {
                break;
            }
        }
        assert!(machine.ended(), "seed {seed}: {machine:?}");
        assert!(decisions <= 30, "seed {seed}: {decisions} decisions"); // 8 attempts, each left and entered, plus 7
    }
    assert!(seen.iter().all(|count| *count > 1000), "a state was hardly visited: {seen:?}");
}

fn check_decision(before: &ModeMachine, decision: Option<Decision>, situation: &Situation, seed: u64) {
    let Some(decision) = decision else { return };
    let excited = decision.experiment != Experiment::None;
    assert_eq!(excited, excitation_allowed(decision.to), "seed {seed}: {decision:?}");
    assert_eq!(excited, decision.duration_frames > 0, "seed {seed}");
    assert_eq!(u32::from(excited), decision.generation - before.generation, "seed {seed}: one counter an experiment");
    assert!(!before.ended || decision.to == ModeState::Safe, "seed {seed}: {decision:?} after the end");
    assert!(decision.measured.is_finite() && decision.limit.is_finite(), "seed {seed}");
    if decision.to == ModeState::Capture {
        let fresh = |domain| situation.of(domain).accepted_age_frames.is_some();
        assert!(before.operator_override || fresh(Domain::Inertial) && fresh(Domain::Slosh) || decision.limit == 0.8);
        assert_eq!(decision.from, ModeState::ApproachHold);
    }
    if decision.to == ModeState::MatedSettle && decision.from == ModeState::Capture {
        assert!(situation.contact.is_some(), "seed {seed}: contact is seen in the data, not assumed");
    }
}

#[test]
fn a_restored_machine_decides_as_the_one_that_was_saved() {
    for seed in 0..200 {
        let mut noise = SeededNoise::new(seed);
        let mut machine = ModeMachine::new(random_plan(&mut noise), 3);
        for step in 0..60 {
            let (stimuli, situation) = (random_stimuli(&mut noise, machine.generation), random_situation(&mut noise));
            let bytes = postcard::to_allocvec(&machine).unwrap();
            let mut restored: ModeMachine = postcard::from_bytes(&bytes).unwrap();
            let frame = 10 * step;
            assert_eq!(machine.evaluate(frame, &stimuli, &situation), restored.evaluate(frame, &stimuli, &situation));
            assert_eq!(machine, restored);
        }
    }
}
