//! Benches: deployed plants with sampling, control loop and the effects that a case can hide in
//! them.

mod menus;

use crate::equations::{Extra, Numbers};
use crate::hidden::Seat;
use crate::machines::machine;
use dynamics::description::{Controller, Plant, Quantity, Signal, SignalKind};

/// An effect that can be hidden in a bench.
pub struct Entry {
    pub kind: &'static str,
    pub site: &'static str,
    pub seat: Seat,
    /// Name of the amplitude, first value of the search for it, and the largest value.
    pub amplitude: (&'static str, f64, f64),
    /// The amplitude may be negative.
    pub signed: bool,
    /// Further values, drawn log-uniformly between two bounds.
    pub shape: &'static [(&'static str, f64, f64)],
    /// Kinds that contain this law as a limit, or are a limit of it; a case without this law
    /// removes them from the catalogue, too.
    pub kin: &'static [&'static str],
}

/// A plant on a bench.
pub struct Bench {
    pub plant: &'static str,
    text: &'static str,
    pub period_s: f64,
    pub samples: usize,
    /// Sensors that are recorded; empty: all.
    sensors: &'static [&'static str],
    pub closed: Option<Gains>,
    pub menu: &'static [Entry],
    /// Effects that are never hidden here, with which a hidden effect can be confused, besides the
    /// menu.
    pub rivals: &'static [Entry],
}

/// `u = kp (r − y) + kd (r' − y')`.
#[derive(Clone, Copy)]
pub struct Gains {
    pub kp: f64,
    pub kd: f64,
    pub position_sensor: &'static str,
    pub rate_sensor: Option<&'static str>,
}

macro_rules! plant_text {
    ($name:literal) => {
        include_str!(concat!("../../../deploy/plants/", $name, ".toml"))
    };
}

const OPEN: Bench =
    Bench { plant: "", text: "", period_s: 0.0, samples: 0, sensors: &[], closed: None, menu: &[], rivals: &[] };

const DRIVE: Bench = Bench {
    plant: "drive_rig",
    text: plant_text!("drive_rig"),
    period_s: 0.015,
    samples: 400,
    menu: menus::DRIVE,
    rivals: menus::DRIVE_RIVALS,
    ..OPEN
};

const OSCILLATOR: Bench = Bench {
    plant: "oscillator",
    text: plant_text!("oscillator"),
    period_s: 0.008,
    samples: 400,
    menu: menus::OSCILLATOR,
    rivals: menus::OSCILLATOR_RIVALS,
    ..OPEN
};

/// Every bench: six plants, two of them also in closed loop.
pub static BENCHES: &[Bench] = &[
    Bench {
        plant: "pendulum",
        text: plant_text!("pendulum"),
        period_s: 0.025,
        samples: 480,
        menu: menus::PENDULUM,
        ..OPEN
    },
    DRIVE,
    Bench { closed: Some(Gains { kp: 10.0, kd: 1.0, position_sensor: "angle", rate_sensor: Some("rate") }), ..DRIVE },
    Bench {
        plant: "double_pendulum",
        text: plant_text!("double_pendulum"),
        period_s: 0.012,
        samples: 400,
        menu: menus::DOUBLE_PENDULUM,
        ..OPEN
    },
    OSCILLATOR,
    Bench {
        closed: Some(Gains { kp: 500.0, kd: 0.0, position_sensor: "displacement", rate_sensor: None }),
        ..OSCILLATOR
    },
    Bench {
        plant: "tank_planar",
        text: plant_text!("tank_planar"),
        period_s: 3.0,
        samples: 320,
        menu: menus::TANK,
        rivals: menus::TANK_RIVALS,
        ..OPEN
    },
    Bench {
        plant: "hub_appendage",
        text: plant_text!("hub_appendage"),
        period_s: 0.012,
        samples: 360,
        sensors: &["acceleration_3", "acceleration_6", "acceleration_10"],
        menu: menus::PANEL,
        rivals: menus::PANEL_RIVALS,
        ..OPEN
    },
];

/// The plant that the tool receives: sampled as the bench samples, commands taken from the
/// recording.
///
/// # Panics
/// The deployed plant file does not parse.
#[must_use]
pub fn kept(bench: &Bench) -> Plant {
    let parsed = plant_file::parse(bench.plant, bench.text);
    let mut plant = parsed.unwrap_or_else(|_| panic!("the deployed plant '{}' parses", bench.plant)).plant;
    plant.sensors.retain(|sensor| bench.sensors.is_empty() || bench.sensors.contains(&sensor.name.as_str()));
    plant.actuators.iter_mut().for_each(|actuator| actuator.command.clear());
    let settings = &mut plant.simulation;
    settings.period_s = bench.period_s;
    settings.duration_s = bench.period_s * bench.samples as f64;
    settings.step_s = settings.step_s.min(bench.period_s / 2.0);
    plant
}

/// The same with its loop and reference.
#[must_use]
pub fn with_loop(plant: &Plant, gains: Gains, sines: &[[f64; 3]]) -> Plant {
    let known = Quantity::known;
    let sine = |[a, f, p]: &[f64; 3]| Signal {
        kind: SignalKind::Sine { amplitude: known(*a), frequency_hz: known(*f), phase_rad: known(*p) },
        begin_s: known(0.0),
        end_s: None,
    };
    let mut plant = plant.clone();
    plant.controllers = vec![Controller {
        name: "loop".to_owned(),
        actuator: plant.actuators[0].name.clone(),
        position_sensor: Some(gains.position_sensor.to_owned()),
        rate_sensor: gains.rate_sensor.map(str::to_owned),
        kp: known(gains.kp),
        ki: known(0.0),
        kd: known(gains.kd),
        reference: sines.iter().map(sine).collect(),
        feed_forward: known(0.0),
        reference_rate: gains.rate_sensor.is_some(),
    }];
    plant
}

/// Degrees of freedom without hidden structure.
#[must_use]
pub fn coordinates(bench: &Bench, numbers: &Numbers) -> usize {
    machine(bench.plant, numbers, Extra::default()).dof()
}

#[cfg(test)]
mod tests;
