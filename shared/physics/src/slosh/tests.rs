//! One axis against two bodies in absolute coordinates, and the transitions against their own
//! differences.

use super::*;
use std::vec::Vec;

pub const BASE_MASS_KG: f64 = 1004.5;

/// The benchmark's tank: 28.7 kg, 0.012052 Hz, ζ = 0.71 %.
pub const TANK: SloshParameters = SloshParameters { slosh_mass_kg: 28.7, stiffness_n_m: 0.16, damping_n_s_m: 0.03 };

#[test]
fn accelerations_are_those_of_two_bodies() {
    for (r, v, f) in [(0.3, -0.02, 44.0), (-1.2, 0.5, 0.0), (0.0, 0.1, -7.0)] {
        let found = TANK.accelerations(BASE_MASS_KG, &SloshState { displacement_m: r, velocity_m_s: v }, f);
        let spring = TANK.stiffness_n_m * r + TANK.damping_n_s_m * v; // on the base; its reaction on the mass
        let (base, slosh) = ((f + spring) / BASE_MASS_KG, -spring / TANK.slosh_mass_kg);
        assert!((found.base_m_s2 - base).abs() < 1e-17, "{found:?}"); // rounding of 0.05
        assert!((found.relative_m_s2 - (slosh - base)).abs() < 1e-17, "{found:?}");
    }
}

