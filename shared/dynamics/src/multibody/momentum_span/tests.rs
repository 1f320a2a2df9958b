use super::super::{JointKind, Link};
use super::*;
use nalgebra::{Matrix3, Vector3};

/// A base with two links: masses, inertias, mount (2), CM of links 1 and 2, length of link 1, and
/// how far CM 2 lies off its axis.
fn arm(p: &[f64], joint: JointKind, base: JointKind) -> Result<Model, ModelError> {
    let [m0, m1, m2, i0, i1, i2, rx, ry, l1, l2, length, off] = p else { panic!("twelve parameters") };
    let link = |parent, joint, at: [f64; 2], mass: &f64, com: [f64; 2], inertia: &f64| Link {
        parent,
        joint,
        position_m: Vector3::new(at[0], at[1], 0.0),
        rotation: Matrix3::identity(),
        mass_kg: *mass,
        com_m: Vector3::new(com[0], com[1], 0.0),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.6, 0.7, 1.0)) * *inertia,
        armature: 0.0,
    };
    let links = [
        link(None, base, [0.0; 2], m0, [0.0; 2], i0),
        link(Some(0), joint, [*rx, *ry], m1, [*l1, 0.0], i1),
        link(Some(1), joint, [*length, 0.0], m2, [*l2, *off], i2),
    ];
    Model::new(&links, &[], Vector3::zeros())
}

const PLANAR: JointKind = JointKind::FreePlanar;
const TURN: JointKind = JointKind::Revolute { axis: Vector3::new(0.0, 0.0, 1.0) };

const RANGES: [(f64, f64); 12] = [
    (200.0, 600.0),
    (5.0, 25.0),
    (5.0, 25.0),
    (30.0, 90.0),
    (5.0, 30.0),
    (5.0, 30.0),
    (0.3, 1.5),
    (0.3, 1.5),
    (0.5, 2.5),
    (0.5, 2.5),
    (1.5, 3.0),
    (0.0, 0.0),
];

fn span(ranges: [(f64, f64); 12], basis: bool) -> MomentumSpan {
    let model = |p: &[f64]| arm(p, TURN, PLANAR);
    let family = ParameterFamily { ranges: &ranges, model: &model };
    let functions = planar_tree_functions(&model(&ranges.map(|(low, high)| 0.5 * (low + high))).unwrap()).unwrap();
    let evaluate = |q: &[f64], v: &[f64], values: &mut [f64]| functions.evaluate(q, v, values);
    let named = MomentumBasis { names: functions.names(), evaluate: &evaluate };
    momentum_span(&family, basis.then_some(&named), 3).unwrap()
}

#[test]
fn two_link_arm_has_eight_coefficients_on_a_manifold_of_seven_and_the_known_dependence() {
    let found = span(RANGES, true);
    assert_eq!((found.span_dimension, found.manifold_dimension), (8, 7), "{found:?}");
    assert_eq!(found.unused, ["(w1+w2) sin(phi2-phi1)"]);
    assert_eq!(found.dependences.len(), 1);
    assert_eq!(found.dependences[0].text.replace("a5·a6 = a4·a7", "a4·a7 = a5·a6"), "a4·a7 = a5·a6");
    assert!(found.gaps.iter().all(|gap| *gap > 1e3), "{:?}", found.gaps); // rounding and differences
    assert!(found.residual < 1e-13); // rounding
}

#[test]
fn with_the_outer_centre_of_mass_off_its_axis_there_are_nine() {
    let mut ranges = RANGES;
    ranges[11] = (-0.5, 0.5);
    let found = span(ranges, true);
    assert_eq!((found.span_dimension, found.manifold_dimension), (9, 8));
    assert!(found.unused.is_empty());
    // both pairs of the mount are turned against each other by the direction of CM 2: Im((a6 + i
    // a7) (a4 − i a5) (a8 ± i a9)) = 0, four products of three
    let texts: Vec<&str> = found.dependences.iter().map(|dependence| dependence.text.as_str()).collect();
    assert_eq!(found.dependences.len(), 1, "{texts:?}");
    let mut products: Vec<Vec<usize>> = found.dependences[0].terms.iter().map(|term| term.0.clone()).collect();
    products.sort();
    assert_eq!(products, [[3, 5, 8], [3, 6, 7], [4, 5, 7], [4, 6, 8]], "{texts:?}");
    assert!(found.dependences[0].terms.iter().all(|term| (term.1.abs() - 1.0).abs() < 1e-6)); // of the null vector
}

#[test]
fn without_a_basis_the_dimensions_and_the_number_of_equations_are_the_same() {
    let found = span(RANGES, false);
    assert_eq!((found.span_dimension, found.manifold_dimension, found.dependences.len()), (8, 7, 1), "{found:?}");
}

#[test]
fn coefficients_of_the_arm_of_the_benchmark_are_the_published_ones() {
    let a = simulation::oracle::arm_parameters::ArmParameters::paper_table_ii();
    let [m1, m2] = a.link_mass_kg;
    let [i1, i2] = a.link_inertia_com_kg_m2;
    let exact = [
        a.base_mass_kg,
        m1,
        m2,
        a.base_inertia_com_kg_m2,
        i1,
        i2,
        a.r0_m[0],
        a.r0_m[1],
        a.l_m[0],
        a.l_m[1],
        a.l_m[0] + a.r_m[0],
        0.0,
    ];
    let mut ranges = exact.map(|x| (0.7 * x, 1.3 * x));
    ranges[11] = (0.0, 0.0);
    let found = span(ranges, true);
    for (found, truth) in found.coefficients.iter().zip(a.inertial_parameters_truth()) {
        assert!((found / truth - 1.0).abs() < 1e-12, "{found} {truth}"); // rounding × condition of the functions
    }
    assert_eq!(found.dependences.len(), 1);
}

#[test]
fn a_spatial_arm_is_answered_without_a_basis_and_a_wrong_basis_is_refused() {
    let model = |p: &[f64]| arm(p, JointKind::Revolute { axis: Vector3::z() }, JointKind::FreeSpatial);
    let family = ParameterFamily { ranges: &RANGES, model: &model };
    let found = momentum_span(&family, None, 1).unwrap();
    assert!(found.span_dimension > 8 && found.manifold_dimension <= found.span_dimension, "{found:?}");
    assert!(found.manifold_dimension <= 11);

    let planar = |p: &[f64]| arm(p, TURN, PLANAR);
    let family = ParameterFamily { ranges: &RANGES, model: &planar };
    let evaluate = |_: &[f64], v: &[f64], values: &mut [f64]| values.copy_from_slice(&v[..1]);
    let poor = MomentumBasis { names: vec!["w0".to_owned()], evaluate: &evaluate };
    assert!(matches!(momentum_span(&family, Some(&poor), 1), Err(MomentumSpanError::BasisIncomplete { .. })));
    let fixed = |p: &[f64]| arm(p, TURN, TURN);
    let family = ParameterFamily { ranges: &RANGES, model: &fixed };
    assert_eq!(momentum_span(&family, None, 1), Err(MomentumSpanError::NotFreeFloating));
}
