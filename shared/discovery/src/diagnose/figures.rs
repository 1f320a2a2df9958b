//! Data of the report's figures, thinned to what a figure resolves.

use super::report::{EvidenceCurve, LawCell, LawMap, Overlay, Tile};
use crate::unknown_law::{Acts, Cell, Coordinate, UnknownLaw};
use core::f64::consts::TAU;
use identification::fit::EstimationSession;
use identification::held_out::{Predictor, free_residual};

/// Windows of a recording, and points of a curve.
const WINDOWS: usize = 16;
const CURVE_POINTS_MAX: usize = 1500;

/// Power of windows and octaves of every channel's innovations, in standard errors from one.
pub(crate) fn tiles(session: &EstimationSession<'_>, before: &[f64], after: &[f64]) -> Vec<Tile> {
    let mut list = Vec::new();
    for (channel, sensor) in session.problem.plant.sensors.iter().enumerate() {
        for (run, offset) in session.offsets.iter().enumerate() {
            let timeline = &session.timelines[run];
            let own: Vec<usize> = (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).collect();
            let length = own.len() / WINDOWS;
            if length < 16 {
                continue;
            }
            for window in own.chunks_exact(length) {
                let times = [timeline.stamp_s[window[0]], timeline.stamp_s[window[length - 1]]];
                let rate_hz = (length - 1) as f64 / (times[1] - times[0]);
                let powers = |r: &[f64]| octaves(&window.iter().map(|s| r[offset + s]).collect::<Vec<_>>());
                for (octave, (z_before, z_after)) in powers(before).into_iter().zip(powers(after)).enumerate() {
                    let bins = [1usize << octave, 2 << octave];
                    let band_hz = bins.map(|bin| bin.min(length / 2) as f64 * rate_hz / length as f64);
                    list.push(Tile { channel: sensor.name.clone(), time: times, band_hz, z_before, z_after });
                }
            }
        }
    }
    list
}

/// Per octave of bins 1, 2–3, 4–7, …: `(mean of |X|²/n − 1) √bins`.
fn octaves(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let power = |bin: usize| -> f64 {
        let step = TAU * bin as f64 / n as f64;
        let (mut c, mut s) = (0.0, 0.0);
        for (i, x) in x.iter().enumerate() {
            let angle = step * i as f64;
            (c, s) = (c + x * libm::cos(angle), s + x * libm::sin(angle));
        }
        (c * c + s * s) / n as f64
    };
    let mut list = Vec::new();
    let mut first = 1;
    while first < n / 2 {
        let bins: Vec<usize> = (first..(2 * first).min(n / 2)).collect();
        // a band of many bins is known well enough from some of them
        let every = (bins.len() / 32).max(1);
        let taken: Vec<f64> = bins.iter().step_by(every).map(|bin| power(*bin)).collect();
        let count = taken.len() as f64;
        list.push((taken.iter().sum::<f64>() / count - 1.0) * count.sqrt());
        first *= 2;
    }
    list
}

/// Gain in log-likelihood up to each instant, of effects of these kinds at these sites together:
/// whitened innovations without and with them. `None`: no effect.
pub(crate) fn curve(
    session: &EstimationSession<'_>,
    (before, after): (&[f64], &[f64]),
    [kind, site]: &[String; 2],
) -> Option<EvidenceCurve> {
    if kind.is_empty() {
        return None;
    }
    let (kind, site) = (kind.clone(), site.clone());
    let mut curve = EvidenceCurve { kind, site, time_s: Vec::new(), gain: Vec::new() };
    let every = (session.samples / CURVE_POINTS_MAX).max(1);
    let (mut sum, mut count, mut origin) = (0.0, 0, 0.0);
    for (run, offset) in session.offsets.iter().enumerate() {
        let timeline = &session.timelines[run];
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        let mut last = first;
        for event in timeline.events.iter().filter(|event| event.count > 0) {
            for s in offset + event.first..offset + event.first + event.count {
                sum += 0.5 * (before[s] * before[s] - after[s] * after[s]);
                count += 1;
                if count % every == 0 {
                    curve.time_s.push(origin + event.t_s - first);
                    curve.gain.push(sum);
                }
            }
            last = event.t_s;
        }
        origin += last - first;
    }
    Some(curve)
}

/// The data and the fitted law over its coordinates.
pub(crate) fn state_map(session: &EstimationSession<'_>, map: &UnknownLaw) -> LawMap {
    let plant = &session.problem.plant;
    let site = &map.place.site;
    let of_joint = |name: &str| -> String {
        let joint = name.trim_start_matches("joint:").trim_end_matches(".rate");
        let slides = plant.bodies.iter().any(|body| {
            body.joint.name == joint && matches!(body.joint.kind, dynamics::description::JointKind::Prismatic { .. })
        });
        if slides || name.starts_with("tank:") { "m".to_owned() } else { "rad".to_owned() }
    };
    let (quantity, own) = match map.place.acts {
        Acts::Force(_) => (format!("force at {site}"), if of_joint(site) == "m" { "N" } else { "N m" }),
        Acts::Reading(channel) => (format!("error of {site}"), plant.sensor_unit(&plant.sensors[channel])),
    };
    let axis = |k: usize| {
        let (Some(name), Some(coordinate)) = (map.names.get(k), map.place.along.get(k)) else {
            return (String::new(), String::new());
        };
        let unit = match coordinate {
            Coordinate::Time => "s".to_owned(),
            Coordinate::Reading => own.to_owned(),
            Coordinate::ReadingRate | Coordinate::CommandRate(_) => format!("{own}/s"),
            Coordinate::Command(_) => own.to_owned(),
            Coordinate::State(_) if name.ends_with(".rate") => format!("{}/s", of_joint(name)),
            Coordinate::State(_) => of_joint(name),
        };
        (name.clone(), unit)
    };
    let cell = |c: &Cell| LawCell { x: c.at[0], y: c.at[1], value: c.value, sigma: c.sigma };
    LawMap { quantity, unit: own.to_owned(), x: axis(0), y: axis(1), cells: map.cells.iter().map(cell).collect() }
}

/// Free runs of both plants over the first run of held-out data.
pub(super) fn overlays(
    before: (&EstimationSession<'_>, Predictor<'_>),
    after: (&EstimationSession<'_>, Predictor<'_>),
) -> Vec<Overlay> {
    let (Some((b, first)), Some((a, _))) = (free_residual(before.0, before.1, 0), free_residual(after.0, after.1, 0))
    else {
        return Vec::new();
    };
    let timeline = &before.0.timelines[0];
    let begin = timeline.events.get(first).map_or(0, |event| event.first);
    let plant = &before.0.problem.plant;
    let mut list = Vec::new();
    for (channel, sensor) in plant.sensors.iter().enumerate() {
        let own: Vec<usize> = (begin..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).collect();
        let taken: Vec<usize> = own.iter().copied().step_by((own.len() / CURVE_POINTS_MAX).max(1)).collect();
        if taken.is_empty() {
            continue;
        }
        let of = |f: &dyn Fn(usize) -> f64| taken.iter().map(|s| f(*s)).collect::<Vec<f64>>();
        list.push(Overlay {
            channel: sensor.name.clone(),
            unit: plant.sensor_unit(sensor).to_owned(),
            time_s: of(&|s| timeline.stamp_s[s]),
            measured: of(&|s| timeline.value[s]),
            before: of(&|s| timeline.value[s] - b[s]),
            after: of(&|s| timeline.value[s] - a[s]),
        });
    }
    list
}
