//! Values of one channel: constant, saturated, quantised, with spikes, wrapped.

use core::f64::consts::PI;
use std::borrow::Cow;

use super::{Check, FALSE_ALARM, Finding, Severity, quantity, short};
use crate::clipping::clipped;
use crate::lattice::{Lattice, lattice};
use channels::{Channel, Recording, Role};
use estimation::quantiles::median;
use identification::statistics::{deviation, difference_sigma, mean, normal_two_sided, rms};

/// Quantisation noise below this share of the rms is not reported: a 16-bit converter at a third of
/// full scale.
const QUANTISATION_RMS_SHARE: f64 = 1e-5;
/// Quantisation is reported when it makes this share of the channel's noise variance, or when this
/// share of neighbours is equal.
const QUANTISATION_NOISE_SHARE: f64 = 0.1;
const EQUAL_NEIGHBOURS_SHARE: f64 = 0.2;

/// Findings on the values of each channel: constant, saturated, quantised, with spikes, wrapped.
/// `progress` receives the share done.
pub fn examine(recording: &Recording, progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let mut findings = Vec::new();
    let channels = recording.channels.len() as f64;
    for (k, channel) in recording.channels.iter().enumerate() {
        progress(k as f64 / channels);
        if channel.value.len() < 8 {
            continue;
        }
        if let Some(finding) = constant(channel) {
            findings.push(finding);
            continue;
        }
        let lattice = lattice(&channel.value);
        findings.extend(saturation(channel, lattice.as_ref()).or_else(|| limited(channel)));
        // what is held repeats without being coarse
        match super::sampling::held_values(channel) {
            Some(held) => findings.push(held),
            None => findings.extend(lattice.as_ref().and_then(|l| quantisation(channel, l))),
        }
        findings.extend(spikes(channel, lattice.as_ref(), channels));
    }
    findings
}

fn constant(channel: &Channel) -> Option<Finding> {
    let first = *channel.value.first()?;
    channel.value.iter().all(|v| *v == first).then(|| {
        let cure = if super::content::is_input(channel) {
            "what acts through it cannot be found from this recording; if it was driven, look at the wiring and the mapping"
        } else {
            "carries nothing: leave it out; if a quantity should be here, look at the wiring and the mapping"
        };
        Finding::new(Check::Constant, Severity::Warning, &channel.name, first, &channel.unit)
            .because(format!("all {} samples are {}", channel.value.len(), short(first)))
            .cure(cure)
    })
}

fn quantisation(channel: &Channel, lattice: &Lattice) -> Option<Finding> {
    let value = &channel.value;
    let (noise, spread) = (lattice.step / 12.0_f64.sqrt(), deviation(value));
    let equal =
        value.windows(2).filter(|w| (w[1] - w[0]).abs() < 0.5 * lattice.step).count() as f64 / (value.len() - 1) as f64;
    let total = difference_sigma(value, 4);
    let noise_share = if total > 0.0 { (noise / total).powi(2).min(1.0) } else { 1.0 };
    // A counter steps by one level every time.
    let counter = value.windows(2).all(|w| ((w[1] - w[0]).abs() - lattice.step).abs() < 0.1 * lattice.step);
    // A command held on a few levels is no measurement that a converter coarsened.
    let command = channel.role == Role::Input && equal > 0.9;
    let matters = noise_share >= QUANTISATION_NOISE_SHARE || equal >= EQUAL_NEIGHBOURS_SHARE;
    if noise < QUANTISATION_RMS_SHARE * spread || !matters || command || counter {
        return None;
    }
    let severity = if noise > 0.01 * spread { Severity::Warning } else { Severity::Note };
    Some(
        Finding::new(Check::Quantisation, severity, &channel.name, lattice.step, &channel.unit)
            .because(format!(
                "{} levels, step {} {}; step/sqrt(12) is {} % of the rms about the mean and {} % of the noise variance; {} % of neighbours are equal",
                lattice.levels, short(lattice.step), channel.unit, short(100.0 * noise / spread), short(100.0 * noise_share), short(100.0 * equal)
            ))
            .cure("give the noise at least step/sqrt(12); do not difference it sample by sample; where neighbours are equal it is not white"),
    )
}

