//! Tools for tests of laws: random states, work over a cycle, and a plant with one of everything.

use dynamics::description::{
    Actuator, ActuatorKind, Appendage, Body, Joint, JointKind, Mode, Noise, Orientation, Plant, Quantity, Reading,
    Sensor, SensorKind, Space, Tank, TankModel,
};
use dynamics::dual::Dual;
use dynamics::effect::{Action, BodyState, Both, Effect, HIDDEN_MAX, Law, Local, Surroundings};
use dynamics::noise::Stream;
use dynamics::real::Real;

/// Arguments of a law: zero, upright and at rest, but for the fields that a test states.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    pub t_s: f64,
    pub coordinate: f64,
    pub rate: f64,
    pub command: f64,
    pub reading: f64,
    pub body: BodyState<f64>,
    pub hidden: [f64; HIDDEN_MAX],
    pub surroundings: Surroundings,
}

impl Default for Trial {
    fn default() -> Self {
        Self {
            t_s: 0.0,
            coordinate: 0.0,
            rate: 0.0,
            command: 0.0,
            reading: 0.0,
            body: BodyState { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..BodyState::default() },
            hidden: [0.0; HIDDEN_MAX],
            surroundings: Surroundings { body_mass_kg: 1.0, site_axis: [1.0, 0.0, 0.0], ..Surroundings::default() },
        }
    }
}

/// Numbers of one sign or the other, of a size that varies over four decades.
struct Draw {
    stream: Stream,
    next: u64,
}

impl Draw {
    fn number(&mut self) -> f64 {
        self.next += 1;
        let [u, w] = self.stream.uniform_pair(self.next);
        (2.0 * u - 1.0) * libm::pow(10.0, 4.0 * w - 2.0)
    }

    fn vector(&mut self) -> [f64; 3] {
        [self.number(), self.number(), self.number()]
    }

    fn rotation(&mut self) -> [[f64; 3]; 3] {
        let (sin, cos) = libm::sincos(self.number());
        let (s, c) = libm::sincos(self.number());
        [[cos, -sin * c, sin * s], [sin, cos * c, -cos * s], [0.0, s, c]]
    }
}

impl Trial {
    /// The `k`-th random state.
    pub fn random(k: u64) -> Self {
        let mut draw = Draw { stream: Stream::new(k, "trial of a law"), next: 0 };
        let body = BodyState {
            rotation: draw.rotation(),
            position_m: draw.vector(),
            omega_rad_s: draw.vector(),
            velocity_m_s: draw.vector(),
            alpha_rad_s2: draw.vector(),
            specific_force_m_s2: draw.vector(),
        };
        let surroundings = Surroundings {
            gravity_m_s2: draw.vector(),
            orbit_rate_rad_s: 1e-3,
            orbit_phase_rad: draw.number(),
            density_kg_m3: 1.2,
            wind_m_s: draw.vector(),
            field_t: draw.vector(),
            body_mass_kg: 3.0,
            body_com_m: draw.vector(),
            body_inertia_com_kg_m2: [[2.0, 0.1, 0.2], [0.1, 3.0, 0.3], [0.2, 0.3, 4.0]],
            site_position_m: draw.vector(),
            site_axis: super::geometry::direction(draw.number(), draw.number()),
            back_emf_v_s_rad: 0.3,
            step_s: 0.0,
            one_sided: false,
            quiet: 0.0,
        };
        Self {
            t_s: draw.number().abs(),
            coordinate: draw.number(),
            rate: draw.number(),
            command: draw.number(),
            reading: draw.number(),
            body,
            hidden: [draw.number(), draw.number(), draw.number(), draw.number()].map(|z| z.clamp(-1.0, 1.0)),
            surroundings,
        }
    }

    /// The action before the law.
    pub fn untouched(&self, effect: &Effect) -> Action<f64> {
        let value = match effect.law {
            Law::Actuator(_) => self.command,
            Law::Sensor(_) => self.reading,
            _ => 0.0,
        };
        Action { value, ..Action::default() }
    }

