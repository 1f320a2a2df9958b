//! All arcs at one common point of linearisation, and what two such points say of the line between.
//!
//! The objective is `F = Σ (χ² + ln|S|) + d'd`, −2 ln of the posterior density, of the fold of all
//! messages; about a point it falls by `2 r'δ − δ'Λδ`, `r = −d + Σ g`, `Λ = 1 + Σ N`.

use crate::message::Received;
use crate::parameters::Parameters;
use nalgebra::DVector;

/// One point.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonPoint {
    /// Arcs that spoke, in their order.
    pub arcs: Vec<usize>,
    /// F there.
    pub objective: f64,
    d: DVector<f64>,
    /// r, half the steepest descent.
    r: DVector<f64>,
}

impl CommonPoint {
    /// Of messages at one point; `None` where they have none in common.
    #[must_use]
    pub fn of(parameters: &Parameters, received: &[Received]) -> Option<Self> {
        let theta = &received.first()?.theta;
        if received.iter().any(|one| one.theta != *theta) {
            return None;
        }
        let mut order: Vec<&Received> = received.iter().collect();
        order.sort_by_key(|one| one.arc);
        let d = parameters.deviations(theta);
        let (mut r, mut objective) = (-&d, d.dot(&d));
        for one in &order {
            r += &one.message.gradient;
            objective += one.message.chi2 + one.message.log_determinant;
        }
        let arcs = order.iter().map(|one| one.arc).collect();
        objective.is_finite().then_some(Self { arcs, objective, d, r })
    }

    /// Where on the line to `other`, which is at 1, the parabola through F of both and its slope
    /// here is least; infinite where F falls ever faster. `None` where arcs differ, or F does not
    /// fall towards `other`.
    #[must_use]
    pub fn least(&self, other: &Self) -> Option<f64> {
        let slope = self.r.dot(&(&other.d - &self.d));
        if self.arcs != other.arcs || slope <= 0.0 {
            return None;
        }
        let bend = other.objective - self.objective + 2.0 * slope;
        Some(if bend > 0.0 { slope / bend } else { f64::INFINITY })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial;
    use identification::joint::Message;
    use nalgebra::DMatrix;

    /// An arc at `share` of the way from the priors to one prior standard deviation of all, of an
    /// F whose minimum is at `least`; the arc's information is 3.
    fn point(share: f64, least: f64) -> CommonPoint {
        let parameters = Parameters::of_plant(&trial::plant("oscillator")).unwrap();
        let n = parameters.len();
        let d = DVector::from_element(n, share);
        // F = 4 n (share − least)² by what the prior leaves to the arc
        let chi2 = n as f64 * (4.0 * (share - least).powi(2) - share * share);
        let gradient = DVector::from_element(n, 4.0 * (least - share) + share);
        let message =
            Message { information: 3.0 * DMatrix::identity(n, n), gradient, chi2, log_determinant: 0.0, rows: 9 };
        let theta = parameters.values(&d);
        CommonPoint::of(&parameters, &[Received { arc: 1, theta, message }]).unwrap()
    }

    #[test]
    fn two_points_of_a_parabola_tell_where_it_is_least() {
        for least in [0.3, 1.0, 2.5] {
            let found = point(0.0, least).least(&point(1.0, least)).unwrap();
            assert!((found - least).abs() < 1e-9, "{found} {least}");
        }
        assert_eq!(point(0.0, -0.5).least(&point(1.0, -0.5)), None, "uphill");
    }

    #[test]
    fn points_of_other_arcs_are_not_compared() {
        let mut other = point(1.0, 1.0);
        other.arcs.push(2);
        assert_eq!(point(0.0, 1.0).least(&other), None);
    }
}
