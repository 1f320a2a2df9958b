//! A set of hypotheses fitted to its end, with its evidence.

use super::augmented::augmented;
use super::decide::CONFLICT_FACTOR;
use super::hypothesis::{Hypothesis, InnerPrior, freed, log_swap, unknown_of};
use super::marginal::{Bound, cut_at_nothing, log_marginal};
use super::noise::{Linearly, NoisePrior};
use super::temper::Instants;
use super::timed::timed;
use super::timing::{as_seen, shift_of};
use dynamics::effect::Role;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit, Normal, fit};
use identification::problem::{Problem, Unknown};

/// Alternations between unknowns and noise, relinearisations of each, and the decrease of
/// `−2 ln p` that ends them.
const TURNS_MAX: usize = 5;
const ROUNDS: usize = 4;
const SETTLED: f64 = 0.1;
/// `−2 ln p` by which a fit may end above that of the model it contains: rounding of two fits.
/// Above, it has failed.
const FAILED: f64 = 1.0;
/// Shares of the screened amplitude at which a fit starts.
const STARTS: [f64; 2] = [1.0, 1e-3];

/// A fitted set.
#[derive(Clone)]
pub(super) struct Model {
    pub set: Vec<Hypothesis>,
    /// Plant with the effects, unknowns with the priors of the set.
    pub problem: Problem,
    /// Where the states of added modes and tanks were given their widths.
    pub start: Vec<f64>,
    pub fit: Fit,
    pub noise: NoiseModel,
    /// `−2 ln` of likelihood and priors at the mode.
    pub objective: f64,
    /// `ln ∫ p(D|θ, φ, η) p(θ, φ, η)`, points of grids included, up to a constant of the data.
    pub log_marginal: f64,
    /// Log-likelihood of every instant at the mode.
    pub terms: Instants,
}

/// The recordings, the plant without hypotheses, and the noise as stated.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub session: &'a EstimationSession<'a>,
}

/// Where a fit begins: unknowns with values, and noise.
#[derive(Clone, Copy)]
pub(super) struct Begin<'a> {
    pub unknowns: &'a [Unknown],
    pub theta: &'a [f64],
    pub noise: &'a NoiseModel,
}

impl Model {
    pub(super) fn begin(&self) -> Begin<'_> {
        Begin { unknowns: &self.problem.unknowns, theta: &self.fit.theta, noise: &self.noise }
    }

    pub(super) fn prior(&self, session: &EstimationSession<'_>) -> NoisePrior {
        NoisePrior::new(session, &self.set)
    }

    /// A session of the recordings with this model's plant.
    pub(super) fn session<'m>(&'m self, ground: Ground<'_>) -> Option<EstimationSession<'m>> {
        session_of(ground, &self.set, &self.problem, &self.start)
    }

    pub(super) fn log_likelihood(&self) -> f64 {
        self.terms.sum()
    }

    /// Members that another model lacks.
    pub(super) fn beyond(&self, other: &Self) -> Vec<Hypothesis> {
        let key = |own: &Hypothesis| own.key(&self.problem.plant);
        let theirs: Vec<String> = other.set.iter().map(key).collect();
        self.set.iter().filter(|own| !theirs.contains(&key(own))).cloned().collect()
    }

    /// It has every member of another model, and more.
    pub(super) fn holds(&self, other: &Self) -> bool {
        self.set.len() > other.set.len() && self.beyond(other).len() + other.set.len() == self.set.len()
    }

    /// Keys of its members, in alphabetical order.
    pub(super) fn key(&self) -> String {
        key(&self.set, &self.problem)
    }
}

/// Keys of the members of a set, in alphabetical order.
pub(super) fn key(set: &[Hypothesis], problem: &Problem) -> String {
    let mut keys: Vec<String> = set.iter().map(|own| own.key(&problem.plant)).collect();
    keys.sort();
    keys.join(", ")
}

/// A session of the recordings with `problem`'s plant, inputs as `set` has them.
pub(super) fn session_of<'m>(
    ground: Ground<'_>,
    set: &[Hypothesis],
    problem: &'m Problem,
    start: &[f64],
) -> Option<EstimationSession<'m>> {
    let session = EstimationSession::like_at(ground.session, problem, Some(start)).ok()?;
    if shift_of(set).is_some() { session.in_parts(session.parts).ok() } else { Some(session) }
}

/// `bare` with the effects of `set` at `share` of their amplitudes, and where its unknowns start.
fn set_up(bare: &Problem, set: &[Hypothesis], share: f64) -> Option<(Problem, Vec<f64>)> {
    let mut plant = bare.plant.clone();
    freed(&mut plant, set);
    for part in set.iter().flat_map(Hypothesis::parts) {
        plant = augmented(&plant, &part.column, &part.amplitude, share)?;
    }
    let mut problem = as_seen(bare.with_plant(&plant), set);
    let start = problem.unknowns.iter().map(|unknown| unknown.prior).collect();
    for part in set.iter().flat_map(Hypothesis::parts) {
        let candidate = &part.column.candidate;
        for parameter in candidate.effect.parameters.iter().filter(|p| p.role == Role::Amplitude) {
            let name = unknown_of(candidate, parameter.name);
            let own = problem.unknowns.iter_mut().filter(|unknown| unknown.parameter == name);
            own.for_each(|unknown| (unknown.prior, unknown.sigma) = (0.0, part.scale));
        }
    }
    for part in set.iter().flat_map(Hypothesis::parts) {
        for (name, prior) in &part.inner {
            let InnerPrior::LogUniform([low, high]) = prior else { continue };
            let name = unknown_of(&part.column.candidate, name);
            let own = problem.unknowns.iter_mut().filter(|unknown| unknown.parameter == name);
            for unknown in own {
                (unknown.low, unknown.high) = (unknown.low.max(*low), unknown.high.min(*high));
                // the middle of a screening may lie outside
                unknown.prior = unknown.prior.clamp(unknown.low, unknown.high);
            }
        }
    }
    for own in set {
        match own {
            Hypothesis::Conflict(name) => {
                problem.unknowns.iter_mut().find(|unknown| unknown.name == *name)?.sigma *= CONFLICT_FACTOR;
            }
            Hypothesis::Exact(exact) => {
                let own = problem.unknowns.iter_mut().find(|unknown| unknown.name == exact.name)?;
                own.low = own.low.max(0.0);
            }
            _ => {}
        }
    }
    Some((problem, start))
}

