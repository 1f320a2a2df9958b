use super::super::{JointKind, Link};
use super::*;
use nalgebra::{Matrix3, Vector3};

/// A planar or spatial arm of bodies without symmetry.
fn arm(base: JointKind, axes: &[Vector3<f64>], gravity: Vector3<f64>) -> Model {
    let link = |parent, joint, k: f64| Link {
        parent,
        joint,
        position_m: Vector3::new(0.9 + 0.1 * k, 0.2 * k, 0.1 * k),
        rotation: Matrix3::identity(),
        mass_kg: 5.0 + k,
        com_m: Vector3::new(0.3, 0.1 + 0.05 * k, -0.04),
        inertia_com_kg_m2: Matrix3::new(2.0, 0.1, 0.2, 0.1, 3.0, -0.1, 0.2, -0.1, 4.0),
        armature: 0.0,
    };
    let mut links = vec![link(None, base, 0.0)];
    for (i, axis) in axes.iter().enumerate() {
        links.push(link(Some(i), JointKind::Revolute { axis: *axis }, 1.0 + i as f64));
    }
    Model::new(&links, &[], gravity).unwrap()
}

fn names(model: &Model) -> Vec<String> {
    let links: Vec<String> = (0..model.links_len()).map(|i| format!("link_{i}")).collect();
    standard_parameter_names(&links.iter().map(String::as_str).collect::<Vec<_>>())
}

fn identify(model: &Model, rows: RegressorRows<'_>) -> (DMatrix<f64>, BaseParameters) {
    let stacked = stacked_regressor(model, rows, 200, 1);
    let found = base_parameters(&stacked, &names(model));
    (stacked, found)
}

#[test]
fn base_parameters_reproduce_the_efforts_of_all_standard_parameters() {
    let (y, z) = (Vector3::y(), Vector3::z());
    for base in [JointKind::Fixed, JointKind::FreePlanar, JointKind::FreeSpatial] {
        let model = arm(base, &[z, y, z], Vector3::new(0.0, 0.0, -9.81));
        let (stacked, found) = identify(&model, RegressorRows::Efforts);
        assert!(found.gap > 1e6, "{base:?}: {}", found.gap); // rounding against excitation
        let standard = model.standard_parameters();
        let efforts = &stacked * DVector::from_column_slice(&standard);
        let independent: Vec<usize> = found.base.iter().map(|base| base.terms[0].0).collect();
        let reduced = stacked.select_columns(&independent) * DVector::from_vec(found.values(&standard));
        assert!((efforts.clone() - reduced).norm() <= 1e-11 * efforts.norm()); // rounding × condition
    }
}

/// Counts of the literature: a single planar pendulum has one without gravity (its inertia) and
/// three with it; a planar arm of two links three and seven … ; a free-flying rigid body all ten.
#[test]
fn numbers_of_base_parameters_are_the_known_ones() {
    let z = Vector3::z();
    let down = Vector3::new(0.0, -9.81, 0.0);
    let rank =
        |base, axes: &[Vector3<f64>], gravity| identify(&arm(base, axes, gravity), RegressorRows::Efforts).1.rank();
    assert_eq!(rank(JointKind::Fixed, &[z], Vector3::zeros()), 1);
    assert_eq!(rank(JointKind::Fixed, &[z], down), 3);
    // joint 1: I1 + m2 L²; joint 2: mcx, mcy, Izz of the outer link
    assert_eq!(rank(JointKind::Fixed, &[z, z], Vector3::zeros()), 4);
    assert_eq!(rank(JointKind::FreeSpatial, &[], Vector3::zeros()), 10);
    // each further revolute joint brings seven: Khalil & Dombre, table of minimal parameters
    assert_eq!(rank(JointKind::FreeSpatial, &[z], Vector3::zeros()), 17);
    assert_eq!(rank(JointKind::FreeSpatial, &[z, Vector3::y()], Vector3::zeros()), 24);
    // a planar free-flyer: m, mcx, mcy, Izz; each joint three more
    assert_eq!(rank(JointKind::FreePlanar, &[z, z], Vector3::zeros()), 10);
}

#[test]
fn an_outer_mass_regroups_into_the_inner_link_with_the_joint_offset() {
    let model = arm(JointKind::Fixed, &[Vector3::z(), Vector3::z()], Vector3::new(0.0, -9.81, 0.0));
    let (_, found) = identify(&model, RegressorRows::Efforts);
    let texts: Vec<&str> = found.base.iter().map(|base| base.text.as_str()).collect();
    // joint 2 sits at (1.1, 0.4) in link 1
    assert_eq!(
        texts,
        [
            "link_1.mcx + 1.1 link_2.m",
            "link_1.mcy + 0.4 link_2.m",
            "link_1.Izz + 1.37 link_2.m",
            "link_2.mcx",
            "link_2.mcy",
            "link_2.Izz",
        ]
    );
    assert_eq!(found.regrouped, ["link_2.m"]);
    assert!(found.unidentifiable.contains(&"link_0.m".to_owned()));
    assert!(found.unidentifiable.contains(&"link_1.Ixx".to_owned()));
    assert!(found.condition_number > 1.0 && found.condition_number < 100.0);
}

#[test]
fn joint_rows_alone_see_less_than_all_rows_and_momentum_sees_as_much_as_efforts() {
    let model = arm(JointKind::FreePlanar, &[Vector3::z(), Vector3::z()], Vector3::zeros());
    let all = identify(&model, RegressorRows::Efforts).1.rank();
    let joints = identify(&model, RegressorRows::Chosen(&[3, 4])).1.rank();
    assert!(joints < all, "{joints} {all}");
    let spatial = arm(JointKind::FreeSpatial, &[Vector3::z(), Vector3::y()], Vector3::zeros());
    let efforts = identify(&spatial, RegressorRows::Efforts).1.rank();
    assert_eq!(identify(&spatial, RegressorRows::Momentum).1.rank(), efforts);
}

#[test]
fn scaling_the_units_of_a_column_changes_neither_rank_nor_combinations() {
    let model = arm(JointKind::FreeSpatial, &[Vector3::z(), Vector3::y()], Vector3::zeros());
    let (mut stacked, plain) = identify(&model, RegressorRows::Efforts);
    for (c, mut column) in stacked.column_iter_mut().enumerate() {
        column *= if c % 2 == 0 { 1e-4 } else { 1e4 };
    }
    let scaled = base_parameters(&stacked, &names(&model));
    assert_eq!(plain.rank(), scaled.rank());
    assert_eq!(plain.regrouped, scaled.regrouped);
    assert!((plain.condition_number / scaled.condition_number - 1.0).abs() < 1e-9); // rounding × condition
}
