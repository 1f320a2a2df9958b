//! The second sigma of an estimate: what the sensor sheet's systematic errors may have done to it
//! (Schmidt's consider covariance).
//!
//! White noise averages out, a bias does not. Errors β that are not estimated (gyro bias, scales,
//! zeros, latency) with the sigmas of the data sheet `σ_β` move the momentum fit by
//! `∂α/∂β = (Λ + F − B)⁻¹ Σ w y ∂r/∂β` (F − B the data's information, Λ the prior's: what the prior
//! holds, no error of a sensor moves); their covariance `(∂α/∂β) diag(σ_β²) (∂α/∂β)'` stands beside
//! that of the noise, never mixed into it: more data shrink the one and not the other. Misalignment
//! of the gyro acts as a scale (its cosine) in the plane.

use crate::momentum::{CHANNELS, ChannelSigma, MomentumSample, channel_jacobian, noisy_momentum_row};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Errors of the data sheet that are considered.
pub const CONSIDERED: usize = 7;

/// Standard deviations of the errors that the data sheet allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorSheet {
    pub gyro_bias_rad_s: f64,
    /// Misalignment included.
    pub gyro_scale: f64,
    pub joint_rate_scale: [f64; 2],
    pub joint_zero_rad: [f64; 2],
    /// Of the gyro behind the joints.
    pub latency_s: f64,
}

impl SensorSheet {
    /// In the order of [`channels_by_error`].
    pub fn sigmas(&self) -> SVector<f64, CONSIDERED> {
        let ([r1, r2], [z1, z2]) = (self.joint_rate_scale, self.joint_zero_rad);
        SVector::from([self.gyro_bias_rad_s, self.gyro_scale, r1, r2, z1, z2, self.latency_s])
    }
}

/// Change of the measured channels (w0, d1, d2, th1, th2) by each considered error, one column
/// each.
pub fn channels_by_error(sample: &MomentumSample, base_acceleration_rad_s2: f64) -> SMatrix<f64, CHANNELS, CONSIDERED> {
    let mut columns = SMatrix::zeros();
    columns[(0, 0)] = 1.0;
    columns[(0, 1)] = sample.omega0_z_rad_s;
    columns[(1, 2)] = sample.joint_rate_rad_s[0];
    columns[(2, 3)] = sample.joint_rate_rad_s[1];
    columns[(3, 4)] = 1.0;
    columns[(4, 5)] = 1.0;
    columns[(0, 6)] = -base_acceleration_rad_s2;
    columns
}

/// Samples on either side of the one whose base acceleration is wanted.
const DIFFERENCE_REACH: usize = 5;
const RING: usize = 2 * DIFFERENCE_REACH + 1;

/// `F − B = Σ w (y y' − S)` and `Σ w y ∂r/∂β`, sample by sample: how the weighted fit moves with
/// each error of the data sheet. Fixed memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConsiderSums<const P: usize> {
    interval_s: f64,
    /// Diagonal of Λ, apart from the sums: the fit has it once, however many of its rows are in
    /// them.
    prior_information: SVector<f64, P>,
    information: SMatrix<f64, P, P>,
    cross: SMatrix<f64, P, CONSIDERED>,
    rows: u64,
    /// The last samples without a gap, oldest overwritten.
    ring: [MomentumSample; RING],
    filled: usize,
    next: usize,
}

impl<const P: usize> ConsiderSums<P> {
    /// Samples come every `interval_s`; `prior_information` is the diagonal of Λ, zero without a
    /// prior.
    pub fn new(interval_s: f64, prior_information: &SVector<f64, P>) -> Self {
        assert!(interval_s > 0.0);
        let ring = [MomentumSample::default(); RING];
        let (information, cross, prior_information) = (SMatrix::zeros(), SMatrix::zeros(), *prior_information);
        Self { interval_s, prior_information, information, cross, rows: 0, ring, filled: 0, next: 0 }
    }

    /// A gap: accelerations are not taken across it.
    pub fn interrupt(&mut self) {
        self.filled = 0;
    }

    /// Takes one sample; weights are those at `reference`. The base's acceleration is a central
    /// difference over ten samples, enough for a sensitivity, so the sums lag five samples behind.
    /// O(P² + P C).
    pub fn push(&mut self, sample: &MomentumSample, h_nms: f64, sigma: &ChannelSigma, reference: &SVector<f64, P>) {
        self.ring[self.next] = *sample;
        self.next = (self.next + 1) % RING;
        self.filled = (self.filled + 1).min(RING);
        if self.filled < RING {
            return;
        }
        // `next` is the oldest
        let (oldest, middle) = (&self.ring[self.next], &self.ring[(self.next + DIFFERENCE_REACH) % RING]);
        let acceleration =
            (sample.omega0_z_rad_s - oldest.omega0_z_rad_s) / (2.0 * DIFFERENCE_REACH as f64 * self.interval_s);
        let row = noisy_momentum_row::<P>(middle, h_nms, &sigma.in_channel_order());
        let weight = 1.0 / row.residual_variance(reference);
        // r = h − y α: an error of the channels moves it by −(∂y/∂c δc)' α
        let by_channel = channel_jacobian::<P>(middle).tr_mul(reference);
        let by_error = -channels_by_error(middle, acceleration).tr_mul(&by_channel);
        let weighted = row.regressor * weight;
        self.information += weighted * row.regressor.transpose() - row.noise * row.noise.transpose() * weight;
        self.cross += weighted * by_error.transpose();
        // noise stands in y and in the error of a scale alike: E[n_c J_c · (−n_c J_c' α)] is no
        // motion of the fit
        for (error, channel) in [(1, 0), (2, 1), (3, 2)] {
            let noise = row.noise.column(channel);
            let mut column = self.cross.column_mut(error);
            column.axpy(weight * noise.dot(reference), &noise, 1.0);
        }
        self.rows += 1;
    }

    /// `(∂α/∂β) diag(σ_β²) (∂α/∂β)'`, `∂α/∂β = (Λ + r (F − B))⁻¹ r Σ w y ∂r/∂β`: the fit has
    /// `rows_of_fit` rows, `r` times those in the sums, which stand for the others. Zero for a data
    /// sheet that states no error; `None` when the samples do not determine the parameters.
    pub fn covariance(&self, sheet: &SensorSheet, rows_of_fit: u64) -> Option<SMatrix<f64, P, P>> {
        if *sheet == SensorSheet::default() {
            return Some(SMatrix::zeros());
        }
        if self.rows == 0 {
            return None;
        }
        let share = self.rows as f64 / rows_of_fit as f64;
        let information = self.information + SMatrix::from_diagonal(&(self.prior_information * share));
        let moved = information.cholesky()?.solve(&self.cross);
        let scaled = moved * SMatrix::<f64, CONSIDERED, CONSIDERED>::from_diagonal(&sheet.sigmas());
        Some(scaled * scaled.transpose())
    }
}