/// Fits `set` from `begin`; a fit that ends above `−2 ln p` of the model it contains has failed and
/// starts once more near that model. `None`: it failed again.
///
/// Cost: a few relinearisations.
pub(super) fn fitted(ground: Ground<'_>, set: &[Hypothesis], begin: Begin<'_>, contained: f64) -> Option<Model> {
    let tried = STARTS.iter().filter_map(|share| from(ground, set, begin, *share));
    let model = tried.into_iter().find(|model| model.objective < contained + FAILED)?;
    Some(timed(ground, model))
}

/// Fits `set` from `begin` and a share of the screened amplitudes.
pub(super) fn from(ground: Ground<'_>, set: &[Hypothesis], begin: Begin<'_>, share: f64) -> Option<Model> {
    let (problem, own) = set_up(ground.session.problem, set, share)?;
    let known = |name: &str| begin.unknowns.iter().position(|unknown| unknown.name == name);
    let start: Vec<f64> = (problem.unknowns.iter().zip(own))
        .map(|(unknown, own)| known(&unknown.name).map_or(own, |at| begin.theta[at]).clamp(unknown.low, unknown.high))
        .collect();
    settled(ground, set, problem, (start.clone(), &start), begin.noise)
}

/// Unknowns and noise in turn until neither gains.
pub(super) fn settled(
    ground: Ground<'_>,
    set: &[Hypothesis],
    problem: Problem,
    (start, theta): (Vec<f64>, &[f64]),
    noise: &NoiseModel,
) -> Option<Model> {
    let session = session_of(ground, set, &problem, &start)?;
    let prior = NoisePrior::new(ground.session, set);
    let (mut theta, mut noise) = (theta.to_vec(), prior.begun(noise));
    let mut best: Option<(Fit, NoiseModel, f64)> = None;
    let work = &session.work;
    let (mut turn, mut last) = (0.0, f64::INFINITY);
    for _ in 0..TURNS_MAX {
        if !work.allows_step(turn) {
            break;
        }
        let begun = work.spent();
        let found = fit(&session, &problem.plant, &theta, &noise, ROUNDS).ok()?;
        // what a linear problem promises beside its own point counts where a fit confirms it
        let here = found.objective + prior.price(&noise);
        let (extra, room) = (&[][..], &[][..]);
        let linear = Linearly { session: &session, linearised: &found.linearised, theta: &found.theta, extra, room };
        let own = linear.settled(&noise, &prior)?;
        theta.clone_from(&found.theta);
        let known = core::mem::replace(&mut noise, own.noise);
        if best.as_ref().is_none_or(|(.., least)| here < *least) {
            best = Some((found, known, here));
        }
        turn = work.spent() - begun;
        // a turn that ends where the last one ended is not repeated
        let is_repeated = (last - here).abs() < SETTLED;
        if is_repeated || here - own.objective < SETTLED {
            break;
        }
        last = here;
    }
    let (fit, noise, objective) = best?;
    let linear = Linearly { session: &session, linearised: &fit.linearised, theta: &fit.theta, extra: &[], room: &[] };
    let normal = linear.normal(&noise)?;
    let width = linear.log_width(&noise, &prior)?;
    let swap = log_swap(set, &problem.unknowns, &fit.theta);
    let points: f64 = set.iter().map(Hypothesis::log_points).sum();
    // the fit's end is the mode: what its linear problem promises beside it no fit has confirmed
    let promised = normal.objective - normal.least()?.0;
    let own = log_marginal(&normal, &bounds(&problem, &fit, &normal))? - 0.5 * promised;
    let log_marginal = own + width + swap - points;
    let terms = Instants::new(&session, &fit.linearised.linears, &noise)?;
    let model =
        Model { set: set.to_vec(), start, fit, noise, objective, log_marginal, terms, problem: problem.clone() };
    log_marginal.is_finite().then_some(model)
}

/// Of every unknown whose range may be felt.
fn bounds(problem: &Problem, fit: &Fit, normal: &Normal) -> Vec<Bound> {
    let all = problem.unknowns.iter().zip(&fit.theta).zip(&normal.room).enumerate();
    let felt = all.filter(|(_, (_, room))| room.iter().any(|room| room.is_finite()));
    felt.map(|(place, ((unknown, theta), _))| {
        let room = [unknown.low, unknown.high].map(|end| (end - theta) / unknown.sigma);
        let prior = [unknown.low, unknown.high].map(|end| (end - unknown.prior) / unknown.sigma);
        let is_amplitude = unknown.prior == 0.0 && unknown.parameter.starts_with("effect.");
        Bound { place, room, prior: if is_amplitude { cut_at_nothing(prior[0]) } else { prior } }
    })
    .collect()
}
