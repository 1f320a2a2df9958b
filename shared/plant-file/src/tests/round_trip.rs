//! A plant that is written reads back equal: all files of deploy/plants, and random plants.

use super::{PLANT, plant, shown};
use crate::{parse, write};
use dynamics::description::*;
use dynamics::noise::Stream;

fn files() -> Vec<(String, String)> {
    let folder = format!("{}/../../deploy/plants", env!("CARGO_MANIFEST_DIR"));
    let of = |folder: String| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = of(folder.clone()).chain(of(format!("{folder}/rigs"))).filter(|p| p.is_file()).collect();
    paths.sort();
    paths.iter().map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn every_plant_of_the_house_reads_without_a_warning() {
    let files = files();
    assert!(files.len() >= 16, "{} plants", files.len());
    for (name, text) in files {
        let parsed = parse(&name, &text).unwrap_or_else(|errors| panic!("{}", shown(&errors)));
        assert!(parsed.warnings.is_empty(), "{}", shown(&parsed.warnings));
        assert!(name.ends_with(&format!("/{}.toml", parsed.plant.name)), "{name} is called {}", parsed.plant.name);
        assert!(!parsed.plant.about.is_empty());
    }
}

#[test]
fn every_plant_of_the_house_reads_back_equal() {
    for (name, text) in files() {
        let first = parse(&name, &text).unwrap().plant;
        let written = write(&first);
        let again = parse("written", &written).unwrap_or_else(|errors| panic!("{name}: {}", shown(&errors))).plant;
        assert!(again == first, "{name} changed:\n{written}");
        assert_eq!(write(&again), written);
    }
    assert!(plant(&write(&plant(PLANT))) == plant(PLANT));
}

/// Numbers and choices from a named stream.
struct Dice {
    stream: Stream,
    throws: u64,
}

impl Dice {
    fn normal(&mut self) -> f64 {
        self.throws += 1;
        self.stream.normal(self.throws)
    }

    fn chance(&mut self) -> bool {
        self.normal() > 0.0
    }

    /// Any size from 1e-12 to 1e12, both signs.
    fn number(&mut self) -> f64 {
        let exponent = (4.0 * self.normal()).clamp(-12.0, 12.0);
        self.normal() * 10f64.powf(exponent)
    }

    fn any(&mut self) -> Quantity {
        let value = if self.chance() { self.number() } else { 0.0 };
        self.prior(value)
    }

    fn positive(&mut self) -> Quantity {
        let value = self.number().abs() + 1e-9;
        self.prior(value)
    }

    fn prior(&mut self, value: f64) -> Quantity {
        let sigma = self.chance().then(|| self.number().abs() + 1e-12);
        let scope = match (self.chance(), self.chance()) {
            (true, _) => Scope::Shared,
            (false, true) => Scope::PerRecording,
            (false, false) => Scope::PerSegment,
        };
        Quantity { value, sigma, scope }
    }

    /// Within a factor of two of `value`.
    fn about(&mut self, value: f64) -> Quantity {
        let value = value * 2f64.powf(self.normal().clamp(-1.0, 1.0));
        self.prior(value)
    }

    /// Near the origin.
    fn place(&mut self) -> [Quantity; 3] {
        core::array::from_fn(|_| self.about(0.3))
    }

    fn maybe(&mut self) -> Option<Quantity> {
        self.chance().then(|| self.positive())
    }

    fn vector(&mut self) -> [Quantity; 3] {
        core::array::from_fn(|_| self.any())
    }

    fn axis(&mut self) -> [f64; 3] {
        if self.chance() {
            return [0.0, -1.0, 0.0];
        }
        let axis: [f64; 3] = core::array::from_fn(|_| self.normal());
        let norm = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        axis.map(|a| a / norm)
    }

    fn orientation(&mut self) -> Orientation {
        Orientation { axis: self.axis(), angle_rad: self.any() }
    }

    fn joint(&mut self, name: &str, kind: JointKind) -> Joint {
        let moves = matches!(kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
        let none = Quantity::known(0.0);
        let if_moves = |quantity: Quantity| if moves { quantity } else { none };
        Joint {
            name: name.to_owned(),
            viscous_friction: if_moves(self.positive()),
            rotor_inertia: if_moves(self.positive()),
            stiffness: if_moves(self.positive()),
            rest: if_moves(self.any()),
            position_m: self.place(),
            orientation: self.orientation(),
            kind,
        }
    }

    fn body(&mut self, name: &str, parent: Option<&str>, kind: JointKind) -> Body {
        // near a sphere's: definite, within the triangle inequality
        let size = self.about(10.0).value;
        let near = |share: f64, dice: &mut Self| {
            let value = size * share;
            dice.prior(value)
        };
        let inertia = [1.0, 1.2, 1.1, 0.01, -0.02, 0.0].map(|share| near(share, self));
        Body {
            name: name.to_owned(),
            parent: parent.map(str::to_owned),
            joint: self.joint(&format!("{name}_joint"), kind),
            mass_kg: self.about(20.0),
            com_m: self.place(),
            inertia_com_kg_m2: inertia,
        }
    }

    fn signals(&mut self) -> Vec<Signal> {
        let kinds = [
            SignalKind::Constant { value: self.any() },
            SignalKind::Sine { amplitude: self.any(), frequency_hz: self.positive(), phase_rad: self.any() },
            SignalKind::Square { amplitude: self.any(), frequency_hz: self.positive() },
            SignalKind::Multisine { rms: self.any(), period_s: self.positive(), first: 2, last: 9 },
            SignalKind::Chirp { amplitude: self.any(), begin_hz: self.positive(), end_hz: self.positive() },
            SignalKind::Fourier {
                offset: self.any(),
                period_s: self.positive(),
                sine: vec![self.any(), self.any()],
                cosine: vec![self.any(), self.any()],
            },
            SignalKind::Step { size: self.any() },
            SignalKind::Pulse { size: self.any(), width_s: self.positive(), period_s: self.maybe() },
            SignalKind::Staircase { step: self.any(), every_s: self.positive() },
            SignalKind::Slew { size: self.any(), width_s: self.positive() },
            SignalKind::Table {
                time_s: vec![-1.5, 0.1, 1e7 / 3.0],
                value: vec![self.number(), 0.0, 1e-300],
                smooth: self.chance(),
            },
        ];
        let mut signals = Vec::new();
        for kind in kinds {
            if self.chance() {
                let begin_s = self.any();
                let end = begin_s.value + self.positive().value.max(1e-3 * begin_s.value.abs());
                let end_s = self.chance().then(|| self.prior(end));
                signals.push(Signal { kind, begin_s, end_s });
            }
        }
        signals
    }

    fn actuators(&mut self) -> Vec<Actuator> {
        let hub = || "hub".to_owned();
        let kinds = [
            ActuatorKind::JointTorque { joint: "turn_joint".into() },
            ActuatorKind::BodyForce { body: hub(), position_m: self.vector(), direction: self.axis() },
            ActuatorKind::BodyTorque { body: hub(), direction: self.axis() },
            ActuatorKind::Thruster { body: hub(), position_m: self.vector(), direction: self.axis() },
            ActuatorKind::Wheel {
                body: hub(),
                axis: self.axis(),
                inertia_kg_m2: self.about(0.1),
                viscous_friction_n_m_s_rad: self.positive(),
                initial_speed_rad_s: self.any(),
            },
            ActuatorKind::Motor {
                joint: "turn_joint".into(),
                constant_n_m_a: self.positive(),
                gear: self.positive(),
                drive: if self.chance() {
                    Drive::Current
                } else {
                    Drive::Voltage { resistance_ohm: self.positive(), back_emf_v_s_rad: self.positive() }
                },
            },
            ActuatorKind::PrescribedJoint { joint: "slide_joint".into(), what: Prescribed::Rate },
            ActuatorKind::PrescribedBase {
                base: Base::Translation { direction: self.axis() },
                what: Prescribed::Acceleration,
            },
        ];
        let mut list = Vec::new();
        for (i, kind) in kinds.into_iter().enumerate() {
            let (name, recorded) = (format!("actuator_{i}"), self.chance());
            let (noise, range) = if kind.is_imposed() { Default::default() } else { (self.positive(), self.maybe()) };
            list.push(Actuator { name, kind, command: self.signals(), noise, range, recorded });
        }
        list
    }

    fn sensors(&mut self, appendage: &Appendage) -> Vec<Sensor> {
        let (hub, turn) = (|| "hub".to_owned(), || "turn_joint".to_owned());
        let at_tip = SensorKind::Accelerometer {
            body: hub(),
            position_m: appendage.points[1].1,
            axis: self.axis(),
            point: Some((appendage.name.clone(), appendage.points[1].0.clone())),
        };
        let kinds = [
            SensorKind::Gyro { body: hub(), axis: self.axis() },
            SensorKind::Accelerometer { body: hub(), position_m: self.vector(), axis: self.axis(), point: None },
            at_tip,
            SensorKind::Encoder { joint: "slide_joint".into() },
            SensorKind::JointRate { joint: turn() },
            SensorKind::JointTorque { joint: "slide_joint".into() },
            SensorKind::Force { joint: turn(), axis: self.axis() },
            SensorKind::Torque { joint: turn(), axis: self.axis() },
            SensorKind::Position { body: hub(), position_m: self.vector(), axis: self.axis() },
            SensorKind::Velocity { body: hub(), position_m: self.vector(), axis: self.axis() },
            SensorKind::Attitude { body: hub(), axis: self.axis() },
            SensorKind::WheelSpeed { actuator: "actuator_4".into() },
        ];
        let mut list = Vec::new();
        for (i, kind) in kinds.into_iter().enumerate() {
            list.push(Sensor {
                name: format!("sensor_{i}"),
                noise: match (self.chance(), self.chance()) {
                    (true, true) => Noise::Density(self.positive()),
                    (true, false) => Noise::Density(self.prior(0.0)),
                    (false, _) => Noise::PerSample(self.prior(0.0)),
                },
                bias: self.any(),
                scale: self.any(),
                misalignment: if kind.has_direction(false) { self.orientation() } else { Orientation::default() },
                range: self.maybe(),
                resolution: self.positive(),
                low_pass_hz: self.maybe(),
                delay_s: self.about(1.0),
                period_s: self.chance().then(|| self.about(0.02)),
                reading: if self.chance() { Reading::Mean } else { Reading::Instant },
                source: self.chance().then(|| "clock".to_owned()),
                kind,
            });
        }
        list
    }

    fn appendage(&mut self) -> Appendage {
        let points = vec![("b".to_owned(), self.vector()), ("a".to_owned(), self.vector())];
        let mode = |dice: &mut Self, name: &str| Mode {
            name: name.to_owned(),
            frequency_hz: dice.positive(),
            damping_ratio: dice.positive(),
            translation_sqrt_kg: dice.place(),
            rotation_sqrt_kg_m: dice.place(),
            shape_per_sqrt_kg: vec![dice.vector(), dice.vector()],
        };
        Appendage { name: "panel".into(), body: "hub".into(), points, modes: vec![mode(self, "m1"), mode(self, "m2")] }
    }

    fn tanks(&mut self) -> Vec<Tank> {
        let spring = TankModel::Spring {
            axes: vec![self.axis(), [0.0, 0.0, 1.0]],
            stiffness_n_m: vec![self.positive(), self.positive()],
            damping_n_s_m: vec![self.positive(), self.positive()],
        };
        let pendulum =
            TankModel::Pendulum { rest: self.axis(), length_m: self.about(1.0), damping_n_m_s_rad: self.positive() };
        [("fuel", spring), ("oxidiser", pendulum)]
            .into_iter()
            .map(|(name, model)| Tank {
                name: name.into(),
                body: "hub".into(),
                position_m: self.place(),
                mass_kg: self.about(5.0),
                model,
            })
            .collect()
    }

    fn initial(&mut self, coordinates: &[&str]) -> Initial {
        let value = |dice: &mut Self, coordinate: &&str| InitialValue {
            coordinate: (*coordinate).to_owned(),
            position: dice.any(),
            rate: dice.any(),
        };
        Initial {
            values: coordinates.iter().map(|coordinate| value(self, coordinate)).collect(),
            momentum_com_n_m_s: self.chance().then(|| self.vector()),
            on_reference: false,
        }
    }

    fn environment(&mut self) -> Environment {
        Environment {
            gravity_m_s2: self.vector(),
            constant_force_n: self.vector(),
            constant_torque_n_m: self.vector(),
            gravity_gradient: self
                .chance()
                .then(|| GravityGradient { orbit_rate_rad_s: self.positive(), phase_rad: self.any() }),
            atmosphere: self.chance().then(|| Atmosphere { density_kg_m3: self.positive(), wind_m_s: self.vector() }),
            magnetic_field: self.chance().then(|| MagneticField { field_t: self.vector() }),
        }
    }

    fn plant(&mut self) -> Plant {
        let appendage = self.appendage();
        let coordinates = [
            "joint:turn_joint",
            "body:hub.rz",
            "body:hub.x",
            "tank:fuel.2",
            "tank:oxidiser",
            "mode:m1",
            "wheel:actuator_4",
        ];
        Plant {
            catalogue: catalogue::CATALOGUE,
            name: "a \"quoted\" \\ name\n\u{7}".into(),
            about: "ü → ∞".into(),
            space: Space::Spatial,
            environment: self.environment(),
            bodies: vec![
                self.body("hub", None, JointKind::Free),
                {
                    let axis = self.axis();
                    self.body("turn", Some("hub"), JointKind::Revolute { axis })
                },
                {
                    let axis = self.axis();
                    self.body("slide", Some("turn"), JointKind::Prismatic { axis })
                },
                self.body("tool", Some("slide"), JointKind::Fixed),
            ],
            tanks: self.tanks(),
            actuators: self.actuators(),
            controllers: vec![Controller {
                name: "loop".into(),
                actuator: "actuator_0".into(),
                position_sensor: Some("sensor_10".into()),
                rate_sensor: Some("sensor_4".into()),
                kp: self.any(),
                ki: self.any(),
                kd: self.any(),
                reference: self.signals(),
                feed_forward: self.any(),
                reference_rate: self.chance(),
            }],
            sources: vec![Source {
                name: "clock".into(),
                clock_offset_s: self.any(),
                clock_skew: Quantity { value: 1e-5, ..self.any() },
            }],
            sensors: self.sensors(&appendage),
            appendages: vec![appendage],
            effects: Vec::new(),
            initial: self.initial(&coordinates),
            segments: vec![Segment {
                name: "coast".into(),
                begin_s: Quantity { value: 1.0, ..self.any() },
                end_s: self.chance().then(|| Quantity { value: 2.0 / 3.0 + 1.0, ..self.any() }),
                initial: self.initial(&coordinates[2..]),
            }],
            simulation: SimulationSettings {
                duration_s: self.about(60.0).value,
                period_s: self.about(0.02).value,
                step_s: self.about(0.004).value,
                integrator: if self.chance() { Integrator::Midpoint } else { Integrator::RungeKutta4 },
                jitter_s: self.positive().value,
            },
        }
    }
}

#[test]
fn random_plants_read_back_equal() {
    for seed in 0..100 {
        let mut dice = Dice { stream: Stream::new(seed, "plants"), throws: 0 };
        let first = dice.plant();
        let mut faults = crate::validate::validate(&first);
        faults.retain(|fault| !fault.warning);
        assert!(faults.is_empty(), "seed {seed}: {faults:?}");
        let written = write(&first);
        let again = parse("written", &written).unwrap_or_else(|errors| panic!("{}\n{written}", shown(&errors))).plant;
        assert!(again == first, "seed {seed}: {first:#?}\n{again:#?}");
    }
}

#[test]
fn a_plant_in_a_plane_reads_back_equal_with_its_priors() {
    for (from, to) in [
        ("joint = { kind = \"free\" }", "joint = { kind = \"free\" }"),
        (
            "com = [\"1.9 m\", 0]",
            "com = { value = [\"1.9 m\", 0], sigma = [\"3 mm\", \"4 mm\"], scope = \"per recording\" }",
        ),
    ] {
        let first = plant(&PLANT.replacen(from, to, 1));
        assert!(plant(&write(&first)) == first);
    }
}
