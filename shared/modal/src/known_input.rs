//! Modes of a record with known input: search, choice of the direct term, and whether any model of
//! the kind is right.
//!
//! The first search starts from subspace poles ([`fit_of_any_order`]). If residuals that are not
//! white, or feedback of the output into the input, put it in doubt, modes are added one by one
//! from a matched scan. If no model of known input and white sensor noise is right, a disturbance
//! may act on the structure: the innovations form then has its say. If that is not right either,
//! the answer is a candidate, and says so.

mod lags;

use crate::adequacy::{self, Residual, chi_square_tail};
use crate::innovations;
use crate::maximum_likelihood::scan::{other, scan};
use crate::maximum_likelihood::{Feedthrough, Fit, MlError, Model, Outputs, fit};
use crate::model_order::{criterion, fit_of_any_order, resolved};
use crate::projection::{Basis, dot};
use crate::record::Record;

/// Poles of the scan that are tried for one more mode.
const PEAKS: usize = 2;
/// Modes added in vain before the search ends: two close modes may only pay together.
const ADDITIONS_IN_VAIN: usize = 1;
/// Probability below which the innovations form is rejected: one right answer in twenty is
/// withheld, for here the disturbance already contradicts the plain model.
const DISTURBED_LEVEL: f64 = 0.05;
/// Modes of the innovations form at most: its unknowns grow with modes times channels.
const MODES_OF_INNOVATIONS: usize = 6;
/// Samples of the past that predict the input in the test for feedback: a controller with
/// derivative and filter has two or three.
const PAST: usize = 4;
/// Ratio of standard deviations with and without a disturbance from which on the assumption counts.
/// The test of the residuals sees a disturbance that moves an estimate by four of the larger
/// sigmas; what it does not see moves it by up to `4 · CONDITIONAL` of the smaller, so the ratio is
/// as small as it can be without a word on records whose references tell plant and controller
/// apart.
const CONDITIONAL: f64 = 3.0;
/// Part of an input's power that counts as rounding of its digits in a text file.
const INPUT_ROUNDING: f64 = 1e-12;
/// Probability that feedback is seen where there is none. It only makes the search longer.
const FEEDBACK_LEVEL: f64 = 1e-3;

/// What generates the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Sensors alone, white: output error.
    OfSensors,
    /// A disturbance that moves the modes, and sensors: one-step predictions are white.
    Innovations,
}

/// Modes with the model they belong to.
#[derive(Clone, Debug)]
pub struct Identified {
    pub fit: Fit,
    pub model: Model,
    pub noise: Noise,
    /// Test of the residuals.
    pub residual: Residual,
    /// Past residuals predict the input: a controller feeds the measurement back.
    pub feedback: bool,
    /// The record does not contradict the model; otherwise the modes are candidates without
    /// standard deviations.
    pub adequate: bool,
    /// Under feedback, what the standard deviations of f \[Hz\] and ζ would be if a disturbance
    /// also acted on the structure, mode by mode; sensor noise alone is an assumption that such a
    /// record tests only as well as these are small.
    pub if_disturbed: Option<Vec<(f64, f64)>>,
    /// Samples by which each channel is late against the input; empty if all are in step.
    pub lags: Vec<isize>,
}

impl Identified {
    /// Whether the result stands and falls with the assumption that nothing but the input moves the
    /// structure: without it a standard deviation would be more than `CONDITIONAL` times as
    /// large.
    #[must_use]
    pub fn assumes_no_disturbance(&self) -> bool {
        let far = |(k, sd): (usize, &(f64, f64))| {
            let (f, zeta, _) = self.fit.variances(k);
            sd.0 > CONDITIONAL * f.sqrt() || sd.1 > CONDITIONAL * zeta.sqrt()
        };
        self.if_disturbed.as_ref().is_some_and(|all| all.iter().enumerate().any(far))
    }
}

/// What is tried on one record.
struct Search<'a> {
    record: &'a Record,
    outputs: Outputs,
    modes_max: usize,
}

