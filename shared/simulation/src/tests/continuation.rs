//! Checkpoints, segments, and independence of streams.

use super::plants::{self, q};
use crate::oracle::arm::ArmNoise;
use crate::{Sample, SimulationError, Simulator, SimulatorState, record};
use dynamics::description::{Initial, InitialValue, Noise, Plant, Reading, Segment, SensorKind, SignalKind};

/// The arm with everything that has a memory: lag, delay, jitter, slow, fast and mean channels.
fn eventful_arm() -> Plant {
    let mut plant = plants::arm(&ArmNoise::default());
    plant.simulation.jitter_s = 1e-3;
    let gyro = || SensorKind::Gyro { body: "base".to_owned(), axis: plants::Z };
    let mut lagged = plants::sensor("lagged", gyro());
    lagged.low_pass_hz = Some(q(5.0));
    lagged.delay_s = q(0.0137);
    let mut slow = plants::sensor("slow", gyro());
    slow.period_s = Some(q(0.05));
    slow.noise = Noise::PerSample(q(1e-3));
    let mut fast = plants::sensor("fast", gyro());
    fast.period_s = Some(q(0.0025));
    fast.noise = Noise::Density(q(1e-4));
    let mut mean = plants::sensor("mean", gyro());
    mean.period_s = Some(q(0.03));
    mean.reading = Reading::Mean;
    plant.sensors.extend([lagged, slow, fast, mean]);
    plant.controllers[0].rate_sensor = Some("joint1.rate".to_owned());
    plant.sensors[2].delay_s = q(0.004); // joint1.rate, fed back
    plant
}

fn rows(simulator: &mut Simulator, count: usize) -> Vec<Sample> {
    (0..count).flat_map(|_| simulator.step().samples.clone()).collect()
}

fn bits(samples: &[Sample]) -> Vec<(usize, u64, u64)> {
    samples.iter().map(|sample| (sample.channel, sample.time_s.to_bits(), sample.value.to_bits())).collect()
}

#[test]
fn a_checkpoint_continues_with_the_same_bits() {
    let plant = eventful_arm();
    let mut undisturbed = Simulator::new(&plant, 3, "arm").unwrap();
    rows(&mut undisturbed, 137);
    undisturbed.set_excited(false);
    rows(&mut undisturbed, 10);
    let bytes = postcard::to_allocvec(&undisturbed.state()).unwrap();
    let mut restarted = Simulator::new(&plant, 3, "arm").unwrap();
    rows(&mut restarted, 29); // must leave no trace
    restarted.restore(&postcard::from_bytes::<SimulatorState>(&bytes).unwrap()).unwrap();
    for simulator in [&mut undisturbed, &mut restarted] {
        simulator.set_excited(true);
    }
    let (expected, got) = (rows(&mut undisturbed, 200), rows(&mut restarted, 200));
    assert!(expected.len() > 200 * 7);
    assert_eq!(bits(&expected), bits(&got));
    assert_eq!(
        postcard::to_allocvec(&undisturbed.state()).unwrap(),
        postcard::to_allocvec(&restarted.state()).unwrap()
    );
}

#[test]
fn a_checkpoint_of_another_plant_is_refused() {
    let mut arm = Simulator::new(&plants::arm(&ArmNoise::none()), 0, "arm").unwrap();
    let cart = Simulator::new(&plants::cart(vec![]), 0, "cart").unwrap();
    let bytes = postcard::to_allocvec(&cart.state()).unwrap();
    let of_cart: SimulatorState = postcard::from_bytes(&bytes).unwrap();
    assert!(matches!(arm.restore(&of_cart), Err(SimulationError::ForeignState { .. })));
}

