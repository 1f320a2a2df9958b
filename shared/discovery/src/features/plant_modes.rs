//! Modes of a plant: frequency, damping ratio, shape at the sensors, and which mode of a changed
//! plant is which of the one before.

use dynamics::description::Plant;
use dynamics::system::{System, SystemMode, Workspace};
use nalgebra::Complex;

/// An oscillating mode of a linearised plant.
#[derive(Clone, Debug)]
pub(super) struct PlantMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// State that takes the largest part.
    pub name: String,
    /// Share of every state.
    pub participation: Vec<f64>,
    /// Components at the requested sensors, up to one complex factor.
    pub shape: Vec<Complex<f64>>,
}

/// All oscillating modes about the place where the plant begins, at rest, by rising frequency;
/// shapes at the sensors called `channels`.
///
/// `None` where the plant has no such place, or no such sensor.
pub(super) fn plant_modes(plant: &Plant, channels: &[String]) -> Option<Vec<PlantMode>> {
    let system = System::new(plant).ok()?;
    let x = at_rest(plant, &system)?;
    let u = vec![0.0; system.inputs().len()];
    let mut workspace = Workspace::new(&system);
    let found = system.modes(&mut workspace, 0.0, &x, &u);
    let outputs: Option<Vec<usize>> =
        channels.iter().map(|name| system.outputs().iter().position(|output| output.name == *name)).collect();
    let outputs = outputs?;
    let space = (!outputs.is_empty()).then(|| system.linearise(&mut workspace, 0.0, &x, &u));
    let shape = |mode: &SystemMode| {
        let all = space.as_ref().map(|space| space.shape(mode.pole));
        all.map_or(Vec::new(), |all| outputs.iter().map(|k| all[*k]).collect())
    };
    let oscillates = |m: &&SystemMode| m.pole[1] > 1e-9 && m.damping_ratio.abs() < 0.999;
    let mode = |m: &SystemMode| PlantMode {
        frequency_hz: m.frequency_hz,
        damping_ratio: m.damping_ratio,
        name: m.label.clone(),
        participation: m.participation.clone(),
        shape: shape(m),
    };
    Some(found.modes.iter().filter(oscillates).map(mode).collect())
}

/// The state in which a plant begins, with all rates at zero.
pub(super) fn at_rest(plant: &Plant, system: &System) -> Option<Vec<f64>> {
    let x = system.initial_state(&plant.initial, &|_| None).ok()?;
    let rest = |(state, x): (&dynamics::system::StateName, &f64)| if state.name.ends_with(".rate") { 0.0 } else { *x };
    Some(system.states().iter().zip(&x).map(rest).collect())
}

/// `changed` in the order of `before`: mode for mode the one whose states take the same part, also
/// where frequencies have crossed.
///
/// `Σ √(p q)` over the participations p, q is 1 for the same mode; the largest overlaps are taken
/// first. `None` where modes came or went. Plants whose states are not the same are taken by rising
/// frequency.
pub(super) fn tracked(before: &[PlantMode], changed: Vec<PlantMode>) -> Option<Vec<PlantMode>> {
    let n = before.len();
    if changed.len() != n {
        return None;
    }
    let same_states = before.iter().zip(&changed).all(|(a, b)| a.participation.len() == b.participation.len());
    if !same_states {
        return Some(changed);
    }
    let overlap = |i: usize, j: usize| -> f64 {
        before[i].participation.iter().zip(&changed[j].participation).map(|(p, q)| (p * q).sqrt()).sum()
    };
    let mut all: Vec<(f64, usize, usize)> =
        (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| (overlap(i, j), i, j)).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut place, mut taken) = (vec![None; n], vec![false; n]);
    for (_, i, j) in all {
        if place[i].is_none() && !taken[j] {
            (place[i], taken[j]) = (Some(j), true);
        }
    }
    place.into_iter().map(|j| j.map(|j| changed[j].clone())).collect()
}
