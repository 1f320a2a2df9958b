//! Modes and wheels that take more inertia along than their body has.

use super::{At, Check, Fault, Place};
use dynamics::description::{ActuatorKind, Body, Plant, Quantity, Space};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

type Matrix6 = SMatrix<f64, 6, 6>;
type Vector6 = SVector<f64, 6>;

/// One internal coordinate of a body, scaled to mass one: rotation, translation.
struct Share {
    place: Place,
    vector: Vector6,
}

impl Check<'_> {
    pub(super) fn participation(&mut self) {
        let plant = self.plant;
        self.faults.extend(plant.bodies.iter().enumerate().filter_map(|(i, body)| overload(plant, i, body)));
    }
}

/// A warning where the inertia that is left to `body` beside its modes and wheels is not positive:
/// `I − Σ D Dᵀ`, `D` the participations `[ρ; δ]`, of a wheel `√J [axis; 0]`.
///
/// A heavier neighbour may still keep the equations possible; a body of that kind does not exist.
pub(super) fn overload(plant: &Plant, index: usize, body: &Body) -> Option<Fault> {
    let shares = shares(plant, body);
    let inertia = about_origin(plant.space, body);
    let finite = inertia.iter().chain(shares.iter().flat_map(|share| share.vector.iter())).all(|x| x.is_finite());
    if shares.is_empty() || !finite {
        return None;
    }
    let taken = shares.iter().fold(Matrix6::zeros(), |sum, share| sum + share.vector * share.vector.transpose());
    // every coordinate by its own inertia: metres and radians become comparable
    let size: Vector6 = (inertia + taken).diagonal().map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 0.0 });
    let scaled = |m: &Matrix6| Matrix6::from_fn(|i, j| size[i] * m[(i, j)] * size[j]);
    let eigen = scaled(&(inertia - taken)).symmetric_eigen();
    let least = (0..6).filter(|k| moves(&size, &eigen.eigenvectors.column(*k).into()));
    let least = least.min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]))?;
    let direction: Vector6 = eigen.eigenvectors.column(least).into();
    let own = direction.dot(&(scaled(&inertia) * direction));
    // a body without inertia in that direction, which nothing takes along, is none of our business
    if eigen.eigenvalues[least] > 1e-12 || (own < 1e-12 && eigen.eigenvalues[least] > -1e-12) {
        return None;
    }
    let weight = |share: &Share| size.component_mul(&share.vector).dot(&direction).abs();
    let culprit = shares.iter().max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
    let key = if culprit.place.section == "actuator" { "inertia" } else { leading(&size, &direction) };
    let key = if culprit.place.key.is_empty() { key.to_owned() } else { format!("{}.{key}", culprit.place.key) };
    let at = At::new("body", index, &body.name);
    Some(Fault {
        place: Place { key, ..culprit.place.clone() },
        message: message_of(plant.space, &at, &inertia, &taken),
        cure: "mass and inertia of a body include its undeformed appendages and locked wheels".into(),
        warning: true,
        because_of: ["mass", "com", "inertia"].map(|key| at.place(key)).into_iter().chain(parts(&shares)).collect(),
    })
}

fn parts(shares: &[Share]) -> impl Iterator<Item = Place> {
    let keys = |share: &Share| {
        let of = share.place.clone();
        let key = move |key: &str| if of.key.is_empty() { key.to_owned() } else { format!("{}.{key}", of.key) };
        let place = share.place.clone();
        ["translation", "rotation", "inertia", "axis"].map(|name| Place { key: key(name), ..place.clone() })
    };
    shares.iter().flat_map(keys).collect::<Vec<_>>().into_iter()
}

/// A direction of the plant's space, not one that a plane lacks.
fn moves(size: &Vector6, direction: &Vector6) -> bool {
    (0..6).any(|i| size[i] > 0.0 && direction[i].abs() > 1e-6)
}

fn leading(size: &Vector6, direction: &Vector6) -> &'static str {
    let largest = (0..6).filter(|i| size[*i] > 0.0).max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs()));
    if largest.is_some_and(|i| i >= 3) { "translation" } else { "rotation" }
}

/// The single axis at fault, where it is one.
fn message_of(space: Space, at: &At, inertia: &Matrix6, taken: &Matrix6) -> String {
    let named = ["kg*m^2 about x", "kg*m^2 about y", "kg*m^2 about z", "kg along x", "kg along y", "kg along z"];
    let order = if space == Space::Planar { vec![3, 4, 2] } else { vec![3, 4, 5, 0, 1, 2] };
    let axis = order.into_iter().find(|i| taken[(*i, *i)] > 0.0 && taken[(*i, *i)] >= inertia[(*i, *i)]);
    let what = &at.what;
    match axis {
        Some(i) => format!(
            "modes and wheels of {what} take {} {} of its {} along (about its origin)",
            taken[(i, i)],
            named[i],
            inertia[(i, i)]
        ),
        None => format!("modes and wheels of {what} together take more inertia along in some direction than it has"),
    }
}

fn shares(plant: &Plant, body: &Body) -> Vec<Share> {
    let mut list = Vec::new();
    let six =
        |a: &[Quantity; 3], b: &[Quantity; 3]| Vector6::from_fn(|i, _| if i < 3 { a[i].value } else { b[i - 3].value });
    for (i, appendage) in plant.appendages.iter().enumerate().filter(|(_, appendage)| appendage.body == body.name) {
        for (k, mode) in appendage.modes.iter().enumerate() {
            let place = Place { section: "appendage", index: i, key: format!("mode.{k}") };
            list.push(Share { place, vector: six(&mode.rotation_sqrt_kg_m, &mode.translation_sqrt_kg) });
        }
    }
    for (index, actuator) in plant.actuators.iter().enumerate() {
        let ActuatorKind::Wheel { body: of, axis, inertia_kg_m2, .. } = &actuator.kind else { continue };
        if *of == body.name && inertia_kg_m2.value > 0.0 {
            let root = inertia_kg_m2.value.sqrt();
            let place = Place { section: "actuator", index, key: String::new() };
            list.push(Share { place, vector: Vector6::from_fn(|i, _| if i < 3 { root * axis[i] } else { 0.0 }) });
        }
    }
    list
}

/// Spatial inertia about the body's origin, rotation first; in a plane only about z and along x and
/// y.
fn about_origin(space: Space, body: &Body) -> Matrix6 {
    let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|q| q.value);
    let (mass, com) = (body.mass_kg.value, Vector3::from(body.com_m.map(|q| q.value)));
    let steiner = (Matrix3::identity() * com.norm_squared() - com * com.transpose()) * mass;
    let mut inertia = Matrix6::zeros();
    inertia.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) + steiner));
    inertia.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Matrix3::identity() * mass));
    let moment = com.cross_matrix() * mass;
    inertia.fixed_view_mut::<3, 3>(0, 3).copy_from(&moment);
    inertia.fixed_view_mut::<3, 3>(3, 0).copy_from(&moment.transpose());
    if space == Space::Planar {
        for out in [0, 1, 5] {
            inertia.row_mut(out).fill(0.0);
            inertia.column_mut(out).fill(0.0);
        }
    }
    inertia
}
