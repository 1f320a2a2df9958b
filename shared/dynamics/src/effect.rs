//! An effect: parameters, sites, and a law of the local state.
//!
//! The law runs in simulation, in the prediction of a filter and, over [`Dual`](crate::dual::Dual)
//! numbers, in a Jacobian. The crate `catalogue` has the entries. This module has what they share,
//! and how the effects of a plant become parameters and parts.
//!
//! A search knows an effect by its fields alone: [`Role`], [`Scan`] and [`Prior`] of every
//! parameter, [`Family`], [`Limit`]s, [`Needs`].

mod law;
mod parameter;
mod resolve;

pub use law::{Action, BodyState, Both, HIDDEN_MAX, LawFn, Local, Pick, Surroundings, fired};
pub use parameter::{AMPLITUDE_PRIOR_RATIO, DIRECTION_PRIOR_RAD, EffectParameter, Prior, Role, Scan, Spread};
pub use resolve::{EffectError, PARAMETERS_MAX, apply_structures, felt, sites, values};

use crate::description::{Plant, Site, SiteKind, Space};
use crate::lags::FilterKind;

/// Where in the equations an effect acts.
#[derive(Clone, Copy)]
pub enum Law {
    /// Generalised force on a joint, slosh or modal coordinate: `action.force`. A tank with several
    /// axes: one call per axis, each with the displacement along all axes.
    Coordinate(Both),
    /// Wrench on a body, in body axes at its origin: `action.wrench`; mass added at its centre of
    /// mass: `action.added_mass_kg`.
    Body(Both),
    /// Acting value from the commanded one: `action.value`; and a further wrench on the body of the
    /// actuator: `action.wrench`.
    Actuator(Both),
    /// Reading from the true value: `action.value`.
    Sensor(Both),
    /// Exact discrete filter on the command, from the parameters.
    ActuatorFilter(fn(&[f64]) -> FilterKind),
    /// Exact discrete filter on the reading, from the parameters.
    SensorFilter(fn(&[f64]) -> FilterKind),
    /// Change of the description: an added part (a second slosh mass, a mode, a flexible joint) or
    /// another value of a parameter.
    Structure(fn(&mut Plant, &Site, &[f64]) -> Result<(), String>),
}

/// Which amplitudes of an effect are physical.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amplitude {
    /// Every value within the range of the parameter.
    Any,
    /// Shares μ of the mass or inertia of a body that a part takes. The largest is not negative.
    /// With the body held the part resonates at `f √(1 − μ)`, f the frequency at which a recording
    /// shows body and part together.
    ShareOfBody,
}

/// Part of a plant's environment that an effect requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No part.
    Nothing,
    /// Density and wind.
    Atmosphere,
    /// A magnetic field in inertial axes.
    MagneticField,
}

/// Group of laws that are confused with each other more than with any other law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Mass, centre of mass, inertia, geometry other than stated.
    MassProperties,
    /// Force opposed to the rate, of bounded size.
    Friction,
    /// Force opposed to the rate, growing with it.
    Damping,
    /// Force that depends on the displacement.
    Stiffness,
    /// Dead zones, backlash, end stops.
    Clearance,
    /// Periodic in a coordinate.
    Ripple,
    /// Added modes and compliance.
    Flexibility,
    /// Maps and dynamics from command to action.
    Actuation,
    /// Laws of propellant in tanks.
    Slosh,
    /// Forces and torques independent of the motion.
    Disturbance,
    /// Forces and torques of a medium.
    Aerodynamics,
    /// Mass that leaves or arrives.
    Consumption,
    /// Errors of the value of a reading.
    SensorError,
    /// Errors of the time of a command or reading.
    Timing,
}

impl Family {
    /// Name in reports, in lower case.
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
    /// Noun phrase for reports.
    pub title: &'static str,
    /// Kinds of site at which it can act.
    pub sites: &'static [SiteKind],
    /// Whether it can act at a site of those kinds: the imbalance of a wheel acts at wheels, not at
    /// every actuator.
    pub applies: fn(&Plant, &Site) -> bool,
    /// Amplitudes first; a law receives their values in this order.
    pub parameters: &'static [EffectParameter],
    /// Which amplitudes are physical.
    pub amplitude: Amplitude,
    /// Number of its own continuous states (hysteresis, integrated impulse); at most
    /// [`HIDDEN_MAX`], zero at the start.
    pub hidden_states: usize,
    /// Where in the equations it acts, and its function.
    pub law: Law,
    /// Part of the environment that it requires.
    pub needs: Needs,
    /// Its reading is a staircase without a derivative; linearisations omit it.
    pub staircase: bool,
    /// Group of laws with which it is confused most.
    pub family: Family,
    /// Simpler laws that it contains as limits.
    pub limits: &'static [Limit],
    /// The equation and its source.
    pub what: &'static str,
    /// Channel, time, frequency and state at which it shows.
    pub signature: &'static str,
    /// Effects and parameters with a similar signature.
    pub confounders: &'static str,
    /// The experiment that separates it from its confounders.
    pub experiment: &'static str,
}

impl Effect {
    /// Default of every field that an entry does not state: any site of its kinds, no action,
    /// hidden states, needs or limits.
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

    /// Number of leading parameters with [`Role::Amplitude`].
    pub fn amplitudes(&self) -> usize {
        self.parameters.iter().take_while(|parameter| parameter.role == Role::Amplitude).count()
    }

    /// The parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<&'static EffectParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// The law has slopes between two readings: it has no sign that turns, no instant at which it
    /// begins or ends, no contact that opens or closes, and no ripple that is passed in between.
    pub fn is_smooth(&self) -> bool {
        let turns = |role: Role| matches!(role, Role::Smoothing | Role::Onset | Role::Duration | Role::Order);
        self.family != Family::Clearance && !self.parameters.iter().any(|parameter| turns(parameter.role))
    }

    /// The first parameter with this role.
    pub fn with_role(&self, role: Role) -> Option<&'static EffectParameter> {
        self.parameters.iter().find(|parameter| parameter.role == role)
    }

    /// The parameters with an effect on a plant in `space`.
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
    /// A catalogue of `entries`, which act in this order.
    pub const fn new(entries: &'static [&'static Effect]) -> Self {
        Self(entries)
    }

    /// Every entry, in the order of action.
    pub fn entries(&self) -> &'static [&'static Effect] {
        self.0
    }

    /// The entry called `kind`.
    pub fn effect(&self, kind: &str) -> Option<&'static Effect> {
        self.0.iter().copied().find(|effect| effect.kind == kind)
    }

    /// Index of an effect in the order of action; for an unknown one the number of entries.
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
