//! Poles of a plant as its joints carry it, and of its sampled loops.

use dynamics::description::Plant;
use dynamics::dual::Dual;
use dynamics::system::{StateSpace, System, SystemMode, Workspace};
use estimation::matrix_exponential;
use nalgebra::{Complex, DMatrix};
use serde_json::{Value, json};
use simulation::{SimulationError, Simulator};

/// A discrete pole this near to one is a free integrator: pairs of them scatter by the square root
/// of rounding.
const AT_ZERO: f64 = 1e-6;

/// About which state the equations are linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The initial posture, at rest.
    Initial,
    /// All coordinates zero, at rest: the initial posture is no equilibrium.
    Neutral,
    /// The initial posture; neither it nor the neutral one is an equilibrium.
    NoEquilibrium,
}

impl About {
    /// The point of linearisation, as it is printed.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Initial => "about the initial posture at rest",
            Self::Neutral => "about the neutral posture at rest (the initial one is no equilibrium)",
            Self::NoEquilibrium => "about the initial posture at rest, which is no equilibrium",
        }
    }
}

/// One pole of the sampled loop, or a pair.
pub struct LoopPole {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
}

/// Poles without and with the controllers.
pub struct Poles {
    pub about: About,
    pub open: Vec<SystemMode>,
    pub zeros: usize,
    /// None without controllers.
    pub closed: Option<Vec<LoopPole>>,
}

impl Poles {
    /// Poles of the plant linearised at rest, without and with its controllers.
    ///
    /// # Errors
    /// [`SimulationError`] where the neutral posture cannot be evaluated.
    pub fn of(plant: &Plant, simulator: &mut Simulator) -> Result<Self, SimulationError> {
        let initial = simulator.truth().state.to_vec();
        let system = simulator.system();
        let posture = at_rest(system, &initial);
        let neutral = at_rest(system, &system.initial_state(&dynamics::description::Initial::default(), &|_| None)?);
        let u = vec![0.0; system.inputs().len()];
        let (about, x) = if is_equilibrium(system, &posture, &u) {
            (About::Initial, posture)
        } else if is_equilibrium(system, &neutral, &u) {
            (About::Neutral, neutral)
        } else {
            (About::NoEquilibrium, posture)
        };
        let mut ws = Workspace::<Dual>::new(system);
        let modes = system.modes(&mut ws, 0.0, &x, &u);
        let closes = plant.controllers.iter().any(|c| c.kp.value != 0.0 || c.ki.value != 0.0 || c.kd.value != 0.0);
        let closed = closes.then(|| closed_loop(plant, &system.linearise(&mut ws, 0.0, &x, &u)));
        Ok(Poles { about, open: modes.modes, zeros: modes.zeros, closed })
    }

    /// Frequencies \[Hz\], damping ratios and poles [1/s], each with the state that dominates its
    /// mode.
    pub fn as_json(&self) -> Value {
        let open = self.open.iter().map(|mode| {
            json!({
                "frequency_hz": mode.frequency_hz, "damping_ratio": mode.damping_ratio, "pole_1_s": mode.pole,
                "dominant_state": mode.label,
            })
        });
        let one = |pole: &LoopPole| json!({ "frequency_hz": pole.frequency_hz, "damping_ratio": pole.damping_ratio });
        json!({
            "about": self.about.text(), "open_loop": open.collect::<Vec<_>>(), "at_zero": self.zeros,
            "closed_loop": self.closed.as_ref().map(|poles| poles.iter().map(one).collect::<Vec<_>>()),
        })
    }
}

/// Rates zero; wheels keep turning.
fn at_rest(system: &System, x: &[f64]) -> Vec<f64> {
    let rate = |name: &str| name.ends_with(".rate");
    system.states().iter().zip(x).map(|(state, value)| if rate(&state.name) { 0.0 } else { *value }).collect()
}

/// Nothing accelerates more than rounding and friction of turning wheels make it.
fn is_equilibrium(system: &System, x: &[f64], u: &[f64]) -> bool {
    const STILL: f64 = 1e-6; // rad/s², m/s²: an hour to the next radian
    let mut ws = Workspace::<f64>::new(system);
    let mut x_dot = vec![0.0; x.len()];
    system.derivative(&mut ws, 0.0, x, u, &mut x_dot);
    let rates = system.states().iter().zip(&x_dot).filter(|(state, _)| state.name.ends_with(".rate"));
    rates.into_iter().all(|(_, rate)| rate.abs() < STILL)
}

