//! The linear problem about one point: innovations, columns of sensitivities, and what any noise
//! makes of them.

use super::FitError;
use super::estimation_session::EstimationSession;
use super::normal::{Normal, prior_chi2};
use super::parallel;
use crate::filter::{Gains, Gradient, Linear, NoiseModel, gains, gradient, products, whiten};
use crate::problem::Timeline;
use crate::work::{of_products, of_whitening};
use dynamics::description::Plant;

mod along;

/// Raw innovations of the frozen filters and their sensitivities, all runs one after the other.
#[derive(Clone, Debug)]
pub struct LinearisedProblem {
    pub linears: Vec<Linear>,
    pub theta: Vec<f64>,
    pub nu: Vec<f64>,
    /// `−∂ν/∂θ` per prior standard deviation, and where it was taken.
    pub jacobian: Vec<Vec<f64>>,
    jacobian_theta: Option<Vec<f64>>,
    /// Steps of the differences [prior standard deviations].
    steps: Vec<f64>,
}

/// A likelihood with its slopes costs as much as so many without.
const GRADIENT: f64 = 3.0;
/// Numbers to whiten from which threads are worth their start.
const SPREAD_LEAST: usize = 100_000;
/// First step of the differences [prior standard deviations].
const STEP_PRIOR: f64 = 1e-3;
/// Change of the innovations [standard deviations of the sensors, over all samples] that a step
/// aims at, and beyond which it is taken again. Where the sensitivity turns by b per prior
/// standard deviation, a change of c leaves an error of b c/2 in it: information b²c²/4 about
/// unknowns that the recording cannot tell apart, beside one of their priors. Signs of dry
/// friction have b of ten: 0.02 where a step is taken again, a quarter at most.
const CHANGE_SIGMA: f64 = 0.03;
const CHANGE_SIGMA_MAX: f64 = 0.1;
/// A step that the plant does not survive is shortened by this.
const STEP_SHORTENING: f64 = 1e-2;
const TRIES_MAX: usize = 3;

impl LinearisedProblem {
    /// Linearises at `theta`.
    ///
    /// # Errors
    /// The filter fails.
    pub fn new(
        session: &EstimationSession<'_>,
        plant: &Plant,
        theta: &[f64],
        noise: &NoiseModel,
    ) -> Result<Self, FitError> {
        let linears = session.linearise(plant, theta, noise)?;
        let nu = linears.iter().flat_map(|linear| linear.nu.iter().copied()).collect();
        let steps = vec![STEP_PRIOR; theta.len()];
        Ok(Self { linears, theta: theta.to_vec(), nu, jacobian: Vec::new(), jacobian_theta: None, steps })
    }

    /// The same unknowns about another point: the steps that `other` found serve here, too.
    pub fn with_steps_of(self, other: &Self) -> Self {
        Self { steps: other.steps.clone(), ..self }
    }

    /// Readings of all recordings together.
    pub fn samples(&self) -> usize {
        self.nu.len()
    }

    /// The sensitivities are those at `theta`.
    pub fn has_jacobian(&self, theta: &[f64]) -> bool {
        self.jacobian_theta.as_deref() == Some(theta)
    }

    /// Sensitivities to all unknowns, if they are not there: in one pass where the session has it
    /// so, else by one pass each, more where the first step was felt too much.
    pub fn take_jacobian(&mut self, session: &EstimationSession<'_>, plant: &Plant, theta: &[f64]) {
        if self.has_jacobian(theta) {
            return;
        }
        self.jacobian_theta = Some(theta.to_vec());
        if session.along {
            return self.take_along(session, plant, theta);
        }
        let taken = parallel(theta.len(), session.threads, |i| self.sensitivity(session, plant, theta, i));
        (self.jacobian, self.steps) = taken.into_iter().unzip();
    }

