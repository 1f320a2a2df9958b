//! Whiteness of innovations, and where the evidence for an effect lies.

use super::report::Where;
use crate::omnibus::StrongestBin;
use crate::unknown_law::{Acts, UnknownLaw};
use estimation::consistency::ljung_box;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit};
use identification::statistics::chi_squared_tail;

/// Lags of the whiteness statistic; chosen by custom, no derivation.
const LAGS: usize = 20;

/// Least p over channels of Ljung and Box's statistic over twenty lags, times the number of
/// channels; `None` where a covariance is not positive.
pub fn whiteness_p(session: &EstimationSession<'_>, fit: &Fit, noise: &NoiseModel) -> Option<f64> {
    let mut r = [fit.linearised.nu.clone()];
    fit.linearised.whiten(session, noise, &mut r)?;
    let channels = session.problem.plant.sensors.len();
    let mut least = 1.0f64;
    for channel in 0..channels {
        let mut series = Vec::new();
        for (run, offset) in session.offsets.iter().enumerate() {
            let timeline = &session.timelines[run];
            let own = (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel);
            // the first samples carry the error of the initial state
            series.extend(own.map(|s| r[0][offset + s]).skip(5));
        }
        // too short or constant: no evidence against whiteness
        least = least.min(ljung_box(&series, LAGS).map_or(1.0, |statistic| chi_squared_tail(statistic, LAGS as f64)));
    }
    Some((least * channels as f64).min(1.0))
}

/// Channel with most of `Σ c r`, and the middle eight tenths of `c²` over time, of whitened
/// innovations `r` and their change `c`.
pub(crate) fn place_of(
    session: &EstimationSession<'_>,
    change: &[f64],
    r: &[f64],
    (site, p): (String, f64),
) -> Option<Where> {
    let mut by_channel = vec![0.0; session.problem.plant.sensors.len()];
    let mut energy = Vec::with_capacity(r.len());
    for (run, offset) in session.offsets.iter().enumerate() {
        let timeline = &session.timelines[run];
        for event in &timeline.events {
            for sample in event.first..event.first + event.count {
                let c = change[offset + sample];
                by_channel[timeline.channel[sample]] += c * r[offset + sample];
                energy.push((event.t_s, c * c));
            }
        }
    }
    let channel = (0..by_channel.len()).max_by(|a, b| by_channel[*a].total_cmp(&by_channel[*b]))?;
    energy.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = energy.iter().map(|e| e.1).sum();
    let time_at = |share: f64| {
        let mut sum = 0.0;
        energy
            .iter()
            .find(|e| {
                sum += e.1;
                sum >= share * total
            })
            .map_or(0.0, |e| e.0)
    };
    Some(Where {
        channel: session.problem.plant.sensors[channel].name.clone(),
        site,
        time: [time_at(0.1), time_at(0.9)],
        band_hz: [0.0, 0.5 / session.timelines[0].period_s],
        states: Vec::new(),
        p,
    })
}

/// Where a time–frequency bin lies.
pub(crate) fn bin_location(session: &EstimationSession<'_>, bin: &StrongestBin) -> Where {
    let channel = session.problem.plant.sensors[bin.channel].name.clone();
    Where { site: channel.clone(), channel, time: bin.time_s, band_hz: bin.band_hz, states: Vec::new(), p: bin.p() }
}

/// Where an unknown law acts.
pub(crate) fn located(session: &EstimationSession<'_>, map: &UnknownLaw, alpha: f64) -> Where {
    let (begin, end) = session
        .problem
        .runs
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(b, e), run| (b.min(run.begin_s), e.max(run.end_s)));
    let channel = match map.place.acts {
        Acts::Reading(channel) => session.problem.plant.sensors[channel].name.clone(),
        Acts::Force(_) => String::new(),
    };
    Where {
        channel,
        site: map.place.site.clone(),
        time: [begin, end],
        band_hz: [0.0, 0.5 / session.timelines[0].period_s],
        states: map.names.clone(),
        p: (libm::exp(-0.5 * map.evidence) * map.tried as f64).min(alpha),
    }
}
