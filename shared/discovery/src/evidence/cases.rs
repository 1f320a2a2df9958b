//! Laws of decisions over plants and kinds of mismatch.

mod friction;

use super::*;
use crate::diagnose::Verdict;
use crate::noisier::of_higher_variance;
use crate::synthetic::{coloured, off_priors, plant, problem, recording, with_effect};
use channels::Recording;
use dynamics::description::Plant;
use identification::held_out::Status;

const SHORT: [(&str, f64); 3] = [("pendulum", 6.0), ("oscillator", 1.0), ("drive_rig", 1.0)];

fn diagnosed(nominal: &Plant, recorded: Recording) -> Diagnosis {
    diagnose(&problem(nominal, recorded), &Options { threads: 2, ..Options::default() }, &mut |_, _| {})
}

#[test]
fn where_nothing_is_missing_nothing_is_named() {
    for (name, duration_s) in SHORT {
        let nominal = plant(name);
        for seed in 1..=7 {
            let found = diagnosed(&nominal, recording(&off_priors(&nominal, seed), seed, duration_s));
            assert_eq!(found.verdict, Verdict::None, "{name} {seed}: {}", found.reason);
            assert!(!found.detection_limits.is_empty());
        }
    }
}

#[test]
fn lost_rows_are_no_law() {
    let nominal = plant("oscillator");
    let mut lost = recording(&off_priors(&nominal, 31), 31, 1.5);
    for channel in &mut lost.channels {
        let kept: Vec<usize> =
            (0..channel.time_s.len()).filter(|i| !(0.6..0.7).contains(&channel.time_s[*i])).collect();
        channel.value = kept.iter().map(|i| channel.value[*i]).collect();
        channel.time_s = kept.iter().map(|i| channel.time_s[*i]).collect();
    }
    let found = diagnosed(&nominal, lost);
    assert_eq!(found.verdict, Verdict::None, "{}", found.reason);
}

/// A hub in free space: commanded by a torque and a force, or coasting.
fn hub(outputs_and_inputs: &str) -> Plant {
    let text = format!(
        "format = 1\nname = \"hub\"\nspace = \"planar\"\n[[body]]\nname = \"hub\"\nmass = {{ value = \"440 kg\", sigma = \"2 %\" }}\n\
         inertia = {{ value = \"130 kg*m^2\", sigma = \"5 %\" }}\njoint = {{ kind = \"free\" }}\n{outputs_and_inputs}\n\
         [simulation]\nduration = \"60 s\"\nperiod = \"0.1 s\"\n"
    );
    plant_file::parse("hub.toml", &text).unwrap().plant
}

#[test]
fn a_panel_left_out_of_a_hub_is_named_by_the_motion_that_it_answers() {
    let signal =
        |rms: &str| format!("{{ kind = \"multisine\", rms = \"{rms}\", period = \"30 s\", first = 1, last = 60 }}");
    let nominal = hub(&format!(
        "[[actuator]]\nname = \"torque\"\nkind = \"body_torque\"\nbody = \"hub\"\ncommand = {}\n\
         [[actuator]]\nname = \"push\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"y\"\ncommand = {}\n\
         [[sensor]]\nname = \"gyro\"\nkind = \"gyro\"\nbody = \"hub\"\nnoise = \"1e-4 rad/s\"\n\
         [[sensor]]\nname = \"acceleration\"\nkind = \"accelerometer\"\nbody = \"hub\"\naxis = \"xy\"\nnoise = \"1e-4 m/s^2\"",
        signal("0.3 N*m"),
        signal("2 N")
    ));
    let shape = [("frequency", 0.35), ("damping_ratio", 0.01)];
    for (kind, share, size) in
        [("appendage_rotation_left_out", "share_z", 0.08), ("appendage_left_out", "share_y", 0.08)]
    {
        let values = [&[("share_x", 0.0), (share, size)], &shape[..]].concat();
        let found = diagnosed(&nominal, recording(&with_effect(&nominal, kind, "body:hub", &values), 41, 60.0));
        let named = found.effects.first().filter(|effect| effect.kind == kind && effect.probability > 0.9);
        let named = named.unwrap_or_else(|| panic!("{kind}: {:?} {}", found.verdict, found.reason));
        let number = |name: &str| named.parameters.iter().find(|parameter| parameter.name == name).unwrap();
        for (name, truth) in [(share, size), ("frequency", 0.35), ("damping_ratio", 0.01)] {
            let (value, sigma) = (number(name).value, number(name).sigma);
            assert!((value - truth).abs() < 4.0 * sigma && sigma < 0.3 * truth, "{kind} {name} {value} {sigma}");
        }
    }
}

