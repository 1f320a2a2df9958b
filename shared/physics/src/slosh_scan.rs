//! Global start of the slosh fit: variable projection over a grid of frequency and damping.
//!
//! For given (κ, γ) the slosh motion under the known force is known, and the momentum balance is linear in what is left:
//!
//! ```text
//! Δv − ∫f/m0 = −β (∫f/m0 + Δṙ_forced) − β (r0 Δṙ_free,r + ṙ0 Δṙ_free,ṙ) + bias B,      β = ms/(m0+ms)
//! ```
//!
//! so one number (or four) is solved per grid point and no local minimum can trap the search. The grid comes from the
//! arc alone: a line of an arc of length T is 1/T wide, a mode is 2ζf wide; steps are a quarter of the one and half of
//! the other, from half a period per arc to the Nyquist frequency of the blocks.

use estimation::consistency::chi_square_quantile;
use nalgebra::{SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};

use crate::slosh::{SloshParameters, SloshState, Transition};
use crate::slosh_arc::SloshArc;

/// A decade apart where damping hardly shows, closer where it does.
const DAMPING_RATIOS: [f64; 4] = [0.002, 0.02, 0.1, 0.4];

/// Bound on the work of one damping ratio, whatever the arc.
const FREQUENCIES_MAX: usize = 2048;

/// Chance that an arc without slosh yields a candidate.
const FALSE_ALARM: f64 = 1e-4;

/// Where to start the maximum likelihood fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshCandidate {
    pub parameters: SloshParameters,
    pub state: SloshState,
    pub bias_m_s2: f64,
    /// χ² that slosh explains beyond a rigid spacecraft.
    pub gain: f64,
}

/// Best candidate of each damping ratio, best first, and the gain noise alone could reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshScan {
    pub candidates: [SloshCandidate; DAMPING_RATIOS.len()],
    /// Gain that an arc without slosh exceeds with probability [`FALSE_ALARM`].
    pub threshold: f64,
    pub grid_points: usize,
}

/// Quiescent start, no bias: one linear unknown. Cost O(grid × blocks).
pub fn scan_quiescent<const N: usize>(arc: &SloshArc<N>, base_mass_kg: f64) -> SloshScan {
    scan::<N, 1>(arc, base_mass_kg)
}

/// Unknown slosh state at the start and unknown accelerometer bias: four linear unknowns.
pub fn scan_with_nuisances<const N: usize>(arc: &SloshArc<N>, base_mass_kg: f64) -> SloshScan {
    scan::<N, 4>(arc, base_mass_kg)
}

fn scan<const N: usize, const COLUMNS: usize>(arc: &SloshArc<N>, base_mass_kg: f64) -> SloshScan {
    const { assert!(COLUMNS == 1 || COLUMNS == 4) }
    let mut candidates = [SloshCandidate::default(); DAMPING_RATIOS.len()];
    let (duration, nyquist) = (arc.duration_s(), 0.5 / arc.block_length_s());
    let rigid = rigid_gain(arc, base_mass_kg, COLUMNS);
    let mut grid_points = 0;
    for (best, damping_ratio) in candidates.iter_mut().zip(DAMPING_RATIOS) {
        let mut frequency_hz = 0.5 / duration;
        for _ in 0..FREQUENCIES_MAX {
            if frequency_hz >= nyquist {
                break;
            }
            grid_points += 1;
            let point = GridPoint::new(frequency_hz, damping_ratio);
            if let Some(candidate) = project::<N, COLUMNS>(arc, base_mass_kg, &point, rigid)
                && candidate.gain > best.gain
            {
                *best = candidate;
            }
            frequency_hz += (0.25 / duration).max(damping_ratio * frequency_hz);
        }
    }
    candidates.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain));
    // Every grid point counts as an independent trial; neighbours are not, so the threshold errs to the safe side.
    let degrees = if COLUMNS == 1 { 1.0 } else { 3.0 };
    let threshold = chi_square_quantile(1.0 - FALSE_ALARM / grid_points.max(1) as f64, degrees);
    SloshScan { candidates, threshold, grid_points }
}

