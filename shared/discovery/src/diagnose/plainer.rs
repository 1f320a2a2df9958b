//! Names that stand for less than they say: where one plain law that the catalogue has no name for, in the place of one of them or of all, explains
//! the recording as well with fewer numbers, or better, they are none.

use super::screening::{Screening, in_a_quiet_loop};
use super::{Adopted, Standing};
use crate::compete::{PREFERRED, Refit, free_numbers};
use crate::fit::{Board, Engine};
use crate::score::{Candidate, Column, columns};
use crate::unknown_law::{Named, Plain, UnknownLaw, plain};

/// Share of what names explain that a law on the linear model may be off by.
const BENT: f64 = 1e-3;
/// The catalogue's step of a reading.
const STEP: &str = "sensor_step";

/// The plain law that BIC prefers to what is `adopted` by twenty to one; most ahead where several are. `nominal` is the plant without any of it.
///
/// Cost: a column a law; where several effects are adopted as much for each, and a fit without it.
pub(super) fn plainer(
    engine: &Engine<'_>,
    nominal: &Standing,
    (best, adopted): (&Standing, &[Adopted]),
    screening: &Screening,
) -> Option<UnknownLaw> {
    let of_one_number = |c: &&Column| c.raw.len() == 1 && free_numbers(&c.candidate, 1) == 1;
    // a step of a reading has a name, whatever its times are
    let steps = !screening.columns.iter().any(|column| column.candidate.effect.kind == STEP);
    let named: Vec<Candidate> =
        screening.columns.iter().filter(of_one_number).map(|column| column.candidate.clone()).collect();
    let mut found: Vec<(Plain, Standing, f64)> = Vec::new();
    let mut look = |base: Standing, numbers: f64| {
        let plain = at(engine, &base, best, (&named, steps));
        found.extend(plain.into_iter().map(|plain| (plain, base.clone(), numbers)));
    };
    let begun = engine.work.spent();
    if !adopted.is_empty() {
        look(nominal.clone(), adopted.iter().map(Adopted::numbers).sum());
    }
    let mut each = engine.work.spent() - begun;
    for own in adopted.iter().filter(|_| adopted.len() > 1) {
        // a fit beside it
        if !engine.work.allows(2.0 * each, "plain laws in the place of each name") {
            break;
        }
        let begun = engine.work.spent();
        if let Some(without) = Refit::from(best.clone()).without(engine, &own.column) {
            look(Standing::of(&without), own.numbers());
        }
        each = each.max(0.5 * (engine.work.spent() - begun));
    }
    let price = libm::log(engine.samples.max(2) as f64);
    let ahead = |(plain, base, numbers): &(Plain, Standing, f64)| {
        let explained = (base.objective - best.objective).max(0.0);
        best.objective - plain.objective + price * (numbers - plain.numbers() as f64) - BENT * explained
    };
    let first = found.into_iter().max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
    let by = ahead(&first);
    let (plain, base, numbers) = first;
    let own = Engine::like(engine, &base.problem).ok()?;
    (by > PREFERRED).then(|| plain.told(&own, (&base.fit.board, &base.fit.theta), by, numbers as usize)).flatten()
}

/// The best plain laws of the plant `base`: under the noise that suits `best`, and where readings may step under the stated one, too:
/// what happens at an instant noise swallows most.
fn at(engine: &Engine<'_>, base: &Standing, best: &Standing, (named, steps): (&[Candidate], bool)) -> Vec<Plain> {
    let Ok(own) = Engine::like(engine, &base.problem) else { return Vec::new() };
    let (board, theta): (&Board, _) = (&base.fit.board, &base.fit.theta);
    in_a_quiet_loop(&own, base, |along| {
        let named = columns(along, &base.plant, theta, named);
        let name = |column: &'_ Column| free_numbers(&column.candidate, column.raw.len());
        let named: Vec<Named<'_>> = named.iter().filter_map(|own| Some((name(own), own.raw.first()?))).collect();
        let stated = (steps && !best.noise.is_about(&engine.noise)).then_some(&engine.noise);
        let under = |noise| plain((&own, board), along, &base.plant, theta, noise, (&named, steps));
        core::iter::once(&best.noise).chain(stated).filter_map(under).collect()
    })
}
