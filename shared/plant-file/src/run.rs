//! `gravity`, `[environment]`, `[initial]`, `[[segment]]`, `[simulation]`, `[[effect]]`.

use super::section::Section;
use super::units;
use dynamics::description::{
    Atmosphere, EffectUse, Environment, GravityGradient, Initial, InitialValue, Integrator, MagneticField, Plant,
    Quantity, Segment, SimulationSettings, Site, SiteKind, in_catalogue_order, unit_at,
};

/// Reads `gravity` of the file and the table `[environment]`.
pub(super) fn environment(root: &Section<'_, '_>) -> Environment {
    let gravity_m_s2 = root.vector_or_zero("gravity", "m/s^2");
    let Some(section) = root.table("environment") else {
        return Environment { gravity_m_s2, ..Environment::default() };
    };
    let gradient = section.section("gravity_gradient", "gravity_gradient").map(|inner| {
        let orbit_rate_rad_s = inner.required_quantity("orbit_rate", "rad/s");
        let gradient = GravityGradient { orbit_rate_rad_s, phase_rad: inner.quantity_or("phase", "rad", 0.0) };
        inner.finish();
        gradient
    });
    let atmosphere = section.section("atmosphere", "atmosphere").map(|inner| {
        let density_kg_m3 = inner.required_quantity("density", "kg/m^3");
        let atmosphere = Atmosphere { density_kg_m3, wind_m_s: inner.vector_or_zero("wind", "m/s") };
        inner.finish();
        atmosphere
    });
    let environment = Environment {
        gravity_m_s2,
        constant_force_n: section.vector_or_zero("constant_force", "N"),
        constant_torque_n_m: section.turning("constant_torque", "N*m").unwrap_or_default(),
        gravity_gradient: gradient,
        atmosphere,
        magnetic_field: section.vector("magnetic_field", "T").map(|field_t| MagneticField { field_t }),
    };
    section.finish();
    environment
}

/// Reads a table of initial states; keys with a colon are coordinates.
pub(super) fn initial(section: &Section<'_, '_>, plant: &Plant) -> Initial {
    let momentum_com_n_m_s = section.turning("momentum", "N*m*s");
    let on_reference = section.flag("on_reference", false);
    let mut values = Vec::new();
    for coordinate in section.keys().into_iter().filter(|key| key.contains(':')) {
        let Some(inner) = section.section(coordinate, coordinate) else { continue };
        let (unit, rate_unit) = plant.initial_unit(coordinate);
        let joint = coordinate.strip_prefix("joint:");
        if joint.is_some_and(|joint| section.is_unsure_of_joint(plant, joint)) {
            inner.take_any_unit();
        }
        let position = inner.quantity_or("position", unit, 0.0);
        let rate = inner.quantity_or("rate", rate_unit, 0.0);
        inner.finish();
        values.push(InitialValue { coordinate: coordinate.to_owned(), position, rate });
    }
    section.finish();
    Initial { values, momentum_com_n_m_s, on_reference }
}

/// Reads one `[[segment]]`.
pub(super) fn segment(section: &mut Section<'_, '_>, plant: &Plant) -> Segment {
    let segment = Segment {
        name: section.name("segment"),
        begin_s: section.required_quantity("begin", "s"),
        end_s: section.quantity("end", "s"),
        initial: section.section("initial", "initial").map(|inner| initial(&inner, plant)).unwrap_or_default(),
    };
    section.finish();
    segment
}

const INTEGRATORS: [(&str, Integrator); 3] = [
    ("runge_kutta_4", Integrator::RungeKutta4),
    ("midpoint", Integrator::Midpoint),
    ("exact_zero_order_hold", Integrator::ExactZeroOrderHold),
];

/// Reads `[simulation]`; the step is the period where it is not stated.
pub(super) fn simulation(section: &Section<'_, '_>) -> SimulationSettings {
    let default = SimulationSettings::default();
    let period_s = section.known_number("period", "s").unwrap_or(default.period_s);
    let settings = SimulationSettings {
        duration_s: section.known_number("duration", "s").unwrap_or(default.duration_s),
        period_s,
        step_s: section.known_number("step", "s").unwrap_or(period_s),
        integrator: section.word("integrator", &INTEGRATORS, Some(default.integrator)).unwrap_or_default(),
        jitter_s: section.known_number("jitter", "s").unwrap_or(0.0),
    };
    section.finish();
    settings
}

/// The word for an integrator.
pub(super) fn integrator_word(integrator: Integrator) -> &'static str {
    INTEGRATORS.iter().find(|(_, known)| *known == integrator).map_or("runge_kutta_4", |(word, _)| word)
}

/// Reads one `[[effect]]`; `plant` has everything else.
pub(super) fn effect(section: &mut Section<'_, '_>, plant: &Plant) -> EffectUse {
    let kind = section.required_text("kind", "a name of the catalogue: obsid effects");
    section.what = if kind.is_empty() { section.what.clone() } else { format!("effect '{kind}'") };
    let site = site(section);
    if !plant.sites(site.kind).contains(&site) || section.is_unsure(&site.name) {
        section.take_any_unit();
    }
    let mut values: Vec<(String, Quantity)> = Vec::new();
    match plant.catalogue.effect(&kind) {
        Some(entry) => {
            for parameter in entry.parameters {
                let unit = readable(unit_at(plant, &site, parameter.unit));
                values.extend(section.quantity(parameter.name, &unit).map(|value| (parameter.name.to_owned(), value)));
            }
        }
        None => section.be_lenient(), // the unknown kind is reported with all faults
    }
    section.finish();
    let effect = EffectUse { kind, site, values };
    match plant.catalogue.effect(&effect.kind) {
        Some(entry) => in_catalogue_order(effect.clone(), entry).unwrap_or(effect),
        None => effect,
    }
}

fn site(section: &Section<'_, '_>) -> Site {
    let text = section.required_text("site", "as in \"joint:NAME\"");
    text.parse().unwrap_or_else(|why: String| {
        if !text.is_empty() {
            section.error("site", format!("site of {}: {why}", section.what), "as in \"joint:NAME\"");
        }
        Site { kind: SiteKind::Body, name: text }
    })
}

/// A unit of the catalogue that this reader cannot parse counts as none.
pub(super) fn readable(unit: String) -> String {
    if !unit.is_empty() && units::parse(&unit).is_ok() { unit } else { "1".to_owned() }
}
