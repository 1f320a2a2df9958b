//! A whole record at a lower rate, behind an anti-alias filter; and trends taken out of one.
//!
//! The filter is a linear-phase FIR with a Kaiser window for 70 dB: pass band to 0.40, stop band
//! from 0.60 of the new rate, as [`crate::decimation`] has for halves. Only outputs at which the
//! filter is full are kept, segment by segment, so that a free decay stays one with the same poles.
//! Kaiser 1974; Oppenheim & Schafer section 7.6.

use crate::decimation::{KAISER_BETA, bessel_i0};
use crate::record::Record;
use std::f64::consts::PI;
use std::ops::Range;

/// Half the taps in units of the factor: Kaiser's `(70 − 7.95)/(2.285 · 2π · 0.2)` taps are 21.6
/// per unit.
const HALF_LENGTH: usize = 11;

/// What is taken out of every channel of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// Its mean: right for ambient motion, wrong for a short decay, whose mean is its own.
    Mean,
    /// Its line of least squares.
    Linear,
}

/// Every `factor`-th output of the anti-alias filter, over the segments of the record. The inputs
/// are left out: held from sample to sample of the old rate, they are not held at the new one.
///
/// A segment shorter than the filter is left out; `None` when all are. An output whose filter lacks
/// a sample (NaN) does not exist.
#[must_use]
pub fn decimated(record: &Record, factor: usize) -> Option<Record> {
    assert!(factor > 0);
    if factor == 1 {
        return Some(record.clone());
    }
    let (l, taps) = (record.channels, taps(factor));
    let (mut outputs, mut segments): (Vec<f64>, Vec<Range<usize>>) = (Vec::new(), Vec::new());
    for segment in record.segments.iter().filter(|segment| segment.len() >= taps.len()) {
        let first = outputs.len() / l;
        for start in (segment.start..=segment.end - taps.len()).step_by(factor) {
            let at = outputs.len();
            outputs.resize(at + l, 0.0);
            let rows = record.outputs[start * l..(start + taps.len()) * l].chunks_exact(l);
            for (tap, row) in taps.iter().zip(rows) {
                outputs[at..].iter_mut().zip(row).for_each(|(out, y)| *out += tap * y);
            }
        }
        segments.push(first..outputs.len() / l);
    }
    (!segments.is_empty())
        .then(|| Record::of_outputs(record.sample_rate_hz / factor as f64, l, outputs).with_segments(segments))
}

