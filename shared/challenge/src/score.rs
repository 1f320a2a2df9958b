//! Answers against truths: the figures of the published table.
//!
//! - False alarm: a null with right noise answered by anything but `none`; one with wrong noise by
//!   physics or a sensor (`named`, `not_separable`, `sensor`, `not_in_catalogue`). `cannot_decide`
//!   on wrong noise is no alarm, nor is `not_in_catalogue` beside a remainder that no law makes.
//! - Detected: a verdict of those four. Power is that of single and masked cases; ideal
//!   `Φ(d − z_m)`, z_m two-sided at [`ALPHA`] over the tool's number of hypotheses: the tested laws
//!   times the points of the hidden law's grid (if that law was tested, else entries times sites of
//!   the plant); besides, that of a test without grids, over entries times sites.
//! - First name and set: single and masked cases of d ≥ 8 that were detected. Ideal
//!   `Φ(d √((1 − ρ)/2))`, ρ towards the nearest entry of the bench's menu (the catalogue has more
//!   entries: again a little high).
//! - Set: first name and rivals with a weight of [`IN_SET`](crate::answer::IN_SET) or more.
//! - Effect outside the catalogue, d ≥ 15: abstained are `not_in_catalogue` and `cannot_decide`; a
//!   false identification has a probability above 0.9.
//! - Pairs: both effects are identified and held-out data reject neither.
//! - Masked: the estimate of the biased parameter lies within two of its sigmas of the truth.
//! - Held out: of first names, right or wrong, of d ≥ 7 on the held-out recording, those confirmed.
//! - Brier: mean of (probability of the first name − it is right)² over all cases with an
//!   identified effect.

use crate::answer::{Answer, Name};
use crate::case::{Class, Truth};
use crate::disturb::NoiseKind;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// The tool's budget of false findings per recording.
pub const ALPHA: f64 = 2e-3;
/// Edges of the bins of d.
const EDGES: [f64; 8] = [0.0, 4.0, 5.5, 7.0, 9.0, 13.0, 25.0, 100.0];

/// Detections of the cases with `d_low ≤ d < d_high`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Power {
    pub d_low: f64,
    pub d_high: f64,
    pub n: usize,
    pub detected: usize,
    /// Expected number of detections by an ideal test with the tool's grids, and by one without
    /// grids.
    pub ideal: f64,
    pub ideal_without_grids: f64,
}

/// Cases whose effect is outside the catalogue.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LeaveOneOut {
    pub n: usize,
    pub abstained: usize,
    pub false_name: usize,
}

/// Cases with two effects.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Pairs {
    pub n: usize,
    pub both_named: usize,
}

/// Cases in which a nominal parameter absorbs the effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Masked {
    pub n: usize,
    pub corrected: usize,
}

/// The figures, keys as published. `None` where there is no such case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    pub cases: usize,
    pub nulls: usize,
    pub false_alarms: usize,
    pub power: Vec<Power>,
    pub first_name_share_d8: Option<f64>,
    pub in_set_share_d8: Option<f64>,
    pub ideal_first_name_share_d8: Option<f64>,
    pub set_size_median: Option<f64>,
    pub leave_one_out: LeaveOneOut,
    pub pairs: Pairs,
    pub masked: Masked,
    pub iou_median: Option<f64>,
    pub parameter_z_rms: Option<f64>,
    pub parameter_z_below_2_share: Option<f64>,
    pub heldout_confirmed_share: Option<f64>,
    pub brier: Option<f64>,
}

/// One opened case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Opened {
    pub truth: Truth,
    pub digest: String,
    pub answer: Answer,
    /// Seconds of drawing and of diagnosis, by the clock of the caller.
    pub seconds: [f64; 2],
}

