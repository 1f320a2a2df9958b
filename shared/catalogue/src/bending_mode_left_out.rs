//! A further bending mode of a slender appendage.

use super::geometry::{cross_f64, dot, norm};
use super::{applies, parts};
use dynamics::beam::{Cantilever, CantileverMode, integrate};
use dynamics::description::{Appendage, Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Scan, Spread};

/// Mode of the uniform cantilever whose first mode the plant states.
pub static EFFECT: Effect = Effect {
    kind: "bending_mode_left_out",
    title: "Further bending mode of a slender appendage",
    sites: &[SiteKind::Mode],
    applies: |plant, site| {
        applies::mode(plant, site).is_some_and(|(appendage, place)| place == 0 && Beam::of(appendage).is_ok())
    },
    parameters: &[
        EffectParameter::new("share", "1", [0.0, 2.0], 1.0, "its effective mass over that of a uniform beam")
            .amplitude(),
        EffectParameter::new("number", "1", [1.0, 6.0], 2.0, "which bending mode it is")
            .scanned(Scan::Each(&[2.0, 3.0, 4.0])),
        EffectParameter::new("frequency", "Hz", [0.01, 200.0], 1.0, "its frequency, hub locked").frequency(),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.2], 0.005, "its damping ratio")
            .damping_ratio(0.01, Spread::Absolute(0.05)),
    ],
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "The points of the appendage lie on a line and its first mode says where its root is and what it weighs: phi(tip) = 2/sqrt(m). The mode \
           has the shape and the participations of mode `number` of that uniform cantilever (Blevins 1979, table 8-1), both times \
           sqrt(share): the response to first order is linear in the share.",
    signature: "A narrow line at one frequency whose sign changes along the appendage.",
    confounders: "mode_left_out where few points are read; sensor_lag and sensor_delay of single accelerometers.",
    experiment: "Chirp through it; more accelerometers along the appendage.",
    ..Effect::PLAIN
};

/// Distance of a point from the line, over the distance of the two outermost ones. As drawings round
/// positions; chosen, no derivation.
const OFF_LINE_MAX: f64 = 0.02;

/// A uniform cantilever.
struct Beam {
    /// Along the beam, and along which it bends.
    axis: [f64; 3],
    across: [f64; 3],
    tip_m: [f64; 3],
    length_m: f64,
    mass_kg: f64,
    /// Of each point from the root.
    points_m: Vec<f64>,
}

impl Beam {
    /// The beam whose first mode is that of `appendage`: its outermost point is the tip.
    fn of(appendage: &Appendage) -> Result<Self, String> {
        let none = || format!("the points of {} are not those of a slender beam", appendage.name);
        let mode = appendage.modes.first().ok_or_else(none)?;
        let shapes: Vec<[f64; 3]> = mode.shape_per_sqrt_kg.iter().map(|shape| shape.map(|x| x.value)).collect();
        let points: Vec<[f64; 3]> = appendage.points.iter().map(|(_, at)| at.map(|x| x.value)).collect();
        let tip = (0..shapes.len()).max_by(|a, b| norm(shapes[*a]).total_cmp(&norm(shapes[*b]))).ok_or_else(none)?;
        let from_tip = |at: &[f64; 3]| core::array::from_fn(|i| points[tip][i] - at[i]);
        let far = |a: &usize, b: &usize| norm(from_tip(&points[*a])).total_cmp(&norm(from_tip(&points[*b])));
        let first = (0..points.len()).max_by(far).ok_or_else(none)?;
        let (span, largest) = (from_tip(&points[first]), norm(shapes[tip]));
        let reach = norm(span);
        let (axis, across) = (span.map(|x| x / reach), shapes[tip].map(|x| x / largest));
        let is_on_line = |at: &[f64; 3]| norm(cross_f64(axis, from_tip(at))) < OFF_LINE_MAX * reach;
        let ratio = dot(shapes[first], across) / largest;
        if points.len() < 3 || !(ratio > 0.0 && ratio < 1.0) || !points.iter().all(is_on_line) {
            return Err(none());
        }
        let mass_kg = 4.0 / (largest * largest);
        let shape_at_first = |length_m: f64| {
            let mode = cantilever(length_m, mass_kg).mode(1);
            mode.shape(length_m - reach) / mode.shape(length_m)
        };
        // the shape at a distance from the tip rises with the length, from none at the root
        let (mut low, mut high) = (reach, 20.0 * reach);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if shape_at_first(middle) < ratio { low = middle } else { high = middle }
        }
        let points_m = points.iter().map(|at| low - dot(axis, from_tip(at))).collect();
        Ok(Self { axis, across, tip_m: points[tip], length_m: low, mass_kg, points_m })
    }

    fn mode(&self, number: usize) -> CantileverMode {
        cantilever(self.length_m, self.mass_kg).mode(number)
    }

    /// `∫ ρ φ f(r) dx` of a vector function of the position.
    fn participation(&self, mode: &CantileverMode, of: impl Fn([f64; 3]) -> [f64; 3]) -> [f64; 3] {
        let density = self.mass_kg / self.length_m;
        let at = |x: f64| core::array::from_fn(|i| self.tip_m[i] + (x - self.length_m) * self.axis[i]);
        core::array::from_fn(|i| integrate(self.length_m, |x| density * mode.shape(x) * of(at(x))[i]))
    }
}

