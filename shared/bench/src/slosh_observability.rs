//! What a formulation of the slosh problem leaves without a trace: "observability issues" by name.
//!
//! In absolute coordinates, `[x0, xs, v0, vs, ms, ks, cs]`, an accelerometer sees `xs − x0` and
//! `vs − v0` only: a shift of both masses and a velocity of both leave no trace, and a filter lets
//! them walk until it breaks. The information of the planned record says so, whatever the filter:
//! `I = Σ h h'/σ²`, scaled to a unit diagonal, its eigenvectors of nearly no value. Velocity fixes
//! remove one direction, position fixes both; the relative form `[r, ṙ, ms, ks, cs]` has none.

use nalgebra::{SMatrix, SVector};

use physics::slosh_arc::{SloshArc, SloshSample};
use physics::slosh_likelihood::{SloshHypothesis, Walk};
use physics::slosh_plan::PlannedStep;

/// `[x0, xs, v0, vs, ms, ks, cs]`.
pub const ABSOLUTE: usize = 7;
/// `[r, ṙ, ms, ks, cs]`.
pub const RELATIVE: usize = 5;
/// Names of the absolute form.
pub const ABSOLUTE_NAMES: [&str; ABSOLUTE] = ["x0", "xs", "v0", "vs", "ms", "ks", "cs"];

/// Eigenvalue of the scaled information below which a direction has no trace: rounding leaves
/// 1e-16, the weakest that was ever seen in a useful experiment is 1e-7.
const NO_TRACE: f64 = 1e-11;

/// Sensors beside the accelerometer: standard deviations of fixes at every sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixes {
    pub velocity_m_s: Option<f64>,
    pub position_m: Option<f64>,
}

/// A formulation whose every direction leaves a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observable<const X: usize> {
    /// Standard deviation each number should reach (Cramér–Rao).
    pub sigmas: SVector<f64, X>,
    /// Largest over smallest singular value of the scaled sensitivities.
    pub condition: f64,
}

/// Refused: `nullity` directions leave no trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unobservable<const X: usize> {
    pub nullity: usize,
    /// The first `nullity` columns span what cannot be seen, in reduced echelon form.
    pub directions: SMatrix<f64, X, X>,
}

/// The absolute form under held forces.
///
/// # Errors
/// [`Unobservable`] with the directions that leave no trace.
#[expect(clippy::result_large_err, reason = "the refused directions stand in fixed memory: nothing is allocated")]
pub fn absolute(
    hypothesis: &SloshHypothesis,
    base_mass_kg: f64,
    step: PlannedStep,
    fixes: Fixes,
    forces_n: impl Iterator<Item = f64>,
) -> Result<Observable<ABSOLUTE>, Unobservable<ABSOLUTE>> {
    let mut information = SMatrix::<f64, ABSOLUTE, ABSOLUTE>::zeros();
    let mut add = |row: &SVector<f64, ABSOLUTE>, sigma: f64| information += row * row.transpose() / (sigma * sigma);
    let (mut velocity, mut position) = (SVector::<f64, ABSOLUTE>::zeros(), SVector::<f64, ABSOLUTE>::zeros());
    (velocity[2], position[0]) = (1.0, 1.0);
    for_each_sensitivity(hypothesis, base_mass_kg, step, forces_n, |[m, k, c, r, v]| {
        let row = SVector::<f64, ABSOLUTE>::from([-r, r, -v, v, m, k, c]);
        position += (velocity + row / 2.0) * step.interval_s;
        velocity += row;
        add(&row, step.sigma_m_s2 * step.interval_s);
        if let Some(sigma) = fixes.velocity_m_s {
            add(&velocity, sigma);
        }
        if let Some(sigma) = fixes.position_m {
            add(&position, sigma);
        }
    });
    verdict(&information)
}