    /// The action after the law with these parameters.
    pub fn act(&self, effect: &Effect, parameters: &[f64]) -> Action<f64> {
        let mut action = self.untouched(effect);
        let local = Local {
            t_s: self.t_s,
            coordinate: self.coordinate,
            rate: self.rate,
            displacement: self.surroundings.site_axis.map(|a| a * self.coordinate),
            displacement_rate: self.surroundings.site_axis.map(|a| a * self.rate),
            command: self.command,
            reading: self.reading,
            body: &self.body,
            hidden: &self.hidden[..effect.hidden_states],
            surroundings: &self.surroundings,
        };
        (both(effect).expect("the effect acts through a law").real)(&local, parameters, &mut action);
        action
    }

    /// The same over dual numbers, every argument moving as in `direction`.
    pub fn act_dual(&self, effect: &Effect, parameters: &[f64], direction: &Self) -> Action<Dual> {
        let d = |value: f64, derivative: f64| Dual::new(value, derivative);
        let vector = |a: [f64; 3], b: [f64; 3]| core::array::from_fn(|i| d(a[i], b[i]));
        let body = BodyState {
            rotation: core::array::from_fn(|i| vector(self.body.rotation[i], direction.body.rotation[i])),
            position_m: vector(self.body.position_m, direction.body.position_m),
            omega_rad_s: vector(self.body.omega_rad_s, direction.body.omega_rad_s),
            velocity_m_s: vector(self.body.velocity_m_s, direction.body.velocity_m_s),
            alpha_rad_s2: vector(self.body.alpha_rad_s2, direction.body.alpha_rad_s2),
            specific_force_m_s2: vector(self.body.specific_force_m_s2, direction.body.specific_force_m_s2),
        };
        let hidden: [Dual; HIDDEN_MAX] = core::array::from_fn(|i| d(self.hidden[i], direction.hidden[i]));
        let local = Local {
            t_s: self.t_s,
            coordinate: d(self.coordinate, direction.coordinate),
            rate: d(self.rate, direction.rate),
            displacement: self.surroundings.site_axis.map(|a| d(self.coordinate, direction.coordinate).scale(a)),
            displacement_rate: self.surroundings.site_axis.map(|a| d(self.rate, direction.rate).scale(a)),
            command: d(self.command, direction.command),
            reading: d(self.reading, direction.reading),
            body: &body,
            hidden: &hidden[..effect.hidden_states],
            surroundings: &self.surroundings,
        };
        let value = match effect.law {
            Law::Actuator(_) => local.command,
            Law::Sensor(_) => local.reading,
            _ => Dual::constant(0.0),
        };
        let mut action = Action { value, ..Action::default() };
        (both(effect).expect("the effect acts through a law").dual)(&local, parameters, &mut action);
        action
    }

    /// This state moved by `step` along `direction`; time and surroundings stay.
    pub fn moved(&self, direction: &Self, step: f64) -> Self {
        let vector = |a: [f64; 3], b: [f64; 3]| core::array::from_fn(|i| a[i] + step * b[i]);
        let (b, d) = (&self.body, &direction.body);
        Self {
            t_s: self.t_s,
            coordinate: self.coordinate + step * direction.coordinate,
            rate: self.rate + step * direction.rate,
            command: self.command + step * direction.command,
            reading: self.reading + step * direction.reading,
            body: BodyState {
                rotation: core::array::from_fn(|i| vector(b.rotation[i], d.rotation[i])),
                position_m: vector(b.position_m, d.position_m),
                omega_rad_s: vector(b.omega_rad_s, d.omega_rad_s),
                velocity_m_s: vector(b.velocity_m_s, d.velocity_m_s),
                alpha_rad_s2: vector(b.alpha_rad_s2, d.alpha_rad_s2),
                specific_force_m_s2: vector(b.specific_force_m_s2, d.specific_force_m_s2),
            },
            hidden: core::array::from_fn(|i| self.hidden[i] + step * direction.hidden[i]),
            surroundings: self.surroundings,
        }
    }

    pub fn force(&self, effect: &Effect, parameters: &[f64]) -> f64 {
        self.act(effect, parameters).force
    }

    pub fn value(&self, effect: &Effect, parameters: &[f64]) -> f64 {
        self.act(effect, parameters).value
    }

    pub fn wrench(&self, effect: &Effect, parameters: &[f64]) -> [f64; 6] {
        self.act(effect, parameters).wrench
    }