fn phi(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// Two-sided threshold \[sigma\] of an ideal test of that many hypotheses at [`ALPHA`].
#[must_use]
pub fn z_m(chances: f64) -> f64 {
    Normal::standard().inverse_cdf(1.0 - ALPHA / (2.0 * chances.max(1.0)))
}

/// Number of hypotheses of the tool for the hidden effect.
fn chances(opened: &Opened) -> f64 {
    let hidden = opened.truth.effects.first();
    let own = hidden.and_then(|hidden| opened.answer.chances(&hidden.kind, &hidden.site));
    own.unwrap_or(opened.truth.candidates as f64)
}

/// A null that the tool does not answer with `none`; with wrong noise, a null answered by a
/// detection.
#[must_use]
pub fn is_false_alarm(truth: &Truth, answer: &Answer) -> bool {
    truth.class == Class::Null
        && match truth.noise {
            NoiseKind::Right => !answer.is("none"),
            NoiseKind::Remainder => answer.detects() && !answer.is("not_in_catalogue"),
            _ => answer.detects(),
        }
}

/// The first name is the hidden effect at its site.
#[must_use]
pub fn first_is_right(opened: &Opened) -> bool {
    opened.answer.set().first().is_some_and(|name| matches(&opened.truth, name.0, name.1))
}

fn matches(truth: &Truth, kind: &str, site: &str) -> bool {
    truth.effects.iter().any(|hidden| hidden.kind == kind && hidden.site == site)
}

fn d_of(opened: &Opened) -> f64 {
    opened.truth.d.first().copied().unwrap_or(0.0)
}

fn share(list: &[bool]) -> Option<f64> {
    (!list.is_empty()).then(|| list.iter().filter(|x| **x).count() as f64 / list.len() as f64)
}

fn mean(list: &[f64]) -> Option<f64> {
    (!list.is_empty()).then(|| list.iter().sum::<f64>() / list.len() as f64)
}

/// Half the sum of the two in the middle, by which published scores were made: the interpolation of
/// `estimation::quantiles` can differ in the last bit. `None` of an empty list.
fn median(mut list: Vec<f64>) -> Option<f64> {
    list.sort_by(f64::total_cmp);
    let n = list.len();
    (n > 0).then(|| 0.5 * (list[(n - 1) / 2] + list[n / 2]))
}

/// The figures of all cases.
#[must_use]
pub fn score(all: &[Opened]) -> Score {
    let of = |class: Class| all.iter().filter(move |o| o.truth.class == class);
    let known = || all.iter().filter(|o| matches!(o.truth.class, Class::Single | Class::Masked));
    let clear: Vec<&Opened> = known().filter(|o| d_of(o) >= 8.0 && o.answer.detects()).collect();
    let named: Vec<&&Opened> = clear.iter().filter(|o| !o.answer.set().is_empty()).collect();
    let in_set = |o: &Opened| o.answer.set().iter().any(|(kind, site, _)| matches(&o.truth, kind, site));
    let ideal = |o: &Opened| phi(d_of(o) * ((1.0 - o.truth.rho) / 2.0).max(0.0).sqrt());
    let errors: Vec<f64> = known().filter(|o| first_is_right(o)).filter_map(parameter_z).collect();
    let answered: Vec<&Opened> = all.iter().filter(|o| !o.answer.set().is_empty()).collect();
    let brier = |o: &&Opened| {
        let right = if first_is_right(o) { 1.0 } else { 0.0 };
        (o.answer.set()[0].2 - right) * (o.answer.set()[0].2 - right)
    };
    let with_held_out: Vec<&Opened> =
        known().filter(|o| o.truth.held_out_d >= 7.0 && !o.answer.set().is_empty()).collect();
    let confirmed: Vec<bool> = with_held_out.iter().map(|o| o.answer.names[0].status == "confirmed").collect();
    Score {
        cases: all.len(),
        nulls: of(Class::Null).count(),
        false_alarms: all.iter().filter(|o| is_false_alarm(&o.truth, &o.answer)).count(),
        power: power(&known().collect::<Vec<_>>()),
        first_name_share_d8: share(&clear.iter().map(|o| first_is_right(o)).collect::<Vec<_>>()),
        in_set_share_d8: share(&clear.iter().map(|o| in_set(o)).collect::<Vec<_>>()),
        ideal_first_name_share_d8: mean(&clear.iter().map(|o| ideal(o)).collect::<Vec<_>>()),
        set_size_median: median(named.iter().map(|o| o.answer.set().len() as f64).collect()),
        leave_one_out: left_out(of(Class::LeftOut)),
        pairs: pairs(of(Class::Pair)),
        masked: masked(of(Class::Masked)),
        iou_median: median(known().filter(|o| o.answer.detects()).filter_map(iou).collect()),
        parameter_z_rms: mean(&errors.iter().map(|z| z * z).collect::<Vec<_>>()).map(f64::sqrt),
        parameter_z_below_2_share: share(&errors.iter().map(|z| z.abs() < 2.0).collect::<Vec<_>>()),
        heldout_confirmed_share: share(&confirmed),
        brier: mean(&answered.iter().map(brier).collect::<Vec<_>>()),
    }
}

fn power(known: &[&Opened]) -> Vec<Power> {
    let bin = |edges: &[f64]| {
        let here: Vec<&&Opened> = known.iter().filter(|o| d_of(o) >= edges[0] && d_of(o) < edges[1]).collect();
        let ideal = |chances: &dyn Fn(&Opened) -> f64| here.iter().map(|o| phi(d_of(o) - z_m(chances(o)))).sum();
        let detected = here.iter().filter(|o| o.answer.detects()).count();
        let ideals = [ideal(&chances), ideal(&|o| o.truth.candidates as f64)];
        let [ideal, ideal_without_grids] = ideals;
        Power { d_low: edges[0], d_high: edges[1], n: here.len(), detected, ideal, ideal_without_grids }
    };
    EDGES.windows(2).map(bin).collect()
}

fn left_out<'a>(cases: impl Iterator<Item = &'a Opened>) -> LeaveOneOut {
    cases.filter(|o| d_of(o) >= 15.0).fold(LeaveOneOut::default(), |sum, o| {
        let abstained = o.answer.is("not_in_catalogue") || o.answer.is("cannot_decide");
        let sure = o.answer.set().first().is_some_and(|(kind, site, p)| *p > 0.9 && !matches(&o.truth, kind, site));
        LeaveOneOut {
            n: sum.n + 1,
            abstained: sum.abstained + usize::from(abstained),
            false_name: sum.false_name + usize::from(sure && !abstained),
        }
    })
}

