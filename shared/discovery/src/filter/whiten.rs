//! Innovations of the frozen filter as those of the filter for another noise, whitened.
//!
//! Both filters run on the same linear model; their states differ by d:
//!
//! ```text
//! ν' = ν − H d − v̂',   d ← d + K' ν' − K ν,   d ← F d,   r = L'⁻¹ ν'
//! ```
//!
//! The map ν → r is linear, and the same for innovations and for columns of sensitivities.

use super::gains::Gains;
use super::linear::Linear;
use crate::problem::Timeline;

/// Whitens `columns` (each as long as the samples of the run) in place.
pub fn whiten(linear: &Linear, timeline: &Timeline, gains: &Gains, columns: &mut [&mut [f64]]) {
    for column in columns.iter_mut() {
        if gains.same_as_frozen {
            scale(timeline, gains, column);
        } else {
            one(linear, timeline, gains, column);
        }
    }
}

fn scale(timeline: &Timeline, gains: &Gains, column: &mut [f64]) {
    for (k, event) in timeline.events.iter().enumerate() {
        if event.count > 0 {
            let factor = &gains.factor[gains.factor_first[k]..];
            solve(factor, &mut column[event.first..event.first + event.count]);
        }
    }
}

/// `L⁻¹ b` in place.
fn solve(factor: &[f64], b: &mut [f64]) {
    let n = b.len();
    for a in 0..n {
        let known: f64 = (0..a).map(|i| factor[a * n + i] * b[i]).sum();
        b[a] = (b[a] - known) / factor[a * n + a];
    }
}

fn one(linear: &Linear, timeline: &Timeline, gains: &Gains, column: &mut [f64]) {
    let layout = &gains.layout;
    let (n, m, c, s) = (layout.tangent, layout.noise_inputs.len(), layout.clone, layout.len());
    let (row_len, len) = (n + m + c, n + m);
    let frozen_rows = linear.frozen.rows;
    let mut d = vec![0.0; s];
    let mut next = vec![0.0; n];
    let mut old = vec![0.0; timeline.events.iter().map(|event| event.count).max().unwrap_or(0)];
    for (k, event) in timeline.events.iter().enumerate() {
        for i in 0..m {
            if event.reset >> layout.noise_inputs[i].min(63) & 1 == 1 {
                d[n + i] = 0.0;
            }
        }
        if event.count > 0 {
            let nu = &mut column[event.first..event.first + event.count];
            for (slot, nu) in nu.iter_mut().enumerate() {
                old[slot] = *nu;
                let sample = event.first + slot;
                let channel = timeline.channel[sample];
                let row = &linear.measurement[sample * row_len..(sample + 1) * row_len];
                let direct: f64 = row[..len].iter().zip(&d).map(|(h, d)| h * d).sum::<f64>()
                    + row[len..].iter().zip(&d[layout.clone_at()..]).map(|(h, d)| h * d).sum::<f64>();
                let felt = match layout.lag_of[channel] {
                    None => direct,
                    Some(place) => {
                        let at = layout.lags_at() + place;
                        d[at] = linear.decay[sample] * d[at] + (1.0 - linear.decay[sample]) * direct;
                        d[at]
                    }
                };
                let colour = layout.colour_of[channel].map_or(0.0, |place| {
                    let at = layout.colours_at() + place;
                    d[at] *= gains.pole[channel];
                    d[at]
                });
                *nu -= felt + colour;
            }
            let gain = &gains.gain[gains.first[k]..];
            let frozen = &linear.frozen.gain[linear.frozen.first[k]..];
            for (i, d) in d.iter_mut().enumerate() {
                for slot in 0..event.count {
                    *d += gain[i * event.count + slot] * nu[slot];
                    if i < frozen_rows {
                        *d -= frozen[i * event.count + slot] * old[slot];
                    }
                }
            }
            solve(&gains.factor[gains.factor_first[k]..], nu);
        }
        if event.begins_mean && c > 0 {
            for i in 0..n {
                d[layout.clone_at() + i] = d[i];
            }
        }
        if k + 1 < timeline.events.len() {
            let transition = &linear.transition[k * n * len..(k + 1) * n * len];
            for (i, next) in next.iter_mut().enumerate() {
                *next = transition[i * len..(i + 1) * len].iter().zip(&d).map(|(f, d)| f * d).sum();
            }
            d[..n].copy_from_slice(&next);
        }
    }
}
