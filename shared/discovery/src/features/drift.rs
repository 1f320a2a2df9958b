//! Modes over the parts of one record: a linear, constant structure has one frequency and one
//! damping ratio, whatever the part.
//!
//! Each frequency and damping ratio is tested against a constant (χ² over the parts, probability
//! shared by all of them). One that is not constant is fitted by a line in time and by a line in
//! the amplitude of the part. The law of smaller residual is reported with its slope and sigma, and
//! both where the parts cannot separate them: in a single decay amplitude and time are confounded,
//! and a second excitation separates them.

use crate::diagnose::{Diagnosis, Verdict, Where};
use examination::doctor::probability;
use identification::statistics::chi_squared_tail;

/// A mode in one part of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeInPart {
    pub begin_s: f64,
    pub end_s: f64,
    /// Of the motion in the part, in any unit.
    pub amplitude: f64,
    /// Value and standard deviation.
    pub frequency_hz: (f64, f64),
    pub damping_ratio: (f64, f64),
}

/// A mode through the parts of its record.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeTrack {
    /// Of the whole record.
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub parts: Vec<ModeInPart>,
}

/// The parameter that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    Frequency,
    Damping,
}

/// Variable that the parameter depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    Time,
    Amplitude,
    /// The parts are consistent with both, or with neither.
    Undecided,
}

/// A parameter of a mode that is not constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    pub mode: usize,
    pub of: Of,
    pub law: Law,
    /// Slope and standard deviation: per second, and per unit of amplitude (`None` where all parts
    /// move alike).
    pub per_second: (f64, f64),
    pub per_amplitude: Option<(f64, f64)>,
    /// p value of a constant, shared by all parameters tested.
    pub p: f64,
}

/// Difference in χ² within which two laws are not separated: ΔBIC of equal sizes, odds of 20 : 1.
const LAW_CHI2_TIE: f64 = 6.0;
/// p value of the residual from which a law is consistent with the parts. Chosen, no derivation.
const LAW_FIT_P_MIN: f64 = 1e-3;

/// All parameters that are not constant at the level `alpha`, the least probable first.
#[must_use]
pub fn drifts(tracks: &[ModeTrack], alpha: f64) -> Vec<Drift> {
    let tested = (2 * tracks.iter().filter(|track| track.parts.len() > 1).count()).max(1) as f64;
    let each = tracks.iter().enumerate().flat_map(|(k, track)| [(k, track, Of::Frequency), (k, track, Of::Damping)]);
    let mut found: Vec<Drift> =
        each.filter_map(|(k, track, of)| drift(k, track, of, tested)).filter(|drift| drift.p < alpha).collect();
    found.sort_by(|a, b| a.p.total_cmp(&b.p));
    found
}

fn drift(mode: usize, track: &ModeTrack, of: Of, tested: f64) -> Option<Drift> {
    let values: Vec<(f64, f64)> = track
        .parts
        .iter()
        .map(|part| if of == Of::Frequency { part.frequency_hz } else { part.damping_ratio })
        .collect();
    let usable = values.len() > 1 && values.iter().all(|(value, sigma)| value.is_finite() && *sigma > 0.0);
    if !usable {
        return None;
    }
    let time: Vec<f64> = track.parts.iter().map(|part| 0.5 * (part.begin_s + part.end_s)).collect();
    let amplitude: Vec<f64> = track.parts.iter().map(|part| part.amplitude).collect();
    let constant = line(&values, None)?;
    let freedom = (values.len() - 1) as f64;
    let p = (chi_squared_tail(constant.left, freedom) * tested).min(1.0);
    let in_time = line(&values, Some(&time))?;
    let in_amplitude = line(&values, Some(&amplitude));
    let fits = |line: &Line| chi_squared_tail(line.left, freedom - 1.0) > LAW_FIT_P_MIN;
    let law = match &in_amplitude {
        Some(other) if freedom > 1.0 && in_time.left + LAW_CHI2_TIE < other.left && fits(&in_time) => Law::Time,
        Some(other) if freedom > 1.0 && other.left + LAW_CHI2_TIE < in_time.left && fits(other) => Law::Amplitude,
        // equal amplitudes exclude a law over amplitude
        None if freedom > 1.0 && fits(&in_time) => Law::Time,
        _ => Law::Undecided,
    };
    Some(Drift { mode, of, law, per_second: in_time.slope, per_amplitude: in_amplitude.map(|line| line.slope), p })
}

struct Line {
    slope: (f64, f64),
    /// Σ (residual / sigma)².
    left: f64,
}

