//! Free-flying arm (BP1B): thrust and torque on the base, eight linear parameters.

use crate::subject::{ROUNDING, SKEWED, STATES, Subject, Worst, arm_of, plant, value};
use dynamics::description::Plant;
use dynamics::multibody::{Data, PARAMETERS_PER_LINK, inverse_dynamics_regressor, mass_matrix};
use dynamics::noise::Stream;
use nalgebra::{DMatrix, DVector, SMatrix};
use physics::free_flying::{
    Five, FlyingGeometry, FlyingMotion, Pi, accelerations, dynamics, momentum_form, parameters, wrench_regressor,
};

fn closed_form(plant: &Plant) -> (FlyingGeometry, Pi) {
    let (arm, base_com_m) = (arm_of(plant), ["hub.com.x", "hub.com.y"].map(|name| value(plant, name)));
    (FlyingGeometry::of(&arm, base_com_m), parameters(&arm, base_com_m))
}

fn plants() -> [Plant; 2] {
    [plant("free_flying_arm", &[]), plant("free_flying_arm", &SKEWED)]
}

/// Rows of the closed forms (force x, force y, torque, τ1, τ2) in the plant's coordinates (torque,
/// force x, force y, τ1, τ2).
const ROWS: [usize; 5] = [1, 2, 0, 3, 4];

fn motion(subject: &Subject, acceleration_m_s2: [f64; 2], accelerations_rad_s2: [f64; 3]) -> FlyingMotion {
    let (joint_angle_rad, rates_rad_s) = subject.arm_state();
    FlyingMotion { acceleration_m_s2, joint_angle_rad, rates_rad_s, accelerations_rad_s2 }
}

/// Inertial acceleration of the base's origin along its axes, from the rates of its velocity's
/// components there.
fn inertial(subject: &Subject, [rate_x, rate_y]: [f64; 2]) -> [f64; 2] {
    let (w, x, y) = (subject.at("body:hub.rz.rate"), subject.at("body:hub.x.rate"), subject.at("body:hub.y.rate"));
    [rate_x - w * y, rate_y + w * x]
}

#[test]
fn accelerations_under_thrust_and_torque_are_those_of_the_closed_form() {
    for plant in plants() {
        let (geometry, pi) = closed_form(&plant);
        let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
        for k in 0..STATES {
            subject.draw(k);
            subject.push(k, 40.0);
            let wrench =
                ["force_x", "force_y", "torque", "shoulder_motor", "elbow_motor"].map(|name| subject.input(name));
            let [x, y, b0, dd1, dd2] = subject.rates([
                "body:hub.x.rate",
                "body:hub.y.rate",
                "body:hub.rz.rate",
                "joint:shoulder.rate",
                "joint:elbow.rate",
            ]);
            let [x, y] = inertial(&subject, [x, y]);
            let (angle, rates) = subject.arm_state();
            let closed = accelerations(&geometry, &pi, angle, rates, &Five::from(wrench)).expect("physical");
            let inverse = dynamics(&geometry, &pi, angle, rates).0.try_inverse().expect("positive");
            let terms = wrench_regressor(&geometry, &motion(&subject, [0.0; 2], [0.0; 3])).abs() * pi.abs();
            let size = inverse.abs() * (terms + Five::from(wrench).abs());
            for (i, found) in [x, y, b0, dd1, dd2].into_iter().enumerate() {
                // the plant's own rate of the velocity components is corrected by w × v
                worst.see(found - closed[i], size[i] + if i < 2 { subject.at("body:hub.rz.rate").abs() } else { 0.0 });
            }
        }
        worst.demand("accelerations, BP1B", ROUNDING);
    }
}

/// `π` of page 1, section 4, in standard parameters
/// `[m, mcx, mcy, mcz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz]` about each link's origin.
fn standard_to_pi(geometry: &FlyingGeometry) -> SMatrix<f64, 8, 30> {
    let ([ax, ay], l) = (geometry.joint_from_reference_m, geometry.link_1_length_m);
    let mut map = SMatrix::zeros();
    let (m, mcx, mcy, izz) = (0, 1, 2, 9);
    for (row, column, factor) in [
        (0, m, 1.0),
        (1, mcx, 1.0),
        (2, mcy, 1.0),
        (3, izz, 1.0),
        (0, 10 + m, 1.0),
        (1, 10 + m, ax),
        (2, 10 + m, ay),
        (3, 10 + m, ax * ax + ay * ay),
        (4, 10 + mcx, 1.0),
        (5, 10 + izz, 1.0),
        (0, 20 + m, 1.0),
        (1, 20 + m, ax),
        (2, 20 + m, ay),
        (3, 20 + m, ax * ax + ay * ay),
        (4, 20 + m, l),
        (5, 20 + m, l * l),
        (6, 20 + mcx, 1.0),
        (7, 20 + izz, 1.0),
    ] {
        map[(row, column)] = factor;
    }
    map
}

