//! Bodies, tanks, appendages, inputs and sensors as text.

use super::{Writer, direction, is_zero, list, number, quoted, value};
use dynamics::description::{
    Actuator, ActuatorKind, Appendage, Base, Body, Controller, Drive, Joint, JointKind, Noise, Orientation, Plant,
    Prescribed, Quantity, Reading, Sensor, SensorKind, Signal, SignalKind, SimulationSettings, Source, Tank, TankModel,
    per_second,
};

impl Writer {
    pub(super) fn body(&mut self, body: &Body) {
        self.header("[[body]]");
        self.text("name", &body.name);
        body.parent.iter().for_each(|parent| self.text("parent", parent));
        self.quantity("mass", &body.mass_kg, "kg");
        self.vector("com", &body.com_m, "m");
        let inertia = &body.inertia_com_kg_m2;
        if self.planar {
            self.quantity("inertia", &inertia[2], "kg*m^2");
        } else {
            let count = if inertia[3..].iter().all(is_zero) { 3 } else { 6 };
            self.line("inertia", &list(&inertia[..count], "kg*m^2"));
        }
        self.joint(body);
    }

    fn joint(&mut self, body: &Body) {
        let Joint { name, kind, .. } = &body.joint;
        self.header("[body.joint]");
        if *name != body.name {
            self.text("name", name);
        }
        let (word, axis) = match kind {
            JointKind::Free => ("free", None),
            JointKind::Fixed => ("fixed", None),
            JointKind::Revolute { axis } => ("revolute", Some(axis)),
            JointKind::Prismatic { axis } => ("prismatic", Some(axis)),
        };
        self.text("kind", word);
        axis.iter().for_each(|axis| self.line("axis", &direction(axis)));
        self.vector("position", &body.joint.position_m, "m");
        self.orientation("orientation", &body.joint.orientation);
        if axis.is_none() {
            return;
        }
        let [friction, inertia, stiffness] =
            if body.joint.is_prismatic() { ["N*s/m", "kg", "N/m"] } else { ["N*m*s/rad", "kg*m^2", "N*m/rad"] };
        self.unless_zero("friction", &body.joint.viscous_friction, friction);
        self.unless_zero("rotor_inertia", &body.joint.rotor_inertia, inertia);
        self.unless_zero("stiffness", &body.joint.stiffness, stiffness);
        self.unless_zero("rest", &body.joint.rest, body.joint.unit());
    }

    fn orientation(&mut self, key: &str, orientation: &Orientation) {
        if *orientation != Orientation::default() {
            let (axis, angle) = (direction(&orientation.axis), value(&orientation.angle_rad, "rad"));
            self.line(key, &format!("{{ axis = {axis}, angle = {angle} }}"));
        }
    }

    pub(super) fn tank(&mut self, tank: &Tank) {
        self.header("[[tank]]");
        self.text("name", &tank.name);
        self.text("body", &tank.body);
        self.quantity("mass", &tank.mass_kg, "kg");
        self.line("position", &list(self.components(&tank.position_m), "m"));
        match &tank.model {
            TankModel::Spring { axes, stiffness_n_m, damping_n_s_m } => {
                self.text("kind", "spring");
                let axes: Vec<String> = axes.iter().map(direction).collect();
                self.line("axes", &format!("[{}]", axes.join(", ")));
                self.line("stiffness", &list(stiffness_n_m, "N/m"));
                self.line("damping", &list(damping_n_s_m, "N*s/m"));
            }
            TankModel::Pendulum { rest, length_m, damping_n_m_s_rad } => {
                self.text("kind", "pendulum");
                self.line("rest", &direction(rest));
                self.quantity("length", length_m, "m");
                self.quantity("damping", damping_n_m_s_rad, "N*m*s/rad");
            }
        }
    }

