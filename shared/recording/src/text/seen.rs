//! What a text file begins with, as it was seen.

use super::dialect::Dialect;
use super::interval::Interval;

/// What was seen of a file before its first row was taken.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub dialect: Dialect,
    /// Texts of the header's cells; empty where the file has no header.
    pub header: Vec<String>,
    /// Texts of a line of units below the header.
    pub units: Vec<String>,
    /// Line of the header, else of the first row.
    pub header_line: u64,
    /// Line of the first row.
    pub first_line: u64,
    /// Cells of the rows that were seen, one inner vector a row.
    pub rows: Vec<Vec<String>>,
    /// Lines above the rows that are neither header nor units nor marked as remarks.
    pub remarks: usize,
    /// What the lines above the rows say of the time between two rows.
    pub interval: Option<Interval>,
    /// What was read in one of two ways, or not used.
    pub notes: Vec<String>,
}
