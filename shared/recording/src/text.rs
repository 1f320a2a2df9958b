//! Text of recordings as loggers write it: encoding, separator, decimal sign, header, stamps.

pub(crate) mod at_most;
mod beside;
pub(crate) mod cells;
pub(crate) mod dialect;
pub(crate) mod encoding;
pub(crate) mod foreign;
mod groups;
mod header;
pub(crate) mod interval;
pub(crate) mod layout;
mod levels;
pub(crate) mod lines;
mod motion_capture;
pub(crate) mod number;
pub(crate) mod quantity;
pub(crate) mod seen;
pub(crate) mod signs;
pub(crate) mod stated_date;
mod trajectories;
mod units_lines;

pub(crate) use crate::intake::stamps;

/// The first 60 characters, control characters made visible: a binary file must not fill the
/// operator's screen, nor move its cursor.
pub(crate) fn printable(text: &str) -> String {
    let visible = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c });
    if text.chars().count() <= 60 { visible.collect() } else { visible.take(60).chain("...".chars()).collect() }
}