/// Poles of plant and controllers, sampled with the control period; references, lags and delays are
/// left out.
///
/// `x⁺ = Φ x + Γ u`, `s⁺ = s − T C_p x`, `u = −(K_p + K_i T) C_p x + K_i s − K_d C_d x`, poles
/// `ln(z)/T`.
fn closed_loop(plant: &Plant, space: &StateSpace) -> Vec<LoopPole> {
    let (n, m, period_s) = (space.a.nrows(), space.b.ncols(), plant.simulation.period_s);
    let mut held = DMatrix::zeros(n + m, n + m);
    held.view_mut((0, 0), (n, n)).copy_from(&(&space.a * period_s));
    held.view_mut((0, n), (n, m)).copy_from(&(&space.b * period_s));
    let held = matrix_exponential(held);
    let loops = plant.controllers.len();
    let mut step = DMatrix::identity(n + loops, n + loops);
    step.view_mut((0, 0), (n, n)).copy_from(&held.view((0, 0), (n, n)));
    for (k, controller) in plant.controllers.iter().enumerate() {
        let reading = |name: &Option<String>| {
            let at = plant.sensors.iter().position(|sensor| Some(&sensor.name) == name.as_ref());
            at.map_or_else(|| DMatrix::zeros(1, n), |at| space.c.rows(at, 1).into_owned())
        };
        let (position, rate) = (reading(&controller.position_sensor), reading(&controller.rate_sensor));
        let Some(input) = input_of(plant, &controller.actuator) else { continue };
        let gamma = held.view((0, n + input), (n, 1)).into_owned();
        let (kp, ki, kd) = (controller.kp.value, controller.ki.value, controller.kd.value);
        let feedback = &position * (kp + ki * period_s) + &rate * kd;
        let mut driven = step.view_mut((0, 0), (n, n));
        driven -= &gamma * feedback;
        let mut integral = step.view_mut((0, n + k), (n, 1));
        integral += &gamma * ki;
        step.view_mut((n + k, 0), (1, n)).copy_from(&(position * -period_s));
    }
    // bounded: some matrices keep the QR iteration turning
    let Some(schur) = nalgebra::Schur::try_new(step, f64::EPSILON, 10_000) else { return Vec::new() };
    let mut poles: Vec<LoopPole> = schur
        .complex_eigenvalues()
        .iter()
        .filter(|z| z.im >= 0.0 && (**z - Complex::new(1.0, 0.0)).norm() > AT_ZERO)
        .map(|z| {
            let pole = z.ln() / period_s;
            LoopPole { frequency_hz: pole.norm() / core::f64::consts::TAU, damping_ratio: -pole.re / pole.norm() }
        })
        .collect();
    poles.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    poles
}

/// Index in `u` of an actuator that is commanded.
fn input_of(plant: &Plant, actuator: &str) -> Option<usize> {
    let prescribed = |kind: &dynamics::description::ActuatorKind| {
        use dynamics::description::ActuatorKind::{PrescribedBase, PrescribedJoint};
        matches!(kind, PrescribedJoint { .. } | PrescribedBase { .. })
    };
    let at = plant.actuators.iter().position(|candidate| candidate.name == actuator)?;
    // position, rate and acceleration are three inputs
    Some(plant.actuators[..at].iter().map(|before| if prescribed(&before.kind) { 3 } else { 1 }).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> Poles {
        let text = crate::plants::text_of(name, std::path::Path::new("")).unwrap();
        let plant = plant_file::parse(name, &text).unwrap().plant;
        Poles::of(&plant, &mut Simulator::new(&plant, 1, "").unwrap()).unwrap()
    }

    #[test]
    fn a_pendulum_swings_about_hanging_with_the_frequency_of_the_textbook() {
        let poles = of("pendulum");
        assert_eq!(poles.about, About::Neutral);
        let (m, l, i) = (1.35, 0.412, 0.0391 + 1.35 * 0.412 * 0.412);
        let natural_hz = f64::sqrt(m * 9.81 * l / i) / core::f64::consts::TAU;
        assert!((poles.open[0].frequency_hz / natural_hz - 1.0).abs() < 1e-12); // rounding
        assert!(poles.closed.is_none());
    }

    /// A rotor of 2 kg m² braked by 5 N m s/rad, sampled at 0.1 s: z = 1 − 5·0.1/2.
    #[test]
    fn a_sampled_brake_decays_as_its_difference_equation() {
        let text = "format = 1\nname = \"rotor\"\nspace = \"planar\"\n[[body]]\nname = \"rotor\"\nmass = \"1 kg\"\ninertia = \"2 kg*m^2\"\njoint = { kind = \"revolute\" }\n[[actuator]]\nname = \"brake\"\nkind = \"joint_torque\"\njoint = \"rotor\"\n[[sensor]]\nname = \"rate\"\nkind = \"joint_rate\"\njoint = \"rotor\"\n[[controller]]\nname = \"loop\"\nactuator = \"brake\"\nrate_sensor = \"rate\"\nkd = \"5 N*m*s/rad\"\n[simulation]\nduration = \"1 s\"\nperiod = \"0.1 s\"\n";
        let plant = plant_file::parse("rotor.toml", text).unwrap().plant;
        let closed = Poles::of(&plant, &mut Simulator::new(&plant, 1, "").unwrap()).unwrap().closed.unwrap();
        assert_eq!(closed.len(), 1);
        let time_s = 1.0 / (core::f64::consts::TAU * closed[0].frequency_hz);
        assert!((time_s / (-0.1 / 0.75_f64.ln()) - 1.0).abs() < 1e-12); // rounding
    }

    /// With the hub free the beam's first mode is at 1.56 Hz; the loop damps it, and has slow poles
    /// of its own.
    #[test]
    fn the_loop_of_the_appendage_has_modes_of_its_own() {
        let poles = of("hub_appendage_closed_loop");
        let closed = poles.closed.unwrap();
        assert!(poles.open.iter().any(|mode| (mode.frequency_hz - 1.56).abs() < 0.01));
        assert!(closed.iter().all(|pole| pole.damping_ratio > 0.01), "the loop is stable and damps");
        assert_eq!(closed.iter().filter(|pole| pole.frequency_hz < 0.5).count(), 2);
    }
}