/// Independent oracle: two bodies in absolute coordinates, RK4 with `substeps` per interval, held
/// force. Mean acceleration of the base per interval.
pub fn two_body_oracle(
    tank: &SloshParameters,
    start: SloshState,
    interval_s: f64,
    forces_n: &[f64],
    substeps: u32,
) -> Vec<f64> {
    let mut x = nalgebra::vector![0.0, start.displacement_m, 0.0, start.velocity_m_s];
    let h = interval_s / f64::from(substeps);
    let rate = |x: &nalgebra::Vector4<f64>, f: f64| {
        let spring = tank.stiffness_n_m * (x[1] - x[0]) + tank.damping_n_s_m * (x[3] - x[2]);
        nalgebra::vector![x[2], x[3], (f + spring) / BASE_MASS_KG, -spring / tank.slosh_mass_kg]
    };
    let mut accelerations = Vec::with_capacity(forces_n.len());
    for force in forces_n {
        let before = x[2];
        for _ in 0..substeps {
            let k1 = rate(&x, *force);
            let k2 = rate(&(x + k1 * (h / 2.0)), *force);
            let k3 = rate(&(x + k2 * (h / 2.0)), *force);
            let k4 = rate(&(x + k3 * h), *force);
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        accelerations.push((x[2] - before) / interval_s);
    }
    accelerations
}

#[test]
fn benchmark_mode_has_the_printed_frequency_and_damping() {
    assert!((TANK.natural_frequency_hz(BASE_MASS_KG) - 0.012052).abs() < 1e-6);
    assert!((TANK.damping_ratio(BASE_MASS_KG) - 0.00710).abs() < 1e-5);
}

#[test]
fn relative_form_equals_two_bodies_in_absolute_coordinates() {
    for (stiffness_n_m, damping_n_s_m) in [(0.16, 0.03), (0.0, 0.2), (0.5, 40.0), (20.0, 0.1), (0.16, -0.05)] {
        let tank = SloshParameters { slosh_mass_kg: 28.7, stiffness_n_m, damping_n_s_m };
        let start = SloshState { displacement_m: 0.3, velocity_m_s: -0.02 };
        let forces: Vec<f64> = (0..400).map(|k| if k % 50 < 20 { 44.0 } else { -10.0 }).collect();
        let oracle = two_body_oracle(&tank, start, 0.5, &forces, 50);
        let mut model = SloshPropagator::new(tank, BASE_MASS_KG, start);
        for (force, expected) in forces.iter().zip(oracle) {
            let acceleration = model.step(0.5, *force);
            assert!((acceleration - expected).abs() < 1e-9, "{tank:?}"); // RK4 truncation at 10 ms
        }
    }
}

#[test]
fn one_long_step_equals_many_short_ones() {
    let start = SloshState { displacement_m: 0.3, velocity_m_s: -0.02 };
    let mut long = SloshPropagator::new(TANK, BASE_MASS_KG, start);
    let mut short = long;
    long.step(200.0, 3.0); // ωB = 15: several squarings
    for _ in 0..2000 {
        short.step(0.1, 3.0);
    }
    let (a, b) = (long.state(), short.state());
    assert!((a.displacement_m - b.displacement_m).abs() < 1e-11); // rounding of 2000 steps
    assert!((a.velocity_m_s - b.velocity_m_s).abs() < 1e-12);
}

#[test]
fn transitions_continue_to_neighbouring_lengths_with_the_order_of_their_series() {
    let difference =
        |a: &Transition, b: &Transition| (a.phi - b.phi).amax().max((a.gain - b.gain).amax() * BASE_MASS_KG);
    for (kappa, gamma) in [(0.0057, 0.001), (0.0, 0.0), (0.3, 0.4), (9.0, 0.1)] {
        let at = TransitionWithSensitivity::new(kappa, gamma, 1.0, BASE_MASS_KG);
        let near = NeighbouringTransitions::new(&at.value, kappa, gamma, 1.0, BASE_MASS_KG);
        let sensitivities = NeighbouringSensitivities::new(&at, kappa, gamma, 1.0, BASE_MASS_KG);
        let error = |delta: f64| {
            let exact = Transition::new(kappa, gamma, 1.0 + delta, BASE_MASS_KG);
            difference(&near.at(1.0 + delta).expect("near"), &exact)
        };
        assert!(error(0.0) < 1e-12, "{}", error(0.0)); // rounding, 12 S1/B³ against 6 S1/B²
        let (far, close) = (error(0.16), error(0.08));
        // ṡ is continued to the fourth power of δ: halving δ divides the error by 2⁵ nearly, down
        // to rounding.
        assert!(far < 1e-12 || far / close > 24.0, "{kappa} {gamma}: {far} {close}");
        let exact = TransitionWithSensitivity::new(kappa, gamma, 1.009, BASE_MASS_KG);
        let continued = sensitivities.at(1.009).expect("near");
        for (a, b) in
            [(continued.value, exact.value), (continued.by_kappa, exact.by_kappa), (continued.by_gamma, exact.by_gamma)]
        {
            assert!(difference(&a, &b) < 5e-9, "{kappa} {gamma}: {}", difference(&a, &b)); // κ² δ⁵/5! of ṡ, κ = 9
        }
    }
    let far = Transition::new(9.0, 0.1, 1.0, BASE_MASS_KG);
    assert!(NeighbouringTransitions::new(&far, 9.0, 0.1, 1.0, BASE_MASS_KG).at(1.2).is_none());
}

#[test]
fn analytic_sensitivities_equal_central_differences() {
    for (kappa, gamma, b) in [(0.0057, 0.001, 0.8), (0.0, 0.0, 2.0), (0.3, 3.0, 5.0), (4.0, 0.1, 1.5)] {
        let at = TransitionWithSensitivity::new(kappa, gamma, b, BASE_MASS_KG);
        let plain = Transition::new(kappa, gamma, b, BASE_MASS_KG);
        assert!((at.value.phi - plain.phi).amax() < 1e-13 && (at.value.gain - plain.gain).amax() < 1e-13);
        let step = 1e-5;
        let difference = |dk: f64, dg: f64| {
            let plus = Transition::new(kappa + dk, gamma + dg, b, BASE_MASS_KG);
            let minus = Transition::new(kappa - dk, gamma - dg, b, BASE_MASS_KG);
            ((plus.phi - minus.phi) / (2.0 * step), (plus.gain - minus.gain) / (2.0 * step))
        };
        for (analytic, numeric) in [(at.by_kappa, difference(step, 0.0)), (at.by_gamma, difference(0.0, step))] {
            let size = analytic.phi.amax();
            assert!((analytic.phi - numeric.0).amax() < 1e-7 * size, "{kappa} {gamma} {b}"); // truncation (B² step)²
            assert!((analytic.gain - numeric.1).amax() < 1e-7 * size);
        }
    }
}

#[test]
fn force_with_an_edge_inside_a_block_is_carried_by_its_two_moments() {
    // 44 N switched off at 30 % of a 2 s block: error of the block's Δṙ falls as (ωB)² relative to
    // the impulse.
    let (b, edge, force) = (2.0, 0.6, 44.0);
    let mu = TANK.reduced_mass_kg(BASE_MASS_KG);
    let (kappa, gamma) = (TANK.stiffness_n_m / mu, TANK.damping_n_s_m / mu);
    let moments = Vector2::new(force * edge, force * edge * (edge / 2.0 - b / 2.0));
    let block = Transition::new(kappa, gamma, b, BASE_MASS_KG).apply(&Vector2::zeros(), &moments);
    let mut exact = SloshPropagator::new(TANK, BASE_MASS_KG, SloshState::default());
    exact.step(edge, force);
    exact.step(b - edge, 0.0);
    assert!((block[0] - exact.state().displacement_m).abs() < 1e-3 * block[0].abs());
    assert!((block[1] - exact.state().velocity_m_s).abs() < 1e-3 * block[1].abs());
}
