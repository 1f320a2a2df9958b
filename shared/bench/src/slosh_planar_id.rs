//! Slosh in the plane from the record alone: modes from the gyro, a coarse search with the
//! stiffness tied to them, maximum likelihood from several starts, and χ² as the judge.
//!
//! Started from modes 10 % off, the likelihood locks into wrong minima nearly always; with the
//! modes right within 1 % the other numbers may be a third off.

use nalgebra::{SVector, Vector2};

use crate::slosh_planar::{PlanarHub, PlanarSlosh, Suspension, stiffness_from_modes};
use crate::slosh_planar_fit::{PlanarCraft, PlanarEstimate, chi_square, fit};
use crate::slosh_planar_record::{PlanarError, PlanarRecord, PlanarThrust};
use crate::slosh_planar_scan::{PlanarSample, scan_modes};

/// `[ms, kx, ky, cx, cy, bx, by]`.
pub const SPRINGS: usize = 7;
/// `[ms, k, c, bx, by]` of a spring across the thrust; `[ms, L, D, dx, dy]` of a pendulum.
pub const ONE_AXIS: usize = 5;

/// Masses of the coarse search, parts of the hub's.
const MASS_SHARES: [f64; 5] = [0.01, 0.02, 0.04, 0.08, 0.16];
/// Places of the coarse search along x and y, parts of the greatest that is possible.
const PLACES: [f64; 7] = [-0.9, -0.6, -0.3, 0.05, 0.3, 0.6, 0.9];
/// Damping ratio of the coarse search.
const DAMPING_RATIO: f64 = 0.01;
/// Starts that are followed to their minimum.
pub const STARTS_MAX: usize = 8;
/// Driven samples of the coarse search: half a dozen periods tell a place.
const COARSE_SAMPLES: usize = 900;
/// χ² further than this from what it should be, in its standard deviations, is a wrong minimum or a
/// wrong model.
pub const GATE_Z: f64 = 5.0;

/// Where to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarSearch {
    pub band_hz: [f64; 2],
    /// Greatest distance of the tank from the hub's centre of mass, along either axis.
    pub reach_m: f64,
    /// Starts that are followed, at most [`STARTS_MAX`].
    pub starts: usize,
}

/// The best minimum that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarAnswer<const N: usize> {
    pub estimate: PlanarEstimate<N>,
    /// χ² within [`GATE_Z`]: the model explains the record.
    pub is_explained: bool,
    /// Starts followed until then.
    pub starts: usize,
}

/// A slosh mass on springs along x and y.
pub fn springs(hub: PlanarHub, theta: &SVector<f64, SPRINGS>) -> Option<PlanarCraft<1>> {
    let suspension = Suspension::Springs {
        position_m: Vector2::new(theta[5], theta[6]),
        stiffness_n_m: Vector2::new(theta[1], theta[2]),
        damping_n_s_m: Vector2::new(theta[3], theta[4]),
    };
    let masses = [PlanarSlosh { mass_kg: theta[0], suspension }];
    let exists = theta[0] > 0.0 && theta[1] > 0.0 && theta[2] > 0.0;
    exists.then(|| PlanarCraft::at_rest(hub, masses))
}

/// A slosh mass on a spring across the thrust, along y.
pub fn lateral_spring(hub: PlanarHub, theta: &SVector<f64, ONE_AXIS>) -> Option<PlanarCraft<1>> {
    let suspension = Suspension::Rail {
        position_m: Vector2::new(theta[3], theta[4]),
        direction: Vector2::y(),
        stiffness_n_m: theta[1],
        damping_n_s_m: theta[2],
    };
    let masses = [PlanarSlosh { mass_kg: theta[0], suspension }];
    (theta[0] > 0.0 && theta[1] > 0.0).then(|| PlanarCraft::at_rest(hub, masses))
}

/// A pendulum that hangs along −x under thrust along +x.
pub fn pendulum(hub: PlanarHub, theta: &SVector<f64, ONE_AXIS>) -> Option<PlanarCraft<1>> {
    let suspension =
        Suspension::Pendulum { pivot_m: Vector2::new(theta[3], theta[4]), length_m: theta[1], damping_n_s_m: theta[2] };
    let masses = [PlanarSlosh { mass_kg: theta[0], suspension }];
    (theta[0] > 0.0 && theta[1] > 0.0).then(|| PlanarCraft::at_rest(hub, masses))
}

fn squared(hertz: f64) -> f64 {
    let omega = 2.0 * core::f64::consts::PI * hertz;
    omega * omega
}

/// All seven numbers of a slosh mass on two springs, at rest at the beginning, under thrusters that
/// do as stated. Cost: some 2000 walks of the record.
///
/// # Errors
/// [`PlanarError::DelayedSums`] for late thrusters and sums of samples; [`PlanarError`] when no
/// start could be followed.
pub fn identify_springs(
    record: &PlanarRecord<'_>,
    hub: PlanarHub,
    thrust: PlanarThrust,
    search: &PlanarSearch,
) -> Result<PlanarAnswer<SPRINGS>, PlanarError> {
    thrust.check(record)?;
    let modes = scan_modes(record.samples, record.interval_s, search.band_hz).frequency_hz.map(squared);
    let craft = |theta: &SVector<f64, SPRINGS>| springs(hub, theta).map(|craft| PlanarCraft { thrust, ..craft });
    let mut starts = Best::new();
    let coarse = beginning(record);
    for_each_place(&hub, search, |mass_kg, position_m| {
        for stiffness in stiffness_from_modes(&hub, mass_kg, &position_m, modes).into_iter().flatten() {
            let damping = stiffness.map(|k| 2.0 * DAMPING_RATIO * libm::sqrt(k * mass_kg));
            let theta = SVector::<f64, SPRINGS>::from([
                mass_kg,
                stiffness[0],
                stiffness[1],
                damping[0],
                damping[1],
                position_m[0],
                position_m[1],
            ]);
            if let Some(value) = chi_square(&coarse, &craft, &theta) {
                starts.offer(value, theta);
            }
        }
    });
    follow(record, &craft, &starts, search)
}

