//! Names that stand for less than they say: where one plain law that the catalogue has no name for, in the place of one of them or of all, explains
//! the recording as well with fewer numbers, or better, they are none.

use super::screening::Screening;
use super::{Adopted, Standing};
use crate::compete::{PREFERRED, Refit, free_numbers};
use crate::fit::Engine;
use crate::unknown_law::{Plain, UnknownLaw, plain};

/// The plain law that BIC prefers to what is `adopted` by twenty to one; most ahead where several are. `nominal` is the plant without any of it.
///
/// Cost: a column a law; where several effects are adopted as much for each, and a fit without it.
pub(super) fn plainer(
    engine: &Engine<'_>,
    nominal: &Standing,
    (best, adopted): (&Standing, &[Adopted]),
    screening: &Screening,
) -> Option<UnknownLaw> {
    let price = libm::log(engine.samples.max(2) as f64);
    let numbers = |set: &[Adopted]| set.iter().map(Adopted::numbers).sum::<f64>();
    let all = || {
        let found = at(engine, nominal, best, screening)?;
        Some((found, nominal.clone(), numbers(adopted)))
    };
    let each = adopted.iter().filter(|_| adopted.len() > 1).filter_map(|own| {
        let without = Standing::of(&Refit::from(best.clone()).without(engine, &own.column)?);
        let found = at(engine, &without, best, screening)?;
        Some((found, without, own.numbers()))
    });
    let whole = (!adopted.is_empty()).then(all).flatten();
    let ahead =
        |(found, _, numbers): &(Plain, Standing, f64)| best.objective - found.objective + price * (numbers - 1.0);
    let first = whole.into_iter().chain(each).max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
    let by = ahead(&first);
    let (found, base, numbers) = first;
    let own = Engine::like(engine, &base.problem).ok()?;
    (by > PREFERRED).then(|| found.told(&own, (&base.fit.board, &base.fit.theta), by, numbers as usize)).flatten()
}

/// The best plain law of the plant `base`, under the noise that suits `best`.
fn at(engine: &Engine<'_>, base: &Standing, best: &Standing, screening: &Screening) -> Option<Plain> {
    let own = Engine::like(engine, &base.problem).ok()?;
    let named = screening.columns.iter().filter(|c| c.raw.len() == 1 && free_numbers(&c.candidate, 1) == 1);
    let named: Vec<&Vec<f64>> = named.map(|column| &column.raw[0]).collect();
    plain(&own, &base.plant, (&base.fit.board, &base.fit.theta), &best.noise, &named)
}