    /// Power of the wrench on the moving body [W].
    pub fn body_power(&self, effect: &Effect, parameters: &[f64]) -> f64 {
        let w = self.wrench(effect, parameters);
        (0..3).map(|i| w[i] * self.body.omega_rad_s[i] + w[i + 3] * self.body.velocity_m_s[i]).sum()
    }
}

/// The law of an effect that acts through one.
pub fn both(effect: &Effect) -> Option<Both> {
    match effect.law {
        Law::Coordinate(law) | Law::Body(law) | Law::Actuator(law) | Law::Sensor(law) => Some(law),
        Law::ActuatorFilter(_) | Law::SensorFilter(_) | Law::Structure(_) => None,
    }
}

/// Every parameter at its default.
pub fn defaults(effect: &Effect) -> Vec<f64> {
    effect.parameters.iter().map(|parameter| parameter.default).collect()
}

/// Work [J] that the force does along q = a sin ωt during the third cycle, hidden states moving
/// with it (midpoint rule).
pub fn work_of_a_cycle(effect: &Effect, parameters: &[f64], amplitude: f64, omega: f64) -> f64 {
    let steps = 20_000;
    let dt = core::f64::consts::TAU / omega / f64::from(steps);
    let at = |t: f64, hidden: [f64; HIDDEN_MAX]| {
        let (sin, cos) = libm::sincos(omega * t);
        Trial { t_s: t, coordinate: amplitude * sin, rate: amplitude * omega * cos, hidden, ..Trial::default() }
    };
    let mut hidden = [0.0; HIDDEN_MAX];
    let mut work = 0.0;
    for step in 0..3 * steps {
        let t = f64::from(step) * dt;
        let first = at(t, hidden).act(effect, parameters).hidden_rate;
        let half = core::array::from_fn(|i| hidden[i] + 0.5 * dt * first[i]);
        let middle = at(t + 0.5 * dt, half);
        let action = middle.act(effect, parameters);
        hidden = core::array::from_fn(|i| hidden[i] + dt * action.hidden_rate[i]);
        if step >= 2 * steps {
            work += action.force * middle.rate * dt;
        }
    }
    work
}

/// Tests the law of a force −c |v| v: its work over a cycle is that of c, and it never drives.
pub fn damps_with_the_square_of_the_rate(effect: &Effect) {
    let (c, a, omega) = (0.7, 0.3, 2.0);
    let expected = -8.0 / 3.0 * c * omega * omega * a * a * a;
    let work = work_of_a_cycle(effect, &[c], a, omega);
    assert!((work - expected).abs() < 1e-8 * expected.abs()); // midpoint rule, |cos|³ has a jump in its 3rd derivative
    for k in 0..200 {
        let state = Trial::random(k);
        assert!(state.force(effect, &[2.0]) * state.rate <= 0.0);
    }
}

fn known<const N: usize>(values: [f64; N]) -> [Quantity; N] {
    values.map(Quantity::known)
}

fn joint(name: &str, kind: JointKind, position_m: [f64; 3]) -> Joint {
    let zero = Quantity::known(0.0);
    Joint {
        name: name.to_owned(),
        kind,
        position_m: known(position_m),
        orientation: Orientation::default(),
        viscous_friction: zero,
        rotor_inertia: zero,
        stiffness: zero,
        rest: zero,
    }
}

fn mode(name: &str, frequency_hz: f64, translation: f64, rotation: f64) -> Mode {
    Mode {
        name: name.to_owned(),
        frequency_hz: Quantity::known(frequency_hz),
        damping_ratio: Quantity::known(0.005),
        translation_sqrt_kg: known([0.0, translation, 0.0]),
        rotation_sqrt_kg_m: known([0.0, 0.0, rotation]),
        shape_per_sqrt_kg: vec![known([0.0, 0.5 * frequency_hz, 0.0])],
    }
}

/// A slender beam of 0.25 kg and 2 m along x.
fn spar(body: String) -> Appendage {
    let points = [0.25, 0.5, 1.0].map(|share| (format!("at_{share}"), known([0.5 + 2.0 * share, 0.0, 0.0])));
    // Blevins, table 8-1
    let shape_per_sqrt_kg = [0.097, 0.3395, 1.0].map(|shape| known([0.0, 4.0 * shape, 0.0]));
    let shape_per_sqrt_kg = shape_per_sqrt_kg.to_vec();
    let modes = vec![Mode { shape_per_sqrt_kg, ..mode("spar_bending", 0.8, 0.39, 0.77) }];
    Appendage { name: "spar".to_owned(), body, points: points.to_vec(), modes }
}

