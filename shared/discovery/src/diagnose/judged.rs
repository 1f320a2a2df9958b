//! What held-out data say of what was found: which of several names they favour, and what each effect of a set adds to the others.
//!
//! An effect is confirmed on its own where the set predicts better with it than without it, the others fitted again. What they refuse beside the
//! others leaves; what they do not decide keeps its name and stays out of the model.

use super::search::Found;
use super::showing::{Shown, held_out};
use super::{Adopted, Options, RIVAL_SPAN, Standing, status};
use crate::compete::Refit;
use crate::compete::subsets::TIE;
use crate::fit::{Engine, Fit};
use crate::held_out::{Gain, Status};
use crate::problem::Problem;

/// Probability that an effect that adds nothing is refused or confirmed beside the others.
const LEVEL: f64 = 0.05;

/// What held-out data say of a set of effects, and of each.
pub(super) struct Judged {
    /// Of the model.
    pub shown: Shown,
    /// Of what is named, in its order.
    pub status: Vec<Status>,
    /// The plant with what is confirmed on its own, where the set is.
    pub model: Standing,
    /// What left, with the plant that had it.
    pub refused: Vec<(Adopted, Standing)>,
}

/// The plant without one of its effects, and what held-out data gain by it.
struct Part {
    without: Standing,
    gain: Gain,
}

/// A recording, the nominal plant and how to ask.
struct Asking<'a> {
    problem: &'a Problem,
    engine: &'a Engine<'a>,
    stated: &'a Fit,
    options: &'a Options,
}

/// Held-out data on what was found, which is left with what they do not refuse.
pub(super) fn judged(
    problem: &Problem,
    (engine, stated): (&Engine<'_>, &Fit),
    found: &mut Found,
    options: &Options,
    notes: &mut Vec<String>,
) -> Judged {
    let asking = Asking { problem, engine, stated, options };
    let mut shown = borne_out(&asking, found, notes);
    let mut refused = Vec::new();
    let mut parts = asking.parts(&found.best, &found.adopted);
    while let Some(place) = worst(&parts, |gain, count| gain.interval(LEVEL / count)[1] < 0.0) {
        let Some(part) = parts.swap_remove(place) else { break };
        let gone = found.adopted.remove(place);
        notes.push(format!(
            "held-out data refuse {} beside {}",
            named(core::slice::from_ref(&gone)),
            named(&found.adopted)
        ));
        refused.push((gone, core::mem::replace(&mut found.best, part.without)));
        found.unknown_noise = 0.0;
        shown = asking.held_out(&found.best, false);
        parts = asking.parts(&found.best, &found.adopted);
    }
    let of_all = status(shown.gain.as_ref());
    let mut judged = Judged { shown, status: vec![of_all; found.adopted.len()], model: found.best.clone(), refused };
    if of_all != Status::Refused {
        judged.confirm_each(&asking, &found.adopted, parts);
    }
    judged
}

impl Judged {
    /// What adds nothing that is certain leaves the model, the least first, where the rest is confirmed.
    fn confirm_each(&mut self, asking: &Asking<'_>, adopted: &[Adopted], mut parts: Vec<Option<Part>>) {
        let (mut model, mut status) = (None, self.status.clone());
        let mut left: Vec<usize> = (0..adopted.len()).collect();
        while let Some(place) = worst(&parts, |gain, _| gain.interval(LEVEL)[0] <= 0.0) {
            let Some(part) = parts.swap_remove(place) else { break };
            status[left.remove(place)] = Status::Unconfirmed;
            let others: Vec<Adopted> = left.iter().map(|place| adopted[*place].clone()).collect();
            parts = asking.parts(&part.without, &others);
            model = Some(part.without);
        }
        let Some(model) = model else { return };
        let shown = asking.held_out(&model, false);
        // else they are confirmed together and none alone
        if super::status(shown.gain.as_ref()) == Status::Confirmed {
            (self.model, self.status, self.shown) = (model, status, shown);
        }
    }
}

/// The part that gains least of those that are `meant`, by their gains and the number of parts.
fn worst(parts: &[Option<Part>], meant: impl Fn(&Gain, f64) -> bool) -> Option<usize> {
    let all = parts.iter().enumerate().filter_map(|(place, part)| Some((place, part.as_ref()?.gain)));
    let those = all.filter(|(_, gain)| meant(gain, parts.len() as f64));
    those.min_by(|a, b| a.1.loglik_gain.total_cmp(&b.1.loglik_gain)).map(|(place, _)| place)
}

impl Asking<'_> {
    fn held_out(&self, best: &Standing, nothing: bool) -> Shown {
        held_out(self.problem, self.engine, self.stated, best, nothing, self.options)
    }

    /// Each of `adopted` on its own, where it is one of several.
    ///
    /// Cost: a fit and a prediction each.
    fn parts(&self, best: &Standing, adopted: &[Adopted]) -> Vec<Option<Part>> {
        let several = adopted.len() > 1;
        adopted.iter().map(|own| several.then(|| self.part(best, own)).flatten()).collect()
    }

    fn part(&self, best: &Standing, own: &Adopted) -> Option<Part> {
        let without = Standing::of(&Refit::from(best.clone()).without(self.engine, &own.column)?);
        let engine = Engine::like(self.engine, &without.problem).ok()?;
        let gain = held_out(&without.problem, &engine, &without.fit, best, false, self.options).gain?;
        drop(engine);
        Some(Part { without, gain })
    }
}

fn named(set: &[Adopted]) -> String {
    set.iter().map(|own| own.column.candidate.effect.kind).collect::<Vec<_>>().join(" and ")
}

