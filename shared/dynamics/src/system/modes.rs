//! Natural frequencies and damping of the linearised plant.
//!
//! States without influence (a floating base's position, the angle of a free joint) are removed
//! with their exact eigenvalue before the numerical eigenvalue problem, because a defective zero
//! would otherwise scatter by the square root of rounding.

use super::workspace::Workspace;
use super::{StateSpace, System};
use crate::dual::Dual;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// One pole, or a pair of complex ones.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemMode {
    /// |λ| / 2π.
    pub frequency_hz: f64,
    /// −Re λ / |λ|: 1 for a decaying real pole, −1 for a growing one.
    pub damping_ratio: f64,
    /// [1/s]: real part, imaginary part ≥ 0.
    pub pole: [f64; 2],
    /// Share of every state (participation factors, largest first power, sum 1).
    pub participation: Vec<f64>,
    /// State with the largest share.
    pub dominant: usize,
    /// Its name.
    pub label: String,
}

/// All poles.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// By rising frequency.
    pub modes: Vec<SystemMode>,
    /// Poles at zero: rigid-body motions and free integrators.
    pub zeros: usize,
}

/// Iterations of the QR algorithm; two a pole are usual.
const ITERATIONS_MAX: usize = 10_000;

impl System {
    /// Poles of the plant about (`x`, `u`), effects and inputs held.
    pub fn modes(&self, ws: &mut Workspace<Dual>, t_s: f64, x: &[f64], u: &[f64]) -> Modes {
        let a = self.linearise(ws, t_s, x, u).a;
        let (kept, mut poles) = removed_integrators(&a);
        let rest = DMatrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
        let mut modes = Vec::new();
        // bounded: some matrices keep the QR iteration turning
        let bounded = || Schur::try_new(rest.clone(), f64::EPSILON, ITERATIONS_MAX);
        if let Some(schur) = (!kept.is_empty()).then(bounded).flatten() {
            for pole in schur.complex_eigenvalues().iter().filter(|pole| pole.im >= 0.0) {
                modes.push(self.mode(*pole, participation(&rest, *pole), &kept));
            }
        }
        // a quaternion's fourth number is no motion
        let surplus = self.layout.quaternions.len();
        let zeros = poles.iter().filter(|(_, pole)| *pole == 0.0).count().saturating_sub(surplus);
        poles.retain(|(_, pole)| *pole != 0.0);
        for (state, pole) in poles {
            modes.push(self.mode(Complex::new(pole, 0.0), DVector::from_element(1, 1.0), &[state]));
        }
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        Modes { modes, zeros }
    }

    fn mode(&self, pole: Complex<f64>, share: DVector<f64>, kept: &[usize]) -> SystemMode {
        let size = libm::hypot(pole.re, pole.im);
        let mut participation = vec![0.0; self.states().len()];
        for (state, share) in kept.iter().zip(&share) {
            participation[*state] = *share;
        }
        let dominant = kept[share.imax()];
        SystemMode {
            frequency_hz: size / core::f64::consts::TAU,
            damping_ratio: if size > 0.0 { -pole.re / size } else { 0.0 },
            pole: [pole.re, pole.im],
            participation,
            dominant,
            label: self.states()[dominant].name.clone(),
        }
    }
}

impl StateSpace {
    /// Readings of every output in the mode of `pole` (real and imaginary part [1/s]), up to one
    /// complex factor.
    ///
    /// `C v` (outputs), `A v = λ v`: a component is the reading of the sensor, in its own unit,
    /// while only this mode moves. Sensors' own lags, delays and scales are not in it. `pole` is
    /// one of [`System::modes`] of the same system and place, and is simple: of two equal poles any
    /// mixture of both is an answer.
    ///
    /// Cost: one factorisation of A.
    #[must_use]
    pub fn shape(&self, pole: [f64; 2]) -> Vec<Complex<f64>> {
        let v = eigenvector(&self.a, Complex::new(pole[0], pole[1]), false);
        (self.c.map(|c| Complex::new(c, 0.0)) * v).iter().copied().collect()
    }
}

/// States kept, and (state, pole) of those removed: a column of A that is zero off the diagonal has
/// its own pole there.
fn removed_integrators(a: &DMatrix<f64>) -> (Vec<usize>, Vec<(usize, f64)>) {
    let row_size: Vec<f64> = (0..a.nrows()).map(|i| a.row(i).amax()).collect();
    // rounding of the terms that cancel in a rate, which are as large as its largest derivative
    let nothing = |i: usize, j: usize| a[(i, j)].abs() <= 1e-13 * row_size[i];
    let mut kept: Vec<usize> = (0..a.nrows()).collect();
    let mut poles = Vec::new();
    loop {
        let alone = |j: &usize| kept.iter().all(|i| i == j || nothing(*i, *j));
        let Some(at) = kept.iter().position(alone) else { return (kept, poles) };
        let state = kept.remove(at);
        poles.push((state, if nothing(state, state) { 0.0 } else { a[(state, state)] }));
    }
}

/// `|w_k v_k| / Σ`, left and right eigenvectors by inverse iteration beside the pole (Pérez-Arriaga
/// et al. 1982).
fn participation(a: &DMatrix<f64>, pole: Complex<f64>) -> DVector<f64> {
    let (right, left) = (eigenvector(a, pole, false), eigenvector(a, pole, true));
    let size = |z: Complex<f64>| libm::hypot(z.re, z.im);
    let share = DVector::from_fn(a.nrows(), |i, _| size(left[i] * right[i]));
    let sum = share.sum();
    if sum > 0.0 { share / sum } else { share }
}

/// Eigenvector of `a`, or of its transpose, to the simple eigenvalue `pole`, of length 1: inverse
/// iteration.
fn eigenvector(a: &DMatrix<f64>, pole: Complex<f64>, transposed: bool) -> DVector<Complex<f64>> {
    let n = a.nrows();
    let scale = a.amax().max(f64::MIN_POSITIVE);
    // beside the pole, so that the matrix can be factorised
    let beside = pole + Complex::new(1e-10 * scale, 1e-10 * scale);
    let shifted = DMatrix::from_fn(n, n, |i, j| {
        let at = if transposed { a[(j, i)] } else { a[(i, j)] };
        Complex::new(at, 0.0) - if i == j { beside } else { Complex::new(0.0, 0.0) }
    });
    let factor = shifted.lu();
    let mut v = DVector::from_fn(n, |i, _| Complex::new(1.0 + 0.1 * i as f64, 0.3));
    for _ in 0..3 {
        if let Some(next) = factor.solve(&v) {
            let norm = next.norm();
            v = next / Complex::new(norm, 0.0);
        }
    }
    v
}
