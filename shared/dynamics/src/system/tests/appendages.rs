//! Against BP3.

use super::*;
use simulation::oracle::appendage::AppendageParameters;

/// Hub on a hinge with the benchmark's beam along x; the tip has an accelerometer across the beam.
fn hub_and_beam() -> Plant {
    let design = AppendageParameters::design();
    let hinge = joint("hub", JointKind::Revolute { axis: Z }, [0.0; 3]);
    let locked = design.hub_locked_modes();
    let beam = design.beam;
    let modes = design.coupling().into_iter().enumerate().map(|(k, coupling)| {
        let shape = beam.mode(k + 1).shape(beam.length_m);
        mode(&format!("beam{}", k + 1), locked[k].0, locked[k].1, [0.0; 3], [0.0, 0.0, coupling], [0.0, shape, 0.0])
    });
    let tip = [design.root_radius_m + beam.length_m, 0.0, 0.0];
    let accelerometer = SensorKind::Accelerometer {
        body: "hub".to_owned(),
        position_m: three([0.0; 3]),
        axis: [0.0, 1.0, 0.0],
        point: Some(("beam".to_owned(), "tip".to_owned())),
    };
    Plant {
        bodies: vec![body("hub", None, hinge, 0.0, [0.0; 3], [0.0, 0.0, design.total_inertia_kg_m2()])],
        appendages: vec![appendage("beam", "hub", tip, modes.collect())],
        actuators: vec![torque_of("hub")],
        sensors: vec![sensor("tip", accelerometer)],
        ..Plant::default()
    }
}

#[test]
fn modes_of_the_benchmark_hub_are_the_published_ones() {
    let system = System::new(&hub_and_beam()).unwrap();
    let modes = system.modes(&mut Workspace::new(&system), 0.0, &[0.0; 6], &[0.0]);
    let own = AppendageParameters::design().modes();
    assert_eq!((modes.modes.len(), modes.zeros), (2, 2));
    for (k, (frequency, label)) in [(1.56110, "mode:beam1"), (6.48443, "mode:beam2")].into_iter().enumerate() {
        let found = &modes.modes[k];
        assert!((found.frequency_hz - frequency).abs() < 0.51e-5, "{found:?}"); // printed digits
        // rounding of two eigenvalue algorithms
        assert!((found.frequency_hz / own[k].frequency_hz - 1.0).abs() < 1e-11);
        assert!((found.damping_ratio / own[k].damping_ratio - 1.0).abs() < 1e-9);
        assert!(found.label.starts_with(label), "{found:?}");
        assert!((found.participation.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn state_space_of_the_hub_is_that_of_bp3s_matrices() {
    let design = AppendageParameters::design();
    let system = System::new(&hub_and_beam()).unwrap();
    let space = system.linearise(&mut Workspace::new(&system), 0.0, &[0.0; 6], &[0.0]);
    let (c, locked) = (design.coupling(), design.hub_locked_modes());
    let mass = nalgebra::Matrix3::new(design.total_inertia_kg_m2(), c[0], c[1], c[0], 1.0, 0.0, c[1], 0.0, 1.0);
    let inverse = mass.try_inverse().unwrap();
    let omega = [0, 1].map(|k| core::f64::consts::TAU * locked[k].0);
    for row in 0..3 {
        for k in 0..2 {
            let stiffness = -inverse[(row, k + 1)] * omega[k] * omega[k];
            let damping = -inverse[(row, k + 1)] * 2.0 * locked[k].1 * omega[k];
            // rounding of an inverse with condition 200, entries up to 1e4
            assert!((space.a[(3 + row, 1 + k)] - stiffness).abs() < 1e-9);
            assert!((space.a[(3 + row, 4 + k)] - damping).abs() < 1e-11);
        }
        assert!((space.b[(3 + row, 0)] - inverse[(row, 0)]).abs() < 1e-12);
    }
    let beam = design.beam;
    let arm = [design.root_radius_m + beam.length_m, beam.mode(1).shape(5.0), beam.mode(2).shape(5.0)];
    for column in 0..6 {
        let expected: f64 = (0..3).map(|row| arm[row] * space.a[(3 + row, column)]).sum();
        assert!((space.c[(0, column)] - expected).abs() < 1e-10, "{column}");
    }
}
