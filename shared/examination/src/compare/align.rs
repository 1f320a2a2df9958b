//! The four simple explanations, each alone: a lag, a gain, a sign, an offset.

use super::Pair;
use crate::spectrum::correlation;
use identification::statistics::{correlation_length, least_squares, normal_two_sided, rms};

/// One explanation.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    pub value: f64,
    pub sigma: f64,
    /// Distance of `value` from doing nothing, in sigma.
    pub z: f64,
    /// What the explanation leaves.
    pub residual: Vec<f64>,
}

impl Correction {
    /// Whether four explanations tried would reach this by chance with probability below `p`.
    #[must_use]
    pub fn significant(&self, p: f64) -> bool {
        self.z.abs() > normal_two_sided(p / 4.0)
    }
}

/// The four corrections that may explain a difference, each fitted on its own.
pub struct Corrections {
    pub lag: Correction,
    pub scale: Correction,
    pub sign: Correction,
    pub offset: Correction,
}

pub(super) fn corrections(p: &Pair) -> Corrections {
    let (real, simulated) = (&p.real, &p.simulated);
    let error: Vec<f64> = real.iter().zip(simulated).map(|(y, s)| y - s).collect();
    let turned: Vec<f64> = real.iter().zip(simulated).map(|(y, s)| y + s).collect();
    let better = rms(&turned) < rms(&error);
    let z = if better { f64::INFINITY } else { 0.0 };
    Corrections {
        lag: lag(p),
        scale: regress(core::slice::from_ref(simulated), real, 1.0),
        sign: Correction { value: if better { -1.0 } else { 1.0 }, sigma: 0.0, z, residual: turned },
        offset: regress(&[vec![1.0; real.len()]], &error, 0.0),
    }
}

/// Newey–West over twice the residual's own memory.
fn regress(columns: &[Vec<f64>], target: &[f64], nothing: f64) -> Correction {
    let none = || Correction { value: nothing, sigma: f64::INFINITY, z: 0.0, residual: target.to_vec() };
    let Some(first) = least_squares(columns, target, 0) else { return none() };
    if first.rank == 0 {
        return none();
    }
    let memory = (2.0 * correlation_length(&first.residual)).min(target.len() as f64 / 6.0) as usize;
    let fit = least_squares(columns, target, memory).unwrap_or(first);
    let (value, sigma) = (fit.coefficients[0], fit.sigma[0]);
    Correction {
        value,
        sigma,
        z: (value - nothing) / sigma.max(1e-12 * value.abs()).max(1e-300),
        residual: fit.residual,
    }
}

/// `real(t) ≈ simulated(t - lag)`: the peak of the correlation nearest to zero, then Gauss–Newton
/// at fractions of a sample.
fn lag(p: &Pair) -> Correction {
    let n = p.real.len();
    let shift_max = n / 4;
    let rho = correlation(&p.simulated, &p.real, shift_max);
    let peak = rho.iter().fold(0.0_f64, |m, r| m.max(*r));
    let top = |k: usize| {
        rho[k] >= 0.97 * peak && (k == 0 || rho[k] >= rho[k - 1]) && (k + 1 == rho.len() || rho[k] >= rho[k + 1])
    };
    let start = (0..rho.len()).filter(|&k| top(k)).min_by_key(|k| k.abs_diff(shift_max)).unwrap_or(shift_max);
    let mut lag = start as f64 - shift_max as f64;
    let read = |lag: f64| p.time_s.iter().map(|t| p.simulation.at(t - lag * p.dt_s)).collect::<Vec<f64>>();
    let mut step = Correction { value: 0.0, sigma: f64::INFINITY, z: 0.0, residual: Vec::new() };
    for _ in 0..20 {
        let shifted = read(lag);
        let slope: Vec<f64> = read(lag + 0.5).iter().zip(read(lag - 0.5)).map(|(early, late)| early - late).collect();
        let error: Vec<f64> = p.real.iter().zip(&shifted).map(|(y, s)| y - s).collect();
        step = regress(&[slope], &error, 0.0);
        let change = step.value.clamp(-2.0, 2.0);
        lag += change;
        if change.abs() < 1e-6 {
            break;
        }
    }
    let lag = lag.clamp(-(shift_max as f64), shift_max as f64);
    // Samples that have no partner once shifted, and the two at each end that are interpolated
    // linearly, are left out.
    let shifted = read(lag);
    let (from, to) = (2 + libm::ceil(lag.max(0.0)) as usize, n - 2 - libm::ceil((-lag).max(0.0)) as usize);
    let residual: Vec<f64> = (from..to.max(from + 1)).map(|i| p.real[i] - shifted[i]).collect();
    let sigma = step.sigma.max(1e-9);
    Correction { value: lag * p.dt_s, sigma: step.sigma * p.dt_s, z: lag / sigma, residual }
}
