//! Parameters that the angular momentum of a free-floating system determines.
//!
//! About the centre of mass, with the linear momentum zero, the momentum is linear in coefficients
//! that are *not* linear in the standard parameters (they are divided by the total mass):
//! `h(state; θ) = Σ α_j(θ) w_j(state)`. The span of all `h(·; θ)` has a dimension, the number of
//! coefficients an experiment can find; the coefficients of real bodies fill a manifold in it whose
//! dimension may be smaller. Then they satisfy equations among themselves, which this module finds:
//! the null vectors of their quadratic monomials over random bodies, or of the cubic ones where
//! there is no quadratic. For the planar arm of two links whose centres of mass lie on their axes:
//! eight coefficients, a manifold of seven dimensions, and `a4 a7 = a5 a6`.

use super::base_parameters::{numerical_rank, random_state};
use super::model::Joint;
use super::vector::{M3, V3};
use super::{Data, Model, ModelError, momentum};
use crate::noise::Stream;
use dependence::dependences;
use nalgebra::DMatrix;

mod dependence;
mod planar_functions;

pub use dependence::{Dependence, MONOMIALS_MAX};
pub use planar_functions::{PlanarFunctions, planar_tree_functions};

/// Models that differ in physical parameters alone: same tree, same joints.
pub struct ParameterFamily<'a> {
    /// (low, high) of each parameter.
    pub ranges: &'a [(f64, f64)],
    pub model: &'a dyn Fn(&[f64]) -> Result<Model, ModelError>,
}

/// (q, v) → values.
pub type StateFunctions<'a> = dyn Fn(&[f64], &[f64], &mut [f64]) + 'a;

/// Functions of the state in which the momentum is expected to be linear.
pub struct MomentumBasis<'a> {
    pub names: Vec<String>,
    /// Values at (q, v), `components` rows of `names.len()` (row-major; one component for a planar
    /// base, three for a spatial one, base axes).
    pub evaluate: &'a StateFunctions<'a>,
}

/// Dimensions of what angular momentum determines: a linear span, and the parameters that reach it.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentumSpan {
    /// Number of coefficients that momentum can determine.
    pub span_dimension: usize,
    /// Dimension of the set that physical parameters reach: the rank of `∂α/∂θ`.
    pub manifold_dimension: usize,
    /// Last accepted over first rejected pivot of the two rank decisions.
    pub gaps: [f64; 2],
    /// Functions with a coefficient, in order; numbered (`"f1"` …) when no basis was given.
    pub functions: Vec<String>,
    /// Functions of the basis whose coefficient is always zero.
    pub unused: Vec<String>,
    /// Coefficients in the middle of the family's ranges.
    pub coefficients: Vec<f64>,
    /// Largest part of the momentum outside the basis, relative: rounding if the basis is complete.
    pub residual: f64,
    /// Independent quadratic equations, or else cubic ones; empty also when there would be more
    /// than [`MONOMIALS_MAX`] monomials.
    pub dependences: Vec<Dependence>,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum MomentumSpanError {
    /// Link 0 is not a free base carried by the world, or there is a second root.
    NotFreeFloating,
    /// A draw of the family is no mechanism.
    Model(ModelError),
    /// The momentum is not in the span of the given functions: the part outside.
    BasisIncomplete { residual: f64 },
    /// Functions of the basis are linearly dependent on the model's states.
    BasisDependent { rank: usize, functions: usize },
    /// The span is larger than this many samples can determine.
    TooLarge { draws: usize },
}

impl core::fmt::Display for MomentumSpanError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotFreeFloating => write!(f, "link 0 must be a free base and the only root"),
            Self::Model(error) => write!(f, "{error}"),
            Self::BasisIncomplete { residual } => {
                write!(f, "the basis leaves {residual:.1e} of the momentum unexplained")
            }
            Self::BasisDependent { rank, functions } => {
                write!(f, "only {rank} of {functions} functions of the basis are independent")
            }
            Self::TooLarge { draws } => write!(f, "the span has more dimensions than {draws} draws can tell"),
        }
    }
}

impl core::error::Error for MomentumSpanError {}

impl From<ModelError> for MomentumSpanError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