fn pairs<'a>(cases: impl Iterator<Item = &'a Opened>) -> Pairs {
    let strong = |o: &&Opened| o.truth.d.len() == 2 && o.truth.d.iter().all(|d| *d >= 10.0);
    cases.filter(strong).fold(Pairs::default(), |sum, o| {
        let found = |hidden: &crate::hidden::Hidden| {
            let is_it = |name: &Name| name.kind == hidden.kind && name.site == hidden.site && name.status != "rejected";
            o.answer.names.iter().any(is_it)
        };
        let both = o.answer.detects() && o.truth.effects.iter().all(found);
        Pairs { n: sum.n + 1, both_named: sum.both_named + usize::from(both) }
    })
}

fn masked<'a>(cases: impl Iterator<Item = &'a Opened>) -> Masked {
    cases
        .filter_map(|o| Some((o, o.truth.biased.as_ref()?)))
        .filter(|(_, biased)| biased.shift_sigma.abs() >= 2.0)
        .fold(Masked::default(), |sum, (o, biased)| {
            let found = o.answer.nominal.iter().find(|(name, ..)| *name == biased.name);
            let near = found.is_some_and(|(_, after, sigma)| (after - biased.truth).abs() <= 2.0 * sigma);
            Masked { n: sum.n + 1, corrected: sum.corrected + usize::from(near) }
        })
}

/// Error of the amplitude in its sigma.
fn parameter_z(opened: &Opened) -> Option<f64> {
    let hidden = opened.truth.effects.first()?;
    let (name, truth) = hidden.values.first()?;
    let first = opened.answer.names.first()?;
    let (_, value, sigma) = first.parameters.iter().find(|(n, ..)| n == name || n.ends_with(&format!(".{name}")))?;
    (*sigma > 0.0).then(|| (value - truth) / sigma)
}

/// Intersection over union of times, on the right channel; zero on another.
fn iou(opened: &Opened) -> Option<f64> {
    let (channel, [begin, end]) = opened.truth.window.as_ref()?;
    let best = opened.answer.located.iter().filter(|(name, _)| name == channel).map(|(_, [a, b])| {
        let both = (b.min(*end) - a.max(*begin)).max(0.0);
        both / (b.max(*end) - a.min(*begin)).max(1e-12)
    });
    Some(best.fold(0.0, f64::max))
}

#[cfg(test)]
mod tests;
