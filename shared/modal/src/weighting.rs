//! Equal say for all parts of a record whose excitation changes its strength.
//!
//! The error of a pole is a sum of innovation times state over the record. Where the excitation is
//! s times stronger, both factors are, and a sum of plain products is ruled by the strongest
//! moments: one jump outweighs a minute of walking. Dividing each block by the variance of its
//! innovations makes the record homogeneous (weighted least squares), whatever the excitation did
//! between blocks. A free decay keeps its weights: there the residual is sensor noise, equal in all
//! blocks.

use faer::Mat;

use crate::gram::Gram;
use crate::ssi_cov::Realisation;

/// Below this ratio of residual powers the exact unweighted Gram matrix, which also has the columns
/// across blocks, is the better one.
const POWER_RATIO_MIN: f64 = 3.0;

/// Blocks and their sum, weighted by the inverse residual power; `None` when the power hardly
/// changes or there are no blocks.
#[must_use]
pub fn homogeneous(blocks: &[Gram], realisation: &Realisation) -> Option<(Gram, Vec<Gram>)> {
    let powers: Vec<f64> = blocks.iter().map(|block| residual_power(block, realisation)).collect();
    let smallest = powers.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = powers.iter().copied().fold(0.0, f64::max);
    if smallest.is_nan() || smallest <= 0.0 || largest < POWER_RATIO_MIN * smallest {
        return None;
    }
    let mean = powers.len() as f64 / powers.iter().map(|power| 1.0 / power).sum::<f64>();
    let weighted: Vec<Gram> = blocks.iter().zip(&powers).map(|(block, power)| scaled(block, mean / power)).collect();
    let mut sum = weighted[0].clone();
    for block in &weighted[1..] {
        sum.matrix += &block.matrix;
        sum.columns += block.columns;
        sum.tails.extend(block.tails.iter().cloned());
    }
    Some((sum, weighted))
}

fn scaled(block: &Gram, weight: f64) -> Gram {
    let mut block = block.clone();
    block.matrix *= faer::Scale(weight);
    for (_, tail) in &mut block.tails {
        tail.iter_mut().for_each(|y| *y *= weight.sqrt());
    }
    block
}

/// Mean power of the past outside all states of the realisation.
fn residual_power(block: &Gram, realisation: &Realisation) -> f64 {
    let half = block.half();
    let past = block.matrix.submatrix(0, 0, half, half);
    let product: Mat<f64> = past * &realisation.u;
    let total: f64 = (0..half).map(|k| past[(k, k)]).sum();
    let inside: f64 = (0..realisation.u.ncols())
        .map(|c| product.col_as_slice(c).iter().zip(realisation.u.col_as_slice(c)).map(|(a, b)| a * b).sum::<f64>())
        .sum();
    (total - inside) / block.columns as f64
}
