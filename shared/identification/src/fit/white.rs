//! Innovations and sensitivities whitened once, for normal equations with one set of further
//! columns after the other.

use super::estimation_session::EstimationSession;
use super::linearised_problem::LinearisedProblem;
use super::normal::Normal;
use crate::filter::{Gains, NoiseModel, crossed};
use crate::work::of_products;

/// What one noise makes of a linearised problem.
pub struct White<'b> {
    pub noise: NoiseModel,
    linearised: &'b LinearisedProblem,
    gains: Vec<Gains>,
    log_determinant: f64,
    /// Innovations, then sensitivities.
    columns: Vec<Vec<f64>>,
    /// Their products with each other, row by row.
    products: Vec<f64>,
}

impl<'b> White<'b> {
    /// `None`: a covariance is not positive.
    pub fn new(session: &EstimationSession<'_>, linearised: &'b LinearisedProblem, noise: &NoiseModel) -> Option<Self> {
        let (gains, columns) = linearised.white(session, noise)?;
        let products = products(session, &columns, &columns);
        let log_determinant = gains.iter().map(|gains| gains.log_determinant).sum();
        let noise = noise.clone();
        Some(Self { noise, linearised, gains, log_determinant, columns, products })
    }

    /// [`LinearisedProblem::normal`] with raw `extra` columns behind the unknowns.
    ///
    /// Cost: whitening of these alone, and their products with all.
    pub fn normal(&self, session: &EstimationSession<'_>, theta: &[f64], extra: &[&Vec<f64>]) -> Option<Normal> {
        let mut own: Vec<Vec<f64>> = extra.iter().copied().cloned().collect();
        self.linearised.whiten_by(session, &self.gains, &mut own);
        let (known, width) = (self.columns.len(), self.columns.len() + own.len());
        let (across, among) = (products(session, &self.columns, &own), products(session, &own, &own));
        let mut sums = vec![0.0; width * width];
        for (row, sums) in sums.chunks_exact_mut(width).enumerate() {
            let (own_known, own_extra) = sums.split_at_mut(known);
            if row < known {
                own_known.copy_from_slice(&self.products[row * known..(row + 1) * known]);
                own_extra.copy_from_slice(&across[row * own.len()..(row + 1) * own.len()]);
            } else {
                let row = row - known;
                own_extra.copy_from_slice(&among[row * own.len()..(row + 1) * own.len()]);
            }
        }
        Normal::new(session, theta, &sums, self.linearised.jacobian.len(), self.log_determinant)
    }
}

fn products(session: &EstimationSession<'_>, a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<f64> {
    let [all_a, all_b] = [a, b].map(|columns| columns.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>());
    let mut sums = vec![0.0; a.len() * b.len()];
    session.work.add(of_products(session.samples, 1) * 2.0 * (a.len() * b.len()) as f64);
    crossed(&all_a, &all_b, &mut sums);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;
    use crate::synthetic::{plant, recording};

    #[test]
    fn columns_behind_what_was_whitened_before_have_the_normal_equations_of_all_at_once() {
        let nominal = plant("double_pendulum");
        let both = [recording(&nominal, 3, 1.0), recording(&nominal, 4, 1.5)];
        let problem = Problem::new(&nominal, &both, &[]).unwrap();
        let session = EstimationSession::new(&problem, 1).unwrap();
        let theta = session.prior();
        let mut linearised = LinearisedProblem::new(&session, &nominal, &theta, &session.noise).unwrap();
        linearised.take_jacobian(&session, &nominal, &theta);
        let column = |k: usize| -> Vec<f64> { (0..session.samples).map(|s| libm::sin((s * (k + 1)) as f64)).collect() };
        let extra: Vec<Vec<f64>> = (0..11).map(column).collect();
        let extra: Vec<&Vec<f64>> = extra.iter().collect();
        for noise in [session.noise.clone(), session.noise.scaled(1.7)] {
            let whole = linearised.normal(&session, &theta, &noise, &extra).unwrap();
            let found = White::new(&session, &linearised, &noise).unwrap().normal(&session, &theta, &extra).unwrap();
            let size = |i: usize| whole.matrix[(i, i)].sqrt();
            for i in 0..whole.right.len() {
                let row = |j: usize| (found.matrix[(i, j)] - whole.matrix[(i, j)]).abs() < 1e-9 * size(i) * size(j);
                assert!((0..whole.right.len()).all(row));
                assert!((found.right[i] - whole.right[i]).abs() < 1e-9 * size(i) * whole.chi2.sqrt());
            }
            assert!((found.chi2 - whole.chi2).abs() < 1e-9 * whole.chi2 && found.room == whole.room);
            assert!((found.objective - whole.objective).abs() < 1e-9 * whole.objective.abs());
        }
    }
}
