//! A plant description as equations: states, inputs, outputs, derivatives and readings.
//!
//! ```text
//! x' = f(t, x, u),   y = h(t, x, u)
//! x = [positions of joints | modal coordinates | velocities of joints, modal rates, wheel speeds | hidden states of effects]
//! ```
//!
//! [`System::new`] turns bodies, tanks, appendages, actuators, sensors and effects into flat lists
//! once; a call walks them. The functions are generic over [`Pick`](crate::effect::Pick): `f64`
//! simulates, [`Dual`](crate::dual::Dual) numbers differentiate the same code. Nothing is allocated
//! after [`Workspace::new`].
//!
//! Noise, range, quantisation, lags, delays and sampling belong to the simulator that drives a
//! system.
//!
//! Conventions: a free body has position (inertial axes) and angle or quaternion `[w, x, y, z]`,
//! and the rate `[ω, v]` of its origin in body axes. Prescribed joints are functions of time: their
//! position, rate and acceleration are inputs, not states. A prescribed base accelerates the frame
//! in which everything else is written: states are relative to it, readings are not.

mod actuation;
mod apart;
mod binding;
mod compile;
mod effect_terms;
mod environment;
mod error;
mod evaluate;
mod feed_forward;
mod geometry;
mod initial;
mod layout;
mod linear;
mod mean_reading;
mod mechanism;
mod modes;
mod names;
mod passive;
mod period;
mod residual;
mod runge_kutta;
mod sensing;
mod sensors;
mod sites;
mod spectral_radius;
mod state_names;
mod tangent;
mod totals;
mod workspace;

pub use error::SystemError;
pub use feed_forward::JointReference;
pub use layout::{InputName, InputRole, OutputName, StateName};
pub use linear::StateSpace;
pub use modes::{Modes, SystemMode};
pub use period::Period;
pub use residual::Differs;
pub use runge_kutta::RungeKutta;
pub use spectral_radius::spectral_radius;
pub use totals::Totals;
pub use workspace::Workspace;

use crate::description::{Plant, Site, Space};
use crate::lags::FilterKind;
use crate::multibody::Model;

/// Where a discrete filter sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterPlace {
    /// On the command: index in `u`.
    Input(usize),
    /// On the reading: index in `y`.
    Output(usize),
}

/// A filter that an effect requires of the simulator; lags and delays of the sensors themselves are
/// not repeated here.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    pub site: Site,
    pub place: FilterPlace,
    pub kind: FilterKind,
}

/// The equations of a plant.
#[derive(Clone)]
pub struct System {
    space: Space,
    model: Model,
    layout: layout::Layout,
    springs: Vec<passive::Passive>,
    actuators: Vec<actuation::Actuation>,
    environment: environment::Surrounding,
    effects: effect_terms::EffectTerms,
    sensors: Vec<sensors::SensorTerm>,
    joints: Vec<sites::JointSite>,
    coordinates: Vec<sites::NamedCoordinate>,
    filters: Vec<Filter>,
    /// Per link, about its centre of mass, link axes.
    inertia_com: Vec<[[f64; 3]; 3]>,
    /// Computations that a reading of all sensors requires.
    reach: sensors::Reach,
    /// Some actuator, environment or effect pushes bodies.
    pushed: bool,
    /// 1 / inertia of every coordinate where none feels another.
    lightness_apart: Option<Vec<f64>>,
    /// Per velocity coordinate: all but those of free joints.
    all_but_base: Vec<bool>,
    /// Links with a quaternion.
    spatial_bases: Vec<usize>,
}

impl System {
    /// Compiles `plant` with the effects of its catalogue. Those that change its structure are
    /// applied to a copy first.
    ///
    /// # Errors
    /// A name that does not exist, an effect at a site it cannot sit at, or bodies without mass
    /// where one must move.
    pub fn new(plant: &Plant) -> Result<Self, SystemError> {
        compile::compile(plant)
    }

    /// Whether the plant moves in a plane or in space.
    pub fn space(&self) -> Space {
        self.space
    }

    /// Meaning of every component of `x`, in order.
    pub fn states(&self) -> &[StateName] {
        &self.layout.states
    }

    /// Meaning of every component of `u`, in order.
    pub fn inputs(&self) -> &[InputName] {
        &self.layout.inputs
    }

    /// Meaning of every component of `y`, in order.
    pub fn outputs(&self) -> &[OutputName] {
        &self.layout.outputs
    }

    /// Discrete filters of effects, in file order.
    pub fn filters(&self) -> &[Filter] {
        &self.filters
    }

    /// Where in the state the effects keep their own: consumption, bent bristles, turns of rotors.
    pub fn hidden_states(&self) -> core::ops::Range<usize> {
        self.layout.hidden_at()..self.layout.states_len()
    }

    /// Some effect acts by a law on coordinates, bodies or actuators; those at sensors do not move
    /// anything.
    pub fn has_laws(&self) -> bool {
        let terms = &self.effects;
        !(terms.coordinates.is_empty() && terms.bodies.is_empty() && terms.actuators.is_empty())
    }

    /// Index of a joint with one degree of freedom, for [`JointReference`].
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// The tree of bodies, tanks, modes and wheels: bodies first, in their order, then the links of
    /// the tanks.
    pub fn model(&self) -> &Model {
        &self.model
    }
}

#[cfg(test)]
mod tests;
