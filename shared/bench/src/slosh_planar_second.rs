//! A second slosh mass beside a first that does not explain the record: posterior over its
//! frequency, damping and axis.
//!
//! A second mass is often seen by what it adds to mass and inertia rather than by its own swing;
//! its frequency then has many near-equal minima, and the curvature of any one of them promises too
//! much. Frequency f, damping ratio ζ and axis are therefore walked on a grid; at each point the
//! eight other numbers (five of the first, mass and place of the second) are fitted together, and
//! the points are mixed:
//!
//! ```text
//! ln w = −χ²/2 + ½ ln |C8| + ln p(ζ) + ln p(f)        Laplace's approximation of what the point explains
//! mean = Σ w θ,   covariance = Σ w (J C8 J' + h²/12 θ_f θ_f' + θθ') − mean mean'      θ: [ms, k, c, bx, by] of both
//! ```
//!
//! A point stands for its cell of the grid, one line (h = 1/T) wide; `θ_f` is ∂θ/∂f, the eight
//! held. `p(ζ)` log-normal about 1 % by a factor of e (Gauss–Hermite, three points), `p(f)` even in
//! ln f over the band, both axes alike. Where the mixture lies within one line and on one axis the
//! record decides alone, and the joint fit of all ten is the answer.

mod grid;
mod mixture;

use libm::{log, sqrt};
use nalgebra::{SMatrix, SVector};

use self::grid::{AT_A_POINT, Point, derivative};
pub use self::grid::{SecondAxis, TWO_MASSES, two_masses};
use self::mixture::{Cell, Mixture};
use crate::slosh_planar::PlanarHub;
use crate::slosh_planar_fit::{PlanarEstimate, PlanarPrior, chi_square, fit, fit_with};
use crate::slosh_planar_id::{Best, ONE_AXIS, PlanarSearch, for_each_place};
use crate::slosh_planar_record::{PlanarError, PlanarRecord};

/// Frequencies of the grid, a line apart.
const GRID_POINTS_MAX: usize = 256;
/// Damping ratios of the grid and their logarithmic prior, up to a constant, the median first:
/// nodes 0, ∓√3 and weights 2/3, 1/6, 1/6 of Gauss and Hermite for `ln(ζ/0.01)` of unit variance.
const RATIOS: [(f64, f64); 3] = [(0.01, 0.0), (0.001_769_2, -1.386_294), (0.056_522, -1.386_294)];
/// Iterations from the neighbour on the grid, of a start, and of a point that counts, which must
/// converge.
const ITERATIONS: [u32; 3] = [2, 4, 15];
/// A point whose ln w is further than this below the greatest does not count: e⁻⁷.
const COUNTS: f64 = 7.0;
/// An axis of less probability than this is not that of the second mass.
const OTHER_AXIS: f64 = 1e-3;
/// A neighbour further than this from the best is no start.
const STARTS_FROM: f64 = 60.0;
/// Starts at the top of the band, where the second mass nearly stands still and the rest is nearly
/// all there is.
const STARTS: usize = 3;

const AXES: [SecondAxis; 2] = [SecondAxis::X, SecondAxis::Y];

/// What the record says of two masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondMass {
    /// `[ms, k, c, bx, by]` of the first, then of the second.
    pub theta: SVector<f64, TWO_MASSES>,
    pub covariance: SMatrix<f64, TWO_MASSES, TWO_MASSES>,
    /// Probability that the second moves along x; along y otherwise.
    pub along_x: f64,
    /// Of the second mass on its spring against the bare hub, `√(k per_force)/2π`: not a mode of
    /// the craft, which the first mass shifts.
    pub frequency_hz: f64,
    pub frequency_sigma_hz: f64,
    /// Of the best point.
    pub chi_square: f64,
    pub degrees_of_freedom: f64,
    /// One minimum holds all: ten numbers fitted jointly, without a prior.
    pub is_joint: bool,
}

impl SecondMass {
    /// Standard deviations of the posterior, in the units of `theta`.
    pub fn sigmas(&self) -> SVector<f64, TWO_MASSES> {
        self.covariance.diagonal().map(sqrt)
    }

    /// Within one line and on one axis.
    fn is_sharp(&self, line_hz: f64) -> bool {
        self.frequency_sigma_hz < line_hz && (self.along_x - 0.5).abs() > 0.5 - OTHER_AXIS
    }

    /// `(χ² − dof)/√(2 dof)`.
    pub fn z_score(&self) -> f64 {
        (self.chi_square - self.degrees_of_freedom) / sqrt(2.0 * self.degrees_of_freedom)
    }
}

struct Search<'a> {
    record: &'a PlanarRecord<'a>,
    hub: PlanarHub,
    line_hz: f64,
    scale: SVector<f64, AT_A_POINT>,
    prior: PlanarPrior<AT_A_POINT>,
}

