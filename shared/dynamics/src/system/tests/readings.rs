//! Sensors.

use super::*;
use crate::description::Reading;

fn accelerometer(body: &str, at: [f64; 3], axis: [f64; 3]) -> SensorKind {
    SensorKind::Accelerometer { body: body.to_owned(), position_m: three(at), axis, point: None }
}

fn gyro(body: &str, axis: [f64; 3]) -> SensorKind {
    SensorKind::Gyro { body: body.to_owned(), axis }
}

#[test]
fn scale_bias_and_misalignment_do_what_a_data_sheet_means() {
    let mut plant = arm(Space::Spatial);
    let mut crooked = sensor("crooked", gyro("base", [1.0, 0.0, 0.0]));
    (crooked.scale, crooked.bias) = (known(0.02), known(0.5));
    crooked.misalignment = Orientation { axis: Z, angle_rad: known(0.1) };
    plant.sensors = vec![crooked];
    let system = System::new(&plant).unwrap();
    let x = random_state(&system, 1);
    let (wx, wy) = (x[index(&system, "body:base.rx.rate")], x[index(&system, "body:base.ry.rate")]);
    let turned = libm::cos(0.1) * wx + libm::sin(0.1) * wy;
    assert!((readings(&system, &x, &[0.0; 2])[0] - (1.02 * turned + 0.5)).abs() < 1e-15);
}

#[test]
fn an_accelerometer_at_rest_on_the_ground_feels_the_ground() {
    let mut plant = Plant { space: Space::Spatial, ..Plant::default() };
    plant.environment.gravity_m_s2 = three([0.0, 0.0, -9.81]);
    let hinge = joint("hinge", JointKind::Revolute { axis: [1.0, 0.0, 0.0] }, [0.0; 3]);
    plant.bodies = vec![body("arm", None, hinge, 2.0, [0.0, 0.0, -0.4], [0.1, 0.1, 0.1])];
    plant.sensors = vec![
        sensor("a", accelerometer("arm", [0.0, 0.1, 0.2], Z)),
        sensor("f", SensorKind::Force { joint: "hinge".to_owned(), axis: Z }),
    ];
    let system = System::new(&plant).unwrap();
    let y = readings(&system, &[0.0; 2], &[]);
    assert!((y[0] - 9.81).abs() < 1e-14 && (y[1] - 2.0 * 9.81).abs() < 1e-14, "{y:?}");
}

/// Second differences of the position of a point that really moves.
#[test]
fn position_velocity_and_acceleration_of_a_point_belong_together() {
    let mut plant = everything(true);
    let at = [0.3, -0.2, 0.5];
    for (k, axis) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Z].into_iter().enumerate() {
        let body = || "tool".to_owned();
        plant.sensors.extend([
            sensor(&format!("x{k}"), SensorKind::Position { body: body(), position_m: three(at), axis }),
            sensor(&format!("v{k}"), SensorKind::Velocity { body: body(), position_m: three(at), axis }),
            sensor(&format!("a{k}"), accelerometer("tool", at, axis)),
        ]);
    }
    let system = System::new(&plant).unwrap();
    let x = random_state(&system, 9);
    let mut ws = Workspace::<Dual>::new(&system);
    let mut y = vec![Dual::default(); 9];
    system.read(&mut ws, 0.0, &moving(&system, &x, &[0.0; 4]), &[Dual::default(); 4], &mut y);
    let (mut gained, mut felt) = (0.0, 0.0);
    for k in 0..3 {
        assert!((y[3 * k].derivative - y[3 * k + 1].value).abs() < 1e-13); // rounding
        gained += y[3 * k + 1].derivative * y[3 * k + 1].derivative;
        felt += y[3 * k + 2].value * y[3 * k + 2].value;
    }
    // one in inertial, one in body axes: the same length
    assert!((gained / felt - 1.0).abs() < 1e-12, "{gained} {felt}");
}

#[test]
fn an_accelerometer_on_a_panel_feels_the_motion_of_the_bent_panel() {
    let mut plant = everything(true);
    for (k, axis) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Z].into_iter().enumerate() {
        let kind = SensorKind::Accelerometer {
            body: "hub".to_owned(),
            position_m: three([0.0; 3]),
            axis,
            point: Some(("panel".to_owned(), "tip".to_owned())),
        };
        plant.sensors.push(sensor(&format!("tip{k}"), kind));
    }
    let system = System::new(&plant).unwrap();
    let x = random_state(&system, 9);
    let felt: f64 = readings(&system, &x, &[0.0; 4]).iter().map(|a| a * a).sum();
    let mut ws = Workspace::<Dual>::new(&system);
    system.place(&mut ws, &moving(&system, &x, &[0.0; 4]), &[Dual::default(); 4]);
    let crate::system::sensors::Measured::Accelerometer { link, point, flexure, .. } = &system.sensors[0].measured
    else {
        panic!("an accelerometer")
    };
    let velocity = system.inertial_velocity(&ws, *link, point, flexure);
    let gained: f64 = velocity.iter().map(|v| v.derivative * v.derivative).sum();
    assert!((gained / felt - 1.0).abs() < 1e-12, "{gained} {felt}"); // rounding
}

