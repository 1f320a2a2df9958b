//! What separates two channels, in one word and one sentence.
//!
//! One number that explains half of the difference comes first; then noise alone; then that the two
//! have nothing to do with each other; then the place to which the difference is confined.

use super::align::Corrections;
use super::locate::{Band, locate};
use super::{ChannelComparison, Correction, FALSE_ALARM, Pair, Verdict, constant, fit_percent};
use crate::doctor::short;
use crate::spectrum::{Averaging, density};
use channels::Recording;
use identification::statistics::{deviation, mean, rms};

/// An explanation must take away this share of the squared difference to be the conclusion.
const EXPLAINED_SHARE: f64 = 0.5;
/// Share of the recorded variance below which the simulation, scaled or shifted at will, has
/// nothing to do with it.
const RELATED_SHARE: f64 = 0.1;

pub(super) fn conclude(
    c: &ChannelComparison,
    all: &Corrections,
    p: &Pair,
    recording: &Recording,
    error: &[f64],
) -> (Verdict, String) {
    let before = rms(error).powi(2);
    let share = |x: &Correction| 1.0 - rms(&x.residual).powi(2) / before;
    let spread = deviation(&p.real).powi(2);
    // a gain near zero takes away a simulation that explains nothing: it has to explain what was
    // recorded
    let explains = |x: &Correction| !constant(&p.real) && rms(&x.residual).powi(2) <= EXPLAINED_SHARE * spread;
    let named = [
        (Verdict::Offset, &all.offset),
        (Verdict::Scale, &all.scale),
        (Verdict::Lag, &all.lag),
        (Verdict::Sign, &all.sign),
    ];
    let significant = || named.iter().filter(|(_, x)| x.significant(FALSE_ALARM));
    let best = significant()
        .filter(|(verdict, x)| !matches!(verdict, Verdict::Scale | Verdict::Sign) || explains(x))
        .max_by(|a, b| share(a.1).total_cmp(&share(b.1)));
    if let Some((verdict, correction)) = best
        && share(correction) >= EXPLAINED_SHARE
    {
        return corrected(*verdict, correction, (c, all), p, recording, share(correction));
    }
    if c.windows.is_empty() && c.bands.is_empty() && c.coherence.is_empty() && significant().next().is_none() {
        let sigma = c.noise_sigma.unwrap_or(c.rms);
        let text = format!("only noise ({} {} rms, mean {})", short(sigma), c.unit, short(mean(error)));
        return (Verdict::OnlyNoise, text);
    }
    let common = |x: &Correction| 1.0 - rms(&x.residual).powi(2) / spread;
    if !constant(&p.real) && !constant(&p.simulated) {
        let most = [&all.scale, &all.lag].into_iter().map(common).fold(0.0, f64::max);
        if most < RELATED_SHARE {
            let text = format!(
                "unrelated: scaled or shifted at will, the simulation explains {} % of what was recorded",
                short(100.0 * most)
            );
            return (Verdict::Unrelated, text);
        }
    }
    placed(c, p, before)
}

/// What one number explains, and what it leaves.
fn corrected(
    verdict: Verdict,
    correction: &Correction,
    (c, all): (&ChannelComparison, &Corrections),
    p: &Pair,
    recording: &Recording,
    share: f64,
) -> (Verdict, String) {
    let turned = verdict == Verdict::Sign || (verdict == Verdict::Scale && correction.value < 0.0);
    let verdict = if turned { Verdict::Sign } else { verdict };
    let what = match verdict {
        Verdict::Lag => {
            format!("differs by a lag of {} ± {} ms", short(1e3 * correction.value), short(1e3 * correction.sigma))
        }
        Verdict::Scale => format!("differs by a gain of {} ± {}", short(correction.value), short(correction.sigma)),
        Verdict::Offset => {
            format!("differs by an offset of {} ± {} {}", short(correction.value), short(correction.sigma), c.unit)
        }
        _ => format!("has the opposite sign, gain {} ± {}", short(all.scale.value), short(all.scale.sigma)),
    };
    let rest = locate(&correction.residual, p, recording, &c.name);
    if rest.silent() {
        return (verdict, format!("{what}; the rest is noise"));
    }
    let fit = fit_percent(&correction.residual, &p.real).map_or_else(String::new, |f| format!(", fit {} %", short(f)));
    let left = rest.bands.first().map_or_else(String::new, band_text);
    let share = short(100.0 * share);
    (verdict, format!("{what}; takes {share} % of the squared difference{fit}; more is left{left}"))
}

/// Where the difference is confined to, if to anything.
fn placed(c: &ChannelComparison, p: &Pair, power: f64) -> (Verdict, String) {
    let follows = c
        .coherence
        .first()
        .map_or_else(String::new, |k| format!("; {} % of it follows {}", short(100.0 * k.share), k.channel));
    let in_band = |b: &&Band| b.rms * b.rms > EXPLAINED_SHARE * power && b.confined;
    // in the band of the motion itself any error of the model shows: that band tells nothing apart
    if let Some(band) = c.bands.first().filter(in_band).filter(|b| share_in(&p.real, p.dt_s, b) < EXPLAINED_SHARE) {
        return (Verdict::Band, format!("differs{}{follows}", band_text(band)));
    }
    if let Some(window) = c.windows.first().filter(|w| w.share > EXPLAINED_SHARE && w.confined) {
        return (
            Verdict::Window,
            format!(
                "differs in {}-{} s ({} % of the squared difference){follows}",
                short(window.start_s),
                short(window.end_s),
                short(100.0 * window.share)
            ),
        );
    }
    let fit = c.fit_percent.map_or_else(String::new, |f| format!(" (fit {} %)", short(f)));
    let place = c.bands.first().map_or_else(String::new, |b| format!(", most{}", band_text(b)));
    (Verdict::Unexplained, format!("differs{fit}: no lag, gain, sign or offset alone takes half of it{place}{follows}"))
}

/// Share of a channel's variance that lies in a band.
fn share_in(value: &[f64], dt_s: f64, band: &Band) -> f64 {
    let middle = mean(value);
    let centred: Vec<f64> = value.iter().map(|v| v - middle).collect();
    let s = density(&centred, dt_s, Averaging::for_length(centred.len()));
    let lines = || s.frequency_hz.iter().zip(&s.density).skip(1);
    let inside: f64 = lines().filter(|(f, _)| (band.low_hz..=band.high_hz).contains(*f)).map(|(_, d)| d).sum();
    inside / lines().map(|(_, d)| d).sum::<f64>().max(f64::MIN_POSITIVE)
}

fn band_text(band: &Band) -> String {
    format!(" in the band {}-{} Hz", short(band.low_hz), short(band.high_hz))
}
