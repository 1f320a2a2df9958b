//! Hidden effects of a case: laws of this crate under the names and parameters of the catalogue.
//!
//! Dry friction sticks and slips at located instants instead of a smooth tanh. Every other law is
//! the one of its name.

use crate::equations::Extra;
use serde::{Deserialize, Serialize};

/// One hidden effect. The first value is its amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    pub kind: String,
    pub site: String,
    pub values: Vec<(String, f64)>,
}

impl Hidden {
    /// The first value; zero without values.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        self.values.first().map_or(0.0, |(_, value)| *value)
    }

    /// The same with another amplitude.
    #[must_use]
    pub fn scaled(&self, amplitude: f64) -> Self {
        let mut other = self.clone();
        if let Some(first) = other.values.first_mut() {
            first.1 = amplitude;
        }
        other
    }

    fn value(&self, index: usize) -> f64 {
        self.values.get(index).map_or(0.0, |(_, value)| *value)
    }
}

/// Place of a law in the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seat {
    /// A coordinate of the machine.
    Coordinate(usize),
    Input(usize),
    Sensor(usize),
    /// The structure of the machine changes.
    Structure,
}

/// Dry friction in a coordinate: `level + extra exp(−(v / rate)²)`, opposed to the rate v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dry {
    pub coordinate: usize,
    pub level: f64,
    pub extra: f64,
    pub rate: f64,
}

impl Dry {
    /// Magnitude at rate `v`.
    #[must_use]
    pub fn magnitude(&self, v: f64) -> f64 {
        if self.extra == 0.0 {
            return self.level;
        }
        self.level + self.extra * libm::exp(-(v / self.rate) * (v / self.rate))
    }
}

/// A smooth force on a coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    Constant(f64),
    Viscous(f64),
    Quadratic(f64),
    CubicDamping(f64),
    Stiffness(f64),
    CubicStiffness(f64),
    Ripple {
        sine: f64,
        order: f64,
    },
    /// Force, yield displacement, exponent, share; its hidden state has the index `state`.
    BoucWen {
        force: f64,
        give: f64,
        exponent: f64,
        share: f64,
        state: usize,
    },
}

impl Force {
    /// Force at coordinate `q` and rate `v`, with the hidden states of the case.
    #[must_use]
    pub fn at(&self, q: f64, v: f64, hidden: &[f64]) -> f64 {
        match *self {
            Self::Constant(force) => force,
            Self::Viscous(c) => -c * v,
            Self::Quadratic(c) => -c * v.abs() * v,
            Self::CubicDamping(c) => -c * v * v * v,
            Self::Stiffness(k) => -k * q,
            Self::CubicStiffness(k) => -k * q * q * q,
            Self::Ripple { sine, order } => sine * libm::sin(order * q),
            Self::BoucWen { force, state, .. } => -force * hidden[state],
        }
    }

    /// Index and rate of its hidden state.
    #[must_use]
    pub fn rate(&self, v: f64, hidden: &[f64]) -> Option<(usize, f64)> {
        let Self::BoucWen { give, exponent, share, state, .. } = *self else { return None };
        let z = hidden[state];
        let knee = libm::pow(z.abs(), exponent - 1.0);
        Some((state, (v - share * v.abs() * knee * z - (1.0 - share) * v * knee * z.abs()) / give))
    }
}

/// Map and dynamics from a command to the acting input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InputFault {
    pub bias: f64,
    pub dead: f64,
    pub gain: f64,
    pub delay_s: f64,
    pub lag_s: f64,
}

impl InputFault {
    /// Static part of the map.
    #[must_use]
    pub fn acting(&self, u: f64) -> f64 {
        let live = if u.abs() > self.dead { u - self.dead * u.signum() } else { 0.0 };
        (1.0 + self.gain) * live + self.bias
    }
}

/// Errors of a true reading before its noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorFault {
    pub scale: f64,
    pub quadratic: f64,
    pub drift: f64,
    pub delay_s: f64,
    pub lag_s: f64,
    /// Amplitude, order, phase.
    pub ripple: [f64; 3],
    /// Amplitude, frequency, phase.
    pub tone: [f64; 3],
    /// Size, begin, duration.
    pub step: [f64; 3],
}

impl SensorFault {
    /// The erroneous reading of `truth` at `t_s`, without delay, lag and noise.
    #[must_use]
    pub fn reading(&self, t_s: f64, truth: f64) -> f64 {
        let [ripple, order, phase] = self.ripple;
        let [tone, frequency_hz, tone_phase] = self.tone;
        let [step, begin_s, duration_s] = self.step;
        let mut y = truth * (1.0 + self.scale) + self.quadratic * truth * truth + self.drift * t_s;
        if ripple != 0.0 {
            y += ripple * libm::sin(order * truth + phase);
        }
        if tone != 0.0 {
            y += tone * libm::sin(core::f64::consts::TAU * frequency_hz * t_s + tone_phase);
        }
        if t_s >= begin_s && t_s < begin_s + duration_s {
            y += step;
        }
        y
    }
}