/// Held-out data on what was found. Another recording is evidence on names, too: the rival that both recordings together favour, each law under its
/// own noise, takes the place of what this one favours, and any that is confirmed the place of what is not; else the nearest smaller set
/// that they confirm or at least find better. Weights stay those of this recording: of laws that only come near the truth another one makes too sure.
fn borne_out(asking: &Asking<'_>, found: &mut Found, notes: &mut Vec<String>) -> Shown {
    let shown = favoured(asking, found, notes);
    no_more_than_borne(asking, found, shown, notes)
}

/// A set that was judged: by how much it is behind in BIC on this recording, its log-likelihood on the other, zero without one.
struct Heard {
    behind: f64,
    loglik: f64,
    numbers: Vec<Number>,
}

/// Name, value and standard deviation of one of the plant's numbers.
type Number = (String, f64, f64);

impl Heard {
    fn new(standing: &Standing, behind: f64, loglik: f64) -> Self {
        let fit = &standing.fit;
        let unknowns = standing.problem.unknowns.iter().map(|unknown| unknown.name.clone());
        let numbers = unknowns.zip(&fit.theta).zip(&fit.sigma).map(|((name, theta), sigma)| (name, *theta, *sigma));
        Self { behind, loglik, numbers: numbers.collect() }
    }

    /// By how much `self` is behind `other` in BIC, both recordings together.
    fn behind(&self, other: &Self) -> f64 {
        self.behind - other.behind - 2.0 * (self.loglik - other.loglik)
    }
}

/// The set of rivals that both recordings favour; its numbers are as uncertain as its name is.
fn favoured(asking: &Asking<'_>, found: &mut Found, notes: &mut Vec<String>) -> Shown {
    let mut shown = asking.held_out(&found.best, found.adopted.is_empty());
    let mut heard = vec![Heard::new(&found.best, 0.0, shown.loglik.unwrap_or(0.0))];
    let mut first = 0;
    let rivals = core::mem::take(&mut found.rivals);
    // the best of several confirmations is one by chance more often
    let alpha = LEVEL / rivals.len().max(1) as f64;
    for (set, standing, behind) in rivals {
        let is_confirmed = status(shown.gain.as_ref()) == Status::Confirmed;
        if is_confirmed && shown.loglik.is_none() {
            heard.push(Heard::new(&standing, behind, 0.0));
            continue;
        }
        let again = asking.held_out(&standing, false);
        // one that fails there says nothing
        let Some(loglik) = again.loglik.or(shown.loglik.is_none().then_some(0.0)) else { continue };
        heard.push(Heard::new(&standing, behind, loglik));
        let is_ahead = again.loglik.is_some() && heard[heard.len() - 1].behind(&heard[first]) < -TIE;
        let bears = again.gain.as_ref().is_some_and(|gain| gain.interval(alpha)[0] > 0.0);
        // of two that nothing confirms the better predicted one, too
        if (bears || !is_confirmed) && is_ahead || bears && !is_confirmed {
            let word = if bears && !is_confirmed { "confirm" } else { "are better predicted by" };
            notes.push(format!("held-out data {word} {}, not {}", named(&set), named(&found.adopted)));
            first = heard.len() - 1;
            (found.adopted, found.best, found.unknown_noise, shown) = (set, standing, 0.0, again);
        }
    }
    widen(&mut found.best, &heard, first);
    shown
}

/// Standard deviations over all sets that are not excluded: names that cannot be told apart leave the plant's numbers where any of them has them.
fn widen(best: &mut Standing, heard: &[Heard], first: usize) {
    let own = &heard[first];
    let others = heard.iter().enumerate().filter(|(i, _)| *i != first).map(|(_, other)| (other, other.behind(own)));
    let others: Vec<(&Heard, f64)> = others.filter(|(_, behind)| *behind <= RIVAL_SPAN).collect();
    let fit = &mut best.fit;
    for ((unknown, theta), sigma) in best.problem.unknowns.iter().zip(&fit.theta).zip(&mut fit.sigma) {
        let (mut whole, mut variance) = (1.0, *sigma * *sigma);
        for (other, behind) in &others {
            let Some((_, value, spread)) = other.numbers.iter().find(|(name, ..)| *name == unknown.name) else {
                continue;
            };
            let weight = libm::exp(-0.5 * behind.max(0.0));
            whole += weight;
            variance += weight * (spread * spread + (value - theta) * (value - theta));
        }
        *sigma = (variance / whole).sqrt();
    }
}

/// The nearest smaller set where held-out data do not bear all of `found`: a term that they do not bear takes no other with it.
fn no_more_than_borne(asking: &Asking<'_>, found: &mut Found, mut shown: Shown, notes: &mut Vec<String>) -> Shown {
    for (set, standing) in core::mem::take(&mut found.smaller) {
        if found.adopted.is_empty() || status(shown.gain.as_ref()) == Status::Confirmed {
            break;
        }
        let again = asking.held_out(&standing, false);
        let gain = |shown: &Shown| shown.gain.as_ref().map_or(f64::NEG_INFINITY, |gain| gain.loglik_gain);
        let is_confirmed = status(again.gain.as_ref()) == Status::Confirmed;
        if is_confirmed || gain(&again) > gain(&shown) {
            let word = if is_confirmed { "confirm" } else { "are better predicted by" };
            notes.push(format!(
                "held-out data {word} {} of {} effects that this recording asks for",
                set.len(),
                found.adopted.len()
            ));
            (found.adopted, found.best, found.unknown_noise, shown) = (set, standing, 0.0, again);
        }
    }
    shown
}

#[cfg(test)]
mod tests;
