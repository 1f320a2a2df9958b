//! The time axis: stamps that stand twice or run back, gaps, jitter, uneven sampling, sources of
//! different rate.
//!
//! These are facts of the stamps, not statistics; what limits them is the resolution the stamps
//! were written with, and a stated material size: jitter below 0.1 % of a step moves a signal at a
//! tenth of the Nyquist frequency by 3e-4 of its amplitude.

use std::borrow::Cow;

use super::{Check, Finding, Severity, short};
use crate::missing::{Missing, missing};
use channels::{Channel, EvenClock, GAP_MEDIANS, IRREGULAR_SHARE, Recording, Role};
use estimation::quantiles::{median, quantile};
use identification::statistics::{deviation, rms};

/// Jitter reported from this share of a step.
const JITTER_SHARE: f64 = 1e-3;
/// From here on a method that assumes equal steps needs resampling.
const JITTER_WARNING_SHARE: f64 = 0.05;

/// A noise level from n samples has a relative standard deviation of `1 / sqrt(2 (n - 1))`: below
/// ten it is not known to a quarter.
const CHANNEL_SAMPLES_MIN: usize = 10;

/// Findings about the stamps, one per source (channels with the same stamps).
pub fn examine(recording: &Recording) -> Vec<Finding> {
    let mut findings = Vec::new();
    let sources = sources(recording);
    for source in &sources {
        findings.extend(not_finite(source));
        findings.extend(few_samples(source));
        findings.extend(source_findings(source));
    }
    findings.extend(gaps(&sources));
    let rates: Vec<(f64, &str)> =
        sources.iter().filter_map(|s| Some((1.0 / s[0].interval_s()?, s[0].name.as_str()))).collect();
    let (low, high) = rates.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), (r, _)| (l.min(*r), h.max(*r)));
    if rates.len() > 1 && high > low * (1.0 + JITTER_SHARE) {
        let list: Vec<String> = rates.iter().map(|(r, name)| format!("{name} {} Hz", short(*r))).collect();
        let mut finding = Finding::new(Check::Rate, Severity::Note, rates[0].1, high / low, "-");
        finding.others = rates[1..].iter().map(|(_, name)| (*name).to_string()).collect();
        findings.push(
            finding
                .because(list.join(", "))
                .cure("resample to the slowest source after filtering, or estimate with each source's own stamps"),
        );
    }
    findings
}

/// One finding for all gaps of the recording.
fn gaps(sources: &[Vec<&Channel>]) -> Option<Finding> {
    let of = |source: &Vec<&Channel>| {
        let time: Vec<f64> = source[0].time_s.iter().copied().filter(|t| t.is_finite()).collect();
        let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        let even = source[0].interval_s().is_some_and(|interval| irregular(&time, &steps, interval).is_none());
        missing(&time).filter(|_| even).map(|missing| (missing, time.len()))
    };
    let found: Vec<(&Vec<&Channel>, Missing, usize)> =
        sources.iter().filter_map(|source| of(source).map(|(missing, samples)| (source, missing, samples))).collect();
    let (_, longest, _) = found.iter().max_by(|a, b| a.1.longest_s.total_cmp(&b.1.longest_s))?;
    let names: Vec<&str> = found.iter().flat_map(|(source, ..)| source.iter().map(|c| c.name.as_str())).collect();
    let count: usize = found.iter().map(|(_, missing, _)| missing.gaps).sum();
    let absent: usize = found.iter().map(|(_, missing, _)| missing.samples).sum();
    let due = absent + found.iter().map(|(.., samples)| samples).sum::<usize>();
    let channels = if names.len() == 1 { "1 channel".into() } else { format!("{} channels", names.len()) };
    Some(
        Finding::new(Check::Gaps, Severity::Warning, names[0], absent as f64, "samples")
            .with(&names[1..])
            .because(format!(
                "{count} gap(s) in {channels}, {absent} samples missing of {due} ({} %); the longest {} s from {} s",
                short(100.0 * absent as f64 / due as f64),
                short(longest.longest_s),
                short(longest.longest_from_s)
            ))
            .cure("split there, or let the estimator predict across; never fill in"),
    )
}

fn sources(recording: &Recording) -> Vec<Vec<&Channel>> {
    let mut groups: Vec<Vec<&Channel>> = Vec::new();
    for channel in &recording.channels {
        match groups.iter_mut().find(|g| g[0].same_clock(channel)) {
            Some(group) => group.push(channel),
            None => groups.push(vec![channel]),
        }
    }
    groups
}

