//! Commands, references and prescribed motions as functions of time, with their two analytic
//! derivatives.
//!
//! A signal is a sum of terms. Each term runs on its own time, counted from its beginning, and is
//! zero outside `[begin, end)`. Jumps have no derivative here: rate and acceleration are those of
//! the pieces between them.

mod table;

use crate::description::{Quantity, Signal, SignalKind};
use core::f64::consts::{PI, TAU};
use table::Table;

/// A signal that has no meaning.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("signal of {of}: {why}")]
pub struct SignalError {
    pub of: String,
    pub why: &'static str,
}

/// An instant meant to lie on an edge must not fall before it by rounding \[s\].
pub const EDGE_S: f64 = 1e-9;

/// Value of a signal and its derivatives, in the SI unit of the driven input, per second, per
/// second squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalValue {
    pub value: f64,
    pub rate: f64,
    pub acceleration: f64,
}

impl SignalValue {
    const fn held(value: f64) -> Self {
        Self { value, rate: 0.0, acceleration: 0.0 }
    }

    fn add(&mut self, other: &Self) {
        self.value += other.value;
        self.rate += other.rate;
        self.acceleration += other.acceleration;
    }
}

/// One sinusoid `amplitude · sin(ω t + phase)`.
#[derive(Clone, Copy, Debug)]
struct Sinusoid {
    amplitude: f64,
    omega_rad_s: f64,
    phase_rad: f64,
}

impl Sinusoid {
    fn at(&self, t_s: f64) -> SignalValue {
        let (sin, cos) = libm::sincos(self.omega_rad_s * t_s + self.phase_rad);
        let (a, w) = (self.amplitude, self.omega_rad_s);
        SignalValue { value: a * sin, rate: a * w * cos, acceleration: -a * w * w * sin }
    }
}

#[derive(Clone, Debug)]
enum Shape {
    Constant(f64),
    Sine(Sinusoid),
    Square {
        amplitude: f64,
        frequency_hz: f64,
    },
    Multisine(Vec<Sinusoid>),
    Chirp {
        amplitude: f64,
        begin_rad_s: f64,
        sweep_rad_s2: f64,
    },
    /// Offset, ω, then per harmonic (a, b).
    Fourier {
        offset: f64,
        omega_rad_s: f64,
        harmonics: Vec<[f64; 2]>,
    },
    Pulse {
        size: f64,
        width_s: f64,
        period_s: Option<f64>,
    },
    Staircase {
        step: f64,
        every_s: f64,
    },
    Slew {
        size: f64,
        width_s: f64,
    },
    Table(Table),
}

#[derive(Clone, Debug)]
struct Term {
    shape: Shape,
    begin_s: f64,
    end_s: f64,
}

/// A sum of terms, compiled from its description.
#[derive(Clone, Debug, Default)]
pub struct SignalSum {
    terms: Vec<Term>,
}

impl SignalSum {
    /// Sum of `signals`; `duration_s` ends the terms that state no end. `of` names the signal in an
    /// error.
    ///
    /// # Errors
    /// A period, width or frequency span that has no meaning, a table whose times do not increase.
    pub fn new(signals: &[Signal], duration_s: f64, of: &str) -> Result<Self, SignalError> {
        let term = |signal: &Signal| -> Result<Term, SignalError> {
            let begin_s = signal.begin_s.value;
            let end_s = signal.end_s.map_or(f64::INFINITY, |end| end.value);
            let span_s = if end_s.is_finite() { end_s } else { duration_s } - begin_s;
            let shape = Shape::new(&signal.kind, span_s).map_err(|why| SignalError { of: of.to_owned(), why })?;
            Ok(Term { shape, begin_s, end_s })
        };
        Ok(Self { terms: signals.iter().map(term).collect::<Result<_, _>>()? })
    }