struct GridPoint {
    kappa: f64,
    gamma: f64,
}

impl GridPoint {
    fn new(frequency_hz: f64, damping_ratio: f64) -> Self {
        let omega = 2.0 * core::f64::consts::PI * frequency_hz;
        Self { kappa: omega * omega, gamma: 2.0 * damping_ratio * omega }
    }
}

/// χ² that the bias alone explains (zero when no bias is estimated).
fn rigid_gain<const N: usize>(arc: &SloshArc<N>, base_mass_kg: f64, columns: usize) -> f64 {
    let (mut zb, mut bb) = (0.0, 0.0);
    for block in arc.blocks() {
        let z = block.delta_v_m_s - block.force.impulse_n_s / base_mass_kg;
        zb += z * block.length_s / block.variance_m2_s2;
        bb += block.length_s * block.length_s / block.variance_m2_s2;
    }
    if columns == 1 || bb == 0.0 { 0.0 } else { zb * zb / bb }
}

/// Solves the linear unknowns at one grid point; `None` when they are not physical (β outside (0, 1)).
fn project<const N: usize, const COLUMNS: usize>(
    arc: &SloshArc<N>,
    base_mass_kg: f64,
    point: &GridPoint,
    rigid: f64,
) -> Option<SloshCandidate> {
    let mut matrix = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    let mut vector = SVector::<f64, COLUMNS>::zeros();
    let mut transition = CachedTransition::new(point, base_mass_kg, arc.block_length_s());
    let mut forced = Vector2::zeros();
    let mut free = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
    let per_mass = 1.0 / base_mass_kg;
    // `for_each`, not `for`: the chained iterator of the arc is then one plain loop (a third faster).
    arc.blocks().for_each(|block| {
        let step = transition.of(block.length_s);
        let rigid_dv = block.force.impulse_n_s * per_mass;
        let weight = 1.0 / block.variance_m2_s2;
        let next = step.apply(&forced, &block.force_vector());
        let mut column = SVector::<f64, COLUMNS>::zeros();
        column[0] = -(rigid_dv + next[1] - forced[1]);
        forced = next;
        if COLUMNS == 4 {
            for (k, state) in free.iter_mut().enumerate() {
                let next = step.phi * *state;
                column[1 + k] = state[1] - next[1];
                *state = next;
            }
            column[3] = block.length_s;
        }
        vector += column * ((block.delta_v_m_s - rigid_dv) * weight);
        matrix += column * (column * weight).transpose();
    });
    let solution = matrix.cholesky()?.solve(&vector);
    let beta = solution[0];
    if !(beta > 0.0 && beta < 1.0) {
        return None;
    }
    let mu = beta * base_mass_kg;
    let parameters = SloshParameters {
        slosh_mass_kg: mu / (1.0 - beta),
        stiffness_n_m: point.kappa * mu,
        damping_n_s_m: point.gamma * mu,
    };
    let at = |k: usize| if COLUMNS == 4 { solution[k] } else { 0.0 };
    let state = SloshState { displacement_m: at(1) / beta, velocity_m_s: at(2) / beta };
    Some(SloshCandidate { parameters, state, bias_m_s2: at(3), gain: solution.dot(&vector) - rigid })
}

/// Blocks of one arc have one length, but for the last: compute again only when the length changes.
struct CachedTransition<'a> {
    point: &'a GridPoint,
    base_mass_kg: f64,
    length_s: f64,
    transition: Transition,
}

impl<'a> CachedTransition<'a> {
    fn new(point: &'a GridPoint, base_mass_kg: f64, length_s: f64) -> Self {
        let transition = Transition::new(point.kappa, point.gamma, length_s, base_mass_kg);
        Self { point, base_mass_kg, length_s, transition }
    }

    fn of(&mut self, length_s: f64) -> &Transition {
        if (length_s - self.length_s).abs() > crate::slosh_estimator::SAME_LENGTH * length_s {
            *self = Self::new(self.point, self.base_mass_kg, length_s);
        }
        &self.transition
    }
}
