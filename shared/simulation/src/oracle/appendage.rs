//! A flexible appendage on a rotating hub, with accelerometers along it: the truth of BP3.
//!
//! Assumed modes of the clamped beam on the hub's angle, `q = (θ, d_1 … d_n)`:
//!
//! ```text
//! M q̈ + D q̇ + K q = (u, 0 … 0),   M = [[J, cᵀ], [c, 1]],  K = diag(0, ω_k²),  D = diag(0, 2 ζ_k ω_k)
//! y_i = (r_0 + x_i) θ̈ + Σ φ_k(x_i) d̈_k
//! ```
//!
//! ω_k, ζ_k belong to the hub held still (locked). With the hub free the system's own modes are
//! higher: 1.561 Hz instead of 1.001 Hz. [`AppendageParameters::modes`] gives those, which
//! torque-excited acceleration shows. Planar, small angles, exact for a torque held over the
//! sampling interval.

use crate::oracle::sensor::Channel;
use dynamics::beam::{Cantilever, CantileverMode, integrate};
use dynamics::noise::Stream;
use dynamics::zero_order_hold::discretise;
use nalgebra::{Complex, ComplexField, DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Accelerometers on the appendage, equally spaced, the last at the tip.
pub const SENSORS: usize = 10;

/// White noise of one accelerometer sample: 3.16 µg/√Hz over 100 Hz [m/s²].
pub const ACCELEROMETER_SIGMA_M_S2: f64 = 3.10e-4;

/// Hub and beam.
#[derive(Clone, Debug, PartialEq)]
pub struct AppendageParameters {
    pub hub_inertia_kg_m2: f64,
    /// Hub's axis to the root of the beam.
    pub root_radius_m: f64,
    pub beam: Cantilever,
    /// Damping ratio of each clamped mode that is simulated, lowest first.
    pub damping_ratio: Vec<f64>,
}

/// A mode of hub and appendage together.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemMode {
    /// |λ| / 2π.
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Acceleration at the sensors, `[real, imaginary]`, the tip's being 1.
    pub shape: [[f64; 2]; SENSORS],
}

/// Equations of motion as matrices.
#[derive(Clone, Debug)]
struct Equations {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    /// Rows: tangential acceleration of each sensor per unit of q̈.
    sensor: DMatrix<f64>,
}

impl AppendageParameters {
    /// The benchmark's hub and beam with two modes.
    pub fn design() -> Self {
        Self {
            hub_inertia_kg_m2: 66.67,
            root_radius_m: 0.5,
            beam: Cantilever { length_m: 5.0, mass_per_length_kg_m: 2.0, bending_stiffness_n_m2: 4000.0 },
            damping_ratio: vec![0.005, 0.008],
        }
    }

    /// The same beam with three more modes of 0.5 % damping: a truth with more in it than two
    /// modes.
    pub fn design_five_modes() -> Self {
        Self { damping_ratio: vec![0.005, 0.008, 0.005, 0.005, 0.005], ..Self::design() }
    }

    /// Inertia of hub and undeformed beam about the hub's axis [kg m²].
    pub fn total_inertia_kg_m2(&self) -> f64 {
        let radius = |x: f64| self.root_radius_m + x;
        let beam = integrate(self.beam.length_m, |x| self.beam.mass_per_length_kg_m * radius(x) * radius(x));
        self.hub_inertia_kg_m2 + beam
    }

    /// Coupling `c_k = ∫ ρA (r_0 + x) φ_k dx` of each mode with the hub's angle [√kg m].
    pub fn coupling(&self) -> Vec<f64> {
        let per_length = self.beam.mass_per_length_kg_m;
        let couple = |mode: CantileverMode| {
            integrate(self.beam.length_m, |x| per_length * (self.root_radius_m + x) * mode.shape(x))
        };
        self.clamped_modes().map(couple).collect()
    }

    /// Modes with the hub held still: (frequency [Hz], damping ratio).
    pub fn hub_locked_modes(&self) -> Vec<(f64, f64)> {
        let hertz = |mode: CantileverMode| mode.angular_frequency_rad_s / core::f64::consts::TAU;
        self.clamped_modes().map(hertz).zip(self.damping_ratio.iter().copied()).collect()
    }

    /// Modes with the hub free, lowest first: eigenvalues of the flexible part, found numerically.
    pub fn modes(&self) -> Vec<SystemMode> {
        let equations = self.equations();
        let n = self.damping_ratio.len();
        let mut poles: Vec<Complex<f64>> =
            flexible_state_matrix(&equations).complex_eigenvalues().iter().copied().filter(|p| p.im > 0.0).collect();
        assert!(poles.len() == n, "an appendage mode is overdamped");
        poles.sort_by(|a, b| a.modulus().total_cmp(&b.modulus()));
        poles.into_iter().map(|pole| system_mode(&equations, pole)).collect()
    }

