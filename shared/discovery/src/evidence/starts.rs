//! Frequencies and orders at which a fit begins: their likelihoods have many maxima.

use super::hypothesis::{Hypothesis, InnerPrior, unknown_of};
use super::model::Model;
use super::pool::Pool;

/// Standard errors of a frequency or an order from which another start is another maximum.
const MODE_SIGMA: f64 = 5.0;

impl Pool {
    /// All fits of the set that are in the pool are far from these frequencies and orders.
    pub(super) fn is_another_maximum(&self, name: &str, numbers: &[SearchedNumber]) -> bool {
        let own = self.entries.iter().filter(|entry| entry.model.key() == name);
        let known: Vec<Vec<SearchedNumber>> = own.map(|entry| fitted_numbers(&entry.model)).collect();
        let is_far = |other: &SearchedNumber| {
            let own = numbers.iter().find(|own| own.name == other.name);
            own.is_some_and(|own| (own.value - other.value).abs() > MODE_SIGMA * other.sigma)
        };
        !numbers.is_empty() && known.iter().all(|mode| mode.iter().any(is_far))
    }
}

/// A frequency or an order of a set, by the name of its unknown.
pub(super) struct SearchedNumber {
    name: String,
    value: f64,
    sigma: f64,
}

fn searched_numbers(set: &[Hypothesis]) -> impl Iterator<Item = (String, f64)> {
    set.iter().flat_map(Hypothesis::parts).flat_map(|part| {
        let all = part.inner.iter().filter(|(_, prior)| matches!(prior, InnerPrior::LogUniform(_)));
        all.filter_map(|(name, _)| {
            let candidate = &part.column.candidate;
            let (_, value) = candidate.inner.iter().find(|(own, _)| own == name)?;
            Some((unknown_of(candidate, name), *value))
        })
    })
}

/// As they were fitted.
pub(super) fn fitted_numbers(model: &Model) -> Vec<SearchedNumber> {
    let all = searched_numbers(&model.set).filter_map(|(name, _)| {
        let at = model.problem.unknowns.iter().position(|unknown| unknown.parameter == name)?;
        Some(SearchedNumber { name, value: model.fit.theta[at], sigma: model.fit.sigma[at] })
    });
    all.collect()
}

/// As a fit that begins at `from` begins at them.
pub(super) fn starts(set: &[Hypothesis], from: &Model) -> Vec<SearchedNumber> {
    let known = fitted_numbers(from);
    let start = |(name, value): (String, f64)| {
        let value = known.iter().find(|own| own.name == name).map_or(value, |own| own.value);
        SearchedNumber { name, value, sigma: 0.0 }
    };
    searched_numbers(set).map(start).collect()
}

/// The key of a set from these starts, to a percent of each.
pub(super) fn at_starts(name: &str, starts: &[SearchedNumber]) -> String {
    starts.iter().fold(name.to_owned(), |key, own| format!("{key} at {:.2e}", own.value))
}
