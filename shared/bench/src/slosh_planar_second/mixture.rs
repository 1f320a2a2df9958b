//! Sum over the points of the grid: the posterior's mean and covariance.

use libm::{exp, sqrt};
use nalgebra::{SMatrix, SVector, Vector2};

use super::SecondMass;
use super::grid::{AT_A_POINT, SecondAxis, TWO_MASSES};
use crate::slosh_planar_fit::PlanarEstimate;

type Fit = PlanarEstimate<AT_A_POINT>;

/// What a point of the grid says of the ten, for all its cell.
pub(super) struct Cell {
    pub axis: SecondAxis,
    pub hertz: f64,
    pub width_hz: f64,
    pub log_weight: f64,
    pub theta: SVector<f64, TWO_MASSES>,
    pub covariance: SMatrix<f64, TWO_MASSES, TWO_MASSES>,
}

/// Sum over the grid, weights relative to the greatest so far; moments about the first cell.
pub(super) struct Mixture {
    pub cells: usize,
    log_weight: f64,
    weight: f64,
    along_x: f64,
    reference: SVector<f64, TWO_MASSES>,
    mean: SVector<f64, TWO_MASSES>,
    second: SMatrix<f64, TWO_MASSES, TWO_MASSES>,
    hertz: Vector2<f64>,
}

impl Mixture {
    /// A sum of no cells.
    pub fn new() -> Self {
        Self {
            cells: 0,
            log_weight: f64::NEG_INFINITY,
            weight: 0.0,
            along_x: 0.0,
            reference: SVector::zeros(),
            mean: SVector::zeros(),
            second: SMatrix::zeros(),
            hertz: Vector2::zeros(),
        }
    }

    /// Adds a cell; all weights are rescaled where it has the greatest so far.
    pub fn add(&mut self, cell: &Cell) {
        if self.cells == 0 {
            self.reference = cell.theta;
        }
        if cell.log_weight > self.log_weight {
            let shrink = exp(self.log_weight - cell.log_weight);
            self.weight *= shrink;
            self.along_x *= shrink;
            self.mean *= shrink;
            self.second *= shrink;
            self.hertz *= shrink;
            self.log_weight = cell.log_weight;
        }
        let weight = exp(cell.log_weight - self.log_weight);
        let ten = cell.theta - self.reference;
        self.cells += 1;
        self.weight += weight;
        self.along_x += if cell.axis == SecondAxis::X { weight } else { 0.0 };
        self.mean += ten * weight;
        self.second += (cell.covariance + ten * ten.transpose()) * weight;
        let within = cell.width_hz * cell.width_hz / 12.0;
        self.hertz += Vector2::new(cell.hertz, cell.hertz * cell.hertz + within) * weight;
    }

    /// Mean and covariance of the posterior over all cells, beside the best single fit.
    pub fn report(&self, best: &Fit) -> SecondMass {
        let (mean, hertz) = (self.mean / self.weight, self.hertz / self.weight);
        SecondMass {
            theta: self.reference + mean,
            covariance: self.second / self.weight - mean * mean.transpose(),
            along_x: self.along_x / self.weight,
            frequency_hz: hertz[0],
            frequency_sigma_hz: sqrt((hertz[1] - hertz[0] * hertz[0]).max(0.0)),
            chi_square: best.chi_square,
            degrees_of_freedom: best.degrees_of_freedom,
            is_joint: false,
        }
    }
}