/// The relative form under held forces.
///
/// # Errors
/// [`Unobservable`] with the directions that leave no trace: a craft that is not pushed.
#[expect(clippy::result_large_err, reason = "the refused directions stand in fixed memory: nothing is allocated")]
pub fn relative(
    hypothesis: &SloshHypothesis,
    base_mass_kg: f64,
    step: PlannedStep,
    forces_n: impl Iterator<Item = f64>,
) -> Result<Observable<RELATIVE>, Unobservable<RELATIVE>> {
    let mut information = SMatrix::<f64, RELATIVE, RELATIVE>::zeros();
    let sigma = step.sigma_m_s2 * step.interval_s;
    for_each_sensitivity(hypothesis, base_mass_kg, step, forces_n, |[m, k, c, r, v]| {
        let row = SVector::<f64, RELATIVE>::from([r, v, m, k, c]);
        information += row * row.transpose() / (sigma * sigma);
    });
    verdict(&information)
}

/// Derivatives of each sample's Δv by `[ms, ks, cs, r0, ṙ0]`.
fn for_each_sensitivity(
    hypothesis: &SloshHypothesis,
    base_mass_kg: f64,
    step: PlannedStep,
    forces_n: impl Iterator<Item = f64>,
    mut visit: impl FnMut([f64; 5]),
) {
    let mut walk = Walk::new(base_mass_kg, hypothesis, step.interval_s);
    for force_n in forces_n {
        // An arc of one sample, for its block.
        let mut arc = SloshArc::<4>::default();
        let sample = SloshSample { interval_s: step.interval_s, force_n, acceleration_m_s2: 0.0, sigma_m_s2: 1.0 };
        if arc.push(&sample).is_err() {
            return;
        }
        for block in arc.blocks() {
            let (_, by) = walk.step(&block);
            visit([by[0], by[1], by[2], by[3], by[4]]);
        }
    }
}

fn verdict<const X: usize>(information: &SMatrix<f64, X, X>) -> Result<Observable<X>, Unobservable<X>> {
    let unit = information.diagonal().map(|value| if value > 0.0 { 1.0 / libm::sqrt(value) } else { 0.0 });
    let scaling = SMatrix::<f64, X, X>::from_diagonal(&unit);
    let (values, vectors) = eigen(scaling * information * scaling);
    let (least, greatest) = (values.min(), values.max());
    if greatest > 0.0 && least > NO_TRACE * greatest {
        let inverse = SMatrix::<f64, X, X>::from_diagonal(&values.map(|value| 1.0 / value));
        let covariance = scaling * vectors * inverse * vectors.transpose() * scaling;
        return Ok(Observable {
            sigmas: covariance.diagonal().map(libm::sqrt),
            condition: libm::sqrt(greatest / least),
        });
    }
    let mut directions = SMatrix::<f64, X, X>::zeros();
    let mut nullity = 0;
    // A number without any trace is a direction of its own.
    for i in (0..X).filter(|i| unit[*i] == 0.0) {
        directions[(i, nullity)] = 1.0;
        nullity += 1;
    }
    for i in (0..X).filter(|i| values[*i] <= NO_TRACE * greatest) {
        let direction = scaling * vectors.column(i);
        if direction.amax() > 0.0 {
            directions.set_column(nullity, &(direction / direction.amax()));
            nullity += 1;
        }
    }
    reduce(&mut directions, nullity);
    Err(Unobservable { nullity, directions })
}

/// Reduced echelon form of the first columns; what is rounding becomes zero.
fn reduce<const X: usize>(directions: &mut SMatrix<f64, X, X>, nullity: usize) {
    let mut done = 0;
    for row in 0..X {
        let Some(pivot) = (done..nullity)
            .max_by(|a, b| directions[(row, *a)].abs().total_cmp(&directions[(row, *b)].abs()))
            .filter(|pivot| directions[(row, *pivot)].abs() > 1e-3)
        else {
            continue;
        };
        directions.swap_columns(done, pivot);
        let column = directions.column(done) / directions[(row, done)];
        directions.set_column(done, &column);
        for other in (0..nullity).filter(|other| *other != done) {
            let cleared = directions.column(other) - column * directions[(row, other)];
            directions.set_column(other, &cleared);
        }
        done += 1;
    }
    directions.apply(|value| {
        if value.abs() < 1e-3 {
            *value = 0.0;
        }
    });
}

