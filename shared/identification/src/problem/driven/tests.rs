use super::*;
use crate::synthetic;
use simulation::record;

fn simulated(plant: &Plant, end_s: f64) -> Recording {
    record(plant, 1, end_s, &mut |_| {}).unwrap()
}

/// A recording of the plant without noise, and what the plant says when it is driven by that.
fn there_and_back(plant: &Plant, duration_s: f64) -> (Recording, Recording) {
    let recorded = simulated(&quiet(plant), duration_s);
    let again = driven(plant, &recorded).unwrap();
    assert!(again.own_command.is_empty(), "{:?}", again.own_command);
    (recorded, simulated(&again.plant, again.end_s))
}

/// Greatest difference of a sensor, relative to its span; both have the same stamps.
fn difference(plant: &Plant, (recorded, again): &(Recording, Recording)) -> f64 {
    let mut most: f64 = 0.0;
    for sensor in &plant.sensors {
        let of = |recording: &Recording| recording.channel_named(&sensor.name).unwrap().clone();
        let (was, is) = (of(recorded), of(again));
        assert_eq!(was.time_s, is.time_s, "{}", sensor.name);
        let span = was.value.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        let apart = was.value.iter().zip(&is.value).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
        most = most.max(apart / span.max(1e-30));
    }
    most
}

#[test]
fn a_plant_driven_by_its_own_recorded_commands_repeats_its_recording() {
    for (name, duration_s) in [("pendulum", 2.0), ("drive_rig", 1.0), ("study_case", 4.0), ("six_joint_arm", 2.0)] {
        let plant = synthetic::plant(name);
        // equal commands at equal times: nothing but rounding lies between the two
        let apart = difference(&plant, &there_and_back(&plant, duration_s));
        assert!(apart < 1e-9, "{name}: {apart:.1e}");
    }
}

#[test]
fn an_imposed_motion_is_the_smooth_one_of_the_estimator() {
    let imposed = plant_file::parse("imposed", IMPOSED).unwrap().plant;
    let apart = difference(&imposed, &there_and_back(&imposed, 4.0));
    // the cubic spline of a sine with a hundred samples a turn: h⁴ω⁴/384 of position, h²ω²/12 of
    // acceleration
    assert!(apart < 2e-3, "{apart:.1e}");
}

const IMPOSED: &str = "format = 1\nname = \"imposed\"\nspace = \"planar\"\n[[body]]\nname = \"cart\"\nmass = \"1 kg\"\ninertia = \"0.01 kg*m^2\"\n\
joint = { kind = \"prismatic\", name = \"rail\", axis = \"x\" }\n[[body]]\nname = \"bob\"\nparent = \"cart\"\n\
mass = \"1 kg\"\ninertia = \"0.01 kg*m^2\"\ncom = [\"0.2 m\", 0]\n\
joint = { kind = \"revolute\", name = \"pivot\", friction = \"0.1 N*m*s/rad\", stiffness = \"2 N*m/rad\" }\n\
[[actuator]]\nname = \"place\"\nkind = \"prescribed_joint\"\njoint = \"rail\"\nwhat = \"position\"\n\
command = { kind = \"sine\", amplitude = \"0.1 m\", frequency = \"1 Hz\" }\n\
[[sensor]]\nname = \"angle\"\nkind = \"encoder\"\njoint = \"pivot\"\n\
[simulation]\nduration = \"4 s\"\nperiod = \"10 ms\"\n";

#[test]
fn a_recording_that_begins_late_is_driven_by_its_own_clock() {
    let plant = synthetic::plant("drive_rig");
    let mut recorded = simulated(&quiet(&plant), 0.5);
    let clean = recorded.clone();
    recorded.channels.iter_mut().for_each(|channel| channel.time_s.iter_mut().for_each(|t| *t += 100.0));
    let again = driven(&plant, &recorded).unwrap();
    let again = simulated(&again.plant, again.end_s);
    let (was, is) = (clean.channel_named("angle").unwrap(), again.channel_named("angle").unwrap());
    assert!((is.time_s[0] - 100.0).abs() < 1e-9 && is.time_s.len() == was.time_s.len(), "{}", is.time_s[0]);
    let apart = was.value.iter().zip(&is.value).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-9, "{apart:.1e}");
}

#[test]
fn commands_faster_than_the_plant_are_followed_and_sensors_keep_their_period() {
    let plant = synthetic::plant("drive_rig");
    let recorded = simulated(&quiet(&plant), 0.5);
    let mut slow = plant.clone();
    (slow.simulation.period_s, slow.simulation.step_s) = (0.01, 0.001);
    let again = driven(&slow, &recorded).unwrap();
    let again = simulated(&again.plant, again.end_s);
    let (was, is) = (recorded.channel_named("angle").unwrap(), again.channel_named("angle").unwrap());
    assert_eq!(is.value.len(), 50);
    for (k, value) in is.value.iter().enumerate() {
        assert!((value - was.value[10 * k]).abs() < 1e-9, "sample {k}");
    }
}

#[test]
fn an_actuator_without_a_channel_keeps_its_command_and_is_named() {
    let plant = synthetic::plant("drive_rig");
    let mut recorded = simulated(&plant, 0.2);
    recorded.channels.retain(|channel| channel.name != "motor");
    let again = driven(&plant, &recorded).unwrap();
    assert_eq!(
        (again.own_command, &again.plant.actuators[0].command),
        (vec!["motor".to_owned()], &plant.actuators[0].command)
    );
}

#[test]
fn a_command_in_another_unit_is_refused() {
    let plant = synthetic::plant("drive_rig");
    let mut recorded = simulated(&plant, 0.2);
    recorded
        .channels
        .iter_mut()
        .filter(|channel| channel.name == "motor")
        .for_each(|channel| channel.unit = "N".into());
    assert!(matches!(driven(&plant, &recorded), Err(ProblemError::Unit { .. })));
}