/// Weighted least squares of a constant, or of a line; `None` where the abscissae are all one.
fn line(values: &[(f64, f64)], over: Option<&[f64]>) -> Option<Line> {
    let weight: Vec<f64> = values.iter().map(|(_, sigma)| 1.0 / (sigma * sigma)).collect();
    let total: f64 = weight.iter().sum();
    let mean = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(|k| weight[k] * of(k)).sum::<f64>() / total;
    let y_mean = mean(&|k| values[k].0);
    let squares = |slope: f64, x: &dyn Fn(usize) -> f64| -> f64 {
        (0..values.len()).map(|k| weight[k] * (values[k].0 - y_mean - slope * x(k)).powi(2)).sum()
    };
    let Some(x) = over else { return Some(Line { slope: (0.0, 0.0), left: squares(0.0, &|_| 0.0) }) };
    let x_mean = mean(&|k| x[k]);
    let spread: f64 = (0..values.len()).map(|k| weight[k] * (x[k] - x_mean) * (x[k] - x_mean)).sum();
    let scale: f64 = x.iter().map(|x| x * x).sum::<f64>() * total;
    let distinct = spread > 1e-12 * scale;
    if !distinct {
        return None;
    }
    let slope = (0..values.len()).map(|k| weight[k] * (x[k] - x_mean) * (values[k].0 - y_mean)).sum::<f64>() / spread;
    Some(Line { slope: (slope, 1.0 / spread.sqrt()), left: squares(slope, &|k| x[k] - x_mean) })
}

impl Drift {
    /// One sentence with numbers.
    #[must_use]
    pub fn in_words(&self, track: &ModeTrack) -> String {
        let (what, unit, suspects) = match self.of {
            Of::Frequency => {
                ("frequency", "Hz", ["mass, temperature or wear that changes", "stiffness that depends on amplitude"])
            }
            Of::Damping => {
                ("damping ratio", "1", ["a damper that changes", "damping that depends on amplitude, or friction"])
            }
        };
        let slope = |(value, sigma): (f64, f64), per: &str| format!("{value:+.3e} ± {sigma:.1e} {unit}/{per}");
        let time = slope(self.per_second, "s");
        let amplitude =
            self.per_amplitude.map_or("no slope, all parts move alike".into(), |s| slope(s, "unit of amplitude"));
        let law = match self.law {
            Law::Time => format!("it follows time, {time}: {}", suspects[0]),
            Law::Amplitude => format!("it follows the amplitude, {amplitude}: {}", suspects[1]),
            Law::Undecided => format!(
                "over time {time}, over the amplitude {amplitude}: {} or {}; these parts do not separate them, a record of another amplitude does",
                suspects[0], suspects[1]
            ),
        };
        format!(
            "the {what} of the mode at {:.4} Hz is not constant over the record ({}); {law}",
            track.frequency_hz,
            probability(self.p)
        )
    }
}