/// Five numbers of a slosh mass on one axis, `craft` either [`lateral_spring`] or [`pendulum`] of
/// the hub, whose second number is `second(mass, place, λ)` for a mode of λ = ω² at the beginning
/// of the record.
///
/// # Errors
/// [`PlanarError`] when no start could be followed.
pub fn identify_one_axis(
    record: &PlanarRecord<'_>,
    hub: &PlanarHub,
    search: &PlanarSearch,
    mode_hz: f64,
    craft: &impl Fn(&SVector<f64, ONE_AXIS>) -> Option<PlanarCraft<1>>,
    second: &impl Fn(f64, &Vector2<f64>, f64) -> f64,
) -> Result<PlanarAnswer<ONE_AXIS>, PlanarError> {
    let lambda = squared(mode_hz);
    let mut starts = Best::new();
    let coarse = beginning(record);
    for_each_place(hub, search, |mass_kg, place_m| {
        // Across the thrust the place is found, not tried: a few centimetres turn the craft more
        // than all the rest.
        if place_m[1] != PLACES[0] * search.reach_m {
            return;
        }
        let damping = 4.0 * DAMPING_RATIO * libm::sqrt(lambda) * mass_kg;
        let at = |y: f64| {
            let place_m = Vector2::new(place_m[0], y);
            let number = second(mass_kg, &place_m, lambda);
            SVector::<f64, ONE_AXIS>::from([mass_kg, number, damping, place_m[0], y])
        };
        let y = lowest(|y| chi_square(&coarse, craft, &at(y)), search.reach_m);
        if let Some(value) = chi_square(&coarse, craft, &at(y)) {
            starts.offer(value, at(y));
        }
    });
    follow(record, craft, &starts, search)
}

/// Where a nearly quadratic function is lowest within `reach` of zero, by parabolas over a third, a
/// thirtieth and a three hundredth of the reach.
fn lowest(value: impl Fn(f64) -> Option<f64>, reach: f64) -> f64 {
    let mut best = 0.0;
    for step in [0.3 * reach, 0.03 * reach, 0.003 * reach] {
        let [Some(below), Some(here), Some(above)] = [best - step, best, best + step].map(&value) else { break };
        let (slope, curvature) = (above - below, above - 2.0 * here + below);
        if curvature > 0.0 {
            best = (best - 0.5 * step * slope / curvature).clamp(-reach, reach);
        }
    }
    best
}

/// The record from its begin to [`COARSE_SAMPLES`] behind the first thrust: a craft at rest tells
/// nothing.
fn beginning<'a>(record: &PlanarRecord<'a>) -> PlanarRecord<'a> {
    let is_driven = |sample: &PlanarSample| sample.wrench.force_n.amax() > 0.0 || sample.wrench.torque_n_m != 0.0;
    let first = record.samples.iter().position(is_driven).unwrap_or(0);
    record.part(0, record.samples.len().min(first + COARSE_SAMPLES))
}

pub(crate) fn for_each_place(hub: &PlanarHub, search: &PlanarSearch, mut visit: impl FnMut(f64, Vector2<f64>)) {
    for share in MASS_SHARES {
        for x in PLACES {
            for y in PLACES {
                visit(share * hub.mass_kg, Vector2::new(x, y) * search.reach_m);
            }
        }
    }
}

/// Follows the starts to their minima until one explains the record; the best of them otherwise.
fn follow<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    starts: &Best<N>,
    search: &PlanarSearch,
) -> Result<PlanarAnswer<N>, PlanarError> {
    let mut best: Result<PlanarAnswer<N>, PlanarError> = Err(PlanarError::NotObserved);
    for (count, start) in starts.found().take(search.starts).enumerate() {
        // Places may be zero; what is small against the rest is no place.
        let scale = start.map(|value| if value == 0.0 { 0.3 * search.reach_m } else { value.abs() });
        match fit(record, craft, start, &scale) {
            Ok(estimate) => {
                let is_explained = estimate.is_converged && estimate.z_score().abs() < GATE_Z;
                let is_better = best.as_ref().is_ok_and(|best| estimate.chi_square < best.estimate.chi_square);
                if best.is_err() || is_better {
                    best = Ok(PlanarAnswer { estimate, is_explained, starts: count + 1 });
                }
                if is_explained {
                    break;
                }
            }
            Err(error) if best.is_err() => best = Err(error),
            Err(_) => {}
        }
    }
    best
}

/// The best few starts, best first.
pub(crate) struct Best<const N: usize> {
    kept: [(f64, SVector<f64, N>); STARTS_MAX],
}

impl<const N: usize> Best<N> {
    pub(crate) fn new() -> Self {
        Self { kept: [(f64::INFINITY, SVector::zeros()); STARTS_MAX] }
    }

    /// Best first.
    pub(crate) fn found(&self) -> impl Iterator<Item = &SVector<f64, N>> {
        self.kept.iter().filter(|(value, _)| value.is_finite()).map(|(_, theta)| theta)
    }

    pub(crate) fn offer(&mut self, value: f64, theta: SVector<f64, N>) {
        if value < self.kept[STARTS_MAX - 1].0 {
            self.kept[STARTS_MAX - 1] = (value, theta);
            self.kept.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
}

#[cfg(test)]
mod tests;
