//! One craft through all its arcs: its numbers, drawn once from the priors of its plant file, and
//! its rows.

use dynamics::description::{Plant, Scope};
use dynamics::noise::Stream;
use plant_file::scenario::{ArcError, ArcPlan, CraftPlan};
use simulation::Row;
use telemetry::{CraftRow, Sample};

/// Draws are repeated beyond this many standard deviations: a data sheet's tolerance is no tail.
const DRAW_SIGMAS_MAX: f64 = 2.0;
/// Draws until one is possible: of a prior of 1.7 sigma above zero each is with 95 %.
const DRAWS_MAX: u64 = 64;

/// The craft as it flies `arc`: every number that the plant file gives a sigma drawn from its prior
/// (one for all arcs, or one an arc where its scope says so), then the numbers set and the effects
/// hidden. No draw changes the sign that the file gives a number.
///
/// # Errors
/// See [`ArcError`].
pub fn flown(craft: &CraftPlan, arc: &ArcPlan, seed: u64) -> Result<Plant, ArcError> {
    let mut plant = craft.known(arc)?;
    plant.visit_quantities(&mut |name, _, quantity| {
        let Some(sigma) = quantity.sigma else { return };
        let stream = match quantity.scope {
            Scope::Shared => Stream::new(seed, &format!("truth.{name}")),
            Scope::PerRecording | Scope::PerSegment => Stream::new(seed, &format!("truth.{name}@{}", arc.name)),
        };
        let prior = quantity.value;
        let draws = (0..DRAWS_MAX).map(|k| stream.normal(k)).filter(|z| z.abs() < DRAW_SIGMAS_MAX);
        let possible = |value: &f64| prior == 0.0 || value.signum() == prior.signum();
        quantity.value = draws.map(|z| prior + z * sigma).find(possible).unwrap_or(prior);
    });
    let failed =
        |error: plant_file::scenario::PlantUseError| ArcError::Arc { arc: arc.name.clone(), reason: error.to_string() };
    craft.plant.change(&mut plant).map_err(failed)?;
    Ok(plant)
}

/// The sample of one control period that began at `t_ns`.
pub fn row(plant: &Plant, row: &Row, interval_s: f64, t_ns: u64) -> CraftRow {
    let mut sample = CraftRow::zeroed_at(t_ns);
    (sample.interval_s, sample.t_s) = (interval_s, row.time_s);
    (sample.commands, sample.readings) = (plant.actuators.len() as u32, plant.sensors.len() as u32);
    sample.command.iter_mut().zip(&row.commands).for_each(|(to, command)| *to = *command);
    for reading in &row.samples {
        sample.valid |= 1 << reading.channel;
        (sample.reading[reading.channel], sample.stamp_s[reading.channel]) = (reading.value, reading.time_s);
    }
    sample
}

#[cfg(test)]
mod tests {
    use super::*;

    fn craft() -> CraftPlan {
        let text = "plant = { file = \"study_case\" }\n\
            [[arc]]\nname = \"E1\"\nexperiment = \"modal\"\nduration_s = 1.0\n\
            [[arc]]\nname = \"E2\"\nexperiment = \"slosh\"\nduration_s = 1.0\n";
        let mut craft: CraftPlan = toml::from_str(text).unwrap();
        craft.plant.text = include_str!("../../../deploy/plants/study_case.toml").into();
        craft
    }

    fn values(plant: &Plant) -> Vec<(String, f64, Option<f64>, Scope)> {
        plant.parameters().into_iter().map(|p| (p.name, p.value, p.sigma, p.scope)).collect()
    }

    #[test]
    fn arcs_share_every_number_but_those_of_a_recording_and_another_seed_is_another_craft() {
        let craft = craft();
        let of = |arc: usize, seed: u64| values(&flown(&craft, &craft.arcs[arc], seed).unwrap());
        let (first, second, other) = (of(0, 1), of(1, 1), of(0, 2));
        for ((a, b), c) in first.iter().zip(&second).zip(&other) {
            if a.2.is_none() {
                continue;
            }
            assert_eq!(a.1 == b.1, a.3 == Scope::Shared, "{}", a.0);
            assert_ne!(a.1, c.1, "{}", a.0);
        }
    }

    #[test]
    fn draws_stay_within_two_sigma_of_the_file_and_keep_its_sign() {
        let craft = craft();
        let known = values(&craft.known(&craft.arcs[0]).unwrap());
        for seed in 0..20 {
            for (drawn, file) in values(&flown(&craft, &craft.arcs[0], seed).unwrap()).iter().zip(&known) {
                let sigma = file.2.unwrap_or(0.0);
                assert!((drawn.1 - file.1).abs() <= DRAW_SIGMAS_MAX * sigma, "{}", file.0);
                assert!(file.1 == 0.0 || drawn.1.signum() == file.1.signum(), "{}", file.0);
            }
        }
    }

    #[test]
    fn a_number_that_is_set_is_not_drawn() {
        let mut craft = craft();
        craft.plant.set.insert("hub.mass".into(), "999 kg".into());
        let plant = flown(&craft, &craft.arcs[0], 5).unwrap();
        assert_eq!(plant.bodies[0].mass_kg.value, 999.0);
    }
}