    pub(super) fn appendage(&mut self, appendage: &Appendage) {
        self.header("[[appendage]]");
        self.text("name", &appendage.name);
        self.text("body", &appendage.body);
        for (point, position) in &appendage.points {
            self.line(&format!("points.{}", quoted(point)), &list(self.components(position), "m"));
        }
        for mode in &appendage.modes {
            self.header("[[appendage.mode]]");
            self.text("name", &mode.name);
            self.quantity("frequency", &mode.frequency_hz, "Hz");
            self.quantity("damping_ratio", &mode.damping_ratio, "1");
            self.vector("translation", &mode.translation_sqrt_kg, "sqrt(kg)");
            self.turning("rotation", &mode.rotation_sqrt_kg_m, "sqrt(kg)*m");
            for ((point, _), shape) in appendage.points.iter().zip(&mode.shape_per_sqrt_kg) {
                self.line(&format!("shape.{}", quoted(point)), &list(self.components(shape), "1/sqrt(kg)"));
            }
        }
    }

    pub(super) fn actuator(&mut self, plant: &Plant, actuator: &Actuator) {
        self.header("[[actuator]]");
        self.text("name", &actuator.name);
        self.actuator_kind(&actuator.kind);
        let unit = plant.actuator_unit(actuator);
        self.signals("command", &actuator.command, unit);
        self.unless_zero("noise", &actuator.noise, unit);
        actuator.range.iter().for_each(|range| self.quantity("range", range, unit));
        if !actuator.recorded {
            self.line("recorded", "false");
        }
    }

    fn actuator_kind(&mut self, kind: &ActuatorKind) {
        match kind {
            ActuatorKind::JointTorque { joint } => self.texts(&[("kind", "joint_torque"), ("joint", joint)]),
            ActuatorKind::BodyForce { body, position_m, direction: along }
            | ActuatorKind::Thruster { body, position_m, direction: along } => {
                let force = matches!(kind, ActuatorKind::BodyForce { .. });
                self.texts(&[("kind", if force { "body_force" } else { "thruster" }), ("body", body)]);
                self.line("position", &list(self.components(position_m), "m"));
                self.line("direction", &direction(along));
            }
            ActuatorKind::BodyTorque { body, direction: about } => {
                self.texts(&[("kind", "body_torque"), ("body", body)]);
                self.line("direction", &direction(about));
            }
            ActuatorKind::Wheel { body, axis, inertia_kg_m2, viscous_friction_n_m_s_rad, initial_speed_rad_s } => {
                self.texts(&[("kind", "wheel"), ("body", body)]);
                self.line("axis", &direction(axis));
                self.quantity("inertia", inertia_kg_m2, "kg*m^2");
                self.unless_zero("friction", viscous_friction_n_m_s_rad, "N*m*s/rad");
                self.unless_zero("initial_speed", initial_speed_rad_s, "rad/s");
            }
            ActuatorKind::Motor { joint, constant_n_m_a, gear, drive } => {
                self.texts(&[("kind", "motor"), ("joint", joint)]);
                self.quantity("constant", constant_n_m_a, "N*m/A");
                self.quantity("gear", gear, "1");
                if let Drive::Voltage { resistance_ohm, back_emf_v_s_rad } = drive {
                    self.text("drive", "voltage");
                    self.quantity("resistance", resistance_ohm, "ohm");
                    self.quantity("back_emf", back_emf_v_s_rad, "V*s/rad");
                }
            }
            ActuatorKind::PrescribedJoint { joint, what } => {
                self.texts(&[("kind", "prescribed_joint"), ("joint", joint), ("what", prescribed(*what))]);
            }
            ActuatorKind::PrescribedBase { base: Base::Translation { direction: along }, what } => {
                self.texts(&[("kind", "prescribed_base"), ("what", prescribed(*what))]);
                self.line("direction", &direction(along));
            }
        }
    }

    fn texts(&mut self, pairs: &[(&str, &str)]) {
        pairs.iter().for_each(|(key, text)| self.text(key, text));
    }

    fn signals(&mut self, key: &str, signals: &[Signal], unit: &str) {
        let terms: Vec<String> = signals.iter().map(|term| signal(term, unit)).collect();
        match &terms[..] {
            [] => {}
            [one] => self.line(key, one),
            many => self.line(key, &format!("[\n    {},\n]", many.join(",\n    "))),
        }
    }

