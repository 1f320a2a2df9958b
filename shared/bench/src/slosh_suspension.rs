//! Spring or pendulum, from several levels of axial thrust (one tank behind the hub's centre of
//! mass, thrust along +x).
//!
//! At one level both are the same to first order. The stiffness of a pendulum is `ms a/L`, that of
//! a spring does not know the acceleration: fitted level by level, `k(a) = k0 + k1 a` has `k0 ≈ 0`
//! for the one and `k1 ≈ 0` for the other; a tank that is both (surface tension and thrust alike)
//! shows both. The joint fits over all levels decide by the Bayesian information criterion, and χ²
//! says whether the winner explains the record.

use nalgebra::{Matrix2, SVector, Vector2};

use crate::slosh_planar::{PlanarHub, PlanarState};
use crate::slosh_planar_fit::{PlanarCraft, fit};
use crate::slosh_planar_id::{ONE_AXIS, PlanarAnswer, PlanarSearch, identify_one_axis, lateral_spring, pendulum};
use crate::slosh_planar_record::{PlanarError, PlanarRecord};
use crate::slosh_planar_scan::scan_modes;

/// Levels a record can have.
pub const LEVELS_MAX: usize = 8;
/// Evidence that decides: a difference of the criterion of ten is a likelihood ratio of e⁵.
pub const BIC_DECIDES: f64 = 10.0;

/// Five numbers, and rate, displacement and speed at the beginning of a level.
const LEVEL_UNKNOWNS: usize = ONE_AXIS + 3;

/// What holds the slosh mass: its stiffness is constant (spring) or proportional to the thrust
/// (pendulum).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspensionKind {
    Spring,
    Pendulum,
}

impl SuspensionKind {
    /// The competing hypothesis.
    pub fn other(self) -> Self {
        if self == Self::Spring { Self::Pendulum } else { Self::Spring }
    }

    /// The craft of its five numbers.
    pub fn craft(self, hub: PlanarHub, theta: &SVector<f64, ONE_AXIS>) -> Option<PlanarCraft<1>> {
        match self {
            Self::Spring => lateral_spring(hub, theta),
            Self::Pendulum => pendulum(hub, theta),
        }
    }
}

/// `k(a) = k0 + k1 a` by weighted least squares over the levels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StiffnessRegression {
    pub offset_n_m: f64,
    pub offset_sigma: f64,
    pub slope_kg_m: f64,
    pub slope_sigma: f64,
    /// Levels that gave a stiffness; two at least, or the rest is zero.
    pub levels: usize,
}

impl StiffnessRegression {
    /// Standard deviations of the offset from zero: small for a pendulum.
    pub fn offset_sigmas(&self) -> f64 {
        self.offset_n_m / self.offset_sigma
    }

    /// Standard deviations of the slope from zero: small for a spring.
    pub fn slope_sigmas(&self) -> f64 {
        self.slope_kg_m / self.slope_sigma
    }
}

/// Both fits, and which of them the record prefers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuspensionVerdict {
    /// `None` when the criterion does not decide, or the winner does not explain the record.
    pub kind: Option<SuspensionKind>,
    pub spring: PlanarAnswer<ONE_AXIS>,
    pub pendulum: PlanarAnswer<ONE_AXIS>,
    pub regression: StiffnessRegression,
    rows: f64,
}

impl SuspensionVerdict {
    /// The fit under one hypothesis.
    pub fn estimate(&self, kind: SuspensionKind) -> &PlanarAnswer<ONE_AXIS> {
        match kind {
            SuspensionKind::Spring => &self.spring,
            SuspensionKind::Pendulum => &self.pendulum,
        }
    }

    /// `χ² + parameters ln rows`.
    pub fn bic(&self, kind: SuspensionKind) -> f64 {
        self.estimate(kind).estimate.chi_square + ONE_AXIS as f64 * libm::log(self.rows)
    }
}