const DRAWS: usize = 400;
const STATES: usize = 240;
/// Relative; rounding leaves 1e-14, a coefficient that varies at 1e-9 of the others cannot be
/// estimated.
const TOLERANCE: f64 = 1e-9;

/// Span, manifold and dependences of the momentum of a free-floating family.
///
/// # Errors
/// [`MomentumSpanError`].
///
/// Cost: 400 draws × 240 states, some tenths of a second for a small arm; allocates.
pub fn momentum_span(
    family: &ParameterFamily<'_>,
    basis: Option<&MomentumBasis<'_>>,
    seed: u64,
) -> Result<MomentumSpan, MomentumSpanError> {
    let centre = (family.model)(&at(family, &vec![0.5; family.ranges.len()]))?;
    let states = States::new(&centre, seed)?;
    let stream = Stream::new(seed, "parameters of the momentum span");
    let n = family.ranges.len();
    let draw = |j: usize| -> Vec<f64> { (0..n).map(|i| stream.uniform_pair((j * n + i) as u64)[1]).collect() };
    let mut h = DMatrix::zeros(states.rows(), DRAWS);
    for j in 0..DRAWS {
        let model = (family.model)(&at(family, &draw(j)))?;
        h.column_mut(j).copy_from_slice(&states.momentum(&model));
    }
    let (span_dimension, span_gap, _) = numerical_rank(&h);
    if span_dimension * 5 > DRAWS.min(states.rows()) * 4 {
        return Err(MomentumSpanError::TooLarge { draws: DRAWS });
    }
    let projection = Projection::new(&states, basis, &h, span_dimension)?;
    let alpha = &projection.inverse * &h;
    let manifold = (0..4).map(|j| manifold_dimension(family, &states, &projection, &draw(j)));
    let (manifold_dimension, manifold_gap) =
        manifold.collect::<Result<Vec<_>, _>>()?.into_iter().max_by_key(|found| found.0).expect("four draws");
    let coefficients = &projection.inverse * DMatrix::from_vec(states.rows(), 1, states.momentum(&centre));
    Ok(MomentumSpan {
        span_dimension,
        manifold_dimension,
        gaps: [span_gap, manifold_gap],
        functions: projection.functions,
        unused: projection.unused,
        coefficients: coefficients.iter().copied().collect(),
        residual: projection.residual,
        dependences: if manifold_dimension < span_dimension { dependences(&alpha) } else { Vec::new() },
    })
}

/// Parameters at fractions of their ranges.
fn at(family: &ParameterFamily<'_>, fraction: &[f64]) -> Vec<f64> {
    family.ranges.iter().zip(fraction).map(|((low, high), f)| low + (high - low) * f).collect()
}

/// Random states, and the momentum in them once the linear momentum is taken away.
struct States {
    states: Vec<(Vec<f64>, Vec<f64>)>,
    planar: bool,
}

impl States {
    fn new(model: &Model, seed: u64) -> Result<Self, MomentumSpanError> {
        let planar = model.links[0].joint == Joint::FreePlanar;
        let free = planar || model.links[0].joint == Joint::FreeSpatial;
        if !free || model.links.iter().enumerate().any(|(i, link)| (link.parent == 0) != (i == 0)) {
            return Err(MomentumSpanError::NotFreeFloating);
        }
        let stream = Stream::new(seed, "states of the momentum span");
        let states = (0..STATES).map(|k| {
            let (q, v, _) = random_state(model, &stream, k);
            (q, v)
        });
        Ok(Self { states: states.collect(), planar })
    }

    fn components(&self) -> usize {
        if self.planar { 1 } else { 3 }
    }

    fn rows(&self) -> usize {
        self.states.len() * self.components()
    }

    /// Angular momentum about the centre of mass at zero linear momentum, base axes, of every
    /// state.
    fn momentum(&self, model: &Model) -> Vec<f64> {
        let mut data = Data::new(model);
        let mut found = Vec::with_capacity(self.rows());
        for (q, v) in &self.states {
            let mut v = v.clone();
            let linear = if self.planar { 1..3 } else { 3..6 };
            v[linear.clone()].fill(0.0);
            let drifting = momentum(model, &mut data, q, &v);
            let base: M3<f64> = data.link(0).rotation;
            let stop = base.apply_transposed(V3::from(drifting.linear)).scale(-1.0 / drifting.mass).array();
            let stop_len = linear.len();
            v[linear].copy_from_slice(&stop[..stop_len]);
            let h = base.apply_transposed(V3::from(momentum(model, &mut data, q, &v).angular_about_com));
            if self.planar { found.push(h.z) } else { found.extend(h.array()) }
        }
        found
    }
}

