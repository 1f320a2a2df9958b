//! What one arc says where each arc has a keeper of its own, and messages travel.
//!
//! An arc is heard once through growing windows, from what the messages before it say; then it
//! answers with one message at every point of linearisation that is announced.

use super::fold::{Knowledge, Message};
use super::stage::{Part, Stage};
use super::{JointError, Vehicle};

/// Parts of each step of integration of a message that is folded. The first linearisation's steps
/// follow h ω = 0.4, where Runge–Kutta's amplitude is off by (h ω)⁶/144 = 3·10⁻⁵ a step; of halves
/// by 2⁻⁵ of that.
const STEP_PARTS: usize = 2;
/// Sets of sensitivities for the arc's own unknowns: a few biases and a clock, nearly linear.
const ROUNDS_OF_OWN: usize = 3;

impl Vehicle<'_> {
    /// Hears arc `arc` through growing windows from `theta`, with what is `known` before it (over
    /// all unknowns of the vehicle); where that ends, and what the arc says there.
    ///
    /// # Errors
    /// The plant cannot predict the arc; an interruption.
    ///
    /// Cost: some six sets of sensitivities of the arc.
    pub fn hear(&self, arc: usize, known: &Knowledge, mut theta: Vec<f64>) -> Result<(Vec<f64>, Message), JointError> {
        let message = self.heard(arc, known, &mut theta, &mut |_| {})?;
        Ok((theta, message))
    }

    /// What arc `arc` says at `theta`.
    ///
    /// # Errors
    /// The plant cannot predict the arc at `theta`.
    ///
    /// Cost: one set of sensitivities of the arc with halved steps.
    pub fn message(&self, arc: usize, theta: &[f64]) -> Result<Message, JointError> {
        let finer = self.sessions[arc].in_parts(STEP_PARTS).map_err(|error| self.arcs[arc].failed(error))?;
        let before = Knowledge::of_priors(self.unknowns.len());
        let parts = vec![Part { session: &finer, places: &self.places[arc], arc }];
        let stage = Stage { unknowns: &self.unknowns, parts, before: &before, free: vec![true; self.unknowns.len()] };
        let mut messages = stage.messages(theta).map_err(|found| self.failed(found))?;
        messages.pop().ok_or(JointError::NotPositive)
    }

    /// `theta` with what belongs to arc `arc` alone estimated from it; all else stays.
    ///
    /// # Errors
    /// The plant cannot predict the arc at `theta`.
    pub fn own_settled(&self, arc: usize, theta: Vec<f64>) -> Result<Vec<f64>, JointError> {
        let free = self.unknowns.iter().map(|unknown| unknown.own == Some(arc)).collect();
        let before = Knowledge::of_priors(self.unknowns.len());
        let parts = vec![Part { session: &self.sessions[arc], places: &self.places[arc], arc }];
        let stage = Stage { unknowns: &self.unknowns, parts, before: &before, free };
        let ended = stage.maximise(theta, ROUNDS_OF_OWN, &mut |_| {}).map_err(|found| self.failed(found))?;
        Ok(ended.theta)
    }
}