fn not_finite(source: &[&Channel]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for channel in source {
        let bad = channel.value.len().max(channel.time_s.len()) - channel.finite().len();
        if bad > 0 {
            findings.push(
                Finding::new(Check::NotFinite, Severity::Warning, &channel.name, bad as f64, "samples")
                    .because(format!("{bad} of {} samples are not a number", channel.value.len()))
                    .cure("they are left out here; find out what the source writes when it has no measurement"),
            );
        }
    }
    findings
}

fn few_samples(source: &[&Channel]) -> Option<Finding> {
    // a command is held until the next one: two may be all there is
    let few: Vec<&&Channel> =
        source.iter().filter(|c| c.role != Role::Input && c.finite().len() < CHANNEL_SAMPLES_MIN).collect();
    let (first, others) = few.split_first()?;
    let others: Vec<&str> = others.iter().map(|c| c.name.as_str()).collect();
    let n = first.finite().len();
    let known = if n > 1 {
        let percent = 100.0 / (2.0 * (n - 1) as f64).sqrt();
        format!("the level of their noise is known to ± {} % at best", short(libm::round(percent)))
    } else {
        "they show no spread".into()
    };
    Some(
        Finding::new(Check::FewSamples, Severity::Warning, &first.name, n as f64, "samples")
            .with(&others)
            .because(format!("{n} samples: {known} (± 24 % at {CHANNEL_SAMPLES_MIN}), and most checks here need more"))
            .cure(format!("record longer or faster: at least {CHANNEL_SAMPLES_MIN} samples a channel, and several times the numbers sought")),
    )
}

fn source_findings(source: &[&Channel]) -> Vec<Finding> {
    let channel = source[0];
    let others: Vec<&str> = source[1..].iter().map(|c| c.name.as_str()).collect();
    let Some(interval) = channel.interval_s() else { return Vec::new() };
    let time: Vec<f64> = channel.time_s.iter().copied().filter(|t| t.is_finite()).collect();
    let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let finding = |check, severity, value: f64, unit: &str| {
        Finding::new(check, severity, &channel.name, value, unit).with(&others)
    };
    let mut findings = Vec::new();
    let twice = steps.iter().filter(|d| **d == 0.0).count();
    if twice > 0 {
        findings.push(
            finding(Check::DuplicateStamps, Severity::Warning, twice as f64, "stamps")
                .because(format!(
                    "{twice} of {} stamps stand twice; the first at {} s",
                    time.len(),
                    first_at(&time, &steps, |d| d == 0.0)
                ))
                .cure("drop one of each pair if the values agree; else the source writes faster than its clock counts"),
        );
    }
    let back: Vec<usize> = (0..steps.len()).filter(|&i| steps[i] < 0.0).collect();
    if let Some(&first) = back.first() {
        findings.push(
            finding(Check::BackwardStamps, Severity::Fault, back.len() as f64, "stamps")
                .because(format!(
                    "time steps back {} time(s), first from {} s to {} s at sample {}",
                    back.len(),
                    short(time[first]),
                    short(time[first + 1]),
                    first + 1
                ))
                .cure("several runs in one file: give each its own recording (they were examined one by one)"),
        );
    }
    let regular: Vec<f64> = steps.iter().copied().filter(|d| *d > 0.0 && *d <= GAP_MEDIANS * interval).collect();
    let irregular = irregular(&time, &steps, interval);
    if let Some(evidence) = &irregular {
        findings.push(
            finding(Check::IrregularTime, Severity::Warning, quantile_departure(&steps, interval), "-")
                .because(evidence.clone())
                .cure("resample, or use methods that take each stamp as it is"),
        );
    }
    if irregular.is_none() {
        findings.extend(jitter(&time, &regular, interval).map(|(share, evidence)| {
            let severity = if share >= JITTER_WARNING_SHARE { Severity::Warning } else { Severity::Note };
            finding(Check::Jitter, severity, share * interval, "s")
                .because(evidence)
                .cure("interpolate to even steps with the stamps given, or use each stamp as it is")
        }));
    }
    findings
}

fn first_at(time: &[f64], steps: &[f64], is: impl Fn(f64) -> bool) -> String {
    steps.iter().position(|d| is(*d)).map_or_else(String::new, |i| short(time[i]))
}

