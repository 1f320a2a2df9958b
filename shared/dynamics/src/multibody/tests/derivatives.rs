//! Analytic derivatives against dual numbers and against differences.

use super::*;

fn analytic(model: &Model, state: &State) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = model.v_len();
    let (mut dq, mut dv) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let mut data = Data::new(model);
    inverse_dynamics_derivatives(model, &mut data, &state.q, &state.v, &state.a, &mut dq, &mut dv);
    (dq, dv)
}

#[test]
fn derivatives_of_inverse_dynamics_are_those_of_dual_numbers() {
    for (model, state) in random_trees() {
        let n = model.v_len();
        let (dq, dv) = analytic(&model, &state);
        let lift = |x: &[f64]| x.iter().map(|x| Dual::constant(*x)).collect::<Vec<_>>();
        let (q, v, a) = (lift(&state.q), lift(&state.v), lift(&state.a));
        let mut data = Data::<Dual>::new(&model);
        let mut tau = lift(&state.tau);
        for k in 0..n {
            let mut direction = lift(&vec![0.0; n]);
            direction[k] = Dual::constant(1.0);
            let mut moved = q.clone();
            integrate_position(&model, &q, &direction, Dual::variable(0.0), &mut moved);
            inverse_dynamics(&model, &mut data, &moved, &v, &a, &[], &mut tau);
            for i in 0..n {
                // rounding, relative to the column; the two sums run over different terms
                let found = (dq[(i, k)] - tau[i].derivative).abs();
                assert!(found <= 1e-12 * (1.0 + dq.norm()), "∂τ_{i}/∂q_{k}: {} {}", dq[(i, k)], tau[i].derivative);
            }
            let mut faster = v.clone();
            faster[k].derivative = 1.0;
            inverse_dynamics(&model, &mut data, &q, &faster, &a, &[], &mut tau);
            for i in 0..n {
                let found = (dv[(i, k)] - tau[i].derivative).abs();
                assert!(found <= 1e-12 * (1.0 + dv.norm()), "∂τ_{i}/∂v_{k}: {} {}", dv[(i, k)], tau[i].derivative);
            }
        }
    }
}

#[test]
fn derivatives_of_inverse_dynamics_are_the_limit_of_differences() {
    for (model, state) in random_trees().take(30) {
        let n = model.v_len();
        let (dq, dv) = analytic(&model, &state);
        let h = 1e-5;
        for k in 0..n {
            let at = |step: f64, of_position: bool| {
                let (mut q, mut v) = (state.q.clone(), state.v.clone());
                let mut direction = vec![0.0; n];
                direction[k] = step;
                if of_position {
                    integrate_position(&model, &state.q, &direction, 1.0, &mut q);
                } else {
                    v[k] += step;
                }
                efforts(&model, &q, &v, &state.a, &[])
            };
            for (matrix, of_position) in [(&dq, true), (&dv, false)] {
                let (plus, minus) = (at(h, of_position), at(-h, of_position));
                for i in 0..n {
                    let central = (plus[i] - minus[i]) / (2.0 * h);
                    // truncation h²/6 · third derivative, rounding 1e-16 · τ / h
                    assert!((central - matrix[(i, k)]).abs() <= 1e-8 * (1.0 + matrix.norm() + norm(&plus)));
                }
            }
        }
    }
}
