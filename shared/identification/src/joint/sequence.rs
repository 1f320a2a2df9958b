//! The order in which arcs are heard, from priors that may be far off to one joint maximum.
//!
//! A frequency known to 5 % loses its phase within ten periods: over a whole arc the likelihood has
//! many maxima. Arcs are heard one after another, the shortest first, each through windows that
//! grow from the longest one that the plant already explains to the whole; what earlier arcs said
//! is the prior of the next. Then one pass over all arcs together from the plants' priors (design
//! page "study case", 4).

use super::agreement::Agreement;
use super::fold::{Knowledge, Message};
use super::stage::{Ended, Part, Stage, deviations};
use super::{Arc, JointError, Vehicle};
use crate::fit::{EstimationSession, LinearisedProblem};
use crate::problem::Problem;

/// Mean square of the whitened innovations up to which a window is explained: its step stays in the
/// same period.
const CHI2_PER_ROW_NEAR: f64 = 2.0;
/// Halvings of an arc to its shortest window.
const WINDOW_HALVINGS_MAX: u32 = 8;
/// Sets of sensitivities of a window, and of the last passes over all arcs.
pub(super) const ROUNDS_OF_A_WINDOW: usize = 3;
pub(super) const ROUNDS_OF_ALL: usize = 8;
/// Squared distance of two maxima, for each unknown, below which steps of integration are short
/// enough: a tenth of a standard deviation rms, as far as the iteration itself is off.
const STEP_ERROR: f64 = 1e-2;
const STEP_HALVINGS_MAX: u32 = 4;
/// Share of the progress that the arcs one after the other are: about as many sets of sensitivities
/// as the passes over all.
const HEARD_SHARE: f64 = 0.5;

/// All arcs together.
#[derive(Clone, Debug)]
pub struct JointFit {
    /// Estimates, in the vehicle's order.
    pub theta: Vec<f64>,
    /// What priors and arcs say together, about [`JointFit::theta`].
    pub knowledge: Knowledge,
    /// Of each arc, at [`JointFit::theta`].
    pub messages: Vec<Message>,
    /// Of each arc with all others and the priors; `None` where it is alone.
    pub agreement: Vec<Option<Agreement>>,
    /// The iteration ended, and halved steps of integration end at the same maximum.
    pub converged: bool,
    /// Posterior standard deviations, in the units of the unknowns.
    pub sigma: Vec<f64>,
    /// It was stopped: what was known by then, of the arcs and windows that were heard.
    pub interrupted: bool,
}

/// The joint maximum a posteriori estimate of all arcs, from the priors.
///
/// `progress` receives the arc that is heard, or `None` for all together, and the share done.
///
/// # Errors
/// An arc that its plant cannot predict. An interruption ends it with what is known by then.
///
/// Cost: some ten sets of sensitivities of each arc.
pub fn identify(vehicle: &Vehicle<'_>, progress: &mut dyn FnMut(Option<&str>, f64)) -> Result<JointFit, JointError> {
    let n = vehicle.unknowns.len();
    let mut theta = vehicle.prior();
    let mut known = Knowledge::of_priors(n);
    let mut order: Vec<usize> = (0..vehicle.arcs.len()).collect();
    order.sort_by(|a, b| vehicle.arcs[*a].duration_s().total_cmp(&vehicle.arcs[*b].duration_s()));
    let all_s: f64 = vehicle.arcs.iter().map(Arc::duration_s).sum();
    let mut heard_s = 0.0;
    let mut messages = vec![Message::of_nothing(n); vehicle.arcs.len()];
    for arc in order {
        let (name, own_s) = (&vehicle.arcs[arc].name, vehicle.arcs[arc].duration_s());
        let mut shown = |share: f64| progress(Some(name), HEARD_SHARE * (heard_s + share * own_s) / all_s);
        messages[arc] = vehicle.heard(arc, &known, &mut theta, &mut shown)?;
        known = known.with([&messages[arc]], &deviations(&vehicle.unknowns, &theta)).ok_or(JointError::NotPositive)?;
        if vehicle.work.is_stopped() {
            return vehicle.fitted(Ended { theta, messages, converged: false }, true);
        }
        heard_s += own_s;
    }
    vehicle.all_together(theta, progress)
}

