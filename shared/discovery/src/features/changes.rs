//! Hypotheses about a plant whose modes are wrong: each change with one amplitude, zero for no
//! change.
//!
//! Of an appendage: all its frequencies by one factor (stiffness over mass, thickness, length), one
//! mode alone, a spring at its clamp, a mass at one of its points; all its damping ratios by one
//! factor, one alone. In addition every effect of the catalogue that changes the structure, or
//! applies a force that is linear in the motion ([`linear_laws`](super::linear_laws)). Each change
//! is a plant, which can be written, simulated and diagnosed again.
//!
//! With ξ the clamped modes' coordinates of the whole displacement, φ the shape at a point, ρ the
//! participation of rotation about the root: a mass m at the point has `M = 1 + m φ φᵀ, K = Ω²`; a
//! root that turns against a spring k has the flexibility `Ω⁻² + ρ ρᵀ / k` (the rigid turn of the
//! root expands in the clamped modes with coefficients ρ). Few modes make both a little too stiff.

use super::linear_laws;
use dynamics::description::{Appendage, Plant, Quantity, SiteKind, Space};
use dynamics::effect::{Effect, Law};
use nalgebra::{DMatrix, SymmetricEigen};

/// One hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// ln of the factor on all frequencies of an appendage.
    Scale { appendage: usize },
    /// ln of the factor on one.
    Single { appendage: usize, mode: usize },
    /// Flexibility [rad/(N m)] of the clamp against a turn about an axis.
    Root { appendage: usize, axis: usize },
    /// Mass [kg] at a point.
    Mass { appendage: usize, point: usize },
    /// ln of the factor on all damping ratios of an appendage.
    DampingScale { appendage: usize },
    /// ln of the factor on one.
    DampingSingle { appendage: usize, mode: usize },
    /// Catalogue entry and site, its first amplitude.
    Effect { effect: &'static Effect, site: String },
}

impl Change {
    /// All changes that the plant offers; those of damping only where damping was measured.
    pub fn all(plant: &Plant, damping: bool) -> Vec<Self> {
        let mut list = Vec::new();
        for (appendage, description) in plant.appendages.iter().enumerate() {
            list.push(Self::Scale { appendage });
            for axis in if plant.space == Space::Planar { 2..3 } else { 0..3 } {
                if description.modes.iter().any(|mode| mode.rotation_sqrt_kg_m[axis].value != 0.0) {
                    list.push(Self::Root { appendage, axis });
                }
            }
            for point in 0..description.points.len() {
                let moves = |mode: &dynamics::description::Mode| {
                    mode.shape_per_sqrt_kg.get(point).is_some_and(|shape| shape.iter().any(|s| s.value != 0.0))
                };
                if description.modes.iter().any(moves) {
                    list.push(Self::Mass { appendage, point });
                }
            }
            list.extend((0..description.modes.len()).map(|mode| Self::Single { appendage, mode }));
            if damping && description.modes.iter().any(|mode| mode.damping_ratio.value > 0.0) {
                list.push(Self::DampingScale { appendage });
                let damped = |mode: &usize| description.modes[*mode].damping_ratio.value > 0.0;
                let each = (0..description.modes.len()).filter(damped);
                list.extend(each.map(|mode| Self::DampingSingle { appendage, mode }));
            }
        }
        for effect in plant.catalogue.entries().iter().filter(|e| matches!(e.law, Law::Structure(_))) {
            // sensors do not vibrate; a further mode shows as a further peak
            let sites = effect.sites.iter().filter(|kind| !matches!(kind, SiteKind::Sensor | SiteKind::Actuator));
            for site in sites.flat_map(|kind| plant.sites(*kind)).filter(|site| (effect.applies)(plant, site)) {
                list.push(Self::Effect { effect, site: site.to_string() });
            }
        }
        if damping {
            let laws = linear_laws::of(plant).into_iter();
            list.extend(laws.map(|(effect, site)| Self::Effect { effect, site: site.to_string() }));
        }
        list
    }

