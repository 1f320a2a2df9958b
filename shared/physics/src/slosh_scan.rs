//! Global start of the slosh fit: variable projection over a grid of frequency and damping.
//!
//! For given (κ, γ) the slosh motion under the known force is known, and the momentum balance is
//! linear in what is left:
//!
//! ```text
//! Δv − ∫f/m0 = −β (∫f/m0 + Δṙ_forced) − β (r0 Δṙ_free,r + ṙ0 Δṙ_free,ṙ) + bias B,      β = ms/(m0+ms)
//! ```
//!
//! so one number (or two, and two for every free segment) is solved per grid point and no local
//! minimum can trap the search. The grid comes from the arc alone: a line of an arc of length T is
//! 1/T wide, a mode is 2ζf wide; steps are a quarter of the one and half of the other, from half a
//! period per arc to the fastest mode its blocks tell.

use estimation::consistency::chi_square_quantile;
use nalgebra::{Matrix2, Vector2, Vector4};
use serde::{Deserialize, Serialize};

use crate::slosh::{NeighbouringTransitions, SloshParameters, Transition};
use crate::slosh_arc::{RESOLVED_MERGED, SAME_LENGTH, SloshArc};
use crate::slosh_likelihood::{SEGMENT_BLOCKS_MIN, SloshUnknowns, solve_scaled};

/// A decade apart where damping hardly shows, closer where it does.
const DAMPING_RATIOS: [f64; 4] = [0.002, 0.02, 0.1, 0.4];

/// Bound on the work of one damping ratio, whatever the arc; a full arc of single samples needs
/// 3700.
const FREQUENCIES_MAX: usize = 4096;

/// Chance that an arc without slosh yields a candidate.
const FALSE_ALARM: f64 = 1e-4;

/// Pieces in which [`prefers_a_fast_mode`] looks at the arc.
const PIECE_BLOCKS: usize = 128;

/// Where to start the maximum likelihood fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshCandidate {
    pub parameters: SloshParameters,
    pub bias_m_s2: f64,
    /// χ² that slosh explains beyond a rigid spacecraft.
    pub gain: f64,
}

/// Best candidate of each damping ratio, best first, and the gain noise alone could reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshScan {
    pub candidates: [SloshCandidate; DAMPING_RATIOS.len()],
    /// Gain that an arc without slosh exceeds with probability `FALSE_ALARM`.
    pub threshold: f64,
    pub grid_points: usize,
    /// Frequencies that were searched; slosh outside is neither found nor excluded.
    pub band_hz: [f64; 2],
}

/// Searches all frequencies the arc tells, at the start state and bias `unknowns` says. Cost O(grid
/// × blocks).
///
/// `mass_ratio` is what is known of β beforehand, and its standard deviation: a free swing alone
/// does not tell it.
pub fn scan<const N: usize>(
    arc: &SloshArc<N>,
    base_mass_kg: f64,
    unknowns: SloshUnknowns,
    mass_ratio: Option<[f64; 2]>,
) -> SloshScan {
    let band_hz = [0.5 / arc.duration_s(), arc.resolved_rad_s() / (2.0 * core::f64::consts::PI)];
    Projection { arc, base_mass_kg, unknowns, mass_ratio, piece_blocks: usize::MAX }.search(band_hz)
}

/// True when the arc shows a mode that it would no longer tell once its blocks are merged: the gain
/// of the band that would be lost exceeds the gain of what is kept by more than noise.
///
/// Looked at in pieces of [`PIECE_BLOCKS`] with free states: a fast mode lasts many periods in
/// each, and slow slosh is explained there by any slow frequency. A tenth of the cost of a scan.
pub(crate) fn prefers_a_fast_mode<const N: usize>(
    arc: &SloshArc<N>,
    base_mass_kg: f64,
    unknowns: SloshUnknowns,
) -> bool {
    let to_hz = 1.0 / (2.0 * core::f64::consts::PI);
    let kept_hz = RESOLVED_MERGED / (2.0 * arc.resolution_s()) * to_hz;
    let projection = Projection { arc, base_mass_kg, unknowns, mass_ratio: None, piece_blocks: PIECE_BLOCKS };
    let lost = projection.search([kept_hz, arc.resolved_rad_s() * to_hz]);
    if lost.candidates[0].gain <= lost.threshold {
        return false;
    }
    let kept = projection.search([0.5 / projection.coherent_s(), kept_hz]);
    lost.candidates[0].gain - kept.candidates[0].gain > lost.threshold
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

/// The linear problem at every grid point: β and bias, and the start state of every free stretch
/// eliminated.
struct Projection<'a, const N: usize> {
    arc: &'a SloshArc<N>,
    base_mass_kg: f64,
    unknowns: SloshUnknowns,
    mass_ratio: Option<[f64; 2]>,
    /// Segments are cut into stretches of so many blocks.
    piece_blocks: usize,
}

