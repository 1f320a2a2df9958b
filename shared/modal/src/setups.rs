//! One structure measured in several setups: some sensors stay (references), the others move.
//!
//! [`merge`] identifies each setup by itself and merges the modes (PoSER: after estimation):
//! frequency and damping by their inverse variances, shapes glued by the references. Every setup's
//! shape is scaled by `w_j = ψ_ref/|ψ_ref|²` of its own references; all are then brought to the
//! scale of the first setup that shows the mode, `ψ_j / (wᴴ ψ_j,ref)`, so that a change of
//! excitation or a gain common to a setup leaves no trace. Deviations must have been stated for
//! that scale ([`crate::ShapeScale::FirstChannels`]); then those of the moving sensors hold the
//! error of the gluing.
//!
//! [`pre_scaled`] identifies all setups at once (PreGER: before estimation). With
//! `H_j,ref = U Z_j` (reference futures by reference pasts, U of the juxtaposed
//! `[H_1,ref/|H_1,ref| …]`), the moving rows of setup j are `H_j,mov Z_j⁺`, whatever its excitation
//! was. Döhler, Lam & Mevel 2013; Reynders, Magalhães, De Roeck & Cunha 2009.

mod pre_scaled;

use crate::mode_sets::{ModeSet, SetMode, compare};
use faer::c64;
pub use pre_scaled::pre_scaled;

/// Chance that references which agree are said to disagree.
const FALSE_ALARM: f64 = 0.001;

/// A mode of one setup.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub sigma_frequency_hz: f64,
    pub sigma_damping: f64,
    /// References first.
    pub shape: Vec<c64>,
    /// Of real and imaginary parts, the references holding the scale; empty where not known.
    pub shape_deviation: Vec<c64>,
}

/// Modes of one setup, in order of frequency.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// The references, then the sensors of this setup alone.
    pub channels: Vec<String>,
    pub modes: Vec<SetupMode>,
}

/// A mode of the whole structure.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub sigma_frequency_hz: f64,
    pub sigma_damping: f64,
    /// χ² of the frequencies of the setups about their mean, per degree of freedom; above 1 the
    /// deviations are widened by its root (Birge 1932). Of one setup 1.
    pub frequency_spread: f64,
    pub damping_spread: f64,
    /// References first, then the sensors of every setup; not a number where no setup that shows
    /// the mode has the sensor.
    pub shape: Vec<c64>,
    pub shape_deviation: Vec<c64>,
    /// Which mode of each setup.
    pub found_in: Vec<Option<usize>>,
    /// Largest difference of a reference component between a setup and the others, in its standard
    /// deviations, and the size that agreeing references exceed once in a thousand.
    pub reference_difference: f64,
    pub reference_limit: f64,
}

impl MergedMode {
    /// The references say the same in all setups, as far as their deviations tell.
    #[must_use]
    pub fn references_agree(&self) -> bool {
        self.reference_difference <= self.reference_limit
    }
}

/// Channels of the whole, and its modes in order of frequency.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    pub channels: Vec<String>,
    pub modes: Vec<MergedMode>,
}

/// Merges the modes of setups whose first `references` channels are the same sensors.
///
/// Modes are matched over the references ([`compare`]).
///
/// # Panics
/// When there are no references or no setups.
#[must_use]
pub fn merge(setups: &[Setup], references: usize) -> Merged {
    assert!(references > 0 && !setups.is_empty());
    let channels: Vec<String> = setups[0].channels[..references]
        .iter()
        .chain(setups.iter().flat_map(|setup| &setup.channels[references..]))
        .cloned()
        .collect();
    let mut groups: Vec<Vec<Option<usize>>> = Vec::new();
    for (j, setup) in setups.iter().enumerate() {
        let known = ModeSet {
            channels: setup.channels[..references].to_vec(),
            modes: groups.iter().map(|group| first_of(setups, group, references)).collect(),
        };
        let here = ModeSet {
            channels: setup.channels[..references].to_vec(),
            modes: setup.modes.iter().map(|mode| over_references(mode, references)).collect(),
        };
        let pairs = compare(&here, &known).pairs;
        groups.iter_mut().for_each(|group| group.push(None));
        for row in 0..setup.modes.len() {
            match pairs.iter().find(|pair| pair.row == row) {
                Some(pair) => groups[pair.column][j] = Some(row),
                None => {
                    let mut group = vec![None; j];
                    group.push(Some(row));
                    groups.push(group);
                }
            }
        }
    }
    let mut modes: Vec<MergedMode> = groups.into_iter().map(|group| merged(setups, references, group)).collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Merged { channels, modes }
}

fn over_references(mode: &SetupMode, references: usize) -> SetMode {
    let (frequency_hz, damping_ratio) = (mode.frequency_hz, Some(mode.damping_ratio));
    SetMode { frequency_hz, damping_ratio, shape: mode.shape[..references].to_vec() }
}

