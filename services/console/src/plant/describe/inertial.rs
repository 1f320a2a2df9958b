//! Totals of a plant, and the inertial parameters that its equations and its momentum can see.

use dynamics::description::{ActuatorKind, Initial, JointKind, Plant, Space};
use dynamics::multibody::{
    BaseParameters, Model, ModelError, MomentumBasis, MomentumSpan, ParameterFamily, RegressorRows, base_parameters,
    momentum_span, planar_tree_functions, stacked_regressor, standard_parameter_names,
};
use dynamics::system::{System, SystemError, Workspace};
use serde_json::{Value, json};
use simulation::{SimulationError, Simulator};

/// Random states over which regressors are stacked: several times as many rows as columns.
const STATES: usize = 100;
/// Share by which the parameters of a family are varied about their values.
const VARIATION_SHARE: f64 = 0.3;

/// Totals and base parameters.
pub struct Inertial {
    pub mass_kg: f64,
    /// Axes of the first body, from its origin; joints in their initial posture.
    pub com_m: [f64; 3],
    /// About the centre of mass, same axes; `None` for a plant with several roots.
    pub inertia_com_kg_m2: Option<[[f64; 3]; 3]>,
    /// Of the tree of rigid bodies.
    pub base: BaseParameters,
    pub momentum: Option<MomentumView>,
    pub free_base: bool,
}

impl Inertial {
    /// Totals, base parameters and the span of the momentum of a plant as a tree of rigid bodies.
    ///
    /// # Errors
    /// [`SimulationError`] where the equations of the plant cannot be set up.
    pub fn of(plant: &Plant) -> Result<Self, SimulationError> {
        let (mass_kg, com_m, inertia) = totals(plant)?;
        let rigid = rigid_tree(plant);
        let system = System::new(&rigid)?;
        let links: Vec<&str> = rigid.bodies.iter().map(|body| body.name.as_str()).collect();
        let stacked = stacked_regressor(system.model(), RegressorRows::Efforts, STATES, 1);
        let mut base = base_parameters(&stacked, &standard_parameter_names(&links));
        if plant.space == Space::Planar {
            base.unidentifiable.retain(|name| is_planar(name));
        }
        let free_base = plant.bodies.iter().any(|body| body.joint.kind == JointKind::Free);
        let momentum = floats_freely(plant).then(|| MomentumView::of(&rigid, &system)).flatten();
        Ok(Inertial { mass_kg, com_m, inertia_com_kg_m2: inertia, base, momentum, free_base })
    }

    /// Mass [kg], centre of mass [m] and inertia about it [kg m²] of the whole plant.
    pub fn totals_json(&self) -> Value {
        json!({ "mass_kg": self.mass_kg, "com_m": self.com_m, "inertia_com_kg_m2": self.inertia_com_kg_m2 })
    }

    /// Base parameters: combinations, condition number, and the gap of the singular values that
    /// decides the rank (null: infinite).
    pub fn base_json(&self) -> Value {
        let gap = self.base.gap.is_finite().then_some(self.base.gap);
        json!({
            "count": self.base.rank(), "combinations": self.base.base.iter().map(|base| &base.text).collect::<Vec<_>>(),
            "condition_number": self.base.condition_number, "gap": gap,
            "regrouped": self.base.regrouped, "unidentifiable": self.base.unidentifiable,
        })
    }
}

/// Of the standard parameters those that a planar body has.
fn is_planar(name: &str) -> bool {
    [".m", ".mcx", ".mcy", ".Izz"].iter().any(|ending| name.ends_with(ending))
}

/// What the angular momentum of a planar arm that floats freely can tell.
pub struct MomentumView {
    pub span: MomentumSpan,
    /// Equations among the coefficients, `a4·a7 = a5·a6`.
    pub dependences: Vec<String>,
}

