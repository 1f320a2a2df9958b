//! Innovations and sensitivities whitened once, for normal equations with one set of further
//! columns after the other.

use super::board::Board;
use super::engine::Engine;
use super::normal::Normal;
use crate::filter::{Gains, NoiseModel, crossed};
use crate::work::of_products;

/// What one noise makes of a board.
pub struct White<'b> {
    pub noise: NoiseModel,
    board: &'b Board,
    gains: Vec<Gains>,
    log_determinant: f64,
    /// Innovations, then sensitivities.
    columns: Vec<Vec<f64>>,
    /// Their products with each other, row by row.
    products: Vec<f64>,
}

impl<'b> White<'b> {
    /// `None`: a covariance is not positive.
    pub fn new(engine: &Engine<'_>, board: &'b Board, noise: &NoiseModel) -> Option<Self> {
        let (gains, columns) = board.white(engine, noise)?;
        let products = products(engine, &columns, &columns);
        let log_determinant = gains.iter().map(|gains| gains.log_determinant).sum();
        let noise = noise.clone();
        Some(Self { noise, board, gains, log_determinant, columns, products })
    }

    /// [`Board::normal`] with raw `extra` columns behind the unknowns.
    ///
    /// Cost: whitening of these alone, and their products with all.
    pub fn normal(&self, engine: &Engine<'_>, theta: &[f64], extra: &[&Vec<f64>]) -> Option<Normal> {
        let mut own: Vec<Vec<f64>> = extra.iter().copied().cloned().collect();
        self.board.whiten_by(engine, &self.gains, &mut own);
        let (known, width) = (self.columns.len(), self.columns.len() + own.len());
        let (across, among) = (products(engine, &self.columns, &own), products(engine, &own, &own));
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
        Normal::new(engine, theta, &sums, self.board.jacobian.len(), self.log_determinant)
    }
}

fn products(engine: &Engine<'_>, a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<f64> {
    let [all_a, all_b] = [a, b].map(|columns| columns.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>());
    let mut sums = vec![0.0; a.len() * b.len()];
    engine.work.add(of_products(engine.samples, 1) * 2.0 * (a.len() * b.len()) as f64);
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
        let engine = Engine::new(&problem, 1).unwrap();
        let theta = engine.prior();
        let mut board = Board::new(&engine, &nominal, &theta, &engine.noise).unwrap();
        board.take_jacobian(&engine, &nominal, &theta);
        let column = |k: usize| -> Vec<f64> { (0..engine.samples).map(|s| libm::sin((s * (k + 1)) as f64)).collect() };
        let extra: Vec<Vec<f64>> = (0..11).map(column).collect();
        let extra: Vec<&Vec<f64>> = extra.iter().collect();
        for noise in [engine.noise.clone(), engine.noise.louder(1.7)] {
            let whole = board.normal(&engine, &theta, &noise, &extra).unwrap();
            let found = White::new(&engine, &board, &noise).unwrap().normal(&engine, &theta, &extra).unwrap();
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