    /// Name of the change in the report: that of the effect, or one of its own (`frequency_scale`,
    /// `point_mass`, …).
    pub fn kind(&self) -> String {
        match self {
            Self::Scale { .. } => "frequency_scale".to_owned(),
            Self::Single { .. } => "frequency_of_one_mode".to_owned(),
            Self::Root { .. } => "root_rotation_spring".to_owned(),
            Self::Mass { .. } => "point_mass".to_owned(),
            Self::DampingScale { .. } => "damping_scale".to_owned(),
            Self::DampingSingle { .. } => "damping_of_one_mode".to_owned(),
            Self::Effect { effect, .. } => effect.kind.to_owned(),
        }
    }

    /// In words; of a change that is no effect its kind.
    pub fn title(&self) -> String {
        if let Self::Effect { effect, .. } = self { effect.title.to_owned() } else { self.kind() }
    }

    /// Site of the change in `plant`, as in a plant file.
    pub fn site(&self, plant: &Plant) -> String {
        let name = |appendage: &usize| &plant.appendages[*appendage].name;
        match self {
            Self::Scale { appendage } | Self::DampingScale { appendage } => format!("appendage:{}", name(appendage)),
            Self::Root { appendage, axis } if plant.space == Space::Spatial => {
                format!("appendage:{}.root.{}", name(appendage), ["x", "y", "z"][*axis])
            }
            Self::Root { appendage, .. } => format!("appendage:{}.root", name(appendage)),
            Self::Single { appendage, mode } | Self::DampingSingle { appendage, mode } => {
                format!("mode:{}", plant.appendages[*appendage].modes[*mode].name)
            }
            Self::Mass { appendage, point } => {
                format!("appendage:{}.{}", name(appendage), plant.appendages[*appendage].points[*point].0)
            }
            Self::Effect { site, .. } => site.clone(),
        }
    }

    /// Reported parameter: name, value, its derivative by the amplitude, unit.
    pub fn parameter(&self, amplitude: f64) -> (String, f64, f64, String) {
        let of = |name: &str, value: f64, slope: f64, unit: &str| (name.to_owned(), value, slope, unit.to_owned());
        match self {
            Self::Scale { .. } | Self::Single { .. } | Self::DampingScale { .. } | Self::DampingSingle { .. } => {
                let factor = libm::exp(amplitude);
                of("factor", factor, factor, "1")
            }
            Self::Root { .. } => of("stiffness", 1.0 / amplitude, 1.0 / (amplitude * amplitude), "N*m/rad"),
            Self::Mass { .. } => of("mass", amplitude, 1.0, "kg"),
            Self::Effect { effect, .. } => {
                let parameter = &effect.parameters[0];
                of(parameter.name, amplitude, 1.0, parameter.unit)
            }
        }
    }