/// A stretch of constant axial thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    from: usize,
    until: usize,
    axial_n: f64,
}

/// A level differs from its neighbour by at least this part of the greatest axial thrust.
const SAME_THRUST: f64 = 0.02;
/// A level shorter than this many samples is a transition.
const LEVEL_SAMPLES_MIN: usize = 64;
/// Samples per period of the fastest mode that is looked for: the integration of the model is exact
/// to 1e-5 there.
const SAMPLES_PER_PERIOD: f64 = 8.0;

/// The levels of a record, in order, coasting among them; of more than there is room for, the
/// first.
fn levels(record: &PlanarRecord<'_>) -> ([Level; LEVELS_MAX], usize) {
    let axial = |k: usize| record.samples[k].wrench.force_n[0];
    let greatest = record.samples.iter().map(|s| s.wrench.force_n[0].abs()).fold(0.0, f64::max);
    let (mut found, mut count) = ([Level { from: 0, until: 0, axial_n: 0.0 }; LEVELS_MAX], 0);
    let (mut from, end) = (0, record.samples.len());
    while from < end && count < LEVELS_MAX {
        let changed = |k: &usize| (axial(*k) - axial(from)).abs() > SAME_THRUST * greatest;
        let until = (from..end).find(changed).unwrap_or(end);
        if until - from >= LEVEL_SAMPLES_MIN {
            found[count] = Level { from, until, axial_n: axial(from) };
            count += 1;
        }
        from = until;
    }
    (found, count)
}

/// Decides over a record that is at rest at its beginning; its levels of axial thrust are read from
/// it, a coast among them or none. `reach_m` is how far from the hub's centre of mass a tank may
/// be.
///
/// # Errors
/// [`PlanarError::NotObserved`] when no level is driven, or a model has no minimum.
pub fn decide(record: &PlanarRecord<'_>, reach_m: f64, hub: &PlanarHub) -> Result<SuspensionVerdict, PlanarError> {
    let (levels, count) = levels(record);
    let levels = &levels[..count];
    let by_thrust = |a: &&Level, b: &&Level| a.axial_n.total_cmp(&b.axial_n);
    let strongest =
        levels.iter().max_by(by_thrust).filter(|level| level.axial_n > 0.0).ok_or(PlanarError::NotObserved)?;
    let samples = &record.samples[strongest.from..strongest.until];
    let search = PlanarSearch { band_hz: band_hz(samples.len(), record.interval_s), reach_m, starts: STARTS };
    let mode_hz = scan_modes(samples, record.interval_s, search.band_hz).frequency_hz[0];
    let axial_m_s2 = |mass_kg: f64| strongest.axial_n / (hub.mass_kg + mass_kg);
    // λ = B k along y: B = 1/μ + x²/I0 (a mass on the thrust line).
    let stiffness = |mass_kg: f64, place: &Vector2<f64>, lambda: f64| {
        lambda / (1.0 / hub.mass_kg + 1.0 / mass_kg + place[0] * place[0] / hub.inertia_com_kg_m2)
    };
    let length = |mass_kg: f64, place: &Vector2<f64>, lambda: f64| {
        mass_kg * axial_m_s2(mass_kg) / stiffness(mass_kg, place, lambda)
    };
    let spring_craft = |theta: &SVector<f64, ONE_AXIS>| lateral_spring(*hub, theta);
    let pendulum_craft = |theta: &SVector<f64, ONE_AXIS>| pendulum(*hub, theta);
    let spring = identify_one_axis(record, hub, &search, mode_hz, &spring_craft, &stiffness)?;
    let pendulum = identify_one_axis(record, hub, &search, mode_hz, &pendulum_craft, &length)?;
    let regression = regress(record, levels, hub, &spring, &pendulum);
    let mut verdict =
        SuspensionVerdict { kind: None, spring, pendulum, regression, rows: 3.0 * record.samples.len() as f64 };
    let margin = verdict.bic(SuspensionKind::Pendulum) - verdict.bic(SuspensionKind::Spring);
    let winner = if margin > 0.0 { SuspensionKind::Spring } else { SuspensionKind::Pendulum };
    let decided = margin.abs() > BIC_DECIDES && verdict.estimate(winner).is_explained;
    verdict.kind = decided.then_some(winner);
    Ok(verdict)
}

