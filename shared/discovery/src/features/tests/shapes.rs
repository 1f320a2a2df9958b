//! Shapes as evidence.

use super::*;
use dynamics::description::{Quantity, SensorKind};
use nalgebra::Complex;

/// Places of the sensors, in lengths of the beam.
const PLACES: [f64; 6] = [0.2, 0.35, 0.5, 0.65, 0.8, 1.0];
/// √ of the beam's mass, from the file's shape at the tip: 2 over it.
const ROOT_MASS: f64 = 2.0 / 1.605_68;

/// Shape of a clamped beam with eigenvalue `z` whose end carries no moment, whatever mass it
/// carries.
fn clamped(z: f64, x: f64) -> f64 {
    let c = (libm::cosh(z) + libm::cos(z)) / (libm::sinh(z) + libm::sin(z));
    libm::cosh(z * x) - libm::cos(z * x) - c * (libm::sinh(z * x) - libm::sin(z * x))
}

/// The cantilever with an accelerometer at each place: `a0` … `a5`.
fn instrumented() -> Plant {
    let mut plant = cantilever();
    let free = roots(|z| 1.0 / libm::cosh(z) + libm::cos(z), 10);
    let like = plant.sensors.pop().unwrap();
    for (k, x) in PLACES.iter().enumerate() {
        // the last one sits at the tip, which the file has
        let point = if *x == 1.0 { "tip".to_owned() } else { format!("p{k}") };
        let at = [0.759 * x, 0.0, 0.0].map(Quantity::known);
        let new = plant.appendages[0].points.iter().all(|known| known.0 != point);
        if new {
            plant.appendages[0].points.push((point.clone(), at));
        }
        for (mode, z) in plant.appendages[0].modes.iter_mut().zip(&free).filter(|_| new) {
            mode.shape_per_sqrt_kg.push([0.0, clamped(*z, *x) / ROOT_MASS, 0.0].map(Quantity::known));
        }
        let mut sensor = like.clone();
        sensor.name = format!("a{k}");
        if let SensorKind::Accelerometer { point: place, .. } = &mut sensor.kind {
            *place = Some(("beam".to_owned(), point));
        }
        plant.sensors.push(sensor);
    }
    plant
}

/// Modes of frequency and shape, each with noise; every shape with a size and phase of its own.
fn noisy(modes: &[(f64, Vec<f64>)], relative: f64, of_shape: f64, seed: u64) -> Vec<MeasuredMode> {
    let mut draw = Noise::new(seed);
    let mode = |(frequency_hz, shape): &(f64, Vec<f64>)| {
        let largest = shape.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let turn = Complex::new(draw.normal(), draw.normal());
        let mut at = |(k, x): (usize, &f64)| {
            let noise = Complex::new(of_shape * draw.normal(), of_shape * draw.normal());
            let (value, sigma) = ((Complex::new(x / largest, 0.0) + noise) * turn, of_shape * turn.norm());
            ShapeComponent { channel: format!("a{k}"), value, sigma }
        };
        let shape = shape.iter().enumerate().map(&mut at).collect();
        MeasuredMode {
            frequency_hz: frequency_hz * (1.0 + relative * draw.normal()),
            sigma_hz: relative * frequency_hz,
            damping_ratio: f64::NAN,
            damping_sigma: f64::NAN,
            prominence: 1.0,
            shape,
        }
    };
    let mut list: Vec<MeasuredMode> = modes.iter().map(mode).collect();
    list.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    list
}

/// Closed form of the first seven modes with a mass at the end.
fn beam_with_tip_mass(mu: f64) -> Vec<(f64, Vec<f64>)> {
    let z = with_tip_mass(mu);
    hz(&z).into_iter().zip(&z).map(|(f, z)| (f, PLACES.iter().map(|x| clamped(*z, *x)).collect())).collect()
}

fn asked(measured: &[MeasuredMode]) -> Diagnosis {
    diagnose_modes(&instrumented(), "modes", measured, &FeatureOptions::default())
}

#[test]
fn the_plants_shapes_at_its_sensors_are_the_closed_form() {
    let channels: Vec<String> = (0..PLACES.len()).map(|k| format!("a{k}")).collect();
    let modes = plant_modes(&instrumented(), &channels).unwrap();
    for (mode, (_, shape)) in modes.iter().zip(beam_with_tip_mass(0.0)) {
        let size: Complex<f64> = mode.shape[5] / shape[5];
        for (found, expected) in mode.shape.iter().zip(&shape) {
            assert!((found / size - expected).norm() < 1e-5, "{mode:?}"); // six digits in the file
        }
    }
}

#[test]
fn a_plant_whose_shapes_are_right_is_left_alone() {
    for seed in 0..8 {
        let found = asked(&noisy(&beam_with_tip_mass(0.0), 2e-3, 0.02, seed));
        assert_eq!(found.verdict, Verdict::None, "seed {seed}: {}", found.reason);
        assert!(found.notes.iter().any(|note| note.contains("shapes over 6 sensors, MAC")), "{:?}", found.notes);
    }
}

#[test]
fn shapes_tell_the_tip_mass_from_the_root_spring_that_has_its_spectrum() {
    let mu = 0.08;
    let found = asked(&noisy(&beam_with_tip_mass(mu), 2e-3, 5e-3, 6));
    assert_eq!(found.verdict, Verdict::Named, "{} {:?}", found.reason, found.effects);
    let first = &found.effects[0];
    assert_eq!((first.kind.as_str(), first.site.as_str()), ("point_mass", "appendage:beam.tip"), "{}", found.reason);
    let mass = &first.parameters[0];
    // ten modes make a beam with a mass a little too stiff: some per cent of the mass
    assert!((mass.value - mu * ROOT_MASS * ROOT_MASS).abs() < 0.05 * mass.value, "{mass:?}");
    let spring = first.rivals.iter().find(|rival| rival.kind == "root_rotation_spring");
    assert!(spring.is_none_or(|rival| rival.probability < 1e-3), "{:?}", first.rivals);
}

#[test]
fn modes_whose_frequencies_have_changed_places_are_paired_by_their_shapes() {
    let mut plant = instrumented();
    // two modes side by side, as bending and torsion of a panel are
    plant.appendages[0].modes[2].frequency_hz.value = 50.0;
    let mut modes = beam_with_tip_mass(0.0);
    (modes[1].0, modes[2].0) = (45.5924 * 1.25, 50.0);
    let found = diagnose_modes(&plant, "modes", &noisy(&modes, 1e-3, 0.02, 9), &FeatureOptions::default());
    assert_eq!(found.effects.len(), 1, "{}", found.reason);
    let effect = &found.effects[0];
    assert_eq!(
        (effect.kind.as_str(), effect.site.as_str()),
        ("frequency_of_one_mode", "mode:bending_2"),
        "{}",
        found.reason
    );
    let factor = &effect.parameters[0];
    assert!((factor.value - 1.25).abs() < 5.0 * factor.sigma, "{factor:?}");
}
