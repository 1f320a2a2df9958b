//! Every parameter of a plant by a stable, unique name with its unit: one visitor, from which
//! listing and setting derive.
//!
//! Names are those of the file: `hub.mass`, `link_1.com.x`, `shoulder.friction`,
//! `fuel.stiffness.x`, `bending_1.frequency`, `gyro.bias`,
//! `effect.joint_coulomb@joint:shoulder.force`, `initial.joint:shoulder.rate`. Components that a
//! planar plant cannot have are left out.

mod visitor;

use super::{Controller, EffectUse, Initial, Plant, Quantity, Scope, SensorKind, Space, Tank, nearest};
use visitor::Visitor;

/// One parameter of a plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub name: String,
    /// SI; `1`: none.
    pub unit: String,
    pub value: f64,
    /// Prior standard deviation; `None` = known.
    pub sigma: Option<f64>,
    pub scope: Scope,
}

/// Why a parameter cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    #[error("no parameter is called '{name}'{}", nearest.as_ref().map(|n| format!("; did you mean '{n}'?")).unwrap_or_default())]
    Unknown { name: String, nearest: Option<String> },
    #[error("{name} = {value}: not a finite number")]
    NotFinite { name: String, value: f64 },
}

impl Plant {
    /// Every parameter, in file order; of effects also those at the catalogue's default.
    pub fn parameters(&self) -> Vec<Parameter> {
        let mut list = Vec::new();
        let effects = self.effects.iter().map(|effect| effect.in_full(self.catalogue)).collect();
        Self { effects, ..self.clone() }.visit_quantities(&mut |name, unit, quantity| {
            let (name, unit) = (name.to_owned(), unit.to_owned());
            list.push(Parameter { name, unit, value: quantity.value, sigma: quantity.sigma, scope: quantity.scope });
        });
        list
    }

    /// Sets one parameter, SI; its prior and scope stay.
    ///
    /// # Errors
    /// No such name, or no finite value. Whether the plant is still possible is for
    /// `plant_file::validate`.
    pub fn set_parameter(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        if !value.is_finite() {
            return Err(ParameterError::NotFinite { name: name.to_owned(), value });
        }
        if self.put(name, value) || self.put_default(name, value) {
            return Ok(());
        }
        let parameters = self.parameters();
        let near = nearest(name, parameters.iter().map(|parameter| parameter.name.as_str()));
        Err(ParameterError::Unknown { name: name.to_owned(), nearest: near.map(str::to_owned) })
    }

    fn put(&mut self, name: &str, value: f64) -> bool {
        let mut found = false;
        self.visit_quantities(&mut |candidate, _, quantity| {
            if candidate == name {
                quantity.value = value;
                found = true;
            }
        });
        found
    }

    /// States a parameter of an effect that had its default.
    fn put_default(&mut self, name: &str, value: f64) -> bool {
        for i in 0..self.effects.len() {
            let mut changed = self.clone();
            changed.effects[i] = changed.effects[i].in_full(self.catalogue);
            if !changed.put(name, value) {
                continue;
            }
            let stated: Vec<String> = self.effects[i].values.iter().map(|(key, _)| key.clone()).collect();
            let new = |(key, _): &&(String, Quantity)| name.ends_with(&format!(".{key}"));
            let keep = changed.effects[i].values.iter().find(new).map(|(key, _)| key.clone());
            let mut values = core::mem::take(&mut changed.effects[i].values);
            values.retain(|(key, _)| stated.contains(key) || keep.as_ref() == Some(key));
            self.effects[i].values = values;
            return true;
        }
        false
    }

