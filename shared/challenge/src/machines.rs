//! Closed forms of the deployed plants, each with the structure that a case can add.

mod double_pendulum;
mod drive;
mod oscillator;
mod panel;
mod pendulum;
mod tank;
#[cfg(test)]
mod tests;

use crate::equations::{Equations, Extra, Numbers};

/// The machine behind plant `name`.
///
/// # Panics
/// A plant that has no closed form here.
#[must_use]
pub fn machine(name: &str, numbers: &Numbers, extra: Extra) -> Box<dyn Equations> {
    match name {
        "pendulum" => Box::new(pendulum::Pendulum::new(numbers)),
        "drive_rig" => Box::new(drive::Drive::new(numbers, extra)),
        "double_pendulum" => Box::new(double_pendulum::DoublePendulum::new(numbers)),
        "oscillator" => Box::new(oscillator::Oscillator::new(numbers)),
        "tank_planar" => Box::new(tank::Tank::new(numbers, extra)),
        "hub_appendage" => Box::new(panel::Panel::new(numbers, extra)),
        other => panic!("no closed form of plant '{other}'"),
    }
}