impl MomentumView {
    /// `None` where the tree is not one of revolute joints or the rank of the span is ambiguous.
    fn of(rigid: &Plant, system: &System) -> Option<Self> {
        let functions = planar_tree_functions(system.model())?;
        let numbers = varied(rigid);
        let ranges: Vec<(f64, f64)> = numbers
            .iter()
            .map(|(_, value)| (value - VARIATION_SHARE * value.abs(), value + VARIATION_SHARE * value.abs()))
            .collect();
        let model = |values: &[f64]| {
            let mut moved = rigid.clone();
            for ((name, _), value) in numbers.iter().zip(values) {
                moved.set_parameter(name, *value).expect("the name is one that the plant listed");
            }
            match System::new(&moved) {
                Ok(system) => Ok(Model::clone(system.model())),
                Err(SystemError::Mechanism { error, .. }) => Err(error),
                Err(_) => Err(ModelError::Empty),
            }
        };
        let evaluate = |q: &[f64], v: &[f64], values: &mut [f64]| functions.evaluate(q, v, values);
        let basis = MomentumBasis { names: functions.names(), evaluate: &evaluate };
        let span = momentum_span(&ParameterFamily { ranges: &ranges, model: &model }, Some(&basis), 1).ok()?;
        let dependences = span.dependences.iter().map(|dependence| in_order(&dependence.text)).collect();
        Some(MomentumView { span, dependences })
    }

    /// Dimension of the span, functions and gaps; null for a gap that is infinite.
    pub fn as_json(&self) -> Value {
        json!({
            "base_parameters": self.span.span_dimension, "manifold_dimension": self.span.manifold_dimension,
            "functions": self.span.functions, "coefficients": self.span.coefficients,
            "dependences": self.dependences, "gaps": self.span.gaps.map(|gap| gap.is_finite().then_some(gap)),
        })
    }
}

/// Numbers of the bodies that are not zero, which is taken as structure: a centre of mass on the
/// axis stays there.
fn varied(rigid: &Plant) -> Vec<(String, f64)> {
    let root = &rigid.bodies[0].joint.name;
    let numbers = rigid.parameters().into_iter().filter(|number| number.value != 0.0);
    let of_body = numbers.filter(|number| {
        let Some((owner, key)) = number.name.split_once('.') else { return false };
        let body = rigid.bodies.iter().any(|body| body.name == owner);
        let joint = rigid.bodies.iter().any(|body| body.joint.name == owner) && owner != root;
        (body && matches!(key, "mass" | "com.x" | "com.y" | "inertia.zz"))
            || (joint && matches!(key, "position.x" | "position.y"))
    });
    of_body.map(|number| (number.name, number.value)).collect()
}

/// An equation with the smaller side first.
fn in_order(equation: &str) -> String {
    match equation.split_once(" = ") {
        Some((left, right)) if right < left => format!("{right} = {left}"),
        _ => equation.to_owned(),
    }
}

/// Bodies and joints alone.
fn rigid_tree(plant: &Plant) -> Plant {
    Plant {
        name: plant.name.clone(),
        space: plant.space,
        environment: plant.environment.clone(),
        bodies: plant.bodies.clone(),
        ..Plant::default()
    }
}

/// Nothing pushes the base: a planar tree on a free body, driven in its joints alone.
fn floats_freely(plant: &Plant) -> bool {
    let free = plant.bodies.iter().filter(|body| body.parent.is_none()).map(|body| body.joint.kind);
    let driven_in_joints = plant.actuators.iter().all(|actuator| {
        matches!(
            actuator.kind,
            ActuatorKind::JointTorque { .. } | ActuatorKind::Motor { .. } | ActuatorKind::PrescribedJoint { .. }
        )
    });
    plant.space == Space::Planar
        && plant.bodies.len() > 1
        && free.collect::<Vec<_>>() == [JointKind::Free]
        && plant.environment.gravity_m_s2.iter().all(|g| g.value == 0.0)
        && plant.tanks.is_empty()
        && plant.appendages.is_empty()
        && driven_in_joints
}

/// Mass [kg], centre of mass [m], inertia about it [kg m²] where it has one.
type MassProperties = (f64, [f64; 3], Option<[[f64; 3]; 3]>);

