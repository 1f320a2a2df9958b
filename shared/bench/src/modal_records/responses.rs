//! Modes of frequency responses of structures drawn at random: how many are
//! missed and invented, and whether errors are as large as their standard deviations.
//!
//! A structure has two to four modes of 0.3–3 % damping, in one of three draws a close pair, one to
//! ten channels, and one mode more above the lines. Responses are closed forms with normal noise of
//! 2–10 % of the root mean square, or estimates H1 of simulated records under random force.

use super::responding::{Draw, Record, Structure};
use modal::c64;
use modal::frequency_responses::identify;
use serde::Serialize;

/// Largest damping ratio that is sought.
const DAMPING_MAX: f64 = 0.25;

/// How the lines are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Closed form, noise of one variance per channel.
    Additive,
    /// Closed form, noise in proportion to the response.
    Proportional,
    /// H1 of a record under random force.
    H1,
}

impl Kind {
    /// As the table of figures has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Additive => "responses, one noise",
            Self::Proportional => "in proportion",
            Self::H1 => "H1 of records",
        }
    }
}

/// Every kind, in the order of the rows.
pub const KINDS: [Kind; 3] = [Kind::Additive, Kind::Proportional, Kind::H1];

/// Statistics of one kind.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    pub kind: &'static str,
    pub trials: usize,
    pub modes: usize,
    pub missed: usize,
    pub invented: usize,
    /// Root mean square of error over stated deviation.
    pub frequency_rms_z: f64,
    pub damping_rms_z: f64,
    /// Share of 95 % intervals that hold the truth.
    pub frequency_coverage: f64,
    pub damping_coverage: f64,
    /// Of the shapes' real and imaginary parts.
    pub shape_rms_z: Option<f64>,
}

/// Errors over deviations of one trial.
#[derive(Clone, Debug, Default)]
pub struct Trial {
    pub modes: usize,
    pub missed: Vec<(f64, f64)>,
    pub invented: Vec<(f64, f64)>,
    pub frequency_z: Vec<f64>,
    pub damping_z: Vec<f64>,
    pub shape_z: Vec<f64>,
}

/// A mode that was found: frequency, its deviation, damping, its deviation, shape with deviations.
struct Found {
    frequency: (f64, f64),
    damping: (f64, f64),
    shape: Vec<(c64, f64, f64)>,
}

/// One row for every kind whose name is wanted.
#[must_use]
pub fn run(wanted: impl Fn(&str) -> bool, trials: usize, seed: u64) -> Vec<Row> {
    KINDS
        .iter()
        .filter(|kind| wanted(kind.name()))
        .map(|kind| row(*kind, &(0..trials as u64).map(|k| trial(*kind, seed, k)).collect::<Vec<_>>()))
        .collect()
}

/// Statistics of the trials of one kind.
#[must_use]
pub fn row(kind: Kind, trials: &[Trial]) -> Row {
    let all = |of: fn(&Trial) -> &Vec<f64>| trials.iter().flat_map(|t| of(t).iter().copied()).collect::<Vec<f64>>();
    let rms = |z: &[f64]| (z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64).sqrt();
    let coverage = |z: &[f64]| z.iter().filter(|z| z.abs() < 1.96).count() as f64 / z.len().max(1) as f64;
    let (frequency, damping, shape) = (all(|t| &t.frequency_z), all(|t| &t.damping_z), all(|t| &t.shape_z));
    Row {
        kind: kind.name(),
        trials: trials.len(),
        modes: trials.iter().map(|t| t.modes).sum(),
        missed: trials.iter().map(|t| t.missed.len()).sum(),
        invented: trials.iter().map(|t| t.invented.len()).sum(),
        frequency_rms_z: rms(&frequency),
        damping_rms_z: rms(&damping),
        frequency_coverage: coverage(&frequency),
        damping_coverage: coverage(&damping),
        shape_rms_z: (!shape.is_empty()).then(|| rms(&shape)),
    }
}

/// One draw of one kind.
#[must_use]
pub fn trial(kind: Kind, seed: u64, number: u64) -> Trial {
    let mut draw = Draw::new(seed.wrapping_mul(1_000_003).wrapping_add(number));
    let structure = Structure::draw(&mut draw);
    let found = of_responses(kind, &structure, &mut draw);
    compared(&structure, found)
}

fn of_responses(kind: Kind, structure: &Structure, draw: &mut Draw) -> Vec<Found> {
    let (frequency_hz, responses) = match kind {
        Kind::H1 => Record::driven(structure, draw).h1(),
        _ => structure.noisy_responses(kind == Kind::Proportional, draw),
    };
    let Ok(fit) = identify(&frequency_hz, &responses, 2..=30, DAMPING_MAX) else {
        return Vec::new();
    };
    let found = |mode: &modal::frequency_responses::ResponseMode| Found {
        frequency: (mode.frequency_hz, mode.frequency_sd),
        damping: (mode.damping_ratio, mode.damping_sd),
        shape: mode.mode_shape.iter().zip(&mode.shape_sd).map(|(x, sd)| (*x, sd.re, sd.im)).collect(),
    };
    fit.modes.iter().map(found).collect()
}

/// Every true mode beside the nearest found one, within three half bandwidths or five deviations.
fn compared(structure: &Structure, mut found: Vec<Found>) -> Trial {
    let mut trial = Trial { modes: structure.modes.len(), ..Trial::default() };
    for (k, (f, zeta)) in structure.modes.iter().enumerate() {
        let distance = |mode: &Found| (mode.frequency.0 - f).abs();
        let near = |mode: &Found| distance(mode) < (3.0 * zeta * f).max(5.0 * mode.frequency.1);
        let nearest = (0..found.len())
            .filter(|m| near(&found[*m]))
            .min_by(|a, b| distance(&found[*a]).total_cmp(&distance(&found[*b])));
        let Some(nearest) = nearest else {
            trial.missed.push((*f, *zeta));
            continue;
        };
        let mode = found.swap_remove(nearest);
        trial.frequency_z.push((mode.frequency.0 - f) / mode.frequency.1);
        trial.damping_z.push((mode.damping.0 - zeta) / mode.damping.1);
        let whole = mode.shape.iter().position(|(x, ..)| (x - c64::new(1.0, 0.0)).norm_sqr() < 1e-20);
        for (c, (x, re, im)) in mode.shape.iter().enumerate() {
            if let Some(whole) = whole.filter(|whole| *whole != c) {
                let truth = structure.shapes[k][c] / structure.shapes[k][whole];
                trial.shape_z.extend([(x.re - truth) / re, x.im / im]);
            }
        }
    }
    trial.invented = found.iter().map(|mode| (mode.frequency.0, mode.damping.0)).collect();
    trial
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_modes_of_noisy_responses_are_as_large_as_their_deviations() {
        let trials: Vec<Trial> =
            [Kind::Additive, Kind::Proportional].iter().flat_map(|kind| (0..3).map(|k| trial(*kind, 61, k))).collect();
        let row = row(Kind::Additive, &trials);
        // 18 errors of unit variance each: one in a thousand is below 0.52, and beyond 1.53.
        for rms_z in [row.frequency_rms_z, row.damping_rms_z] {
            assert!(rms_z > 0.52 && rms_z < 1.53, "{row:?}");
        }
    }
}
