//! Diagnoses by evidence.

use super::noise::{Linearly, NoisePrior};
use super::*;
use crate::diagnose::Verdict;
use crate::synthetic::{coloured, plant, recording, with_effect};
use channels::Recording;
use dynamics::description::{Actuator, ActuatorKind, Plant, Quantity};

fn diagnosed(nominal: &Plant, recorded: Recording, held_out: Option<Recording>) -> Diagnosis {
    let problem = |recorded: Recording| Problem::new(nominal, &[recorded], &[]).unwrap();
    let options = Options { held_out: held_out.map(&problem), ..Options::default() };
    diagnose(&problem(recorded), &options, &mut |_, _| {})
}

#[test]
fn a_complete_plant_lacks_nothing() {
    let nominal = plant("pendulum");
    let found = diagnosed(&nominal, recording(&nominal, 5, 5.0), Some(recording(&nominal, 6, 4.0)));
    assert_eq!(found.verdict, Verdict::None, "{}", found.reason);
    assert!(found.effects.is_empty() && !found.detection_limits.is_empty());
}

#[test]
fn dry_friction_is_named_alone_and_a_second_recording_confirms_it() {
    let nominal = plant("pendulum");
    let mut truth = nominal.clone();
    truth.add_effect("joint_coulomb", &"joint:pivot".parse().unwrap(), &[("force", 0.05)]).unwrap();
    let found = diagnosed(&nominal, recording(&truth, 5, 5.0), Some(recording(&truth, 6, 5.0)));
    let names: Vec<_> = found.effects.iter().map(|own| (&*own.kind, own.probability, own.status)).collect();
    assert_eq!(found.verdict, Verdict::Named, "{} {names:?}", found.reason);
    assert!(names.len() == 1 && names[0].0 == "joint_coulomb", "{names:?}");
    // who builds the plant again needs the rate over which the sign was smoothed
    assert!(found.effects[0].kept.iter().any(|(name, _)| name == "smooth_rate"), "{:?}", found.effects[0].kept);
    let force = &found.effects[0].parameters[0];
    assert!((force.value - 0.05).abs() < 3.0 * force.sigma, "{force:?}");
    // over a horizon it takes away all that noise does not explain
    assert!(found.relevance_percent.is_some_and(|share| share > 95.0), "{:?}", found.relevance_percent);
    let confirmed = found.effects[0].status;
    assert_eq!(confirmed, identification::held_out::Status::Confirmed);
}

#[test]
fn noise_that_remembers_is_noise_and_no_physics() {
    let nominal = plant("pendulum");
    let found = diagnosed(&nominal, coloured(&nominal, 5, 5.0, 0.8), None);
    assert_eq!(found.verdict, Verdict::NoiseModel, "{}", found.reason);
    assert!(found.effects.is_empty());
}

/// The pendulum of `plant`, pushed by a white torque.
fn pushed(nominal: &Plant) -> Plant {
    let mut truth = nominal.clone();
    truth.actuators.push(Actuator {
        name: "push".to_owned(),
        kind: ActuatorKind::JointTorque { joint: "pivot".to_owned() },
        command: Vec::new(),
        noise: Quantity::known(0.02),
        recorded: false,
        ..plant("oscillator").actuators[0].clone()
    });
    truth
}

#[test]
fn a_disturbance_that_nobody_stated_pays_for_itself_and_is_no_physics() {
    let nominal = plant("pendulum");
    let found = diagnosed(&nominal, recording(&pushed(&nominal), 5, 8.0), None);
    assert_eq!(found.verdict, Verdict::NoiseModel, "{}", found.reason);
    assert!(found.effects.is_empty() && found.reason.contains("disturbance of pivot"), "{}", found.reason);
}

/// It turns freely.
fn rotor() -> Plant {
    let mut plant = plant("pendulum");
    plant.environment.gravity_m_s2 = [0.0; 3].map(Quantity::known);
    plant
}