/// Four thrusters that pulse in turn; a gyro whose steps the filter forgets within a few samples.
fn floater() -> Plant {
    let thruster = |(name, place, direction, begin): (&str, &str, &str, &str)| {
        format!(
            "[[actuator]]\nname = \"{name}\"\nkind = \"thruster\"\nbody = \"hub\"\nposition = {place}\ndirection = \"{direction}\"\n\
             range = \"22 N\"\nnoise = \"0.02 N\"\n\
             command = {{ kind = \"pulse\", size = \"22 N\", width = \"1 s\", period = \"17 s\", begin = \"{begin}\" }}\n"
        )
    };
    let thrusters = [
        ("t1", "[\"-0.9 m\", \"0.7 m\"]", "x", "2 s"),
        ("t2", "[\"-0.9 m\", \"-0.7 m\"]", "x", "5 s"),
        ("t3", "[\"0.9 m\", \"0.7 m\"]", "-x", "12 s"),
        ("t4", "[\"0.9 m\", \"-0.7 m\"]", "-x", "9 s"),
    ];
    hub(&format!(
        "{}[[sensor]]\nname = \"gyro\"\nkind = \"gyro\"\nbody = \"hub\"\nnoise = \"2e-5 rad/s\"\n\
         [[sensor]]\nname = \"acceleration\"\nkind = \"accelerometer\"\nbody = \"hub\"\naxis = \"xy\"\nnoise = \"2e-4 m/s^2\"",
        thrusters.map(thruster).concat()
    ))
}

/// Effect, site, and names of its numbers with their values and the largest standard errors.
type Timed = (&'static str, &'static str, &'static [(&'static str, f64, f64)]);

#[test]
fn what_begins_or_ends_is_named_with_its_times_and_what_sticks_altogether_with_a_share_of_one() {
    let nominal = floater();
    let cases: [Timed; 3] = [
        ("actuator_stuck", "actuator:t2", &[("share", 1.0, 1.0), ("begin", 31.0, 10.0)]),
        ("thruster_leak", "actuator:t1", &[("force", 0.3, 0.02), ("begin", 31.83, 0.1)]),
        ("sensor_step", "sensor:gyro", &[("step", 2e-3, 1e-4), ("begin", 23.33, 0.1), ("duration", 9.7, 0.15)]),
    ];
    for (kind, site, numbers) in cases {
        let values: Vec<(&str, f64)> = numbers.iter().map(|(name, value, _)| (*name, *value)).collect();
        let found = diagnosed(&nominal, recording(&with_effect(&nominal, kind, site, &values), 43, 60.0));
        let [named] = &found.effects[..] else { panic!("{kind}: {:?} {:?}", found.reason, found.effects) };
        assert!(named.kind == kind && named.site == site && named.probability > 0.9, "{named:?}");
        for (name, truth, most) in numbers {
            let number =
                named.parameters.iter().find(|p| p.name == *name).unwrap_or_else(|| panic!("{name}: {named:?}"));
            let off = (number.value - truth).abs();
            assert!(off <= 4.0 * number.sigma && number.sigma <= *most, "{kind} {name}: {number:?}");
        }
    }
}