/// All hidden effects of a case, sorted by place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    pub extra: Extra,
    pub dry: Vec<Dry>,
    pub forces: Vec<(usize, Force)>,
    pub inputs: Vec<InputFault>,
    pub sensors: Vec<SensorFault>,
    pub hidden_states: usize,
}

impl Faults {
    /// # Panics
    /// A kind without a law in this crate: a menu is wrong.
    #[must_use]
    pub fn of(list: &[(Hidden, Seat)], inputs: usize, sensors: usize) -> Self {
        let mut faults = Self {
            inputs: vec![InputFault::default(); inputs],
            sensors: vec![SensorFault::default(); sensors],
            ..Self::default()
        };
        for (hidden, seat) in list {
            match *seat {
                Seat::Structure => faults.structure(hidden),
                Seat::Coordinate(coordinate) => faults.coordinate(hidden, coordinate),
                Seat::Input(index) => input(&mut faults.inputs[index], hidden),
                Seat::Sensor(index) => sensor(&mut faults.sensors[index], hidden),
            }
        }
        faults
    }

    fn structure(&mut self, hidden: &Hidden) {
        let [a, b, c] = [0, 1, 2].map(|index| hidden.value(index));
        match hidden.kind.as_str() {
            "joint_flexibility" if a > 0.0 => self.extra.gear = Some([a, b]),
            "slosh_second_mode" | "mode_left_out" if a > 0.0 => self.extra.second = Some([a, b, c]),
            "joint_flexibility" | "slosh_second_mode" | "mode_left_out" => {}
            other => panic!("no structure '{other}'"),
        }
    }

    fn coordinate(&mut self, hidden: &Hidden, coordinate: usize) {
        let a = hidden.value(0);
        let force = match hidden.kind.as_str() {
            "joint_coulomb" => return self.dry(coordinate, a, 0.0, 1.0),
            "joint_stribeck" => return self.dry(coordinate, 0.0, a, hidden.value(1)),
            "joint_torque_bias" => Force::Constant(a),
            "joint_viscous" => Force::Viscous(a),
            "joint_quadratic_damping" | "slosh_quadratic_damping" | "mode_quadratic_damping" => Force::Quadratic(a),
            "joint_cubic_damping" => Force::CubicDamping(a),
            "joint_stiffness" => Force::Stiffness(a),
            "joint_cubic_stiffness" | "slosh_cubic" | "mode_duffing" => Force::CubicStiffness(a),
            "joint_gear_ripple" => Force::Ripple { sine: a, order: hidden.value(2) },
            "joint_bouc_wen" => {
                self.hidden_states += 1;
                let (give, exponent, share) = (hidden.value(1), hidden.value(2), hidden.value(3));
                Force::BoucWen { force: a, give, exponent, share, state: self.hidden_states - 1 }
            }
            other => panic!("no force '{other}'"),
        };
        self.forces.push((coordinate, force));
    }

    fn dry(&mut self, coordinate: usize, level: f64, extra: f64, rate: f64) {
        // two laws of one place are one contact
        if let Some(dry) = self.dry.iter_mut().find(|dry| dry.coordinate == coordinate) {
            dry.level += level;
            if extra != 0.0 {
                (dry.extra, dry.rate) = (extra, rate);
            }
        } else if level > 0.0 || extra > 0.0 {
            self.dry.push(Dry { coordinate, level, extra, rate });
        }
    }
}

fn input(fault: &mut InputFault, hidden: &Hidden) {
    let a = hidden.value(0);
    match hidden.kind.as_str() {
        "actuator_bias" => fault.bias = a,
        "motor_constant_error" => fault.gain = a,
        "actuator_dead_zone" => fault.dead = a,
        "actuator_delay" => fault.delay_s = a,
        "actuator_lag" => fault.lag_s = a,
        other => panic!("no fault of an actuator '{other}'"),
    }
}

fn sensor(fault: &mut SensorFault, hidden: &Hidden) {
    let [a, b, c] = [0, 1, 2].map(|index| hidden.value(index));
    match hidden.kind.as_str() {
        "sensor_scale" => fault.scale = a,
        "sensor_quadratic" => fault.quadratic = a,
        "sensor_drift" => fault.drift = a,
        "sensor_delay" => fault.delay_s = a,
        "sensor_lag" => fault.lag_s = a,
        "encoder_ripple" => fault.ripple = [a, b, c],
        "sensor_tone" => fault.tone = [a, b, c],
        "sensor_step" => fault.step = [a, b, c],
        other => panic!("no fault of a sensor '{other}'"),
    }
}
