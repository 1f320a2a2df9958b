//! One maximum of the posterior of some arcs, by damped Gauss–Newton steps.

use super::JointUnknown;
use super::fold::{Knowledge, Message};
use crate::fit::{AS_PROMISED, DAMPING_MAX, EstimationSession, FitError, INNER_STEPS, LinearisedProblem, prior_chi2};
use estimation::levenberg_marquardt::{Damping, damped_step};
use nalgebra::{DMatrix, DVector};

/// Decrease of `−2 ln p` for each unknown below which a step ends the iteration: a step of a tenth
/// of a standard deviation, rms over the unknowns.
const CONVERGED_PER_UNKNOWN: f64 = 1e-2;
/// Halvings of a step before it is damped.
const SHORTENINGS: usize = 4;

/// An arc, or a window of it, as part of a stage.
pub(super) struct Part<'a> {
    pub session: &'a EstimationSession<'a>,
    pub places: &'a [usize],
    pub arc: usize,
}

/// Where a stage ended.
pub(super) struct Ended {
    pub theta: Vec<f64>,
    /// One of each part, at `theta`.
    pub messages: Vec<Message>,
    pub converged: bool,
}

/// What a stage maximises over.
pub(super) struct Stage<'a> {
    pub unknowns: &'a [JointUnknown],
    pub parts: Vec<Part<'a>>,
    /// What is known before these parts are heard.
    pub before: &'a Knowledge,
    /// The others keep their values.
    pub free: Vec<bool>,
}

/// Linear models of all parts about one point.
struct Point {
    linearised: Vec<LinearisedProblem>,
    messages: Vec<Message>,
    objective: f64,
}

impl Stage<'_> {
    /// The nearest maximum from `theta`, with at most `rounds` sets of sensitivities.
    ///
    /// # Errors
    /// A part cannot be predicted at `theta`; later failures end the stage with what is there.
    pub(super) fn maximise(
        &self,
        mut theta: Vec<f64>,
        rounds: usize,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Ended, (usize, FitError)> {
        let mut damping = Damping::on_failure();
        let mut shown = |round: usize, share: f64| progress((round as f64 + share) / (rounds + 1) as f64);
        let mut point = self.point(&theta, &mut |share| shown(0, share))?;
        let mut lowest = point.ended(&theta);
        let mut converged = false;
        let enough = CONVERGED_PER_UNKNOWN * self.free.iter().filter(|free| **free).count() as f64;
        'rounds: for round in 0..rounds {
            if round > 0 {
                match self.point(&theta, &mut |share| shown(round, share)) {
                    Ok(fresh) => point = fresh,
                    Err(_) => break,
                }
                // steps descend along one linear model; about their end the objective may be higher
                if point.objective > lowest.objective + enough {
                    theta.iter_mut().zip(&lowest.theta).for_each(|(t, low)| *t = 0.5 * (*t + low));
                    continue;
                }
                lowest = point.ended(&theta);
            }
            let mut taken = 0.0;
            for inner in 0..INNER_STEPS {
                if self.is_stopped() {
                    break 'rounds;
                }
                let Some((step, promised)) = self.step(&point, &theta, damping.value()) else { break 'rounds };
                if promised < enough {
                    // at a point whose sensitivities are its own
                    converged = inner == 0;
                    if converged {
                        break 'rounds;
                    }
                    break;
                }
                let gained = self.search(&mut point, &mut theta, &step);
                if gained <= 0.0 {
                    damping.failed();
                    if damping.value() > DAMPING_MAX {
                        break 'rounds;
                    }
                    continue;
                }
                damping.taken();
                taken += gained;
                if gained < AS_PROMISED * promised {
                    break;
                }
            }
            if taken <= 0.0 {
                break;
            }
        }
        if converged || self.is_stopped() {
            return Ok(Ended { theta, messages: point.messages, converged });
        }
        let last = self.point(&theta, &mut |share| shown(rounds, share))?;
        let End { theta, messages, .. } =
            if last.objective > lowest.objective + enough { lowest } else { last.ended(&theta) };
        Ok(Ended { theta, messages, converged })
    }

    /// One message of each part at `theta`, from where nothing moves.
    ///
    /// # Errors
    /// A part cannot be predicted at `theta`.
    pub(super) fn messages(&self, theta: &[f64]) -> Result<Vec<Message>, (usize, FitError)> {
        self.point(theta, &mut |_| {}).map(|point| point.messages)
    }

    /// Linearisations, sensitivities and messages at `theta`.
    fn point(&self, theta: &[f64], progress: &mut dyn FnMut(f64)) -> Result<Point, (usize, FitError)> {
        let mut point = Point { linearised: Vec::new(), messages: Vec::new(), objective: 0.0 };
        for (k, part) in self.parts.iter().enumerate() {
            progress(k as f64 / self.parts.len() as f64);
            let failed = |error| (part.arc, error);
            let own = part.own(theta);
            let plant = &part.session.problem.plant;
            let mut linearised =
                LinearisedProblem::new(part.session, plant, &own, &part.session.noise).map_err(failed)?;
            linearised.take_jacobian(part.session, plant, &own);
            let message =
                part.message(&linearised, &own, self.unknowns.len()).ok_or((part.arc, FitError::NotPositive))?;
            point.linearised.push(linearised);
            point.messages.push(message);
        }
        point.objective = self.objective(&point.messages, theta);
        Ok(point)
    }

    fn is_stopped(&self) -> bool {
        self.parts.first().is_some_and(|part| part.session.work.is_stopped())
    }

    fn objective(&self, messages: &[Message], theta: &[f64]) -> f64 {
        let data: f64 = messages.iter().map(|message| message.chi2 + message.log_determinant).sum();
        data + self.before.chi2(&deviations(self.unknowns, theta))
    }

    /// Step of the unknowns in their own units and the decrease that it promises; those at an edge
    /// that they would leave stay there.
    fn step(&self, point: &Point, theta: &[f64], damping: f64) -> Option<(Vec<f64>, f64)> {
        let d = deviations(self.unknowns, theta);
        let mut information = self.before.information.clone();
        let mut right = &self.before.information * (&self.before.mean - &d);
        for message in &point.messages {
            information += &message.information;
            right += &message.gradient;
        }
        let mut fixed: Vec<bool> = self.free.iter().map(|free| !free).collect();
        for _ in 0..=self.unknowns.len() {
            let (mut matrix, mut side) = (information.clone(), right.clone());
            for i in (0..fixed.len()).filter(|i| fixed[*i]) {
                matrix.row_mut(i).fill(0.0);
                matrix.column_mut(i).fill(0.0);
                (matrix[(i, i)], side[i]) = (1.0, 0.0);
            }
            let solved = damped_step(matrix, &side, damping)?;
            let mut leaves = false;
            for (i, unknown) in self.unknowns.iter().enumerate() {
                let leaving =
                    (theta[i] <= unknown.low && solved[i] < 0.0) || (theta[i] >= unknown.high && solved[i] > 0.0);
                leaves |= leaving && !fixed[i];
                fixed[i] |= leaving;
            }
            if !leaves {
                let step = solved.iter().zip(self.unknowns).map(|(s, u)| s * u.sigma).collect();
                return Some((step, solved.dot(&side)));
            }
        }
        None
    }

    /// Shortens the step until the objective falls; the decrease, zero where it does not.
    fn search(&self, point: &mut Point, theta: &mut Vec<f64>, step: &[f64]) -> f64 {
        let mut share = 1.0;
        for _ in 0..SHORTENINGS {
            let ends = theta.iter().zip(step).zip(self.unknowns);
            let moved: Vec<f64> = ends.map(|((t, s), u)| (t + share * s).clamp(u.low, u.high)).collect();
            if let Some((mut innovations, messages)) = self.moved(point, &moved) {
                let after = self.objective(&messages, &moved);
                if after < point.objective {
                    point.exchange(&mut innovations);
                    let gained = point.objective - after;
                    (point.messages, point.objective, *theta) = (messages, after, moved);
                    return gained;
                }
            }
            share *= 0.5;
        }
        0.0
    }

    /// Innovations and messages at `theta` with the gains and the sensitivities of `point`.
    fn moved(&self, point: &mut Point, theta: &[f64]) -> Option<(Vec<Vec<f64>>, Vec<Message>)> {
        let innovations = self.parts.iter().zip(&point.linearised).map(|(part, linearised)| {
            let plant = &part.session.problem.plant;
            part.session.innovations(plant, &part.own(theta), &linearised.linears, &|_| true)
        });
        let mut innovations = innovations.collect::<Option<Vec<_>>>()?;
        point.exchange(&mut innovations);
        let parts = self.parts.iter().zip(&point.linearised);
        let messages: Option<Vec<_>> =
            parts.map(|(part, linearised)| part.message(linearised, &part.own(theta), self.unknowns.len())).collect();
        point.exchange(&mut innovations);
        Some((innovations, messages?))
    }
}