fn first_of(setups: &[Setup], group: &[Option<usize>], references: usize) -> SetMode {
    let found = group.iter().enumerate().find_map(|(j, mode)| Some(&setups[j].modes[(*mode)?]));
    over_references(found.expect("a group begins with a mode"), references)
}

/// Mean by inverse variances, its deviation, χ² per degree of freedom.
fn weighted(values: &[(f64, f64)]) -> (f64, f64, f64) {
    let usable = values.iter().all(|(_, sigma)| *sigma > 0.0 && sigma.is_finite());
    let weight = |sigma: f64| if usable { 1.0 / (sigma * sigma) } else { 1.0 };
    let total: f64 = values.iter().map(|(_, sigma)| weight(*sigma)).sum();
    let mean = values.iter().map(|(x, sigma)| weight(*sigma) * x).sum::<f64>() / total;
    let squares: f64 = values.iter().map(|(x, sigma)| weight(*sigma) * (x - mean) * (x - mean)).sum();
    if !usable {
        return (mean, f64::NAN, f64::NAN);
    }
    let spread = if values.len() > 1 { squares / (values.len() - 1) as f64 } else { 1.0 };
    (mean, (spread.max(1.0) / total).sqrt(), spread)
}

fn merged(setups: &[Setup], references: usize, found_in: Vec<Option<usize>>) -> MergedMode {
    let members: Vec<(usize, &SetupMode)> =
        found_in.iter().enumerate().filter_map(|(j, mode)| Some((j, &setups[j].modes[(*mode)?]))).collect();
    let of = |get: &dyn Fn(&SetupMode) -> (f64, f64)| -> (f64, f64, f64) {
        weighted(&members.iter().map(|(_, mode)| get(mode)).collect::<Vec<_>>())
    };
    let (frequency_hz, sigma_frequency_hz, frequency_spread) = of(&|m| (m.frequency_hz, m.sigma_frequency_hz));
    let (damping_ratio, sigma_damping, damping_spread) = of(&|m| (m.damping_ratio, m.sigma_damping));
    let first = &members[0].1.shape[..references];
    let power: f64 = first.iter().map(c64::norm_sqr).sum();
    // ψ_j at the scale of the first member, and its deviations.
    let scaled: Vec<(usize, Vec<c64>, Vec<c64>)> = members
        .iter()
        .map(|(j, mode)| {
            let zero = c64::new(0.0, 0.0);
            let along = first.iter().zip(&mode.shape).fold(zero, |sum, (w, psi)| sum + w.conj() * psi) / power;
            let shape: Vec<c64> = mode.shape.iter().map(|psi| *psi / along).collect();
            (*j, shape, turned(&mode.shape_deviation, along))
        })
        .collect();
    let (mut shape, mut deviation) = (Vec::new(), Vec::new());
    let (mut difference, mut compared) = (0.0_f64, 0_usize);
    for c in 0..references {
        let components: Vec<(c64, c64)> = scaled
            .iter()
            .map(|(_, psi, sigma)| (psi[c], sigma.get(c).copied().unwrap_or(c64::new(f64::NAN, f64::NAN))))
            .collect();
        for part in [|x: &c64| x.re, |x: &c64| x.im] {
            let values: Vec<(f64, f64)> = components.iter().map(|(psi, sigma)| (part(psi), part(sigma))).collect();
            compared += values.len();
            difference = difference.max(largest_difference(&values));
        }
        let (re, im) = (
            weighted(&components.iter().map(|(psi, sigma)| (psi.re, sigma.re)).collect::<Vec<_>>()),
            weighted(&components.iter().map(|(psi, sigma)| (psi.im, sigma.im)).collect::<Vec<_>>()),
        );
        shape.push(c64::new(re.0, im.0));
        deviation.push(c64::new(re.1, im.1));
    }
    for (j, setup) in setups.iter().enumerate() {
        let own = scaled.iter().find(|member| member.0 == j);
        for c in references..setup.channels.len() {
            let unknown = c64::new(f64::NAN, f64::NAN);
            shape.push(own.map_or(unknown, |(_, psi, _)| psi[c]));
            deviation.push(own.and_then(|(.., sigma)| sigma.get(c).copied()).unwrap_or(unknown));
        }
    }
    normalise(&mut shape, &mut deviation);
    // P(|z| > t) < exp(−t²/2), over all comparisons.
    let reference_limit = (2.0 * libm::log(compared.max(1) as f64 / FALSE_ALARM)).sqrt();
    MergedMode {
        frequency_hz,
        damping_ratio,
        sigma_frequency_hz,
        sigma_damping,
        frequency_spread,
        damping_spread,
        shape,
        shape_deviation: deviation,
        found_in,
        reference_difference: difference,
        reference_limit,
    }
}