    fn clamped_modes(&self) -> impl Iterator<Item = CantileverMode> {
        let beam = self.beam;
        (1..=self.damping_ratio.len()).map(move |number| beam.mode(number))
    }

    fn equations(&self) -> Equations {
        let n = self.damping_ratio.len();
        assert!(n > 0);
        let modes: Vec<CantileverMode> = self.clamped_modes().collect();
        let mut mass = DMatrix::identity(n + 1, n + 1);
        let mut damping = DMatrix::zeros(n + 1, n + 1);
        let mut stiffness = DMatrix::zeros(n + 1, n + 1);
        mass[(0, 0)] = self.total_inertia_kg_m2();
        for (k, coupling) in self.coupling().into_iter().enumerate() {
            let omega = modes[k].angular_frequency_rad_s;
            (mass[(0, k + 1)], mass[(k + 1, 0)]) = (coupling, coupling);
            damping[(k + 1, k + 1)] = 2.0 * self.damping_ratio[k] * omega;
            stiffness[(k + 1, k + 1)] = omega * omega;
        }
        let sensor = DMatrix::from_fn(SENSORS, n + 1, |i, column| {
            let x = sensor_position_m(self.beam.length_m, i);
            if column == 0 { self.root_radius_m + x } else { modes[column - 1].shape(x) }
        });
        Equations { mass, damping, stiffness, sensor }
    }
}

/// Distance of accelerometer `index` (from 0) from the root.
fn sensor_position_m(length_m: f64, index: usize) -> f64 {
    length_m * (index + 1) as f64 / SENSORS as f64
}

/// State matrix of the deflections alone. The hub's row has neither stiffness nor damping, so
/// `θ̈ = (u − cᵀ d̈)/J` leaves `(1 − c cᵀ/J) d̈ + D ḋ + K d = −c u/J`: no zero eigenvalues to be
/// told apart from rounding.
fn flexible_state_matrix(equations: &Equations) -> DMatrix<f64> {
    let n = equations.mass.nrows() - 1;
    let flexible = |m: &DMatrix<f64>| m.view((1, 1), (n, n)).into_owned();
    let coupling = equations.mass.view((1, 0), (n, 1)).into_owned();
    let mass = flexible(&equations.mass) - &coupling * coupling.transpose() / equations.mass[(0, 0)];
    let factor = mass.cholesky().expect("a Schur complement of M > 0 is positive definite");
    let mut state = DMatrix::zeros(2 * n, 2 * n);
    state.view_mut((0, n), (n, n)).fill_with_identity();
    state.view_mut((n, 0), (n, n)).copy_from(&-factor.solve(&flexible(&equations.stiffness)));
    state.view_mut((n, n), (n, n)).copy_from(&-factor.solve(&flexible(&equations.damping)));
    state
}

/// Shape at the sensors by inverse iteration on `λ² M + λ D + K` next to the pole.
fn system_mode(equations: &Equations, pole: Complex<f64>) -> SystemMode {
    let complex = |m: &DMatrix<f64>| m.map(|x| Complex::new(x, 0.0));
    let beside = pole * Complex::new(1.0 + 1e-9, 0.0);
    let impedance = complex(&equations.mass) * (beside * beside)
        + complex(&equations.damping) * beside
        + complex(&equations.stiffness);
    let factor = impedance.lu();
    let mut shape = DVector::from_element(equations.mass.nrows(), Complex::new(1.0, 0.0));
    for _ in 0..3 {
        shape = factor.solve(&shape).expect("beside a pole the impedance is not singular");
        let size = shape.norm();
        shape /= Complex::new(size, 0.0);
    }
    let at_sensors = complex(&equations.sensor) * shape;
    let tip = at_sensors[SENSORS - 1];
    SystemMode {
        frequency_hz: pole.modulus() / core::f64::consts::TAU,
        damping_ratio: -pole.re / pole.modulus(),
        shape: core::array::from_fn(|i| {
            let relative = at_sensors[i] / tip;
            [relative.re, relative.im]
        }),
    }
}

/// Tangential acceleration at the sensors at `t_k`, just after the torque has switched to the value
/// held from `t_k` on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AppendageMeasurement {
    pub acceleration_m_s2: [f64; SENSORS],
}

/// Everything that changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AppendageState {
    /// θ [rad], modal deflections [√kg m]; then their rates.
    pub x: Vec<f64>,
    pub sample: u64,
}