/// Nothing else drives it, and a disturbance would take all of it.
#[test]
fn a_constant_torque_on_a_body_that_coasts_is_found() {
    let nominal = rotor();
    let truth = with_effect(&nominal, "joint_torque_bias", "joint:pivot", &[("force", 0.02)]);
    let found = diagnosed(&nominal, recording(&truth, 5, 8.0), Some(recording(&truth, 6, 8.0)));
    let is_physics = found.effects.first().is_some_and(|own| !own.site.starts_with("sensor"));
    assert!(is_physics, "{:?} {}", found.verdict, found.reason);
}

/// A floor that the first samples do not show lets a momentum wander, which hides what lasts.
#[test]
fn floors_of_disturbances_hide_no_force_that_lasts() {
    let nominal = rotor();
    let problem = Problem::new(&nominal, &[recording(&nominal, 5, 60.0)], &[]).unwrap();
    let sigma = |share: Option<f64>| {
        let mut session = EstimationSession::new(&problem, 1).unwrap();
        match share {
            Some(share) => session.noise.input_sigma.iter_mut().for_each(|sigma| *sigma *= share),
            None => session.lower_floors(),
        }
        let stated = crate::diagnose::nominal(&session, &Options::default()).unwrap();
        let model = bare(&session, &stated).unwrap();
        let screened = screen::screen(Ground { session: &session }, &model, &[]).unwrap();
        let is_it = |own: &&screen::Looked| own.candidate.effect.kind == "joint_torque_bias";
        screened.looked.iter().find(is_it).unwrap().sigma
    };
    let [lowered, none, whole] = [None, Some(1e-3), Some(1.0)].map(sigma);
    assert!(lowered < 1.06 * none, "{lowered} {none}");
    assert!(whole > 1.3 * none, "{whole} {none}");
}

/// Far from the mode the linear problem promises what no fit confirms.
#[test]
fn what_a_model_is_worth_stands_when_it_is_fitted_again_from_its_own_end() {
    about_falling_ball(|session, alone| {
        let ground = Ground { session };
        let disturbed = disturbed::of_disturbances(ground, alone).into_iter().filter_map(|own| {
            let begin = model::Begin { noise: &own.noise, ..alone.begin() };
            model::fitted(ground, &own.set, begin, f64::INFINITY)
        });
        for first in disturbed.chain([alone.clone()]) {
            let (start, theta) = (first.start.clone(), &first.fit.theta[..]);
            let again =
                model::settled(ground, &first.set, first.problem.clone(), (start, theta), &first.noise).unwrap();
            let changed = again.log_marginal - first.log_marginal;
            assert!(changed.abs() < 0.1, "{}: {changed}", first.key());
        }
    });
}

#[test]
fn dry_friction_is_named_where_a_load_is_read_along_an_imposed_motion() {
    let nominal = plant("damper_rig");
    let truth = with_effect(&nominal, "joint_coulomb", "joint:stroke", &[("force", 20.0)]);
    let found = diagnosed(&nominal, recording(&truth, 5, 4.0), Some(recording(&truth, 6, 4.0)));
    let names: Vec<_> = found.effects.iter().map(|own| (&*own.kind, own.probability)).collect();
    assert!(matches!(names[..], [("joint_coulomb", _)]), "{names:?} {}", found.reason);
}

/// Every command stands one row too late in the log.
#[test]
fn commands_that_are_logged_late_are_a_matter_of_timing_and_no_physics() {
    let nominal = plant("oscillator");
    let late = |seed: u64| {
        let mut recorded = recording(&nominal, seed, 4.0);
        let command = recorded.channels.iter_mut().find(|channel| channel.name == "shaker").unwrap();
        command.value.rotate_right(1);
        command.value[0] = 0.0;
        recorded
    };
    let found = diagnosed(&nominal, late(5), Some(late(6)));
    assert_eq!(found.verdict, Verdict::InputTiming, "{}", found.reason);
    assert!(found.effects.is_empty());
    let [timing] = &found.input_timing[..] else { panic!("{:?}", found.input_timing) };
    assert!((timing.shift_samples + 1.0).abs() < 0.3 && timing.probability > 0.9, "{timing:?}");
}

