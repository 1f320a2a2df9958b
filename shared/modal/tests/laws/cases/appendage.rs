//! Free decay of a hub with one flexible appendage after a one-second torque pulse (BP3A), ten
//! accelerometers along the beam.
//!
//! `M q″ + D q′ + K q = [1 0 0]ᵀ u`, q = [hub angle, beam mode 1, beam mode 2]; the beam is clamped
//! to the hub. Reported modes are the hub-free modes of the system. Written from the equations,
//! independently of any simulator.

use super::TrueMode;
use super::noise::Noise;
use faer::{Mat, c64};

pub const CHANNELS: usize = 10;
pub const SAMPLE_RATE_HZ: f64 = 200.0;
pub const SAMPLES: usize = 800;
/// White acceleration noise of one sample [m/s²].
pub const SIGMA_M_S2: f64 = 3.10e-4;

const HUB_INERTIA_KG_M2: f64 = 66.67;
const ROOT_M: f64 = 0.5;
const LENGTH_M: f64 = 5.0;
const DENSITY_KG_M: f64 = 2.0;
const STIFFNESS_N_M2: f64 = 4000.0;
const LOCKED_DAMPING: [f64; 2] = [0.005, 0.008];
const BETA_L: [f64; 2] = [1.875_104_068_711_961, 4.694_091_132_974_175];
const TORQUE_N_M: f64 = 2.0;
const PULSE_SAMPLES: usize = 200;

/// Noise-free decay from the end of the pulse on, and its modes.
pub struct Appendage {
    pub modes: Vec<TrueMode>,
    /// Of each mode, what the accelerometers show.
    pub shapes: Vec<Vec<c64>>,
    decay: Vec<Vec<f64>>,
    poles: Vec<(c64, Vec<c64>)>,
    /// Accelerations per torque, at once.
    direct: Vec<f64>,
}

fn beam_shape(k: usize, x: f64) -> f64 {
    let (bx, bl) = (BETA_L[k] * x / LENGTH_M, BETA_L[k]);
    let s = (libm::cosh(bl) + libm::cos(bl)) / (libm::sinh(bl) + libm::sin(bl));
    (libm::cosh(bx) - libm::cos(bx) - s * (libm::sinh(bx) - libm::sin(bx))) / (DENSITY_KG_M * LENGTH_M).sqrt()
}

impl Appendage {
    pub fn new() -> Self {
        let (m, d, k) = matrices();
        let m_inverse = m.partial_piv_lu();
        let (m_k, m_d) =
            (faer::linalg::solvers::Solve::solve(&m_inverse, &k), faer::linalg::solvers::Solve::solve(&m_inverse, &d));
        let mut a = Mat::<f64>::zeros(6, 6);
        for r in 0..3 {
            a[(r, r + 3)] = 1.0;
            for c in 0..3 {
                a[(r + 3, c)] = -m_k[(r, c)];
                a[(r + 3, c + 3)] = -m_d[(r, c)];
            }
        }
        let eigen = a.eigen().unwrap();
        let mut poles: Vec<(c64, Vec<c64>)> = (0..6)
            .map(|n| (eigen.S().column_vector()[n], (0..3).map(|r| eigen.U()[(r, n)]).collect()))
            .filter(|(lambda, _): &(c64, Vec<c64>)| lambda.im > 1.0)
            .collect();
        poles.sort_by(|a, b| a.0.im.total_cmp(&b.0.im));
        let modes = poles
            .iter()
            .map(|(lambda, _)| {
                let omega = lambda.norm_sqr().sqrt();
                TrueMode { frequency_hz: omega / (2.0 * std::f64::consts::PI), damping_ratio: -lambda.re / omega }
            })
            .collect();
        // Residue of the symmetric second-order system: φ (φᵀ b) / (2 λ φᵀMφ + φᵀDφ).
        let shapes: Vec<Vec<c64>> = poles
            .iter()
            .map(|(lambda, phi)| {
                let quadratic = |x: &Mat<f64>| {
                    let mut sum = c64::new(0.0, 0.0);
                    for r in 0..3 {
                        for c in 0..3 {
                            sum += phi[r] * phi[c] * x[(r, c)];
                        }
                    }
                    sum
                };
                let gain = phi[0] / (*lambda * 2.0 * quadratic(&m) + quadratic(&d));
                (0..CHANNELS).map(|i| gain * lambda * lambda * at_sensor(i, phi)).collect()
            })
            .collect();
        let at_once =
            faer::linalg::solvers::Solve::solve(&m_inverse, &Mat::from_fn(3, 1, |r, _| f64::from(u8::from(r == 0))));
        let at_once: Vec<c64> = (0..3).map(|r| c64::new(at_once[(r, 0)], 0.0)).collect();
        let direct = (0..CHANNELS).map(|i| at_sensor(i, &at_once).re).collect();
        let mut appendage = Self { modes, shapes, decay: Vec::new(), poles, direct };
        let mut torque = vec![0.0; PULSE_SAMPLES + SAMPLES];
        torque[..PULSE_SAMPLES].fill(TORQUE_N_M);
        appendage.decay = appendage.response(&torque).split_off(PULSE_SAMPLES);
        appendage
    }