    pub(super) fn controller(&mut self, plant: &Plant, controller: &Controller) {
        self.header("[[controller]]");
        self.texts(&[("name", &controller.name), ("actuator", &controller.actuator)]);
        controller.position_sensor.iter().for_each(|sensor| self.text("position_sensor", sensor));
        controller.rate_sensor.iter().for_each(|sensor| self.text("rate_sensor", sensor));
        let (effort, coordinate) = plant.controller_units(controller);
        self.unless_zero("kp", &controller.kp, &format!("{effort}/{coordinate}"));
        self.unless_zero("ki", &controller.ki, &format!("{effort}/{coordinate}/s"));
        self.unless_zero("kd", &controller.kd, &format!("{effort}*s/{coordinate}"));
        self.signals("reference", &controller.reference, coordinate);
        self.unless_zero("feed_forward", &controller.feed_forward, "1");
        if !controller.reference_rate {
            self.line("reference_rate", "false");
        }
    }

    pub(super) fn source(&mut self, source: &Source) {
        self.header("[[source]]");
        self.text("name", &source.name);
        self.unless_zero("clock_offset", &source.clock_offset_s, "s");
        self.unless_zero("clock_skew", &source.clock_skew, "1");
    }

    pub(super) fn sensor(&mut self, plant: &Plant, sensor: &Sensor) {
        self.header("[[sensor]]");
        self.text("name", &sensor.name);
        self.sensor_kind(&sensor.kind);
        let unit = plant.sensor_unit(sensor);
        match &sensor.noise {
            // a density of zero is still a density
            Noise::Density(density) if density.value == 0.0 => {
                let text = value(density, &format!("{unit}*sqrt(s)"));
                self.line("noise", &text.replacen('0', &format!("\"0 {unit}*sqrt(s)\""), 1));
            }
            Noise::Density(density) => self.quantity("noise", density, &format!("{unit}*sqrt(s)")),
            Noise::PerSample(sigma) => self.unless_zero("noise", sigma, unit),
        }
        self.unless_zero("bias", &sensor.bias, unit);
        self.unless_zero("scale", &sensor.scale, "1");
        self.orientation("misalignment", &sensor.misalignment);
        sensor.range.iter().for_each(|range| self.quantity("range", range, unit));
        self.unless_zero("resolution", &sensor.resolution, unit);
        sensor.low_pass_hz.iter().for_each(|cut_off| self.quantity("low_pass", cut_off, "Hz"));
        self.unless_zero("delay", &sensor.delay_s, "s");
        sensor.period_s.iter().for_each(|period| self.quantity("period", period, "s"));
        if sensor.reading == Reading::Mean {
            self.text("reading", "mean");
        }
        sensor.source.iter().for_each(|source| self.text("source", source));
    }

    fn sensor_kind(&mut self, kind: &SensorKind) {
        match kind {
            SensorKind::Gyro { body, axis } => self.on_body("gyro", body, None, axis),
            SensorKind::Attitude { body, axis } => self.on_body("attitude", body, None, axis),
            SensorKind::Accelerometer { axis, point: Some((appendage, point)), .. } => {
                self.texts(&[("kind", "accelerometer"), ("point", &format!("{appendage}:{point}"))]);
                self.line("axis", &direction(axis));
            }
            SensorKind::Accelerometer { body, position_m, axis, point: None } => {
                self.on_body("accelerometer", body, Some(position_m), axis);
            }
            SensorKind::Position { body, position_m, axis } => self.on_body("position", body, Some(position_m), axis),
            SensorKind::Velocity { body, position_m, axis } => self.on_body("velocity", body, Some(position_m), axis),
            SensorKind::Encoder { joint } => self.texts(&[("kind", "encoder"), ("joint", joint)]),
            SensorKind::JointRate { joint } => self.texts(&[("kind", "joint_rate"), ("joint", joint)]),
            SensorKind::JointTorque { joint } => self.texts(&[("kind", "joint_torque"), ("joint", joint)]),
            SensorKind::Force { joint, axis } => {
                self.texts(&[("kind", "force"), ("joint", joint)]);
                self.line("axis", &direction(axis));
            }
            SensorKind::Torque { joint, axis } => {
                self.texts(&[("kind", "torque"), ("joint", joint)]);
                self.line("axis", &direction(axis));
            }
            SensorKind::WheelSpeed { actuator } => self.texts(&[("kind", "wheel_speed"), ("actuator", actuator)]),
        }
    }

