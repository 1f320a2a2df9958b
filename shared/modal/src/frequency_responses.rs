//! Modes of measured frequency responses: rational fractions of rising order until an order splits
//! or invents a mode, and weighted least squares from there.
//!
//! An order is accepted when all its poles decay, none beyond the damping sought, and no two lie
//! within each other's half-power bandwidths: a fraction with more poles than the responses have
//! modes spends them on halves of one peak, or on noise. Modes closer than their bandwidths are
//! therefore not separated here. Of the accepted orders the one of smallest
//! `n ln RSS + unknowns · ln n` (Schwarz 1978) is reported, RSS of the responses synthesised from
//! its modes.
//!
//! From its poles, weighted least squares of
//! `H_c(s) = Σ_k r_ck/(s − λ_k) + r̄_ck/(s − λ̄_k) + Σ_j ρ_cj s^j`, j ≥ −2, find the optimum
//! beside them (`refinement`), with the noise of the residual: one level per channel and, where
//! the residual shows it, a part in proportion to `|H|²` (`lines`). Standard deviations are those
//! of the Fisher information at that noise, freedom counted, with the covariance of the score that
//! correlated residuals of neighbouring lines give (windows, zero padding, leakage). At white
//! residuals the estimate has the Cramér–Rao bound. Pintelon & Schoukens 2012, ch. 9.

mod deviations;
mod leakage;
mod lines;
mod refinement;

use crate::projection::Basis;
use crate::rational_fraction::{Orders, RfpError, of_responses};
use crate::residual_correlation::lines_of;
use faer::c64;
use lines::ResponseLines;
use refinement::Refined;
use std::ops::RangeInclusive;

/// Terms of a channel for the modes outside the lines.
const RESIDUAL_TERMS: usize = 3;
/// Least damping ratio in its standard deviations. A fraction spends a pole on the highest of the
/// lines' noise peaks; its width is that of chance.
const DAMPING_SIGNIFICANCE: f64 = 3.0;
/// Orders above the accepted one that are tried where it leaves more than noise.
const REJECTED_TRIED: usize = 4;
/// Orders tried beyond the last accepted one.
const ORDERS_BEYOND: usize = 3;

/// A mode of the responses.
#[derive(Clone, Debug)]
pub struct ResponseMode {
    /// Continuous-time pole [1/s].
    pub pole: c64,
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Standard deviation of the frequency \[Hz\].
    pub frequency_sd: f64,
    /// Standard deviation of the damping ratio.
    pub damping_sd: f64,
    /// Residues per channel, largest component 1.
    pub mode_shape: Vec<c64>,
    /// Standard deviations of the shape's real and imaginary parts, per channel; zero for the
    /// largest component.
    pub shape_sd: Vec<c64>,
}

/// Modes of the accepted order, and the poles of all orders.
#[derive(Clone, Debug)]
pub struct ResponseFit {
    pub order: usize,
    pub modes: Vec<ResponseMode>,
    /// Poles of every order tried, and whether the order was accepted.
    pub poles: Vec<(usize, c64, bool)>,
    /// The responses of the modes found and the residual terms, channel by channel.
    pub synthesised: Vec<Vec<c64>>,
    /// Modes left out because their damping is within three deviations of zero: peaks of noise, and
    /// lines without a width.
    pub unresolved: Vec<ResponseMode>,
    /// Neighbouring lines of which the residuals are correlated; 0 where they are white.
    pub correlated_lines: usize,
    /// The lines are those of segments under this window, by the correlation of their residuals,
    /// and the width of the window is part of the model.
    pub window: Option<&'static str>,
}

