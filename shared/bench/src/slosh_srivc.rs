//! Refined instrumental variables (SRIVC) for slosh on one axis: the literature's regression,
//! repaired.
//!
//! With `u = f/m0`, base acceleration `a` and `A(s) = s² + (cs/μ) s + ks/μ`,
//!
//! ```text
//! [−s a/Â, −a/Â, s u/Â, u/Â] [cs/μ, ks/μ, cs/ms, ks/ms]' = s² (a − u)/Â
//! ```
//!
//! The seed integrates twice (`1/s²`), which turns white noise into a random walk. Filtered by
//! `1/Â` instead the equation error is `(A/Â) n`: white where `Â` is right. Instruments are the
//! same rows with `a` simulated. The four coefficients are projected on the three parameters in the
//! metric of their covariance `σ² (V'V)⁻¹`. (Young & Jakeman 1980; Garnier & Young 2014.) Assumes a
//! quiescent start, no bias, samples of one length.

use nalgebra::{Matrix3, Matrix4, Matrix4x3, Vector3, Vector4};

use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use physics::slosh_arc::SloshSample;

/// Bound of the refinements.
pub const REFINEMENTS_MAX: u32 = 20;

/// Ends when a refinement moves every parameter by less than this part of its standard deviation.
const STEP_SIGMAS: f64 = 1e-3;

/// Why the refinement ends without a tank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SrivcError {
    /// Instruments and rows share a direction without content: excite more.
    NotExcited,
    /// A refinement left the tanks that exist (positive mass and stiffness, below a thousand base
    /// masses).
    Impossible { refinement: u32 },
}

/// A tank by refined instrumental variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SrivcEstimate {
    pub parameters: SloshParameters,
    /// Of `[ms, ks, cs]`.
    pub covariance: Matrix3<f64>,
    pub refinements: u32,
    /// False where the refinements ended before they stood still: the covariance is then that of no
    /// fixed point.
    pub is_converged: bool,
}

/// Refines `start` over a record. Cost about 60 ns per sample and refinement; no memory beyond the
/// sums.
///
/// # Errors
/// [`SrivcError`] names what the record lacks.
pub fn refined_instrumental_variables(
    record: &[SloshSample],
    base_mass_kg: f64,
    start: &SloshParameters,
) -> Result<SrivcEstimate, SrivcError> {
    let mut at = *start;
    let mut last = None;
    for refinement in 1..=REFINEMENTS_MAX {
        let sums = Sums::over(record, base_mass_kg, &at);
        let alpha = sums.cross.lu().solve(&sums.right).ok_or(SrivcError::NotExcited)?;
        let (parameters, covariance) =
            project(&alpha, &sums.instruments, base_mass_kg, &at).ok_or(SrivcError::NotExcited)?;
        if !is_possible(&parameters, base_mass_kg) {
            return Err(SrivcError::Impossible { refinement });
        }
        let moved = (vector(&parameters) - vector(&at)).component_div(&covariance.diagonal().map(libm::sqrt)).amax();
        at = parameters;
        let is_converged = moved < STEP_SIGMAS;
        last = Some(SrivcEstimate { parameters, covariance, refinements: refinement, is_converged });
        if is_converged {
            break;
        }
    }
    last.ok_or(SrivcError::NotExcited)
}

fn is_possible(parameters: &SloshParameters, base_mass_kg: f64) -> bool {
    let m_s = parameters.slosh_mass_kg;
    m_s > 0.0 && m_s < 1e3 * base_mass_kg && parameters.stiffness_n_m > 0.0 && parameters.damping_n_s_m.is_finite()
}

fn vector(parameters: &SloshParameters) -> Vector3<f64> {
    Vector3::new(parameters.slosh_mass_kg, parameters.stiffness_n_m, parameters.damping_n_s_m)
}

/// Weighted by the variance of the samples.
struct Sums {
    /// `V'Z`.
    cross: Matrix4<f64>,
    /// `V'V`.
    instruments: Matrix4<f64>,
    /// `V'y`.
    right: Vector4<f64>,
}

