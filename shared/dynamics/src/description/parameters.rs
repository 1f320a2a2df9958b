//! Every number of a plant by a stable, unique name with its unit: one visitor, from which listing and setting derive.
//!
//! Names are those of the file: `hub.mass`, `link_1.com.x`, `shoulder.friction`, `fuel.stiffness.x`, `bending_1.frequency`, `gyro.bias`,
//! `effect.joint_coulomb@joint:shoulder.force`, `initial.joint:shoulder.rate`. Components that a planar plant cannot have are left out.

use super::{
    Actuator, ActuatorKind, Appendage, Body, Controller, Drive, EffectUse, Environment, Initial, InitialValue,
    JointKind, Noise, Plant, Quantity, Scope, Sensor, SensorKind, Signal, SignalKind, Space, Tank, TankModel, nearest,
};
use crate::effect::Catalogue;

/// One number of a plant.
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

/// Why a number cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    #[error("no parameter is called '{name}'{}", nearest.as_ref().map(|n| format!("; did you mean '{n}'?")).unwrap_or_default())]
    Unknown { name: String, nearest: Option<String> },
    #[error("{name} = {value}: not a finite number")]
    NotFinite { name: String, value: f64 },
}

impl Plant {
    /// Every number, in file order; of effects also those that stand at the catalogue's default.
    pub fn parameters(&self) -> Vec<Parameter> {
        let mut list = Vec::new();
        let effects = self.effects.iter().map(|effect| effect.in_full(self.catalogue)).collect();
        Self { effects, ..self.clone() }.visit_quantities(&mut |name, unit, quantity| {
            let (name, unit) = (name.to_owned(), unit.to_owned());
            list.push(Parameter { name, unit, value: quantity.value, sigma: quantity.sigma, scope: quantity.scope });
        });
        list
    }

    /// Sets one number, SI; its prior and scope stay.
    ///
    /// # Errors
    /// No such name, or no finite value. Whether the plant is still possible is for [`Plant::validate`].
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

    /// States a number of an effect that stood at its default.
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

    /// Calls `visit(name, SI unit, number)` for every number that is stated, in file order. Positions of sensors at points of appendages follow those
    /// points.
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

    /// Units of the two derivatives of what an initial value names.
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

struct Visitor<'v> {
    planar: bool,
    catalogue: Catalogue,
    visit: &'v mut dyn FnMut(&str, &str, &mut Quantity),
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Visitor<'_> {
    fn one(&mut self, prefix: &str, key: &str, unit: &str, quantity: &mut Quantity) {
        (self.visit)(&format!("{prefix}.{key}"), unit, quantity);
    }

    /// A vector of translation; in a plane without z.
    fn vector(&mut self, prefix: &str, key: &str, unit: &str, vector: &mut [Quantity; 3]) {
        let count = if self.planar { 2 } else { 3 };
        for (axis, quantity) in AXES.iter().zip(vector).take(count) {
            self.one(prefix, &format!("{key}.{axis}"), unit, quantity);
        }
    }

    /// A vector of rotation; in a plane only z.
    fn turning(&mut self, prefix: &str, key: &str, unit: &str, vector: &mut [Quantity; 3]) {
        let first = if self.planar { 2 } else { 0 };
        for (axis, quantity) in AXES.iter().zip(vector).skip(first) {
            self.one(prefix, &format!("{key}.{axis}"), unit, quantity);
        }
    }

    fn environment(&mut self, environment: &mut Environment) {
        let prefix = "environment";
        self.vector(prefix, "gravity", "m/s^2", &mut environment.gravity_m_s2);
        self.vector(prefix, "constant_force", "N", &mut environment.constant_force_n);
        self.turning(prefix, "constant_torque", "N*m", &mut environment.constant_torque_n_m);
        if let Some(gradient) = &mut environment.gravity_gradient {
            self.one(prefix, "gravity_gradient.orbit_rate", "rad/s", &mut gradient.orbit_rate_rad_s);
            self.one(prefix, "gravity_gradient.phase", "rad", &mut gradient.phase_rad);
        }
        if let Some(atmosphere) = &mut environment.atmosphere {
            self.one(prefix, "atmosphere.density", "kg/m^3", &mut atmosphere.density_kg_m3);
            self.vector(prefix, "atmosphere.wind", "m/s", &mut atmosphere.wind_m_s);
        }
        if let Some(field) = &mut environment.magnetic_field {
            // a field may cross the plane
            for (axis, quantity) in AXES.iter().zip(&mut field.field_t) {
                self.one(prefix, &format!("magnetic_field.{axis}"), "T", quantity);
            }
        }
    }