    /// Calls `visit(name, SI unit, quantity)` for every stated parameter, in file order.
    /// Positions of sensors at points of appendages follow those points.
    pub fn visit_quantities(&mut self, visit: &mut dyn FnMut(&str, &str, &mut Quantity)) {
        let units = Units::of(self);
        let mut visitor = Visitor { planar: self.space == Space::Planar, catalogue: self.catalogue, visit };
        visitor.environment(&mut self.environment);
        self.bodies.iter_mut().for_each(|body| visitor.body(body));
        self.tanks.iter_mut().for_each(|tank| visitor.tank(tank));
        self.appendages.iter_mut().for_each(|appendage| visitor.appendage(appendage));
        for (actuator, unit) in self.actuators.iter_mut().zip(&units.actuators) {
            visitor.actuator(actuator, unit);
        }
        for (controller, (effort, coordinate)) in self.controllers.iter_mut().zip(&units.controllers) {
            visitor.controller(controller, effort, coordinate);
        }
        for source in &mut self.sources {
            visitor.one(&source.name, "clock_offset", "s", &mut source.clock_offset_s);
            visitor.one(&source.name, "clock_skew", "1", &mut source.clock_skew);
        }
        for (sensor, unit) in self.sensors.iter_mut().zip(&units.sensors) {
            visitor.sensor(sensor, unit);
        }
        visitor.initial("initial", &mut self.initial, &units.initial[0]);
        for (segment, units) in self.segments.iter_mut().zip(&units.initial[1..]) {
            let prefix = format!("segment.{}", segment.name);
            visitor.one(&prefix, "begin", "s", &mut segment.begin_s);
            segment.end_s.iter_mut().for_each(|end| visitor.one(&prefix, "end", "s", end));
            visitor.initial(&prefix, &mut segment.initial, units);
        }
        visitor.effects(&mut self.effects, &units.effects);
        self.place_sensors_at_their_points();
    }

    fn place_sensors_at_their_points(&mut self) {
        let Self { sensors, appendages, .. } = self;
        for sensor in sensors {
            let SensorKind::Accelerometer { position_m, point: Some((appendage, point)), .. } = &mut sensor.kind else {
                continue;
            };
            let appendage = appendages.iter().find(|candidate| candidate.name == *appendage);
            let found = appendage.and_then(|a| a.points.iter().find(|(name, _)| name == point));
            *position_m = found.map_or(*position_m, |(_, position)| *position);
        }
    }

    /// Units of position and rate of the coordinate that an initial value names.
    pub fn initial_unit(&self, coordinate: &str) -> (&'static str, &'static str) {
        let (kind, name) = coordinate.split_once(':').unwrap_or(("", coordinate));
        let base = name.split('.').next().unwrap_or(name);
        let unit = match kind {
            "joint" => self.joint(name).map_or("rad", super::Joint::unit),
            "body" if name.rsplit('.').next().is_some_and(|component| component.starts_with('r')) => "rad",
            "tank" => self.tanks.iter().find(|tank| tank.name == base).map_or("m", Tank::unit),
            "mode" => return ("sqrt(kg)*m", "sqrt(kg)*m/s"),
            "wheel" => "rad",
            _ => "m",
        };
        if unit == "rad" { ("rad", "rad/s") } else { ("m", "m/s") }
    }

    /// Unit of an effect's parameter at its site; `unit` as the catalogue has it.
    pub fn effect_unit(&self, effect: &EffectUse, unit: &str) -> String {
        super::effect_use::unit_at(self, &effect.site, unit)
    }

    /// Unit of the actuator that a controller commands, and of the coordinate that it controls.
    pub fn controller_units(&self, controller: &Controller) -> (&'static str, &'static str) {
        let effort = self.actuator(&controller.actuator).map_or("N*m", |actuator| self.actuator_unit(actuator));
        let of = |name: &Option<String>| name.as_ref().and_then(|name| self.sensor(name)).map(|s| self.sensor_unit(s));
        let linear = match (of(&controller.position_sensor), of(&controller.rate_sensor)) {
            (Some(position), _) => position == "m",
            (None, Some(rate)) => rate == "m/s",
            (None, None) => false,
        };
        (effort, if linear { "m" } else { "rad" })
    }
}

/// Units that depend on other parts of the plant, taken before it is changed.
struct Units {
    actuators: Vec<&'static str>,
    controllers: Vec<(&'static str, &'static str)>,
    sensors: Vec<&'static str>,
    /// The record's, then each segment's.
    initial: Vec<Vec<(&'static str, &'static str)>>,
    effects: Vec<Vec<String>>,
}

impl Units {
    fn of(plant: &Plant) -> Self {
        let initial = |initial: &Initial| initial.values.iter().map(|v| plant.initial_unit(&v.coordinate)).collect();
        let segments = plant.segments.iter().map(|segment| initial(&segment.initial));
        Self {
            actuators: plant.actuators.iter().map(|actuator| plant.actuator_unit(actuator)).collect(),
            controllers: plant.controllers.iter().map(|controller| plant.controller_units(controller)).collect(),
            sensors: plant.sensors.iter().map(|sensor| plant.sensor_unit(sensor)).collect(),
            initial: core::iter::once(initial(&plant.initial)).chain(segments).collect(),
            effects: plant.effects.iter().map(|effect| super::effect_use::units(plant, effect)).collect(),
        }
    }
}