/// Eigenvalues and eigenvectors of a symmetric matrix by Jacobi's rotations.
fn eigen<const X: usize>(mut a: SMatrix<f64, X, X>) -> (SVector<f64, X>, SMatrix<f64, X, X>) {
    const SWEEPS: usize = 30;
    let mut v = SMatrix::<f64, X, X>::identity();
    for _ in 0..SWEEPS {
        for p in 0..X {
            for q in p + 1..X {
                if a[(p, q)].abs() < 1e-300 {
                    continue;
                }
                let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
                let t = theta.signum() / (theta.abs() + libm::sqrt(theta * theta + 1.0));
                let c = 1.0 / libm::sqrt(t * t + 1.0);
                let s = t * c;
                let mut rotation = SMatrix::<f64, X, X>::identity();
                (rotation[(p, p)], rotation[(q, q)], rotation[(p, q)], rotation[(q, p)]) = (c, c, s, -s);
                a = rotation.transpose() * a * rotation;
                v *= rotation;
            }
        }
    }
    (a.diagonal(), v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark_tank::{BASE_MASS_KG, TANK};

    const STEP: PlannedStep = PlannedStep { interval_s: 1.0, sigma_m_s2: 0.008 / 60.0 };

    fn at() -> SloshHypothesis {
        SloshHypothesis { parameters: TANK, ..SloshHypothesis::default() }
    }

    fn sine() -> impl Iterator<Item = f64> {
        (0..1000).map(|k| 44.0 * libm::sin(2.0 * core::f64::consts::PI * 0.01 * (f64::from(k) + 0.5)))
    }

    #[test]
    fn an_accelerometer_sees_neither_where_the_craft_is_nor_how_fast() {
        let refused = absolute(&at(), BASE_MASS_KG, STEP, Fixes::default(), sine()).expect_err("two directions");
        assert_eq!(refused.nullity, 2);
        let expected = [[1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]];
        for (column, expected) in expected.iter().enumerate() {
            for (row, value) in expected.iter().enumerate() {
                assert!((refused.directions[(row, column)] - value).abs() < 1e-3, "{}", refused.directions);
            }
        }
    }

    #[test]
    fn velocity_fixes_leave_the_common_shift_and_position_fixes_nothing() {
        let velocity = Fixes { velocity_m_s: Some(0.005), position_m: None };
        let refused = absolute(&at(), BASE_MASS_KG, STEP, velocity, sine()).expect_err("one direction");
        assert_eq!(refused.nullity, 1);
        assert!((refused.directions[(0, 0)] - 1.0).abs() < 1e-3 && (refused.directions[(1, 0)] - 1.0).abs() < 1e-3);
        let position = Fixes { velocity_m_s: Some(0.005), position_m: Some(0.5) };
        assert!(absolute(&at(), BASE_MASS_KG, STEP, position, sine()).is_ok());
    }

    #[test]
    fn the_relative_form_sees_everything_and_promises_what_the_bound_says() {
        let seen = relative(&at(), BASE_MASS_KG, STEP, sine()).expect("rank 5");
        // With r0 and ṙ0 unknown c_s reaches 1.43 % (benchmark page 2, section 1.1).
        assert!((100.0 * seen.sigmas[4] / TANK.damping_n_s_m / 1.43 - 1.0).abs() < 0.02, "{}", seen.sigmas);
    }

    #[test]
    fn a_craft_that_is_not_pushed_hides_the_tank() {
        let refused = relative(&at(), BASE_MASS_KG, STEP, core::iter::repeat_n(0.0, 500)).expect_err("nothing moves");
        assert_eq!(refused.nullity, 3);
    }
}