/// Rms departure of the intervals from their median as a share of it, when larger than the stamps'
/// own resolution explains.
fn jitter(time: &[f64], regular: &[f64], interval: f64) -> Option<(f64, String)> {
    if regular.len() < 16 {
        return None;
    }
    let wander = wander(time, interval);
    let share = (deviation(regular) / interval).max(wander);
    if share < JITTER_SHARE {
        return None;
    }
    let largest = regular.iter().map(|d| (d / interval - 1.0).abs()).fold(0.0, f64::max);
    Some((
        share,
        format!(
            "intervals {} s with a deviation of {} s ({} %), at most {} %; stamps off an even clock by {} s rms",
            short(interval),
            short(deviation(regular)),
            short(100.0 * deviation(regular) / interval),
            short(100.0 * largest),
            short(wander * interval)
        ),
    ))
}

/// Rms departure of the stamps from the straight line through them, in intervals; zero where there
/// are gaps.
fn wander(time: &[f64], interval: f64) -> f64 {
    if time.windows(2).any(|w| w[1] - w[0] > GAP_MEDIANS * interval || w[1] <= w[0]) {
        return 0.0;
    }
    let n = time.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let centre = identification::statistics::mean(time);
    let slope = time.iter().enumerate().map(|(i, t)| (i as f64 - middle) * (t - centre)).sum::<f64>()
        / (n * (n * n - 1.0) / 12.0);
    let departure: Vec<f64> = time.iter().enumerate().map(|(i, t)| t - centre - slope * (i as f64 - middle)).collect();
    rms(&departure) / interval
}

fn quantile_departure(steps: &[f64], interval: f64) -> f64 {
    let mut departures: Vec<f64> = steps.iter().filter(|d| **d > 0.0).map(|d| (d / interval - 1.0).abs()).collect();
    quantile(&mut departures, 0.95)
}

/// Why the stamps are no even clock's, not even one with rows missing.
fn irregular(time: &[f64], steps: &[f64], interval: f64) -> Option<String> {
    uneven(steps, interval).filter(|_| EvenClock::of(time).is_none())
}

fn uneven(steps: &[f64], interval: f64) -> Option<String> {
    if steps.len() < 16 {
        return None;
    }
    let departure = quantile_departure(steps, interval);
    if departure > IRREGULAR_SHARE {
        return Some(format!(
            "5 % of the intervals are off the median of {} s by more than {} %",
            short(interval),
            short(100.0 * departure)
        ));
    }
    let part = (steps.len() / 8).max(16);
    let medians: Vec<f64> = steps.chunks(part).filter(|c| c.len() >= 16).map(|c| median(&mut c.to_vec())).collect();
    let (low, high) = medians.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), m| (l.min(*m), h.max(*m)));
    (rms(&medians) > 0.0 && high > low * (1.0 + IRREGULAR_SHARE))
        .then(|| format!("the interval changes lastingly, from {} s to {} s", short(low), short(high)))
}

/// The recording cut where stamps run back; stamps that stand twice are dropped. One run when
/// nothing is wrong.
pub fn runs(recording: &Recording) -> Vec<Cow<'_, Recording>> {
    let in_order = |c: &Channel| {
        c.time_s.len() == c.value.len()
            && c.time_s.iter().chain(&c.value).all(|x| x.is_finite())
            && c.time_s.windows(2).all(|w| w[1] > w[0])
    };
    if recording.channels.iter().all(in_order) {
        return vec![Cow::Borrowed(recording)];
    }
    let parts: Vec<Vec<Channel>> = recording.channels.iter().map(pieces).collect();
    let count = parts.iter().map(Vec::len).max().unwrap_or(0);
    (0..count)
        .map(|k| {
            let channels = parts.iter().filter_map(|p| p.get(k).cloned()).collect();
            Cow::Owned(Recording { name: recording.name.clone(), channels })
        })
        .collect()
}

fn pieces(channel: &Channel) -> Vec<Channel> {
    let empty = || Channel { time_s: Vec::new(), value: Vec::new(), ..channel.clone() };
    let mut out = vec![empty()];
    for i in channel.finite() {
        let (t, v) = (channel.time_s[i], channel.value[i]);
        match out.last().and_then(|c| c.time_s.last().copied()) {
            Some(last) if t == last => continue,
            Some(last) if t < last => out.push(empty()),
            _ => {}
        }
        let run = out.last_mut().expect("starts with one");
        run.time_s.push(t);
        run.value.push(v);
    }
    out
}
