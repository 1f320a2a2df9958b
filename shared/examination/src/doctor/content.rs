//! What a channel's spectrum holds: energy left at the Nyquist frequency, noise whose level
//! changes, no signal at all.

use super::{Check, FALSE_ALARM, Finding, Severity, probability, short, usable};
use crate::spectrum::{Averaging, cross_spectrum, density};
use channels::{Channel, Recording, Role, common_grid};
use estimation::consistency::ljung_box;
use identification::statistics::{
    chi_squared_tail, difference_dependence, difference_sigma, fisher_tail, mean, white_floor,
};

/// A converter's filter should leave the top of the band this far below the peak: 20 dB.
const NYQUIST_SHARE: f64 = 0.01;
/// A change of the noise level below this ratio is not reported.
const NOISE_RATIO: f64 = 2.0;

/// Findings on the spectrum of each channel: aliasing, noise of changing level, no signal.
pub fn examine(recording: &Recording) -> Vec<Finding> {
    let channels = usable(recording, 64);
    let count = channels.len() as f64;
    let inputs: Vec<&Channel> = channels.iter().copied().filter(|c| is_input(c)).collect();
    let mut findings = Vec::new();
    for channel in &channels {
        if is_input(channel) {
            continue;
        }
        findings.extend(aliasing(channel, FALSE_ALARM / count));
        findings.extend(noise_level(channel, FALSE_ALARM / count));
        if !inputs.is_empty() {
            findings.extend(no_signal(channel, &inputs));
        }
    }
    findings
}

/// Said to be an input, or a force, torque, voltage or current of a recording that says nothing
/// about roles.
pub fn is_input(channel: &Channel) -> bool {
    match channel.role {
        Role::Input => true,
        Role::Output => false,
        Role::Unknown => super::quantity::of(&channel.unit).is_some_and(|q| q.drives()),
    }
}

/// The top tenth of the band less than 20 dB below the peak, and the upper half not flat: what is
/// there is no noise floor.
///
/// A flat upper half is a floor reached (or folded noise that nothing can tell from it) and stays
/// unreported.
fn aliasing(channel: &Channel, alpha: f64) -> Option<Finding> {
    let u = channel.uniform().filter(|u| u.value.len() >= 256 && !u.interpolated || u.value.len() >= 1024)?;
    let s = density(&u.value, u.dt_s, Averaging::for_length(u.value.len()));
    let nyquist = 0.5 / u.dt_s;
    let (top, _) = s.band(0.9 * nyquist, 1.01 * nyquist)?;
    let (low, low_freedom) = s.band(0.5 * nyquist, 0.75 * nyquist)?;
    let (high, high_freedom) = s.band(0.75 * nyquist, 1.01 * nyquist)?;
    let peak = (1..s.density.len()).max_by(|&i, &j| s.density[i].total_cmp(&s.density[j]))?;
    let ratio = if high > low { high / low } else { low / high };
    let p = 2.0
        * if high > low {
            fisher_tail(ratio, high_freedom, low_freedom)
        } else {
            fisher_tail(ratio, low_freedom, high_freedom)
        };
    // Half a decibel of tilt between the halves is a filter's droop, not a spectrum that goes on.
    if top < NYQUIST_SHARE * s.density[peak] || p > alpha || ratio < 1.12 {
        return None;
    }
    let down_db = 10.0 * libm::log10(s.density[peak] / top);
    Some(
        Finding::new(Check::Aliasing, Severity::Warning, &channel.name, down_db, "dB")
            .because(format!(
                "the spectrum is {} dB down at the Nyquist frequency ({} Hz) from its peak at {} Hz and still {} there ({} against a flat floor)",
                short(down_db), short(nyquist), short(s.frequency_hz[peak]), if high > low { "rising" } else { "falling" }, probability(p)
            ))
            .cure("what lies above the Nyquist frequency is folded into the band: sample faster or filter before the converter; fit below half of it"),
    )
}

