//! What the momentum of the free-floating arm can say, asked of the plant file.

use crate::subject::{arm_of, plant, value};
use dynamics::multibody::{MomentumBasis, MomentumSpan, ParameterFamily, momentum_span, planar_tree_functions};
use dynamics::system::System;

/// The numbers of an arm; every one is varied by 30 %.
const VARIED: [&str; 11] = [
    "hub.mass",
    "hub.inertia.zz",
    "link_1.mass",
    "link_1.com.x",
    "link_1.inertia.zz",
    "link_2.mass",
    "link_2.com.x",
    "link_2.inertia.zz",
    "shoulder.position.x",
    "shoulder.position.y",
    "elbow.position.x",
];

/// Span of the momentum of a plant file when `names` vary over their ranges.
fn span(name: &str, ranges: &[(&str, (f64, f64))]) -> MomentumSpan {
    let nominal = plant(name, &[]);
    let model = |values: &[f64]| {
        let mut varied = nominal.clone();
        for ((name, _), value) in ranges.iter().zip(values) {
            varied.set_parameter(name, *value).unwrap();
        }
        Ok(System::new(&varied).unwrap().model().clone())
    };
    let functions = planar_tree_functions(System::new(&nominal).unwrap().model()).unwrap();
    let evaluate = |q: &[f64], v: &[f64], values: &mut [f64]| functions.evaluate(q, v, values);
    let basis = MomentumBasis { names: functions.names(), evaluate: &evaluate };
    let limits: Vec<(f64, f64)> = ranges.iter().map(|(_, range)| *range).collect();
    momentum_span(&ParameterFamily { ranges: &limits, model: &model }, Some(&basis), 5).unwrap()
}

fn around(name: &str) -> Vec<(&'static str, (f64, f64))> {
    let nominal = plant(name, &[]);
    VARIED.iter().map(|name| (*name, (0.7 * value(&nominal, name), 1.3 * value(&nominal, name)))).collect()
}

#[test]
fn free_floating_arm_has_eight_base_parameters_and_reports_a4_a7_equals_a5_a6() {
    let found = span("free_floating_arm", &around("free_floating_arm"));
    assert_eq!((found.span_dimension, found.manifold_dimension), (8, 7));
    let texts: Vec<&str> = found.dependences.iter().map(|dependence| dependence.text.as_str()).collect();
    assert!(texts == ["a4·a7 = a5·a6"] || texts == ["a5·a6 = a4·a7"], "{texts:?}");
    assert!(found.gaps.iter().all(|gap| *gap > 1e3), "{:?}", found.gaps); // the decisions are clear
    // In the middle of the ranges the coefficients are those of the closed form.
    let alpha = arm_of(&plant("free_floating_arm", &[])).minimal_parameters();
    for (found, closed) in found.coefficients.iter().zip(&alpha) {
        assert!((found / closed - 1.0).abs() < 1e-11, "{found} {closed}"); // rounding × condition of the functions
    }
}

#[test]
fn mated_arm_has_nine_and_no_quadratic_dependence() {
    let mut ranges = around("mated");
    ranges.extend([("target.mass", (50.0, 250.0)), ("target.com.x", (0.2, 1.0)), ("target.com.y", (-0.5, 0.8))]);
    let found = span("mated", &ranges);
    assert_eq!((found.span_dimension, found.manifold_dimension), (9, 8));
    let quadratic = found.dependences.iter().filter(|dependence| dependence.terms.iter().all(|term| term.0.len() == 2));
    assert_eq!(quadratic.count(), 0, "{:?}", found.dependences);
}
