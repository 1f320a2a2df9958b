//! Units as people write them, and what they are in SI: the one table and the one parser.
//!
//! What it is: text such as `ug/sqrt(Hz)`, `m/s/sqrt(h)`, `N·m`, `kg m2`, `°/√h`, `Umdr/min` in, a
//! [`Unit`] out. A unit is a decimal power, a quotient of two exact numbers and a power of √π, so
//! that "5 ms" is the double next to 0.005 and not a product of two rounded numbers. Products and
//! quotients associate from the left: `N m/rad/s` is (N m/rad)/s.
//!
//! Angles and cycles have no dimension, but a rad/s is not a Hz: both are remembered.
//!
//! May import: nothing. Must never know: recordings, plants, which quantity a unit is wanted for.
//!
//! ```
//! use units::parse;
//!
//! let [sheet, logger] = ["ug/sqrt(Hz)", "m/s2"].map(|text| parse(text).unwrap());
//! assert_eq!(sheet.to_si("100"), Some(9.80665e-4));
//! assert_eq!(logger.dimension, parse("m s^-2").unwrap().dimension);
//! assert!(parse("furlong").is_err());
//! ```

#![forbid(unsafe_code)]

mod parse;
mod table;
mod text;
mod unit;

pub use parse::{Fault, Spelled, parse, parse_with_gram, spelled, spelled_with_gram};
pub use table::{is_symbol, symbols};
pub use text::plain;
pub use unit::{Dimension, NONE, Unit};

#[cfg(test)]
mod tests;
