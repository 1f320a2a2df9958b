//! The published estimators of the slosh parameters: total least squares and instrumental variables
//! on an accelerometer that is integrated twice (BP2, Eqs. 16–18), kept so that their failure on
//! the damping is seen on the same records.
//!
//! `a − f/m0 = −c* v0 − k* x0 + c*/(m0+ms) ∫f + k*/(m0+ms) ∬f`,  `c* = cs/μ`, `k* = ks/μ`,
//! `ms = k*/a4 − m0`.
//!
//! The source does not say what its instruments are. Here, as usual: the same regressors without
//! noise, simulated with the estimate of total least squares.

use crate::campaign::Answer;
use estimation::total_least_squares::TotalLeastSquares;
use nalgebra::{Matrix4, Vector4};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};
use physics::slosh_arc::SloshSample;

/// Answers with three parameters.
const PARAMETERS: usize = 3;

/// `[−v, −x, ∫f, ∬f]` at mid-interval, and what they explain.
struct Regressors {
    base_mass_kg: f64,
    velocity: Integrals,
    impulse: Integrals,
}

impl Regressors {
    fn new(base_mass_kg: f64) -> Self {
        Self { base_mass_kg, velocity: Integrals::default(), impulse: Integrals::default() }
    }

    fn row(&mut self, dt: f64, force_n: f64, acceleration_m_s2: f64) -> (Vector4<f64>, f64) {
        let (v, x) = self.velocity.at_half(acceleration_m_s2, dt);
        let (p, q) = self.impulse.at_half(force_n, dt);
        self.velocity.advance(acceleration_m_s2, dt);
        self.impulse.advance(force_n, dt);
        (Vector4::new(-v, -x, p, q), acceleration_m_s2 - force_n / self.base_mass_kg)
    }
}

/// The three parameters from the published four coefficients.
fn parameters(alpha: &Vector4<f64>, base_mass_kg: f64) -> [f64; PARAMETERS] {
    let (c_star, k_star) = (alpha[0], alpha[1]);
    let m_s = k_star / alpha[3] - base_mass_kg;
    let mu = base_mass_kg * m_s / (base_mass_kg + m_s);
    [m_s, k_star * mu, c_star * mu]
}

/// Total least squares over a record.
pub(super) fn total_least_squares(record: &[SloshSample], base_mass_kg: f64) -> Option<[f64; PARAMETERS]> {
    let (mut factor, mut regressors) = (TotalLeastSquares::<4, 5>::default(), Regressors::new(base_mass_kg));
    for SloshSample { interval_s, force_n, acceleration_m_s2, .. } in record {
        let (row, right) = regressors.row(*interval_s, *force_n, *acceleration_m_s2);
        factor.push(&row, right);
    }
    factor.estimate().ok().map(|alpha| parameters(&alpha, base_mass_kg))
}

/// Instrumental variables over a record; nothing when total least squares gives no tank to
/// simulate.
pub(super) fn instrumental_variables(record: &[SloshSample], base_mass_kg: f64) -> Option<[f64; PARAMETERS]> {
    let [slosh_mass_kg, stiffness_n_m, damping_n_s_m] = total_least_squares(record, base_mass_kg)?;
    if !(slosh_mass_kg > 0.0 && stiffness_n_m > 0.0) {
        return None;
    }
    let auxiliary = SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m };
    let mut model = SloshPropagator::new(auxiliary, base_mass_kg, SloshState::default());
    let (mut measured, mut simulated) = (Regressors::new(base_mass_kg), Regressors::new(base_mass_kg));
    let (mut cross, mut vector) = (Matrix4::zeros(), Vector4::zeros());
    for SloshSample { interval_s, force_n, acceleration_m_s2, .. } in record {
        let (row, right) = measured.row(*interval_s, *force_n, *acceleration_m_s2);
        let (instrument, _) = simulated.row(*interval_s, *force_n, model.step(*interval_s, *force_n));
        cross += instrument * row.transpose();
        vector += instrument * right;
    }
    cross.lu().solve(&vector).map(|alpha| parameters(&alpha, base_mass_kg))
}

pub(super) fn answer(found: Option<[f64; PARAMETERS]>) -> Answer {
    let finite = found.filter(|values| values.iter().all(|value| value.is_finite()));
    finite.map_or_else(|| Answer::none(PARAMETERS), Answer::bare)
}

/// First and second integral of a quantity held over each interval.
#[derive(Clone, Copy, Default)]
struct Integrals {
    first: f64,
    second: f64,
}

impl Integrals {
    fn at_half(&self, held: f64, dt: f64) -> (f64, f64) {
        (self.first + held * dt / 2.0, self.second + self.first * dt / 2.0 + held * dt * dt / 8.0)
    }

    fn advance(&mut self, held: f64, dt: f64) {
        self.second += self.first * dt + held * dt * dt / 2.0;
        self.first += held * dt;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulated::without_noise;
    use crate::slosh::Slosh;

    #[test]
    fn the_published_forms_are_right_without_noise_so_their_failure_is_the_noise() {
        let slosh = Slosh::bp2();
        let quiet = Slosh { plant: without_noise(&slosh.plant), ..slosh.clone() };
        let (record, base_mass_kg) = (quiet.record(0, 0), slosh.settings.base_mass_kg);
        for found in [total_least_squares(&record, base_mass_kg), instrumental_variables(&record, base_mass_kg)] {
            for (value, truth) in found.expect("generic").iter().zip(slosh.truth().iter()) {
                // The mean acceleration stands for the one at mid-interval: (ω dt)²/24 = 2e-6,
                // times the gain 36 of ms.
                assert!((value / truth - 1.0).abs() < 1e-3, "{value} {truth}");
            }
        }
    }
}
