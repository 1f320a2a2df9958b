//! The likelihood against its own differences.

use super::*;
use crate::slosh::tests::{BASE_MASS_KG, TANK};
use crate::slosh_arc::SloshSample;
use std::vec::Vec;

#[test]
fn sensitivities_of_every_unknown_equal_central_differences() {
    let mut arc = SloshArc::<64>::default();
    for k in 0..300 {
        let force_n = if k % 90 < 40 { 44.0 } else { -20.0 };
        arc.push(&SloshSample { interval_s: 1.0, force_n, acceleration_m_s2: 0.0, sigma_m_s2: 1.0 }).expect("finite");
    }
    let at = SloshHypothesis {
        parameters: TANK,
        state: SloshState { displacement_m: 0.4, velocity_m_s: 0.02 },
        bias_m_s2: 1e-5,
        thrust_scale_error: 0.02,
        thrust_delay_s: 0.03,
    };
    let predict = |hypothesis: &SloshHypothesis| {
        let mut walk = Walk::new(BASE_MASS_KG, hypothesis, arc.block_length_s());
        arc.blocks().map(|block| walk.step(&block)).collect::<Vec<_>>()
    };
    let analytic = predict(&at);
    let moved = |step: &Sensitivity| {
        let mut hypothesis = at.moved(&Vector6::new(step[0], step[1], step[2], step[5], step[6], step[7]));
        hypothesis.state.displacement_m += step[3];
        hypothesis.state.velocity_m_s += step[4];
        hypothesis
    };
    let steps = [1e-3, 1e-6, 1e-6, 1e-4, 1e-5, 1e-7, 1e-4, 1e-4];
    for i in 0..steps.len() {
        let mut step = Sensitivity::zeros();
        step[i] = steps[i];
        let (plus, minus) = (predict(&moved(&step)), predict(&moved(&-step)));
        let size = analytic.iter().map(|(_, s)| s[i].abs()).fold(0.0, f64::max);
        for ((a, p), m) in analytic.iter().zip(plus).zip(minus) {
            let difference = (p.0 - m.0) / (2.0 * steps[i]);
            assert!((a.1[i] - difference).abs() < 1e-6 * size, "unknown {i}"); // truncation (step/value)², rounding
        }
    }
}
