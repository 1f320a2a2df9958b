//! Shared unknowns and those of one arc alone, in the likelihood of that arc.

use identification::joint::{JointError, Knowledge, Message, Vehicle};
use nalgebra::{DMatrix, DVector};

/// Gain in `χ²` for each unknown of the arc alone that its elimination may promise: a step of 0.3
/// standard deviations rms, whose terms of third order are small against the gain of 0.01 for each
/// shared unknown that ends the iteration.
const OWN_PROMISE_ENOUGH: f64 = 0.1;
/// Passes over an arc for one message at most; a few biases and a clock are nearly linear.
const OWN_PASSES_MAX: usize = 4;

/// A message over the shared unknowns alone.
pub struct Reduced {
    /// Values of the shared unknowns.
    pub shared: Vec<f64>,
    pub message: Message,
    /// Estimates of those that the arc alone has, the shared ones held.
    pub own: Vec<f64>,
    /// Decrease of `χ²` that the estimates promise.
    promised: f64,
}

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

    /// A message at `theta` without what the arc alone has.
    pub fn reduced(&self, vehicle: &Vehicle<'_>, theta: Vec<f64>, message: &Message) -> Result<Reduced, JointError> {
        let d =
            DVector::from_fn(theta.len(), |i, _| (theta[i] - vehicle.unknowns[i].prior) / vehicle.unknowns[i].sigma);
        let reduced = message.eliminated(&self.own, &d).ok_or(JointError::NotPositive)?;
        let shared = theta.iter().zip(&self.own).filter(|(_, own)| !**own).map(|(value, _)| *value).collect();
        let own = (0..theta.len()).filter(|i| self.own[*i]).zip(reduced.step.iter());
        let moved = own.map(|(i, step)| {
            let unknown = &vehicle.unknowns[i];
            (theta[i] + step * unknown.sigma).clamp(unknown.low, unknown.high)
        });
        let own = moved.collect();
        let off = (0..theta.len()).filter(|i| self.own[*i]).map(|i| d[i] * d[i]).sum::<f64>();
        let promised = message.chi2 + off - reduced.message.chi2;
        Ok(Reduced { shared, message: reduced.message, own, promised })
    }

    /// The message of a vehicle of one arc at the values `shared`, what the arc alone has estimated
    /// from the values `own` on.
    ///
    /// The elimination follows the linear model of the arc's own unknowns. After a far step of the
    /// shared ones it promises more than there is, and a point that was too good would refuse every
    /// other: it is taken again where the own unknowns have moved to, until it promises little.
    pub fn message(&self, vehicle: &Vehicle<'_>, shared: &[f64], mut own: Vec<f64>) -> Result<Reduced, JointError> {
        let enough = OWN_PROMISE_ENOUGH * self.own.iter().filter(|own| **own).count() as f64;
        let mut pass = 1;
        loop {
            let at = self.joined(vehicle, shared, &own);
            let message = vehicle.message(0, &at)?;
            let reduced = self.reduced(vehicle, at, &message)?;
            if reduced.promised <= enough || pass == OWN_PASSES_MAX {
                return Ok(reduced);
            }
            own = reduced.own;
            pass += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial;
    use identification::joint::Arc;
    use identification::problem::Problem;
    use identification::work::Work;

    /// `χ² + ln|S|` of a swing at the priors, its initial angle and bias started so many prior
    /// standard deviations off.
    fn objective(off: f64) -> f64 {
        let plant = trial::plant("pendulum");
        let recording = simulation::record(&plant, 5, 2.0, &mut |_| {}).unwrap();
        let arcs = [Arc { name: "A".into(), problem: Problem::new(&plant, &[recording], &[]).unwrap() }];
        let vehicle = Vehicle::new(&arcs, 1, std::sync::Arc::new(Work::of(f64::INFINITY))).unwrap();
        let places = Places::of(&vehicle);
        let of = |wanted: bool, off: f64| {
            let unknowns = vehicle.unknowns.iter().filter(move |unknown| unknown.own.is_some() == wanted);
            unknowns.map(move |unknown| unknown.prior + off * unknown.sigma).collect::<Vec<_>>()
        };
        assert!(!of(true, 0.0).is_empty());
        let reduced = places.message(&vehicle, &of(false, 0.0), of(true, off)).unwrap();
        reduced.message.chi2 + reduced.message.log_determinant
    }

    #[test]
    fn a_message_does_not_depend_on_where_what_the_arc_has_alone_was_before() {
        let [near, far] = [0.0, 3.0].map(objective);
        assert!((near - far).abs() < 0.05, "{near} {far}");
    }
}
