//! Actuators, their signals, and controllers.

use super::{At, Check, Must, not_positive};
use dynamics::description::{
    Actuator, ActuatorKind, Base, Controller, Drive, Integrator, Quantity, Signal, SignalKind,
};

impl Check<'_> {
    pub(super) fn actuators(&mut self) {
        let plant = self.plant;
        for (i, actuator) in plant.actuators.iter().enumerate() {
            let at = At::new("actuator", i, &actuator.name);
            self.actuator_kind(&at, &actuator.kind);
            let settings = &plant.simulation;
            let imposed = actuator.kind.is_imposed();
            // a motion is followed within each step, all else is held over a period
            let held_s = if imposed { settings.step_s.min(settings.period_s) } else { settings.period_s };
            self.signals(&at, "command", &actuator.command, held_s);
            self.number(&at, "noise", &actuator.noise, Must::NotNegative);
            self.optional(&at, "range", actuator.range.as_ref(), Must::Positive);
            self.one_driver(&at, i, actuator);
            if imposed {
                self.exact_motion(&at, actuator);
            } else if matches!(actuator.kind, ActuatorKind::Thruster { .. }) {
                self.pushes_only(&at, actuator);
            }
        }
    }

    /// A motion that is imposed is what it is.
    fn exact_motion(&mut self, at: &At, actuator: &Actuator) {
        let cure = "a motion that is imposed is exact: leave it out";
        if actuator.noise != Quantity::known(0.0) {
            self.fault(at, "noise", format!("noise of {}, which imposes a motion", at.what), cure);
        }
        if actuator.range.is_some() {
            self.fault(at, "range", format!("range of {}, which imposes a motion", at.what), cure);
        }
        if self.plant.simulation.integrator == Integrator::ExactZeroOrderHold {
            let message = format!("exact_zero_order_hold needs inputs that are held, and {} imposes a motion", at.what);
            self.fault(&At::new("simulation", 0, ""), "integrator", message, "use runge_kutta_4");
            self.because_of([at.place("kind")]);
        }
    }

    /// Below zero a thruster is shut.
    fn pushes_only(&mut self, at: &At, actuator: &Actuator) {
        if let Some((value, term)) = super::limits::lowest(&actuator.command).filter(|(value, _)| *value < 0.0) {
            let message = format!("the command of {} falls to {value} N", at.what);
            let cure = "a thruster gives nothing below zero; a body_force pushes both ways";
            self.warn(&at.within(&format!("command.{term}"), ""), "kind", message, cure);
        }
    }

    fn actuator_kind(&mut self, at: &At, kind: &ActuatorKind) {
        match kind {
            ActuatorKind::JointTorque { joint } | ActuatorKind::PrescribedJoint { joint, .. } => {
                self.moving_joint(at, "joint", joint);
            }
            ActuatorKind::BodyForce { body, position_m, direction }
            | ActuatorKind::Thruster { body, position_m, direction } => {
                self.known_body(at, "body", body);
                self.vector(at, "position", position_m);
                self.axis(at, "direction", direction, false);
            }
            ActuatorKind::BodyTorque { body, direction } => {
                self.known_body(at, "body", body);
                self.axis(at, "direction", direction, true);
            }
            ActuatorKind::Wheel { body, axis, inertia_kg_m2, viscous_friction_n_m_s_rad, initial_speed_rad_s } => {
                self.known_body(at, "body", body);
                self.axis(at, "axis", axis, true);
                self.number(at, "inertia", inertia_kg_m2, Must::Positive);
                self.number(at, "friction", viscous_friction_n_m_s_rad, Must::NotNegative);
                self.number(at, "initial_speed", initial_speed_rad_s, Must::Finite);
            }
            ActuatorKind::Motor { joint, constant_n_m_a, gear, drive } => {
                self.moving_joint(at, "joint", joint);
                self.number(at, "constant", constant_n_m_a, Must::Positive);
                self.number(at, "gear", gear, Must::Positive);
                if let Drive::Voltage { resistance_ohm, back_emf_v_s_rad } = drive {
                    self.number(at, "resistance", resistance_ohm, Must::Positive);
                    self.number(at, "back_emf", back_emf_v_s_rad, Must::NotNegative);
                }
            }
            ActuatorKind::PrescribedBase { base: Base::Translation { direction }, .. } => {
                self.axis(at, "direction", direction, false);
            }
        }
    }

    /// Where a joint's motion is imposed, nothing else can drive it.
    fn one_driver(&mut self, at: &At, index: usize, actuator: &Actuator) {
        let Some(joint) = joint_of(&actuator.kind) else { return };
        let imposed = |kind: &ActuatorKind| matches!(kind, ActuatorKind::PrescribedJoint { .. });
        let plant = self.plant;
        for earlier in &plant.actuators[..index] {
            let same = joint_of(&earlier.kind) == Some(joint);
            if same && (imposed(&earlier.kind) || imposed(&actuator.kind)) {
                let message = format!(
                    "the motion of joint '{joint}' is imposed, and both '{}' and '{}' drive it",
                    earlier.name, actuator.name
                );
                self.fault(at, "joint", message, "take one of them away");
            }
        }
    }

    /// `held_s`: over which it is held.
    pub(super) fn signals(&mut self, at: &At, key: &str, signals: &[Signal], held_s: f64) {
        for (k, signal) in signals.iter().enumerate() {
            let at = at.within(&format!("{key}.{k}"), key);
            self.signal(&at, signal);
            self.slow_enough(&at, signal, held_s);
            self.number(&at, "begin", &signal.begin_s, Must::Finite);
            self.end(&at, &signal.begin_s, signal.end_s.as_ref());
        }
    }

    pub(super) fn end(&mut self, at: &At, begin: &Quantity, end: Option<&Quantity>) {
        let Some(end) = end else { return };
        self.number(at, "end", end, Must::Finite);
        if end.value <= begin.value {
            let message = format!("{} ends at {} s, before it begins at {} s", at.what, end.value, begin.value);
            self.fault(at, "end", message, "");
        }
    }

    fn signal(&mut self, at: &At, signal: &Signal) {
        use Must::{Finite, Positive};
        match &signal.kind {
            SignalKind::Constant { value } => self.number(at, "value", value, Finite),
            SignalKind::Sine { amplitude, frequency_hz, phase_rad } => {
                self.number(at, "amplitude", amplitude, Finite);
                self.number(at, "frequency", frequency_hz, Positive);
                self.number(at, "phase", phase_rad, Finite);
            }
            SignalKind::Square { amplitude, frequency_hz } => {
                self.number(at, "amplitude", amplitude, Finite);
                self.number(at, "frequency", frequency_hz, Positive);
            }
            SignalKind::Multisine { rms, period_s, first, last } => {
                self.number(at, "rms", rms, Finite);
                self.number(at, "period", period_s, Positive);
                if *first == 0 || last < first {
                    let message = format!("harmonics of {} run from {first} to {last}", at.what);
                    self.fault(at, if *first == 0 { "first" } else { "last" }, message, "count them from 1 upwards");
                }
                self.harmonics(at, *first, *last);
            }
            SignalKind::Chirp { amplitude, begin_hz, end_hz } => {
                self.number(at, "amplitude", amplitude, Finite);
                self.number(at, "begin_frequency", begin_hz, Must::NotNegative);
                self.number(at, "end_frequency", end_hz, Must::NotNegative);
            }
            SignalKind::Fourier { offset, period_s, sine, cosine } => {
                self.number(at, "offset", offset, Finite);
                self.number(at, "period", period_s, Positive);
                sine.iter().for_each(|a| self.number(at, "sine", a, Finite));
                cosine.iter().for_each(|b| self.number(at, "cosine", b, Finite));
                if sine.len() != cosine.len() {
                    let message = format!("{} has {} sine and {} cosine terms", at.what, sine.len(), cosine.len());
                    self.fault(at, "cosine", message, "give as many of each; zeros where there are none");
                }
            }
            SignalKind::Step { size } => self.number(at, "size", size, Finite),
            SignalKind::Pulse { size, width_s, period_s } => {
                self.number(at, "size", size, Finite);
                self.number(at, "width", width_s, Positive);
                self.optional(at, "period", period_s.as_ref(), Positive);
            }
            SignalKind::Staircase { step, every_s } => {
                self.number(at, "step", step, Finite);
                self.number(at, "every", every_s, Positive);
            }
            SignalKind::Slew { size, width_s } => {
                self.number(at, "size", size, Finite);
                self.number(at, "width", width_s, Positive);
            }
            SignalKind::Table { time_s, value, .. } => self.table(at, time_s, value),
        }
    }

    fn table(&mut self, at: &At, time_s: &[f64], value: &[f64]) {
        if time_s.len() != value.len() || time_s.is_empty() {
            let message = format!("{} has {} times and {} values", at.what, time_s.len(), value.len());
            self.fault(at, "value", message, "a table has as many of each, and one row at least");
        }
        if let Some(row) = time_s.windows(2).position(|pair| not_positive(pair[1] - pair[0])) {
            let message = format!("times of {} do not grow: {} s, then {} s", at.what, time_s[row], time_s[row + 1]);
            self.fault(at, "time", message, "");
        }
        if time_s.iter().chain(value).any(|number| !number.is_finite()) {
            self.fault(at, "value", format!("{} holds a number that is not finite", at.what), "");
        }
    }

    pub(super) fn controllers(&mut self) {
        let plant = self.plant;
        for (i, controller) in plant.controllers.iter().enumerate() {
            let at = At::new("controller", i, &controller.name);
            let actuators = plant.actuators.iter().map(|actuator| &actuator.name);
            self.known(&at, "actuator", "actuator", &controller.actuator, actuators);
            if let Some(index) = plant.actuators.iter().position(|actuator| actuator.name == controller.actuator) {
                self.commanded(&at, controller, &plant.actuators[index], index);
            }
            if let Some(other) = plant.controllers[..i].iter().find(|other| other.actuator == controller.actuator) {
                let message =
                    format!("'{}' and '{}' both command '{}'", other.name, controller.name, controller.actuator);
                self.fault(&at, "actuator", message, "an actuator has one controller");
            }
            let sensors = || plant.sensors.iter().map(|sensor| &sensor.name);
            let position = controller.position_sensor.as_ref();
            let rate = controller.rate_sensor.as_ref();
            if let Some(name) = position
                && self.known(&at, "position_sensor", "sensor", name, sensors())
            {
                self.unit_of_sensor(&at, "position_sensor", name, &["rad", "m"]);
            }
            if let Some(name) = rate
                && self.known(&at, "rate_sensor", "sensor", name, sensors())
            {
                self.unit_of_sensor(&at, "rate_sensor", name, &["rad/s", "m/s"]);
            }
            for (key, gain, sensor, term) in [
                ("kp", &controller.kp, position.is_some(), "position_sensor"),
                ("ki", &controller.ki, position.is_some(), "position_sensor"),
                ("kd", &controller.kd, rate.is_some(), "rate_sensor"),
            ] {
                self.number(&at, key, gain, Must::Finite);
                if gain.value != 0.0 && !sensor {
                    let message = format!("{} has {key} = {} and no {term}", at.what, gain.value);
                    self.fault(&at, key, message, format!("name a {term}"));
                }
            }
            self.number(&at, "feed_forward", &controller.feed_forward, Must::Finite);
            self.signals(&at, "reference", &controller.reference, plant.simulation.period_s);
        }
    }

    /// What a loop can command.
    fn commanded(&mut self, at: &At, controller: &Controller, actuator: &Actuator, index: usize) {
        let kind = At::new("actuator", index, &actuator.name).place("kind");
        if actuator.kind.is_imposed() {
            let message = format!("{} commands '{}', which imposes a motion", at.what, actuator.name);
            self.fault(at, "actuator", message, "state the motion as its command, or command a joint_torque");
            self.because_of([kind]);
        } else if controller.feed_forward.value != 0.0 && joint_of(&actuator.kind).is_none() {
            let message = format!("{} feeds forward to '{}', which is in no joint", at.what, actuator.name);
            self.fault(at, "feed_forward", message, "inverse dynamics gives torques of joints: leave it out");
            self.because_of([kind]);
        }
    }

    fn unit_of_sensor(&mut self, at: &At, key: &str, name: &str, units: &[&str]) {
        let plant = self.plant;
        let Some(sensor) = plant.sensor(name) else { return };
        let unit = plant.sensor_unit(sensor);
        if !units.contains(&unit) {
            let message = format!("{key} of {} is '{name}', which reads {unit}", at.what);
            self.fault(at, key, message, format!("a {} reads {}", key.replace('_', " "), units.join(" or ")));
        }
    }
}

fn joint_of(kind: &ActuatorKind) -> Option<&str> {
    match kind {
        ActuatorKind::JointTorque { joint }
        | ActuatorKind::Motor { joint, .. }
        | ActuatorKind::PrescribedJoint { joint, .. } => Some(joint),
        _ => None,
    }
}
