//! Frequencies of slosh in the plane from the gyro alone: the start without which a planar fit
//! locks into a wrong minimum.
//!
//! Hub and slosh swing in modes; each answers to force and torque as one oscillator, so that the
//! rate is linear in what is left when frequency and damping are given:
//!
//! ```text
//! rate = Σ_modes (Σ_inputs g η̇_input + free η̇'s) + Σ_inputs g ∫input + bias + trend
//! ```
//!
//! One mode is searched over the band, the second beside the first, then each again with the other
//! at its new place.

use nalgebra::{SMatrix, SVector, Vector2, Vector3};

use crate::slosh_planar::Wrench;
use physics::slosh::Transition;

/// Columns of a mode: three inputs and two free swings.
const PER_MODE: usize = 5;
/// Three integrals of inputs, bias, trend.
const RIGID: usize = 5;
const COLUMNS_MAX: usize = RIGID + 2 * PER_MODE;

/// Damping of the searched oscillators: a line of a record of a few times its decay is found
/// whatever its damping.
const DAMPING_RATIO: f64 = 0.01;

/// Two modes are told apart when they are at least so many lines (1/T) apart.
const LINES_APART: f64 = 1.0;

/// Points of a search, whatever band and record.
const SCAN_POINTS_MAX: usize = 4096;

/// Thrust and torque held, and what was measured, over one interval; all intervals of a record are
/// of one length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarSample {
    /// Mean over the interval.
    pub wrench: Wrench,
    /// End less begin of the straight line through that mean which has the first moment of what
    /// acted; zero where it was held. An edge within a sum of samples is described by it: without,
    /// sums of 2 s move a mass by one sigma.
    pub wrench_change: Wrench,
    /// Of the sensor, mean over the interval, in the body axes of its middle.
    pub acceleration_m_s2: Vector2<f64>,
    /// Mean over the interval.
    pub rate_rad_s: f64,
}

impl PlanarSample {
    /// The mean of neighbouring samples. The body must not turn much within.
    pub fn mean(samples: &[Self]) -> Self {
        let (share, mut mean) = (1.0 / samples.len() as f64, Self::default());
        for (k, sample) in samples.iter().enumerate() {
            let place = (k as f64 + 0.5) * share - 0.5;
            mean.wrench = mean.wrench.plus(&sample.wrench, share);
            // ∫ τ² dτ over the interval is a twelfth; a line within a part adds the part's own.
            mean.wrench_change = mean.wrench_change.plus(&sample.wrench, 12.0 * place * share);
            mean.wrench_change = mean.wrench_change.plus(&sample.wrench_change, share * share);
            mean.acceleration_m_s2 += sample.acceleration_m_s2 * share;
            mean.rate_rad_s += sample.rate_rad_s * share;
        }
        mean
    }
}

/// Modes and what they explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarModes {
    /// Strongest first.
    pub frequency_hz: [f64; 2],
    /// Sum of squares of the rate explained beyond a rigid craft, by the first alone and by both
    /// [rad²/s²].
    pub explained: [f64; 2],
}

/// One or two modes between the frequencies of `band_hz`. Cost: some 500 walks of the record, 0.1
/// µs per sample each.
pub fn scan_modes(record: &[PlanarSample], interval_s: f64, band_hz: [f64; 2]) -> PlanarModes {
    let search = Search { record, interval_s };
    let line_hz = 1.0 / (record.len() as f64 * interval_s);
    let rigid = search.explained([None, None]);
    let (first, alone) = search.best(band_hz, line_hz / 4.0, |hertz| [Some(hertz), None]);
    // Nearer than a line the second would only mend the shape of the first.
    let (second, both) = search.best(band_hz, line_hz / 4.0, |hertz| {
        if (hertz - first).abs() < LINES_APART * line_hz { [None, None] } else { [Some(first), Some(hertz)] }
    });
    let (mut frequency_hz, mut explained) = ([first, second], both);
    for fineness in [6.0, 12.0, 24.0] {
        for moving in [0, 1] {
            let around = frequency_hz[moving];
            let reach_hz = 12.0 * line_hz / fineness;
            let (best, value) = search.best([around - reach_hz, around + reach_hz], line_hz / fineness, |hertz| {
                let mut both = frequency_hz.map(Some);
                both[moving] = Some(hertz);
                both
            });
            if value > explained {
                (frequency_hz[moving], explained) = (best, value);
            }
        }
    }
    PlanarModes { frequency_hz, explained: [alone - rigid, explained - rigid] }
}

struct Search<'a> {
    record: &'a [PlanarSample],
    interval_s: f64,
}