    /// Grid of amplitudes, rising, dense enough that neighbours bracket every optimum: both signs,
    /// or positive ones.
    pub fn grid(&self, plant: &Plant) -> Vec<f64> {
        let both =
            |most: f64, n: i32| (-n..=n).map(|k| most * f64::from(k) / f64::from(n)).filter(|a| *a != 0.0).collect();
        let by_size = |unit: f64| (0..=32).map(|k| unit * libm::exp(0.25 * f64::from(k) - 6.0)).collect();
        match self {
            Self::Scale { .. } | Self::Single { .. } => both(0.4, 20),
            // to a twelfth and to twelve times
            Self::DampingScale { .. } | Self::DampingSingle { .. } => both(2.5, 8),
            // in units of the largest ω² ρ² of the modes, whose inverse changes a mode as much as
            // its own flexibility
            Self::Root { appendage, axis } => {
                let strongest = plant.appendages[*appendage].modes.iter().map(|mode| {
                    let (omega, rho) = (omega(mode), mode.rotation_sqrt_kg_m[*axis].value);
                    omega * omega * rho * rho
                });
                by_size(1.0 / strongest.fold(0.0, f64::max).max(1e-300))
            }
            Self::Mass { appendage, point } => {
                let strongest = plant.appendages[*appendage]
                    .modes
                    .iter()
                    .map(|mode| mode.shape_per_sqrt_kg[*point].iter().map(|s| s.value * s.value).sum::<f64>());
                by_size(1.0 / strongest.fold(0.0, f64::max).max(1e-300))
            }
            Self::Effect { effect, .. } => {
                let parameter = &effect.parameters[0];
                let size = parameter.default.abs().max(1e-9);
                let inside = |a: &f64| *a != 0.0 && *a >= parameter.low && *a <= parameter.high;
                // a law's coefficient may be of any size: the catalogue knows neither mass nor
                // lever
                let (steps, ratio) = if matches!(effect.law, Law::Structure(_)) { (8, 2.0) } else { (10, 4.0) };
                let sizes = (-steps..=steps).map(|k| size * libm::pow(ratio, f64::from(k)));
                let mut values: Vec<f64> = sizes.flat_map(|a| [-a, a]).filter(inside).collect();
                values.sort_by(f64::total_cmp);
                values
            }
        }
    }

    /// The plant with the change; `None` where it is not possible.
    pub fn applied(&self, plant: &Plant, amplitude: f64) -> Option<Plant> {
        let mut changed = plant.clone();
        match self {
            Self::Scale { appendage } => {
                let factor = libm::exp(amplitude);
                changed.appendages[*appendage].modes.iter_mut().for_each(|m| m.frequency_hz.value *= factor);
            }
            Self::Single { appendage, mode } => {
                changed.appendages[*appendage].modes[*mode].frequency_hz.value *= libm::exp(amplitude);
            }
            Self::DampingScale { appendage } => {
                let factor = libm::exp(amplitude);
                changed.appendages[*appendage].modes.iter_mut().for_each(|m| m.damping_ratio.value *= factor);
            }
            Self::DampingSingle { appendage, mode } => {
                changed.appendages[*appendage].modes[*mode].damping_ratio.value *= libm::exp(amplitude);
            }
            Self::Root { appendage, axis } => soften(&mut changed.appendages[*appendage], *axis, amplitude)?,
            Self::Mass { appendage, point } => load(&mut changed, *appendage, *point, amplitude)?,
            Self::Effect { effect, site } => {
                let value = [(effect.parameters[0].name, amplitude)];
                changed.add_effect(effect.kind, &site.parse().ok()?, &value).ok()?;
            }
        }
        Some(changed)
    }
}

fn omega(mode: &dynamics::description::Mode) -> f64 {
    core::f64::consts::TAU * mode.frequency_hz.value
}

/// Root on a spring of flexibility `compliance`.
fn soften(appendage: &mut Appendage, axis: usize, compliance: f64) -> Option<()> {
    let n = appendage.modes.len();
    let rho: Vec<f64> = appendage.modes.iter().map(|mode| mode.rotation_sqrt_kg_m[axis].value).collect();
    let flexibility = DMatrix::from_fn(n, n, |i, j| {
        let own = if i == j { 1.0 / (omega(&appendage.modes[i]) * omega(&appendage.modes[i])) } else { 0.0 };
        own + rho[i] * rho[j] * compliance
    });
    let eigen = SymmetricEigen::new(flexibility);
    let omegas: Vec<f64> = eigen.eigenvalues.iter().map(|l| 1.0 / l.max(0.0).sqrt()).collect();
    rebuilt(appendage, &eigen.eigenvectors, &omegas)
}