/// The simulator.
#[derive(Clone, Debug)]
pub struct AppendageTruth {
    transition: DMatrix<f64>,
    input: DVector<f64>,
    output: DMatrix<f64>,
    feedthrough: DVector<f64>,
    accelerometers: [Channel; SENSORS],
    state: DVector<f64>,
    next: DVector<f64>,
    sample: u64,
}

impl AppendageTruth {
    /// Hub and beam at rest. Noise streams are `{stream_prefix}.accelerometer1` … `10`.
    pub fn new(
        parameters: &AppendageParameters,
        rate_hz: f64,
        accelerometer_sigma_m_s2: f64,
        seed: u64,
        stream_prefix: &str,
    ) -> Self {
        assert!(rate_hz > 0.0 && rate_hz.is_finite());
        let (a, b, output, feedthrough) = state_space(&parameters.equations());
        let (transition, input) = discretise(&a, &b, 1.0 / rate_hz);
        let channel = |i: usize| {
            let stream = Stream::new(seed, &format!("{stream_prefix}.accelerometer{}", i + 1));
            Channel::white(stream, accelerometer_sigma_m_s2)
        };
        Self {
            state: DVector::zeros(a.nrows()),
            next: DVector::zeros(a.nrows()),
            input: input.column(0).into_owned(),
            transition,
            output,
            feedthrough,
            accelerometers: core::array::from_fn(channel),
            sample: 0,
        }
    }

    /// Applies `torque_nm` from now on, measures, and moves on by one interval with the torque
    /// held.
    pub fn step(&mut self, torque_nm: f64) -> AppendageMeasurement {
        let measure = |i: usize| {
            let truth = self.output.row(i).tr_dot(&self.state) + self.feedthrough[i] * torque_nm;
            self.accelerometers[i].measure(truth, self.sample)
        };
        let measurement = AppendageMeasurement { acceleration_m_s2: core::array::from_fn(measure) };
        self.next.gemv(1.0, &self.transition, &self.state, 0.0);
        self.next.axpy(torque_nm, &self.input, 1.0);
        core::mem::swap(&mut self.state, &mut self.next);
        self.sample += 1;
        measurement
    }

    /// The changing part, for a checkpoint.
    pub fn state(&self) -> AppendageState {
        AppendageState { x: self.state.as_slice().to_vec(), sample: self.sample }
    }

    /// Continues from a checkpoint of a simulator built with the same configuration.
    pub fn restore(&mut self, state: &AppendageState) {
        assert!(state.x.len() == self.state.len(), "a checkpoint of a simulator with another number of modes");
        self.state.copy_from_slice(&state.x);
        self.sample = state.sample;
    }

    /// Angle of the hub [rad].
    pub fn hub_angle_rad(&self) -> f64 {
        self.state[0]
    }

    /// Rate of the hub [rad/s].
    pub fn hub_rate_rad_s(&self) -> f64 {
        self.state[self.state.len() / 2]
    }
}

/// The seed's excitation: `amplitude` from t = 0 until `end_s`, then nothing.
pub fn rectangular_pulse_nm(t_s: f64, amplitude_nm: f64, end_s: f64) -> f64 {
    // a sample meant to lie on the edge must not fall before it by rounding
    if t_s >= -1e-9 && t_s < end_s - 1e-9 { amplitude_nm } else { 0.0 }
}

type StateSpace = (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DVector<f64>);

/// `x = (q, q̇)`, `x' = A x + B u`, `y = C x + D u`.
fn state_space(equations: &Equations) -> StateSpace {
    let size = equations.mass.nrows();
    let factor = equations.mass.clone().cholesky().expect("the mass matrix of hub and beam is positive definite");
    let mut force = DVector::zeros(size);
    force[0] = 1.0;
    let from_torque = factor.solve(&force);
    // q̈ = [−M⁻¹K, −M⁻¹D] x + M⁻¹ e₁ u
    let mut acceleration = DMatrix::zeros(size, 2 * size);
    acceleration.view_mut((0, 0), (size, size)).copy_from(&-factor.solve(&equations.stiffness));
    acceleration.view_mut((0, size), (size, size)).copy_from(&-factor.solve(&equations.damping));

    let mut a = DMatrix::zeros(2 * size, 2 * size);
    a.view_mut((0, size), (size, size)).fill_with_identity();
    a.view_mut((size, 0), (size, 2 * size)).copy_from(&acceleration);
    let mut b = DMatrix::zeros(2 * size, 1);
    b.view_mut((size, 0), (size, 1)).copy_from(&from_torque);
    (a, b, &equations.sensor * acceleration, &equations.sensor * from_torque)
}

#[cfg(test)]
mod tests;