/// A point without its linear models.
struct End {
    theta: Vec<f64>,
    messages: Vec<Message>,
    objective: f64,
}

impl Point {
    /// Before a step from it, which is at `theta`.
    fn ended(&self, theta: &[f64]) -> End {
        End { theta: theta.to_vec(), messages: self.messages.clone(), objective: self.objective }
    }

    /// Exchanges the innovations of all parts for others.
    fn exchange(&mut self, innovations: &mut [Vec<f64>]) {
        for (linearised, nu) in self.linearised.iter_mut().zip(innovations) {
            core::mem::swap(&mut linearised.nu, nu);
        }
    }
}

impl Part<'_> {
    /// The unknowns of this part, of all.
    pub(super) fn own(&self, theta: &[f64]) -> Vec<f64> {
        self.places.iter().map(|at| theta[*at]).collect()
    }

    /// What the part says, its priors taken out: they are counted once for all parts.
    fn message(&self, linearised: &LinearisedProblem, own: &[f64], n: usize) -> Option<Message> {
        let normal = linearised.normal(self.session, own, &self.session.noise, &[])?;
        let (mut information, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let unknowns = &self.session.problem.unknowns;
        for (i, at) in self.places.iter().enumerate() {
            gradient[*at] = normal.right[i] - (unknowns[i].prior - own[i]) / unknowns[i].sigma;
            for (j, other) in self.places.iter().enumerate() {
                information[(*at, *other)] = normal.matrix[(i, j)] - f64::from(u8::from(i == j));
            }
        }
        let log_determinant = normal.objective - normal.chi2 - prior_chi2(self.session, own);
        Some(Message { information, gradient, chi2: normal.chi2, log_determinant, rows: linearised.samples() })
    }
}

/// `(θ − θ₀)/σ₀`.
pub(super) fn deviations(unknowns: &[JointUnknown], theta: &[f64]) -> DVector<f64> {
    DVector::from_iterator(theta.len(), theta.iter().zip(unknowns).map(|(t, u)| (t - u.prior) / u.sigma))
}