#[test]
fn a_gravity_gradient_is_named_wherever_the_planet_stands() {
    let mut nominal = hub("[[actuator]]\nname = \"torque\"\nkind = \"body_torque\"\nbody = \"hub\"\n\
         [[sensor]]\nname = \"gyro\"\nkind = \"gyro\"\nbody = \"hub\"\nnoise = \"1e-5 rad/s\"");
    nominal.simulation.period_s = 10.0;
    for planet in [-0.9, 0.6] {
        let values = [("torque", 2e-4), ("planet_azimuth", planet)];
        let with = with_effect(&nominal, "gravity_gradient", "body:hub", &values);
        let found = diagnosed(&nominal, recording(&with, 42, 4000.0));
        let named = found.effects.first().filter(|effect| effect.kind == "gravity_gradient");
        let named = named.unwrap_or_else(|| panic!("{planet}: {:?} {}", found.verdict, found.reason));
        let [torque, azimuth] = &named.parameters[..] else { panic!("{:?}", named.parameters) };
        let turned = (azimuth.value + planet).abs() < 4.0 * azimuth.sigma.max(1e-3);
        assert!((torque.value - 2e-4).abs() < 4.0 * torque.sigma && turned, "{planet} {torque:?} {azimuth:?}");
    }
}

#[test]
fn lone_outliers_are_noise_and_a_burst_is_located() {
    let nominal = plant("oscillator");
    let spiked = |samples: &[usize]| {
        let mut recorded = recording(&nominal, 34, 1.5);
        let channel = recorded.channels.iter_mut().find(|channel| channel.name == nominal.sensors[0].name).unwrap();
        let sigma = crate::synthetic::sample_sigma(&nominal, &channel.name).unwrap();
        samples.iter().for_each(|at| channel.value[*at] += 17.0 * sigma);
        diagnosed(&nominal, recorded)
    };
    let found = spiked(&[700]);
    assert_eq!(found.verdict, Verdict::NoiseModel, "{}", found.reason);
    assert!(found.reason.contains("has 1 of"), "{}", found.reason);
    // no noise and no law that was compared explains what is left of it, and the answer says where
    let found = spiked(&(700..712).collect::<Vec<_>>());
    let [begin, end] = found.located[0].time;
    assert!(found.verdict != Verdict::None && begin < 1.40 && end > 1.40, "{:?} {}", found.verdict, found.reason);
}

#[test]
fn a_limit_is_found_whatever_the_unit_of_what_it_limits() {
    // peaks of the command below the usual limit, and above
    for size in [1.0, 0.05] {
        let mut nominal = plant("oscillator");
        nominal.visit_quantities(&mut |name, _, quantity| {
            let is_force = ["carriage.mass", "rail.stiffness", "rail.friction", "shaker.noise"].contains(&name);
            if is_force || name.starts_with("shaker.command") && name.ends_with("rms") {
                quantity.value *= size;
                quantity.sigma = quantity.sigma.map(|sigma| sigma * size);
            }
        });
        let limit = 1.0 / (4.5 * size);
        let with = with_effect(&nominal, "actuator_saturation", "actuator:shaker", &[("inverse_limit", limit)]);
        let found = diagnosed(&nominal, recording(&with, 32, 2.0));
        let named = found.effects.first().filter(|effect| effect.kind == "actuator_saturation");
        let named =
            named.unwrap_or_else(|| panic!("{size}: {:?} {}", found.verdict, found.reason)).parameters[0].clone();
        assert!((named.value - limit).abs() < 4.0 * named.sigma, "{size}: {} ± {}, {limit}", named.value, named.sigma);
    }
}

#[test]
fn a_number_far_from_what_the_file_states_is_no_silence() {
    let nominal = plant("oscillator");
    let mut heavy = nominal.clone();
    heavy.bodies[0].mass_kg.value *= 1.1;
    let found = diagnosed(&nominal, recording(&heavy, 33, 1.5));
    assert_eq!(found.verdict, Verdict::ParameterConflict, "{}", found.reason);
    assert!(found.reason.contains("carriage.mass"), "{}", found.reason);
    let mass = found.nominal.iter().find(|number| number.name == "carriage.mass").expect("it is free");
    assert!((mass.after - heavy.bodies[0].mass_kg.value).abs() < 4.0 * mass.sigma, "{mass:?}");
}

