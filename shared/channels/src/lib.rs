//! Named channels: a quantity with its unit, the times of its own samples and their values.
//!
//! What it is: the one form in which simulators, files and methods hand records to each other. A
//! [`Channel`] carries its own stamps, so that sources with different clocks and rates stay what
//! they are; nothing but the name of the [`Recording`] ties channels together. [`Channel::uniform`]
//! and [`common_grid`] serve methods that need equal steps.
//!
//! May import: `estimation`, for quantiles. Must never know: files and their units, plants,
//! simulators, likelihoods.
//!
//! ```
//! use channels::Channel;
//!
//! // 10 Hz, three samples lost behind 1.1 s
//! let kept = (0..40).filter(|k| !(12..15).contains(k));
//! let (time_s, value) = kept.map(|k| (0.1 * f64::from(k), 0.02 * f64::from(k))).unzip();
//! let angle = Channel::new("angle", "rad", time_s, value);
//! assert!((angle.interval_s().unwrap() - 0.1).abs() < 1e-12);
//! let longest = angle.uniform().unwrap();
//! assert_eq!((longest.value.len(), longest.interpolated), (25, false));
//! assert!((longest.start_s - 1.5).abs() < 1e-12);
//! ```

#![forbid(unsafe_code)]

mod channel;
mod even_clock;
mod uniform;

pub use channel::{Channel, GAP_MEDIANS, IRREGULAR_GAP_MEDIANS, IRREGULAR_SHARE, Recording, Role, same_unit};
pub use even_clock::{EvenClock, Stamps};
pub use uniform::{Uniform, common_grid, interpolate};
