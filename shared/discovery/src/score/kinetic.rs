//! Size of pushes in the metric of the kinetic energy.
//!
//! ```text
//! |Δ|² = Σ_k Δv_kᵀ M(q_k) Δv_k,   Δv_k = h M⁻¹ τ_k        M: mass matrix, τ: what pushes, over h
//! ```
//!
//! Forces and torques of all coordinates have one unit in it, whatever a recording shows of them.

use core::ops::Range;
use identification::filter::{Linear, Propagator};
use nalgebra::{DMatrix, DVector};

/// Poses along a run at which the mass matrix is evaluated.
const POSES: usize = 40;

/// Mass matrices along the filtered trajectory of one run.
pub(crate) struct Kinetic {
    /// Of the velocities in a small change of state, and its length.
    rows: Range<usize>,
    tangent: usize,
    /// Events of each pose.
    span: usize,
    masses: Vec<DMatrix<f64>>,
}

impl Kinetic {
    /// Cost: [`POSES`] mass matrices.
    pub(crate) fn new(linear: &Linear, base: &mut Propagator<'_>) -> Self {
        let (events, states) = (base.timeline.events.len(), base.x0.len());
        let (rows, places) = base.system.velocities();
        let places = places.to_vec();
        let n = base.system.model().v_len();
        let span = events.div_ceil(POSES).max(1);
        let mut whole = DMatrix::zeros(n, n);
        let mass = |k: usize| {
            base.mass_at(k, &linear.updated[k * states..(k + 1) * states], &mut whole);
            whole.select_rows(&places).select_columns(&places)
        };
        let masses = if places.is_empty() { Vec::new() } else { (0..events).step_by(span).map(mass).collect() };
        Self { rows, tangent: linear.layout.tangent, span, masses }
    }

    /// `|Δ|²` of changes of state, one for each event [J].
    pub(crate) fn square(&self, changes: &[f64]) -> f64 {
        let stretches = changes.chunks(self.span * self.tangent.max(1)).zip(&self.masses);
        let square = |(changes, mass): (&[f64], &DMatrix<f64>)| {
            let all = changes.chunks_exact(self.tangent);
            let all = all.map(|change| DVector::from_column_slice(&change[self.rows.clone()]));
            all.map(|change| change.dot(&(mass * &change))).sum::<f64>()
        };
        stretches.map(square).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::propagator;
    use crate::synthetic::{plant, problem, recording};
    use identification::fit::{EstimationSession, LinearisedProblem};

    #[test]
    fn a_change_of_one_rate_has_its_mass_times_its_square_and_one_of_a_position_nothing() {
        let ball = plant("ball_drop");
        let problem = problem(&ball, recording(&ball, 5, 3.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let theta = session.prior();
        let linearised = LinearisedProblem::new(&session, &ball, &theta, &session.noise).unwrap();
        let linear = &linearised.linears[0];
        let mut base = propagator(&session, &ball, &theta, 0).unwrap();
        let kinetic = Kinetic::new(linear, &mut base);
        let (n, events) = (linear.layout.tangent, session.timelines[0].events.len());
        let (mass, inertia) = (ball.bodies[0].mass_kg.value, ball.bodies[0].inertia_com_kg_m2[2].value);
        for (row, name) in linear.names.iter().enumerate() {
            let mut changes = vec![0.0; events * n];
            (0..events).for_each(|k| changes[k * n + row] = 0.5);
            let expected = match (name.ends_with(".rate"), name.contains(".rz")) {
                (true, true) => inertia,
                (true, false) => mass,
                (false, _) => 0.0,
            };
            let found = kinetic.square(&changes) / (0.25 * events as f64);
            assert!((found - expected).abs() < 1e-9 * mass, "{name}: {found} {expected}");
        }
    }
}