#[test]
fn a_wrong_noise_model_is_called_that_and_nothing_else() {
    for (name, duration_s) in SHORT {
        let nominal = plant(name);
        for recorded in
            [recording(&of_higher_variance(&nominal, 3.0), 11, duration_s), coloured(&nominal, 12, duration_s, 0.6)]
        {
            let found = diagnosed(&nominal, recorded);
            assert_eq!(found.verdict, Verdict::NoiseModel, "{name}: {}", found.reason);
            // what changed by chance is no word worth
            assert!(
                !found.reason.contains("pole 0.0") && !found.reason.contains("pole -0.0"),
                "{name}: {}",
                found.reason
            );
        }
    }
}

/// What noise of any size and colour would absorb leaves a line of the spectrum or a force over the
/// command.
#[test]
fn a_law_that_the_catalogue_lacks_is_not_named_and_what_noise_leaves_of_it_is_located() {
    let cases: [Case; 3] = [
        ("drive_rig", 2.0, "sensor_tone", "sensor:rate", &[("amplitude", 4e-3), ("frequency", 29.0)]),
        ("oscillator", 1.0, "sensor_tone", "sensor:acceleration", &[("amplitude", 0.1), ("frequency", 26.0)]),
        ("oscillator", 2.0, "actuator_dead_zone", "actuator:shaker", &[("half_width", 0.05)]),
    ];
    for (name, duration_s, kind, site, values) in cases {
        let nominal = plant(name);
        let recorded = recording(&with_effect(&nominal, kind, site, values), 21, duration_s);
        let options = Options { threads: 2, without: vec![kind.to_owned()], ..Options::default() };
        let found = diagnose(&problem(&nominal, recorded), &options, &mut |_, _| {});
        // noise may have taken up what moves nothing; what it leaves is located and called neither
        let is_left = found.reason.contains("of no law or noise that was compared");
        let abstains = matches!(found.verdict, Verdict::CannotDecide | Verdict::NotInCatalogue) || is_left;
        assert!(abstains && found.augmented_plant.is_none(), "{name} {kind}: {:?} {}", found.verdict, found.reason);
    }
}

/// A ripple of one lobe beside an end stop, and a torque that decays, come as near the data as the
/// law that acts, with more numbers.
#[test]
fn effects_that_a_one_parameter_law_outside_the_catalogue_explains_as_well_are_withdrawn() {
    let cases: [(Case, &[&str], &str); 2] = [
        (("oscillator", 2.0, "joint_cubic_stiffness", "joint:rail", &[("stiffness", 2e6)]), &[], "joint:rail^3"),
        (("pendulum", 20.0, "sensor_drift", "sensor:angle", &[("rate", 3e-4)]), &["sensor_warm_up"], "time"),
    ];
    for ((name, duration_s, kind, site, values), kin, formula) in cases {
        let nominal = plant(name);
        let recorded = recording(&with_effect(&nominal, kind, site, values), 22, duration_s);
        let without = kin.iter().copied().chain([kind]).map(str::to_owned).collect();
        let asked = problem(&nominal, recorded);
        let found = diagnose(&asked, &Options { threads: 2, without, ..Options::default() }, &mut |_, _| {});
        let reported = format!("one number times {formula} is");
        assert_eq!(found.verdict, Verdict::NotInCatalogue, "{name} {kind}: {}", found.reason);
        assert!(found.reason.contains(&reported), "{name} {kind}: {}", found.reason);
        assert!(found.effects.is_empty() && found.augmented_plant.is_none());
        // with its name in the catalogue it has one
        let found = diagnose(&asked, &Options { threads: 2, ..Options::default() }, &mut |_, _| {});
        assert_eq!(found.effects[0].kind, kind, "{name}: {:?} {}", found.verdict, found.reason);
    }
}

