//! Arguments and results of a law.

use crate::dual::Dual;
use crate::real::Real;

/// Most states an effect can have of its own.
pub const HIDDEN_MAX: usize = 4;

/// Motion of the body a site belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState<T> {
    /// Body axes to inertial axes, row-major.
    pub rotation: [[T; 3]; 3],
    /// Origin of the body's axes, inertial \[m\].
    pub position_m: [T; 3],
    /// Rate relative to inertial space, body axes [rad/s].
    pub omega_rad_s: [T; 3],
    /// Velocity of the origin, body axes [m/s].
    pub velocity_m_s: [T; 3],
    /// Angular acceleration, body axes [rad/s²]; zero where forces are still to be found (all but
    /// sensors).
    pub alpha_rad_s2: [T; 3],
    /// Specific force of the origin, body axes [m/s²]; zero likewise.
    pub specific_force_m_s2: [T; 3],
}

/// Constants that laws may need and that no site owns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surroundings {
    pub gravity_m_s2: [f64; 3],
    pub orbit_rate_rad_s: f64,
    pub orbit_phase_rad: f64,
    pub density_kg_m3: f64,
    pub wind_m_s: [f64; 3],
    pub field_t: [f64; 3],
    /// Nominal mass of the site's body \[kg\], its centre of mass \[m\], its inertia about it
    /// (row-major, body axes) [kg m²].
    pub body_mass_kg: f64,
    pub body_com_m: [f64; 3],
    pub body_inertia_com_kg_m2: [[f64; 3]; 3],
    /// Where the site is on its body (thruster, accelerometer) \[m\], and its axis (thrust
    /// direction, wheel spin, sensitive axis), unit.
    pub site_position_m: [f64; 3],
    pub site_axis: [f64; 3],
    /// Of a voltage motor: back-emf per rate of its joint [V s/rad].
    pub back_emf_v_s_rad: f64,
    /// Longest step of integration \[s\]: hidden states must be no faster than it can follow.
    pub step_s: f64,
    /// Of an actuator: it pushes one way only.
    pub one_sided: bool,
    /// Of an actuator: magnitude below which the acting value is noise, not firing.
    pub quiet: f64,
}

/// Arguments of a law: the state at a site at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Local<'a, T> {
    pub t_s: f64,
    /// Joint angle or displacement (also at an actuator in that joint), slosh displacement or
    /// angle, modal coordinate; zero elsewhere.
    pub coordinate: T,
    /// Its rate; at a wheel: speed of the rotor relative to the body about the wheel's axis.
    pub rate: T,
    /// Of a tank: the displacement of its mass along all its axes, body axes \[m\], and its rate;
    /// `site_axis` is the axis of this coordinate. Of a pendulum: its angles about its two axes
    /// \[rad\].
    pub displacement: [T; 3],
    pub displacement_rate: [T; 3],
    /// The command of an actuator; at a joint: the sum of its actuators' efforts; at a body: the
    /// sum of what its thrusters and body forces fire, noise apart \[N\].
    pub command: T,
    /// The reading of the sensor without this effect.
    pub reading: T,
    /// At rest for a law on a joint or a tank: their motion is all that acts there.
    pub body: &'a BodyState<T>,
    /// The effect's own states.
    pub hidden: &'a [T],
    pub surroundings: &'a Surroundings,
}

/// Result of a law. All is zero before the first law, but `value`, which is the command or the
/// reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Action<T> {
    pub force: T,
    /// Torque [N m], force \[N\]; body axes, at the origin.
    pub wrench: [T; 6],
    /// Of a wheel: torque on the body along the axis; the rotor takes its reaction.
    pub value: T,
    pub added_mass_kg: T,
    /// Of this effect's own states, from the first.
    pub hidden_rate: [T; HIDDEN_MAX],
}

/// A law over one scalar: state of the site and the effect's parameters, in catalogue order.
pub type LawFn<T> = fn(&Local<'_, T>, &[f64], &mut Action<T>);

/// One law over real and over dual numbers.
#[derive(Clone, Copy)]
pub struct Both {
    pub real: LawFn<f64>,
    pub dual: LawFn<Dual>,
}

/// A scalar that knows which of [`Both`] is its own.
pub trait Pick: Real {
    fn pick(both: &Both) -> LawFn<Self>;
}

impl Pick for f64 {
    fn pick(both: &Both) -> LawFn<Self> {
        both.real
    }
}

impl Pick for Dual {
    fn pick(both: &Both) -> LawFn<Self> {
        both.dual
    }
}

/// The part of an acting value that counts as firing. Thrusters push one way, so that their noise
/// cancels in an integral. A force that pushes both ways counts if its magnitude exceeds `quiet`, a
/// bound of its noise.
pub fn fired<T: Real>(value: T, one_sided: bool, quiet: f64) -> T {
    if one_sided {
        value
    } else if value.value().abs() > quiet {
        value.abs()
    } else {
        T::zero()
    }
}

/// `both!(law)`: one generic function as [`Both`].
#[macro_export]
macro_rules! both {
    ($law:ident) => {
        $crate::effect::Both { real: $law::<f64>, dual: $law::<$crate::dual::Dual> }
    };
}
