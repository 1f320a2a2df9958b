//! Insufficient data: too few samples for the free parameters, or a constant channel.

use examination::doctor::FALSE_ALARM;
use identification::fit::EstimationSession;
use identification::problem::standstill;

/// Samples beyond one for each free parameter [1]. With fewer, the size of the noise is uncertain
/// by more than a third, and no likelihood ratio has its asymptotic distribution.
const SPARE_SAMPLES_MIN: usize = 5;

/// Why the data are insufficient, and what would help; `None` where they suffice.
pub(crate) fn insufficient_data(session: &EstimationSession<'_>) -> Option<String> {
    too_few(session).or_else(|| (0..session.problem.plant.sensors.len()).find_map(|channel| stuck(session, channel)))
}

/// Fewer samples than free parameters need: unknowns, initial states of every run, and the size of
/// the noise of every channel.
fn too_few(session: &EstimationSession<'_>) -> Option<String> {
    let problem = session.problem;
    let states = dynamics::system::System::new(&problem.plant).map_or(0, |system| system.tangent_len());
    let free = problem.unknowns.len() + states * problem.runs.len() + problem.plant.sensors.len();
    let least = free + SPARE_SAMPLES_MIN;
    (session.samples < least).then(|| {
        format!(
            "{} samples are too few for {free} free parameters (unknowns, initial states and sizes of the noise): record {least} at least",
            session.samples
        )
    })
}

/// A channel whose samples are all equal, although its noise would make them differ.
fn stuck(session: &EstimationSession<'_>, channel: usize) -> Option<String> {
    let problem = session.problem;
    let sensor = &problem.plant.sensors[channel];
    let samples = problem.runs.iter().map(|run| &run.samples[channel]);
    let stretches: Vec<(&[f64], &[f64])> = samples.map(|own| (&own.time_s[..], &own.value[..])).collect();
    let found = standstill(&problem.plant, sensor, &stretches)
        .filter(|found| found.p < FALSE_ALARM && found.samples >= SPARE_SAMPLES_MIN);
    // constant within one step of a resolution: the doctor reports that
    let found = found.filter(|_| sensor.resolution.value <= 0.0)?;
    Some(format!(
        "'{}' reads {} in all of its {} samples, and its noise would make each another: it is stuck or was not recorded; \
         remove it from the plant, or state its resolution",
        sensor.name, found.reading, found.samples
    ))
}