/// Modes of `responses` (one per channel over `frequency_hz`), even orders of the denominator
/// within `orders`.
///
/// # Errors
/// [`RfpError`] when there are too few lines for the smallest order, or no order is accepted.
pub fn identify(
    frequency_hz: &[f64],
    responses: &[Vec<c64>],
    orders: RangeInclusive<usize>,
    damping_max: f64,
) -> Result<ResponseFit, RfpError> {
    let band_hz = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let (mut all, mut accepted): (_, Vec<(usize, Vec<c64>)>) = (Vec::new(), Vec::new());
    let mut first_error = None;
    for order in (*orders.start().max(&2)..=*orders.end()).filter(|order| order % 2 == 0) {
        if accepted.last().is_some_and(|(last, _)| order > last + 2 * ORDERS_BEYOND) {
            break;
        }
        let tried = Orders { denominator: order, numerator: order + 4, transient: 0 };
        match of_responses(frequency_hz, responses, tried) {
            Ok(poles) => {
                let good = poles.len() == order / 2 && acceptable(&poles, band_hz, damping_max);
                all.extend(poles.iter().map(|pole| (order, *pole, good)));
                if good {
                    accepted.push((order, poles));
                }
            }
            Err(error) => {
                first_error.get_or_insert(error);
                break;
            }
        }
    }
    let lines = frequency_hz.len();
    let criteria =
        accepted.iter().map(|(_, poles)| criterion(responses, &synthesised(frequency_hz, responses, poles), poles));
    let best = criteria.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| accepted[k].clone());
    let Some((order, poles)) = best else {
        return Err(first_error.unwrap_or(RfpError::NotDetermined { lines }));
    };
    let undetermined = RfpError::NotDetermined { lines };
    let seen = ResponseLines::new(frequency_hz, responses);
    let mut found = refinement::refined(&seen, &poles).ok_or_else(|| undetermined.clone())?;
    let mut chosen = order;
    if !found.is_noise() {
        let sought = Sought { band_hz, damping_max };
        if let Some((order, better)) = among_rejected(&seen, sought, &all, (order, &found)) {
            (chosen, found) = (order, better);
        }
    }
    let mut modes = deviations::modes(&seen, &found).ok_or(undetermined)?;
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let unresolved = modes.extract_if(.., |mode| !is_resolved(mode)).collect();
    Ok(ResponseFit {
        order: chosen,
        unresolved,
        modes,
        poles: all,
        synthesised: found.fit.at.channels.iter().map(|channel| lines_of(&channel.model, 2)).collect(),
        correlated_lines: found.correlations.len(),
        window: found.fit.window.map(|window| window.name),
    })
}

fn is_resolved(mode: &ResponseMode) -> bool {
    mode.damping_ratio > DAMPING_SIGNIFICANCE * mode.damping_sd
}

/// Where modes are sought.
#[derive(Clone, Copy)]
struct Sought {
    band_hz: (f64, f64),
    damping_max: f64,
}

/// Of the orders above the one accepted the lowest whose residual is noise alone where that of the
/// accepted one is not: one peak then holds two modes, and both are resolved.
fn among_rejected(
    lines: &ResponseLines,
    sought: Sought,
    all: &[(usize, c64, bool)],
    (accepted, found): (usize, &Refined),
) -> Option<(usize, Refined)> {
    let mut orders: Vec<usize> = all.iter().map(|(order, ..)| *order).filter(|order| *order > accepted).collect();
    orders.dedup();
    orders.truncate(REJECTED_TRIED);
    orders.into_iter().find_map(|order| {
        let of_order = all.iter().filter(|(of, ..)| *of == order).map(|(_, pole, _)| *pole);
        let tried: Vec<c64> =
            of_order.filter(|pole| acceptable(&[*pole], sought.band_hz, sought.damping_max)).collect();
        if tried.len() <= found.fit.at.poles.len() || !found.is_worse_than(lines, &tried) {
            return None;
        }
        let better = resolved(lines, tried)?;
        (better.is_noise() && better.fit.at.poles.len() > found.fit.at.poles.len()).then_some((order, better))
    })
}

/// The fit of those of the `poles` that it resolves: an order that holds all modes holds poles of
/// noise, too.
fn resolved(lines: &ResponseLines, mut poles: Vec<c64>) -> Option<Refined> {
    loop {
        let found = refinement::refined(lines, &poles)?;
        let modes = deviations::modes(lines, &found)?;
        let kept: Vec<c64> = modes.iter().filter(|mode| is_resolved(mode)).map(|mode| mode.pole).collect();
        match kept.len() {
            all if all == modes.len() => return Some(found),
            0 => return None,
            _ => poles = kept,
        }
    }
}

fn numbers(pole: c64) -> (f64, f64) {
    let omega = pole.norm_sqr().sqrt();
    (omega / (2.0 * std::f64::consts::PI), -pole.re / omega)
}

fn acceptable(poles: &[c64], band_hz: (f64, f64), damping_max: f64) -> bool {
    let good = |pole: &c64| {
        let (f, zeta) = numbers(*pole);
        zeta > 0.0 && zeta < damping_max && f > band_hz.0 && f < band_hz.1
    };
    // Half bandwidths are the real parts; poles come in order of frequency.
    poles.iter().all(good) && poles.windows(2).all(|two| (two[1].im - two[0].im).abs() > -(two[0].re + two[1].re))
}

