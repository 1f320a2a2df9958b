//! The noise of a recording against the stated one, as probability, as share and in words.

use super::Findings;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit};
use identification::statistics::chi_squared_tail;

/// The stated noise; disturbances of unspecified size count only upwards.
fn as_stated(session: &EstimationSession<'_>, found: &NoiseModel) -> NoiseModel {
    let mut stated = session.noise.clone();
    for ((own, found), actuator) in stated.input_sigma.iter_mut().zip(&found.input_sigma).zip(&session.noise_names) {
        let known = session.problem.plant.actuator(actuator).is_some_and(|a| a.noise.value > 0.0);
        if !known && *found < *own {
            *own = *found;
        }
    }
    stated
}

/// Least `−2 ln p` of `fit` under `noise`, its parameters free.
fn least(session: &EstimationSession<'_>, fit: &Fit, noise: &NoiseModel) -> Option<f64> {
    Some(fit.linearised.normal(session, &fit.theta, noise, &[])?.minimum()?.0)
}

/// p value of the stated against the adapted noise: χ² tail of the likelihood ratio.
pub(in crate::diagnose) fn noise_p(
    session: &EstimationSession<'_>,
    stated: &Fit,
    adapted: &Fit,
    noise: &NoiseModel,
    objective: f64,
) -> f64 {
    let as_stated = as_stated(session, noise);
    let jittering = noise.jitter_s.iter().filter(|jitter| **jitter > 0.0).count();
    let freedom = (noise.input_sigma.len() + 2 * noise.sensor_sigma.len() + jittering) as f64;
    match [stated, adapted].into_iter().filter_map(|fit| least(session, fit, &as_stated)).min_by(f64::total_cmp) {
        Some(before) => chi_squared_tail((before - objective + session.disturbance_price(noise)).max(0.0), freedom),
        None => 0.0,
    }
}

/// Share of the misfit that the adopted effects remove while no disturbance, and unless granted no
/// reading, has a higher variance than stated; the rest of the misfit needed more noise. Lower
/// variances, colour and jitter are granted.
pub(super) fn share_explained(findings: &Findings<'_>, grants_readings: bool) -> Option<f64> {
    let (session, best) = (findings.session, findings.best);
    let mut noise = best.noise.clone();
    let capped = |found: &mut [f64], stated: &[f64]| found.iter_mut().zip(stated).for_each(|(f, s)| *f = f.min(*s));
    capped(&mut noise.input_sigma, &session.noise.input_sigma);
    if !grants_readings {
        capped(&mut noise.sensor_sigma, &session.noise.sensor_sigma);
    }
    let own = EstimationSession::like(session, &best.problem).ok()?;
    let before = least(session, findings.stated, &noise)?;
    let (after, free) = (least(&own, &best.fit, &noise)?, least(&own, &best.fit, &best.noise)?);
    Some((before - after) / (before - free).max(f64::MIN_POSITIVE))
}

/// Gain in `−2 ln p` from which a change of the noise is reported by itself: odds of exp(5) = 150 :
/// 1. Chosen, no derivation; it affects the sentence only.
const NOISE_CHANGE_GAIN_MIN: f64 = 10.0;

/// The largest changes between stated and adapted noise, in words.
pub(super) fn changed_noise(findings: &Findings<'_>) -> String {
    let (session, best) = (findings.session, findings.best);
    let mut list = changes(session, &best.noise);
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    let objective = |noise: &NoiseModel| {
        let normal = best.fit.linearised.normal(session, &best.fit.theta, noise, &[]);
        normal.and_then(|normal| normal.minimum_without()).unwrap_or(f64::INFINITY) + session.disturbance_price(noise)
    };
    let least = objective(&best.noise);
    let (worth, rest): (Vec<_>, Vec<_>) =
        list.into_iter().partition(|(.., before)| objective(before) > least + NOISE_CHANGE_GAIN_MIN);
    let reported = if worth.is_empty() { rest } else { worth };
    reported.into_iter().take(3).map(|(_, text, _)| text).collect::<Vec<_>>().join(", ")
}

/// Every parameter of the noise that was adapted: the size of its change, in words, and the noise
/// without it.
fn changes(session: &EstimationSession<'_>, noise: &NoiseModel) -> Vec<(f64, String, NoiseModel)> {
    let mut list = Vec::new();
    let stated = &session.noise;
    let mut push = |size: f64, text: String, back: &dyn Fn(&mut NoiseModel)| {
        let mut before = noise.clone();
        back(&mut before);
        list.push((size, text, before));
    };
    for (i, sensor) in session.problem.plant.sensors.iter().enumerate() {
        let (name, factor) = (&sensor.name, noise.sensor_sigma[i] / stated.sensor_sigma[i]);
        push(libm::log(factor).abs(), format!("{name} x{factor:.2}"), &|n| n.sensor_sigma[i] = stated.sensor_sigma[i]);
        let jitter = noise.jitter_s[i] / session.interval_s(i);
        if jitter > 0.0 {
            // a hundredth of an interval counts as much as a factor of e
            let text = format!("stamps of {name} jitter by {:.1} % of the interval", 100.0 * jitter);
            push(libm::log(1.0 + 100.0 * jitter), text, &|n| n.jitter_s[i] = 0.0);
        }
        let colour = libm::atanh(noise.pole[i].abs().min(0.999));
        push(colour, format!("{name} correlated, pole {:.2}", noise.pole[i]), &|n| n.pole[i] = 0.0);
    }
    for (i, name) in session.noise_names.iter().enumerate() {
        let factor = noise.input_sigma[i] / stated.input_sigma[i];
        if factor > 1.0 {
            let text = format!("{name} x{factor:.3}");
            push(0.3 * libm::log(factor), text, &|n| n.input_sigma[i] = stated.input_sigma[i]);
        }
    }
    list
}
