use super::*;
use crate::synthetic::{plant, recording};

#[test]
fn a_channel_that_is_called_otherwise_is_named_with_the_nearest_and_a_map_joins_it() {
    let nominal = plant("oscillator");
    let mut recorded = recording(&nominal, 1, 0.2);
    let at = recorded.channels.iter().position(|c| c.name == "displacement").unwrap();
    recorded.channels[at].name = "displacement_1".to_owned();
    let error = Problem::new(&nominal, core::slice::from_ref(&recorded), &[]).unwrap_err();
    assert!(error.to_string().contains("did you mean 'displacement_1'"), "{error}");
    let map = [("displacement".to_owned(), "displacement_1".to_owned())];
    assert_eq!(Problem::new(&nominal, &[recorded], &map).unwrap().samples(), 200);
}

#[test]
fn another_unit_is_an_error() {
    let nominal = plant("oscillator");
    let mut recorded = recording(&nominal, 1, 0.2);
    recorded.channels.iter_mut().filter(|c| c.name == "displacement").for_each(|c| c.unit = "mm".to_owned());
    let error = Problem::new(&nominal, &[recorded], &[]).unwrap_err();
    assert!(matches!(error, ProblemError::Unit { .. }), "{error}");
}

#[test]
fn numbers_per_recording_become_one_unknown_a_recording() {
    let nominal = plant("pendulum");
    let both = [recording(&nominal, 1, 0.5), recording(&nominal, 2, 0.5)];
    let one = Problem::new(&nominal, &both[..1], &[]).unwrap();
    let two = Problem::new(&nominal, &both, &[]).unwrap();
    assert_eq!(two.unknowns.len(), one.unknowns.len() + 1);
    assert!(two.unknowns.iter().any(|u| u.name == "angle.bias@2" && u.recording == Some(1)));
}

#[test]
fn a_split_keeps_every_sample_once() {
    let nominal = plant("pendulum");
    let whole = crate::synthetic::problem(&nominal, recording(&nominal, 1, 2.0));
    let (first, last) = whole.split(0.7);
    assert_eq!(first.samples() + last.samples(), whole.samples());
    assert!(first.runs[0].end_s <= last.runs[0].begin_s);
}

#[test]
fn a_channel_that_is_another_sensor_is_not_proposed_for_a_missing_one() {
    let nominal = plant("double_pendulum");
    let names: Vec<String> = nominal.sensors.iter().map(|sensor| sensor.name.clone()).collect();
    let mut recorded = recording(&nominal, 1, 0.2);
    recorded.channels.retain(|channel| channel.name != names[1]);
    let problem = Problem::new(&nominal, &[recorded], &[]).unwrap();
    assert!(problem.notes.iter().any(|note| note.contains(&names[1])), "{:?}", problem.notes);
    assert!(problem.runs[0].samples[1].value.is_empty());
}

#[test]
fn recordings_of_several_rates_with_missing_channels_are_one_problem() {
    let nominal = plant("oscillator");
    let full = recording(&nominal, 1, 0.4);
    let mut thin = recording(&nominal, 2, 0.4);
    thin.channels.retain(|channel| channel.name != "acceleration");
    for channel in thin.channels.iter_mut().filter(|channel| channel.name == "displacement") {
        // a third of the samples, at uneven times
        let keep: Vec<usize> = (0..channel.value.len()).filter(|i| (i * i) % 3 == 1).collect();
        channel.time_s = keep.iter().map(|i| channel.time_s[*i]).collect();
        channel.value = keep.iter().map(|i| channel.value[*i]).collect();
    }
    let kept = thin.channels.iter().find(|channel| channel.name == "displacement").unwrap().value.len();
    let problem = Problem::new(&nominal, &[full, thin], &[]).unwrap();
    assert_eq!(problem.samples(), 200 + 200 + kept);
    assert_eq!(problem.runs.len(), 2);
}

#[test]
fn a_controlled_actuator_without_its_command_is_an_unknown_input() {
    let nominal = plant("study_case");
    let actuator = nominal.controllers[0].actuator.clone();
    let mut recorded = recording(&nominal, 1, 0.2);
    recorded.channels.retain(|channel| channel.name != actuator);
    let error = Problem::new(&nominal, &[recorded], &[]).unwrap_err();
    assert!(matches!(&error, ProblemError::UnknownInput { actuator: named } if *named == actuator), "{error}");
}