/// Runs at the highest or lowest value that the motion before and after would have left.
///
/// A cubic with the entry and exit slopes would overshoot the level by `(s_in + s_out) L dt / 8`;
/// the top of a smooth, quantised peak overshoots by less than one step. Reported when the mean
/// overshoot exceeds two steps and `z` standard errors of the slopes' noise, and equal neighbours
/// are rare elsewhere.
fn saturation(channel: &Channel, lattice: Option<&Lattice>) -> Option<Finding> {
    let value = &channel.value;
    let n = value.len();
    let tolerance = lattice.map_or(0.0, |l| 0.25 * l.step);
    let (low, high) = value.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let noise = difference_sigma(value, 4);
    let mut samples = 0;
    let mut runs: Vec<(f64, usize, usize)> = Vec::new();
    for (level, sign) in [(high, 1.0), (low, -1.0)] {
        let at = |i: usize| (value[i] - level).abs() <= tolerance;
        let mut i = 0;
        while i < n {
            let first = i;
            while i < n && at(i) {
                i += 1;
            }
            if i - first >= 3 && first >= 2 && i + 2 <= n {
                let entry = sign * (level - value[first - 2]) / 2.0;
                let exit = sign * (level - value[i + 1]) / 2.0;
                runs.push(((entry + exit) * (i - first) as f64 / 8.0, first, i - first));
                samples += i - first;
            }
            i += 1;
        }
    }
    let inside: Vec<&[f64]> =
        value.windows(2).filter(|w| [low, high].iter().all(|l| (w[0] - l).abs() > tolerance)).collect();
    let equal = inside.iter().filter(|w| w[0] == w[1]).count() as f64 / inside.len().max(1) as f64;
    let longest = runs.iter().max_by_key(|r| r.2)?;
    // The chance that a run of that length is a coincidence of equal neighbours.
    let chance = n as f64 * libm::pow(equal + 1.0 / (inside.len() as f64 + 1.0), (longest.2 - 1) as f64);
    let overshoot = mean(&runs.iter().map(|r| r.0).collect::<Vec<_>>());
    let step = lattice.map_or(0.0, |l| l.step);
    let error = noise * longest.2 as f64 / 16.0 * 2.0_f64.sqrt() / (runs.len() as f64).sqrt();
    let real = overshoot > 2.0 * step && overshoot > normal_two_sided(FALSE_ALARM) * error;
    (real && chance < FALSE_ALARM && equal < 0.5 && inside.len() >= 8).then(|| {
        let extreme = value[longest.1];
        Finding::new(Check::Saturation, Severity::Fault, &channel.name, extreme, &channel.unit)
            .because(format!(
                "{} run(s), {samples} samples ({} %) pinned at {} or {} {}; the longest of {} samples at {} s; the motion around them would have gone {} {} further",
                runs.len(), short(100.0 * samples as f64 / n as f64), short(low), short(high), channel.unit, longest.2,
                short(channel.time_s[longest.1]), short(overshoot), channel.unit
            ))
            .cure(OUT_OF_RANGE)
    })
}

/// Values at a limit by their distribution: noise and motions too fast for [`saturation`].
fn limited(channel: &Channel) -> Option<Finding> {
    let found = clipped(&channel.value).filter(|_| !super::content::is_input(channel))?;
    Some(
        Finding::new(Check::Saturation, Severity::Fault, &channel.name, found.level, &channel.unit)
            .because(format!(
                "{} samples ({} %) stand at {} {}, more than any motion has at its extreme",
                found.samples,
                short(100.0 * found.share),
                short(found.level),
                channel.unit
            ))
            .cure(OUT_OF_RANGE),
    )
}

const OUT_OF_RANGE: &str = "leave these samples out (they are bounds, not measurements), or repeat with more range";

/// Cubic through the four neighbours against the sample: the answer to one spike.
const SPIKE: [f64; 5] = [1.0 / 6.0, -2.0 / 3.0, 1.0, -2.0 / 3.0, 1.0 / 6.0];