impl Vehicle<'_> {
    /// Hears one arc through growing windows, and from other starts where there may be another
    /// maximum; what it says where `theta` has moved to.
    pub(super) fn heard(
        &self,
        arc: usize,
        known: &Knowledge,
        theta: &mut Vec<f64>,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Message, JointError> {
        let message = self.through_windows(arc, known, theta, &self.free_of(arc), progress)?;
        let (moved, message) = self.restarted(arc, known, (core::mem::take(theta), message));
        *theta = moved;
        Ok(message)
    }

    /// Those that the arc has; the others keep their values.
    pub(super) fn free_of(&self, arc: usize) -> Vec<bool> {
        (0..self.unknowns.len()).map(|unknown| self.places[arc].contains(&unknown)).collect()
    }

    /// Hears one arc through growing windows of which the unknowns `free` are estimated; what it
    /// says where `theta` has moved to.
    pub(super) fn through_windows(
        &self,
        arc: usize,
        known: &Knowledge,
        theta: &mut Vec<f64>,
        free: &[bool],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Message, JointError> {
        let first = self.first_window(arc, theta);
        // a window costs as much as it lasts
        let length = |halvings: u32| libm::ldexp(1.0, -(halvings as i32));
        let (all, mut done) = ((0..=first).map(length).sum::<f64>(), 0.0);
        for halvings in (0..=first).rev() {
            let window = (halvings > 0).then(|| self.window(arc, halvings));
            let own = match &window {
                Some(problem) => Some(self.session_of(arc, problem)?),
                None => None,
            };
            let session = own.as_ref().unwrap_or(&self.sessions[arc]);
            let part = Part { session, places: &self.places[arc], arc };
            let stage = Stage { unknowns: &self.unknowns, parts: vec![part], before: known, free: free.to_vec() };
            let mut shown = |share: f64| progress((done + share * length(halvings)) / all);
            let ended = stage.maximise(theta.clone(), ROUNDS_OF_A_WINDOW, &mut shown);
            let mut ended = ended.map_err(|found| self.failed(found))?;
            *theta = ended.theta;
            done += length(halvings);
            if halvings == 0 || self.work.is_stopped() {
                return ended.messages.pop().ok_or(JointError::NotPositive);
            }
        }
        Err(JointError::Interrupted)
    }

    /// Halvings of the arc to the longest window that `theta` explains, else to the shortest one
    /// that holds samples at all.
    fn first_window(&self, arc: usize, theta: &[f64]) -> u32 {
        let own = self.of_arc(arc, theta);
        let mut shortest = 0;
        for halvings in 0..=WINDOW_HALVINGS_MAX {
            let found = if halvings == 0 {
                chi2_per_row(&self.sessions[arc], &own)
            } else {
                let window = self.window(arc, halvings);
                self.session_of(arc, &window).ok().and_then(|session| chi2_per_row(&session, &own))
            };
            match found {
                Some(chi2) if chi2 < CHI2_PER_ROW_NEAR => return halvings,
                Some(_) => shortest = halvings,
                None => {}
            }
        }
        shortest
    }

    /// The beginning of an arc, halved so often.
    fn window(&self, arc: usize, halvings: u32) -> Problem {
        self.arcs[arc].problem.split(libm::ldexp(1.0, -(halvings as i32))).0
    }
    fn session_of<'w>(&self, arc: usize, problem: &'w Problem) -> Result<EstimationSession<'w>, JointError> {
        super::counted(problem, self.threads, self.work.clone()).map_err(|error| self.arcs[arc].failed(error))
    }

    /// Passes over all arcs from the plants' priors, to the joint maximum; once more with each step
    /// of integration halved, until the maximum stays.
    fn all_together(
        &self,
        theta: Vec<f64>,
        progress: &mut dyn FnMut(Option<&str>, f64),
    ) -> Result<JointFit, JointError> {
        let n = self.unknowns.len();
        let before = Knowledge::of_priors(n);
        let left = 1.0 - HEARD_SHARE;
        let mut shown = |share: f64| progress(None, HEARD_SHARE + 0.5 * left * share);
        let mut ended = self.maximum(&self.sessions, &before, theta, &mut shown)?;
        let mut steps_agree = false;
        for halvings in 1..=STEP_HALVINGS_MAX {
            if self.work.is_stopped() {
                break;
            }
            let finer = self
                .sessions
                .iter()
                .zip(self.arcs)
                .map(|(session, arc)| session.in_parts(1 << halvings).map_err(|error| arc.failed(error)));
            let finer = finer.collect::<Result<Vec<_>, _>>()?;
            // what was shown is never more than what is done
            let from = 1.0 - left * libm::ldexp(1.0, -(halvings as i32));
            let mut shown = |share: f64| progress(None, from + 0.5 * (1.0 - from) * share);
            let again = self.maximum(&finer, &before, ended.theta.clone(), &mut shown)?;
            let moved = deviations(&self.unknowns, &again.theta) - deviations(&self.unknowns, &ended.theta);
            let known = before.with(&again.messages, &deviations(&self.unknowns, &again.theta));
            let known = known.ok_or(JointError::NotPositive)?;
            let squared = moved.dot(&(&known.information * &moved));
            ended = again;
            if squared < STEP_ERROR * n as f64 {
                steps_agree = true;
                break;
            }
        }
        ended.converged &= steps_agree;
        self.fitted(ended, self.work.is_stopped())
    }

    /// What the priors and the messages of all arcs say.
    fn fitted(&self, ended: Ended, stopped: bool) -> Result<JointFit, JointError> {
        let (n, before) = (self.unknowns.len(), Knowledge::of_priors(self.unknowns.len()));
        let d = deviations(&self.unknowns, &ended.theta);
        let knowledge = before.with(&ended.messages, &d).ok_or(JointError::NotPositive)?;
        let covariance = knowledge.covariance().ok_or(JointError::NotPositive)?;
        let sigma = (0..n).map(|i| libm::sqrt(covariance[(i, i)].max(0.0)) * self.unknowns[i].sigma).collect();
        let heard = ended.messages.iter().filter(|message| message.rows > 0).count();
        let agreement = (0..self.arcs.len())
            .map(|arc| {
                let others = ended.messages.iter().enumerate().filter(|(k, _)| *k != arc).map(|(_, message)| message);
                let others = before.with(others, &d)?;
                let compared = heard > 1 && ended.messages[arc].rows > 0;
                compared.then(|| Agreement::of(&ended.messages[arc], &others, &d)).flatten()
            })
            .collect();
        let Ended { theta, messages, converged } = ended;
        let interrupted = stopped && !converged;
        Ok(JointFit { theta, knowledge, messages, agreement, converged, sigma, interrupted })
    }

    fn maximum(
        &self,
        sessions: &[EstimationSession<'_>],
        before: &Knowledge,
        theta: Vec<f64>,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Ended, JointError> {
        let whole = |arc: usize| Part { session: &sessions[arc], places: &self.places[arc], arc };
        let parts = (0..self.arcs.len()).map(whole).collect();
        let stage = Stage { unknowns: &self.unknowns, parts, before, free: vec![true; self.unknowns.len()] };
        stage.maximise(theta, ROUNDS_OF_ALL, progress).map_err(|found| self.failed(found))
    }

    pub(super) fn failed(&self, (arc, error): (usize, crate::fit::FitError)) -> JointError {
        self.arcs[arc].failed(error)
    }
}

/// Mean square of the whitened innovations at the values `own`; `None` where they cannot be
/// computed.
fn chi2_per_row(session: &EstimationSession<'_>, own: &[f64]) -> Option<f64> {
    let linearised = LinearisedProblem::new(session, &session.problem.plant, own, &session.noise).ok()?;
    let normal = linearised.normal(session, own, &session.noise, &[])?;
    Some(normal.chi2 / linearised.samples().max(1) as f64)
}

/// Mean square of the whitened innovations of an arc that was not fitted: the vehicle's numbers are
/// those of `fit`, only what belongs to the arc alone (its biases, its clock) is estimated from it.
///
/// # Errors
/// Those of [`Vehicle::new`] and [`identify`].
pub fn predict(vehicle: &Vehicle<'_>, fit: &JointFit, arc: &Arc) -> Result<f64, JointError> {
    let alone = [arc.clone()];
    let predicted = Vehicle::new(&alone, vehicle.threads, vehicle.work.clone())?;
    let of_fit = |name: &str| vehicle.unknowns.iter().position(|known| known.name == name).map(|at| fit.theta[at]);
    let theta = predicted.unknowns.iter().map(|unknown| of_fit(&unknown.name).unwrap_or(unknown.prior)).collect();
    // what no fitted arc has stays at its prior, too: a prediction takes nothing of the vehicle
    let free = predicted.unknowns.iter().map(|unknown| unknown.own.is_some()).collect();
    let before = Knowledge::of_priors(predicted.unknowns.len());
    let part = Part { session: &predicted.sessions[0], places: &predicted.places[0], arc: 0 };
    let stage = Stage { unknowns: &predicted.unknowns, parts: vec![part], before: &before, free };
    let ended = stage.maximise(theta, ROUNDS_OF_A_WINDOW, &mut |_| {}).map_err(|found| predicted.failed(found))?;
    Ok(ended.messages[0].chi2 / ended.messages[0].rows.max(1) as f64)
}