impl Search<'_> {
    fn best(&self, band_hz: [f64; 2], step_hz: f64, modes: impl Fn(f64) -> [Option<f64>; 2]) -> (f64, f64) {
        let mut best = (band_hz[0].max(step_hz), 0.0);
        for k in 0..SCAN_POINTS_MAX {
            let hertz = band_hz[0] + k as f64 * step_hz;
            if hertz > band_hz[1] {
                break;
            }
            if hertz < step_hz {
                continue;
            }
            let explained = self.explained(modes(hertz));
            if explained > best.1 {
                best = (hertz, explained);
            }
        }
        best
    }

    /// Sum of squares of the rate in the span of the columns.
    fn explained(&self, modes: [Option<f64>; 2]) -> f64 {
        let dt = self.interval_s;
        let mut swings = modes.map(|hertz| hertz.map(|hertz| Swing::new(hertz, dt)));
        let count = RIGID + PER_MODE * swings.iter().flatten().count();
        let (mut impulse, middle) = (Vector3::zeros(), self.record.len() as f64 / 2.0);
        let (mut normal, mut right) =
            (SMatrix::<f64, COLUMNS_MAX, COLUMNS_MAX>::identity(), SVector::<f64, COLUMNS_MAX>::zeros());
        normal.view_mut((0, 0), (count, count)).fill(0.0);
        let mut row = SVector::<f64, COLUMNS_MAX>::zeros();
        for (k, sample) in self.record.iter().enumerate() {
            let Wrench { force_n, torque_n_m } = sample.wrench;
            let inputs = Vector3::new(force_n[0], force_n[1], torque_n_m);
            let mean = impulse + inputs * (dt / 2.0);
            impulse += inputs * dt;
            row.fixed_rows_mut::<3>(0).copy_from(&mean);
            (row[3], row[4]) = (1.0, (k as f64 - middle) / middle);
            for (place, swing) in swings.iter_mut().flatten().enumerate() {
                let columns = swing.step(&inputs);
                row.fixed_rows_mut::<PER_MODE>(RIGID + place * PER_MODE).copy_from(&columns);
            }
            for i in 0..count {
                right[i] += row[i] * sample.rate_rad_s;
                for j in 0..=i {
                    normal[(i, j)] += row[i] * row[j];
                }
            }
        }
        solve_square(&normal, &right, count)
    }
}

/// `r' N⁻¹ r` by an elimination that leaves out columns without content of their own; lower
/// triangle of `N`.
fn solve_square(
    normal: &SMatrix<f64, COLUMNS_MAX, COLUMNS_MAX>,
    right: &SVector<f64, COLUMNS_MAX>,
    count: usize,
) -> f64 {
    /// Of a column's own square: below, what is left of it is rounding.
    const OWN: f64 = 1e-9;
    let (mut factor, mut solved, mut sum) =
        (SMatrix::<f64, COLUMNS_MAX, COLUMNS_MAX>::zeros(), [0.0; COLUMNS_MAX], 0.0);
    for i in 0..count {
        for j in 0..i {
            if factor[(j, j)] > 0.0 {
                let dot: f64 = (0..j).map(|k| factor[(i, k)] * factor[(j, k)]).sum();
                factor[(i, j)] = (normal[(i, j)] - dot) / factor[(j, j)];
            }
        }
        let pivot = normal[(i, i)] - (0..i).map(|k| factor[(i, k)] * factor[(i, k)]).sum::<f64>();
        if pivot > OWN * normal[(i, i)] {
            factor[(i, i)] = libm::sqrt(pivot);
            let dot: f64 = (0..i).map(|k| factor[(i, k)] * solved[k]).sum();
            solved[i] = (right[i] - dot) / factor[(i, i)];
            sum += solved[i] * solved[i];
        }
    }
    sum
}

/// One oscillator under three inputs, and swinging freely in two ways.
struct Swing {
    transition: Transition,
    interval_s: f64,
    forced: [Vector2<f64>; 3],
    free: [Vector2<f64>; 2],
}

impl Swing {
    fn new(hertz: f64, interval_s: f64) -> Self {
        let omega = 2.0 * core::f64::consts::PI * hertz;
        // A base of one kilogram: the transition is driven by minus the force.
        let transition = Transition::new(omega * omega, 2.0 * DAMPING_RATIO * omega, interval_s, 1.0);
        Self { transition, interval_s, forced: [Vector2::zeros(); 3], free: [Vector2::x(), Vector2::y()] }
    }

    /// Mean speeds over the interval.
    fn step(&mut self, inputs: &Vector3<f64>) -> SVector<f64, PER_MODE> {
        let mut columns = SVector::zeros();
        for (i, state) in self.forced.iter_mut().enumerate() {
            let next = self.transition.apply(state, &Vector2::new(inputs[i] * self.interval_s, 0.0));
            columns[i] = (next[0] - state[0]) / self.interval_s;
            *state = next;
        }
        for (i, state) in self.free.iter_mut().enumerate() {
            let next = self.transition.phi * *state;
            columns[3 + i] = (next[0] - state[0]) / self.interval_s;
            *state = next;
        }
        columns
    }
}