fn cantilever(length_m: f64, mass_kg: f64) -> Cantilever {
    Cantilever { length_m, mass_per_length_kg_m: mass_kg / length_m, bending_stiffness_n_m2: 1.0 }
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (share, number) = (p[0], libm::round(p[1]) as usize);
    if share == 0.0 {
        return Ok(());
    }
    let name = parts::free_name(plant, &format!("{}_bending_{number}", site.name));
    let (appendage, place) = parts::mode_mut(plant, site)?;
    let beam = Beam::of(appendage)?;
    let (own, root) = (beam.mode(number), libm::sqrt(share));
    let mut mode = appendage.modes[place].clone();
    mode.name = name;
    (mode.frequency_hz, mode.damping_ratio) = (Quantity::known(p[2]), Quantity::known(p[3]));
    let scaled = |vector: [f64; 3]| vector.map(|x| Quantity::known(root * x));
    mode.translation_sqrt_kg = scaled(beam.participation(&own, |_| beam.across));
    mode.rotation_sqrt_kg_m = scaled(beam.participation(&own, |at| cross_f64(at, beam.across)));
    let shape = |x: &f64| scaled(beam.across.map(|across| own.shape(*x) * across));
    mode.shape_per_sqrt_kg = beam.points_m.iter().map(shape).collect();
    parts::add_mode_beside(plant, site, mode)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;

    /// A uniform beam of 1 kg and 4 m along x, clamped 1 m off the hub's origin.
    fn with_beam() -> Plant {
        let mut plant = plant();
        let appendage = &mut plant.appendages[0];
        let beam = Beam {
            axis: [1.0, 0.0, 0.0],
            across: [0.0, 1.0, 0.0],
            tip_m: [5.0, 0.0, 0.0],
            length_m: 4.0,
            mass_kg: 1.0,
            points_m: vec![0.5, 1.5, 2.5, 4.0],
        };
        let at = |x: &f64| (format!("p{x}"), [1.0 + x, 0.0, 0.0].map(Quantity::known));
        appendage.points = beam.points_m.iter().map(at).collect();
        appendage.modes.truncate(1);
        let (own, mode) = (beam.mode(1), &mut appendage.modes[0]);
        let known = |vector: [f64; 3]| vector.map(Quantity::known);
        mode.shape_per_sqrt_kg = beam.points_m.iter().map(|x| known([0.0, own.shape(*x), 0.0])).collect();
        mode.translation_sqrt_kg = known(beam.participation(&own, |_| beam.across));
        mode.rotation_sqrt_kg_m = known(beam.participation(&own, |at| cross_f64(at, beam.across)));
        plant
    }

    fn built(number: f64) -> [dynamics::description::Mode; 2] {
        let mut plant = with_beam();
        let site = Site { kind: SiteKind::Mode, name: plant.appendages[0].modes[0].name.clone() };
        build(&mut plant, &site, &[1.0, number, 7.0, 0.01]).unwrap();
        let modes = &plant.appendages[0].modes;
        [modes[0].clone(), modes[1].clone()]
    }

    #[test]
    fn the_first_mode_of_the_beam_is_the_mode_that_the_plant_states() {
        let [stated, own] = built(1.0);
        let numbers = |mode: &dynamics::description::Mode| {
            let shapes = mode.shape_per_sqrt_kg.iter().flatten();
            let all = shapes.chain(&mode.translation_sqrt_kg).chain(&mode.rotation_sqrt_kg_m);
            all.map(|x| x.value).collect::<Vec<_>>()
        };
        for (a, b) in numbers(&stated).into_iter().zip(numbers(&own)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn the_participation_of_rotation_is_that_of_the_closed_integral() {
        // of x W over the beam 2/beta^2 (Hughes 1980), clamped 1 m off the axis: m = 1 kg, L = 4 m
        for (number, beta_l, translation) in [(1.0, 1.875_104, 0.7830), (2.0, 4.694_091, 0.4339)] {
            let [_, own] = built(number);
            let expected = translation * 1.0 + 4.0 * 2.0 / (beta_l * beta_l);
            let found = own.rotation_sqrt_kg_m.map(|x| x.value);
            assert!((found[2].abs() - expected).abs() < 1e-3, "{found:?} {expected}");
            assert!(found[0].abs() < 1e-12 && found[1].abs() < 1e-12);
            // y at positive x turns about z the same way
            assert!(found[2] * own.translation_sqrt_kg[1].value > 0.0);
        }
    }

    #[test]
    fn the_second_mode_has_its_tabulated_participation_and_a_node() {
        let [_, own] = built(2.0);
        // 0.4339 of the root of the mass (Blevins, table 8-1: 2 sigma/(beta l))
        assert!((own.translation_sqrt_kg[1].value.abs() - 0.4339).abs() < 1e-3);
        let shapes: Vec<f64> = own.shape_per_sqrt_kg.iter().map(|shape| shape[1].value).collect();
        assert!(shapes[1] * shapes[3] < 0.0, "{shapes:?}");
    }
}
