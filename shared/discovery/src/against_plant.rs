//! Faults of a recording that only show against a plant: names, units, time unit, constant
//! channels.
//!
//! Names and units are checked by [`Problem::refusals`] and constant channels by [`standstill`],
//! the functions a diagnosis uses. What makes a diagnosis reject the recording is therefore a fault
//! here.

use dynamics::description::{Plant, Sensor};

use crate::mislabelled::{self, Mislabelled, mislabelled};
use channels::{Channel, Recording};
use examination::doctor::{Check, FALSE_ALARM, Finding, Severity, examine_with, in_order, probability, short};
use identification::problem::{Problem, ProblemError, period_s, standstill};
use identification::work::{LABEL_CHECK_SHARE, NORMAL_WORK, Watch, Work};
use std::sync::Arc;

/// Units of time that are taken for one another: ms, µs and ns for s, and s for them.
const TIME_UNITS: [(f64, &str); 3] = [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")];
/// A ratio of steps within this share of a unit's is that unit.
const UNIT_SHARE: f64 = 0.02;

/// Findings about `recording` as data of `plant`: channels or units that do not match, constant
/// channels, too few readings, a time unit that is off by a power of a thousand.
///
/// The channel metadata (wrong unit, flipped sign, swapped channels) is not checked here: see
/// [`examine_for`]. Cost: O(samples).
pub fn examine(recording: &Recording, plant: &Plant) -> Vec<Finding> {
    let mut findings: Vec<Finding> =
        Problem::refusals(plant, recording).iter().filter_map(|error| rejection(error, plant)).collect();
    let sensors =
        || plant.sensors.iter().filter_map(|s| Some((s, recording.channels.iter().find(|c| c.name == s.name)?)));
    findings.extend(sensors().filter_map(|(sensor, channel)| stuck(plant, sensor, channel)));
    findings.extend(few_readings(recording, plant));
    findings.extend(time_unit(plant, &sensors().collect::<Vec<_>>()));
    findings
}

/// The finding for an error that makes a diagnosis reject the recording; errors of the plant alone
/// belong to `obsid plant check`.
fn rejection(error: &ProblemError, plant: &Plant) -> Option<Finding> {
    let (check, channel, value) = match error {
        ProblemError::MissingChannel { channel, .. } => (Check::Missing, channel, 1.0),
        ProblemError::UnknownInput { actuator } => (Check::Missing, actuator, 1.0),
        ProblemError::Unit { channel, .. } => (Check::Units, channel, 1.0),
        ProblemError::Empty { channel, .. } => (Check::FewSamples, channel, 0.0),
        ProblemError::NoRecording | ProblemError::Plant(_) | ProblemError::NoNoise(_) => return None,
    };
    let unit = if check == Check::FewSamples { "samples" } else { "channel" };
    Some(
        Finding::new(check, Severity::Fault, channel, value, unit)
            .because(format!("{error}; `obsid diagnose` rejects it with plant '{}'", plant.name))
            .cure(error.cure("the plant file")),
    )
}

/// A measured channel that never changes although noise is stated on it.
fn stuck(plant: &Plant, sensor: &Sensor, channel: &Channel) -> Option<Finding> {
    let kept = channel.finite();
    let of = |all: &[f64]| kept.iter().map(|&i| all[i]).collect::<Vec<_>>();
    let (times, values) = (of(&channel.time_s), of(&channel.value));
    let found = standstill(plant, sensor, &[(&times, &values)]).filter(|found| found.p < FALSE_ALARM)?;
    Some(
        Finding::new(Check::Constant, Severity::Fault, &channel.name, found.reading, &channel.unit)
            .because(format!(
                "all {} samples are {}, the plant states noise of {} {} on each: {}",
                found.samples,
                short(found.reading),
                short(found.sigma),
                channel.unit,
                probability(found.p)
            ))
            .cure("stuck, not recorded, or written with too few digits: look at the sensor, the wiring and the mapping, or leave the channel out"),
    )
}

/// The recording has no more readings than the plant has parameters to estimate.
fn few_readings(recording: &Recording, plant: &Plant) -> Option<Finding> {
    let problem = Problem::new(plant, core::slice::from_ref(recording), &[]).ok()?;
    let (readings, unknowns) = (problem.samples(), problem.unknowns.len());
    let measured = plant.sensors.iter().map(|s| s.name.as_str());
    let measured: Vec<&str> = measured.filter(|name| recording.channels.iter().any(|c| c.name == *name)).collect();
    let (first, others) = measured.split_first()?;
    (readings <= unknowns).then(|| {
        Finding::new(Check::FewSamples, Severity::Warning, first, readings as f64, "samples")
            .with(others)
            .because(format!(
                "{readings} readings of all sensors for {unknowns} unknown parameters of the plant and its initial state: none is left to test the fit"
            ))
            .cure("record longer or faster, or remove the sigmas of known parameters")
    })
}

/// The steps of the sensors are longer or shorter than the plant's by a power of a thousand.
///
/// This is a hint, not a proof: both may be correct.
fn time_unit(plant: &Plant, sensors: &[(&Sensor, &Channel)]) -> Option<Finding> {
    let ratio = |(sensor, channel): &(&Sensor, &Channel)| Some(channel.interval_s()? / period_s(plant, sensor));
    let near = |x: f64, unit: f64| (x / unit - 1.0).abs() < UNIT_SHARE;
    let labelled = |r: f64| {
        TIME_UNITS.iter().find_map(|(factor, name)| match r {
            r if near(r, *factor) => Some((*name, "seconds")),
            r if near(r * factor, 1.0) => Some(("seconds", *name)),
            _ => None,
        })
    };
    let odd: Vec<(f64, &Sensor, &Channel)> = sensors
        .iter()
        .filter_map(|pair| Some((ratio(pair).filter(|r| labelled(*r).is_some())?, pair.0, pair.1)))
        .collect();
    let ((r, sensor, channel), others) = odd.split_first()?;
    let (meant, written) = labelled(*r)?;
    let others: Vec<&str> = others.iter().map(|(.., c)| c.name.as_str()).collect();
    Some(
        Finding::new(Check::TimeUnit, Severity::Warning, &channel.name, *r, "-")
            .with(&others)
            .because(format!(
                "sampled every {} s, every {} s in the plant: a factor of {} is that of {meant} labelled {written}",
                short(channel.interval_s()?),
                short(period_s(plant, sensor)),
                short(*r)
            ))
            .cure("look at the unit in the header of the time column; where it is right, state the period of the recording in [simulation]"),
    )
}

/// As [`examine_with`], with the findings against `plant` ([`examine`]) and the check of the
/// channel metadata ([`mislabelled()`]), which `watch` sees and stops.
#[must_use]
pub fn examine_for(recording: &Recording, plant: &Plant, watch: &Watch, progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let work = Arc::new(Work::watched(LABEL_CHECK_SHARE * NORMAL_WORK, watch.clone()));
    let label = mislabelled(recording, plant, &work);
    let mut findings = examine_beside(recording, plant, label.as_ref(), progress);
    findings.extend(
        work.note().filter(|_| label.is_none()).and_then(|note| mislabelled::not_tested(recording, plant, &note)),
    );
    in_order(findings)
}

/// As [`examine_for`] with the [`mislabelled()`] channels given: a channel whose mistake is known
/// is not reported a second time for it.
#[must_use]
pub fn examine_beside(
    recording: &Recording,
    plant: &Plant,
    label: Option<&Mislabelled>,
    progress: &mut dyn FnMut(f64),
) -> Vec<Finding> {
    let mut reported = examine(recording, plant);
    reported.extend(label.map(Mislabelled::finding));
    let mut findings = examine_with(recording, progress);
    let names = |f: &Finding, channel: &str| f.channel == channel || f.others.iter().any(|other| other == channel);
    let again = |f: &Finding| match f.check {
        Check::Constant => reported.iter().any(|t| t.check == f.check && t.channel == f.channel),
        Check::Units | Check::Sign => reported.iter().any(|t| t.check == f.check && names(f, &t.channel)),
        _ => false,
    };
    findings.retain(|f| !again(f));
    findings.extend(reported);
    in_order(findings)
}

#[cfg(test)]
mod tests;
