//! Algorithms against each other: the same equations written in different ways.

use super::*;

#[test]
fn inverse_dynamics_undoes_forward_dynamics() {
    for (model, state) in random_trees() {
        let a = accelerations(&model, &state, &state.wrench);
        let tau = efforts(&model, &state.q, &state.v, &a, &state.wrench);
        // rounding of a matrix equation: terms M a
        let terms = (mass(&model, &state.q).abs() * DVector::from_vec(a).abs()).norm();
        assert!(difference(&tau, &state.tau) <= 1e-12 * (terms + norm(&state.tau)), "{:?}", model.parent(0));
    }
}

#[test]
fn mass_matrix_times_acceleration_plus_bias_is_inverse_dynamics() {
    for (model, state) in random_trees() {
        let bias = efforts(&model, &state.q, &state.v, &vec![0.0; model.v_len()], &state.wrench);
        let tau = efforts(&model, &state.q, &state.v, &state.a, &state.wrench);
        let product = mass(&model, &state.q) * DVector::from_column_slice(&state.a);
        let sum: Vec<f64> = product.iter().zip(&bias).map(|(m, b)| m + b).collect();
        // rounding
        assert!(difference(&sum, &tau) <= 1e-13 * (product.norm() + norm(&bias)));
    }
}

#[test]
fn mass_matrix_is_positive_definite_and_its_columns_are_efforts_of_unit_accelerations() {
    for (model, state) in random_trees() {
        let n = model.v_len();
        let matrix = mass(&model, &state.q);
        let at_rest = vec![0.0; n];
        let bias = efforts(&model, &state.q, &at_rest, &at_rest, &[]);
        for k in 0..n {
            let mut unit = at_rest.clone();
            unit[k] = 1.0;
            let tau = efforts(&model, &state.q, &at_rest, &unit, &[]);
            let column: Vec<f64> = tau.iter().zip(&bias).map(|(t, b)| t - b).collect();
            // rounding of the weights that are subtracted
            assert!(difference(&column, matrix.column(k).as_slice()) <= 1e-13 * (norm(&tau) + norm(&bias)));
        }
        assert_eq!(matrix, matrix.transpose());
        assert!(matrix.cholesky().is_some());
    }
}

#[test]
fn kinetic_energy_is_half_the_quadratic_form_of_the_mass_matrix() {
    for (model, state) in random_trees() {
        let v = DVector::from_column_slice(&state.v);
        let form = 0.5 * (v.transpose() * mass(&model, &state.q) * &v)[0];
        let energy = kinetic_energy(&model, &mut Data::new(&model), &state.q, &state.v);
        assert!((energy - form).abs() <= 1e-13 * form); // rounding
    }
}

#[test]
fn regressor_times_parameters_is_inverse_dynamics() {
    for (model, state) in random_trees() {
        let mut links_only = model.clone();
        links_only.internals.clear();
        let n = links_only.v_len();
        let mut regressor = DMatrix::zeros(n, 10 * model.links_len());
        let mut data = Data::new(&links_only);
        inverse_dynamics_regressor(&links_only, &mut data, &state.q, &state.v[..n], &state.a[..n], &mut regressor);
        let tau = &regressor * DVector::from_vec(links_only.standard_parameters());
        let terms = regressor.abs() * DVector::from_vec(links_only.standard_parameters()).abs();
        let mut expected = efforts(&links_only, &state.q, &state.v[..n], &state.a[..n], &[]);
        for link in links_only.links.iter().filter(|link| link.v_len == 1) {
            expected[link.v] -= link.armature * state.a[link.v];
        }
        for (row, expected) in expected.iter().enumerate() {
            assert!((tau[row] - expected).abs() <= 1e-12 * terms[row].max(1e-3)); // rounding
        }
    }
}

#[test]
fn momentum_regressor_times_parameters_is_momentum() {
    for (model, state) in random_trees() {
        let mut links_only = model.clone();
        links_only.internals.clear();
        let v = &state.v[..links_only.v_len()];
        let mut regressor = DMatrix::zeros(6, 10 * model.links_len());
        let mut data = Data::new(&links_only);
        momentum_regressor(&links_only, &mut data, &state.q, v, &mut regressor);
        let h = &regressor * DVector::from_vec(links_only.standard_parameters());
        let terms = regressor.abs() * DVector::from_vec(links_only.standard_parameters()).abs();
        let expected = momentum(&links_only, &mut data, &state.q, v);
        let expected = expected.angular_about_origin.into_iter().chain(expected.linear);
        for (row, expected) in expected.enumerate() {
            assert!((h[row] - expected).abs() <= 1e-13 * terms[row]); // rounding
        }
    }
}