/// The modes of `record`, at most `modes_max`.
///
/// `accelerations`: an output may answer the input at the same sample. If feedback is seen and both
/// direct terms suit, that at the next sample is taken, which is right with and without a loop.
///
/// # Errors
/// [`MlError`] when no number of modes can be fitted.
///
/// Cost: of a record whose first model is right and that shows no feedback, one more fit from its
/// poles.
pub fn identify(record: &Record, model: Model, accelerations: bool, modes_max: usize) -> Result<Identified, MlError> {
    let found = output_error(record, model, accelerations, modes_max)?;
    if found.adequate {
        return Ok(found);
    }
    let outputs = Outputs::new(record);
    if let Some(lags) = lags::lags(record, found.model, &outputs, &found.fit.poles) {
        let again = output_error(&lags::in_step(record, &lags), model, accelerations, modes_max);
        if let Some(again) = again.ok().filter(|again| again.adequate) {
            return Ok(Identified { lags, ..again });
        }
    }
    let disturbed = Search { record, outputs, modes_max }.innovations(found.model);
    Ok(disturbed.map_or(found.clone(), |disturbed| Identified { feedback: found.feedback, ..disturbed }))
}

/// The best model of known input and white sensor noise, right or not.
fn output_error(record: &Record, model: Model, accelerations: bool, modes_max: usize) -> Result<Identified, MlError> {
    let search = Search { record, outputs: Outputs::new(record), modes_max };
    let same = Model { feedthrough: Feedthrough::SameSample, ..model };
    let next = other(same);
    let first = search.first(same);
    let mut tried = Vec::new();
    if let Ok(first) = &first {
        tried.push(search.examined(first.clone(), same));
        tried.extend(fit(record, next, &first.poles).ok().map(|fit| search.examined(fit, next)));
    }
    let mut feedback = tried.iter().any(|found| search.feeds_back(&found.fit));
    if !feedback && let Some(best) = search.best(&tried, |found| found.adequate) {
        return Ok(best);
    }
    tried.extend(search.forward(next).into_iter().map(|fit| search.examined(fit, next)));
    feedback |= tried.last().is_some_and(|found| search.feeds_back(&found.fit));
    let deviations =
        |found: &Identified| innovations::deviations(record, found.model, &search.outputs, &found.fit.poles);
    let marked = |found: Identified| Identified {
        feedback,
        if_disturbed: feedback.then(|| deviations(&found)).flatten(),
        ..found
    };
    if let Some(best) = search.best(&tried, |found| found.adequate && found.model == next) {
        return Ok(marked(best));
    }
    let either = accelerations || !feedback;
    if either && search.best(&tried, |found| found.adequate).is_none() {
        tried.extend(search.forward(same).into_iter().map(|fit| search.examined(fit, same)));
    }
    if let Some(best) = search.best(&tried, |found| found.adequate && either) {
        return Ok(marked(best));
    }
    let shown = search.best(&tried, |found| found.model == next || either).or_else(|| search.best(&tried, |_| true));
    let shown = shown.map(|found| Identified { feedback, adequate: false, ..found });
    shown.ok_or(first.err().unwrap_or(MlError::NoStart { found: 0, asked: 1 }))
}