/// White noise whose level differs between parts of the record: Bartlett's test on high differences
/// of blocks.
fn noise_level(channel: &Channel, alpha: f64) -> Option<Finding> {
    const ORDER: usize = 6;
    let u = channel.uniform().filter(|u| u.value.len() >= 512 && !u.interpolated)?;
    let step = crate::lattice::lattice(&u.value).map_or(0.0, |l| l.step);
    let floor = white_floor(&u.value)?;
    // Rounding noise follows the motion; its level is no property of the sensor.
    if !floor.flat || floor.sigma < step {
        return None;
    }
    let blocks = (u.value.len() / 400).clamp(2, 20);
    let size = u.value.len() / blocks;
    // The median over sub-blocks costs a third of the information (efficiency of a median: 2/pi).
    let nu = 0.64 * size as f64 / difference_dependence(ORDER);
    let block = |b: usize| &u.value[b * size..(b + 1) * size];
    let sigma: Vec<f64> = (0..blocks).map(|b| difference_sigma(block(b), ORDER)).collect();
    let loudest = (0..blocks).max_by(|&i, &j| sigma[i].total_cmp(&sigma[j]))?;
    let quietest = (0..blocks).min_by(|&i, &j| sigma[i].total_cmp(&sigma[j]))?;
    let variance: Vec<f64> = sigma.iter().map(|s| s * s).collect();
    let logs: Vec<f64> = variance.iter().map(|v| libm::log(v.max(1e-300))).collect();
    let statistic = nu * blocks as f64 * (libm::log(mean(&variance)) - mean(&logs))
        / (1.0 + (blocks as f64 + 1.0) / (3.0 * blocks as f64 * nu));
    let p = chi_squared_tail(statistic, blocks as f64 - 1.0);
    let ratio = sigma[loudest] / sigma[quietest];
    if p > alpha || ratio < NOISE_RATIO || !(white(block(loudest)) && white(block(quietest))) {
        return None;
    }
    Some(
        Finding::new(Check::NoiseLevel, Severity::Note, &channel.name, ratio, "-")
            .because(format!(
                "white noise from {} {} (at {} s) to {} {} (at {} s), blocks of {} s, {}",
                short(sigma[quietest]),
                channel.unit,
                short(u.time_s(quietest * size)),
                short(sigma[loudest]),
                channel.unit,
                short(u.time_s(loudest * size)),
                short(size as f64 * u.dt_s),
                probability(p)
            ))
            .cure(
                "one sigma for the whole record over-trusts the loud part: weight by parts, or find what shakes there",
            ),
    )
}

/// Whether the upper half of the band is flat to a decibel and a half: motion is not.
fn white(x: &[f64]) -> bool {
    let s = density(x, 1.0, Averaging::Multitaper { tapers: 7 });
    let levels: Vec<f64> =
        [(0.2, 0.3), (0.3, 0.4), (0.4, 0.51)].iter().filter_map(|(l, h)| s.band(*l, *h).map(|b| b.0)).collect();
    let (low, high) = levels.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    high < 1.41 * low
}

/// A measured channel that is white and follows no input.
fn no_signal(channel: &Channel, inputs: &[&Channel]) -> Option<Finding> {
    let u = channel.uniform().filter(|u| u.value.len() >= 256)?;
    let (m, n) = (mean(&u.value), u.value.len());
    let centred: Vec<f64> = u.value.iter().map(|v| v - m).collect();
    let power: f64 = centred.iter().map(|v| v * v).sum();
    const LJUNG_BOX_LAGS: usize = 20;
    if ljung_box(&centred, LJUNG_BOX_LAGS)
        .is_some_and(|statistic| chi_squared_tail(statistic, LJUNG_BOX_LAGS as f64) < 0.01)
    {
        return None;
    }
    for input in inputs {
        let (x, y) = common_grid(input, channel, 256)?;
        let s = cross_spectrum(&x.value, &y.value, x.dt_s, Averaging::for_length(x.value.len()));
        let level = s.coherence_level(0.01 / s.frequency_hz.len() as f64);
        if (1..s.frequency_hz.len()).any(|k| s.coherence(k) > level) {
            return None;
        }
    }
    let sigma = (power / n as f64).sqrt();
    Some(
        Finding::new(Check::NoSignal, Severity::Note, &channel.name, sigma, &channel.unit)
            .with(&inputs.iter().map(|c| c.name.as_str()).collect::<Vec<_>>())
            .because(format!("white (Ljung-Box over {LJUNG_BOX_LAGS} lags) with sigma {} {}, mean {}, and coherent with no input", short(sigma), channel.unit, short(m)))
            .cure("parameters that act on this channel alone cannot be found here; excite it, or use it to measure the noise"),
    )
}