fn criterion(responses: &[Vec<c64>], synthesised: &[Vec<c64>], poles: &[c64]) -> f64 {
    let both = responses.iter().flatten().zip(synthesised.iter().flatten());
    let squares: f64 = both.map(|(y, m)| (y - m).norm_sqr()).sum();
    let numbers = (2 * responses.len() * responses[0].len()) as f64;
    let unknowns = (2 * poles.len() + responses.len() * (2 * poles.len() + RESIDUAL_TERMS)) as f64;
    numbers * libm::log(squares.max(f64::MIN_POSITIVE)) + unknowns * libm::log(numbers)
}

/// Synthesised responses: `Σ c/(s−λ) + c̄/(s−λ̄) + r₀ + r₁ s + r₂ s²`, by least squares per
/// channel.
fn synthesised(frequency_hz: &[f64], responses: &[Vec<c64>], poles: &[c64]) -> Vec<Vec<c64>> {
    let lines = frequency_hz.len();
    let scale = 2.0 * std::f64::consts::PI * frequency_hz[lines - 1];
    let s: Vec<c64> = frequency_hz.iter().map(|f| c64::new(0.0, 2.0 * std::f64::consts::PI * f)).collect();
    let one = c64::new(1.0, 0.0);
    let turn = c64::new(0.0, 1.0);
    let mut complex: Vec<Vec<c64>> = Vec::new();
    for pole in poles {
        let parts = |s: &c64| (one / (*s - *pole), one / (*s - pole.conj()));
        complex.push(s.iter().map(|s| parts(s).0 + parts(s).1).collect());
        complex.push(s.iter().map(|s| turn * (parts(s).0 - parts(s).1)).collect());
    }
    complex.push(vec![one; lines]);
    complex.push(s.iter().map(|s| s / scale).collect());
    complex.push(s.iter().map(|s| s * s / (scale * scale)).collect());
    let stacked = |values: &[c64]| -> Vec<f64> { values.iter().flat_map(|x| [x.re, x.im]).collect() };
    let basis = Basis::new(complex.iter().flat_map(|column| stacked(column)).collect(), 2 * lines);
    let of = |response: &Vec<c64>| {
        let found = basis.coefficients(basis.project_out(&mut stacked(response)));
        let at = |line: usize| complex.iter().zip(&found).fold(c64::new(0.0, 0.0), |sum, (x, c)| sum + x[line] * *c);
        (0..lines).map(at).collect()
    };
    responses.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_of_a_known_fraction_are_found_with_their_shapes_and_the_order_by_itself() {
        let truth = [(30.0, 0.004, [1.0, -0.5]), (82.0, 0.002, [0.3, 1.0]), (150.0, 0.01, [-1.0, 0.8])];
        let frequency_hz: Vec<f64> = (1..400).map(|k| 0.5 * f64::from(k)).collect();
        let pole = |f: f64, zeta: f64| {
            let omega = 2.0 * std::f64::consts::PI * f;
            c64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt())
        };
        let mut noise = crate::test_noise::Noise::new(4);
        let responses: Vec<Vec<c64>> = (0..2)
            .map(|channel| {
                let at = |f: &f64| {
                    let s = c64::new(0.0, 2.0 * std::f64::consts::PI * f);
                    truth.iter().fold(c64::new(0.0, 0.0), |sum, (f, zeta, shape)| {
                        let pole = pole(*f, *zeta);
                        let residue = c64::new(0.0, -shape[channel]);
                        sum + residue / (s - pole) + residue.conj() / (s - pole.conj())
                    }) + c64::new(1e-4 * noise.normal(), 1e-4 * noise.normal())
                };
                frequency_hz.iter().map(at).collect()
            })
            .collect();
        let found = identify(&frequency_hz, &responses, 2..=20, 0.2).unwrap();
        assert_eq!(found.order, 6);
        for (mode, (f, zeta, shape)) in found.modes.iter().zip(truth) {
            // Peaks stand two decades above the noise of a line.
            assert!((mode.frequency_hz / f - 1.0).abs() < 1e-4 && (mode.damping_ratio / zeta - 1.0).abs() < 0.02);
            let shape = shape.map(|x| c64::new(x, 0.0));
            assert!(1.0 - crate::mac::modal_assurance_criterion(&mode.mode_shape, &shape) < 1e-3);
        }
    }
}
