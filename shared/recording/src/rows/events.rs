//! Rows at events: simulators write the row before and that behind a jump at one time.
//!
//! What moves from row to row goes on through such a pair, and something else jumps. Two samples
//! under one rounded stamp differ in all that moves.

use super::Rows;

/// Rows at events are at most one in so many.
const ROWS_PER_EVENT: usize = 10;

impl Rows {
    /// Whether the rows at the time of the one before are those behind a jump.
    pub(super) fn has_events(&self) -> bool {
        let rare = self.conflict.is_some() && ROWS_PER_EVENT * self.repeated.len() <= self.count();
        let moving = || self.values.iter().filter(|values| self.moves(values));
        let goes_on = |row: &usize| moving().any(|values| values[*row] == values[row - 1]);
        rare && self.repeated.iter().all(goes_on)
    }

    /// Whether a channel has another value in most rows than in the one before.
    fn moves(&self, values: &[f64]) -> bool {
        let moved = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        2 * moved > values.len()
    }

    /// Leaves the rows behind the jumps, and says so.
    pub(super) fn behind_events(&mut self) -> String {
        let behind = core::mem::take(&mut self.repeated);
        let before: Vec<usize> = behind.iter().map(|row| row - 1).collect();
        let first = self.lines[behind[0]];
        self.conflict = None;
        self.drop_rows(&before);
        format!(
            "{} time(s) stand twice, as simulators write jumps: the row behind the jump is taken (first: line {first})",
            behind.len()
        )
    }
}
