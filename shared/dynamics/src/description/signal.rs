//! Commands and prescribed motions as functions of time.

use super::Quantity;

/// One term of a signal; amplitudes are in the SI unit of the driven input.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalKind {
    Constant {
        value: Quantity,
    },
    Sine {
        amplitude: Quantity,
        frequency_hz: Quantity,
        phase_rad: Quantity,
    },
    /// Square wave, starting positive.
    Square {
        amplitude: Quantity,
        frequency_hz: Quantity,
    },
    /// Random-phase multisine: equal amplitudes at the harmonics `k / period_s`, k from `first` to
    /// `last`, Schroeder phases.
    Multisine {
        rms: Quantity,
        period_s: Quantity,
        first: u32,
        last: u32,
    },
    /// Linear sweep over the term's duration.
    Chirp {
        amplitude: Quantity,
        begin_hz: Quantity,
        end_hz: Quantity,
    },
    /// Joint trajectory `q0 + Σ (a_k sin kωt − b_k cos kωt)/(kω)` (Swevers 1997), ω = 2π/period.
    Fourier {
        offset: Quantity,
        period_s: Quantity,
        sine: Vec<Quantity>,
        cosine: Vec<Quantity>,
    },
    Step {
        size: Quantity,
    },
    /// Rectangular pulses of `width_s` every `period_s`; no period: one pulse.
    Pulse {
        size: Quantity,
        width_s: Quantity,
        period_s: Option<Quantity>,
    },
    /// `step · (1 + ⌊t/every⌋)`.
    Staircase {
        step: Quantity,
        every_s: Quantity,
    },
    /// Rest-to-rest quintic from zero to `size` within `duration_s` of the term.
    Slew {
        size: Quantity,
        width_s: Quantity,
    },
    /// Rows of a table, held (`linear` = false) or joined by natural cubic splines.
    Table {
        time_s: Vec<f64>,
        value: Vec<f64>,
        smooth: bool,
    },
}

/// A sum of terms, each zero outside `[begin_s, end_s)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    pub kind: SignalKind,
    pub begin_s: Quantity,
    /// `None`: to the end of the record.
    pub end_s: Option<Quantity>,
}