    /// `−∂ν/∂θ_i` per prior standard deviation, and the step it was taken over: of a law that jumps
    /// one that it feels; zero where the plant survives none.
    fn sensitivity(&self, session: &EstimationSession<'_>, plant: &Plant, theta: &[f64], i: usize) -> (Vec<f64>, f64) {
        let unknown = &session.problem.unknowns[i];
        let concerned = |run: usize| unknown.concerns(&session.problem.runs[run]);
        // away from the edge of what is possible
        let sign = if theta[i] + STEP_PRIOR * unknown.sigma > unknown.high { -1.0 } else { 1.0 };
        let mut step = self.steps[i];
        let mut found = (vec![0.0; self.nu.len()], step);
        for _ in 0..TRIES_MAX {
            let mut moved = theta.to_vec();
            moved[i] += sign * step * unknown.sigma;
            let change = session.innovations(plant, &moved, &self.linears, &concerned);
            let change = change.map(|nu| nu.iter().zip(&self.nu).map(|(a, b)| b - a).collect::<Vec<f64>>());
            let Some((size, mut change)) =
                change.map(|change| (self.change_sigma(session, &change, &concerned), change))
            else {
                step *= STEP_SHORTENING;
                continue;
            };
            if !size.is_finite() {
                step *= STEP_SHORTENING;
                continue;
            }
            if size > 0.0 {
                change.iter_mut().for_each(|c| *c /= sign * step);
                session.silence(&mut change, &concerned);
                found = (change, step);
            }
            if size <= CHANGE_SIGMA_MAX {
                break;
            }
            step *= CHANGE_SIGMA / size;
        }
        found
    }

    /// Norm of a change of the innovations in standard deviations of their sensors, over the runs
    /// that are concerned.
    fn change_sigma(&self, session: &EstimationSession<'_>, change: &[f64], concerned: &dyn Fn(usize) -> bool) -> f64 {
        let runs = (0..session.timelines.len()).filter(|run| concerned(*run));
        let of = |run: usize| -> f64 {
            let channels = &session.timelines[run].channel;
            let own = change[session.offsets[run]..].iter().zip(channels);
            own.map(|(change, channel)| (change / session.noise.sensor_sigma[*channel]).powi(2)).sum()
        };
        runs.map(of).sum::<f64>().sqrt()
    }

    /// Whitens `columns` under `noise`; returns `Σ ln |S|`.
    pub fn whiten(&self, session: &EstimationSession<'_>, noise: &NoiseModel, columns: &mut [Vec<f64>]) -> Option<f64> {
        let found = self.gains(session, noise)?;
        self.whiten_by(session, &found, columns);
        let log_determinant: f64 = found.iter().map(|gains| gains.log_determinant).sum();
        log_determinant.is_finite().then_some(log_determinant)
    }

    /// Gains of every run under `noise`.
    pub fn gains(&self, session: &EstimationSession<'_>, noise: &NoiseModel) -> Option<Vec<Gains>> {
        session.work.add(self.whitening_work(session, 0));
        let runs = self.linears.iter().zip(session.timelines.iter());
        runs.map(|(linear, timeline)| gains(linear, timeline, noise)).collect()
    }

    /// Whitens `columns` by the gains of every run.
    pub fn whiten_by(&self, session: &EstimationSession<'_>, found: &[Gains], columns: &mut [Vec<f64>]) {
        session.work.add(self.whitening_work(session, columns.len()) - self.whitening_work(session, 0));
        for (run, (linear, found)) in self.linears.iter().zip(found).enumerate() {
            let timeline = &session.timelines[run];
            let range = session.offsets[run]..session.offsets[run] + timeline.value.len();
            let mut parts: Vec<&mut [f64]> = columns.iter_mut().map(|column| &mut column[range.clone()]).collect();
            let worth = parts.len() * timeline.value.len() > SPREAD_LEAST;
            let threads = if worth { session.threads.min(parts.len()).max(1) } else { 1 };
            let each = parts.len().div_ceil(threads).max(1);
            std::thread::scope(|scope| {
                let mut shares = parts.chunks_mut(each);
                let own = shares.next();
                shares.for_each(|share| drop(scope.spawn(|| whiten(linear, timeline, found, share))));
                own.into_iter().for_each(|share| whiten(linear, timeline, found, share));
            });
        }
    }

    /// `−2 ln p` of innovations `nu` at `theta`.
    pub fn objective(
        &self,
        session: &EstimationSession<'_>,
        nu: &[f64],
        theta: &[f64],
        noise: &NoiseModel,
    ) -> Option<f64> {
        let mut columns = [nu.to_vec()];
        let log_determinant = self.whiten(session, noise, &mut columns)?;
        let chi2: f64 = columns[0].iter().map(|r| r * r).sum();
        let total = chi2 + log_determinant + prior_chi2(session, theta);
        total.is_finite().then_some(total)
    }