/// The plant alone on a recording, with what `look` makes of it.
fn about<T>(nominal: &Plant, recorded: Recording, look: impl Fn(&EstimationSession<'_>, &Model) -> T) -> T {
    let problem = Problem::new(nominal, &[recorded], &[]).unwrap();
    let session = EstimationSession::new(&problem, 1).unwrap();
    let model = bare(&session, &super::nominal(&session, &Options::default()).unwrap()).unwrap();
    look(&session, &model)
}

fn about_bare<T>(recorded: Recording, look: impl Fn(&EstimationSession<'_>, &Model) -> T) -> T {
    about(&plant("oscillator"), recorded, look)
}

/// Free fall of a ball that the air slows, by a camera whose scale is uncertain.
fn about_falling_ball(look: impl Fn(&EstimationSession<'_>, &Model)) {
    let nominal = plant("ball_drop");
    let truth = with_effect(&nominal, "quadratic_drag", "body:ball", &[("coefficient", 0.008)]);
    about(&nominal, recording(&truth, 5, 3.0), look);
}

#[test]
fn channels_whose_noise_remembers_are_proposed_together_and_white_ones_are_not() {
    let most = |recorded: Recording| {
        about_bare(recorded, |session, model| {
            let ground = Ground { session };
            let screened = screen::screen(ground, model, &[]).unwrap();
            let (list, _) = propose::proposals(ground, model, &screened, 4.0);
            let is_colour = |own: &&hypothesis::Hypothesis| matches!(own, hypothesis::Hypothesis::Coloured(_));
            list.iter().map(|own| own.set.iter().filter(is_colour).count()).max().unwrap_or(0)
        })
    };
    let nominal = plant("oscillator");
    assert_eq!([most(coloured(&nominal, 5, 4.0, 0.8)), most(recording(&nominal, 5, 4.0))], [2, 0]);
}

/// A disturbance that was taken for three times its size leaves the readings too little.
#[test]
fn what_explains_a_distance_is_readings_beside_disturbances_of_their_stated_size() {
    about_bare(recording(&plant("oscillator"), 7, 4.0), |session, model| {
        let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
        let linear = Linearly { session, linearised, theta, extra: &[], room: &[] };
        let mut taken = session.noise.clone();
        taken.input_sigma.iter_mut().for_each(|sigma| *sigma *= 3.0);
        taken.sensor_sigma.iter_mut().for_each(|sigma| *sigma *= 0.8);
        let own = predict::explaining(&linear, &taken, NoisePrior::new(session, &[])).unwrap();
        assert!(own.input_sigma.iter().zip(&session.noise.input_sigma).all(|(own, stated)| own <= stated), "{own:?}");
        for (own, stated) in own.sensor_sigma.iter().zip(&session.noise.sensor_sigma) {
            assert!((0.9..1.0 + 1e-9).contains(&(own / stated)), "{own} of {stated}");
        }
        let within = predict::explaining(&linear, &session.noise, NoisePrior::new(session, &[])).unwrap();
        assert_eq!(within.sensor_sigma, session.noise.sensor_sigma);
    });
}

/// Readings of a height hardly show a torque about an axis that nothing reads.
#[test]
fn a_push_that_readings_hardly_show_is_no_larger_than_what_drives_the_record() {
    about_falling_ball(|session, alone| {
        let screened = screen::screen(Ground { session }, alone, &[]).unwrap();
        let ball = &alone.problem.plant.bodies[0];
        let (mass, inertia) = (ball.mass_kg.value, ball.inertia_com_kg_m2[2].value);
        // the torque that does in a second the work of the weight on the mass: m g² = τ²/J
        let weight = 9.81 * mass;
        for (kind, most) in [("constant_torque", weight * (inertia / mass).sqrt()), ("constant_force", weight)] {
            let is_it = |own: &&screen::Rated| own.column.candidate.effect.kind == kind;
            let scale = screened.rated.iter().find(is_it).unwrap().part.scale;
            assert!(scale < 1.5 * most, "{kind}: {scale} of {most}");
        }
    });
}

/// Of laws without a name those of one number compete with names of several.
#[test]
fn a_law_has_the_numbers_that_a_fit_or_a_scan_picks() {
    let nominal = plant("pendulum");
    about(&nominal, recording(&nominal, 5, 4.0), |session, alone| {
        let screened = screen::screen(Ground { session }, alone, &[]).unwrap();
        let numbers = |kind: &str| {
            let is_it = |own: &&screen::Rated| own.column.candidate.effect.kind == kind;
            screened.rated.iter().find(is_it).map(|own| own.column.candidate.numbers())
        };
        // a sign that is smoothed has no number of its own
        let counted = ["joint_coulomb", "sensor_drift", "joint_stribeck", "sensor_step"].map(numbers);
        assert_eq!(counted, [Some(1), Some(1), Some(2), Some(3)]);
    });
}

/// About a motion that lacks dry friction which holds, friction's linear response may be nothing.
#[test]
fn where_a_disturbance_has_taken_up_something_a_plain_law_of_each_family_is_fitted_at_its_joint() {
    let nominal = plant("pendulum");
    about(&nominal, recording(&pushed(&nominal), 5, 4.0), |session, alone| {
        let ground = Ground { session };
        let plain = ["joint_coulomb", "joint_viscous", "joint_stiffness"];
        let proposed = |model: &Model| {
            let screened = screen::screen(ground, model, &[]).unwrap();
            let (list, _) = propose::proposals(ground, model, &screened, 4.0);
            let names: Vec<String> = list.iter().map(|own| model::key(&own.set, &model.problem)).collect();
            plain.iter().filter(|kind| names.contains(&format!("{kind}@joint:pivot"))).count()
        };
        let disturbed = disturbed::of_disturbances(ground, alone).into_iter().next().unwrap();
        let begin = model::Begin { noise: &disturbed.noise, ..alone.begin() };
        let disturbed = model::fitted(ground, &disturbed.set, begin, f64::INFINITY).unwrap();
        assert_eq!(proposed(&disturbed), plain.len());
        assert!(proposed(alone) < plain.len());
    });
}

/// Accelerometers that drift at once have as many faults, and no group.
#[test]
fn sensors_fail_one_by_one() {
    let nominal = plant("hub_appendage");
    let kind = std::mem::discriminant(&nominal.sensors[0].kind);
    let alike = nominal.sensors.iter().filter(|sensor| std::mem::discriminant(&sensor.kind) == kind);
    let names: Vec<String> = alike.map(|sensor| format!("sensor:{}", sensor.name)).collect();
    assert!(names.len() > 1);
    let mut truth = nominal.clone();
    // no motion of the hub does the same to all
    for (name, rate) in names.iter().zip([0.05, -0.05].into_iter().cycle()) {
        truth.add_effect("sensor_drift", &name.parse().unwrap(), &[("rate", rate)]).unwrap();
    }
    about(&nominal, recording(&truth, 5, 4.0), |session, model| {
        let ground = Ground { session };
        let screened = screen::screen(ground, model, &[]).unwrap();
        let (list, _) = propose::proposals(ground, model, &screened, 4.0);
        let is_group = |own: &&hypothesis::Hypothesis| own.parts().len() > 1 && own.class() == decide::Class::Sensor;
        assert!(list.iter().flat_map(|own| &own.set).filter(is_group).count() == 0);
    });
}