/// Adds the parameters that drift to a diagnosis of the frequencies. A model of constant modes is
/// then wrong whatever its frequencies are, and no structural change explains it: the verdict is
/// that a law is missing which this form's catalogue does not contain.
pub fn add_drifts(diagnosis: &mut Diagnosis, tracks: &[ModeTrack], alpha: f64) {
    let found = drifts(tracks, alpha);
    if found.is_empty() {
        if !tracks.is_empty() {
            diagnosis.notes.push(format!("{} modes over the parts of the record: none drifts", tracks.len()));
        }
        return;
    }
    for drift in &found {
        let track = &tracks[drift.mode];
        let (first, last) = (track.parts.first(), track.parts.last());
        let half_width = track.damping_ratio * track.frequency_hz;
        diagnosis.located.push(Where {
            channel: match drift.of {
                Of::Frequency => format!("frequency over the parts, mode at {:.4} Hz", track.frequency_hz),
                Of::Damping => format!("damping over the parts, mode at {:.4} Hz", track.frequency_hz),
            },
            site: "record".to_owned(),
            time: [first.map_or(0.0, |part| part.begin_s), last.map_or(0.0, |part| part.end_s)],
            band_hz: [track.frequency_hz - half_width, track.frequency_hz + half_width],
            states: Vec::new(),
            p: drift.p,
        });
    }
    let words: Vec<String> = found.iter().map(|drift| drift.in_words(&tracks[drift.mode])).collect();
    let frequencies = core::mem::take(&mut diagnosis.reason);
    diagnosis.reason = words.join("; ");
    if matches!(diagnosis.verdict, Verdict::None | Verdict::CannotDecide) {
        diagnosis.verdict = Verdict::NotInCatalogue;
        diagnosis.notes.push(format!("frequencies of the whole record: {frequencies}"));
    } else {
        diagnosis.reason = format!("{frequencies}; besides, {}", diagnosis.reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    const SIGMA: (f64, f64) = (1e-3, 2e-4);

    /// Four parts of five seconds with the given amplitudes; frequency by time and amplitude,
    /// damping by amplitude.
    fn track(seed: u64, amplitudes: [f64; 4], f_time: f64, f_amplitude: f64, z_amplitude: f64) -> ModeTrack {
        let mut draw = Noise::new(seed);
        let part = |(k, amplitude): (usize, &f64)| {
            let begin_s = 5.0 * k as f64;
            let f = 1.56 + f_time * (begin_s + 2.5) + f_amplitude * amplitude;
            let zeta = 0.008 + z_amplitude * amplitude;
            ModeInPart {
                begin_s,
                end_s: begin_s + 5.0,
                amplitude: *amplitude,
                frequency_hz: (f + SIGMA.0 * draw.normal(), SIGMA.0),
                damping_ratio: (zeta + SIGMA.1 * draw.normal(), SIGMA.1),
            }
        };
        let parts = amplitudes.iter().enumerate().map(part).collect();
        ModeTrack { frequency_hz: 1.56, damping_ratio: 0.008, parts }
    }

    const SHUFFLED: [f64; 4] = [0.2, 1.0, 0.1, 0.7];

    #[test]
    fn a_constant_mode_raises_an_alarm_as_often_as_alpha_says() {
        let alarms =
            (0..2000).filter(|seed| !drifts(&[track(*seed, SHUFFLED, 0.0, 0.0, 0.0)], 0.01).is_empty()).count();
        // 20 expected; Poisson, four sigma, and Bonferroni over two independent numbers is exact to
        // 0.5 %.
        assert!((3..=38).contains(&alarms), "{alarms} of 2000");
    }

    #[test]
    fn drift_with_time_and_dependence_on_amplitude_are_separated_with_honest_slopes() {
        let (mut z, mut right) = (Vec::new(), 0);
        for seed in 0..100 {
            let time = &drifts(&[track(seed, SHUFFLED, 1e-3, 0.0, 0.0)], 0.01)[0];
            assert_eq!(time.of, Of::Frequency);
            z.push((time.per_second.0 - 1e-3) / time.per_second.1);
            let amplitude = &drifts(&[track(seed, SHUFFLED, 0.0, 0.0, 4e-3)], 0.01)[0];
            assert_eq!(amplitude.of, Of::Damping);
            let slope = amplitude.per_amplitude.unwrap();
            z.push((slope.0 - 4e-3) / slope.1);
            right += usize::from(time.law == Law::Time && amplitude.law == Law::Amplitude);
        }
        let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
        // χ² of 200: standard deviation 0.1.
        assert!((square - 1.0).abs() < 0.4, "{square}");
        // What the law does not explain is χ² of 2: beyond the limit once in a thousand.
        assert!(right >= 97, "{right} of 100");
    }

    #[test]
    fn in_one_decay_time_and_amplitude_are_not_separated_and_that_is_said() {
        let decay = track(3, [1.0, 0.75, 0.5, 0.25], 0.0, 0.03, 0.0);
        let found = &drifts(std::slice::from_ref(&decay), 0.01)[0];
        assert_eq!((found.of, found.law), (Of::Frequency, Law::Undecided));
        assert!(found.in_words(&decay).contains("do not separate them"));
    }

    #[test]
    fn a_drift_turns_nothing_is_missing_into_something_and_leaves_a_name_its_place() {
        let tracks = [track(1, SHUFFLED, 1e-3, 0.0, 0.0)];
        let mut diagnosis = Diagnosis::cannot_decide("two modes are too few".into());
        add_drifts(&mut diagnosis, &tracks, 0.01);
        assert_eq!(diagnosis.verdict, Verdict::NotInCatalogue);
        assert!(diagnosis.reason.contains("follows time") && diagnosis.located.len() == 1, "{}", diagnosis.reason);
        assert!(diagnosis.notes.iter().any(|note| note.contains("two modes are too few")));
        let mut named = Diagnosis { verdict: Verdict::Named, ..Diagnosis::cannot_decide("a mass".into()) };
        add_drifts(&mut named, &tracks, 0.01);
        assert!(named.verdict == Verdict::Named && named.reason.starts_with("a mass; besides, the frequency"));
        let mut quiet = Diagnosis { verdict: Verdict::None, ..Diagnosis::cannot_decide(String::new()) };
        add_drifts(&mut quiet, &[track(2, SHUFFLED, 0.0, 0.0, 0.0)], 1e-6);
        assert!(quiet.verdict == Verdict::None && quiet.notes.len() == 1);
    }
}
