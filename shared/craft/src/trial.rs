//! Plants and rows for tests.

use dynamics::description::Plant;
use simulation::Simulator;
use telemetry::{CraftRow, Sample};

pub fn plant(name: &str) -> Plant {
    let text = match name {
        "oscillator" => include_str!("../../../deploy/plants/oscillator.toml"),
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