impl Search<'_> {
    /// From subspace poles; of a record with absent rows, of which there are none, from the scan.
    fn first(&self, model: Model) -> Result<Fit, MlError> {
        if self.outputs.present.len() == self.outputs.samples {
            return fit_of_any_order(self.record, model, self.modes_max);
        }
        let path = self.forward(model);
        self.smallest(path, model).ok_or(MlError::NoStart { found: 0, asked: 1 })
    }

    /// One fit for each number of modes, each from the last and the best of the scan beside it.
    fn forward(&self, model: Model) -> Vec<Fit> {
        let (mut path, mut smallest, mut in_vain): (Vec<Fit>, f64, usize) = (Vec::new(), f64::INFINITY, 0);
        while path.len() < self.modes_max && in_vain <= ADDITIONS_IN_VAIN {
            let poles = path.last().map_or(Vec::new(), |fit: &Fit| fit.poles.clone());
            let peaks = scan(self.record, model, &self.outputs, &poles, PEAKS);
            let fits = peaks.into_iter().filter_map(|peak| {
                let start: Vec<_> = poles.iter().copied().chain([peak]).collect();
                let nyquist = std::f64::consts::PI * self.record.sample_rate_hz;
                fit(self.record, model, &start).ok().filter(|fit| fit.poles.iter().all(|pole| pole.im < nyquist))
            });
            let Some((score, found)) =
                fits.map(|fit| (self.criterion(&fit, model), fit)).min_by(|a, b| a.0.total_cmp(&b.0))
            else {
                break;
            };
            in_vain = if score < smallest && resolved(&found) { 0 } else { in_vain + 1 };
            smallest = smallest.min(score);
            path.push(found);
        }
        path
    }

    fn criterion(&self, fit: &Fit, model: Model) -> f64 {
        criterion(&self.outputs, self.record.inputs, model, fit)
    }

    fn smallest(&self, fits: Vec<Fit>, model: Model) -> Option<Fit> {
        let scored = fits.into_iter().filter(resolved).map(|fit| (self.criterion(&fit, model), fit));
        scored.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, fit)| fit)
    }

    fn examined(&self, fit: Fit, model: Model) -> Identified {
        let residual = adequacy::examine(self.record, model, &self.outputs, &fit.poles);
        let (noise, adequate) = (Noise::OfSensors, residual.white);
        Identified { fit, model, noise, residual, feedback: false, adequate, if_disturbed: None, lags: Vec::new() }
    }

    /// Of those that suit the one of the smallest criterion; the dampings of all its modes are
    /// significant, or, where no fit has such, positive: the criterion has seen the modes all the
    /// same.
    fn best(&self, of: &[Identified], suits: impl Fn(&Identified) -> bool) -> Option<Identified> {
        let score = |found: &Identified| self.criterion(&found.fit, found.model);
        let smallest = |of: Vec<&Identified>| of.into_iter().min_by(|a, b| score(a).total_cmp(&score(b))).cloned();
        let suit: Vec<&Identified> = of.iter().filter(|found| suits(found)).collect();
        let decays = |found: &Identified| (0..found.fit.poles.len()).all(|k| found.fit.damping_ratio(k) > 0.0);
        smallest(suit.iter().copied().filter(|found| resolved(&found.fit)).collect())
            .or_else(|| smallest(suit.into_iter().filter(|found| decays(found)).collect()))
    }

    /// Whether past residuals help to predict an input beyond its own past (Granger 1969):
    /// residuals of a right model in open loop are independent of every input.
    fn feeds_back(&self, fit: &Fit) -> bool {
        let (record, samples) = (self.record, self.outputs.samples);
        if samples < 10 * PAST * (record.inputs + record.channels + 1) {
            return false;
        }
        let rows = samples - PAST;
        let past = |series: &[f64]| -> Vec<f64> {
            (1..=PAST).flat_map(|lag| series[PAST - lag..samples - lag].to_vec()).collect()
        };
        let inputs: Vec<Vec<f64>> =
            (0..record.inputs).map(|m| record.input.iter().skip(m).step_by(record.inputs).copied().collect()).collect();
        let own = Basis::new([vec![1.0; rows], inputs.iter().flat_map(|u| past(u)).collect()].concat(), rows);
        let mut heard: Vec<f64> = fit.residuals.iter().flat_map(|e| past(e)).collect();
        heard.chunks_exact_mut(rows).for_each(|column| {
            own.project_out(column);
        });
        let heard = Basis::new(heard, rows);
        inputs.iter().any(|u| {
            let mut now = u[PAST..].to_vec();
            let floor = INPUT_ROUNDING * dot(&now, &now);
            own.project_out(&mut now);
            let before = dot(&now, &now);
            let along = heard.along(&now);
            let left = (before - dot(&along, &along)).max(f64::MIN_POSITIVE);
            let statistic = rows as f64 * libm::log(before / left);
            before > floor && chi_square_tail(statistic, (PAST * record.channels) as f64) < FEEDBACK_LEVEL
        })
    }

    /// The innovations form, from modes that input and the innovations of a long autoregression
    /// drive together (Hannan & Rissanen 1982): the smallest criterion if its innovations are
    /// white.
    fn innovations(&self, model: Model) -> Option<Identified> {
        let driven = innovations::with_innovations(self.record, model, &self.outputs)?;
        let search = Search {
            record: &driven.record,
            outputs: Outputs::new(&driven.record),
            modes_max: self.modes_max.min(MODES_OF_INNOVATIONS),
        };
        let found = search
            .forward(model)
            .into_iter()
            .filter_map(|start| innovations::fit((self.record, &driven), model, &self.outputs, &start.poles));
        let (_, fit) = found.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let residual = adequacy::judged(&fit.residuals, [adequacy::ljung_box(&fit.residuals, &self.outputs)]);
        let noise = Noise::Innovations;
        let adequate = residual.p > DISTURBED_LEVEL && resolved(&fit);
        adequate.then_some(Identified {
            fit,
            model,
            noise,
            residual,
            feedback: false,
            adequate,
            if_disturbed: None,
            lags: Vec::new(),
        })
    }
}