fn sensor(name: &str, kind: SensorKind) -> Sensor {
    let zero = Quantity::known(0.0);
    Sensor {
        name: name.to_owned(),
        kind,
        noise: Noise::default(),
        bias: zero,
        scale: zero,
        misalignment: Orientation::default(),
        range: None,
        resolution: zero,
        low_pass_hz: None,
        delay_s: zero,
        period_s: None,
        reading: Reading::Instant,
        source: None,
    }
}

fn actuator(name: &str, kind: ActuatorKind) -> Actuator {
    Actuator {
        name: name.to_owned(),
        kind,
        command: Vec::new(),
        noise: Quantity::known(0.0),
        range: None,
        recorded: true,
    }
}

/// Hub with thruster, wheel, tank, appendage and spar, one arm joint, a gyro, an accelerometer
/// and an encoder; planar, 400 kg.
pub fn plant() -> Plant {
    let (hub, elbow) = ("hub".to_owned(), "elbow".to_owned());
    let z = [0.0, 0.0, 1.0];
    let hub_body = Body {
        name: hub.clone(),
        parent: None,
        joint: joint("hub", JointKind::Free, [0.0; 3]),
        mass_kg: Quantity::known(400.0),
        com_m: known([0.02, -0.01, 0.0]),
        inertia_com_kg_m2: known([60.0, 70.0, 80.0, 1.0, -2.0, 0.5]),
    };
    let arm = Body {
        name: "arm".to_owned(),
        parent: Some(hub.clone()),
        joint: joint("elbow", JointKind::Revolute { axis: z }, [0.5, 0.0, 0.0]),
        mass_kg: Quantity::known(10.0),
        com_m: known([0.6, 0.0, 0.0]),
        inertia_com_kg_m2: known([0.2, 1.2, 1.2, 0.0, 0.0, 0.0]),
    };
    let wheel = ActuatorKind::Wheel {
        body: hub.clone(),
        axis: z,
        inertia_kg_m2: Quantity::known(0.02),
        viscous_friction_n_m_s_rad: Quantity::known(0.0),
        initial_speed_rad_s: Quantity::known(0.0),
    };
    let thruster =
        ActuatorKind::Thruster { body: hub.clone(), position_m: known([-0.5, 0.2, 0.0]), direction: [1.0, 0.0, 0.0] };
    let accelerometer = SensorKind::Accelerometer {
        body: hub.clone(),
        position_m: known([0.1, 0.2, 0.0]),
        axis: [1.0, 0.0, 0.0],
        point: None,
    };
    Plant {
        name: "one of everything".to_owned(),
        catalogue: super::CATALOGUE,
        space: Space::Planar,
        bodies: vec![hub_body, arm],
        tanks: vec![Tank {
            name: "oxidiser".to_owned(),
            body: hub.clone(),
            position_m: known([0.1, 0.0, 0.0]),
            mass_kg: Quantity::known(40.0),
            model: TankModel::Spring {
                axes: vec![[0.0, 1.0, 0.0]],
                stiffness_n_m: vec![Quantity::known(30.0)],
                damping_n_s_m: vec![Quantity::known(0.8)],
            },
        }],
        appendages: vec![
            Appendage {
                name: "panel".to_owned(),
                body: hub.clone(),
                points: vec![("tip".to_owned(), known([0.0, 4.0, 0.0]))],
                modes: vec![mode("bending", 0.3, 2.5, 4.0), mode("second", 1.9, 1.2, 0.7)],
            },
            spar(hub.clone()),
        ],
        actuators: vec![
            actuator("main", thruster),
            actuator("rw", wheel),
            actuator("drive", ActuatorKind::JointTorque { joint: elbow.clone() }),
        ],
        sensors: vec![
            sensor("gyro_z", SensorKind::Gyro { body: hub, axis: z }),
            sensor("acc_x", accelerometer),
            sensor("enc", SensorKind::Encoder { joint: elbow }),
        ],
        ..Plant::default()
    }
}