impl Sums {
    fn over(record: &[SloshSample], base_mass_kg: f64, at: &SloshParameters) -> Self {
        let mut sums = Self { cross: Matrix4::zeros(), instruments: Matrix4::zeros(), right: Vector4::zeros() };
        let mu = at.reduced_mass_kg(base_mass_kg);
        // A filter that grows is no prefilter; a short record may well say so.
        let filter = || Prefilter::new(at.stiffness_n_m / mu, (at.damping_n_s_m / mu).max(0.0));
        let (mut measured, mut simulated, mut forced) = (filter(), filter(), filter());
        let damped = SloshParameters { damping_n_s_m: at.damping_n_s_m.max(0.0), ..*at };
        let mut motion = SloshPropagator::new(damped, base_mass_kg, SloshState::default());
        for sample in record {
            let SloshSample { interval_s, force_n, acceleration_m_s2, sigma_m_s2 } = *sample;
            let u = forced.step(force_n / base_mass_kg, interval_s);
            let a = measured.step(acceleration_m_s2, interval_s);
            let simulated_a = simulated.step(motion.step(interval_s, force_n), interval_s);
            let row = Vector4::new(-a[1], -a[0], u[1], u[0]);
            let instrument = Vector4::new(-simulated_a[1], -simulated_a[0], u[1], u[0]);
            let weighted = instrument / (sigma_m_s2 * sigma_m_s2);
            sums.cross += weighted * row.transpose();
            sums.instruments += weighted * instrument.transpose();
            sums.right += weighted * (a[2] - u[2]);
        }
        sums
    }
}

/// `x'' + γ x' + κ x = w` by the trapezoidal rule: `[w/Â, s w/Â, s² w/Â]`.
///
/// Means over intervals belong to mid-interval; those of a held force are piecewise linear between
/// the middles, where the rule errs by (ω dt)²/12.
struct Prefilter {
    kappa: f64,
    gamma: f64,
    x: f64,
    velocity: f64,
    input: f64,
}

impl Prefilter {
    fn new(kappa: f64, gamma: f64) -> Self {
        Self { kappa, gamma, x: 0.0, velocity: 0.0, input: 0.0 }
    }

    fn step(&mut self, input: f64, dt: f64) -> Vector3<f64> {
        let (k, g, h) = (self.kappa, self.gamma, dt / 2.0);
        // v⁺ (1 + g h + k h²) = v (1 − g h − k h²) − 2 k h x + h (w + w⁺),  x⁺ = x + h (v + v⁺).
        let pull = g * h + k * h * h;
        let velocity = (self.velocity * (1.0 - pull) - 2.0 * k * h * self.x + h * (self.input + input)) / (1.0 + pull);
        self.x += h * (self.velocity + velocity);
        (self.velocity, self.input) = (velocity, input);
        Vector3::new(self.x, self.velocity, input - g * self.velocity - k * self.x)
    }
}

/// `min (α − α(θ))' W (α − α(θ))` by Gauss–Newton from `at`; `W` the inverse covariance of `α`,
/// whose inverse in the parameters is returned.
fn project(
    alpha: &Vector4<f64>,
    weight: &Matrix4<f64>,
    base_mass_kg: f64,
    at: &SloshParameters,
) -> Option<(SloshParameters, Matrix3<f64>)> {
    const GAUSS_NEWTON_STEPS: usize = 12;
    let mut theta = *at;
    let mut normal = Matrix3::zeros();
    for _ in 0..GAUSS_NEWTON_STEPS {
        let SloshParameters { slosh_mass_kg: m, stiffness_n_m: k, damping_n_s_m: c } = theta;
        let per_mu = 1.0 / base_mass_kg + 1.0 / m;
        let (by_c, by_k) = (c / (m * m), k / (m * m));
        let predicted = Vector4::new(c * per_mu, k * per_mu, c / m, k / m);
        let jacobian = Matrix4x3::new(
            -by_c,
            0.0,
            per_mu, //
            -by_k,
            per_mu,
            0.0, //
            -by_c,
            0.0,
            1.0 / m, //
            -by_k,
            1.0 / m,
            0.0,
        );
        normal = jacobian.transpose() * weight * jacobian;
        let step = scaled_solve(&normal, &(jacobian.transpose() * weight * (alpha - predicted)))?;
        theta = SloshParameters {
            // Not below a tenth at once: 1/ms is what enters.
            slosh_mass_kg: (m + step[0]).max(0.1 * m),
            stiffness_n_m: k + step[1],
            damping_n_s_m: c + step[2],
        };
    }
    let mut covariance = Matrix3::zeros();
    for i in 0..3 {
        covariance.set_column(i, &scaled_solve(&normal, &Matrix3::identity().column(i).into())?);
    }
    Some((theta, covariance))
}