/// A point mass on an appendage, and on the body that carries it.
fn load(plant: &mut Plant, appendage: usize, point: usize, mass_kg: f64) -> Option<()> {
    let space = plant.space;
    let appendage = &mut plant.appendages[appendage];
    let n = appendage.modes.len();
    let at = appendage.points[point].1.map(|q| q.value);
    let shape: Vec<[f64; 3]> =
        appendage.modes.iter().map(|mode| mode.shape_per_sqrt_kg[point].map(|q| q.value)).collect();
    let coupling = |i: usize, j: usize| -> f64 { (0..3).map(|k| shape[i][k] * shape[j][k]).sum() };
    let mass = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) + mass_kg * coupling(i, j));
    // K = Ω² and M become one symmetric problem: Ω⁻¹ M Ω⁻¹ has the eigenvalues 1/ω²
    let inverse: Vec<f64> = appendage.modes.iter().map(|mode| 1.0 / omega(mode)).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| inverse[i] * mass[(i, j)] * inverse[j]);
    let eigen = SymmetricEigen::new(scaled);
    let omegas: Vec<f64> = eigen.eigenvalues.iter().map(|l| 1.0 / l.max(0.0).sqrt()).collect();
    // Vᵀ M V = 1 with V = Ω⁻¹ E diag(ω)
    let v = DMatrix::from_fn(n, n, |i, j| inverse[i] * eigen.eigenvectors[(i, j)] * omegas[j]);
    for (mode, shape) in appendage.modes.iter_mut().zip(&shape) {
        (0..3).for_each(|k| mode.translation_sqrt_kg[k].value += mass_kg * shape[k]);
        let turn = [
            at[1] * shape[2] - at[2] * shape[1],
            at[2] * shape[0] - at[0] * shape[2],
            at[0] * shape[1] - at[1] * shape[0],
        ];
        (0..3).for_each(|k| mode.rotation_sqrt_kg_m[k].value += mass_kg * turn[k]);
    }
    rebuilt(appendage, &v, &omegas)?;
    let body = appendage.body.clone();
    let body = plant.bodies.iter_mut().find(|candidate| candidate.name == body)?;
    body.mass_kg.value += mass_kg;
    // about the body's origin; the shift of its centre of mass is of second order to a clamp
    let square: f64 = at.iter().map(|x| x * x).sum();
    for k in if space == Space::Planar { 2..3 } else { 0..3 } {
        body.inertia_com_kg_m2[k].value += mass_kg * (square - at[k] * at[k]);
    }
    Some(())
}

/// Modes that are combinations V of the old ones, by rising frequency; damping and names stay with
/// their place.
fn rebuilt(appendage: &mut Appendage, v: &DMatrix<f64>, omegas: &[f64]) -> Option<()> {
    let n = omegas.len();
    if omegas.iter().any(|w| !w.is_finite()) {
        return None;
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| omegas[*a].total_cmp(&omegas[*b]));
    let old = appendage.modes.clone();
    for (place, k) in order.iter().enumerate() {
        let mix = |of: &dyn Fn(usize) -> f64| -> f64 { (0..n).map(|i| of(i) * v[(i, *k)]).sum() };
        // the sign of an eigenvector is arbitrary: that of the mode in its place
        let sign = if v[(place, *k)] < 0.0 { -1.0 } else { 1.0 };
        let mode = &mut appendage.modes[place];
        mode.frequency_hz = Quantity { value: omegas[*k] / core::f64::consts::TAU, ..old[place].frequency_hz };
        for c in 0..3 {
            mode.translation_sqrt_kg[c].value = sign * mix(&|i| old[i].translation_sqrt_kg[c].value);
            mode.rotation_sqrt_kg_m[c].value = sign * mix(&|i| old[i].rotation_sqrt_kg_m[c].value);
            for p in 0..mode.shape_per_sqrt_kg.len() {
                mode.shape_per_sqrt_kg[p][c].value = sign * mix(&|i| old[i].shape_per_sqrt_kg[p][c].value);
            }
        }
    }
    Some(())
}