/// The wrong model has no minimum worth finding: few starts.
const STARTS: usize = 3;

/// From two periods in a stretch to what its samples tell.
fn band_hz(samples: usize, interval_s: f64) -> [f64; 2] {
    [2.0 / (samples as f64 * interval_s), 1.0 / (SAMPLES_PER_PERIOD * interval_s)]
}

/// Spring fits level by level, each with a free start, regressed on the axial acceleration.
fn regress(
    record: &PlanarRecord<'_>,
    levels: &[Level],
    hub: &PlanarHub,
    spring: &PlanarAnswer<ONE_AXIS>,
    pendulum: &PlanarAnswer<ONE_AXIS>,
) -> StiffnessRegression {
    let (mut normal, mut right, mut used) = (Matrix2::zeros(), Vector2::zeros(), 0);
    for level in levels {
        let axial_m_s2 = level.axial_n / (hub.mass_kg + spring.estimate.theta[0]);
        let part = record.part(level.from, level.until);
        let Some((stiffness, sigma)) = level_stiffness(&part, hub, axial_m_s2, spring, pendulum) else { continue };
        let row = Vector2::new(1.0, axial_m_s2);
        normal += row * row.transpose() / (sigma * sigma);
        right += row * (stiffness / (sigma * sigma));
        used += 1;
    }
    let Some(covariance) = normal.try_inverse().filter(|_| used >= 2) else {
        return StiffnessRegression { levels: used, ..StiffnessRegression::default() };
    };
    let solved = covariance * right;
    StiffnessRegression {
        offset_n_m: solved[0],
        offset_sigma: libm::sqrt(covariance[(0, 0)]),
        slope_kg_m: solved[1],
        slope_sigma: libm::sqrt(covariance[(1, 1)]),
        levels: used,
    }
}

/// Stiffness of one level and its standard deviation, from the better of two starts: what either
/// joint fit says of it.
fn level_stiffness(
    level: &PlanarRecord<'_>,
    hub: &PlanarHub,
    axial_m_s2: f64,
    spring: &PlanarAnswer<ONE_AXIS>,
    pendulum: &PlanarAnswer<ONE_AXIS>,
) -> Option<(f64, f64)> {
    let craft = |theta: &SVector<f64, LEVEL_UNKNOWNS>| {
        let craft = lateral_spring(*hub, &theta.fixed_rows::<ONE_AXIS>(0).into_owned())?;
        let start = PlanarState {
            rate_rad_s: theta[5],
            place: [Vector2::new(theta[6], 0.0)],
            speed: [Vector2::new(theta[7], 0.0)],
        };
        Some(PlanarCraft { start, ..craft })
    };
    let hung = &pendulum.estimate.theta;
    // The mass hangs a rod's length behind its pivot.
    let as_spring = [hung[0], hung[0] * axial_m_s2 / hung[1], hung[2], hung[3] - hung[1], hung[4]];
    let starts = [SVector::<f64, ONE_AXIS>::from(as_spring), spring.estimate.theta];
    let scale = SVector::<f64, LEVEL_UNKNOWNS>::from([10.0, 0.3, 0.1, 0.3, 0.3, 1e-4, 0.03, 0.01]);
    let fits = starts.iter().filter_map(|five| {
        let mut start = SVector::<f64, LEVEL_UNKNOWNS>::zeros();
        start.fixed_rows_mut::<ONE_AXIS>(0).copy_from(five);
        fit(level, &craft, &start, &scale).ok()
    });
    let best = fits.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))?;
    Some((best.theta[1], best.sigmas()[1]))
}
