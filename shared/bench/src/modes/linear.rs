//! Modes of the linearised plant: poles and what the accelerometers show of them, in open loop and
//! under its sampled controller.

use dynamics::description::{Initial, Plant};
use dynamics::system::{StateSpace, System, Workspace};
use estimation::matrix_exponential;
use modal::c64;
use nalgebra::{Complex, DMatrix, DVector};

/// A true mode.
#[derive(Clone, Debug)]
pub struct TrueMode {
    /// Continuous-time pole [1/s], imaginary part positive (zero for a real pole).
    pub pole: c64,
    /// Accelerations of all accelerometers.
    pub shape: Vec<c64>,
}

impl TrueMode {
    /// Undamped natural frequency: the modulus of the pole over 2π \[Hz\].
    pub fn frequency_hz(&self) -> f64 {
        self.pole.norm_sqr().sqrt() / core::f64::consts::TAU
    }

    /// Share of critical damping; negative for a mode that grows.
    pub fn damping_ratio(&self) -> f64 {
        -self.pole.re / self.pole.norm_sqr().sqrt()
    }
}

fn state_space(plant: &Plant) -> Option<StateSpace> {
    let system = System::new(plant).ok()?;
    let x = system.initial_state(&Initial::default(), &|_| None).ok()?;
    let u = vec![0.0; system.inputs().len()];
    Some(system.linearise(&mut Workspace::new(&system), 0.0, &x, &u))
}

/// Vibrations of the plant with its inputs held, `accelerometers` being rows of the output, in
/// order of frequency.
pub fn open_loop(plant: &Plant, accelerometers: &[usize]) -> Option<Vec<TrueMode>> {
    let space = state_space(plant)?;
    let vibrates = |pole: &Complex<f64>| pole.im > 1e-3; // the hub's own pair at zero scatters around it
    let poles: Vec<Complex<f64>> =
        space.a.clone().schur().complex_eigenvalues().iter().copied().filter(vibrates).collect();
    let mode = |pole: &Complex<f64>| TrueMode {
        pole: c64::new(pole.re, pole.im),
        shape: shape(&space.c, accelerometers, &eigenvector(&space.a, *pole)),
    };
    let mut modes: Vec<TrueMode> = poles.iter().map(mode).collect();
    modes.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    Some(modes)
}

/// All poles of the plant with its only controller, sampled and held once per period, the reference
/// at rest.
///
/// `u_k = −kp θ_k − kd θ'_k + ki I_k`, `I_k = I_{k−1} − θ_k Δ`; poles are `ln z / Δ` of the sampled
/// loop.
pub fn closed_loop(plant: &Plant, accelerometers: &[usize]) -> Option<Vec<TrueMode>> {
    let space = state_space(plant)?;
    let [controller] = &plant.controllers[..] else { return None };
    let row_of = |name: &Option<String>| plant.sensors.iter().position(|sensor| Some(&sensor.name) == name.as_ref());
    let (angle, rate) = (row_of(&controller.position_sensor)?, row_of(&controller.rate_sensor)?);
    let (kp, ki, kd) = (controller.kp.value, controller.ki.value, controller.kd.value);
    let (n, period) = (space.a.nrows(), plant.simulation.period_s);
    // exp of [[A, B], [0, 0]] Δ holds both matrices of the held input.
    let mut joint = DMatrix::zeros(n + 1, n + 1);
    joint.view_mut((0, 0), (n, n)).copy_from(&(&space.a * period));
    joint.view_mut((0, n), (n, 1)).copy_from(&(space.b.columns(0, 1) * period));
    let held = matrix_exponential(joint);
    let feedback = DVector::from_fn(n + 1, |state, _| match state {
        state if state < n => -(kp + ki * period) * space.c[(angle, state)] - kd * space.c[(rate, state)],
        _ => ki,
    });
    let mut looped = DMatrix::zeros(n + 1, n + 1);
    looped.view_mut((0, 0), (n, n)).copy_from(&held.view((0, 0), (n, n)));
    for column in 0..=n {
        for row in 0..n {
            looped[(row, column)] += held[(row, n)] * feedback[column];
        }
        looped[(n, column)] = if column < n { -period * space.c[(angle, column)] } else { 1.0 };
    }
    let mut readings = DMatrix::zeros(space.c.nrows(), n + 1);
    readings.view_mut((0, 0), (space.c.nrows(), n)).copy_from(&space.c);
    readings += space.d.columns(0, 1) * feedback.transpose();
    let mode = |z: &Complex<f64>| {
        let pole = z.ln() / period;
        TrueMode {
            pole: c64::new(pole.re, pole.im),
            shape: shape(&readings, accelerometers, &eigenvector(&looped, *z)),
        }
    };
    let eigenvalues = looped.clone().schur().complex_eigenvalues();
    let mut modes: Vec<TrueMode> = eigenvalues.iter().filter(|z| z.im >= 0.0).map(mode).collect();
    modes.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    Some(modes)
}

/// Inverse iteration next to an eigenvalue.
fn eigenvector(matrix: &DMatrix<f64>, eigenvalue: Complex<f64>) -> DVector<Complex<f64>> {
    let n = matrix.nrows();
    let beside = eigenvalue * (1.0 + 1e-9) + Complex::new(1e-12, 0.0);
    let shifted = DMatrix::from_fn(n, n, |r, c| {
        Complex::new(matrix[(r, c)], 0.0) - if r == c { beside } else { Complex::new(0.0, 0.0) }
    });
    let factor = shifted.lu();
    let mut vector = DVector::from_fn(n, |k, _| Complex::new(1.0 + k as f64, 0.5));
    for _ in 0..5 {
        if let Some(next) = factor.solve(&vector) {
            vector = &next / Complex::new(next.norm(), 0.0);
        }
    }
    vector
}

fn shape(readings: &DMatrix<f64>, rows: &[usize], vector: &DVector<Complex<f64>>) -> Vec<c64> {
    let reading = |row: &usize| {
        let sum: Complex<f64> = vector.iter().enumerate().map(|(k, x)| x * readings[(*row, k)]).sum();
        c64::new(sum.re, sum.im)
    };
    rows.iter().map(reading).collect()
}