    /// Without terms: zero at all times.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// Value, rate and acceleration at `t_s`.
    ///
    /// Cost: one sine and cosine per sinusoid or Fourier series, a binary search per table; no
    /// allocation.
    pub fn at(&self, t_s: f64) -> SignalValue {
        let mut sum = SignalValue::default();
        for term in &self.terms {
            if t_s >= term.begin_s - EDGE_S && t_s < term.end_s - EDGE_S {
                sum.add(&term.shape.at(t_s - term.begin_s));
            }
        }
        sum
    }
}

fn values(quantities: &[Quantity]) -> impl Iterator<Item = f64> {
    quantities.iter().map(|quantity| quantity.value)
}

fn positive(value: f64, why: &'static str) -> Result<f64, &'static str> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(why) }
}

impl Shape {
    fn new(kind: &SignalKind, span_s: f64) -> Result<Self, &'static str> {
        Ok(match kind {
            SignalKind::Constant { value } => Self::Constant(value.value),
            SignalKind::Step { size } => Self::Constant(size.value),
            SignalKind::Sine { amplitude, frequency_hz, phase_rad } => Self::Sine(Sinusoid {
                amplitude: amplitude.value,
                omega_rad_s: TAU * frequency_hz.value,
                phase_rad: phase_rad.value,
            }),
            SignalKind::Square { amplitude, frequency_hz } => Self::Square {
                amplitude: amplitude.value,
                frequency_hz: positive(frequency_hz.value, "the frequency of a square wave must be positive")?,
            },
            SignalKind::Multisine { rms, period_s, first, last } => {
                multisine(rms.value, period_s.value, *first, *last)?
            }
            SignalKind::Chirp { amplitude, begin_hz, end_hz } => {
                let span_s = positive(span_s, "a chirp must end after it begins")?;
                Self::Chirp {
                    amplitude: amplitude.value,
                    begin_rad_s: TAU * begin_hz.value,
                    sweep_rad_s2: TAU * (end_hz.value - begin_hz.value) / span_s,
                }
            }
            SignalKind::Fourier { offset, period_s, sine, cosine } => {
                fourier(offset.value, period_s.value, values(sine).collect(), values(cosine).collect())?
            }
            SignalKind::Pulse { size, width_s, period_s } => Self::Pulse {
                size: size.value,
                width_s: width_s.value,
                period_s: match period_s {
                    Some(period) => Some(positive(period.value, "the period of pulses must be positive")?),
                    None => None,
                },
            },
            SignalKind::Staircase { step, every_s } => Self::Staircase {
                step: step.value,
                every_s: positive(every_s.value, "the steps of a staircase must take time")?,
            },
            SignalKind::Slew { size, width_s } => {
                Self::Slew { size: size.value, width_s: positive(width_s.value, "a slew must take time")? }
            }
            SignalKind::Table { time_s, value, smooth } => Self::Table(Table::new(time_s, value, *smooth)?),
        })
    }

    /// At the term's own time.
    fn at(&self, t_s: f64) -> SignalValue {
        match self {
            Self::Constant(value) => SignalValue::held(*value),
            Self::Sine(sinusoid) => sinusoid.at(t_s),
            Self::Square { amplitude, frequency_hz } => {
                let cycles = (t_s + EDGE_S) * frequency_hz;
                let first_half = cycles - libm::floor(cycles) < 0.5;
                SignalValue::held(if first_half { *amplitude } else { -amplitude })
            }
            Self::Multisine(sinusoids) => {
                let mut sum = SignalValue::default();
                sinusoids.iter().for_each(|sinusoid| sum.add(&sinusoid.at(t_s)));
                sum
            }
            Self::Chirp { amplitude, begin_rad_s, sweep_rad_s2 } => {
                let omega = begin_rad_s + sweep_rad_s2 * t_s;
                let (sin, cos) = libm::sincos((begin_rad_s + 0.5 * sweep_rad_s2 * t_s) * t_s);
                SignalValue {
                    value: amplitude * sin,
                    rate: amplitude * omega * cos,
                    acceleration: amplitude * (sweep_rad_s2 * cos - omega * omega * sin),
                }
            }
            Self::Fourier { offset, omega_rad_s, harmonics } => fourier_at(*offset, *omega_rad_s, harmonics, t_s),
            Self::Pulse { size, width_s, period_s } => {
                let since = period_s.map_or(t_s, |period| t_s - period * libm::floor((t_s + EDGE_S) / period));
                SignalValue::held(if since < width_s - EDGE_S { *size } else { 0.0 })
            }
            Self::Staircase { step, every_s } => {
                SignalValue::held(step * (1.0 + libm::floor((t_s + EDGE_S) / every_s)))
            }
            Self::Slew { size, width_s } => slew_at(*size, *width_s, t_s),
            Self::Table(table) => table.at(t_s),
        }
    }
}