/// Largest difference of a value from the mean of the others, in its standard deviations; values
/// without deviations say nothing.
fn largest_difference(values: &[(f64, f64)]) -> f64 {
    let of = |k: usize| {
        let others: Vec<(f64, f64)> =
            values.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, value)| *value).collect();
        if others.is_empty() {
            return 0.0;
        }
        let total: f64 = others.iter().map(|(_, sigma)| 1.0 / (sigma * sigma)).sum();
        let mean = others.iter().map(|(x, sigma)| x / (sigma * sigma)).sum::<f64>() / total;
        let z = (values[k].0 - mean).abs() / (values[k].1 * values[k].1 + 1.0 / total).sqrt();
        if z.is_finite() { z } else { 0.0 }
    };
    (0..values.len()).map(of).fold(0.0, f64::max)
}

/// Deviations of parts behind a division by `by`, as if the parts erred independently.
fn turned(deviation: &[c64], by: c64) -> Vec<c64> {
    let scale = c64::new(1.0, 0.0) / by;
    let (c, s) = (scale.re * scale.re, scale.im * scale.im);
    deviation
        .iter()
        .map(|sigma| {
            let (re, im) = (sigma.re * sigma.re, sigma.im * sigma.im);
            c64::new((c * re + s * im).sqrt(), (s * re + c * im).sqrt())
        })
        .collect()
}

/// Largest known component 1.
fn normalise(shape: &mut [c64], deviation: &mut Vec<c64>) {
    let known = shape.iter().filter(|psi| psi.norm_sqr().is_finite());
    let largest = known.copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm_sqr() > a.norm_sqr() { b } else { a });
    if largest.norm_sqr() > 0.0 {
        shape.iter_mut().for_each(|psi| *psi /= largest);
        *deviation = turned(deviation, largest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(channels: &[&str], gain: f64, frequency_hz: f64, shape: &[f64]) -> Setup {
        let mode = SetupMode {
            frequency_hz,
            damping_ratio: 0.01,
            sigma_frequency_hz: 0.01,
            sigma_damping: 0.001,
            shape: shape.iter().map(|x| c64::new(gain * x, 0.0)).collect(),
            shape_deviation: vec![c64::new(0.01 * gain.abs(), 0.01 * gain.abs()); shape.len()],
        };
        Setup { channels: channels.iter().map(|c| (*c).to_string()).collect(), modes: vec![mode] }
    }

    #[test]
    fn shapes_are_glued_by_the_references_whatever_the_gain_of_a_setup() {
        let setups = [
            setup(&["r", "s", "a"], 1.0, 5.00, &[0.5, 0.25, 1.0]),
            setup(&["r", "s", "b"], -3.0, 5.01, &[0.5, 0.25, -0.8]),
        ];
        let merged = merge(&setups, 2);
        assert_eq!(merged.channels, ["r", "s", "a", "b"]);
        let mode = &merged.modes[0];
        for (psi, expected) in mode.shape.iter().zip([0.5, 0.25, 1.0, -0.8]) {
            assert!((psi.re - expected).abs() < 1e-12 && psi.im.abs() < 1e-12);
        }
        assert!(mode.references_agree() && (mode.frequency_hz - 5.005).abs() < 1e-12);
        assert!((mode.sigma_frequency_hz - 0.01 / 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn references_whose_ratio_changes_between_setups_are_reported() {
        let setups = [
            setup(&["r", "s", "a"], 1.0, 5.0, &[0.5, 0.25, 1.0]),
            setup(&["r", "s", "b"], 1.0, 5.0, &[0.5, 0.5, -0.8]),
        ];
        assert!(!merge(&setups, 2).modes[0].references_agree());
    }

    #[test]
    fn frequencies_that_differ_by_more_than_their_deviations_widen_the_deviation() {
        let setups = [setup(&["r", "a"], 1.0, 5.0, &[1.0, 0.5]), setup(&["r", "b"], 1.0, 5.1, &[1.0, 0.5])];
        let mode = &merge(&setups, 1).modes[0];
        // χ² = 2 (0.05/0.01)² = 50 of one degree of freedom.
        assert!((mode.frequency_spread - 50.0).abs() < 1e-9);
        assert!((mode.sigma_frequency_hz - 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_mode_of_one_setup_has_no_shape_at_the_sensors_of_the_other() {
        let mut first = setup(&["r", "a"], 1.0, 5.0, &[1.0, 0.5]);
        first.modes.extend(setup(&["r", "a"], 1.0, 25.0, &[1.0, -0.5]).modes);
        let merged = merge(&[first, setup(&["r", "b"], 1.0, 5.0, &[1.0, 0.5])], 1);
        assert_eq!(merged.modes.len(), 2);
        assert!(merged.modes[1].shape[2].re.is_nan() && merged.modes[1].found_in == [Some(1), None]);
    }
}