    fn on_body(&mut self, kind: &str, body: &str, position_m: Option<&[Quantity; 3]>, axis: &[f64; 3]) {
        self.texts(&[("kind", kind), ("body", body)]);
        position_m.iter().for_each(|position| self.vector("position", position, "m"));
        self.line("axis", &direction(axis));
    }

    pub(super) fn simulation(&mut self, settings: &SimulationSettings) {
        self.header("[simulation]");
        let seconds = |value: f64| format!("\"{} s\"", number(value));
        self.line("duration", &seconds(settings.duration_s));
        self.line("period", &seconds(settings.period_s));
        self.line("step", &seconds(settings.step_s));
        self.text("integrator", super::super::run::integrator_word(settings.integrator));
        if settings.jitter_s != 0.0 {
            self.line("jitter", &seconds(settings.jitter_s));
        }
    }
}

fn prescribed(what: Prescribed) -> &'static str {
    match what {
        Prescribed::Position => "position",
        Prescribed::Rate => "rate",
        Prescribed::Acceleration => "acceleration",
    }
}

/// One term as an inline table.
fn signal(signal: &Signal, unit: &str) -> String {
    let mut pairs: Vec<(&str, String)> = Vec::new();
    let mut put = |key: &'static str, quantity: &Quantity, unit: &str| pairs.push((key, value(quantity, unit)));
    let kind = match &signal.kind {
        SignalKind::Constant { value } => {
            put("value", value, unit);
            "constant"
        }
        SignalKind::Sine { amplitude, frequency_hz, phase_rad } => {
            put("amplitude", amplitude, unit);
            put("frequency", frequency_hz, "Hz");
            put("phase", phase_rad, "rad");
            "sine"
        }
        SignalKind::Square { amplitude, frequency_hz } => {
            put("amplitude", amplitude, unit);
            put("frequency", frequency_hz, "Hz");
            "square"
        }
        SignalKind::Multisine { rms, period_s, first, last } => {
            put("rms", rms, unit);
            put("period", period_s, "s");
            pairs.push(("first", first.to_string()));
            pairs.push(("last", last.to_string()));
            "multisine"
        }
        SignalKind::Chirp { amplitude, begin_hz, end_hz } => {
            put("amplitude", amplitude, unit);
            put("begin_frequency", begin_hz, "Hz");
            put("end_frequency", end_hz, "Hz");
            "chirp"
        }
        SignalKind::Fourier { offset, period_s, sine, cosine } => {
            put("offset", offset, unit);
            put("period", period_s, "s");
            pairs.push(("sine", list(sine, &per_second(unit))));
            pairs.push(("cosine", list(cosine, &per_second(unit))));
            "fourier"
        }
        SignalKind::Step { size } => {
            put("size", size, unit);
            "step"
        }
        SignalKind::Pulse { size, width_s, period_s } => {
            put("size", size, unit);
            put("width", width_s, "s");
            period_s.iter().for_each(|period| put("period", period, "s"));
            "pulse"
        }
        SignalKind::Staircase { step, every_s } => {
            put("step", step, unit);
            put("every", every_s, "s");
            "staircase"
        }
        SignalKind::Slew { size, width_s } => {
            put("size", size, unit);
            put("width", width_s, "s");
            "slew"
        }
        SignalKind::Table { time_s, value, smooth } => {
            pairs.push(("time", values(time_s, "s")));
            pairs.push(("value", values(value, unit)));
            pairs.push(("smooth", smooth.to_string()));
            "table"
        }
    };
    if !is_zero(&signal.begin_s) {
        pairs.push(("begin", value(&signal.begin_s, "s")));
    }
    pairs.extend(signal.end_s.iter().map(|end| ("end", value(end, "s"))));
    let pairs: Vec<String> = pairs.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    format!("{{ kind = {}, {} }}", quoted(kind), pairs.join(", "))
}

/// Many numbers in one unit.
fn values(list: &[f64], unit: &str) -> String {
    let numbers: Vec<String> = list.iter().map(|value| number(*value)).collect();
    format!("{{ unit = {}, values = [{}] }}", quoted(unit), numbers.join(", "))
}
