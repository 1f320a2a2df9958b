//! Models over a horizon, of which others are compared with one.

use crate::diagnose::Options;
use crate::evidence::horizon::{Compared, Horizons};
use crate::evidence::model::{Ground, Model};
use crate::evidence::noise::Linearly;
use crate::evidence::pool::{Entry, Pool};
use crate::evidence::predict::{HeldOut, explaining};
use identification::fit::EstimationSession;

/// Recordings, models, and what a user asks.
pub(super) type Setting<'a> = (&'a EstimationSession<'a>, &'a Pool, &'a Options);

/// A model of the pool over a horizon, which others are compared with.
pub(super) struct Compares<'a> {
    session: &'a EstimationSession<'a>,
    entry: &'a Entry,
    /// With what its parameters give a distance.
    predicted: Option<HeldOut>,
}

impl<'a> Compares<'a> {
    pub(super) fn new((session, pool, options): Setting<'a>, place: usize) -> Self {
        let entry = &pool.entries[place];
        let with_parameters =
            |own: &HeldOut| own.with_parameters(Ground { session }, options.held_out.as_ref()?, &entry.model);
        let predicted = entry.held_out.as_ref().map(|own| with_parameters(own).unwrap_or_else(|| own.clone()));
        Self { session, entry, predicted }
    }

    /// On held-out data, on the fitted ones where there are none.
    pub(super) fn beside(&self, before: &Entry) -> Option<Compared> {
        match (&self.predicted, &before.held_out) {
            (Some(own), Some(before)) => own.beside(before),
            _ => on_fitted(self.session, &self.entry.model, &before.model),
        }
    }
}

/// Free runs over a horizon of two models on the fitted recordings.
fn on_fitted(session: &EstimationSession<'_>, own: &Model, bare: &Model) -> Option<Compared> {
    let ground = Ground { session };
    let of = |model: &Model| {
        let session = model.session(ground)?;
        let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
        let linear = Linearly { session: &session, linearised, theta, extra: &[], room: &[] };
        let explaining = explaining(&linear, &model.noise, model.prior(ground.session))?;
        Horizons::new(&session, &linearised.linears, &model.noise, &explaining)
    };
    of(own)?.beside(&of(bare)?)
}
