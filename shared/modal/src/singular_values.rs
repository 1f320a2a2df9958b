//! Singular values over frequency: of the spectral density matrix of outputs (frequency domain
//! decomposition; Brincker, Zhang & Andersen 2001), and of the matrix of frequency responses
//! (complex mode indicator; Shih, Tsuei, Allemang & Brown 1988).
//!
//! `S(f) = 2/(fs Σ w²) · mean of Y(f) Y(f)ᴴ` over Hann segments that overlap by half, each without
//! its mean; its singular values are densities. A peak of the first is a mode, of the second one
//! close to another. The factors are drawn and exported, and decide about no mode.
//!
//! Cost: O(l N log L + l² N + lines l³).

use crate::record::Record;
use faer::{Mat, Side, c64};
use std::f64::consts::PI;

/// Samples of a segment at most: finer lines than can be drawn.
const SEGMENT_MAX: usize = 4096;
/// Samples of a segment at least.
const SEGMENT_MIN: usize = 64;
/// Averages of a line at least: its standard deviation is about 1/√16 of it.
const AVERAGES_MIN: usize = 16;

/// Singular values, line by line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SingularValues {
    pub frequency_hz: Vec<f64>,
    /// Largest first; of a density matrix (unit)²/Hz, of responses in their unit.
    pub values: Vec<Vec<f64>>,
}

/// Singular values of the spectral density matrix of the outputs, from segments that no border of
/// the record's segments crosses; `None` when it is too short for sixteen averages or for twice as
/// many as channels, below which the matrix has no full rank.
#[must_use]
pub fn of_outputs(record: &Record) -> Option<SingularValues> {
    let l = record.channels;
    let starts = |length: usize| -> Vec<usize> {
        let of = |segment: &std::ops::Range<usize>| {
            (segment.start..(segment.end + 1).saturating_sub(length).max(segment.start)).step_by(length / 2)
        };
        record.segments.iter().flat_map(of).collect()
    };
    let mut length = SEGMENT_MAX;
    while starts(length).len() < AVERAGES_MIN.max(2 * l) {
        length /= 2;
        if length < SEGMENT_MIN {
            return None;
        }
    }
    let starts = starts(length);
    let window: Vec<f64> = (0..length).map(|t| 0.5 - 0.5 * libm::cos(2.0 * PI * t as f64 / length as f64)).collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let scale = 2.0 / (record.sample_rate_hz * power * starts.len() as f64);
    let lines = length / 2;
    let mut density = vec![c64::new(0.0, 0.0); lines * l * l];
    let mut spectra = vec![vec![c64::new(0.0, 0.0); length]; l];
    for start in starts {
        for (channel, spectrum) in spectra.iter_mut().enumerate() {
            let y = record.channel(channel, start..start + length);
            let mean = y.iter().sum::<f64>() / length as f64;
            for ((out, y), w) in spectrum.iter_mut().zip(&y).zip(&window) {
                *out = c64::new(w * (y - mean), 0.0);
            }
            transform(spectrum);
        }
        for line in 0..lines {
            let out = &mut density[line * l * l..(line + 1) * l * l];
            for a in 0..l {
                for b in 0..=a {
                    out[a * l + b] += spectra[a][line + 1] * spectra[b][line + 1].conj() * scale;
                }
            }
        }
    }
    let values = density.chunks_exact(l * l).map(|of_line| {
        let matrix = Mat::from_fn(l, l, |a, b| if a >= b { of_line[a * l + b] } else { of_line[b * l + a].conj() });
        // Of a positive semi-definite matrix the eigenvalues are the singular values.
        matrix.self_adjoint_eigenvalues(Side::Lower).ok().map(|mut found| {
            found.reverse();
            found.iter_mut().for_each(|x| *x = x.max(0.0));
            found
        })
    });
    let values: Option<Vec<Vec<f64>>> = values.collect();
    let line_hz = record.sample_rate_hz / length as f64;
    Some(SingularValues { frequency_hz: (1..=lines).map(|line| line as f64 * line_hz).collect(), values: values? })
}

