//! Rows of a craft: from samples to bytes that only grow, and to a recording.
//!
//! A row is `t, valid, commands, readings, stamps`, eight bytes each, little endian.

use channels::{Channel, Recording};
use dynamics::description::Plant;
use telemetry::CraftRow;

/// How many numbers a row of a craft has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowShape {
    commands: usize,
    readings: usize,
}

impl RowShape {
    #[must_use]
    pub fn of(plant: &Plant) -> Self {
        Self { commands: plant.actuators.len(), readings: plant.sensors.len() }
    }

    /// Of one row.
    #[must_use]
    pub fn bytes(self) -> usize {
        8 * (2 + self.commands + 2 * self.readings)
    }

    /// Appends a row; one of another craft is left out.
    pub fn append(self, row: &CraftRow, bytes: &mut Vec<u8>) {
        if (row.commands as usize, row.readings as usize) != (self.commands, self.readings) {
            return;
        }
        bytes.extend_from_slice(&row.t_s.to_le_bytes());
        bytes.extend_from_slice(&row.valid.to_le_bytes());
        let numbers = [&row.command[..self.commands], &row.reading[..self.readings], &row.stamp_s[..self.readings]];
        numbers.into_iter().flatten().for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
    }

    /// The rows of an arc as a recording of `plant`.
    #[must_use]
    pub fn recording(self, name: &str, plant: &Plant, bytes: &[u8]) -> Recording {
        let mut commands: Vec<Channel> = plant
            .actuators
            .iter()
            .map(|actuator| Channel::new(&actuator.name, plant.actuator_unit(actuator), Vec::new(), Vec::new()))
            .collect();
        let mut readings: Vec<Channel> = plant
            .sensors
            .iter()
            .map(|sensor| Channel::new(&sensor.name, plant.sensor_unit(sensor), Vec::new(), Vec::new()))
            .collect();
        for row in bytes.chunks_exact(self.bytes()) {
            let mut words = row.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word));
            let mut next = || words.next().unwrap_or(0);
            let (t_s, valid) = (f64::from_bits(next()), next());
            for channel in &mut commands {
                push(channel, t_s, f64::from_bits(next()));
            }
            let values: Vec<f64> = (0..self.readings).map(|_| f64::from_bits(next())).collect();
            for (k, channel) in readings.iter_mut().enumerate() {
                let stamp_s = f64::from_bits(next());
                if valid & 1 << k != 0 {
                    push(channel, stamp_s, values[k]);
                }
            }
        }
        let recorded =
            commands.into_iter().zip(&plant.actuators).filter(|(_, a)| a.recorded).map(|(channel, _)| channel);
        Recording { name: name.into(), channels: recorded.chain(readings).collect() }
    }
}

fn push(channel: &mut Channel, t_s: f64, value: f64) {
    channel.time_s.push(t_s);
    channel.value.push(value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial;
    use telemetry::Sample;

    #[test]
    fn rows_come_back_as_the_recording_that_a_simulation_of_the_plant_writes() {
        let mut plant = trial::plant("study_case");
        plant.simulation.period_s = 0.05; // the attitude comes in every other row
        let recording = simulation::record(&plant, 3, 1.0, &mut |_| {}).unwrap();
        let shape = RowShape::of(&plant);
        let mut bytes = Vec::new();
        trial::rows(&plant, 3, 1.0).iter().for_each(|row| shape.append(row, &mut bytes));
        assert_eq!(bytes.len(), 20 * shape.bytes());
        assert_eq!(shape.recording(&plant.name, &plant, &bytes), recording);
    }

    #[test]
    fn a_row_of_another_craft_is_left_out() {
        let shape = RowShape::of(&trial::plant("oscillator"));
        let mut bytes = Vec::new();
        shape.append(&CraftRow { commands: 9, readings: 9, ..CraftRow::zeroed_at(0) }, &mut bytes);
        assert!(bytes.is_empty());
    }
}
