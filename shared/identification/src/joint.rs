//! Several recordings of one vehicle, each with a plant of its own, as one estimate.
//!
//! An arc is one recording with its plant: commands, rates and what is grasped may differ from arc
//! to arc. A parameter of one name is one number, but where its scope says that each recording or
//! segment has its own (a bias), it belongs to its arc.
//!
//! Unknowns are counted in standard deviations of their priors, `d = (θ − θ₀)/σ₀` (n). What an arc
//! knows at a point of linearisation is a [`Message`]: `N = Σ h h'` (n × n) and `g = Σ h r` (n) of
//! its whitened innovations r and their sensitivities h. All messages are folded in the order of
//! the arcs, `Λ = 1 + Σ N`, `Λ δ = −d + Σ g`: each datum is used once (design page "study case",
//! 6). An arc that is not there leaves the estimate wider and as honest.

mod agreement;
mod alone;
mod block;
mod eliminated;
mod fold;
mod restart;
mod sequence;
mod stage;

pub use agreement::Agreement;
pub use eliminated::Eliminated;
pub use fold::{Knowledge, Message};
pub use sequence::{JointFit, identify, predict};

use crate::fit::{EstimationSession, FitError};
use crate::problem::Problem;
use crate::work::Work;
use dynamics::description::{Plant, Scope};
use std::sync::Arc as Shared;

/// A recording of the vehicle, joined with the plant that flew it.
#[derive(Clone, Debug)]
pub struct Arc {
    /// For messages and names of what belongs to it alone.
    pub name: String,
    /// Of exactly one recording.
    pub problem: Problem,
}

/// One unknown of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct JointUnknown {
    /// The plant's name, with `@ARC` where it belongs to one arc.
    pub name: String,
    pub unit: String,
    pub prior: f64,
    pub sigma: f64,
    pub low: f64,
    pub high: f64,
    /// The arc that it belongs to alone.
    pub own: Option<usize>,
}

/// A number with two priors.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{parameter}' is {} ± {} {unit} for {} and {} ± {} {unit} for {}", first.1, first.2, first.0, second.1, second.2, second.0)]
pub struct TwoPriors {
    pub parameter: String,
    pub unit: String,
    /// Arc, value and sigma.
    pub first: (String, f64, f64),
    pub second: (String, f64, f64),
}

/// Why arcs give no joint estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointError {
    #[error(transparent)]
    TwoPriors(Box<TwoPriors>),
    #[error("no parameter of the plant states a sigma: there is nothing to identify")]
    NothingUnknown,
    #[error("{arc}: {error}")]
    Arc { arc: String, error: FitError },
    #[error("the information of the arcs is not positive: some reading is not finite")]
    NotPositive,
    #[error("interrupted before a first estimate")]
    Interrupted,
}

impl JointError {
    /// What the operator can do.
    #[must_use]
    pub fn cure(&self) -> String {
        match self {
            Self::TwoPriors(_) => "a number has one prior: state the same value and sigma in both plant files, \
                or give it scope = \"per recording\" where each recording has its own"
                .into(),
            Self::NothingUnknown => {
                "state what is uncertain, as in mass = { value = \"980 kg\", sigma = \"0.5 %\" }".into()
            }
            Self::Arc { .. } | Self::NotPositive => {
                "`obsid doctor RECORDING --plant FILE` shows what is wrong with a recording; \
                `obsid diagnose` whether its plant explains it"
                    .into()
            }
            Self::Interrupted => "let it run longer; fewer or shorter arcs take less time".into(),
        }
    }
}

/// The arcs of one vehicle with what is unknown of it.
pub struct Vehicle<'p> {
    pub arcs: &'p [Arc],
    pub unknowns: Vec<JointUnknown>,
    sessions: Vec<EstimationSession<'p>>,
    /// Per arc, where its own unknowns stand among those of the vehicle.
    places: Vec<Vec<usize>>,
    work: Shared<Work>,
    threads: usize,
}

