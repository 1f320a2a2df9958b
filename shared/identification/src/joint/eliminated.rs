//! A message without the unknowns that belong to its arc alone.

use super::fold::Message;
use nalgebra::{Cholesky, DMatrix, DVector};

/// What a message says of the shared unknowns, and where it moves those that it alone has.
#[derive(Clone, Debug, PartialEq)]
pub struct Eliminated {
    /// Over the shared unknowns, in their order. Its `chi2` has the expectation `rows` at the true
    /// values of the shared ones.
    pub message: Message,
    /// Step of the eliminated unknowns in standard deviations of their priors, the shared ones
    /// held.
    pub step: DVector<f64>,
}

impl Message {
    /// The marginal over all unknowns but `own`, each of which has its prior of unit variance about
    /// zero and stands at `d`. With `M = 1 + N_oo` and `q = g_o − d_o` (Schur's complement, and the
    /// likelihood with Gaussian unknowns integrated out):
    ///
    /// `N' = N_ss − N_so M⁻¹ N_os`, `g' = g_s − N_so M⁻¹ q`, `χ²' = χ² + d_o'd_o − q'M⁻¹q`,
    /// `ln|S|' = ln|S| + ln|M|`.
    ///
    /// `None` where `M` is not positive: a reading is not finite.
    #[must_use]
    pub fn eliminated(&self, own: &[bool], d: &DVector<f64>) -> Option<Eliminated> {
        let of = |wanted: bool| (0..own.len()).filter(|i| own[*i] == wanted).collect::<Vec<usize>>();
        let (shared, own) = (of(false), of(true));
        let part = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| self.information[(rows[i], columns[j])])
        };
        let gradient = DVector::from_fn(shared.len(), |i, _| self.gradient[shared[i]]);
        let off = DVector::from_fn(own.len(), |i, _| d[own[i]]);
        let q = DVector::from_fn(own.len(), |i, _| self.gradient[own[i]]) - &off;
        let factor = Cholesky::new(part(&own, &own) + DMatrix::identity(own.len(), own.len()))?;
        let step = factor.solve(&q);
        let cross = part(&shared, &own);
        let information = part(&shared, &shared) - &cross * factor.solve(&cross.transpose());
        let half_log: f64 = (0..own.len()).map(|i| libm::log(factor.l_dirty()[(i, i)])).sum();
        let message = Message {
            information: 0.5 * (&information + information.transpose()),
            gradient: gradient - cross * &step,
            chi2: self.chi2 + off.dot(&off) - q.dot(&step),
            log_determinant: self.log_determinant + 2.0 * half_log,
            rows: self.rows,
        };
        Some(Eliminated { message, step })
    }
}
