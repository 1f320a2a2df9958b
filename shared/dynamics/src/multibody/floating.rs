//! Rates of a free base that give the tree a wanted momentum.

use super::data::Data;
use super::inertia::{Factor3, SpatialInertia};
use super::kinematics::{kinematics, velocities};
use super::model::{Joint, Model};
use super::vector::{Sym3, V3};

/// Inertia of a tree locked in its pose, and its momentum, about the origin of its first link,
/// world axes.
#[derive(Clone, Copy, Debug, Default)]
struct Locked {
    inertia: Sym3<f64>,
    first_moment: V3<f64>,
    mass: f64,
    angular: V3<f64>,
    linear: V3<f64>,
}

/// Sets the rates of link 0 so that, with all other rates `v` as they are, the linear momentum of
/// its tree is zero and its angular momentum about the centre of mass is `momentum_n_m_s` (axes of
/// link 0). Leaves the kinematics of the result in `data`. Returns false, and changes nothing,
/// where link 0 is not free.
///
/// `I_locked V = h − h(V = 0)`, all about the origin of link 0: about the centre of mass they are
/// the same when that rests.
///
/// Cost: [`kinematics`], a sum over the links and one more pass over velocities; no allocation.
pub fn float_at_momentum(
    model: &Model,
    data: &mut Data<f64>,
    q: &[f64],
    v: &mut [f64],
    momentum_n_m_s: [f64; 3],
) -> bool {
    let base = &model.links[0];
    if !matches!(base.joint, Joint::FreePlanar | Joint::FreeSpatial) {
        return false;
    }
    v[base.v..base.v + base.v_len].fill(0.0);
    kinematics(model, data, q, v);
    let locked = if model.plane { locked_in_plane(model, data, v) } else { locked(model, data, v) };
    let frame = data.link(0);
    let wanted = V3::from(momentum_n_m_s);
    if base.joint == Joint::FreePlanar {
        let (n, x, y) = (frame.rotation.column_z(), frame.rotation.column_x(), frame.rotation.column_y());
        let swept = n.cross(locked.first_moment);
        let (xx, m) = (n.dot(locked.inertia.apply(n)), locked.mass);
        let block = Sym3 { xx, xy: x.dot(swept), xz: y.dot(swept), yy: m, yz: 0.0, zz: m };
        let missing = V3::new(wanted.z - n.dot(locked.angular), -x.dot(locked.linear), -y.dot(locked.linear));
        Factor3::of(&block).solve(missing).write(v, base.v);
    } else {
        let whole = SpatialInertia::rigid(locked.inertia, locked.first_moment, locked.mass);
        let (omega, velocity) = whole.solve(frame.rotation.apply(wanted) - locked.angular, -locked.linear);
        frame.rotation.apply_transposed(omega).write(v, base.v);
        frame.rotation.apply_transposed(velocity).write(v, base.v + 3);
    }
    velocities(model, data, v);
    true
}

/// Sum over the links that link 0 carries, itself included.
fn locked(model: &Model, data: &Data<f64>, v: &[f64]) -> Locked {
    let mut sum = Locked::default();
    let origin = data.link(0).origin;
    let of_tree = |link: usize| model.links[link].root == 0;
    for (i, link) in model.links.iter().enumerate().filter(|(i, _)| of_tree(*i)) {
        let frame = data.link(i);
        let mut inertia = if model.plane {
            Sym3 { zz: link.inertia_origin.zz, ..Sym3::zero() }
        } else {
            frame.rotation.congruence(&link.inertia_origin)
        };
        let (mut first_moment, mut mass) = (frame.rotation.apply_constant(&link.first_moment), link.mass);
        if frame.carried.acts {
            let (more, carried_mass) = frame.carried_moment();
            inertia += frame.carried_inertia().a;
            (first_moment, mass) = (first_moment + more, mass + carried_mass);
        }
        let r = frame.origin - origin;
        let linear = frame.velocity * mass + frame.omega.cross(first_moment);
        let angular = inertia.apply(frame.omega) + first_moment.cross(frame.velocity);
        sum.inertia += moved(&inertia, first_moment, mass, r);
        sum.first_moment += first_moment + r * mass;
        sum.mass += mass;
        sum.angular += angular + r.cross(linear);
        sum.linear += linear;
    }
    add_internals(model, data, v, &mut sum);
    sum
}

/// [`locked`] where everything lies in the plane: the components that do not vanish.
fn locked_in_plane(model: &Model, data: &Data<f64>, v: &[f64]) -> Locked {
    let mut sum = Locked::default();
    let origin = data.link(0).origin;
    for (i, link) in model.links.iter().enumerate().filter(|(_, link)| link.root == 0) {
        let frame = data.link(i);
        let rows = &frame.rotation.rows;
        let mut inertia = link.inertia_origin.zz;
        let (mut gx, mut gy, mut mass) = (
            rows[0].x * link.first_moment.x + rows[0].y * link.first_moment.y,
            rows[1].x * link.first_moment.x + rows[1].y * link.first_moment.y,
            link.mass,
        );
        if frame.carried.acts {
            let (more, carried_mass) = frame.carried_moment();
            inertia += frame.carried_inertia().a.zz;
            (gx, gy, mass) = (gx + more.x, gy + more.y, mass + carried_mass);
        }
        let (rx, ry) = (frame.origin.x - origin.x, frame.origin.y - origin.y);
        let (omega, vx, vy) = (frame.omega.z, frame.velocity.x, frame.velocity.y);
        let (px, py) = (vx * mass - omega * gy, vy * mass + omega * gx);
        sum.inertia.zz += inertia + 2.0 * (rx * gx + ry * gy) + mass * (rx * rx + ry * ry);
        sum.first_moment += V3::new(gx + rx * mass, gy + ry * mass, 0.0);
        sum.mass += mass;
        sum.angular.z += inertia * omega + gx * vy - gy * vx + rx * py - ry * px;
        sum.linear += V3::new(px, py, 0.0);
    }
    add_internals(model, data, v, &mut sum);
    sum
}

/// Momentum of the internal coordinates.
fn add_internals(model: &Model, data: &Data<f64>, v: &[f64], sum: &mut Locked) {
    let origin = data.link(0).origin;
    for internal in model.internals.iter().filter(|internal| model.links[internal.link].root == 0) {
        let frame = data.link(internal.link);
        let linear = frame.rotation.apply(internal.linear) * v[internal.v];
        sum.angular += frame.rotation.apply(internal.angular) * v[internal.v] + (frame.origin - origin).cross(linear);
        sum.linear += linear;
    }
}

/// Inertia about a point from which `r` leads to the old one: `A + 2 r·g 1 − r gᵀ − g rᵀ`,
/// `g = h + ½ m r`.
fn moved(inertia: &Sym3<f64>, first_moment: V3<f64>, mass: f64, r: V3<f64>) -> Sym3<f64> {
    let g = first_moment + r * (0.5 * mass);
    let twice = 2.0 * r.dot(g);
    Sym3 {
        xx: inertia.xx + twice - 2.0 * r.x * g.x,
        xy: inertia.xy - r.x * g.y - r.y * g.x,
        xz: inertia.xz - r.x * g.z - r.z * g.x,
        yy: inertia.yy + twice - 2.0 * r.y * g.y,
        yz: inertia.yz - r.y * g.z - r.z * g.y,
        zz: inertia.zz + twice - 2.0 * r.z * g.z,
    }
}
