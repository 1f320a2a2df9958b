//! Estimates that lie further from their priors than the priors allow: a prior is wrong, or the
//! likelihood was climbed at the wrong of its optima.

use estimation::identifiability::Identifiability;
use identification::statistics::normal_tail;
use serde_json::{Value, json};
use std::fmt::Write;

/// In one of so many estimates of right priors a conflict is reported all the same.
const FALSE_CONFLICTS: f64 = 0.01;

/// A parameter whose estimate contradicts its prior.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    pub name: String,
    /// Distance of the estimate from its prior over the standard deviation of that distance.
    pub distance_sigma: f64,
    /// How often the most distant of all parameters lies as far off.
    pub p: f64,
}

/// Of parameters, each with estimate and sigma, prior and sigma, those in conflict.
///
/// The estimate θ̂ folds the prior θ₀ of covariance P₀ into its own P, so that θ̂ − θ₀ has the
/// variance P₀ − P where the prior is right and the likelihood is near normal. The level is shared
/// by all identified parameters (Bonferroni).
pub fn conflicts<'a>(parameters: impl Iterator<Item = (&'a str, [f64; 2], [f64; 2])>) -> Vec<Conflict> {
    let is_told = |one: &(&str, [f64; 2], [f64; 2])| {
        one.2[1] > 0.0 && matches!(Identifiability::of(one.1[1], one.2[1]), Identifiability::Identified)
    };
    let told: Vec<_> = parameters.filter(is_told).collect();
    let conflict = |&(name, [value, sigma], [prior, prior_sigma]): &(&str, [f64; 2], [f64; 2])| {
        let distance_sigma = (value - prior) / (prior_sigma * prior_sigma - sigma * sigma).sqrt();
        let p = (2.0 * normal_tail(distance_sigma.abs()) * told.len() as f64).min(1.0);
        Conflict { name: name.to_owned(), distance_sigma, p }
    };
    told.iter().map(conflict).filter(|one| one.p < FALSE_CONFLICTS).collect()
}

/// `prior_conflicts[]` of `--json`.
pub fn object(found: &[Conflict]) -> Value {
    let one = |one: &Conflict| json!({ "name": one.name, "distance_sigma": one.distance_sigma, "p": one.p });
    found.iter().map(one).collect()
}

/// A line for each, for a terminal.
pub fn in_words(found: &[Conflict]) -> String {
    let mut text = String::new();
    for Conflict { name, distance_sigma, p } in found {
        let _ = writeln!(
            text,
            "WARNING: {name} lies {:.1} sigma from its prior (p {p:.1e}): the prior is wrong, or this is not the \
             highest maximum; fix it by measurement, or start from other priors",
            distance_sigma.abs()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::conflicts;

    #[test]
    fn an_estimate_far_from_its_prior_is_a_conflict_and_the_more_parameters_there_are_the_later() {
        let row = |value: f64| ("mass", [value, 0.1], [10.0, 1.0]);
        let found = conflicts([row(14.2), row(11.0), row(8.5)].into_iter());
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].distance_sigma - 4.2 / 0.99_f64.sqrt()).abs() < 1e-12);
        assert!(conflicts(core::iter::repeat_n(row(13.2), 3)).len() == 3);
        assert!(conflicts(core::iter::repeat_n(row(13.2), 30)).is_empty());
    }

    #[test]
    fn what_is_known_exactly_and_what_keeps_its_prior_cannot_contradict_it() {
        assert!(
            conflicts([("exact", [9.0, 0.0], [10.0, 0.0]), ("kept", [90.0, 1.0], [10.0, 1.0])].into_iter()).is_empty()
        );
    }
}
