//! Nonlinear least squares by Levenberg–Marquardt (Marquardt 1963).
//!
//! A step solves `(H + λ diag H) δ = g`, with `H = Jᵀ W J` (n × n) and `g = Jᵀ W r` (n). It is
//! taken where χ² falls, and λ falls with it; λ rises where it does not. Length and end are free of
//! units: `√(g' H⁻¹ g)`, in standard deviations of the estimate.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector};

/// Factor of λ at each step that is taken, and its inverse at each that is not.
const DAMPING_FACTOR: f64 = 0.1;

/// χ² and its quadratic model at a point: `χ²(δ) ≈ χ² − 2 g'δ + δ'H δ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadratic<D: Dim>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    pub chi_square: f64,
    /// `H = Jᵀ W J`.
    pub information: OMatrix<f64, D, D>,
    /// `g = Jᵀ W r`, half the steepest descent of χ².
    pub gradient: OVector<f64, D>,
}

impl<D: Dim> Quadratic<D>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    /// `(H + λ diag H)⁻¹ g` in units that make the diagonal of `H` one, so that no unit of an
    /// unknown matters; `None` where `H` is singular.
    pub fn step(&self, damping: f64) -> Option<OVector<f64, D>> {
        let scale = self.information.diagonal().map(|value| 1.0 / libm::sqrt(value));
        let mut scaled = self.information.clone_owned();
        for j in 0..scaled.ncols() {
            for i in 0..scaled.nrows() {
                scaled[(i, j)] = scale[i] * scaled[(i, j)] * scale[j];
            }
            scaled[(j, j)] += damping;
        }
        Some(scaled.cholesky()?.solve(&self.gradient.component_mul(&scale)).component_mul(&scale))
    }
}

/// `(H + λ diag H)⁻¹ g`; `None` where `H` is singular. For unknowns in units of their own standard
/// deviations, others by [`Quadratic::step`]: a fit that starts far from any minimum follows the
/// rounding of its steps, and scaling them again would move its answers.
pub fn damped_step<D: Dim>(
    mut information: OMatrix<f64, D, D>,
    gradient: &OVector<f64, D>,
    damping: f64,
) -> Option<OVector<f64, D>>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    for i in 0..information.ncols() {
        information[(i, i)] *= 1.0 + damping;
    }
    Some(information.cholesky()?.solve(gradient))
}

/// λ from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    value: f64,
    /// Taken where a step fails at λ = 0.
    first: f64,
    /// Below this λ is zero.
    least: f64,
}

impl Damping {
    /// From the first step on: steps that are taken or left as they are.
    pub const fn always() -> Self {
        Self { value: 1e-3, first: 1e-3, least: 0.0 }
    }

    /// Once a Gauss–Newton step fails, and for a few steps then: steps that a search along their
    /// line shortens.
    pub const fn on_failure() -> Self {
        Self { value: 0.0, first: 1e-2, least: 1e-4 }
    }

    /// λ.
    pub const fn value(&self) -> f64 {
        self.value
    }

    /// The step was taken.
    pub fn taken(&mut self) {
        self.value *= DAMPING_FACTOR;
        if self.value < self.least {
            self.value = 0.0;
        }
    }

    /// χ² did not fall along the step.
    pub fn failed(&mut self) {
        self.value = if self.value == 0.0 { self.first } else { self.value * (1.0 / DAMPING_FACTOR) };
    }
}

/// When [`minimise`] ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bound of the steps, those that are not taken among them.
    pub iterations_max: u32,
    /// Converged where the undamped step is no longer than this [standard deviations].
    pub step_sigmas: f64,
    /// Share of χ² below which a decrease that is still to come is not worth a step.
    pub gain_share: f64,
    /// Length [standard deviations] below which a step that fails, at less than this λ, shows that
    /// rounding of χ² or of its derivatives decides: converged.
    pub rounding: (f64, f64),
    /// λ from which no step is worth a trial.
    pub damping_max: f64,
}

/// Why [`minimise`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Converged,
    /// Out of iterations, or of damping.
    Exhausted,
    /// Some combination of the unknowns leaves no trace in the data.
    Singular,
}

/// Where [`minimise`] ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum<D: Dim, P>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    pub point: P,
    pub quadratic: Quadratic<D>,
    pub iterations: u32,
    /// Length of the last undamped step [standard deviations].
    pub step_sigmas: f64,
    pub end: End,
}