/// The record without the trend of each segment, which is that of the samples that exist.
#[must_use]
pub fn detrended(mut record: Record, trend: Trend) -> Record {
    let l = record.channels;
    for segment in record.segments.clone() {
        let middle = 0.5 * (segment.len() as f64 - 1.0);
        for c in 0..l {
            let (mut n, mut x, mut xx, mut y, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (t, value) in record.channel(c, segment.clone()).into_iter().enumerate().filter(|(_, y)| y.is_finite())
            {
                let from_middle = t as f64 - middle;
                (n, x, xx) = (n + 1.0, x + from_middle, xx + from_middle * from_middle);
                (y, xy) = (y + value, xy + from_middle * value);
            }
            let determinant = n * xx - x * x;
            let slope = if trend == Trend::Linear && determinant > 0.0 { (n * xy - x * y) / determinant } else { 0.0 };
            let level = if n > 0.0 { (y - slope * x) / n } else { 0.0 };
            for (t, row) in segment.clone().enumerate() {
                record.outputs[row * l + c] -= level + slope * (t as f64 - middle);
            }
        }
    }
    record
}

/// Low pass at half the new rate, of unit gain at rest.
fn taps(factor: usize) -> Vec<f64> {
    let half = (HALF_LENGTH * factor) as i32;
    let mut taps: Vec<f64> = (-half..=half)
        .map(|offset| {
            let across = f64::from(offset) / (f64::from(half) + 1.0);
            let x = PI * f64::from(offset) / factor as f64;
            let sinc = if offset == 0 { 1.0 } else { libm::sin(x) / x };
            sinc * bessel_i0(KAISER_BETA * libm::sqrt(1.0 - across * across))
        })
        .collect();
    let gain: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|tap| *tap /= gain);
    taps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pass_band_is_flat_and_nothing_folds_onto_it_at_any_factor() {
        for factor in [2, 3, 5, 16] {
            let taps = taps(factor);
            let middle = (taps.len() / 2) as f64;
            let gain = |f: f64| -> f64 {
                let all = taps.iter().enumerate();
                all.map(|(n, tap)| tap * libm::cos(2.0 * PI * f / factor as f64 * (n as f64 - middle))).sum::<f64>()
            };
            for step in 0..=100 {
                let across = f64::from(step) / 100.0;
                // 70 dB is 3.2e-4; at 1e-3 the folded part of an equal tone is below 0.1 %.
                assert!((gain(0.4 * across) - 1.0).abs() < 1e-3, "factor {factor}: pass {across}");
                assert!(
                    gain(0.6 + (0.5 * factor as f64 - 0.6) * across).abs() < 1e-3,
                    "factor {factor}: stop {across}"
                );
            }
        }
    }

    #[test]
    fn a_decimated_decay_is_the_same_decay_and_no_output_sees_across_a_gap() {
        let (rho, theta) = (0.98, 0.1);
        let decay = |t: usize| libm::pow(rho, t as f64) * libm::cos(theta * t as f64);
        let outputs = (0..300).map(decay).chain((0..50).map(|_| 1e6)).chain((0..300).map(decay)).collect();
        let record = Record::of_outputs(10.0, 1, outputs).with_segments(vec![0..300, 300..350, 350..650]);
        let low = decimated(&record, 3).unwrap();
        assert_eq!(low.segments.len(), 2, "the filter has 67 taps, the middle 50 samples");
        assert!((low.sample_rate_hz - 10.0 / 3.0).abs() < 1e-12);
        for w in low.rows(&low.segments[1]).windows(3) {
            let next = 2.0 * libm::pow(rho, 3.0) * libm::cos(3.0 * theta) * w[1] - libm::pow(rho, 6.0) * w[0];
            assert!((w[2] - next).abs() < 1e-14); // rounding of 67 products of numbers below one
        }
    }

    #[test]
    fn a_line_is_taken_out_of_each_segment_by_itself() {
        let outputs: Vec<f64> =
            (0..50).map(|t| if t < 20 { 3.0 + 0.5 * f64::from(t) } else { -f64::from(t) }).collect();
        let record = Record::of_outputs(1.0, 1, outputs).with_segments(vec![0..20, 20..50]);
        let level = detrended(record.clone(), Trend::Linear);
        assert!(level.outputs.iter().all(|y| y.abs() < 1e-12));
        let centred = detrended(record, Trend::Mean);
        assert!(centred.outputs[..20].iter().sum::<f64>().abs() < 1e-12 && centred.outputs[0].abs() > 4.0);
    }

    #[test]
    fn samples_that_do_not_exist_change_no_trend_and_leave_no_output_that_saw_them() {
        let hole = |t: i32| if t % 7 == 3 { f64::NAN } else { 3.0 + 0.5 * f64::from(t) };
        let level = detrended(Record::of_outputs(1.0, 1, (0..50).map(hole).collect()), Trend::Linear);
        assert!(level.outputs.iter().all(|y| y.is_nan() || y.abs() < 1e-12));
        assert_eq!(level.outputs.iter().filter(|y| y.is_nan()).count(), 7);
        let one_hole: Vec<f64> = (0..400).map(|t| if t == 200 { f64::NAN } else { 1.0 }).collect();
        let low = decimated(&Record::of_outputs(1.0, 1, one_hole), 2).unwrap();
        // Of 45 taps every other output's window holds the hole.
        assert_eq!(low.outputs.iter().filter(|y| y.is_nan()).count(), 23);
        assert!(low.outputs.iter().all(|y| y.is_nan() || (y - 1.0).abs() < 1e-12));
    }
}
