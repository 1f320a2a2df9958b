//! The recent past: the state at the beginning of every piece, from which any instant is reached by
//! a side branch.
//!
//! Why a side branch and not a stop: sensors with their own instants (jitter, delay, other rates)
//! then leave the trajectory alone, so that adding one changes no other number.

use super::excitation::ExcitedClock;
use super::motion::{Dynamics, Origin};
use dynamics::lags::LagState;
use dynamics::signal::EDGE_S;
use serde::{Deserialize, Serialize};

/// Sizes of what a piece keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Widths {
    pub x: usize,
    pub u: usize,
    pub motions: usize,
    pub lags: usize,
    /// Readings at the beginning; zero where no sensor lags.
    pub y: usize,
}

/// A ring of pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct History {
    widths: Widths,
    capacity: usize,
    newest: usize,
    length: usize,
    begin_s: Vec<f64>,
    clocks: Vec<ExcitedClock>,
    x: Vec<f64>,
    u: Vec<f64>,
    motions: Vec<[f64; 2]>,
    lags: Vec<LagState>,
    y: Vec<f64>,
    /// End of the newest piece, and the state there.
    present_s: f64,
    present_x: Vec<f64>,
}

/// What a piece starts with.
pub(crate) struct PieceStart<'a> {
    pub begin_s: f64,
    pub clock: ExcitedClock,
    pub x: &'a [f64],
    pub u: &'a [f64],
    pub motions: &'a [[f64; 2]],
    pub lags: &'a [LagState],
    pub y: &'a [f64],
}

impl History {
    /// Room for `capacity` pieces.
    pub fn new(widths: Widths, capacity: usize) -> Self {
        let clock = ExcitedClock { begin_s: 0.0, excited_begin_s: 0.0, running: false };
        Self {
            widths,
            capacity,
            newest: 0,
            length: 0,
            begin_s: vec![0.0; capacity],
            clocks: vec![clock; capacity],
            x: vec![0.0; capacity * widths.x],
            u: vec![0.0; capacity * widths.u],
            motions: vec![[0.0; 2]; capacity * widths.motions],
            lags: vec![LagState::default(); capacity * widths.lags],
            y: vec![0.0; capacity * widths.y],
            present_s: 0.0,
            present_x: vec![0.0; widths.x],
        }
    }

    /// Slot of the newest piece.
    pub fn newest(&self) -> usize {
        self.newest
    }

    /// Forgets all samples; the memory stays.
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Whether a history can be restored from the other: same widths, same capacity.
    pub fn same_shape(&self, other: &Self) -> bool {
        self.widths == other.widths && self.capacity == other.capacity
    }

    /// Takes a piece, pushing out the oldest.
    pub fn push(&mut self, piece: &PieceStart<'_>) {
        self.newest = if self.newest + 1 == self.capacity { 0 } else { self.newest + 1 };
        self.length = (self.length + 1).min(self.capacity);
        let slot = self.newest;
        (self.begin_s[slot], self.clocks[slot]) = (piece.begin_s, piece.clock);
        put(&mut self.x, slot, self.widths.x, piece.x);
        put(&mut self.u, slot, self.widths.u, piece.u);
        put(&mut self.motions, slot, self.widths.motions, piece.motions);
        put(&mut self.lags, slot, self.widths.lags, piece.lags);
        put(&mut self.y, slot, self.widths.y, piece.y);
    }

    /// Takes the state at the end of the newest piece.
    pub fn close(&mut self, end_s: f64, x: &[f64]) {
        self.present_s = end_s;
        self.present_x.copy_from_slice(x);
    }

    /// Slot of the piece that `t_s` falls into; the oldest for earlier times. A piece's beginning
    /// belongs to it.
    pub fn locate(&self, t_s: f64) -> usize {
        assert!(self.length > 0, "the first piece is taken before the first reading");
        let mut slot = self.newest;
        for _ in 1..self.length {
            if self.begin_s[slot] <= t_s + EDGE_S {
                break;
            }
            slot = if slot == 0 { self.capacity - 1 } else { slot - 1 };
        }
        slot
    }

    /// State and inputs at `t_s`, at earliest those of the oldest piece; returns the slot and the
    /// time after its beginning.
    pub fn state_at(&self, dynamics: &mut Dynamics, t_s: f64, x: &mut [f64], u: &mut [f64]) -> (usize, f64) {
        let slot = self.locate(t_s);
        x.copy_from_slice(get(&self.x, slot, self.widths.x));
        u.copy_from_slice(get(&self.u, slot, self.widths.u));
        let begin_s = self.begin_s[slot];
        let since_s = t_s - begin_s;
        let motions = get(&self.motions, slot, self.widths.motions);
        let origin = Origin { begin_s, clock: &self.clocks[slot], motions };
        if since_s < EDGE_S {
            dynamics.prescribe(&origin, begin_s, u);
            return (slot, 0.0);
        }
        if slot == self.newest && (t_s - self.present_s).abs() < EDGE_S {
            x.copy_from_slice(&self.present_x);
            dynamics.prescribe(&origin, t_s, u);
            return (slot, since_s);
        }
        dynamics.advance(&origin, begin_s, since_s, x, u);
        (slot, since_s)
    }

    /// Lag states and readings at the beginning of the piece in `slot`.
    pub fn lagged(&self, slot: usize) -> (&[LagState], &[f64]) {
        (get(&self.lags, slot, self.widths.lags), get(&self.y, slot, self.widths.y))
    }
}

#[inline]
fn put<T: Copy>(ring: &mut [T], slot: usize, width: usize, value: &[T]) {
    // mostly there is nothing to keep of motions, lags and readings
    if width == 0 {
        return;
    }
    ring[slot * width..(slot + 1) * width].copy_from_slice(&value[..width]);
}

fn get<T>(ring: &[T], slot: usize, width: usize) -> &[T] {
    &ring[slot * width..(slot + 1) * width]
}
