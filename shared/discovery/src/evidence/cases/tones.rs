//! Laws that oscillate in time, and slosh that hangs against the thrust.

use super::*;

/// About a fixed axis a torque in the joint and one on the body are one. It begins at its crest: of
/// one that begins near zero the data do not tell by which half-wave.
#[test]
fn a_torque_that_oscillates_for_a_part_of_the_recording_is_named_with_its_time() {
    let nominal = plant("pendulum");
    let hidden = [("force", 2.5e-2), ("frequency", 2.3), ("phase", 1.5), ("begin", 11.2), ("duration", 2.5)];
    let found =
        diagnosed(&nominal, recording(&with_effect(&nominal, "joint_torque_tone", "joint:pivot", &hidden), 8, 20.0));
    let Some(first) = found.effects.first() else { panic!("{:?} {}", found.verdict, found.reason) };
    let is_it = ["joint_torque_tone", "torque_tone"].contains(&&*first.kind);
    assert!(is_it, "{:?} {}", found.verdict, found.reason);
    let is_shared = |(name, _): &&(&str, f64)| *name != "force";
    for (name, truth) in hidden.iter().filter(is_shared) {
        let own = first.parameters.iter().find(|p| p.name == *name).unwrap();
        assert!((own.value - truth).abs() < 4.0 * own.sigma, "{own:?}");
    }
}

/// The spring's frequency is right at the mean thrust, which the tank's own data sheet does not
/// tell: it follows from the recording.
#[test]
fn slosh_that_hangs_against_the_thrust_is_named() {
    let nominal =
        hub("[[tank]]\nname = \"fuel\"\nbody = \"hub\"\nkind = \"spring\"\naxis = \"y\"\nposition = [\"-0.6 m\", 0]\n\
         mass = { value = \"40 kg\", sigma = \"5 %\" }\nstiffness = { value = \"12 N/m\", sigma = \"10 %\" }\n\
         damping = { value = \"0.6 N*s/m\", sigma = \"30 %\" }\n\
         [[actuator]]\nname = \"main\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"x\"\n\
         command = { kind = \"constant\", value = \"140 N\" }\n\
         [[actuator]]\nname = \"trim\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"x\"\n\
         command = { kind = \"square\", amplitude = \"60 N\", frequency = \"0.04 Hz\" }\n\
         [[actuator]]\nname = \"side\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"y\"\n\
         command = { kind = \"multisine\", rms = \"8 N\", period = \"30 s\", first = 1, last = 12 }\n\
         [[sensor]]\nname = \"acc\"\nkind = \"accelerometer\"\nbody = \"hub\"\naxis = \"xy\"\nnoise = \"2e-3 m/s^2\"\n\
         [[sensor]]\nname = \"gyro\"\nkind = \"gyro\"\nbody = \"hub\"\nnoise = \"2e-4 rad/s\"");
    let hidden = with_effect(
        &nominal,
        "slosh_pendulum",
        "tank:fuel",
        &[("fraction", 0.9), ("axial_acceleration", 140.0 / 480.0)],
    );
    let found = diagnosed(&nominal, recording(&hidden, 5, 60.0));
    assert_eq!(found.effects[0].kind, "slosh_pendulum", "{:?} {}", found.verdict, found.reason);
    let share = &found.effects[0].parameters[0];
    assert!((share.value - 0.9).abs() < 4.0 * share.sigma && share.sigma < 0.2, "{share:?}");
}
