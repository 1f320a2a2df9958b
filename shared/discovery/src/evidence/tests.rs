//! Diagnoses by evidence.

use super::*;
use crate::diagnose::Verdict;
use crate::synthetic::{coloured, plant, recording};
use channels::Recording;
use dynamics::description::Plant;

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

/// The plant alone on a recording of four seconds, with what `look` makes of it.
fn about_bare<T>(recorded: Recording, look: impl Fn(&EstimationSession<'_>, &Model) -> T) -> T {
    let problem = Problem::new(&plant("oscillator"), &[recorded], &[]).unwrap();
    let session = EstimationSession::new(&problem, 1).unwrap();
    let model = bare(&session, &nominal(&session, &Options::default()).unwrap()).unwrap();
    look(&session, &model)
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
        let own = predict::explaining(&linear, &taken, NoisePrior::new(session, Vec::new())).unwrap();
        assert!(own.input_sigma.iter().zip(&session.noise.input_sigma).all(|(own, stated)| own <= stated), "{own:?}");
        for (own, stated) in own.sensor_sigma.iter().zip(&session.noise.sensor_sigma) {
            assert!((0.9..1.0 + 1e-9).contains(&(own / stated)), "{own} of {stated}");
        }
        let within = predict::explaining(&linear, &session.noise, NoisePrior::new(session, Vec::new())).unwrap();
        assert_eq!(within.sensor_sigma, session.noise.sensor_sigma);
    });
}