type Fit = PlanarEstimate<AT_A_POINT>;
/// ln w and the eight numbers of a point.
type Walked = (f64, SVector<f64, AT_A_POINT>);

impl<'a> Search<'a> {
    fn new(
        record: &'a PlanarRecord<'a>,
        hub: PlanarHub,
        search: &PlanarSearch,
        first: &SVector<f64, ONE_AXIS>,
    ) -> Self {
        let mut scale = SVector::<f64, AT_A_POINT>::repeat(0.3 * search.reach_m);
        scale.fixed_rows_mut::<3>(0).copy_from(&first.fixed_rows::<3>(0).abs());
        scale[5] = 0.01 * hub.mass_kg;
        // A tank is within reach: where the second leaves no trace of its place that is all there
        // is to know.
        let mut prior = PlanarPrior::<AT_A_POINT>::none();
        let within = 1.0 / (search.reach_m * search.reach_m);
        (prior.information[(6, 6)], prior.information[(7, 7)]) = (within, within);
        let line_hz = 1.0 / (record.samples.len() as f64 * record.interval_s);
        Self { record, hub, line_hz, scale, prior }
    }

    fn fit(&self, point: &Point, start: &SVector<f64, AT_A_POINT>, iterations: u32) -> Option<Fit> {
        let craft = |eight: &SVector<f64, AT_A_POINT>| {
            if eight[5] <= 0.0 {
                return None;
            }
            two_masses(self.hub, point.axis, &point.ten(&self.hub, eight))
        };
        fit_with(self.record, &craft, (start, &self.scale), &self.prior, iterations).ok()
    }

    /// The best of some starts with the first as it was found alone.
    fn start(&self, point: &Point, search: &PlanarSearch, first: &SVector<f64, ONE_AXIS>) -> Option<Fit> {
        let mut starts = Best::<AT_A_POINT>::new();
        for_each_place(&self.hub, search, |mass_kg, place_m| {
            let mut eight = SVector::<f64, AT_A_POINT>::zeros();
            eight.fixed_rows_mut::<ONE_AXIS>(0).copy_from(first);
            (eight[5], eight[6], eight[7]) = (mass_kg, place_m[0], place_m[1]);
            let craft = two_masses(self.hub, point.axis, &point.ten(&self.hub, &eight));
            if let Some(value) = chi_square(self.record, &|_: &SVector<f64, 1>| craft, &SVector::zeros()) {
                starts.offer(value, eight);
            }
        });
        let fits = starts.found().take(STARTS).filter_map(|start| self.fit(point, start, ITERATIONS[1]));
        fits.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
    }

    /// ln w but for the prior of the damping.
    fn log_weight(&self, point: &Point, fit: &Fit) -> Option<f64> {
        let scaling = SMatrix::<f64, AT_A_POINT, AT_A_POINT>::from_diagonal(&self.scale.map(|value| 1.0 / value));
        let factor = (scaling * fit.covariance * scaling).cholesky()?;
        let half_log_det: f64 = factor.l_dirty().diagonal().iter().map(|value| log(*value)).sum();
        Some(half_log_det - log(point.hertz) - fit.chi_square / 2.0).filter(|value| value.is_finite())
    }

    /// What a fit says of the cell of its point.
    fn cell(&self, point: &Point, fit: &Fit, log_weight: f64) -> Cell {
        let jacobian = point.jacobian(&self.hub, &fit.theta, &self.scale);
        let slope = point.slope_per_hz(&self.hub, &fit.theta);
        let covariance = jacobian * fit.covariance * jacobian.transpose();
        let width_hz = self.line_hz;
        Cell {
            axis: point.axis,
            hertz: point.hertz,
            width_hz,
            log_weight,
            theta: point.ten(&self.hub, &fit.theta),
            covariance: covariance + slope * slope.transpose() * (width_hz * width_hz / 12.0),
        }
    }

    /// The fits of one axis from the top of the band to its bottom, each from its neighbour. `None`
    /// without a start.
    fn down_the_band(
        &self,
        axis: SecondAxis,
        search: &PlanarSearch,
        first: &SVector<f64, ONE_AXIS>,
        found: &mut [Option<Walked>; GRID_POINTS_MAX],
    ) -> Option<()> {
        let mut start = self.start(&self.point(axis, 0, search), search, first)?.theta;
        let mut lowest = f64::INFINITY;
        for (k, found) in found.iter_mut().enumerate() {
            let point = self.point(axis, k, search);
            if point.hertz < search.band_hz[0] {
                break;
            }
            let Some(fit) = self.fit(&point, &start, ITERATIONS[0]) else { continue };
            lowest = lowest.min(fit.chi_square);
            if fit.chi_square < lowest + STARTS_FROM {
                start = fit.theta;
            }
            *found = self.log_weight(&point, &fit).map(|log_weight| (log_weight, fit.theta));
        }
        Some(())
    }

