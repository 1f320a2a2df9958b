//! What is known of a tank besides the arc: a prior, and blocks that have left. Both are quadratics
//! in the unknowns.
//!
//! Station keeping was not designed to show slosh. Where no frequency explains the record beyond
//! noise, a likelihood still has dips within the prior, each as sharp as the noise line it fits; a
//! local fit would call that a measurement. Then the prior stays, and the information of the thrust
//! on the expected tank says whether it was excited at all.

use estimation::cramer_rao::FisherInformation;
use nalgebra::{Matrix3, Matrix6, Vector2, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::slosh::SloshParameters;
use crate::slosh_arc::SloshArc;
use crate::slosh_likelihood::{Likelihood, SloshHypothesis, Walk};
use estimation::identifiability::Identifiability;

/// A tank believed before the first sample, each number with a standard deviation of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TankPrior {
    pub parameters: SloshParameters,
    /// Of `[ms, ks, cs]`, all positive.
    pub sigma: Vector3<f64>,
}

impl TankPrior {
    pub(crate) fn hypothesis(&self) -> SloshHypothesis {
        SloshHypothesis { parameters: self.parameters, ..SloshHypothesis::default() }
    }

    /// `Σ (θ − θ0)²/σ²`.
    pub(crate) fn quadratic(&self) -> Remembered {
        let mut information = Matrix6::zeros();
        for i in 0..3 {
            information[(i, i)] = 1.0 / (self.sigma[i] * self.sigma[i]);
        }
        Remembered { at: self.hypothesis(), information, gradient: Vector6::zeros() }
    }

    /// `β = ms/(m0 + ms)` and its standard deviation.
    pub(crate) fn mass_ratio(&self, base_mass_kg: f64) -> [f64; 2] {
        let (m_s, total) = (self.parameters.slosh_mass_kg, base_mass_kg + self.parameters.slosh_mass_kg);
        [m_s / total, base_mass_kg / (total * total) * self.sigma[0]]
    }

    /// What a posterior covariance did to each of the three.
    pub(crate) fn identifiability(&self, sigmas: &Vector3<f64>) -> [Identifiability; 3] {
        core::array::from_fn(|i| Identifiability::of(sigmas[i], self.sigma[i]))
    }

    /// The information of an arc's thrust on the expected tank, had it started at rest: no more
    /// than that the prior is kept, for nothing was found.
    pub(crate) fn identifiability_unseen<const N: usize>(
        &self,
        arc: &SloshArc<N>,
        base_mass_kg: f64,
    ) -> [Identifiability; 3] {
        let mut information: Matrix3<f64> = self.quadratic().information.fixed_view::<3, 3>(0, 0).into();
        let mut walk = Walk::new(base_mass_kg, &self.hypothesis(), arc.block_length_s());
        for segment in (0..arc.segments()).map(|i| arc.segment(i)) {
            walk.restart(Vector2::zeros(), None);
            for block in arc.blocks_of(segment) {
                let by = walk.step(&block).1.fixed_rows::<3>(0).into_owned();
                information += by * (by * block.weight()).transpose();
            }
        }
        let bound = FisherInformation::<3> { matrix: information }.sigmas();
        let each = self.identifiability(&bound.unwrap_or(self.sigma));
        each.map(|one| if one == Identifiability::NotExcited { one } else { Identifiability::PriorKept })
    }
}

/// A log-likelihood to second order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Remembered {
    pub at: SloshHypothesis,
    pub information: Matrix6<f64>,
    pub gradient: Vector6<f64>,
}

impl Remembered {
    /// Gradient of the log-likelihood at a hypothesis.
    pub fn gradient_at(&self, hypothesis: &SloshHypothesis) -> Vector6<f64> {
        self.gradient - self.information * hypothesis.offset_from(&self.at)
    }

    /// Adds χ², gradient and information to a likelihood at the same hypothesis; χ² up to a
    /// constant.
    pub fn add_to(&self, here: &mut Likelihood, hypothesis: &SloshHypothesis) {
        let offset = hypothesis.offset_from(&self.at);
        here.chi_square += offset.dot(&(self.information * offset - self.gradient * 2.0));
        here.gradient += self.gradient_at(hypothesis);
        here.information += self.information;
    }
}
