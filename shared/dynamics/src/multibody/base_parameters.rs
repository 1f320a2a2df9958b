//! Base parameters: the combinations of standard inertial parameters that the equations of motion
//! can see.
//!
//! The columns of a regressor stacked over random states are dependent in exact arithmetic. A
//! rank-revealing QR factorisation (columns scaled to unit length, so that kilograms and kg m²
//! weigh the same) counts the independent ones and reports the gap it decided by; the others are
//! expressed through them, `Y_2 = Y_1 K`, and regroup: `Y π = Y_1 (π_1 + K π_2)`. (Gautier,
//! Numerical calculation of the base inertial parameters of robots, J. Robotic Systems 8, 1991.)
//!
//! Among all choices of `Y_1` the leftmost independent columns are taken, which regroups outer
//! links into inner ones as the literature does: `link_1.mcx + 2.068 link_2.m`.

use super::regressor::{PARAMETER_NAMES, PARAMETERS_PER_LINK};
use super::{Data, Model, integrate_position, inverse_dynamics_regressor, momentum_regressor};
use crate::noise::Stream;
use nalgebra::{DMatrix, DVector};

/// A column counts as dependent when less than this share of its length is new.
///
/// Rounding leaves 1e-15 to 1e-13, and a parameter excited at 1e-9 of the others is not
/// identifiable by any sensor.
const INDEPENDENCE: f64 = 1e-9;

/// Which equations are stacked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegressorRows<'a> {
    /// All rows of inverse dynamics: joint efforts, and the external wrench on a free base.
    Efforts,
    /// Momentum about the world's origin, six rows.
    Momentum,
    /// These velocity coordinates of inverse dynamics.
    Chosen(&'a [usize]),
}

/// One identifiable combination.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameter {
    /// `"link_1.mcx + 2.068 link_2.m"`.
    pub text: String,
    /// (index of a standard parameter, factor), the independent one first with factor one.
    pub terms: Vec<(usize, f64)>,
}

/// Parameters that the stacked equations determine.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    pub base: Vec<BaseParameter>,
    /// Largest over smallest singular value of the independent columns, each scaled to unit length.
    pub condition_number: f64,
    /// Last accepted over first rejected pivot of the rank decision; infinite if no pivot was
    /// rejected or the rejected one is zero.
    pub gap: f64,
    /// Names of standard parameters without influence on the equations.
    pub unidentifiable: Vec<String>,
    /// Names of those that act only in combination with an independent one.
    pub regrouped: Vec<String>,
}

impl BaseParameters {
    /// Number of independent combinations.
    pub fn rank(&self) -> usize {
        self.base.len()
    }

    /// Values of the base parameters for given standard ones.
    pub fn values(&self, standard: &[f64]) -> Vec<f64> {
        self.base.iter().map(|base| base.terms.iter().map(|(i, factor)| factor * standard[*i]).sum()).collect()
    }
}

/// `"link.m"`, `"link.mcx"` … for the links' names, in the order of the regressors' columns.
pub fn standard_parameter_names(links: &[&str]) -> Vec<String> {
    links.iter().flat_map(|link| PARAMETER_NAMES.iter().map(move |name| format!("{link}.{name}"))).collect()
}

/// Regressor stacked over `states` random states (positions, velocities and accelerations of order
/// one; seeded).
pub fn stacked_regressor(model: &Model, rows: RegressorRows<'_>, states: usize, seed: u64) -> DMatrix<f64> {
    let stream = Stream::new(seed, "states of the base parameters");
    let (n, columns) = (model.v_len(), PARAMETERS_PER_LINK * model.links_len());
    let chosen: Vec<usize> = match rows {
        RegressorRows::Efforts => (0..n).collect(),
        RegressorRows::Momentum => (0..6).collect(),
        RegressorRows::Chosen(rows) => rows.to_vec(),
    };
    let mut data = Data::new(model);
    let mut one = match rows {
        RegressorRows::Momentum => DMatrix::zeros(6, columns),
        _ => DMatrix::zeros(n, columns),
    };
    let mut stacked = DMatrix::zeros(states * chosen.len(), columns);
    for state in 0..states {
        let (q, v, a) = random_state(model, &stream, state);
        match rows {
            RegressorRows::Momentum => momentum_regressor(model, &mut data, &q, &v, &mut one),
            _ => inverse_dynamics_regressor(model, &mut data, &q, &v, &a, &mut one),
        }
        for (k, row) in chosen.iter().enumerate() {
            stacked.row_mut(state * chosen.len() + k).copy_from(&one.row(*row));
        }
    }
    stacked
}

