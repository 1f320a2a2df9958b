//! What an effect is: parameters, sites, and a law of what is locally known.
//!
//! The law runs in simulation, in a filter's prediction and, over [`Dual`](crate::dual::Dual) numbers, in a Jacobian. Entries stand in a
//! catalogue of their own; here is what every entry has in common, and how the effects of a plant become numbers and parts.

mod law;
mod parameter;
mod resolve;

pub use law::{Action, BodyState, Both, HIDDEN_MAX, LawFn, Local, Pick, Surroundings, fired};
pub use parameter::{EffectParameter, Prior, Role, Scan, Spread};
pub use resolve::{EffectError, PARAMETERS_MAX, apply_structures, felt, sites, values};

use crate::description::{Plant, Site, SiteKind, Space};
use crate::lags::FilterKind;

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

/// What the amplitudes of an effect are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amplitude {
    Any,
    /// Shares of the mass or inertia of its body that a part takes: the largest is not negative, and the part alone, its body held,
    /// resonates below the frequency at which a recording shows both: by the root of what of the body is left.
    ShareOfBody,
}

/// What of a plant's environment an effect needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    Nothing,
    Atmosphere,
    MagneticField,
}

/// Laws that are confused with each other more than with any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    MassProperties,
    Friction,
    Damping,
    Stiffness,
    Clearance,
    Ripple,
    Flexibility,
    Actuation,
    Slosh,
    Disturbance,
    Aerodynamics,
    Consumption,
    SensorError,
    Timing,
}

impl Family {
    pub const fn name(self) -> &'static str {
        match self {
            Self::MassProperties => "mass properties",
            Self::Friction => "friction",
            Self::Damping => "damping",
            Self::Stiffness => "stiffness",
            Self::Clearance => "clearance",
            Self::Ripple => "ripple",
            Self::Flexibility => "flexibility",
            Self::Actuation => "actuation",
            Self::Slosh => "slosh",
            Self::Disturbance => "disturbance",
            Self::Aerodynamics => "aerodynamics",
            Self::Consumption => "consumption",
            Self::SensorError => "sensor error",
            Self::Timing => "timing",
        }
    }
}

/// A simpler law that an effect contains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Entry of the same catalogue.
    pub kind: &'static str,
    /// Values at which the effect is that law; parameters of the same name are the same in both.
    pub at: &'static [(&'static str, f64)],
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
    /// What the amplitudes are.
    pub amplitude: Amplitude,
    /// Continuous states of its own (hysteresis, integrated impulse); at most [`HIDDEN_MAX`], zero at the start.
    pub hidden_states: usize,
    pub law: Law,
    /// What of the environment it needs.
    pub needs: Needs,
    /// Its reading is a staircase, which has no derivative: linearisations are taken without it.
    pub staircase: bool,
    pub family: Family,
    /// Simpler laws that it contains as limits.
    pub limits: &'static [Limit],
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
    /// What entries leave out: a law of nothing, without hidden states, needs or limits.
    pub const PLAIN: Self = Self {
        kind: "",
        title: "",
        sites: &[],
        applies: |_, _| true,
        parameters: &[],
        amplitude: Amplitude::Any,
        hidden_states: 0,
        law: Law::Structure(|_, _, _| Ok(())),
        needs: Needs::Nothing,
        staircase: false,
        family: Family::Disturbance,
        limits: &[],
        what: "",
        signature: "",
        confounders: "",
        experiment: "",
    };

    /// How many of its parameters, from the first on, are its amplitudes.
    pub fn amplitudes(&self) -> usize {
        self.parameters.iter().take_while(|parameter| parameter.role == Role::Amplitude).count()
    }

    /// The parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<&'static EffectParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// The first parameter with this role.
    pub fn with_role(&self, role: Role) -> Option<&'static EffectParameter> {
        self.parameters.iter().find(|parameter| parameter.role == role)
    }

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
