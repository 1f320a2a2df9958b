//! Equations among the coefficients of the momentum: null vectors of their monomials over random
//! bodies.

use crate::multibody::base_parameters::combination;
use nalgebra::DMatrix;

/// An equation between the coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependence {
    /// `"a4·a7 = a5·a6"`, coefficients numbered from one in the order of
    /// [`MomentumSpan::functions`](super::MomentumSpan::functions).
    pub text: String,
    /// (factors of the monomial counted from zero, its weight) of `Σ weight · Π α_i = 0`, the
    /// largest weight one.
    pub terms: Vec<(Vec<usize>, f64)>,
}

/// Monomials among which a dependence is searched; more cannot be told apart by the draws taken.
pub const MONOMIALS_MAX: usize = 250;

/// Singular values of scaled monomials: rounding leaves 1e-15, products of coefficients that vary
/// by a half stay above 1e-7.
const NULL_TOLERANCE: f64 = 1e-11;

/// Equations that all columns of `alpha` satisfy: as many as there are, of the lowest degree that
/// has any.
pub(super) fn dependences(alpha: &DMatrix<f64>) -> Vec<Dependence> {
    [2, 3].into_iter().map(|degree| of_degree(alpha, degree)).find(|found| !found.is_empty()).unwrap_or_default()
}

/// Products of `degree` factors out of `n`, factors in ascending order.
fn monomials(n: usize, degree: usize) -> Vec<Vec<usize>> {
    let extend = |list: Vec<Vec<usize>>| -> Vec<Vec<usize>> {
        let longer = |m: Vec<usize>| {
            let first = m.last().copied().unwrap_or(0);
            (first..n).map(move |next| [&m[..], &[next]].concat())
        };
        list.into_iter().flat_map(longer).collect()
    };
    (0..degree).fold(vec![Vec::new()], |list, _| extend(list))
}

fn of_degree(alpha: &DMatrix<f64>, degree: usize) -> Vec<Dependence> {
    let products = monomials(alpha.nrows(), degree);
    if products.is_empty() || products.len() > MONOMIALS_MAX {
        return Vec::new();
    }
    let mut values = DMatrix::from_fn(alpha.ncols(), products.len(), |k, m| {
        products[m].iter().map(|i| alpha[(*i, k)]).product::<f64>()
    });
    let lengths: Vec<f64> = values.column_iter().map(|column| column.norm()).collect();
    for (mut column, length) in values.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let svd = values.svd(false, true);
    let v_t = svd.v_t.expect("it was asked for");
    let largest = svd.singular_values.max();
    let null: Vec<usize> = (0..products.len()).filter(|i| svd.singular_values[*i] < NULL_TOLERANCE * largest).collect();
    let equation = |row: Vec<f64>| {
        let mut terms: Vec<(Vec<usize>, f64)> = (0..products.len())
            .filter(|m| row[*m].abs() > 1e-6) // rounding of the null vector, over the smallest regular singular value
            .map(|m| (products[m].clone(), row[m] / lengths[m]))
            .collect();
        let largest = terms.iter().map(|term| term.1).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
        terms.iter_mut().for_each(|term| term.1 /= largest);
        Dependence { text: equation_text(&terms), terms }
    };
    sparse_rows(v_t.select_rows(&null)).into_iter().map(equation).collect()
}

/// The same row space with as many zeros as elimination with full pivoting gives; largest entry of
/// each row one.
fn sparse_rows(mut rows: DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut free: Vec<usize> = (0..rows.nrows()).collect();
    while !free.is_empty() {
        let candidates = free.iter().flat_map(|r| (0..rows.ncols()).map(move |c| (*r, c)));
        let Some((r, c)) = candidates.max_by(|a, b| rows[*a].abs().total_cmp(&rows[*b].abs())) else { break };
        let pivot = rows.row(r) / rows[(r, c)];
        rows.row_mut(r).copy_from(&pivot);
        for other in (0..rows.nrows()).filter(|other| *other != r) {
            let factor = rows[(other, c)];
            let reduced = rows.row(other) - &pivot * factor;
            rows.row_mut(other).copy_from(&reduced);
        }
        free.retain(|row| *row != r);
    }
    rows.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Positive terms on the left, negative ones on the right.
fn equation_text(terms: &[(Vec<usize>, f64)]) -> String {
    let name = |factors: &Vec<usize>| factors.iter().map(|i| format!("a{}", i + 1)).collect::<Vec<_>>().join("·");
    let names: Vec<String> = terms.iter().map(|(factors, _)| name(factors)).collect();
    let side = |sign: f64| {
        let chosen: Vec<(usize, f64)> =
            (0..terms.len()).filter(|m| terms[*m].1 * sign > 0.0).map(|m| (m, terms[m].1.abs())).collect();
        if chosen.is_empty() { "0".to_owned() } else { combination(&chosen, &names) }
    };
    format!("{} = {}", side(1.0), side(-1.0))
}