#[test]
fn a_prescribed_joint_moves_as_under_the_effort_that_forward_dynamics_finds_for_it() {
    for (seed, (model, state)) in random_trees().enumerate() {
        let mut draw = Draw::new(1000 + seed as u64);
        let n = model.v_len();
        let mut prescribed = vec![false; n];
        for link in 0..model.links_len() {
            let given = draw.number() > 0.0;
            prescribed[model.v_index(link)..][..model.joint_v_len(link)].fill(given);
        }
        for internal in 0..model.internals_len() {
            prescribed[model.v_index_internal(internal)] = draw.number() > 0.0;
        }
        let free = accelerations(&model, &state, &state.wrench);
        let known = |i: usize, value: f64| if prescribed[i] { value } else { f64::NAN };
        let mut a: Vec<f64> = (0..n).map(|i| known(i, free[i])).collect();
        let mut tau: Vec<f64> = (0..n).map(|i| if prescribed[i] { f64::NAN } else { state.tau[i] }).collect();
        let mut data = Data::new(&model);
        forward_dynamics_prescribed(
            &model,
            &mut data,
            &state.q,
            &state.v,
            &prescribed,
            &mut tau,
            &state.wrench,
            &mut a,
        );
        let terms = (mass(&model, &state.q).abs() * DVector::from_column_slice(&free).abs()).norm();
        assert!(difference(&a, &free) <= 1e-11 * norm(&free)); // rounding × condition of M, below 1e3 here
        assert!(difference(&tau, &state.tau) <= 1e-12 * (terms + norm(&state.tau)));
    }
}

#[test]
fn wrench_through_a_joint_is_the_same_from_forward_and_inverse_dynamics_and_holds_its_effort() {
    for (model, state) in random_trees() {
        let mut forward = Data::new(&model);
        let mut a = vec![0.0; model.v_len()];
        forward_dynamics(&model, &mut forward, &state.q, &state.v, &state.tau, &state.wrench, &mut a);
        let mut inverse = Data::new(&model);
        let mut tau = vec![0.0; model.v_len()];
        inverse_dynamics(&model, &mut inverse, &state.q, &state.v, &a, &state.wrench, &mut tau);
        let size = (0..model.links_len()).map(|i| norm(&inverse.joint_wrench(i))).fold(1.0, f64::max);
        for i in 0..model.links_len() {
            let wrench = forward.joint_wrench(i);
            assert!(difference(&wrench, &inverse.joint_wrench(i)) <= 1e-11 * size); // rounding × condition
            if model.links[i].joint == super::super::model::Joint::FreeSpatial {
                let at = model.v_index(i);
                assert!(difference(&wrench, &state.tau[at..at + 6]) <= 1e-11 * size);
            }
        }
    }
}

/// Position of a point after `dt` from the state's velocity and acceleration, to second order.
#[test]
fn point_acceleration_is_the_second_difference_of_its_position() {
    for (model, state) in random_trees().take(40) {
        let mut data = Data::new(&model);
        let mut a = vec![0.0; model.v_len()];
        forward_dynamics(&model, &mut data, &state.q, &state.v, &state.tau, &[], &mut a);
        let link = model.links_len() - 1;
        let point = [0.3, -0.2, 0.5];
        let analytic = data.link(link).rotation.apply(data.point_acceleration(link, point).into()).array();
        let felt = data.link(link).rotation.apply(data.specific_force(link, point).into()).array();
        let dt = 1e-4;
        let at = |t: f64| {
            let mean: Vec<f64> = state.v.iter().zip(&a).map(|(v, a)| v + 0.5 * a * t).collect();
            let (mut q, mut data) = (state.q.clone(), Data::new(&model));
            integrate_position(&model, &state.q, &mean, t, &mut q);
            kinematics(&model, &mut data, &q, &state.v);
            data.point_position(link, point)
        };
        let (before, now, after) = (at(-dt), at(0.0), at(dt));
        let size = 1.0 + norm(&analytic) + norm(&a);
        for k in 0..3 {
            let second = (after[k] - 2.0 * now[k] + before[k]) / (dt * dt);
            // truncation dt² x⁗/12 and rounding 4ε|x|/dt²
            assert!((second - analytic[k]).abs() <= 1e-5 * size, "{second} {}", analytic[k]);
            assert!((analytic[k] - felt[k] - GRAVITY[k]).abs() <= 1e-12 * size);
        }
    }
}

#[test]
fn dual_numbers_give_the_derivative_of_forward_dynamics_and_the_same_value() {
    for (model, state) in random_trees().take(40) {
        let n = model.v_len();
        let mut data = Data::<Dual>::new(&model);
        let lift = |x: &[f64]| x.iter().map(|x| Dual::constant(*x)).collect::<Vec<_>>();
        let (q, tau) = (lift(&state.q), lift(&state.tau));
        let wrench: Vec<[Dual; 6]> = state.wrench.iter().map(|w| w.map(Dual::constant)).collect();
        let h = 1e-6;
        for k in 0..n {
            let mut v = lift(&state.v);
            v[k].derivative = 1.0;
            let mut a = lift(&state.a);
            forward_dynamics(&model, &mut data, &q, &v, &tau, &wrench, &mut a);
            let at = |step: f64| {
                let mut moved =
                    State { v: state.v.clone(), q: state.q.clone(), tau: state.tau.clone(), a: vec![], wrench: vec![] };
                moved.v[k] += step;
                accelerations(&model, &moved, &state.wrench)
            };
            let (plus, minus, plain) = (at(h), at(-h), at(0.0));
            for i in 0..n {
                let central = (plus[i] - minus[i]) / (2.0 * h);
                // quadratic in v: no truncation; rounding of the values over h
                assert!((a[i].derivative - central).abs() <= 1e-8 * (1.0 + norm(&plain)));
                assert!((a[i].value - plain[i]).abs() <= 1e-13 * norm(&plain));
            }
        }
    }
}