/// The grid of damping ratios has one point: a lightly damped mode has a fifth of its evidence
/// there.
#[test]
fn a_mode_left_out_is_found_at_its_own_damping() {
    let nominal = plant("hub_appendage");
    let hidden = [("mass_ratio", 5e-3), ("frequency", 16.03), ("damping_ratio", 4e-3)];
    let found =
        diagnosed(&nominal, recording(&with_effect(&nominal, "mode_left_out", "mode:bending_2", &hidden), 4, 12.0));
    // a bending mode of the next number is the same to the sensors on the hub
    let is_mode = |kind: &str| ["mode_left_out", "bending_mode_left_out"].contains(&kind);
    let first = &found.effects[0];
    assert!(is_mode(&first.kind), "{:?} {}", found.verdict, found.reason);
    let damping = first.parameters.iter().find(|p| p.name == "damping_ratio").unwrap();
    assert!((damping.value - 4e-3).abs() < 4.0 * damping.sigma && damping.sigma < 3e-3, "{damping:?}");
}

#[test]
fn little_work_says_what_it_omitted_names_nothing_else_and_answers_alike_on_any_number_of_threads() {
    let nominal = plant("pendulum");
    let hidden = with_effect(&nominal, "joint_coulomb", "joint:pivot", &[("force", 8e-3), ("smooth_rate", 1e-3)]);
    let recorded = problem(&nominal, recording(&hidden, 5, 12.0));
    let by = |work_max: f64, threads: usize| {
        diagnose(&recorded, &Options { threads, work_max, ..Options::default() }, &mut |_, _| {})
    };
    let left_out = |found: &Diagnosis| found.notes.iter().any(|note| note.starts_with("to bound the work"));
    let (little, again, enough) = (by(2e7, 1), by(2e7, 3), by(identification::work::NORMAL_WORK, 2));
    assert!(left_out(&little), "{:?}", little.notes);
    assert!(!left_out(&enough), "{:?}", enough.notes);
    assert_eq!(enough.effects[0].kind, "joint_coulomb", "{}", enough.reason);
    assert!(little.effects.iter().all(|own| own.kind == "joint_coulomb"), "{}", little.reason);
    assert_ne!(little.verdict, Verdict::None, "{}", little.reason);
    assert_eq!(format!("{little:?}"), format!("{again:?}"));
}

/// A torque that snaps and decays comes near a reading that is off for a while, where the filter's
/// memory is long.
#[test]
fn a_reading_that_is_off_for_a_while_is_no_torque() {
    let nominal = plant("pendulum");
    let off = [("step", 2e-3), ("begin", 5.71), ("duration", 2.0)];
    let found = diagnosed(&nominal, recording(&with_effect(&nominal, "sensor_step", "sensor:angle", &off), 23, 20.0));
    assert_eq!(found.effects[0].kind, "sensor_step", "{:?} {}", found.verdict, found.reason);
}

