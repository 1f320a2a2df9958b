//! Effects of a plant, bound to their sites.

use super::actuation::{Acts, Actuation};
use super::effect_terms::{EffectTerm, EffectTerms};
use super::environment::Surrounding;
use super::error::SystemError;
use super::geometry::values;
use super::layout::{Layout, StateName};
use super::names::{Names, numbered};
use super::sensors::{Measured, SensorTerm};
use super::sites::Coordinate;
use super::{Filter, FilterPlace};
use crate::description::{ActuatorKind, EffectUse, Plant, SensorKind, Site, SiteKind};
use crate::effect::{Both, Effect, Law, PARAMETERS_MAX, Surroundings};

/// Input of the binding of effects.
pub(super) struct Binding<'a> {
    pub plant: &'a Plant,
    pub names: &'a Names,
    pub environment: &'a Surrounding,
}

/// A site: its coordinates (none, one, or one per axis of a tank), its body, and the constants that
/// a law receives.
#[derive(Clone, Debug)]
struct Place {
    coordinates: Vec<Coordinate>,
    link: usize,
    surroundings: Surroundings,
    /// Among actuators or sensors.
    index: usize,
}

/// A law under construction; `index` of the actuator or sensor it belongs to.
type Indexed = (usize, EffectTerm);

impl Binding<'_> {
    /// Terms by the place of their action, and filters; adds hidden states to `layout` and ranges
    /// to actuators and sensors.
    pub fn bind(
        &self,
        layout: &mut Layout,
        actuators: &mut [Actuation],
        sensors: &mut [SensorTerm],
    ) -> Result<(EffectTerms, Vec<Filter>), SystemError> {
        let mut terms = EffectTerms::default();
        let (mut on_actuators, mut on_sensors, mut filters) = (Vec::new(), Vec::new(), Vec::new());
        let mut uses: Vec<&EffectUse> = self.plant.effects.iter().collect();
        uses.sort_by_cached_key(|used| self.plant.order_of_action(used));
        for used in uses {
            let failed = |reason: &str| failure(used, reason);
            let effect = self.plant.catalogue.effect(&used.kind).ok_or_else(|| failed("there is no such effect"))?;
            let place = self.place(used, actuators, sensors)?;
            if !crate::effect::sites(effect, self.plant).contains(&used.site) {
                return Err(failed("it cannot sit there"));
            }
            let mut numbers = crate::effect::values(effect, used).map_err(|error| failed(&error.to_string()))?;
            crate::effect::felt(effect, &mut numbers, self.plant.space);
            let mut term = |law, coordinate| hidden_states(layout, used, effect, (&place, numbers), law, coordinate);
            let axes = if used.site.kind == SiteKind::Tank { self.tank_axes(&place) } else { Vec::new() };
            match effect.law {
                Law::Coordinate(law) if place.coordinates.is_empty() => {
                    let _: Both = law;
                    return Err(failed("nothing moves there"));
                }
                Law::Coordinate(law) => {
                    for (k, at) in place.coordinates.iter().enumerate() {
                        let mut term = term(law, Some(*at));
                        if let Some((_, axis)) = axes.get(k) {
                            term.surroundings.site_axis = *axis;
                            term.tank.clone_from(&axes);
                        }
                        terms.coordinates.push(term);
                    }
                }
                Law::Body(law) => terms.bodies.push(term(law, place.coordinates.first().copied())),
                Law::Actuator(law) => {
                    let at = self.commanded(used, actuators, &place)?;
                    on_actuators.push((at, term(law, place.coordinates.first().copied())));
                }
                Law::Sensor(law) => {
                    let at = self.reading(used, &place)?;
                    on_sensors.push((at, term(law, place.coordinates.first().copied())));
                }
                Law::ActuatorFilter(kind) => {
                    let at = self.commanded(used, actuators, &place)?;
                    let input = FilterPlace::Input(actuators[at].input);
                    let held = |kind: crate::lags::FilterKind| kind.held_over(self.plant.simulation.period_s);
                    filters.push(Filter { site: used.site.clone(), place: input, kind: held(kind(&numbers)) });
                }
                Law::SensorFilter(kind) => {
                    let output = FilterPlace::Output(self.reading(used, &place)?);
                    filters.push(Filter { site: used.site.clone(), place: output, kind: kind(&numbers) });
                }
                Law::Structure(_) => return Err(failed("it changes the structure and is applied before")),
            }
        }
        terms.actuators = grouped(on_actuators, actuators.len(), |k, range| actuators[k].effects = range);
        terms.sensors = grouped(on_sensors, sensors.len(), |k, range| sensors[k].effects = range);
        for sensor in sensors {
            sensor.hidden = terms.sensors[sensor.effects.clone()].iter().any(|term| !term.hidden.is_empty());
        }
        Ok((terms, filters))
    }

    fn commanded(&self, used: &EffectUse, actuators: &[Actuation], place: &Place) -> Result<usize, SystemError> {
        if used.site.kind != SiteKind::Actuator {
            return Err(failure(used, "it acts on commands, and this is no actuator"));
        }
        match actuators[place.index].acts {
            Acts::Joint { .. } | Acts::Base { .. } => Err(failure(used, "a prescribed motion is what it is")),
            _ => Ok(place.index),
        }
    }

    fn reading(&self, used: &EffectUse, place: &Place) -> Result<usize, SystemError> {
        if used.site.kind != SiteKind::Sensor {
            return Err(failure(used, "it acts on readings, and this is no sensor"));
        }
        Ok(place.index)
    }

    fn place(&self, used: &EffectUse, actuators: &[Actuation], sensors: &[SensorTerm]) -> Result<Place, SystemError> {
        let (name, names) = (&used.site.name, self.names);
        let what = format!("effect '{}'", used.kind);
        let missing = || super::names::unknown(&what, used.site.kind.name(), name);
        let of = |link: usize, coordinates: Vec<Coordinate>, at: [f64; 3], axis: [f64; 3], index: usize| Place {
            coordinates,
            link,
            surroundings: self.surroundings(link, at, axis),
            index,
        };
        match used.site.kind {
            SiteKind::Joint => {
                let joint = names.joint(name, &what)?;
                Ok(of(joint.link, vec![joint.coordinate], [0.0; 3], joint.axis, 0))
            }
            SiteKind::Body => Ok(of(names.body(name, &what)?, Vec::new(), [0.0; 3], [0.0; 3], 0)),
            SiteKind::Tank => {
                let at = self.plant.tanks.iter().position(|tank| &tank.name == name).ok_or_else(missing)?;
                let tank = &self.plant.tanks[at];
                let axis = match &tank.model {
                    crate::description::TankModel::Spring { axes, .. } => axes[0],
                    crate::description::TankModel::Pendulum { rest, .. } => *rest,
                };
                let link = names.body(&tank.body, &what)?;
                Ok(of(link, names.tanks[at].clone(), values(&tank.position_m), axis, at))
            }
            SiteKind::Mode => {
                let mut modes = self.plant.appendages.iter().flat_map(|appendage| &appendage.modes);
                let at = modes.position(|mode| &mode.name == name).ok_or_else(missing)?;
                let (link, coordinate) = names.modes[at];
                Ok(of(link, vec![coordinate], [0.0; 3], [0.0; 3], 0))
            }
            SiteKind::Actuator => {
                let at = self.plant.actuators.iter().position(|a| &a.name == name).ok_or_else(missing)?;
                let (position, axis) = self.actuator_axis(at);
                let coordinate = match actuators[at].acts {
                    Acts::Coordinate { coordinate, .. }
                    | Acts::Voltage { coordinate, .. }
                    | Acts::Joint { coordinate } => vec![coordinate],
                    Acts::Wrench { .. } | Acts::Base { .. } => Vec::new(),
                };
                let mut place = of(actuators[at].link, coordinate, position, axis, at);
                let constants = &mut place.surroundings;
                (constants.one_sided, constants.quiet) = (actuators[at].one_sided, actuators[at].quiet);
                if let Acts::Voltage { back_emf, .. } = actuators[at].acts {
                    constants.back_emf_v_s_rad = back_emf;
                }
                Ok(place)
            }
            SiteKind::Sensor => {
                let at = self.plant.sensors.iter().position(|s| &s.name == name).ok_or_else(missing)?;
                let (link, coordinates, position, axis) = self.sensor_place(at, &sensors[at].measured);
                Ok(of(link, coordinates, position, axis, at))
            }
        }
    }

    /// Coordinates of a tank with the direction in which each moves its mass; of a pendulum one
    /// unit vector for each angle.
    fn tank_axes(&self, place: &Place) -> Vec<(Coordinate, [f64; 3])> {
        let axes = match &self.plant.tanks[place.index].model {
            crate::description::TankModel::Spring { axes, .. } => axes.clone(),
            crate::description::TankModel::Pendulum { .. } => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        };
        place.coordinates.iter().copied().zip(axes).collect()
    }

    fn actuator_axis(&self, index: usize) -> ([f64; 3], [f64; 3]) {
        match &self.plant.actuators[index].kind {
            ActuatorKind::BodyForce { position_m, direction, .. }
            | ActuatorKind::Thruster { position_m, direction, .. } => (values(position_m), *direction),
            ActuatorKind::BodyTorque { direction, .. } => ([0.0; 3], *direction),
            ActuatorKind::Wheel { axis, .. } => ([0.0; 3], *axis),
            ActuatorKind::JointTorque { joint }
            | ActuatorKind::Motor { joint, .. }
            | ActuatorKind::PrescribedJoint { joint, .. } => {
                ([0.0; 3], self.names.joint(joint, "").map_or([0.0; 3], |joint| joint.axis))
            }
            ActuatorKind::PrescribedBase { .. } => ([0.0; 3], [0.0; 3]),
        }
    }

    fn sensor_place(&self, index: usize, measured: &Measured) -> (usize, Vec<Coordinate>, [f64; 3], [f64; 3]) {
        let none = [0.0; 3];
        let joint = |name: &str| {
            let site = self.names.joint(name, "").expect("the sensor has been resolved");
            (site.link, vec![site.coordinate], none, site.axis)
        };
        match (&self.plant.sensors[index].kind, measured) {
            (SensorKind::Encoder { joint: name }, _)
            | (SensorKind::JointRate { joint: name }, _)
            | (SensorKind::JointTorque { joint: name }, _) => joint(name),
            (_, Measured::Accelerometer { link, point, axis, .. })
            | (_, Measured::Position { link, point, axis })
            | (_, Measured::Velocity { link, point, axis }) => (*link, Vec::new(), *point, *axis),
            (_, Measured::Gyro { link, axis, .. })
            | (_, Measured::Force { link, axis })
            | (_, Measured::Torque { link, axis })
            | (_, Measured::Attitude { link, axis }) => (*link, Vec::new(), none, *axis),
            (SensorKind::Attitude { body, axis }, _) => {
                (self.names.body(body, "").expect("the sensor has been resolved"), Vec::new(), none, *axis)
            }
            (SensorKind::WheelSpeed { actuator }, _) => self.wheel_place(actuator),
            _ => (0, Vec::new(), none, none),
        }
    }

    fn wheel_place(&self, name: &str) -> (usize, Vec<Coordinate>, [f64; 3], [f64; 3]) {
        let v = self.names.wheel(name, "").expect("the sensor has been resolved");
        let wheel = self.plant.actuators.iter().find(|actuator| actuator.name == name);
        let Some(ActuatorKind::Wheel { body, axis, .. }) = wheel.map(|wheel| &wheel.kind) else {
            unreachable!("the name is a wheel's")
        };
        let link = self.names.body(body, "").expect("the wheel has been resolved");
        (link, vec![Coordinate { position: None, v }], [0.0; 3], *axis)
    }

    fn surroundings(&self, link: usize, site_position_m: [f64; 3], site_axis: [f64; 3]) -> Surroundings {
        let body = &self.plant.bodies[link];
        let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|quantity| quantity.value);
        Surroundings {
            body_mass_kg: body.mass_kg.value,
            body_com_m: values(&body.com_m),
            body_inertia_com_kg_m2: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
            site_position_m,
            site_axis,
            ..self.environment.constants
        }
    }
}