/// First moments across the links, which the closed form sets to zero.
const ACROSS: [usize; 2] = [12, 22];
/// mcz and the moments of inertia out of the plane.
const OUT_OF_PLANE: [usize; 6] = [3, 4, 5, 6, 7, 8];

#[test]
fn every_column_of_the_bodies_regressor_is_a_combination_of_the_closed_forms_columns() {
    for plant in plants() {
        let (geometry, pi) = closed_form(&plant);
        let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
        let model = subject.system.model().clone();
        let map = standard_to_pi(&geometry);
        let same = map * DVector::from_vec(model.standard_parameters());
        (0..8).for_each(|i| worst.see(same[i] - pi[i], pi[i].abs()));
        let mut data = Data::new(&model);
        let mut bodies = DMatrix::zeros(5, PARAMETERS_PER_LINK * 3);
        for k in 0..STATES {
            subject.draw(k);
            let (q, v) = subject.model_state();
            let stream = Stream::new(k, "acceleration");
            let rates: Vec<f64> = (0..5).map(|i| stream.normal(i)).collect();
            inverse_dynamics_regressor(&model, &mut data, &q, &v, &rates, &mut bodies);
            let at = motion(&subject, inertial(&subject, [rates[1], rates[2]]), [rates[0], rates[3], rates[4]]);
            let closed = wrench_regressor(&geometry, &at);
            let (columns, terms) = (closed * map, closed.abs() * map.abs());
            for column in (0..30).filter(|column| !ACROSS.contains(column)) {
                for row in 0..5 {
                    let found = bodies[(ROWS[row], column)];
                    if OUT_OF_PLANE.contains(&(column % 10)) {
                        assert_eq!(found, 0.0, "row {row}, column {column}");
                    } else {
                        // terms of the size of accelerations and squared rates, order ten, are
                        // added
                        worst.see(found - columns[(row, column)], terms[(row, column)] + 1.0);
                    }
                }
            }
        }
        worst.demand("columns of the regressor, BP1B", ROUNDING);
    }
}

#[test]
fn generalised_momentum_and_mass_matrix_are_those_of_the_closed_form() {
    for plant in plants() {
        let (geometry, pi) = closed_form(&plant);
        let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
        let model = subject.system.model().clone();
        let mut data = Data::new(&model);
        let mut mass = DMatrix::zeros(5, 5);
        for k in 0..STATES {
            subject.draw(k);
            // The closed form's momentum is relative to the reference point's own motion.
            subject.set("body:hub.x.rate", 0.0);
            subject.set("body:hub.y.rate", 0.0);
            let (q, v) = subject.model_state();
            mass_matrix(&model, &mut data, &q, &mut mass);
            let (angle, rates) = subject.arm_state();
            let closed = dynamics(&geometry, &pi, angle, rates).0;
            for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
                let size = (closed[(i, i)] * closed[(j, j)]).sqrt();
                worst.see(mass[(ROWS[i], ROWS[j])] - closed[(i, j)], size);
            }
            let form = momentum_form(&geometry, &motion(&subject, [0.0; 2], [0.0; 3])).momentum;
            let (momentum, terms) = (form * pi, form.abs() * pi.abs());
            let bodies = &mass * DVector::from_vec(v);
            (0..5).for_each(|i| worst.see(bodies[ROWS[i]] - momentum[i], terms[i]));
            let linear = subject.totals().linear_momentum_n_s;
            let (sin, cos) = subject.at("body:hub.rz").sin_cos();
            worst.see(linear[0] - (cos * momentum[0] - sin * momentum[1]), terms[0] + terms[1]);
            worst.see(linear[1] - (sin * momentum[0] + cos * momentum[1]), terms[0] + terms[1]);
        }
        worst.demand("momentum, BP1B", ROUNDING);
    }
}