/// Equal amplitudes `rms √(2/N)` with the phases `−π n (n − 1) / N`, n = 1..N, that keep the crest
/// factor near that of a swept sine (Schroeder, IEEE Trans. Information Theory 16, 1970).
fn multisine(rms: f64, period_s: f64, first: u32, last: u32) -> Result<Shape, &'static str> {
    positive(period_s, "the period of a multisine must be positive")?;
    if first == 0 || last < first {
        return Err("a multisine needs harmonics from 1 on, the last not below the first");
    }
    let count = f64::from(last - first + 1);
    let sinusoid = |harmonic: u32| {
        let n = f64::from(harmonic - first + 1);
        Sinusoid {
            amplitude: rms * (2.0 / count).sqrt(),
            omega_rad_s: TAU * f64::from(harmonic) / period_s,
            phase_rad: -PI * libm::fmod(n * (n - 1.0) / count, 2.0),
        }
    };
    Ok(Shape::Multisine((first..=last).map(sinusoid).collect()))
}

fn fourier(offset: f64, period_s: f64, mut sine: Vec<f64>, mut cosine: Vec<f64>) -> Result<Shape, &'static str> {
    let period_s = positive(period_s, "the period of a Fourier trajectory must be positive")?;
    let count = sine.len().max(cosine.len());
    sine.resize(count, 0.0);
    cosine.resize(count, 0.0);
    let harmonics = sine.into_iter().zip(cosine).map(|(a, b)| [a, b]).collect();
    Ok(Shape::Fourier { offset, omega_rad_s: TAU / period_s, harmonics })
}

/// `offset + Σ (a_k sin kωt − b_k cos kωt)/(kω)`, the harmonics by the sum of angles: its rounding
/// grows like that of `kωt`.
fn fourier_at(offset: f64, omega_rad_s: f64, harmonics: &[[f64; 2]], t_s: f64) -> SignalValue {
    let (mut value, mut rate, mut acceleration) = (0.0, 0.0, 0.0);
    let (sin_1, cos_1) = libm::sincos(omega_rad_s * t_s);
    let (mut sin, mut cos, mut k) = (sin_1, cos_1, 1.0);
    for [a, b] in harmonics {
        let across = a * sin - b * cos;
        value += across / k;
        rate += a * cos + b * sin;
        acceleration -= k * across;
        (sin, cos) = (sin * cos_1 + cos * sin_1, cos * cos_1 - sin * sin_1);
        k += 1.0;
    }
    SignalValue { value: offset + value / omega_rad_s, rate, acceleration: acceleration * omega_rad_s }
}

/// `size (10 s³ − 15 s⁴ + 6 s⁵)`, s = t / width: rate and acceleration vanish at both ends.
fn slew_at(size: f64, width_s: f64, t_s: f64) -> SignalValue {
    let s = t_s / width_s;
    if s <= 0.0 {
        return SignalValue::default();
    }
    if s >= 1.0 {
        return SignalValue::held(size);
    }
    SignalValue {
        value: size * s * s * s * (10.0 - s * (15.0 - 6.0 * s)),
        rate: size / width_s * 30.0 * s * s * (1.0 - s) * (1.0 - s),
        acceleration: size / (width_s * width_s) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
    }
}

#[cfg(test)]
mod tests;