/// A term with its own places among the hidden states, which it adds to the layout.
fn hidden_states(
    layout: &mut Layout,
    used: &EffectUse,
    effect: &Effect,
    (place, values): (&Place, [f64; PARAMETERS_MAX]),
    law: Both,
    coordinate: Option<Coordinate>,
) -> EffectTerm {
    let first = layout.hidden;
    layout.hidden += effect.hidden_states;
    let axis = place.coordinates.iter().position(|at| Some(*at) == coordinate).unwrap_or(0);
    let Site { kind, name } = &used.site;
    let owner = numbered(&format!("{}@{}:{name}", used.kind, kind.name()), axis);
    for k in 0..effect.hidden_states {
        layout.states.push(StateName { name: format!("{owner}.{}", k + 1), unit: "1" });
    }
    EffectTerm {
        law,
        smooth: effect.is_smooth(),
        values,
        hidden: first..layout.hidden,
        coordinate,
        tank: Vec::new(),
        link: place.link,
        carried: !matches!(kind, SiteKind::Joint | SiteKind::Tank),
        surroundings: place.surroundings,
    }
}

/// Sorts by owner in the order of the catalogue; every owner gets its range.
fn grouped(
    mut terms: Vec<Indexed>,
    owners: usize,
    mut tell: impl FnMut(usize, core::ops::Range<usize>),
) -> Vec<EffectTerm> {
    terms.sort_by_key(|(owner, _)| *owner);
    for owner in 0..owners {
        let first = terms.partition_point(|(at, _)| *at < owner);
        let end = terms.partition_point(|(at, _)| *at <= owner);
        tell(owner, first..end);
    }
    terms.into_iter().map(|(_, term)| term).collect()
}

fn failure(used: &EffectUse, reason: &str) -> SystemError {
    SystemError::Effect { effect: used.kind.clone(), site: used.site.to_string(), reason: reason.to_owned() }
}
