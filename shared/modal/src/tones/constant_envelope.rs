//! Does the envelope of a band change as that of a driven mode does, or is it constant?
//!
//! `K = E|a|⁴ / (E|a|²)²` of the complex envelope is 2 for a Gaussian process (kurtosis 3 of the
//! samples) and 1 for a line (kurtosis 1.5), however its frequency wanders; a line of share ρ of
//! the power in a mode has 2 − ρ². A record holds about ζωT independent envelopes, and K of few is
//! low by chance; so its distribution is simulated for a mode of the damping that was found, drawn
//! with its deviation. Noise in the band makes more of them and K of a mode the nearer to 2:
//! leaving it out is on the safe side.

use crate::seeded::Seeded;
use core::f64::consts::TAU;
use faer::c64;

/// Simulated modes of which none may have as constant an envelope: p < 1e-3.
const SIMULATIONS: u64 = 1000;
/// Least damping drawn, relative to the estimate: three deviations at the least significance a
/// mode has.
const DAMPING_LEAST: f64 = 0.25;

/// Whether no mode of half width `cells` (± `sigma_cells`) has so constant an envelope.
pub(super) fn is_constant(envelope: &[c64], cells: f64, sigma_cells: f64) -> bool {
    let found = kurtosis(envelope);
    let mut random = Seeded::new(0xE7E1);
    (0..SIMULATIONS).all(|_| {
        let drawn = cells + sigma_cells * core::f64::consts::SQRT_2 * random.complex_normal().re;
        kurtosis(&mode(envelope.len(), drawn.max(DAMPING_LEAST * cells), &mut random)) > found
    })
}

/// Half width in cells of the mode whose spectrum is as wide: of a Lorentzian seen in a periodogram
/// `(Σ I)² / Σ I² = π g`, half of `2π g` because a line of it has twice its mean square.
pub(super) fn half_width(envelope: &[c64]) -> f64 {
    let n = envelope.len();
    let power = |k: usize| {
        let phase = |j: usize| super::fourier::turn(-TAU * (j * k % n) as f64 / n as f64);
        envelope.iter().enumerate().fold(c64::new(0.0, 0.0), |sum, (j, y)| sum + *y * phase(j)).norm_sqr()
    };
    let (mut first, mut second) = (0.0, 0.0);
    for p in (0..n).map(power) {
        first += p;
        second += p * p;
    }
    if second > 0.0 { first * first / second / core::f64::consts::PI } else { 1.0 }
}

/// `E|a|⁴ / (E|a|²)²`.
fn kurtosis(envelope: &[c64]) -> f64 {
    let (mut second, mut fourth) = (0.0, 0.0);
    for power in envelope.iter().map(c64::norm_sqr) {
        second += power;
        fourth += power * power;
    }
    if second > 0.0 { fourth * envelope.len() as f64 / (second * second) } else { 2.0 }
}

/// The envelope of a mode of half width `cells` over a record of `count` values.
fn mode(count: usize, cells: f64, random: &mut Seeded) -> Vec<c64> {
    let keep = libm::exp(-TAU * cells / count as f64);
    let drive = (1.0 - keep * keep).sqrt();
    let mut state = random.complex_normal();
    (0..count)
        .map(|_| {
            state = state * keep + random.complex_normal() * drive;
            state
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_taken_for_a_tone_less_often_than_once_in_a_hundred() {
        let mut random = Seeded::new(5);
        let constant = |_: &u32| is_constant(&mode(400, 3.0, &mut random), 3.0, 0.7);
        assert!((0..100).filter(constant).count() <= 1);
    }

    #[test]
    fn a_wandering_line_in_noise_has_a_constant_envelope() {
        let mut random = Seeded::new(6);
        let wandering: Vec<c64> = (0..400)
            .map(|j| {
                let phase = 20.0 * libm::sin(TAU * f64::from(j) / 100.0);
                super::super::fourier::turn(phase) + random.complex_normal() * 0.2
            })
            .collect();
        assert!(is_constant(&wandering, 5.0, 1.0));
    }
}