/// Normal equations of `[β, bias]` and the χ² explained by what was eliminated.
struct Normal {
    matrix: Matrix2<f64>,
    vector: Vector2<f64>,
    explained: f64,
}

impl<const N: usize> Projection<'_, N> {
    fn search(&self, [low_hz, high_hz]: [f64; 2]) -> SloshScan {
        let mut candidates = [SloshCandidate::default(); DAMPING_RATIOS.len()];
        let (rigid, line_hz) = (self.rigid_gain(), 0.25 / self.coherent_s());
        let (mut grid_points, mut reached_hz) = (0, high_hz);
        for (best, damping_ratio) in candidates.iter_mut().zip(DAMPING_RATIOS) {
            let mut frequency_hz = low_hz;
            for _ in 0..FREQUENCIES_MAX {
                if frequency_hz >= high_hz {
                    break;
                }
                grid_points += 1;
                let point = GridPoint::new(frequency_hz, damping_ratio);
                if let Some(candidate) = self.project(&point, rigid)
                    && candidate.gain > best.gain
                {
                    *best = candidate;
                }
                frequency_hz += line_hz.max(damping_ratio * frequency_hz);
            }
            reached_hz = reached_hz.min(frequency_hz);
        }
        candidates.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain));
        // Every grid point counts as an independent trial; neighbours are not, so the threshold
        // errs to the safe side.
        let degrees = 1.0 + 2.0 * self.stretches().filter(|stretch| stretch.is_free).count() as f64;
        let threshold = chi_square_quantile(1.0 - FALSE_ALARM / grid_points.max(1) as f64, degrees);
        SloshScan { candidates, threshold, grid_points, band_hz: [low_hz, reached_hz] }
    }

    fn knows_bias(&self) -> bool {
        self.unknowns == SloshUnknowns::Parameters
    }

    fn coherent_s(&self) -> f64 {
        self.arc.duration_s().min(self.piece_blocks as f64 * self.arc.resolution_s())
    }

    fn stretches(&self) -> impl Iterator<Item = Stretch> + '_ {
        let knows_start = self.knows_bias() && !self.arc.has_forgotten_the_start();
        (0..self.arc.segments()).flat_map(move |segment| {
            let (from, until) = self.arc.segment(segment);
            let pieces = (until - from).div_ceil(self.piece_blocks);
            (0..pieces).map(move |piece| {
                let start = from + piece * self.piece_blocks;
                let end = until.min(start.saturating_add(self.piece_blocks));
                Stretch { blocks: (start, end), is_free: start > 0 || !knows_start }
            })
        })
    }

    /// χ² that the bias alone explains (zero when no bias is estimated).
    fn rigid_gain(&self) -> f64 {
        let (mut zb, mut bb) = (0.0, 0.0);
        for block in self.arc.blocks() {
            let z = block.delta_v_m_s - block.force.impulse_n_s / self.base_mass_kg;
            zb += z * block.length_s * block.weight();
            bb += block.length_s * block.length_s * block.weight();
        }
        if self.knows_bias() || bb == 0.0 { 0.0 } else { zb * zb / bb }
    }

    /// Solves the linear unknowns at one grid point; `None` when they are not physical (β outside
    /// (0, 1)).
    fn project(&self, point: &GridPoint, rigid: f64) -> Option<SloshCandidate> {
        let mut normal = Normal { matrix: Matrix2::zeros(), vector: Vector2::zeros(), explained: 0.0 };
        let mut transition = CachedTransition::new(point, self.base_mass_kg, self.arc.block_length_s());
        for stretch in self.stretches() {
            if stretch.is_free {
                self.add_free(&stretch, &mut transition, &mut normal);
            } else {
                self.add_quiescent(&stretch, &mut transition, &mut normal);
            }
        }
        if self.knows_bias() {
            normal.matrix = Matrix2::new(normal.matrix[(0, 0)], 0.0, 0.0, 1.0);
            normal.vector[1] = 0.0;
        }
        let (mut matrix, mut vector) = (normal.matrix, normal.vector);
        if let Some([expected, sigma]) = self.mass_ratio {
            matrix[(0, 0)] += 1.0 / (sigma * sigma);
            vector[0] += expected / (sigma * sigma);
        }
        let solution = matrix.cholesky()?.solve(&vector);
        let beta = solution[0];
        if !(beta > 0.0 && beta < 1.0) {
            return None;
        }
        let mu = beta * self.base_mass_kg;
        let parameters = SloshParameters {
            slosh_mass_kg: mu / (1.0 - beta),
            stiffness_n_m: point.kappa * mu,
            damping_n_s_m: point.gamma * mu,
        };
        // Of the record alone, wherever the solution was drawn to.
        let gain = (normal.vector * 2.0 - normal.matrix * solution).dot(&solution) + normal.explained - rigid;
        Some(SloshCandidate { parameters, bias_m_s2: solution[1], gain })
    }

    fn add_quiescent(&self, stretch: &Stretch, transition: &mut CachedTransition<'_>, normal: &mut Normal) {
        let (per_mass, mut forced) = (1.0 / self.base_mass_kg, Vector2::zeros());
        let (mut square, mut cross) = (0.0, 0.0);
        // `for_each`, not `for`: the chained iterator of the arc is then one plain loop (a third
        // faster).
        self.arc.blocks_of(stretch.blocks).for_each(|block| {
            let next = transition.of(block.length_s).apply(&forced, &block.force_vector());
            let (rigid_dv, weight) = (block.force.impulse_n_s * per_mass, block.weight());
            let column = -(rigid_dv + next[1] - forced[1]);
            forced = next;
            square += column * column * weight;
            cross += column * (block.delta_v_m_s - rigid_dv) * weight;
        });
        // The bias is known here: its row is not used.
        normal.matrix[(0, 0)] += square;
        normal.vector[0] += cross;
    }

    fn add_free(&self, stretch: &Stretch, transition: &mut CachedTransition<'_>, normal: &mut Normal) {
        let (per_mass, mut forced) = (1.0 / self.base_mass_kg, Vector2::zeros());
        let mut free = Matrix2::identity();
        let (mut matrix, mut vector, mut measured) = (nalgebra::Matrix4::zeros(), Vector4::zeros(), 0);
        self.arc.blocks_of(stretch.blocks).for_each(|block| {
            let step = transition.of(block.length_s);
            let (rigid_dv, weight) = (block.force.impulse_n_s * per_mass, block.weight());
            let (next, next_free) = (step.apply(&forced, &block.force_vector()), step.phi * free);
            let column = Vector4::new(
                -(rigid_dv + next[1] - forced[1]),
                block.length_s,
                free[(1, 0)] - next_free[(1, 0)],
                free[(1, 1)] - next_free[(1, 1)],
            );
            (forced, free) = (next, next_free);
            vector += column * ((block.delta_v_m_s - rigid_dv) * weight);
            matrix += column * (column * weight).transpose();
            measured += usize::from(block.is_measured());
        });
        if measured < SEGMENT_BLOCKS_MIN {
            return;
        }
        let states: Matrix2<f64> = matrix.fixed_view::<2, 2>(2, 2).into();
        let cross: Matrix2<f64> = matrix.fixed_view::<2, 2>(2, 0).into();
        let right: Vector2<f64> = vector.fixed_rows::<2>(2).into();
        let solved =
            [cross.column(0).into(), cross.column(1).into(), right].map(|column| solve_scaled(&states, &column));
        let [Some(by_beta), Some(by_bias), Some(state)] = solved else { return };
        normal.matrix +=
            matrix.fixed_view::<2, 2>(0, 0) - cross.transpose() * Matrix2::from_columns(&[by_beta, by_bias]);
        normal.vector += vector.fixed_rows::<2>(0) - cross.transpose() * state;
        normal.explained += right.dot(&state);
    }
}

/// Blocks with one unknown start state, or none.
struct Stretch {
    blocks: (usize, usize),
    is_free: bool,
}

/// Blocks of one arc are nearly of one length: the exponential is computed again only out of the
/// reach of its series.
struct CachedTransition<'a> {
    point: &'a GridPoint,
    base_mass_kg: f64,
    length_s: f64,
    transition: Transition,
    neighbours: NeighbouringTransitions,
}

impl<'a> CachedTransition<'a> {
    fn new(point: &'a GridPoint, base_mass_kg: f64, length_s: f64) -> Self {
        let transition = Transition::new(point.kappa, point.gamma, length_s, base_mass_kg);
        let neighbours = NeighbouringTransitions::new(&transition, point.kappa, point.gamma, length_s, base_mass_kg);
        Self { point, base_mass_kg, length_s, transition, neighbours }
    }

    #[inline]
    fn of(&mut self, length_s: f64) -> &Transition {
        if (length_s - self.length_s).abs() > SAME_LENGTH * length_s {
            self.length_s = length_s;
            self.transition = self
                .neighbours
                .at(length_s)
                .unwrap_or_else(|| Transition::new(self.point.kappa, self.point.gamma, length_s, self.base_mass_kg));
        }
        &self.transition
    }
}