/// Means over an interval against averages of a fine integration.
#[test]
fn mean_readings_are_increments_over_the_interval() {
    for space in [Space::Planar, Space::Spatial] {
        let mut plant = arm(space);
        plant.environment.gravity_m_s2 = three([0.3, -0.2, 0.0]);
        plant.sensors = vec![
            sensor("gyro", gyro("link1", Z)),
            sensor("ax", accelerometer("link1", [0.5, 0.2, 0.0], [1.0, 0.0, 0.0])),
            sensor("ay", accelerometer("link1", [0.5, 0.2, 0.0], [0.0, 1.0, 0.0])),
        ];
        let instant = System::new(&plant).unwrap();
        plant.sensors.iter_mut().for_each(|sensor| sensor.reading = Reading::Mean);
        let mean = System::new(&plant).unwrap();
        let (u, steps, step) = ([20.0, -10.0], 64, 0.01 / 64.0);
        let begin = if space == Space::Planar { random_state(&mean, 3) } else { spatial_in_plane() };
        let (mut x, mut sum) = (begin.clone(), [0.0; 3]);
        let mut weighed = |x: &[f64], weight: f64| {
            sum.iter_mut()
                .zip(readings(&instant, x, &u))
                .for_each(|(sum, y)| *sum += weight * y / (3.0 * steps as f64));
        };
        for k in 0..steps {
            // Simpson's rule
            weighed(
                &x,
                if k == 0 {
                    1.0
                } else if k % 2 == 1 {
                    4.0
                } else {
                    2.0
                },
            );
            integrate(&instant, &mut x, &u, step, 1);
        }
        weighed(&x, 1.0);
        let mut y = [0.0; 3];
        mean.read_mean(&mut Workspace::new(&mean), 0.0, 0.01, &begin, &u, &x, &u, &mut y);
        assert!((y[0] - sum[0]).abs() < 1e-11, "{y:?} {sum:?}"); // Simpson's truncation
        // body components averaged in turning axes differ by (ω Δt)²/24 of the acceleration and by
        // its rate across
        for k in 1..3 {
            assert!((y[k] - sum[k]).abs() < 1e-4 * 3.0, "{y:?} {sum:?}");
        }
    }
}

fn spatial_in_plane() -> Vec<f64> {
    let mut x = vec![0.0; 17];
    x[3] = 1.0;
    (x[7], x[8], x[11], x[15], x[16]) = (0.4, -0.6, 0.2, 0.5, -0.8);
    x
}

#[test]
fn a_mean_accelerometer_gives_the_increment_exactly_and_a_mean_gyro_counts_every_turn() {
    let mut plant = arm(Space::Planar);
    plant.sensors =
        vec![sensor("gyro", gyro("link2", Z)), sensor("ax", accelerometer("base", [0.0; 3], [1.0, 0.0, 0.0]))];
    plant.sensors.iter_mut().for_each(|sensor| sensor.reading = Reading::Mean);
    let system = System::new(&plant).unwrap();
    let (mut begin, mut end) = (vec![0.0; 10], vec![0.0; 10]);
    (begin[2], end[2], end[3], end[4]) = (0.1, 0.3, 5.0, 4.0);
    // inertial velocity from zero to (3, 4) m/s; half way the base stands at 0.2 rad
    let (sin, cos) = libm::sincos(0.3);
    (end[6], end[7]) = (cos * 3.0 + sin * 4.0, cos * 4.0 - sin * 3.0);
    let mut y = [0.0; 2];
    system.read_mean(&mut Workspace::new(&system), 0.0, 0.5, &begin, &[0.0; 2], &end, &[0.0; 2], &mut y);
    assert!((y[0] - (0.2 + 9.0) / 0.5).abs() < 1e-14, "{y:?}");
    let expected = (libm::cos(0.2) * 3.0 + libm::sin(0.2) * 4.0) / 0.5;
    assert!((y[1] - expected).abs() < 1e-14, "{y:?} {expected}");
}

#[test]
fn attitude_counts_turns_in_the_plane_and_is_a_rotation_vector_in_space() {
    let mut flat = arm(Space::Planar);
    flat.sensors = vec![sensor("attitude", SensorKind::Attitude { body: "link2".to_owned(), axis: Z })];
    let system = System::new(&flat).unwrap();
    let mut x = vec![0.0; 10];
    (x[2], x[3], x[4]) = (7.0, 8.0, -1.0);
    assert_eq!(readings(&system, &x, &[0.0; 2]), [14.0]);
    let mut full = Plant { space: Space::Spatial, ..Plant::default() };
    full.bodies = vec![free("hub", 1.0, [0.0; 3], [1.0; 3])];
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Z];
    full.sensors = axes.map(|axis| sensor("attitude", SensorKind::Attitude { body: "hub".to_owned(), axis })).to_vec();
    let system = System::new(&full).unwrap();
    for angle in [1e-9, 0.003, 0.5, 3.0, 3.13] {
        let phi = [0.48, -0.6, 0.64].map(|n| n * angle);
        let mut x = vec![0.0; 13];
        x[3..7].copy_from_slice(&crate::system::geometry::quaternion_of_vector(phi));
        for (found, expected) in readings(&system, &x, &[]).iter().zip(phi) {
            assert!((found - expected).abs() < 1e-15 * 4.0, "{angle}: {found} {expected}"); // rounding
        }
    }
}