#[test]
fn a_map_renames_scales_and_turns_signs() {
    let nominal = plant("pendulum");
    let mut recorded = recording(&nominal, 1, 0.5);
    let truth = recorded.channels.iter().find(|c| c.name == "angle").unwrap().clone();
    for channel in recorded.channels.iter_mut().filter(|c| c.name == "angle") {
        channel.name = "encoder_deg".to_owned();
        channel.unit = "deg".to_owned();
        channel.value.iter_mut().for_each(|v| *v *= -180.0 / core::f64::consts::PI);
    }
    let mapping = |theirs: &str| Mapping {
        ours: "angle".to_owned(),
        theirs: theirs.to_owned(),
        scale: -core::f64::consts::PI / 180.0,
    };
    assert_eq!(apply_map(&mut recorded.clone(), &[mapping("nothing")]), Err(vec!["nothing".to_owned()]));
    apply_map(&mut recorded, &[mapping("encoder_deg")]).unwrap();
    let problem = Problem::new(&nominal, &[recorded], &[]).unwrap();
    let off = problem.runs[0].samples[0].value.iter().zip(&truth.value).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-15, "{off}"); // rounding of two factors
}

#[test]
fn a_wrapped_angle_is_unwrapped_and_a_turn_more_is_the_same_place() {
    let nominal = plant("pendulum");
    let recorded = recording(&nominal, 1, 3.0);
    let plain = Problem::new(&nominal, core::slice::from_ref(&recorded), &[]).unwrap();
    let turn = core::f64::consts::TAU;
    // counted from 0 to a turn, of another zero by two turns
    for change in [&|v: f64| v - turn * libm::floor(v / turn), &|v: f64| v + 2.0 * turn] as [&dyn Fn(f64) -> f64; 2] {
        let mut changed = recorded.clone();
        changed.channels.iter_mut().filter(|c| c.name == "angle").for_each(|c| {
            c.value.iter_mut().for_each(|v| *v = change(*v));
        });
        let problem = Problem::new(&nominal, &[changed], &[]).unwrap();
        let pairs = problem.runs[0].samples[0].value.iter().zip(&plain.runs[0].samples[0].value);
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-14, "{off}"); // rounding near 13 rad
        assert!(problem.notes.iter().any(|note| note.contains("turn")), "{:?}", problem.notes);
    }
}

#[test]
fn a_segment_outside_the_recording_is_an_error_not_an_empty_problem() {
    let mut nominal = plant("pendulum");
    let late = dynamics::description::Segment {
        name: "late".to_owned(),
        begin_s: dynamics::description::Quantity::known(100.0),
        end_s: None,
        initial: nominal.initial.clone(),
    };
    nominal.segments.push(late);
    let error = Problem::new(&nominal, &[recording(&nominal, 1, 0.5)], &[]).unwrap_err();
    assert!(matches!(error, ProblemError::Empty { .. }), "{error}");
}

#[test]
fn unknown_numbers_of_the_plants_own_command_reach_the_rows_and_a_step_between_samples_acts_from_where_it_begins() {
    use dynamics::description::{Quantity, SignalKind};
    let mut nominal = plant("oscillator");
    let actuator = &mut nominal.actuators[0];
    (actuator.recorded, actuator.noise) = (false, Quantity::known(0.0));
    let kind = SignalKind::Step { size: Quantity::with_prior(2.0, 1.0) };
    actuator.command =
        vec![dynamics::description::Signal { kind, begin_s: Quantity::with_prior(0.0512, 0.01), end_s: None }];
    let mut recorded = recording(&nominal, 1, 0.2);
    let name = nominal.actuators[0].name.clone();
    recorded.channels.retain(|channel| channel.name != name);
    let problem = Problem::new(&nominal, &[recorded], &[]).unwrap();
    let system = dynamics::system::System::new(&nominal).unwrap();
    let timeline = Timeline::new(&nominal, &system, &problem.runs[0], &[0.0; 2], (1.0, 1));
    let acts = |begin_s: f64, size: f64| -> f64 {
        let mut moved = nominal.clone();
        moved.set_parameter(&format!("{name}.command.1.begin"), begin_s).unwrap();
        moved.set_parameter(&format!("{name}.command.1.size"), size).unwrap();
        let rows = timeline.rows_of(&problem, &problem.runs[0], &moved, &system).unwrap();
        let pulse = |k: usize| -> f64 {
            let next = timeline.events.get(k + 1).map_or(timeline.events[k].t_s, |next| next.t_s);
            (next - timeline.events[k].t_s) * rows[timeline.events[k].row * timeline.inputs]
        };
        (0..timeline.events.len()).map(pulse).sum()
    };
    let end = timeline.events.last().unwrap().t_s;
    for (begin_s, size) in [(0.0512, 2.0), (0.0519, 2.0), (0.0533, -1.5)] {
        // bisection of a sampling interval of 2 ms forty times
        assert!(
            (acts(begin_s, size) - size * (end - begin_s)).abs() < 1e-8,
            "{begin_s} {size}: {}",
            acts(begin_s, size)
        );
    }
}

