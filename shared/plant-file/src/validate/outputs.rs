//! Sensors and the clocks of their sources.

use super::{At, Check, Must};
use dynamics::description::{Noise, Orientation, Sensor, SensorKind};

impl Check<'_> {
    pub(super) fn sources(&mut self) {
        let plant = self.plant;
        for (i, source) in plant.sources.iter().enumerate() {
            let at = At::new("source", i, &source.name);
            self.number(&at, "clock_offset", &source.clock_offset_s, Must::Finite);
            self.number(&at, "clock_skew", &source.clock_skew, Must::Finite);
            if source.clock_skew.value <= -1.0 {
                self.fault(&at, "clock_skew", format!("the clock of {} stands or runs backwards", at.what), "");
            }
        }
    }

    pub(super) fn sensors(&mut self) {
        let plant = self.plant;
        for (i, sensor) in plant.sensors.iter().enumerate() {
            let at = At::new("sensor", i, &sensor.name);
            self.sensor_kind(&at, &sensor.kind);
            self.channel(&at, sensor);
        }
    }

    fn sensor_kind(&mut self, at: &At, kind: &SensorKind) {
        let plant = self.plant;
        match kind {
            SensorKind::Gyro { body, axis } | SensorKind::Attitude { body, axis } => {
                self.known_body(at, "body", body);
                self.axis(at, "axis", axis, true);
            }
            SensorKind::Accelerometer { body, position_m, axis, point } => {
                self.known_body(at, "body", body);
                self.vector(at, "position", position_m);
                self.axis(at, "axis", axis, false);
                if let Some((appendage, point)) = point {
                    self.point(at, body, appendage, point);
                }
            }
            SensorKind::Position { body, position_m, axis } | SensorKind::Velocity { body, position_m, axis } => {
                self.known_body(at, "body", body);
                self.vector(at, "position", position_m);
                self.axis(at, "axis", axis, false);
            }
            SensorKind::Encoder { joint } | SensorKind::JointRate { joint } | SensorKind::JointTorque { joint } => {
                self.moving_joint(at, "joint", joint);
            }
            SensorKind::Force { joint, axis } => {
                self.known_joint(at, "joint", joint);
                self.axis(at, "axis", axis, false);
            }
            SensorKind::Torque { joint, axis } => {
                self.known_joint(at, "joint", joint);
                self.axis(at, "axis", axis, true);
            }
            SensorKind::WheelSpeed { actuator } => {
                let wheel = |kind: &dynamics::description::ActuatorKind| {
                    matches!(kind, dynamics::description::ActuatorKind::Wheel { .. })
                };
                let wheels = plant.actuators.iter().filter(|a| wheel(&a.kind)).map(|actuator| &actuator.name);
                self.known(at, "actuator", "wheel", actuator, wheels);
            }
        }
    }

    fn point(&mut self, at: &At, body: &str, appendage: &str, point: &str) {
        let plant = self.plant;
        if !self.known(at, "point", "appendage", appendage, plant.appendages.iter().map(|a| &a.name)) {
            return;
        }
        for found in plant.appendages.iter().filter(|candidate| candidate.name == appendage) {
            self.known(
                at,
                "point",
                &format!("point of '{appendage}'"),
                point,
                found.points.iter().map(|(name, _)| name),
            );
            if found.body != body {
                let message =
                    format!("{} sits on body '{body}' and on '{appendage}', which is on '{}'", at.what, found.body);
                self.fault(at, "body", message, "leave body out: the appendage has one");
            }
        }
    }

    fn channel(&mut self, at: &At, sensor: &Sensor) {
        let plant = self.plant;
        let (Noise::PerSample(noise) | Noise::Density(noise)) = &sensor.noise;
        self.number(at, "noise", noise, Must::NotNegative);
        self.number(at, "bias", &sensor.bias, Must::Finite);
        self.number(at, "scale", &sensor.scale, Must::Finite);
        self.number(at, "misalignment", &sensor.misalignment.angle_rad, Must::Finite);
        self.axis(&at.within("misalignment", "misalignment"), "axis", &sensor.misalignment.axis, true);
        if sensor.misalignment != Orientation::default() && !sensor.kind.has_direction(self.planar()) {
            let message = format!("{} has no sensitive axis that a misalignment could turn", at.what);
            let cure =
                if self.planar() { "in a plane only what points in x or y is misaligned" } else { "leave it out" };
            self.fault(at, "misalignment", message, cure);
        }
        self.optional(at, "range", sensor.range.as_ref(), Must::Positive);
        self.number(at, "resolution", &sensor.resolution, Must::NotNegative);
        self.optional(at, "low_pass", sensor.low_pass_hz.as_ref(), Must::Positive);
        self.number(at, "delay", &sensor.delay_s, Must::NotNegative);
        self.optional(at, "period", sensor.period_s.as_ref(), Must::Positive);
        if let Some(source) = &sensor.source {
            self.known(at, "source", "source", source, plant.sources.iter().map(|source| &source.name));
        }
    }
}
