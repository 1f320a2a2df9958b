//! Equal say for all parts of a record whose excitation changes its strength.
//!
//! The error of a pole is a sum of innovation times state over the record. Where the excitation is
//! s times stronger, both factors are, and a sum of plain products is ruled by the strongest
//! moments: one jump outweighs a minute of walking. Dividing each block by the variance of its
//! innovations makes the record homogeneous (weighted least squares), whatever the excitation did
//! between blocks. A free decay keeps its weights: there the residual is sensor noise, equal in all
//! blocks.

use crate::gram::Gram;
use crate::ssi_cov::Realisation;
use crate::stretch::Stretch;

/// Below this ratio of residual powers the exact unweighted Gram matrix, which also has the columns
/// across blocks, is the better one.
const POWER_RATIO_MIN: f64 = 3.0;

/// Sum of the blocks, of so many channels and block rows, and the blocks themselves, weighted by
/// the inverse residual power; `None` when the power hardly changes or there are no blocks.
#[must_use]
pub fn homogeneous(
    blocks: &[Stretch],
    (channels, block_rows): (usize, usize),
    realisation: &Realisation,
) -> Option<(Gram, Vec<Stretch>)> {
    let powers: Vec<f64> = blocks.iter().map(|block| residual_power(block, realisation)).collect();
    let smallest = powers.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = powers.iter().copied().fold(0.0, f64::max);
    if smallest.is_nan() || smallest <= 0.0 || largest < POWER_RATIO_MIN * smallest {
        return None;
    }
    let mean = powers.len() as f64 / powers.iter().map(|power| 1.0 / power).sum::<f64>();
    let weighted: Vec<Stretch> =
        blocks.iter().zip(&powers).map(|(block, power)| block.weighted(mean / power)).collect();
    let mut sum = Gram::zeros(channels, block_rows);
    weighted.iter().for_each(|block| sum.add(block));
    Some((sum, weighted))
}

/// Mean power of the past outside all states of the realisation.
fn residual_power(block: &Stretch, realisation: &Realisation) -> f64 {
    let u = &realisation.u;
    let product = block.product(0, u.as_ref());
    let along = |c: usize| product.col_as_slice(c).iter().zip(u.col_as_slice(c)).map(|(a, b)| a * b).sum::<f64>();
    let inside: f64 = (0..u.ncols()).map(along).sum();
    (block.past_power() - inside) / block.columns() as f64
}
