//! Two modes with an elastic coupling.

use super::applies::mode;
use super::parts;
use core::f64::consts::TAU;
use dynamics::description::{Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Elastic coupling of two modes: modal stiffness `[[ω1², c ω1 ω2], [c ω1 ω2, ω2²]]`.
pub static EFFECT: Effect = Effect {
    kind: "mode_coupling",
    title: "Elastic coupling of a mode to the next one",
    sites: &[SiteKind::Mode],
    applies: has_next,
    parameters: &[EffectParameter::new("coupling", "1", [-0.9, 0.9], 0.1, "coupling stiffness over w1 w2").amplitude()],
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "Modal stiffness [[w1^2, c w1 w2], [c w1 w2, w2^2]] with the next mode of the appendage, written in its own modes: frequencies \
           repel, participations and shapes mix. Damping stays diagonal (its mixing is of the order zeta).",
    signature: "Beating between two lines; a mode seen where its shape says it should not be.",
    confounders: "Errors of the two frequencies and shapes; mode_left_out close to one of them.",
    experiment: "Excite along the participation of one mode only.",
    ..Effect::PLAIN
};

fn has_next(plant: &Plant, site: &Site) -> bool {
    mode(plant, site).is_some_and(|(appendage, place)| place + 1 < appendage.modes.len())
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    let (appendage, place) = parts::mode_mut(plant, site)?;
    let [first, second, ..] = &mut appendage.modes[place..] else {
        return Err(format!("{site} is the last mode of {}", appendage.name));
    };
    let (w_1, w_2) = (TAU * first.frequency_hz.value, TAU * second.frequency_hz.value);
    let (sin, cos, squares) = rotation(w_1, w_2, p[0])?;
    let turn = |a: &mut Quantity, b: &mut Quantity| {
        (a.value, b.value) = (cos * a.value + sin * b.value, cos * b.value - sin * a.value);
    };
    for axis in 0..3 {
        turn(&mut first.translation_sqrt_kg[axis], &mut second.translation_sqrt_kg[axis]);
        turn(&mut first.rotation_sqrt_kg_m[axis], &mut second.rotation_sqrt_kg_m[axis]);
        for (a, b) in first.shape_per_sqrt_kg.iter_mut().zip(&mut second.shape_per_sqrt_kg) {
            turn(&mut a[axis], &mut b[axis]);
        }
    }
    let (d_1, d_2) = (first.damping_ratio.value * w_1, second.damping_ratio.value * w_2);
    let (omega_1, omega_2) = (libm::sqrt(squares[0]), libm::sqrt(squares[1]));
    first.damping_ratio.value = (cos * cos * d_1 + sin * sin * d_2) / omega_1;
    second.damping_ratio.value = (sin * sin * d_1 + cos * cos * d_2) / omega_2;
    first.frequency_hz.value = omega_1 / TAU;
    second.frequency_hz.value = omega_2 / TAU;
    Ok(())
}

/// Sine and cosine of the angle, at most 45°, that makes the stiffness diagonal, and the squared
/// frequencies then.
fn rotation(w_1: f64, w_2: f64, coupling: f64) -> Result<(f64, f64, [f64; 2]), String> {
    if coupling.abs() >= 1.0 {
        return Err(format!("a coupling of {coupling} leaves no positive stiffness"));
    }
    let (a, b, c) = (w_1 * w_1, w_2 * w_2, coupling * w_1 * w_2);
    let angle = if a >= b { 0.5 * libm::atan2(2.0 * c, a - b) } else { -0.5 * libm::atan2(2.0 * c, b - a) };
    let (sin, cos) = libm::sincos(angle);
    let squares =
        [a * cos * cos + 2.0 * c * sin * cos + b * sin * sin, a * sin * sin - 2.0 * c * sin * cos + b * cos * cos];
    Ok((sin, cos, squares))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;

    #[test]
    fn frequencies_are_the_eigenvalues_of_the_coupled_stiffness() {
        for (w_1, w_2) in [(1.0, 3.0), (3.0, 1.0), (2.0, 2.0)] {
            for coupling in [-0.8, -0.1, 0.3, 0.9] {
                let (sin, cos, squares) = rotation(w_1, w_2, coupling).unwrap();
                let (trace, c) = (w_1 * w_1 + w_2 * w_2, coupling * w_1 * w_2);
                let determinant = w_1 * w_1 * w_2 * w_2 - c * c;
                assert!((squares[0] + squares[1] - trace).abs() < 1e-14 * trace); // rounding
                assert!((squares[0] * squares[1] - determinant).abs() < 1e-13 * trace * trace);
                assert!(cos > 0.7 && (sin * sin + cos * cos - 1.0).abs() < 1e-15);
            }
        }
        assert!(rotation(1.0, 2.0, 1.0).is_err());
    }

    #[test]
    fn compliance_from_hub_to_hub_is_that_of_the_coupled_stiffness() {
        // static compliance δᵀ K⁻¹ δ, before the change of basis and after
        let mut built = plant();
        let modes = &plant().appendages[0].modes;
        let (w_1, w_2) = (TAU * modes[0].frequency_hz.value, TAU * modes[1].frequency_hz.value);
        let (d_1, d_2) = (modes[0].translation_sqrt_kg[1].value, modes[1].translation_sqrt_kg[1].value);
        let c = 0.4 * w_1 * w_2;
        let determinant = w_1 * w_1 * w_2 * w_2 - c * c;
        let expected = (d_1 * d_1 * w_2 * w_2 - 2.0 * d_1 * d_2 * c + d_2 * d_2 * w_1 * w_1) / determinant;
        build(&mut built, &"mode:bending".parse().unwrap(), &[0.4]).unwrap();
        let found: f64 = built.appendages[0]
            .modes
            .iter()
            .map(|mode| {
                let (d, w) = (mode.translation_sqrt_kg[1].value, TAU * mode.frequency_hz.value);
                d * d / (w * w)
            })
            .sum();
        assert!((found - expected).abs() < 1e-13 * expected); // rounding
        let effective = |plant: &Plant| -> f64 {
            plant.appendages[0]
                .modes
                .iter()
                .map(|m| m.translation_sqrt_kg[1].value * m.translation_sqrt_kg[1].value)
                .sum()
        };
        assert!((effective(&built) - effective(&plant())).abs() < 1e-14 * 10.0); // effective mass is shared anew, not made
        assert!(build(&mut built, &"mode:second".parse().unwrap(), &[0.4]).is_err());
    }
}