/// The minimum of χ² next to a point. `moved(point, step, below)` is the point a step away with its
/// quadratic model, or `None` where that is impossible or its χ² not less than `below`.
///
/// Cost: two factorisations, O(n³), and one call of `moved` an iteration; no allocation where `D`
/// is constant. It finds the nearest minimum: a function with many needs a start in the right one.
pub fn minimise<D: Dim, P>(
    (mut point, mut here): (P, Quadratic<D>),
    settings: &Settings,
    mut moved: impl FnMut(&P, &OVector<f64, D>, f64) -> Option<(P, Quadratic<D>)>,
) -> Minimum<D, P>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    let (mut damping, mut step_sigmas, mut iterations) = (Damping::always(), f64::INFINITY, 0);
    let end = loop {
        if iterations >= settings.iterations_max || damping.value() > settings.damping_max {
            break End::Exhausted;
        }
        let Some(full) = here.step(0.0) else { break End::Singular };
        step_sigmas = libm::sqrt(full.dot(&here.gradient));
        let is_small = step_sigmas * step_sigmas <= settings.gain_share * here.chi_square;
        if step_sigmas <= settings.step_sigmas || is_small {
            break End::Converged;
        }
        let Some(step) = here.step(damping.value()) else { break End::Singular };
        // χ² that is not finite compares as worse
        match moved(&point, &step, here.chi_square).filter(|(_, there)| there.chi_square < here.chi_square) {
            Some(better) => {
                (point, here) = better;
                damping.taken();
            }
            None if step_sigmas < settings.rounding.0 && damping.value() < settings.rounding.1 => break End::Converged,
            None => damping.failed(),
        }
        iterations += 1;
    };
    Minimum { point, quadratic: here, iterations, step_sigmas, end }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Const, Matrix2, Vector2};

    const SETTINGS: Settings = Settings {
        iterations_max: 100,
        step_sigmas: 1e-9,
        gain_share: 0.0,
        rounding: (1e-3, 1e-6),
        damping_max: f64::INFINITY,
    };

    /// Rosenbrock's valley: residuals `10 (y − x²)`, `1 − x`; minimum at (1, 1).
    fn valley(at: &Vector2<f64>) -> Quadratic<Const<2>> {
        let residual = Vector2::new(10.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]);
        let jacobian = Matrix2::new(20.0 * at[0], -10.0, 1.0, 0.0); // of what is predicted
        let (information, gradient) = (jacobian.transpose() * jacobian, jacobian.transpose() * residual);
        Quadratic { chi_square: residual.norm_squared(), information, gradient }
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end_and_no_step_climbs() {
        let start = Vector2::new(-1.2, 1.0);
        let mut last = valley(&start).chi_square;
        let found = minimise((start, valley(&start)), &SETTINGS, |at, step, below| {
            assert!(below <= last);
            last = below;
            Some((at + step, valley(&(at + step))))
        });
        assert_eq!(found.end, End::Converged);
        // 1e-9 of a standard deviation of (1, 1)
        assert!((found.point - Vector2::new(1.0, 1.0)).norm() < 1e-8, "{found:?}");
    }

    #[test]
    fn the_step_is_the_same_in_any_units_and_shortens_as_damping_grows() {
        let here = valley(&Vector2::new(-1.2, 1.0));
        let units = Matrix2::new(1e6, 0.0, 0.0, 1e-5);
        let scaled = Quadratic::<Const<2>> {
            chi_square: here.chi_square,
            information: units * here.information * units,
            gradient: units * here.gradient,
        };
        for damping in [0.0, 1e-3, 1.0] {
            let (own, other) = (here.step(damping).unwrap(), units * scaled.step(damping).unwrap());
            assert!((own - other).norm() < 1e-12 * own.norm()); // rounding, condition 24²
        }
        let long = |damping: f64| here.step(damping).unwrap().norm();
        assert!(long(1e-3) < long(0.0) && long(10.0) < 0.2 * long(0.0));
    }

    #[test]
    fn unknowns_without_a_trace_end_it_as_singular() {
        let flat = |x: f64| Quadratic::<Const<2>> {
            chi_square: x * x,
            information: Matrix2::new(1.0, 0.0, 0.0, 0.0),
            gradient: Vector2::new(-x, 0.0),
        };
        let found = minimise((1.0, flat(1.0)), &SETTINGS, |x, step, _| Some((x + step[0], flat(x + step[0]))));
        assert_eq!((found.end, found.point), (End::Singular, 1.0));
    }

    #[test]
    fn steps_that_never_help_are_damped_until_none_is_worth_a_trial() {
        let here = valley(&Vector2::new(-1.2, 1.0));
        let mut trials = 0;
        let found = minimise(((), here), &Settings { damping_max: 1e3, ..SETTINGS }, |(), _, _| {
            trials += 1;
            None
        });
        assert_eq!((found.end, found.iterations, trials), (End::Exhausted, 7, 7)); // λ = 1e-3 … 1e3
    }
}