/// Singular values of the matrix of responses, `responses[output][input][line]`; `None` when a
/// decomposition fails.
#[must_use]
pub fn of_responses(frequency_hz: &[f64], responses: &[Vec<&[c64]>]) -> Option<SingularValues> {
    let inputs = responses.first().map_or(0, Vec::len);
    let of_line = |line: usize| {
        let matrix = Mat::from_fn(responses.len(), inputs, |output, input| responses[output][input][line]);
        matrix.singular_values().ok()
    };
    let values: Option<Vec<Vec<f64>>> = (0..frequency_hz.len()).map(of_line).collect();
    Some(SingularValues { frequency_hz: frequency_hz.to_vec(), values: values? })
}

/// Discrete Fourier transform in place; a power of two (Cooley & Tukey 1965).
fn transform(values: &mut [c64]) {
    let n = values.len();
    assert!(n.is_power_of_two());
    let bits = n.trailing_zeros();
    for k in 0..n {
        let other = k.reverse_bits() >> (usize::BITS - bits);
        if other > k {
            values.swap(k, other);
        }
    }
    let turns: Vec<c64> = (0..n / 2)
        .map(|k| {
            let (sine, cosine) = libm::sincos(-2.0 * PI * k as f64 / n as f64);
            c64::new(cosine, sine)
        })
        .collect();
    let mut half = 1;
    while half < n {
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = *b * turns[k * (n / (2 * half))];
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    #[test]
    fn the_values_of_independent_white_channels_are_their_densities() {
        let mut noise = Noise::new(4);
        let sizes = [1.0, 3.0];
        let outputs = (0..40_000).map(|k| sizes[k % 2] * noise.normal()).collect();
        let found = of_outputs(&Record::of_outputs(50.0, 2, outputs)).unwrap();
        let mean = |k: usize| found.values.iter().map(|v| v[k]).sum::<f64>() / found.values.len() as f64;
        // Σ σ²/(fs/2): the sum is the trace and has no bias, 1 % of it is the scatter of 40 000
        // samples; the values themselves repel each other by some 1/16, the number of averages.
        assert!(((mean(0) + mean(1)) / (10.0 / 25.0) - 1.0).abs() < 0.03, "{} {}", mean(0), mean(1));
        assert!((mean(0) / mean(1) / 9.0 - 1.0).abs() < 0.25);
    }

    #[test]
    fn one_oscillation_on_many_channels_has_one_value_above_the_noise_at_its_frequency() {
        let mut noise = Noise::new(9);
        let outputs = (0..20_000).flat_map(|t| {
            let swing = libm::sin(2.0 * PI * 0.125 * f64::from(t));
            [1.0, -0.5, 0.3].map(|psi| psi * swing + 0.01 * noise.normal())
        });
        let found = of_outputs(&Record::of_outputs(1.0, 3, outputs.collect())).unwrap();
        let line = (0..found.values.len())
            .max_by(|a, b| found.values[*a][0].total_cmp(&found.values[*b][0]))
            .expect("there are lines");
        assert!((found.frequency_hz[line] - 0.125).abs() < 1e-12);
        assert!(found.values[line][0] > 1e4 * found.values[line][1]);
    }

    #[test]
    fn the_transform_is_the_sum_of_its_definition() {
        let mut noise = Noise::new(2);
        let values: Vec<c64> = (0..16).map(|_| c64::new(noise.normal(), noise.normal())).collect();
        let mut fast = values.clone();
        transform(&mut fast);
        for (k, fast) in fast.iter().enumerate() {
            let slow = values.iter().enumerate().fold(c64::new(0.0, 0.0), |sum, (t, y)| {
                let (sine, cosine) = libm::sincos(-2.0 * PI * (k * t) as f64 / 16.0);
                sum + *y * c64::new(cosine, sine)
            });
            assert!((slow - *fast).norm_sqr() < 1e-26); // rounding of sixteen products
        }
    }

    #[test]
    fn a_matrix_of_responses_to_two_forces_has_two_values() {
        let (a, b) = ([c64::new(3.0, 0.0)], [c64::new(0.0, 4.0)]);
        let none = [c64::new(0.0, 0.0)];
        let found = of_responses(&[1.0], &[vec![&a[..], &none[..]], vec![&none[..], &b[..]]]).unwrap();
        assert!((found.values[0][0] - 4.0).abs() < 1e-14 && (found.values[0][1] - 3.0).abs() < 1e-14);
    }
}