/// From momentum to coefficients.
struct Projection {
    /// coefficients × rows.
    inverse: DMatrix<f64>,
    functions: Vec<String>,
    unused: Vec<String>,
    residual: f64,
}

impl Projection {
    fn new(
        states: &States,
        basis: Option<&MomentumBasis<'_>>,
        h: &DMatrix<f64>,
        span: usize,
    ) -> Result<Self, MomentumSpanError> {
        let Some(basis) = basis else { return Ok(Self::numbered(h, span)) };
        let (count, components) = (basis.names.len(), states.components());
        let mut values = vec![0.0; components * count];
        let mut functions = DMatrix::zeros(states.rows(), count);
        for (k, (q, v)) in states.states.iter().enumerate() {
            (basis.evaluate)(q, v, &mut values);
            for (i, value) in values.iter().enumerate() {
                functions[(k * components + i / count, i % count)] = *value;
            }
        }
        let (rank, _, _) = numerical_rank(&functions);
        if rank < count {
            return Err(MomentumSpanError::BasisDependent { rank, functions: count });
        }
        let inverse = functions.clone().pseudo_inverse(0.0).expect("the tolerance is not negative");
        let alpha = &inverse * h;
        let residual = (&functions * &alpha - h).norm() / h.norm();
        if residual > TOLERANCE {
            return Err(MomentumSpanError::BasisIncomplete { residual });
        }
        let largest = alpha.amax();
        let (used, unused): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|i| alpha.row(*i).amax() > TOLERANCE * largest);
        let named = |which: &[usize]| which.iter().map(|i| basis.names[*i].clone()).collect();
        Ok(Self { inverse: inverse.select_rows(&used), functions: named(&used), unused: named(&unused), residual })
    }

    /// Orthonormal directions of the span itself.
    fn numbered(h: &DMatrix<f64>, span: usize) -> Self {
        let u = h.clone().svd(true, false).u.expect("it was asked for");
        let inverse = u.columns(0, span).transpose();
        let residual = (inverse.transpose() * (&inverse * h) - h).norm() / h.norm();
        let functions = (1..=span).map(|i| format!("f{i}")).collect();
        Self { inverse, functions, unused: Vec::new(), residual }
    }
}

/// Rank of `∂α/∂θ` and its gap at one set of parameters, by fourth-order differences.
fn manifold_dimension(
    family: &ParameterFamily<'_>,
    states: &States,
    projection: &Projection,
    fraction: &[f64],
) -> Result<(usize, f64), MomentumSpanError> {
    const STEP: f64 = 2e-3; // of the range: truncation and rounding both near 1e-11
    let mut jacobian = DMatrix::zeros(projection.inverse.nrows(), fraction.len());
    for i in 0..fraction.len() {
        let mut slope = DMatrix::zeros(projection.inverse.nrows(), 1);
        for (offset, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let mut moved = fraction.to_vec();
            moved[i] += offset * STEP;
            let model = (family.model)(&at(family, &moved))?;
            let h = DMatrix::from_vec(states.rows(), 1, states.momentum(&model));
            slope += &projection.inverse * h * (weight / (12.0 * STEP));
        }
        jacobian.column_mut(i).copy_from(&slope);
    }
    for mut row in jacobian.row_iter_mut() {
        let length = row.norm();
        if length > 0.0 {
            row /= length;
        }
    }
    let mut values: Vec<f64> = jacobian.singular_values().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    // differences leave 1e-9 of the largest; a direction that weak is not a direction
    let rank = values.iter().filter(|value| **value > 1e-7 * values[0]).count();
    let gap = values.get(rank).map_or(f64::INFINITY, |rejected| values[rank - 1] / rejected);
    Ok((rank, gap))
}

#[cfg(test)]
mod tests;
