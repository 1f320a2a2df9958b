//! Whether one arc says the same as all others of some unknowns alone.

use super::agreement::Agreement;
use super::fold::{Knowledge, Message};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Information of the prior with which an arc's other unknowns are integrated out, in that of their
/// own priors: a thousand times as wide as these, it says nothing that the others' messages say,
/// too.
const NUISANCE_INFORMATION: f64 = 1e-6;

impl Agreement {
    /// As [`Agreement::of`], over the unknowns `block` alone: the arc's other unknowns are
    /// integrated out without what the others know of them.
    ///
    /// `None` where some information is not positive.
    #[must_use]
    pub fn of_block(message: &Message, others: &Knowledge, d: &DVector<f64>, block: &[usize]) -> Option<Self> {
        let n = d.len();
        let rest: Vec<usize> = (0..n).filter(|i| !block.contains(i)).collect();
        let pick = |of: &DVector<f64>, at: &[usize]| DVector::from_fn(at.len(), |i, _| of[at[i]]);
        let part = |of: &DMatrix<f64>, rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| of[(rows[i], columns[j])])
        };
        let weak = DMatrix::identity(rest.len(), rest.len()) * NUISANCE_INFORMATION;
        let factor = Cholesky::new(part(&message.information, &rest, &rest) + weak)?;
        let cross = part(&message.information, block, &rest);
        let of_block = Message {
            information: part(&message.information, block, block) - &cross * factor.solve(&cross.transpose()),
            gradient: pick(&message.gradient, block) - &cross * factor.solve(&pick(&message.gradient, &rest)),
            ..message.clone()
        };
        let covariance = part(&others.covariance()?, block, block);
        let information = Cholesky::new(covariance)?.inverse();
        let of_others = Knowledge { information, mean: pick(&others.mean, block) };
        Self::of(&of_block, &of_others, &pick(d, block))
    }
}