#[test]
fn when_a_command_comes_again_may_be_unknown_and_when_a_sensor_looks_is_not() {
    use dynamics::description::{Quantity, Signal, SignalKind};
    let known = Quantity::known;
    let periods = |period_s: Quantity| {
        let mut nominal = plant("oscillator");
        nominal.sensors[0].period_s = Some(Quantity::with_prior(nominal.simulation.period_s, 1e-5));
        nominal.actuators[0].recorded = false;
        let pulses = SignalKind::Pulse { size: known(2.0), width_s: known(0.01), period_s: Some(period_s) };
        let tones = SignalKind::Multisine { rms: known(1.0), period_s, first: 1, last: 3 };
        let signal = |kind| Signal { kind, begin_s: known(0.0), end_s: None };
        nominal.actuators[0].command = [pulses, tones].map(signal).to_vec();
        let mut recorded = recording(&nominal, 1, 0.2);
        recorded.channels.retain(|channel| channel.name != nominal.actuators[0].name);
        let unknowns = Problem::new(&nominal, &[recorded], &[]).unwrap().unknowns;
        unknowns.into_iter().map(|u| u.name).filter(|name| name.ends_with("period")).collect::<Vec<_>>()
    };
    assert_eq!(periods(Quantity::with_prior(0.05, 1e-3)), ["shaker.command.1.period", "shaker.command.2.period"]);
    assert!(periods(known(0.05)).is_empty());
}

/// A recording without the rows of one stretch.
fn without_rows(recorded: &channels::Recording, lost_s: core::ops::Range<f64>) -> channels::Recording {
    let mut left = recorded.clone();
    for channel in &mut left.channels {
        let kept: Vec<usize> = (0..channel.time_s.len()).filter(|i| !lost_s.contains(&channel.time_s[*i])).collect();
        channel.value = kept.iter().map(|i| channel.value[*i]).collect();
        channel.time_s = kept.iter().map(|i| channel.time_s[*i]).collect();
    }
    left
}

#[test]
fn lost_rows_cut_a_run_where_the_command_changed_meanwhile_and_nowhere_else() {
    let nominal = plant("oscillator");
    let whole = recording(&nominal, 1, 1.0);
    let lost = without_rows(&whole, 0.4..0.45);
    let cut = crate::synthetic::problem(&nominal, lost.clone());
    assert_eq!((cut.runs.len(), cut.samples()), (2, lost.channels[0].value.len() * 2));
    assert!(cut.runs[1].is_rest && cut.runs[1].initial.values.iter().all(|v| v.position.sigma.is_none()));
    assert!(
        cut.runs[0].end_s < 0.4 && cut.runs[1].begin_s >= 0.45 && cut.notes.iter().any(|note| note.contains("gap"))
    );
    // the readings alone are lost, or the command stood still
    let mut blind = whole.clone();
    let inputs: Vec<&str> = nominal.actuators.iter().map(|a| a.name.as_str()).collect();
    let is_input = |c: &channels::Channel| inputs.contains(&c.name.as_str());
    blind.channels.iter_mut().zip(&lost.channels).filter(|(c, _)| !is_input(c)).for_each(|(c, l)| c.clone_from(l));
    let mut still = lost.clone();
    still.channels.iter_mut().filter(|c| is_input(c)).for_each(|c| c.value.fill(0.5));
    for recorded in [whole, blind, still] {
        assert_eq!(crate::synthetic::problem(&nominal, recorded).runs.len(), 1);
    }
}

#[test]
fn a_thruster_makes_noise_only_while_it_fires_in_simulation_and_in_the_filter() {
    let mut nominal = plant("study_case");
    nominal.sensors.iter_mut().for_each(|sensor| sensor.noise = dynamics::description::Noise::default());
    for actuator in &mut nominal.actuators {
        let is_thruster = matches!(actuator.kind, dynamics::description::ActuatorKind::Thruster { .. });
        actuator.noise = dynamics::description::Quantity::known(if is_thruster { 1.0 } else { 0.0 });
    }
    // the first pair fires from 2 s to 3 s
    let [one, other] = [1, 2].map(|seed| recording(&nominal, seed, 3.5));
    let gyro = |recorded: &channels::Recording| recorded.channels.iter().find(|c| c.name == "gyro").cloned().unwrap();
    let (a, b) = (gyro(&one), gyro(&other));
    for (k, t_s) in a.time_s.iter().enumerate() {
        assert!(*t_s > 2.005 || a.value[k] == b.value[k], "{t_s}");
    }
    let last = a.value.len() - 1;
    assert!(a.value[last] != b.value[last]);

    let noisy = plant("study_case");
    let problem = crate::synthetic::problem(&noisy, recording(&noisy, 3, 3.5));
    let session = crate::fit::EstimationSession::new(&problem, 1).unwrap();
    let system = dynamics::system::System::new(&noisy).unwrap();
    let input = system.inputs().iter().position(|u| noisy.actuators[u.actuator].name == "thruster_1").unwrap();
    let fires = |t_s: f64| (2.0 - 1e-6..3.0 - 1e-6).contains(&t_s);
    let events = &session.timelines[0].events;
    assert!(events.iter().any(|event| fires(event.t_s)));
    for event in events {
        assert_eq!(event.quiet >> input & 1 == 0, fires(event.t_s), "{}", event.t_s);
    }
}
