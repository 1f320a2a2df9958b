//! Shared unknowns and those of one arc alone, in the likelihood of that arc.

use identification::joint::{JointError, Knowledge, Message, Vehicle};
use nalgebra::{DMatrix, DVector};

/// Which unknowns of a vehicle of one arc all arcs share.
pub struct Places {
    own: Vec<bool>,
}

impl Places {
    pub fn of(vehicle: &Vehicle<'_>) -> Self {
        Self { own: vehicle.unknowns.iter().map(|unknown| unknown.own.is_some()).collect() }
    }

    /// Values of all unknowns: the shared ones, and those of the arc, at their priors where none
    /// are known.
    pub fn joined(&self, vehicle: &Vehicle<'_>, shared: &[f64], own: &[f64]) -> Vec<f64> {
        let (mut shared, mut own) = (shared.iter(), own.iter());
        let value = |(k, is_own): (usize, &bool)| {
            let next = if *is_own { own.next() } else { shared.next() };
            *next.unwrap_or(&vehicle.unknowns[k].prior)
        };
        self.own.iter().enumerate().map(value).collect()
    }

    /// What is known of the shared unknowns, and the priors of the arc's own.
    pub fn widened(&self, known: &Knowledge) -> Knowledge {
        let n = self.own.len();
        let shared: Vec<usize> = (0..n).filter(|i| !self.own[*i]).collect();
        let (mut information, mut mean) = (DMatrix::identity(n, n), DVector::zeros(n));
        for (i, at) in shared.iter().enumerate() {
            mean[*at] = known.mean[i];
            for (j, other) in shared.iter().enumerate() {
                information[(*at, *other)] = known.information[(i, j)];
            }
        }
        Knowledge { information, mean }
    }

    /// Shared values, the message without what the arc alone has, and the estimates of that.
    pub fn reduced(
        &self,
        vehicle: &Vehicle<'_>,
        theta: Vec<f64>,
        message: &Message,
    ) -> Result<(Vec<f64>, Message, Vec<f64>), JointError> {
        let d =
            DVector::from_fn(theta.len(), |i, _| (theta[i] - vehicle.unknowns[i].prior) / vehicle.unknowns[i].sigma);
        let reduced = message.eliminated(&self.own, &d).ok_or(JointError::NotPositive)?;
        let shared = theta.iter().zip(&self.own).filter(|(_, own)| !**own).map(|(value, _)| *value).collect();
        let own = (0..theta.len()).filter(|i| self.own[*i]).zip(reduced.step.iter());
        let moved = own.map(|(i, step)| {
            let unknown = &vehicle.unknowns[i];
            (theta[i] + step * unknown.sigma).clamp(unknown.low, unknown.high)
        });
        let moved = moved.collect();
        Ok((shared, reduced.message, moved))
    }
}