    /// Accelerations under a torque held from sample to sample, from rest, without noise.
    pub fn response(&self, torque: &[f64]) -> Vec<Vec<f64>> {
        let mut z = vec![c64::new(0.0, 0.0); self.poles.len()];
        let mut all = Vec::new();
        for u in torque {
            let mut row: Vec<f64> = self.direct.iter().map(|d| d * u).collect();
            for ((lambda, _), (z, shape)) in self.poles.iter().zip(z.iter_mut().zip(&self.shapes)) {
                row.iter_mut().zip(shape).for_each(|(y, c)| *y += 2.0 * (*c * *z).re);
                let e = exp(*lambda / SAMPLE_RATE_HZ);
                *z = e * *z + (e - 1.0) / lambda * u;
            }
            all.push(row);
        }
        all
    }

    /// The torque of the benchmark and what it does, with white noise.
    pub fn forced(&self, seed: u64, sigma_m_s2: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut torque = vec![0.0; PULSE_SAMPLES + SAMPLES];
        torque[..PULSE_SAMPLES].fill(TORQUE_N_M);
        let mut noise = Noise::new(seed);
        let mut rows = self.response(&torque);
        rows.iter_mut().flatten().for_each(|y| *y += sigma_m_s2 * noise.normal());
        (torque, rows)
    }

    /// Decay with white noise of `sigma_m_s2` and a constant bias per channel of `bias_m_s2` rms.
    pub fn record(&self, seed: u64, sigma_m_s2: f64, bias_m_s2: f64) -> Vec<Vec<f64>> {
        let mut noise = Noise::new(seed);
        let bias: Vec<f64> = (0..CHANNELS).map(|_| bias_m_s2 * noise.normal()).collect();
        self.decay
            .iter()
            .map(|sample| sample.iter().zip(&bias).map(|(y, b)| y + b + sigma_m_s2 * noise.normal()).collect())
            .collect()
    }
}

/// Acceleration at sensor `i` of the motion `phi` of hub and modes.
fn at_sensor(i: usize, phi: &[c64]) -> c64 {
    let x = LENGTH_M * (i + 1) as f64 / 10.0;
    phi[0] * (ROOT_M + x) + phi[1] * beam_shape(0, x) + phi[2] * beam_shape(1, x)
}

fn exp(z: c64) -> c64 {
    c64::new(libm::cos(z.im), libm::sin(z.im)) * libm::exp(z.re)
}

fn matrices() -> (Mat<f64>, Mat<f64>, Mat<f64>) {
    let (mut m, mut d, mut k) = (Mat::<f64>::identity(3, 3), Mat::<f64>::zeros(3, 3), Mat::<f64>::zeros(3, 3));
    let tip = ROOT_M + LENGTH_M;
    m[(0, 0)] = HUB_INERTIA_KG_M2 + DENSITY_KG_M * (tip * tip * tip - ROOT_M * ROOT_M * ROOT_M) / 3.0;
    for n in 0..2 {
        // c = ∫ ρA (r0 + x) φ dx, Simpson with 2000 intervals (error far below 1e-9).
        let steps = 2000;
        let h = LENGTH_M / f64::from(steps);
        let coupling: f64 = (0..=steps)
            .map(|s| {
                let weight = if s == 0 || s == steps {
                    1.0
                } else if s % 2 == 1 {
                    4.0
                } else {
                    2.0
                };
                let x = h * f64::from(s);
                weight * DENSITY_KG_M * (ROOT_M + x) * beam_shape(n, x) * h / 3.0
            })
            .sum();
        let omega = BETA_L[n] * BETA_L[n] * (STIFFNESS_N_M2 / (DENSITY_KG_M * LENGTH_M.powi(4))).sqrt();
        m[(0, n + 1)] = coupling;
        m[(n + 1, 0)] = coupling;
        d[(n + 1, n + 1)] = 2.0 * LOCKED_DAMPING[n] * omega;
        k[(n + 1, n + 1)] = omega * omega;
    }
    (m, d, k)
}