    fn body(&mut self, body: &mut Body) {
        let name = &body.name;
        self.one(name, "mass", "kg", &mut body.mass_kg);
        self.vector(name, "com", "m", &mut body.com_m);
        const ELEMENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];
        for (i, (element, quantity)) in ELEMENTS.iter().zip(&mut body.inertia_com_kg_m2).enumerate() {
            if !self.planar || i == 2 {
                self.one(name, &format!("inertia.{element}"), "kg*m^2", quantity);
            }
        }
        let joint = &mut body.joint;
        let name = joint.name.clone();
        self.vector(&name, "position", "m", &mut joint.position_m);
        self.one(&name, "orientation", "rad", &mut joint.orientation.angle_rad);
        if !matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. }) {
            return;
        }
        let [friction, inertia, stiffness] =
            if joint.is_prismatic() { ["N*s/m", "kg", "N/m"] } else { ["N*m*s/rad", "kg*m^2", "N*m/rad"] };
        let unit = joint.unit();
        self.one(&name, "friction", friction, &mut joint.viscous_friction);
        self.one(&name, "rotor_inertia", inertia, &mut joint.rotor_inertia);
        self.one(&name, "stiffness", stiffness, &mut joint.stiffness);
        self.one(&name, "rest", unit, &mut joint.rest);
    }

    fn tank(&mut self, tank: &mut Tank) {
        let name = &tank.name;
        self.vector(name, "position", "m", &mut tank.position_m);
        self.one(name, "mass", "kg", &mut tank.mass_kg);
        match &mut tank.model {
            TankModel::Spring { axes, stiffness_n_m, damping_n_s_m } => {
                let labels = axis_labels(axes);
                for (label, quantity) in labels.iter().zip(stiffness_n_m) {
                    self.one(name, &format!("stiffness.{label}"), "N/m", quantity);
                }
                for (label, quantity) in labels.iter().zip(damping_n_s_m) {
                    self.one(name, &format!("damping.{label}"), "N*s/m", quantity);
                }
            }
            TankModel::Pendulum { length_m, damping_n_m_s_rad, .. } => {
                self.one(name, "length", "m", length_m);
                self.one(name, "damping", "N*m*s/rad", damping_n_m_s_rad);
            }
        }
    }

    fn appendage(&mut self, appendage: &mut Appendage) {
        let points: Vec<String> = appendage.points.iter().map(|(name, _)| name.clone()).collect();
        for (point, position) in &mut appendage.points {
            self.vector(&appendage.name, point, "m", position);
        }
        for mode in &mut appendage.modes {
            self.one(&mode.name, "frequency", "Hz", &mut mode.frequency_hz);
            self.one(&mode.name, "damping_ratio", "1", &mut mode.damping_ratio);
            self.vector(&mode.name, "translation", "sqrt(kg)", &mut mode.translation_sqrt_kg);
            self.turning(&mode.name, "rotation", "sqrt(kg)*m", &mut mode.rotation_sqrt_kg_m);
            for (point, shape) in points.iter().zip(&mut mode.shape_per_sqrt_kg) {
                self.vector(&mode.name, &format!("shape.{point}"), "1/sqrt(kg)", shape);
            }
        }
    }

    fn actuator(&mut self, actuator: &mut Actuator, unit: &str) {
        let name = &actuator.name;
        match &mut actuator.kind {
            ActuatorKind::BodyForce { position_m, .. } | ActuatorKind::Thruster { position_m, .. } => {
                self.vector(name, "position", "m", position_m);
            }
            ActuatorKind::Wheel { inertia_kg_m2, viscous_friction_n_m_s_rad, initial_speed_rad_s, .. } => {
                self.one(name, "inertia", "kg*m^2", inertia_kg_m2);
                self.one(name, "friction", "N*m*s/rad", viscous_friction_n_m_s_rad);
                self.one(name, "initial_speed", "rad/s", initial_speed_rad_s);
            }
            ActuatorKind::Motor { constant_n_m_a, gear, drive, .. } => {
                self.one(name, "constant", "N*m/A", constant_n_m_a);
                self.one(name, "gear", "1", gear);
                if let Drive::Voltage { resistance_ohm, back_emf_v_s_rad } = drive {
                    self.one(name, "resistance", "ohm", resistance_ohm);
                    self.one(name, "back_emf", "V*s/rad", back_emf_v_s_rad);
                }
            }
            ActuatorKind::JointTorque { .. }
            | ActuatorKind::BodyTorque { .. }
            | ActuatorKind::PrescribedJoint { .. }
            | ActuatorKind::PrescribedBase { .. } => {}
        }
        self.signals(name, "command", unit, &mut actuator.command);
        if actuator.kind.is_imposed() {
            return; // it has neither noise nor range
        }
        self.one(name, "noise", unit, &mut actuator.noise);
        actuator.range.iter_mut().for_each(|range| self.one(name, "range", unit, range));
    }

    /// Terms are counted from 1.
    fn signals(&mut self, name: &str, key: &str, unit: &str, signals: &mut [Signal]) {
        for (i, signal) in signals.iter_mut().enumerate() {
            let prefix = format!("{name}.{key}.{}", i + 1);
            self.signal(&prefix, unit, &mut signal.kind);
            self.one(&prefix, "begin", "s", &mut signal.begin_s);
            signal.end_s.iter_mut().for_each(|end| self.one(&prefix, "end", "s", end));
        }
    }

    fn signal(&mut self, prefix: &str, unit: &str, kind: &mut SignalKind) {
        let mut one = |key: &str, unit: &str, quantity: &mut Quantity| self.one(prefix, key, unit, quantity);
        match kind {
            SignalKind::Constant { value } => one("value", unit, value),
            SignalKind::Sine { amplitude, frequency_hz, phase_rad } => {
                one("amplitude", unit, amplitude);
                one("frequency", "Hz", frequency_hz);
                one("phase", "rad", phase_rad);
            }
            SignalKind::Square { amplitude, frequency_hz } => {
                one("amplitude", unit, amplitude);
                one("frequency", "Hz", frequency_hz);
            }
            SignalKind::Multisine { rms, period_s, .. } => {
                one("rms", unit, rms);
                one("period", "s", period_s);
            }
            SignalKind::Chirp { amplitude, begin_hz, end_hz } => {
                one("amplitude", unit, amplitude);
                one("begin_frequency", "Hz", begin_hz);
                one("end_frequency", "Hz", end_hz);
            }
            SignalKind::Fourier { offset, period_s, sine, cosine } => {
                one("offset", unit, offset);
                one("period", "s", period_s);
                let per_second = super::per_second(unit);
                for (key, coefficients) in [("sine", sine), ("cosine", cosine)] {
                    for (k, coefficient) in coefficients.iter_mut().enumerate() {
                        one(&format!("{key}.{}", k + 1), &per_second, coefficient);
                    }
                }
            }
            SignalKind::Step { size } => one("size", unit, size),
            SignalKind::Pulse { size, width_s, period_s } => {
                one("size", unit, size);
                one("width", "s", width_s);
                period_s.iter_mut().for_each(|period| one("period", "s", period));
            }
            SignalKind::Staircase { step, every_s } => {
                one("step", unit, step);
                one("every", "s", every_s);
            }
            SignalKind::Slew { size, width_s } => {
                one("size", unit, size);
                one("width", "s", width_s);
            }
            SignalKind::Table { .. } => {}
        }
    }

    fn controller(&mut self, controller: &mut Controller, effort: &str, coordinate: &str) {
        let name = &controller.name;
        self.one(name, "kp", &format!("{effort}/{coordinate}"), &mut controller.kp);
        self.one(name, "ki", &format!("{effort}/{coordinate}/s"), &mut controller.ki);
        self.one(name, "kd", &format!("{effort}*s/{coordinate}"), &mut controller.kd);
        self.signals(name, "reference", coordinate, &mut controller.reference);
        self.one(name, "feed_forward", "1", &mut controller.feed_forward);
    }

    fn sensor(&mut self, sensor: &mut Sensor, unit: &str) {
        let name = &sensor.name;
        match &mut sensor.kind {
            SensorKind::Accelerometer { position_m, point: None, .. }
            | SensorKind::Position { position_m, .. }
            | SensorKind::Velocity { position_m, .. } => self.vector(name, "position", "m", position_m),
            _ => {}
        }
        match &mut sensor.noise {
            Noise::PerSample(sigma) => self.one(name, "noise", unit, sigma),
            Noise::Density(density) => self.one(name, "noise", &format!("{unit}*sqrt(s)"), density),
        }
        self.one(name, "bias", unit, &mut sensor.bias);
        self.one(name, "scale", "1", &mut sensor.scale);
        if sensor.kind.has_direction(self.planar) {
            self.one(name, "misalignment", "rad", &mut sensor.misalignment.angle_rad);
        }
        sensor.range.iter_mut().for_each(|range| self.one(name, "range", unit, range));
        self.one(name, "resolution", unit, &mut sensor.resolution);
        sensor.low_pass_hz.iter_mut().for_each(|cut_off| self.one(name, "low_pass", "Hz", cut_off));
        self.one(name, "delay", "s", &mut sensor.delay_s);
        sensor.period_s.iter_mut().for_each(|period| self.one(name, "period", "s", period));
    }

    fn initial(&mut self, prefix: &str, initial: &mut Initial, units: &[(&str, &str)]) {
        if let Some(momentum) = &mut initial.momentum_com_n_m_s {
            self.turning(prefix, "momentum", "N*m*s", momentum);
        }
        for (InitialValue { coordinate, position, rate }, (unit, rate_unit)) in initial.values.iter_mut().zip(units) {
            let prefix = format!("{prefix}.{coordinate}");
            self.one(&prefix, "position", unit, position);
            self.one(&prefix, "rate", rate_unit, rate);
        }
    }

    fn effects(&mut self, effects: &mut [EffectUse], units: &[Vec<String>]) {
        let mut names: Vec<String> = Vec::with_capacity(effects.len());
        for (effect, units) in effects.iter_mut().zip(units) {
            let name = format!("effect.{}@{}", effect.kind, effect.site);
            let earlier = names.iter().filter(|other| **other == name).count();
            names.push(name.clone());
            // the second of the same kind at the same site
            let name = if earlier == 0 { name } else { format!("{name}#{}", earlier + 1) };
            let catalogue = self.catalogue;
            let out_of_plane = |key: &str| {
                let entry = catalogue.effect(&effect.kind);
                entry.is_some_and(|entry| entry.parameters.iter().any(|p| p.name == key && p.out_of_plane))
            };
            for ((key, quantity), unit) in effect.values.iter_mut().zip(units) {
                if !(self.planar && out_of_plane(key)) {
                    self.one(&name, key, unit, quantity);
                }
            }
        }
    }
}

/// `x`, `y`, `z` where every axis is another one of them, either way; else numbers from 1.
pub(super) fn axis_labels(axes: &[[f64; 3]]) -> Vec<String> {
    let along = |axis: &[f64; 3]| (0..3).find(|i| (0..3).all(|k| axis[k].abs() == f64::from(u8::from(k == *i))));
    let named: Option<Vec<usize>> = axes.iter().map(along).collect();
    let named = named.filter(|named| named.iter().enumerate().all(|(i, axis)| !named[..i].contains(axis)));
    named.map_or_else(
        || (1..=axes.len()).map(|i| i.to_string()).collect(),
        |named| named.iter().map(|i| AXES[*i].to_owned()).collect(),
    )
}
