//! Recordings of which no diagnosis can be made: too few samples for the numbers that are free, or a channel that stands still.

use examination::doctor::FALSE_ALARM;
use identification::fit::EstimationSession;
use identification::problem::standstill;

/// Samples that must be left beside one for every free number: with fewer the size of the noise is known to no better than a third, and no
/// likelihood has the distribution that significance is reckoned by.
const SPARE: usize = 5;

/// Why nothing can be said, and what would help.
pub(super) fn silent(session: &EstimationSession<'_>) -> Option<String> {
    too_few(session).or_else(|| (0..session.problem.plant.sensors.len()).find_map(|channel| stuck(session, channel)))
}

/// Numbers that are free: unknowns, initial states of every run and a size of the noise of every channel.
fn too_few(session: &EstimationSession<'_>) -> Option<String> {
    let problem = session.problem;
    let states = dynamics::system::System::new(&problem.plant).map_or(0, |system| system.tangent_len());
    let free = problem.unknowns.len() + states * problem.runs.len() + problem.plant.sensors.len();
    let least = free + SPARE;
    (session.samples < least).then(|| {
        format!(
            "{} samples are too few for {free} free numbers (unknowns, initial states and sizes of the noise): record {least} at least",
            session.samples
        )
    })
}

/// A channel of which every sample is the same number, though its noise would make each another.
fn stuck(session: &EstimationSession<'_>, channel: usize) -> Option<String> {
    let problem = session.problem;
    let sensor = &problem.plant.sensors[channel];
    let samples = problem.runs.iter().map(|run| &run.samples[channel]);
    let stretches: Vec<(&[f64], &[f64])> = samples.map(|own| (&own.time_s[..], &own.value[..])).collect();
    let found =
        standstill(&problem.plant, sensor, &stretches).filter(|found| found.p < FALSE_ALARM && found.samples >= SPARE);
    // at rest on one step of a resolution: the doctor tells
    let found = found.filter(|_| sensor.resolution.value <= 0.0)?;
    Some(format!(
        "'{}' reads {} in all of its {} samples, and its noise would make each another: it is stuck or was not recorded; \
         leave it out of the plant, or state its resolution",
        sensor.name, found.reading, found.samples
    ))
}
