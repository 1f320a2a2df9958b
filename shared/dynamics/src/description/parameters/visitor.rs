//! The walk over every parameter of a plant, part by part.

use crate::description::{
    Actuator, ActuatorKind, Appendage, Body, Controller, Drive, EffectUse, Environment, Initial, InitialValue,
    JointKind, Noise, Quantity, Sensor, SensorKind, Signal, SignalKind, Tank, TankModel,
};
use crate::effect::Catalogue;

/// Visits the parameters of one part of a plant after the other, each with its name and unit.
pub(super) struct Visitor<'v> {
    pub planar: bool,
    pub catalogue: Catalogue,
    pub visit: &'v mut dyn FnMut(&str, &str, &mut Quantity),
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Visitor<'_> {
    /// Visits the parameter `prefix.key` with its SI unit.
    pub fn one(&mut self, prefix: &str, key: &str, unit: &str, quantity: &mut Quantity) {
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

    /// Gravity, constant force and torque, atmosphere, orbit and field: `environment.…`.
    pub fn environment(&mut self, environment: &mut Environment) {
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

    /// Mass, centre of mass and inertia of a body, and its joint.
    pub fn body(&mut self, body: &mut Body) {
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

    /// Position and slosh mass of a tank; stiffness and damping of its springs, or length and
    /// damping of its pendulum.
    pub fn tank(&mut self, tank: &mut Tank) {
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

    /// Points, and frequency, damping, participations and shapes of every mode.
    pub fn appendage(&mut self, appendage: &mut Appendage) {
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

    /// Geometry, wheel or motor parameters, command, noise and range of an actuator; `unit` is that
    /// of its input.
    pub fn actuator(&mut self, actuator: &mut Actuator, unit: &str) {
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
                let per_second = crate::description::per_second(unit);
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

    /// Gains, reference and feed-forward of a controller; `effort` and `coordinate` are units.
    pub fn controller(&mut self, controller: &mut Controller, effort: &str, coordinate: &str) {
        let name = &controller.name;
        self.one(name, "kp", &format!("{effort}/{coordinate}"), &mut controller.kp);
        self.one(name, "ki", &format!("{effort}/{coordinate}/s"), &mut controller.ki);
        self.one(name, "kd", &format!("{effort}*s/{coordinate}"), &mut controller.kd);
        self.signals(name, "reference", coordinate, &mut controller.reference);
        self.one(name, "feed_forward", "1", &mut controller.feed_forward);
    }

    /// Position, noise, bias, scale, misalignment, range, resolution, filter and times of a sensor;
    /// `unit` is that of its channel.
    pub fn sensor(&mut self, sensor: &mut Sensor, unit: &str) {
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

    /// Initial angular momentum, positions and rates; `units` has position and rate of each
    /// coordinate.
    pub fn initial(&mut self, prefix: &str, initial: &mut Initial, units: &[(&str, &str)]) {
        if let Some(momentum) = &mut initial.momentum_com_n_m_s {
            self.turning(prefix, "momentum", "N*m*s", momentum);
        }
        for (InitialValue { coordinate, position, rate }, (unit, rate_unit)) in initial.values.iter_mut().zip(units) {
            let prefix = format!("{prefix}.{coordinate}");
            self.one(&prefix, "position", unit, position);
            self.one(&prefix, "rate", rate_unit, rate);
        }
    }

    /// Values of every effect, `effect.KIND@SITE.NAME`; a second effect of that name is numbered.
    pub fn effects(&mut self, effects: &mut [EffectUse], units: &[Vec<String>]) {
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
