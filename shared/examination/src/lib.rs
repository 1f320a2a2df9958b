//! Examination of recordings on their own, and of two against each other.
//!
//! What it is: checks of a recording (`doctor`), comparison of a real and a simulated one
//! (`compare`), spectra (`spectrum`).
//!
//! May import: `channels`, `identification` (statistics), `estimation`, FFT. Must never know: a
//! plant's equations, files, processes, clocks.
//!
//! ```
//! use channels::{Channel, Recording};
//! use examination::doctor::{Check, examine};
//!
//! // an angle at 50 Hz, half a second of it lost behind 2 s
//! let kept = (0..400).filter(|k| !(100..125).contains(k));
//! let (time_s, value) = kept.map(|k| (f64::from(k) / 50.0, (0.1 * f64::from(k)).sin())).unzip();
//! let angle = Channel::new("angle", "rad", time_s, value);
//! let findings = examine(&Recording { name: "swing".into(), channels: vec![angle] });
//! let gap = findings.iter().find(|finding| finding.check == Check::Gaps);
//! let gap = gap.expect("half a second is missing");
//! println!("{}: {}; {}", gap.channel, gap.evidence, gap.cure);
//! ```

#![forbid(unsafe_code)]

pub mod clipping;
pub mod compare;
pub mod delay;
pub mod doctor;
pub mod even_record;
pub mod held;
mod lattice;
pub mod missing;
#[cfg(test)]
#[path = "../../identification/src/noise.rs"]
mod noise;
pub mod spectrum;