    /// `−2 ln p` of the readings whose innovations are `nu`, and its slopes along the numbers of
    /// the noise; and what the priors at `theta` add.
    pub fn gradient(
        &self,
        session: &EstimationSession<'_>,
        (nu, theta): (&[f64], &[f64]),
        noise: &NoiseModel,
    ) -> Option<(Gradient, f64)> {
        session.work.add(GRADIENT * self.whitening_work(session, 1));
        let runs = self.linears.iter().zip(session.timelines.iter()).zip(&session.offsets);
        let mut all = runs.map(|((linear, timeline), offset)| {
            gradient(linear, timeline, noise, &nu[*offset..offset + timeline.value.len()])
        });
        let first = all.next()??;
        let whole = all.try_fold(first, |mut sum, run| {
            sum += run?;
            Some(sum)
        })?;
        Some((whole, prior_chi2(session, theta)))
    }

    /// Gains under `noise`, and innovations and sensitivities whitened by them.
    pub fn white(&self, session: &EstimationSession<'_>, noise: &NoiseModel) -> Option<(Vec<Gains>, Vec<Vec<f64>>)> {
        let gains = self.gains(session, noise)?;
        let mut columns: Vec<Vec<f64>> = core::iter::once(&self.nu).chain(&self.jacobian).cloned().collect();
        self.whiten_by(session, &gains, &mut columns);
        Some((gains, columns))
    }

    /// Innovations, and sensitivities with raw `extra` columns behind them, whitened under `noise`.
    pub fn whitened(
        &self,
        session: &EstimationSession<'_>,
        noise: &NoiseModel,
        extra: &[&Vec<f64>],
    ) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let columns = self.jacobian.iter().chain(extra.iter().copied());
        let mut columns: Vec<Vec<f64>> = core::iter::once(&self.nu).chain(columns).cloned().collect();
        self.whiten(session, noise, &mut columns)?;
        Some((columns.remove(0), columns))
    }

    /// Normal equations at `theta` under `noise`, with raw `extra` columns (`−∂ν/∂φ`) behind the
    /// unknowns.
    pub fn normal(
        &self,
        session: &EstimationSession<'_>,
        theta: &[f64],
        noise: &NoiseModel,
        extra: &[&Vec<f64>],
    ) -> Option<Normal> {
        let unknowns = self.jacobian.iter().chain(extra.iter().copied());
        let columns: Vec<&Vec<f64>> = core::iter::once(&self.nu).chain(unknowns).collect();
        let mut sums = vec![0.0; columns.len() * columns.len()];
        let mut log_determinant = 0.0;
        session.work.add(self.normal_work(session, extra.len()));
        for ((linear, timeline), offset) in self.linears.iter().zip(session.timelines.iter()).zip(&session.offsets) {
            let own = *offset..offset + timeline.value.len();
            let own: Vec<&[f64]> = columns.iter().map(|column| &column[own.clone()]).collect();
            log_determinant += products((linear, timeline), noise, &own, &mut sums)?;
        }
        Normal::new(session, theta, &sums, self.jacobian.len(), log_determinant)
    }

    /// Work of whitening so many columns.
    pub fn whitening_work(&self, session: &EstimationSession<'_>, columns: usize) -> f64 {
        let runs = self.linears.iter().zip(session.timelines.iter());
        runs.map(|(linear, timeline)| whitening_work(linear, timeline, columns)).sum()
    }

    /// Work of [`LinearisedProblem::normal`] with so many columns behind the unknowns.
    pub fn normal_work(&self, session: &EstimationSession<'_>, extra: usize) -> f64 {
        let columns = 1 + self.jacobian.len() + extra;
        self.whitening_work(session, columns) + of_products(session.samples, columns)
    }
}

/// Work of whitening so many columns of a run.
fn whitening_work(linear: &Linear, timeline: &Timeline, columns: usize) -> f64 {
    let layout = &linear.layout;
    let filter = [layout.tangent, layout.noise_inputs.len(), layout.len()];
    of_whitening(filter, [timeline.events.len(), timeline.value.len()], columns)
}
