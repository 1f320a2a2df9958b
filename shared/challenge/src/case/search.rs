//! The amplitude of a planned detectability d, and the nearest rival of an effect.

use crate::bench::Entry;
use crate::hidden::Hidden;
use crate::random::Draw;
use crate::realised::{Lab, Realised, cosine};

/// Rounds of scaling towards the planned d.
const ROUNDS: usize = 5;

/// An entry with its shape drawn, at the amplitude where the search begins.
pub fn shaped(entry: &Entry, draw: &mut Draw) -> Hidden {
    let (name, start, _) = entry.amplitude;
    let sign = if entry.signed { draw.sign() } else { 1.0 };
    let mut values = vec![(name.to_owned(), sign * start)];
    for (name, low, high) in entry.shape {
        let value = if low < high { draw.log_uniform(*low, *high) } else { *low };
        values.push(((*name).to_owned(), value));
    }
    Hidden { kind: entry.kind.to_owned(), site: entry.site.to_owned(), values }
}

/// Scales `hidden` until its d is `planned` to 10 %; `None`: no amplitude in its range gives 0.6 to
/// 1.7 of it.
pub fn scale(lab: &Lab<'_>, entry: &Entry, hidden: &Hidden, planned: f64) -> Option<(Hidden, Realised)> {
    let (_, start, limit) = entry.amplitude;
    // a lag or a gear much faster than anything here costs time and shows nothing
    let least = start / 30.0;
    let mut best: Option<(Hidden, Realised)> = None;
    let mut amplitude = hidden.amplitude();
    for round in 0..ROUNDS {
        let trial = hidden.scaled(amplitude);
        let found = lab.realised(&[(trial.clone(), entry.seat)], round > 0);
        if !found.d.is_finite() {
            amplitude *= 0.1;
            continue;
        }
        let ratio = planned / found.d.max(1e-6);
        let at_limit = amplitude.abs() >= limit && ratio > 1.0 || amplitude.abs() <= least && ratio < 1.0;
        let near = (ratio - 1.0).abs() < 0.1;
        if round > 0 {
            best = Some((trial, found));
        }
        if (near && best.is_some()) || at_limit {
            break;
        }
        amplitude = (amplitude.abs() * ratio.clamp(0.02, 50.0)).clamp(least, limit) * hidden.amplitude().signum();
    }
    best.filter(|(_, found)| found.d > 0.6 * planned && found.d < 1.7 * planned)
}

/// Largest |cosine| with the other entries of the menu and the bench's rivals that `are_there`,
/// each at the first amplitude of its search.
pub fn rival(
    lab: &Lab<'_>,
    own: &Hidden,
    direction: &Realised,
    draw: &mut Draw,
    are_there: &dyn Fn(&Entry) -> bool,
) -> (f64, String) {
    let mut most = (0.0, String::new());
    let others = lab.bench.menu.iter().chain(lab.bench.rivals);
    for entry in others.filter(|e| e.kind != own.kind || e.site != own.site) {
        let rival = lab.realised(&[(shaped(entry, draw), entry.seat)], false);
        let rho = cosine(&direction.direction, &rival.direction).abs();
        if rho > most.0 && are_there(entry) {
            most = (rho, format!("{}@{}", entry.kind, entry.site));
        }
    }
    most
}