/// Mass, centre of mass and inertia about it in the initial posture, by turning the whole about
/// each axis: the angular momentum per unit of rate is a column of the inertia.
fn totals(plant: &Plant) -> Result<MassProperties, SimulationError> {
    let mut posture = Simulator::new(plant, 1, &plant.name)?;
    let names: Vec<String> = posture.system().states().iter().map(|state| state.name.clone()).collect();
    let initial = posture.truth().state.to_vec();
    let freed = freed(plant);
    let system = System::new(&freed)?;
    let mut x = system.initial_state(&Initial::default(), &|_| None)?;
    for (state, value) in system.states().iter().zip(&mut x) {
        let internal = ["joint:", "tank:"].iter().any(|kind| state.name.starts_with(kind));
        if internal && !state.name.ends_with(".rate") {
            let known = names.iter().position(|name| *name == state.name);
            *value = known.map_or(*value, |at| initial[at]);
        }
    }
    let mut ws = Workspace::<f64>::new(&system);
    let u = vec![0.0; system.inputs().len()];
    let rest = system.totals(&mut ws, &x, &u);
    if plant.bodies.iter().filter(|body| body.parent.is_none()).count() != 1 {
        return Ok((rest.mass_kg, rest.com_m, None));
    }
    let mut inertia = [[0.0; 3]; 3];
    for (axis, name) in ["rx", "ry", "rz"].iter().enumerate() {
        let rate = format!("body:{}.{name}.rate", plant.bodies[0].name);
        let Some(at) = system.states().iter().position(|state| state.name == rate) else { continue };
        x[at] = 1.0;
        let turning = system.totals(&mut ws, &x, &u).angular_momentum_com_n_m_s;
        x[at] = 0.0;
        for (row, component) in inertia.iter_mut().zip(turning) {
            row[axis] = component;
        }
    }
    Ok((rest.mass_kg, rest.com_m, Some(inertia)))
}

/// The same bodies, tanks and appendages with a free root in the origin, and nothing that acts.
fn freed(plant: &Plant) -> Plant {
    let mut freed = rigid_tree(plant);
    (freed.tanks, freed.appendages) = (plant.tanks.clone(), plant.appendages.clone());
    for body in freed.bodies.iter_mut().filter(|body| body.parent.is_none()) {
        body.joint.kind = JointKind::Free;
        body.joint.position_m = Default::default();
        body.joint.orientation = Default::default();
    }
    freed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built_in(name: &str) -> Plant {
        let text = crate::plants::text_of(name, std::path::Path::new("")).unwrap();
        plant_file::parse(name, &text).unwrap().plant
    }

    #[test]
    fn the_arm_of_the_benchmark_shows_eight_parameters_on_a_manifold_of_seven() {
        let found = Inertial::of(&built_in("free_floating_arm")).unwrap();
        let momentum = found.momentum.unwrap();
        assert_eq!((momentum.span.span_dimension, momentum.span.manifold_dimension), (8, 7));
        assert_eq!(momentum.dependences, ["a4·a7 = a5·a6"]);
        assert!((momentum.span.coefficients[0] - 110.7028).abs() < 5e-5); // printed digits of the study
    }

    #[test]
    fn the_inertia_of_two_bodies_is_that_of_steiner() {
        // hub and link 1, 2 of the arm stretched along x: masses on a line through their centres
        let mut plant = built_in("free_floating_arm");
        plant.controllers.clear();
        plant.initial = Initial::default();
        let found = Inertial::of(&plant).unwrap();
        let parts =
            [(400.0, 0.0, 0.0, 66.67), (12.1, 0.99 + 1.9, 0.99, 17.27), (11.7, 0.99 + 2.068 + 1.73, 0.99, 14.1)];
        let mass: f64 = parts.iter().map(|part| part.0).sum();
        let com = [1, 2].map(|i| parts.iter().map(|p| p.0 * [p.1, p.2][i - 1]).sum::<f64>() / mass);
        let about = |p: &(f64, f64, f64, f64)| p.3 + p.0 * ((p.1 - com[0]).powi(2) + (p.2 - com[1]).powi(2));
        let inertia: f64 = parts.iter().map(about).sum();
        assert!((found.mass_kg - mass).abs() < 1e-12 * mass); // rounding
        assert!((found.com_m[0] - com[0]).abs() + (found.com_m[1] - com[1]).abs() < 1e-13);
        assert!((found.inertia_com_kg_m2.unwrap()[2][2] / inertia - 1.0).abs() < 1e-13);
    }
}