impl<'p> Vehicle<'p> {
    /// Joins the unknowns of all arcs by name, in the order in which they first appear.
    ///
    /// # Errors
    /// Two priors for one number, no unknown at all, a plant that cannot predict its recording.
    pub fn new(arcs: &'p [Arc], threads: usize, work: Shared<Work>) -> Result<Self, JointError> {
        let mut unknowns: Vec<JointUnknown> = Vec::new();
        let mut first_arc: Vec<usize> = Vec::new();
        let mut places = Vec::new();
        for (index, arc) in arcs.iter().enumerate() {
            let mut own = Vec::new();
            for found in of_arc(arc, index) {
                let at = unknowns.iter().position(|known| known.name == found.name);
                if let Some(known) = at.map(|at| &unknowns[at])
                    && (known.prior, known.sigma) != (found.prior, found.sigma)
                {
                    return Err(two_priors(known, &arcs[first_arc[at.unwrap_or(0)]], &found, arc));
                }
                own.push(at.unwrap_or_else(|| {
                    unknowns.push(found);
                    first_arc.push(index);
                    unknowns.len() - 1
                }));
            }
            places.push(own);
        }
        if unknowns.is_empty() {
            return Err(JointError::NothingUnknown);
        }
        let session = |arc: &'p Arc| counted(&arc.problem, threads, work.clone()).map_err(|error| arc.failed(error));
        let sessions = arcs.iter().map(session).collect::<Result<_, _>>()?;
        Ok(Self { arcs, unknowns, sessions, places, work, threads })
    }

    /// Prior means.
    #[must_use]
    pub fn prior(&self) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| unknown.prior).collect()
    }

    /// Values of the unknowns of arc `index`, in its problem's order.
    #[must_use]
    pub fn of_arc(&self, index: usize, theta: &[f64]) -> Vec<f64> {
        self.places[index].iter().map(|at| theta[*at]).collect()
    }
}

impl Arc {
    fn failed(&self, error: FitError) -> JointError {
        JointError::Arc { arc: self.name.clone(), error }
    }

    /// First to last sample \[s\].
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.problem.duration_s()
    }
}

/// The unknowns of `plant` that all its arcs share, in the order of every message.
#[must_use]
pub fn shared_unknowns(plant: &Plant) -> Vec<JointUnknown> {
    let parameters = plant.parameters();
    let is_shared = |name: &str| parameters.iter().any(|p| p.name == name && p.scope == Scope::Shared);
    let found = crate::problem::unknowns(plant, 1, &[]).into_iter().filter(|unknown| is_shared(&unknown.parameter));
    let joint = |unknown: crate::problem::Unknown| JointUnknown {
        name: unknown.name,
        unit: unknown.unit,
        prior: unknown.prior,
        sigma: unknown.sigma,
        low: unknown.low,
        high: unknown.high,
        own: None,
    };
    found.map(joint).collect()
}

/// A session that takes its linear models in one pass.
fn counted(problem: &Problem, threads: usize, work: Shared<Work>) -> Result<EstimationSession<'_>, FitError> {
    Ok(EstimationSession { along: true, ..EstimationSession::counted(problem, threads, work)? })
}

/// The unknowns of one arc under the vehicle's names.
fn of_arc(arc: &Arc, index: usize) -> Vec<JointUnknown> {
    let parameters = arc.problem.plant.parameters();
    let is_own = |name: &str| parameters.iter().any(|p| p.name == name && p.scope != Scope::Shared);
    let joint = |unknown: &crate::problem::Unknown| {
        let own = is_own(&unknown.parameter).then_some(index);
        let name = if own.is_some() { format!("{}@{}", unknown.name, arc.name) } else { unknown.name.clone() };
        JointUnknown {
            name,
            unit: unknown.unit.clone(),
            prior: unknown.prior,
            sigma: unknown.sigma,
            low: unknown.low,
            high: unknown.high,
            own,
        }
    };
    arc.problem.unknowns.iter().map(joint).collect()
}

fn two_priors(known: &JointUnknown, first: &Arc, found: &JointUnknown, second: &Arc) -> JointError {
    JointError::TwoPriors(Box::new(TwoPriors {
        parameter: known.name.clone(),
        unit: known.unit.clone(),
        first: (first.name.clone(), known.prior, known.sigma),
        second: (second.name.clone(), found.prior, found.sigma),
    }))
}

#[cfg(test)]
mod alone_tests;
#[cfg(test)]
mod base_tests;
#[cfg(test)]
mod optima_tests;
#[cfg(test)]
mod tests;