/// Isolated samples that the four neighbours exclude.
///
/// The residual against the cubic through the neighbours shows a spike as the pattern [`SPIKE`]; a
/// step, a corner or a burst shows another. Reported where the residual exceeds the normal quantile
/// at `FALSE_ALARM / (2 n channels)` of a local robust scale, widened by the scale's own scatter,
/// and the pattern holds 95 % of the energy.
fn spikes(channel: &Channel, lattice: Option<&Lattice>, channels: f64) -> Option<Finding> {
    let value = &channel.value;
    let n = value.len();
    if n < 64 || channel.role == Role::Input {
        return None;
    }
    let residual: Vec<f64> = (2..n - 2).map(|i| (0..5).map(|k| SPIKE[k] * value[i + k - 2]).sum::<f64>()).collect();
    let half = 40;
    // A scale from about 80 correlated residuals scatters by some 12 %: three of its standard
    // errors.
    let level = normal_two_sided(FALSE_ALARM / (n as f64 * channels)) * 1.35;
    let floor = lattice.map_or(0.0, |l| l.step) + 1e-12 * rms(value);
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    for i in 2..residual.len().saturating_sub(2) {
        let size = residual[i].abs();
        let beside = |k: usize| -residual[k] / residual[i];
        let near = (i.saturating_sub(12)..(i + 13).min(residual.len()))
            .filter(|k| k.abs_diff(i) > 2)
            .map(|k| residual[k].abs())
            .fold(0.0, f64::max);
        // Isolated: four times all that is near (noise alone reaches 2.5 sigma there), both
        // neighbours drawn the other way (a step draws one).
        let alone = size > 4.0 * near && [i - 1, i + 1].iter().all(|&k| (0.4..0.95).contains(&beside(k)));
        if size <= 3.0 * floor || !alone {
            continue;
        }
        let (from, to) = (i.saturating_sub(half), (i + half).min(residual.len()));
        let mut around: Vec<f64> = (from..to).filter(|k| k.abs_diff(i) > 2).map(|k| residual[k].abs()).collect();
        let scale = (1.4826 * median(&mut around)).max(floor / 3.0);
        let local = &residual[i - 2..=i + 2];
        let norm: f64 = SPIKE.iter().map(|s| s * s).sum();
        let amplitude = local.iter().zip(SPIKE).map(|(r, s)| r * s).sum::<f64>() / norm;
        let energy: f64 = local.iter().map(|r| r * r).sum();
        if size > level * scale && amplitude * amplitude * norm > 0.95 * energy {
            found.push((i + 2, amplitude, size / scale));
        }
    }
    let worst = found.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
    let severity = if worst.1.abs() > 1e-3 * deviation(value) { Severity::Warning } else { Severity::Note };
    Some(
        Finding::new(Check::Spikes, severity, &channel.name, found.len() as f64, "samples")
            .because(format!(
                "{} isolated sample(s) excluded by their neighbours; the worst at {} s by {} {} ({} robust sigma; noise alone reaches {})",
                found.len(), short(channel.time_s[worst.0]), short(worst.1), channel.unit, short(worst.2), short(level)
            ))
            .cure("leave them out or use a robust estimator; look for drop-outs of the link"),
    )
}

/// Angles with jumps of one turn taken out, and what was found; the recording itself where none is.
pub fn unwrap_angles(recording: &Recording) -> (Cow<'_, Recording>, Vec<Finding>) {
    let (mut out, mut findings) = (Cow::Borrowed(recording), Vec::new());
    for (k, channel) in recording.channels.iter().enumerate() {
        let Some(turn) = quantity::of(&channel.unit).filter(quantity::Quantity::is_angle).map(|q| 2.0 * PI / q.factor)
        else {
            continue;
        };
        let mut ordinary: Vec<f64> = channel.value.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        let wraps = ordinary.iter().filter(|step| (**step - turn).abs() < 0.25 * turn).count();
        if wraps == 0 || median(&mut ordinary) > 0.1 * turn {
            continue;
        }
        unwrap(&mut out.to_mut().channels[k].value, turn);
        findings.push(
            Finding::new(Check::WrappedAngle, Severity::Note, &channel.name, wraps as f64, "jumps")
                .because(format!("{wraps} jump(s) of one turn ({} {})", short(turn), channel.unit))
                .cure("unwrap before fitting (done here for the other checks)"),
        );
    }
    (out, findings)
}

/// Takes the jumps of about one turn out.
fn unwrap(values: &mut [f64], turn: f64) {
    let (mut shift, mut previous) = (0.0, values[0]);
    for value in values {
        let step = *value - previous;
        previous = *value;
        if (step.abs() - turn).abs() < 0.25 * turn {
            shift -= turn * step.signum();
        }
        *value += shift;
    }
}
