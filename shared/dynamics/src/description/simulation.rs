//! Where and how the plant runs: environment, initial states, segments, numerical settings.

use super::Quantity;

/// Circular orbit about a point mass; the body frame's attitude is relative to inertial space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityGradient {
    pub orbit_rate_rad_s: Quantity,
    /// Direction to the centre of the planet at t = 0, in the x–y plane of inertial space
    /// [rad from x].
    pub phase_rad: Quantity,
}

/// Free molecular or continuum drag: `½ ρ c_d A |v| v` against the velocity relative to the medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    pub density_kg_m3: Quantity,
    /// Velocity of the medium in inertial space [m/s].
    pub wind_m_s: [Quantity; 3],
}

/// Uniform field, turning with the orbit at twice its rate where an orbit is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticField {
    pub field_t: [Quantity; 3],
}

/// Known surroundings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    pub gravity_m_s2: [Quantity; 3],
    /// Acts on the first free body: force \[N\], torque [N m], in inertial axes.
    pub constant_force_n: [Quantity; 3],
    pub constant_torque_n_m: [Quantity; 3],
    pub gravity_gradient: Option<GravityGradient>,
    pub atmosphere: Option<Atmosphere>,
    pub magnetic_field: Option<MagneticField>,
}

/// One initial value. Coordinates are named `joint:NAME` (angle, displacement),
/// `body:NAME.x|y|z|rx|ry|rz` of a free body (position; rotation vector), `tank:NAME` (displacement
/// along its axis; `tank:NAME.2` for the second), `mode:NAME`; `wheel:ACTUATOR`.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialValue {
    pub coordinate: String,
    /// \[m\], \[rad\] or, for a mode, [√kg m].
    pub position: Quantity,
    /// Per second; of a free body in inertial axes for x, y, z, in body axes for rx, ry, rz.
    pub rate: Quantity,
}

/// State at the beginning of a record or segment; a coordinate without a value is zero, or follows
/// from the references of prescribed and controlled joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Initial {
    pub values: Vec<InitialValue>,
    /// The system's centre of mass is at rest in the origin, its angular momentum about it has this
    /// value [N m s] (free-floating systems); overrides the first free body's rates and position.
    pub momentum_com_n_m_s: Option<[Quantity; 3]>,
    /// Controlled joints start on their references.
    pub on_reference: bool,
}

/// A part of a record with its own initial state.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    pub name: String,
    pub begin_s: Quantity,
    pub end_s: Option<Quantity>,
    pub initial: Initial,
}

/// How the state moves over one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Classical Runge–Kutta, inputs held.
    #[default]
    RungeKutta4,
    /// Second order.
    Midpoint,
    /// Matrix exponential about the initial state; exact for plants linear in their state.
    ExactZeroOrderHold,
}

/// Numerical settings of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationSettings {
    pub duration_s: f64,
    /// Inputs are held over it, controllers run at it, sensors without a period of their own are
    /// read at it.
    pub period_s: f64,
    /// Longest integration step.
    pub step_s: f64,
    pub integrator: Integrator,
    /// Standard deviation of sample times about their nominal instants \[s\]; the stamps state the
    /// true times.
    pub jitter_s: f64,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self { duration_s: 60.0, period_s: 0.01, step_s: 0.01, integrator: Integrator::RungeKutta4, jitter_s: 0.0 }
    }
}