/// Rows and columns scaled to a unit diagonal first: kilograms and newtons per metre differ by 10⁵
/// in their information.
fn scaled_solve(normal: &Matrix3<f64>, right: &Vector3<f64>) -> Option<Vector3<f64>> {
    let scale = normal.diagonal().map(|value| 1.0 / libm::sqrt(value));
    let scaling = Matrix3::from_diagonal(&scale);
    Some(scaling * (scaling * normal * scaling).cholesky()?.solve(&(scaling * right)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark_tank::{BASE_MASS_KG, TANK};
    use crate::seeded_noise::SeededNoise;

    fn record(seconds: f64, sigma_m_s2: f64, seed: u64) -> Vec<SloshSample> {
        let mut motion = SloshPropagator::new(TANK, BASE_MASS_KG, SloshState::default());
        let mut noise = SeededNoise::new(seed);
        (0..(seconds * 10.0) as u32)
            .map(|k| {
                let force_n = 44.0 * libm::sin(2.0 * core::f64::consts::PI * 0.01 * (f64::from(k) + 0.5) * 0.1);
                let acceleration_m_s2 = motion.step(0.1, force_n) + sigma_m_s2 * noise.normal();
                SloshSample { interval_s: 0.1, force_n, acceleration_m_s2, sigma_m_s2: 0.008 / 60.0 / 0.1_f64.sqrt() }
            })
            .collect()
    }

    fn far() -> SloshParameters {
        SloshParameters { slosh_mass_kg: 33.0, stiffness_n_m: 0.185, damping_n_s_m: 0.06 }
    }

    #[test]
    fn without_noise_the_truth_is_found_within_the_rule_of_integration() {
        for (seconds, tolerance) in [(100.0, 1.2e-4), (300.0, 2e-5)] {
            let found =
                refined_instrumental_variables(&record(seconds, 0.0, 0), BASE_MASS_KG, &far()).expect("excited");
            let off = vector(&found.parameters).component_div(&vector(&TANK)).add_scalar(-1.0).amax();
            assert!(off < tolerance, "{seconds} s: {off}"); // benchmark page 2, section 1.4
        }
    }

    #[test]
    fn errors_of_noisy_records_are_those_the_covariance_states() {
        let sigma = 0.008 / 60.0 / 0.1_f64.sqrt();
        let (mut sum, seeds) = (Vector3::zeros(), 60);
        for seed in 0..seeds {
            let found =
                refined_instrumental_variables(&record(1000.0, sigma, seed), BASE_MASS_KG, &far()).expect("excited");
            let error = vector(&found.parameters) - vector(&TANK);
            let sigmas = found.covariance.diagonal().map(libm::sqrt);
            sum += error.component_div(&sigmas).map(|z| z * z) / seeds as f64;
        }
        // 60 unit normal squares: their mean spreads by √(2/60) = 0.18.
        assert!(sum.max() < 1.6 && sum.min() > 0.5, "{sum}");
    }

    #[test]
    fn a_craft_that_is_not_pushed_tells_nothing() {
        let still: Vec<SloshSample> =
            record(100.0, 1e-4, 1).into_iter().map(|s| SloshSample { force_n: 0.0, ..s }).collect();
        assert!(refined_instrumental_variables(&still, BASE_MASS_KG, &TANK).is_err());
    }
}