/// Position, velocity and acceleration number `state` of a stream.
pub(crate) fn random_state(model: &Model, stream: &Stream, state: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let n = model.v_len();
    let draw = |i: usize| 2.0 * stream.uniform_pair((3 * state * n + i) as u64)[1] - 1.0;
    let step: Vec<f64> = (0..n).map(|i| 3.0 * draw(i)).collect();
    let neutral = model.neutral_position();
    let mut q = neutral.clone();
    integrate_position(model, &neutral, &step, 1.0, &mut q);
    (q, (n..2 * n).map(draw).collect(), (2 * n..3 * n).map(draw).collect())
}

/// Base parameters of stacked equations `stacked · π`; `names` has one name per column.
///
/// Cost: one QR and one SVD, O(rows · columns²); allocates.
pub fn base_parameters(stacked: &DMatrix<f64>, names: &[String]) -> BaseParameters {
    assert!(names.len() == stacked.ncols());
    let lengths: Vec<f64> = stacked.column_iter().map(|column| column.norm()).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    // rounding of a column that is zero in exact arithmetic
    let seen: Vec<usize> = (0..names.len()).filter(|i| lengths[*i] > 1e-13 * longest).collect();
    let scaled = DMatrix::from_fn(stacked.nrows(), seen.len(), |r, c| stacked[(r, seen[c])] / lengths[seen[c]]);

    let (rank, gap, pivots) = numerical_rank(&scaled);
    let mut independent = leftmost_independent(&scaled);
    if independent.len() != rank {
        independent = pivots[..rank].to_vec();
        independent.sort_unstable();
    }
    let dependent: Vec<usize> = (0..seen.len()).filter(|c| !independent.contains(c)).collect();
    let y_1 = scaled.select_columns(&independent);
    let svd = y_1.svd(true, true);
    let condition_number = if rank == 0 { 1.0 } else { svd.singular_values.max() / svd.singular_values.min() };
    let k = svd.solve(&scaled.select_columns(&dependent), 0.0).expect("the factors were asked for");

    let base = independent.iter().enumerate().map(|(row, column)| {
        let own = seen[*column];
        let mut terms = vec![(own, 1.0)];
        for (other, column) in dependent.iter().enumerate() {
            if k[(row, other)].abs() > INDEPENDENCE {
                terms.push((seen[*column], k[(row, other)] * lengths[seen[*column]] / lengths[own]));
            }
        }
        BaseParameter { text: combination(&terms, names), terms }
    });
    BaseParameters {
        base: base.collect(),
        condition_number,
        gap,
        unidentifiable: (0..names.len()).filter(|i| !seen.contains(i)).map(|i| names[i].clone()).collect(),
        regrouped: dependent.iter().map(|column| names[seen[*column]].clone()).collect(),
    }
}

/// Rank by column pivoting, the gap at the decision, and the pivots in order.
pub(crate) fn numerical_rank(matrix: &DMatrix<f64>) -> (usize, f64, Vec<usize>) {
    if matrix.is_empty() {
        return (0, f64::INFINITY, Vec::new());
    }
    let qr = matrix.clone().col_piv_qr();
    let mut order = DMatrix::from_fn(1, matrix.ncols(), |_, c| c as f64);
    qr.p().permute_columns(&mut order);
    let r = qr.unpack_r();
    let pivots: Vec<f64> = (0..r.nrows().min(r.ncols())).map(|i| r[(i, i)].abs()).collect();
    let largest = pivots.first().copied().unwrap_or(0.0);
    let rank = pivots.iter().take_while(|d| **d > INDEPENDENCE * largest).count();
    let gap = match (rank.checked_sub(1), pivots.get(rank)) {
        (Some(last), Some(rejected)) if *rejected > 0.0 => pivots[last] / rejected,
        _ => f64::INFINITY,
    };
    (rank, gap, order.iter().map(|c| *c as usize).collect())
}

/// Columns that bring something new against all to their left (Gram–Schmidt, done twice).
fn leftmost_independent(matrix: &DMatrix<f64>) -> Vec<usize> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut chosen = Vec::new();
    for (c, column) in matrix.column_iter().enumerate() {
        let mut rest = column.clone_owned();
        for _ in 0..2 {
            for direction in &basis {
                let part = direction.dot(&rest);
                rest.axpy(-part, direction, 1.0);
            }
        }
        let length = rest.norm();
        if length > INDEPENDENCE * column.norm() {
            basis.push(rest / length);
            chosen.push(c);
        }
    }
    chosen
}

/// `"a + 2.068 b − c"` with six significant digits.
pub(crate) fn combination(terms: &[(usize, f64)], names: &[String]) -> String {
    let mut text = String::new();
    for (position, (index, factor)) in terms.iter().enumerate() {
        let sign = match (position, *factor < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        text.push_str(sign);
        let size = six_digits(factor.abs());
        if size != "1" {
            text.push_str(&size);
            text.push(' ');
        }
        text.push_str(&names[*index]);
    }
    text
}

/// Six significant digits without trailing zeros.
fn six_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().expect("a number that was just printed");
    format!("{rounded}")
}

#[cfg(test)]
mod tests;
