//! Orders of convergence, against an adaptive method of eighth order from another hand.

use super::*;
use crate::oracle::arm::ArmNoise;
use crate::tests::plants;
use core::cell::RefCell;
use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};

/// The arm floating freely, its joints pushed by constant torques.
fn system() -> (System, Vec<f64>) {
    let mut plant = plants::arm(&ArmNoise::none());
    plant.controllers.clear();
    let system = System::new(&plant).unwrap();
    let reference = |name: &str| Some(if name == "joint1" { (0.3, 0.4) } else { (-0.5, 0.6) });
    let x = system.initial_state(&plant.initial, &reference).unwrap();
    (system, x)
}

const TORQUE_N_M: [f64; 2] = [5.0, -3.0];
const END_S: f64 = 2.0;

struct Equations<'a> {
    system: &'a System,
    workspace: RefCell<Workspace<f64>>,
}

impl ODE<f64, Vec<f64>> for Equations<'_> {
    fn diff(&self, t: f64, x: &Vec<f64>, x_dot: &mut Vec<f64>) {
        self.system.derivative(&mut self.workspace.borrow_mut(), t, x, &TORQUE_N_M, x_dot);
    }
}

fn reference(system: &System, x: &[f64]) -> Vec<f64> {
    let equations = Equations { system, workspace: RefCell::new(Workspace::new(system)) };
    let method = ExplicitRungeKutta::dop853().rtol(1e-13).atol(1e-13).max_steps(1_000_000);
    let solution = IVP::ode(&equations, 0.0, END_S, x.to_vec()).method(method).solve().unwrap();
    solution.y.last().unwrap().clone()
}

/// Largest error of the state at the end with `steps` steps.
fn error(system: &System, start: &[f64], expected: &[f64], integrator: Integrator, steps: u32) -> f64 {
    let step_s = END_S / f64::from(steps);
    let mut workspace = Workspace::new(system);
    let mut stepper = Stepper::new(system, integrator, step_s, (0.0, start, &TORQUE_N_M), &[]).unwrap();
    let (mut x, mut u) = (start.to_vec(), TORQUE_N_M);
    let mut drive =
        Drive { reading: None, system, workspace: &mut workspace, u: &mut u, prescribe: |_: f64, _: &mut [f64]| {} };
    stepper.advance(&mut drive, 0.0, END_S, &mut x);
    x.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn errors_fall_with_the_order_of_the_method() {
    let (system, start) = system();
    let expected = reference(&system, &start);
    for (integrator, order, steps) in [(Integrator::RungeKutta4, 4.0, 100), (Integrator::Midpoint, 2.0, 400)] {
        let coarse = error(&system, &start, &expected, integrator, steps);
        let fine = error(&system, &start, &expected, integrator, 2 * steps);
        let measured = (coarse / fine).log2();
        assert!(coarse > 1e-11, "{integrator:?}: the error must be above rounding: {coarse:e}");
        assert!((measured - order).abs() < 0.1, "{integrator:?}: order {measured}, errors {coarse:e} {fine:e}");
    }
}

/// Lengths that were prepared and lengths that were not.
#[test]
fn the_exact_hold_equals_the_adaptive_solution_over_any_interval() {
    let plant = plants::slosh();
    let system = System::new(&plant).unwrap();
    let n = system.states().len();
    let start: Vec<f64> = (0..n).map(|i| 0.3 - 0.2 * i as f64).collect();
    let push = [44.0];
    struct Slosh<'a>(&'a System, RefCell<Workspace<f64>>);
    impl ODE<f64, Vec<f64>> for Slosh<'_> {
        fn diff(&self, t: f64, x: &Vec<f64>, x_dot: &mut Vec<f64>) {
            self.0.derivative(&mut self.1.borrow_mut(), t, x, &[44.0], x_dot);
        }
    }
    for length_s in [0.1, 7.3, 60.0] {
        let equations = Slosh(&system, RefCell::new(Workspace::new(&system)));
        let method = ExplicitRungeKutta::dop853().rtol(1e-13).atol(1e-13).max_steps(1_000_000);
        let solution = IVP::ode(&equations, 0.0, length_s, start.clone()).method(method).solve().unwrap();
        for prepared in [&[length_s][..], &[]] {
            let point = (0.0, &start[..], &push[..]);
            let mut stepper = Stepper::new(&system, Integrator::ExactZeroOrderHold, 0.1, point, prepared).unwrap();
            let (mut x, mut u) = (start.clone(), push);
            let mut workspace = Workspace::new(&system);
            let mut drive = Drive {
                reading: None,
                system: &system,
                workspace: &mut workspace,
                u: &mut u,
                prescribe: |_: f64, _: &mut [f64]| {},
            };
            stepper.advance(&mut drive, 0.0, length_s, &mut x);
            for (got, want) in x.iter().zip(solution.y.last().unwrap()) {
                // tolerance of the adaptive method, a hundred steps
                assert!((got - want).abs() < 1e-11 * (1.0 + want.abs()), "{length_s}: {got} {want}");
            }
        }
    }
}
