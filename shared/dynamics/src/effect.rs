//! What an effect is: parameters, sites, and a law of what is locally known.
//!
//! The law runs in simulation, in a filter's prediction and, over [`Dual`](crate::dual::Dual) numbers, in a Jacobian. Entries stand in a
//! catalogue of their own; here is what every entry has in common, and how the effects of a plant become numbers and parts.

mod law;
mod resolve;

pub use law::{Action, BodyState, Both, HIDDEN_MAX, LawFn, Local, Pick, Surroundings, fired};
pub use resolve::{EffectError, PARAMETERS_MAX, apply_structures, felt, sites, values};

use crate::description::{Plant, Site, SiteKind, Space};
use crate::lags::FilterKind;

/// One number of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectParameter {
    pub name: &'static str,
    /// SI unit; `*` stands for the unit of the site (rad or m at a joint, m or rad at a tank, of the input at an actuator, of the
    /// channel at a sensor). J/rad is a torque, J/m a force.
    pub unit: &'static str,
    /// Plausible range; the sign is part of it: friction is never negative.
    pub low: f64,
    pub high: f64,
    pub default: f64,
    pub what: &'static str,
    /// Without any effect where everything lies in a plane: planar plants do not list it.
    pub out_of_plane: bool,
}

impl EffectParameter {
    /// Name, unit, plausible range, default, meaning.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        [low, high]: [f64; 2],
        default: f64,
        what: &'static str,
    ) -> Self {
        Self { name, unit, low, high, default, what, out_of_plane: false }
    }

    /// The same number as one that planar plants do not feel.
    #[must_use]
    pub const fn out_of_plane(self) -> Self {
        Self { out_of_plane: true, ..self }
    }
}

/// Where in the equations an effect acts.
#[derive(Clone, Copy)]
pub enum Law {
    /// Generalised force on a joint, slosh or modal coordinate: `action.force`. A tank with several axes: on each, told of all.
    Coordinate(Both),
    /// Wrench on a body, its axes, at its origin: `action.wrench`; and mass that comes or goes at its centre of mass: `action.added_mass_kg`.
    Body(Both),
    /// What acts, from what is commanded: `action.value`, and a wrench besides on the actuator's body.
    Actuator(Both),
    /// What is read, from what is there: `action.value`.
    Sensor(Both),
    /// An exact discrete filter on the command.
    ActuatorFilter(fn(&[f64]) -> FilterKind),
    /// An exact discrete filter on the reading.
    SensorFilter(fn(&[f64]) -> FilterKind),
    /// A part that the description lacks (a second slosh mass, a mode, a flexible joint), or a number that is another.
    Structure(fn(&mut Plant, &Site, &[f64]) -> Result<(), String>),
}

/// One entry of the catalogue.
pub struct Effect {
    /// Name in files and on the command line, snake case.
    pub kind: &'static str,
    pub title: &'static str,
    pub sites: &'static [SiteKind],
    /// Which of those sites: a wheel's imbalance sits at wheels, not at every actuator.
    pub applies: fn(&Plant, &Site) -> bool,
    pub parameters: &'static [EffectParameter],
    /// The first so many are the amplitude, a number or a vector.
    pub amplitudes: usize,
    /// Continuous states of its own (hysteresis, integrated impulse); at most [`HIDDEN_MAX`], zero at the start.
    pub hidden_states: usize,
    pub law: Law,
    /// The equation and its source.
    pub what: &'static str,
    /// Channel, time, frequency and state at which it shows.
    pub signature: &'static str,
    /// What it is mistaken for.
    pub confounders: &'static str,
    /// The experiment that tells them apart.
    pub experiment: &'static str,
}

impl Effect {
    /// The parameters that a plant in `space` feels.
    pub fn parameters_in(&self, space: Space) -> impl Iterator<Item = &'static EffectParameter> {
        self.parameters.iter().filter(move |parameter| space == Space::Spatial || !parameter.out_of_plane)
    }
}

impl PartialEq for Effect {
    /// The same entry of a catalogue.
    fn eq(&self, other: &Self) -> bool {
        self.kind == other.kind
    }
}

impl core::fmt::Debug for Effect {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.kind)
    }
}

/// The effects that a plant may carry, in the order in which they act.
#[derive(Clone, Copy, Default)]
pub struct Catalogue(&'static [&'static Effect]);

impl Catalogue {
    pub const fn new(entries: &'static [&'static Effect]) -> Self {
        Self(entries)
    }

    /// Every entry, in the order in which they act.
    pub fn entries(&self) -> &'static [&'static Effect] {
        self.0
    }

    /// The entry called `kind`.
    pub fn effect(&self, kind: &str) -> Option<&'static Effect> {
        self.0.iter().copied().find(|effect| effect.kind == kind)
    }

    /// Place of an effect among those that act; of an unknown one behind all.
    pub fn place(&self, kind: &str) -> usize {
        self.0.iter().position(|effect| effect.kind == kind).unwrap_or(self.0.len())
    }
}

impl PartialEq for Catalogue {
    /// The same names in the same order.
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().map(|effect| effect.kind).eq(other.0.iter().map(|effect| effect.kind))
    }
}

impl core::fmt::Debug for Catalogue {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "catalogue of {} effects", self.0.len())
    }
}