    /// Point k of the grid at the median of the damping.
    fn point(&self, axis: SecondAxis, k: usize, search: &PlanarSearch) -> Point {
        Point { axis, hertz: search.band_hz[1] - k as f64 * self.line_hz, ratio: RATIOS[0].0 }
    }

    /// The points that count, at every damping ratio, and the best of them. `None` where an axis
    /// has points that count and none of them converges: the other would win by that alone.
    fn mixed(
        &self,
        search: &PlanarSearch,
        grid: &[[Option<Walked>; GRID_POINTS_MAX]; 2],
    ) -> Option<(Mixture, (Point, Fit))> {
        let walked = grid.iter().flatten().flatten();
        let greatest = walked.map(|(log_weight, _)| *log_weight).fold(f64::NEG_INFINITY, f64::max);
        let counts = |(log_weight, _): &Walked| *log_weight > greatest - COUNTS;
        let (mut mixture, mut best) = (Mixture::new(), None::<(Point, Fit)>);
        for (axis, found) in AXES.into_iter().zip(grid) {
            let mut has_any = false;
            let before = mixture.cells;
            for (k, walked) in found.iter().enumerate() {
                let Some((_, theta)) = walked.filter(counts) else { continue };
                has_any = true;
                for (ratio, log_prior) in RATIOS {
                    let point = Point { ratio, ..self.point(axis, k, search) };
                    let fit = self.fit(&point, &theta, ITERATIONS[2]).filter(|fit| fit.is_converged);
                    let Some((fit, log_weight)) = fit.and_then(|fit| Some((fit, self.log_weight(&point, &fit)?)))
                    else {
                        continue;
                    };
                    mixture.add(&self.cell(&point, &fit, log_weight + log_prior));
                    if best.is_none_or(|(_, best)| fit.chi_square < best.chi_square) {
                        best = Some((point, fit));
                    }
                }
            }
            if has_any && mixture.cells == before {
                return None;
            }
        }
        best.map(|best| (mixture, best))
    }

    /// All ten together, from the best point of the grid: where the record decides alone.
    fn joint(&self, point: &Point, best: &Fit) -> Option<SecondMass> {
        let (hub, start) = (self.hub, point.ten(&self.hub, &best.theta));
        let craft = |ten: &SVector<f64, TWO_MASSES>| two_masses(hub, point.axis, ten);
        // A place may be zero.
        let mut scale = start.abs();
        for place in [3, 4, 8, 9] {
            scale[place] = self.scale[3];
        }
        let fit = fit(self.record, &craft, &start, &scale).ok()?;
        let hertz = |ten: &SVector<f64, TWO_MASSES>| point.axis.frequency_hz(&hub, ten);
        let frequency_hz = hertz(&fit.theta);
        let slope = derivative(|ten| SVector::<f64, 1>::new(hertz(ten)), &fit.theta, &scale).transpose();
        (fit.is_converged && fit.theta[7] > 0.0).then(|| SecondMass {
            theta: fit.theta,
            covariance: fit.covariance,
            along_x: if point.axis == SecondAxis::X { 1.0 } else { 0.0 },
            frequency_hz,
            frequency_sigma_hz: sqrt(slope.dot(&(fit.covariance * slope))),
            chi_square: fit.chi_square,
            degrees_of_freedom: fit.degrees_of_freedom,
            is_joint: true,
        })
    }
}

/// Both masses of a record whose first, `[ms, k, c, bx, by]` along y, was fitted as if it were
/// alone. Cost: some 8000 walks of the record; sum its samples to a dozen per period of the fastest
/// mode that is looked for.
///
/// # Errors
/// [`PlanarError::NotObserved`] when an axis has no start, or no point that counts converges;
/// [`PlanarError::BandTooWide`] for a band of more lines than the grid has points: minima between
/// them would be missed.
pub fn identify_second(
    record: &PlanarRecord<'_>,
    hub: PlanarHub,
    search: &PlanarSearch,
    first: &SVector<f64, ONE_AXIS>,
) -> Result<SecondMass, PlanarError> {
    let walk = Search::new(record, hub, search, first);
    let lines = (search.band_hz[1] - search.band_hz[0]) / walk.line_hz;
    if lines >= GRID_POINTS_MAX as f64 {
        return Err(PlanarError::BandTooWide { lines, most: GRID_POINTS_MAX });
    }
    let mut grid = [[None; GRID_POINTS_MAX]; 2];
    for (axis, found) in AXES.into_iter().zip(&mut grid) {
        walk.down_the_band(axis, search, first, found).ok_or(PlanarError::NotObserved)?;
    }
    let (mixture, (point, best)) = walk.mixed(search, &grid).ok_or(PlanarError::NotObserved)?;
    let mixed = mixture.report(&best);
    let joint = if mixed.is_sharp(walk.line_hz) { walk.joint(&point, &best) } else { None };
    Ok(joint.unwrap_or(mixed))
}

#[cfg(test)]
mod tests;
