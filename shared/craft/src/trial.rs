//! Plants, rows and messages for tests.

use crate::message::Received;
use crate::parameters::Parameters;
use dynamics::description::Plant;
use identification::joint::Message;
use nalgebra::{DMatrix, DVector};
use simulation::Simulator;
use telemetry::{CraftRow, Sample};

pub fn plant(name: &str) -> Plant {
    let text = match name {
        "oscillator" => include_str!("../../../deploy/plants/oscillator.toml"),
        "pendulum" => include_str!("../../../deploy/plants/pendulum.toml"),
        "study_case" => include_str!("../../../deploy/plants/study_case.toml"),
        other => panic!("no plant {other}"),
    };
    plant_file::parse(name, text).unwrap().plant
}

/// Of a simulation with the plant's own numbers.
pub fn rows(plant: &Plant, seed: u64, duration_s: f64) -> Vec<CraftRow> {
    let mut simulator = Simulator::new(plant, seed, &plant.name).unwrap();
    let periods = (duration_s / plant.simulation.period_s).round() as usize;
    let row = |_| {
        simulator.step();
        let found = simulator.row();
        let mut row = CraftRow::zeroed_at(0);
        (row.t_s, row.commands, row.readings) =
            (found.time_s, plant.actuators.len() as u32, plant.sensors.len() as u32);
        row.command[..found.commands.len()].copy_from_slice(&found.commands);
        for sample in &found.samples {
            row.valid |= 1 << sample.channel;
            (row.reading[sample.channel], row.stamp_s[sample.channel]) = (sample.value, sample.time_s);
        }
        row
    };
    (0..periods).map(row).collect()
}

/// A message of so many rows at the priors, which knows every parameter to a tenth of its prior and
/// found it at `offset` prior standard deviations, with `chi2` per row.
pub fn arc(parameters: &Parameters, arc: usize, [offset, chi2]: [f64; 2], rows: usize) -> Received {
    let n = parameters.len();
    Received {
        arc,
        theta: parameters.unknowns.iter().map(|unknown| unknown.prior).collect(),
        message: Message {
            information: 100.0 * DMatrix::identity(n, n),
            gradient: DVector::from_element(n, 100.0 * offset),
            chi2: chi2 * rows as f64,
            log_determinant: 0.0,
            rows,
        },
    }
}