/// The tenth sensor is slow, lagged and jittered, so that its reading needs states between those of
/// all others.
#[test]
fn adding_a_sensor_changes_no_other_channel() {
    let plain = plants::arm(&ArmNoise::default());
    let full = eventful_arm();
    let mut more = plain.clone();
    more.sensors.extend(full.sensors[7..].iter().cloned());
    let run = |plant: &Plant| rows(&mut Simulator::new(plant, 1, "arm").unwrap(), 300);
    let (alone, together) = (run(&plain), run(&more));
    let others: Vec<Sample> = together.into_iter().filter(|sample| sample.channel < 7).collect();
    assert_eq!(bits(&alone), bits(&others));
}

#[test]
fn another_seed_is_another_noise() {
    let plant = plants::arm(&ArmNoise::default());
    let run = |seed| rows(&mut Simulator::new(&plant, seed, "arm").unwrap(), 2);
    assert!(run(1).iter().zip(&run(2)).all(|(a, b)| a.value != b.value || a.channel == 1 || a.channel == 4));
    assert_eq!(bits(&run(1)), bits(&run(1)));
}

#[test]
fn a_simulator_that_draws_from_other_streams_is_the_one_built_with_them() {
    let mut plant = eventful_arm();
    plant.actuators[0].noise = q(0.01);
    let mut built = Simulator::new(&plant, 3, "arm.7").unwrap();
    let mut renamed = Simulator::new(&plant, 1, "").unwrap();
    renamed.draw_from(3, "arm.7");
    let (expected, got) = (rows(&mut built, 50), rows(&mut renamed, 50));
    assert_eq!(bits(&expected), bits(&got));
    let other = rows(&mut Simulator::new(&plant, 1, "").unwrap(), 50);
    assert_ne!(bits(&expected), bits(&other));
}

#[test]
fn segments_start_in_their_own_state_and_do_not_repeat_noise() {
    let mut plant = plants::cart(plants::always(SignalKind::Constant { value: q(0.0) }));
    plant.sensors[0].noise = Noise::PerSample(q(1e-3));
    let segment = |name: &str, begin, end: Option<f64>, at: f64, rate: f64| Segment {
        name: name.to_owned(),
        begin_s: q(begin),
        end_s: end.map(q),
        initial: Initial {
            values: vec![InitialValue { coordinate: "joint:cart".to_owned(), position: q(at), rate: q(rate) }],
            ..Initial::default()
        },
    };
    plant.segments = vec![segment("a", 1.0, Some(2.0), 3.0, 0.5), segment("b", 4.0, None, -1.0, 0.0)];
    let recording = record(&plant, 7, 5.0, &mut |_| {}).unwrap();
    let displacement = recording.channels.iter().find(|channel| channel.name == "displacement").unwrap();
    assert_eq!(displacement.time_s.len(), 200);
    let mut errors = Vec::new();
    for (t, value) in displacement.time_s.iter().zip(&displacement.value) {
        let truth = if *t < 2.5 { 3.0 + 0.5 * (t - 1.0) } else { -1.0 };
        assert!((value - truth).abs() < 6e-3, "{t}: {value}"); // six sigma
        errors.push(value - truth);
    }
    let correlation: f64 = errors[..100].iter().zip(&errors[100..]).map(|(a, b)| a * b).sum::<f64>() / 1e-6 / 10.0;
    assert!(correlation.abs() < 4.5, "{correlation}"); // standard normal under independence
}

#[test]
fn a_record_holds_recorded_commands_and_all_sensors() {
    let mut plant = plants::arm(&ArmNoise::default());
    plant.actuators[1].recorded = false;
    let mut shares = Vec::new();
    let recording = record(&plant, 0, 3.0, &mut |share| shares.push(share)).unwrap();
    assert_eq!(recording.channels.len(), 1 + 7);
    assert!(recording.channels.iter().all(|channel| channel.value.len() == 300 && channel.time_s.len() == 300));
    assert_eq!(recording.channels[0].name, "joint1");
    assert_eq!(recording.name, plant.name);
    assert!(recording.channels.iter().all(|channel| channel.role == channels::Role::Unknown));
    assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]) && shares.last() == Some(&1.0));
}
