//! Descriptions that are no mechanism, and what is said about them.

use super::*;

fn refused(change: impl FnOnce(&mut Vec<Link>, &mut Vec<InternalCoordinate>)) -> ModelError {
    let mut draw = Draw::new(1);
    let mut links = vec![draw.link(None, JointKind::FreeSpatial)];
    links.push(draw.link(Some(0), JointKind::Revolute { axis: Vector3::y() }));
    let mut internals = vec![draw.internal(1)];
    change(&mut links, &mut internals);
    Model::new(&links, &internals, GRAVITY).expect_err("it is no mechanism")
}

#[test]
fn every_fault_of_a_description_is_named_with_its_link_and_number() {
    assert_eq!(refused(|links, _| links.clear()), ModelError::Empty);
    let error = refused(|links, _| links[1].parent = Some(1));
    assert_eq!(error, ModelError::ParentNotBefore { link: 1, parent: 1 });
    let error = refused(|links, _| links[1].com_m.y = f64::NAN);
    assert_eq!(error, ModelError::NotFinite { link: 1, field: "centre of mass" });
    let error = refused(|links, _| links[1].joint = JointKind::Revolute { axis: Vector3::new(0.0, 2.0, 0.0) });
    assert_eq!(error, ModelError::AxisNotUnit { link: 1, length: 2.0 });
    let error = refused(|links, _| links[0].rotation = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)));
    assert_eq!(error, ModelError::NotARotation { link: 0, error: 2.0 });
    let error = refused(|links, _| links[1].mass_kg = -3.0);
    assert_eq!(error, ModelError::NegativeMass { link: 1, mass_kg: -3.0 });
    let error = refused(|links, _| links[0].inertia_com_kg_m2 = -Matrix3::identity());
    assert_eq!(error, ModelError::InertiaNotPositive { link: 0, smallest_kg_m2: -1.0 });
    assert_eq!(refused(|links, _| links[0].armature = 0.1), ModelError::Armature { link: 0, armature: 0.1 });
    let error = refused(|_, internals| internals[0].link = 7);
    assert_eq!(error, ModelError::NoSuchLink { internal: 0, link: 7 });
    let error = refused(|_, internals| internals[0].mass = 0.0);
    assert_eq!(error, ModelError::InternalMass { internal: 0, mass: 0.0 });
}

#[test]
fn a_coordinate_that_moves_no_inertia_is_named() {
    let error = refused(|links, internals| {
        (links[1].mass_kg, links[1].inertia_com_kg_m2, links[1].armature) = (0.0, Matrix3::zeros(), 0.0);
        internals.clear();
    });
    assert!(matches!(error, ModelError::MassMatrixNotPositive { v_index: 6, .. }), "{error}");
    // a mode that moves more than the spacecraft has
    let error = refused(|_, internals| internals[0].coupling = [0.0, 0.0, 0.0, 50.0, 0.0, 0.0]);
    assert!(matches!(error, ModelError::MassMatrixNotPositive { v_index: 7, .. }), "{error}");
}

#[test]
fn indices_follow_the_links_and_internal_coordinates_come_last() {
    let mut draw = Draw::new(2);
    let links = [
        draw.link(None, JointKind::FreeSpatial),
        draw.link(Some(0), JointKind::Fixed),
        draw.link(Some(1), JointKind::Revolute { axis: Vector3::x() }),
        draw.link(None, JointKind::FreePlanar),
    ];
    let internals = [draw.internal(2), draw.internal(0)];
    let model = Model::new(&links, &internals, GRAVITY).unwrap();
    assert_eq!((model.q_len(), model.v_len()), (7 + 1 + 3, 6 + 1 + 3 + 2));
    assert_eq!([0, 1, 2, 3].map(|link| model.q_index(link)), [0, 7, 7, 8]);
    assert_eq!([0, 1, 2, 3].map(|link| model.v_index(link)), [0, 6, 6, 7]);
    assert_eq!([0, 1].map(|internal| model.v_index_internal(internal)), [10, 11]);
    assert_eq!([0, 2, 3].map(|link| model.parent(link)), [None, Some(1), None]);
}