/// Plant, duration, effect, site, values.
type Case = (&'static str, f64, &'static str, &'static str, &'static [(&'static str, f64)]);

#[test]
fn single_effects_are_named_with_their_size() {
    let cases: [Case; 4] = [
        ("pendulum", 12.0, "joint_coulomb", "joint:pivot", &[("force", 4e-3)]),
        ("drive_rig", 2.0, "joint_coulomb", "joint:drive", &[("force", 5e-3)]),
        ("drive_rig", 2.0, "joint_gear_ripple", "joint:drive", &[("sine", 3e-3), ("order", 12.0)]),
        // softening: an amplitude below zero
        ("oscillator", 2.0, "joint_cubic_stiffness", "joint:rail", &[("stiffness", -4e4)]),
    ];
    for (name, duration_s, kind, site, values) in cases {
        let nominal = plant(name);
        let truth = with_effect(&nominal, kind, site, values);
        let found = diagnosed(&nominal, recording(&truth, 21, duration_s));
        assert!(
            matches!(found.verdict, Verdict::Named | Verdict::NotSeparable),
            "{name}: {:?} {}",
            found.verdict,
            found.reason
        );
        let first = &found.effects[0];
        let in_set = first.kind == kind || first.rivals.iter().any(|rival| rival.kind == kind && rival.site == site);
        assert!(in_set, "{name}: {first:?}");
        if first.kind == kind {
            let (amplitude, sigma) = (first.parameters[0].value, first.parameters[0].sigma);
            assert!((amplitude - values[0].1).abs() < 4.0 * sigma, "{name}: {amplitude} +- {sigma}");
        }
    }
}

#[test]
fn a_fault_of_a_sensor_is_a_sensor_s() {
    let nominal = plant("drive_rig");
    let truth = with_effect(&nominal, "sensor_scale", "sensor:rate", &[("error", 1e-3)]);
    let found = diagnosed(&nominal, recording(&truth, 31, 2.0));
    let sensor = found.effects.iter().all(|effect| effect.site.starts_with("sensor:"));
    assert!(sensor && !found.effects.is_empty(), "{:?} {}", found.verdict, found.reason);
}

#[test]
fn a_plant_that_cannot_predict_ends_in_cannot_decide() {
    let mut nominal = plant("oscillator");
    let recorded = recording(&nominal, 1, 0.5);
    nominal.sensors.iter_mut().for_each(|sensor| sensor.noise = dynamics::description::Noise::default());
    let found = diagnosed(&nominal, recorded);
    assert_eq!(found.verdict, Verdict::CannotDecide);
    assert!(found.reason.contains("noise"), "{}", found.reason);
}

#[test]
fn a_tone_and_a_short_step_that_no_grid_meets_are_found_where_they_are() {
    let nominal = plant("drive_rig");
    let of = |kind: &str, values: &[(&str, f64)]| {
        let truth = with_effect(&nominal, kind, "sensor:rate", values);
        let found = diagnosed(&nominal, recording(&truth, 31, 1.0));
        assert_eq!(found.verdict, Verdict::Sensor, "{kind}: {}", found.reason);
        assert_eq!((found.effects.len(), found.effects[0].kind.as_str()), (1, kind), "{:?}", found.effects);
        found
    };
    let tone = of("sensor_tone", &[("amplitude", 1e-3), ("frequency", 131.7), ("phase", 0.6)]);
    let frequency = tone.effects[0].parameters.iter().find(|p| p.name == "frequency").expect("free");
    assert!((frequency.value - 131.7).abs() < 4.0 * frequency.sigma, "{frequency:?}");
    let step = of("sensor_step", &[("step", 1.5e-3), ("begin", 0.437), ("duration", 0.171)]);
    // the window of the evidence is that of the fault, within a quarter of its length
    let [begin, end] = step.located[0].time;
    assert!((begin - 0.437).abs() < 0.05 && (end - 0.608).abs() < 0.05, "{begin} {end}");
}

/// The experiment once more: physics recurs, what happened once does not.
#[test]
fn the_experiment_once_more_confirms_physics_and_rejects_what_occurred_once() {
    let nominal = plant("drive_rig");
    let truth = with_effect(&nominal, "joint_coulomb", "joint:drive", &[("force", 5e-3)]);
    let again = |repeated: &Plant| {
        let held_out = Some(problem(&nominal, recording(repeated, 52, 2.0)));
        let options = Options { threads: 2, held_out, ..Options::default() };
        diagnose(&problem(&nominal, recording(&truth, 51, 2.0)), &options, &mut |_, _| {})
    };
    let physics = again(&truth);
    assert!(matches!(physics.verdict, Verdict::Named | Verdict::NotSeparable), "{}", physics.reason);
    assert_eq!(physics.effects[0].status, Status::Confirmed, "{}", physics.reason);
    let once = again(&nominal);
    assert!(once.effects.is_empty() && once.augmented_plant.is_none(), "{:?} {}", once.verdict, once.reason);
}

/// `x` along a track, by a camera; nothing pushes it.
fn glider(rate: &str) -> Plant {
    let text = format!(
        r#"
format = 1
name = "coast"
about = "Glider on an air track"
space = "planar"

[[body]]
name = "glider"
mass = "0.4 kg"
inertia = "1e-3 kg*m^2"
joint = {{ kind = "prismatic", name = "track", axis = "x" }}

[[sensor]]
name = "x"
kind = "encoder"
joint = "track"
noise = "15 mm"

[initial]
"joint:track" = {{ position = {{ value = 0, sigma = "0.5 m" }}, rate = {{ value = "{rate}", sigma = "1 m/s" }} }}

[simulation]
duration = "2.5 s"
period = "8 ms"
"#
    );
    plant_file::parse("coast.toml", &text).unwrap().plant
}

#[test]
fn what_coasts_or_rests_and_is_not_pushed_lacks_nothing() {
    for (rate, seed) in [("0 m/s", 1), ("0 m/s", 2), ("0 m/s", 3), ("2 m/s", 4), ("2 m/s", 5), ("2 m/s", 6)] {
        let nominal = glider(rate);
        let found = diagnosed(&nominal, recording(&nominal, seed, 2.5));
        // that it rests where its file allows a metre a second is some evidence of friction
        let is_rest = found.effects.iter().all(|own| rate == "0 m/s" && own.kind == "joint_coulomb");
        assert!(is_rest, "{rate} {seed}: {}", found.reason);
    }
}

#[test]
fn a_constant_channel_or_a_handful_of_samples_is_insufficient_data() {
    let nominal = plant("drive_rig");
    let mut stuck = recording(&nominal, 3, 1.0);
    let rate = stuck.channels.iter_mut().find(|channel| channel.name == "rate").expect("the rig reads its rate");
    rate.value.fill(0.25);
    let found = diagnosed(&nominal, stuck);
    assert!(found.verdict == Verdict::CannotDecide && found.reason.contains("'rate' reads 0.25"), "{}", found.reason);
    let few = recording(&nominal, 3, 4.5 * nominal.simulation.period_s);
    let found = diagnosed(&nominal, few);
    assert!(found.verdict == Verdict::CannotDecide && found.reason.contains("too few"), "{}", found.reason);
}

#[test]
fn nothing_is_missing_is_not_said_beside_an_outlier() {
    let nominal = plant("pendulum");
    let sigma = {
        let (dynamics::description::Noise::PerSample(s) | dynamics::description::Noise::Density(s)) =
            &nominal.sensors[0].noise;
        s.value
    };
    let asked = |glitch: f64| {
        let mut recorded = recording(&nominal, 21, 12.0);
        let value = &mut recorded.channels.iter_mut().find(|c| c.name == "angle").expect("it reads its angle").value;
        let middle = value.len() / 2;
        value[middle] += glitch * sigma;
        diagnosed(&nominal, recorded)
    };
    assert_eq!(asked(0.0).verdict, Verdict::None);
    // one sample moves the size of the noise by next to nothing
    let found = asked(9.0);
    assert!(found.verdict == Verdict::NoiseModel && found.reason.contains("outliers"), "{}", found.reason);
    assert!(found.located.iter().any(|place| place.channel == "angle"), "{:?}", found.located);
}

/// A short record leaves the friction wide, and what this moves in a long one is no memory of the
/// noise.
#[test]
fn what_held_out_data_correct_of_the_parameters_takes_nothing_of_what_they_say_of_the_laws() {
    let nominal = plant("oscillator");
    for seed in 51..=54 {
        let truth =
            with_effect(&off_priors(&nominal, seed), "joint_quadratic_damping", "joint:rail", &[("damping", 30.0)]);
        let [fitted, other] =
            [(seed, 0.8), (seed + 50, 4.0)].map(|(seed, s)| problem(&nominal, recording(&truth, seed, s)));
        let options = Options { threads: 2, held_out: Some(other), ..Options::default() };
        let found = diagnose(&fitted, &options, &mut |_, _| {});
        let of_cubic = |effect: &crate::diagnose::EffectReport| {
            let rivals = effect.rivals.iter().map(|rival| (&rival.kind, rival.probability));
            let all = rivals.chain([(&effect.kind, effect.probability)]);
            all.filter(|(kind, _)| *kind == "joint_cubic_damping").map(|(_, p)| p).sum::<f64>()
        };
        let quadratic = ["joint_quadratic_damping", "quadratic_drag"];
        assert!(found.effects.iter().any(|effect| quadratic.contains(&&*effect.kind)), "{seed} {}", found.reason);
        assert!(found.effects.iter().all(|effect| of_cubic(effect) < 0.1), "{seed} {}", found.reason);
    }
}
