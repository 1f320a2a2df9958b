//! Scale and delay of the thrust from a fast square wave that slosh does not follow, before it is
//! used for slosh.
//!
//! A thrust scale that is free takes 8 % of mass, stiffness and damping with it in the plane (it
//! scales them all). Far above the slosh mode the hub answers alone: the reaction of the slosh mass
//! is `β (ω_mode/ω)²` of the thrust, 2e-5 at 0.5 Hz. With force held over intervals of `dt` and a
//! delay δ below one of them,
//!
//! ```text
//! a_k = (1+s) f_k/m0 − (1+s) δ (f_k − f_{k−1})/(m0 dt) + bias + trend + curvature + n_k
//! ```
//!
//! is linear in `[1+s, (1+s) δ, bias, trend, curvature]`; the three last take what slosh already
//! swings. A square wave that begins with a quarter of its period adds no velocity and no
//! displacement on the mean: the stroke stays as it was.

use estimation::cramer_rao::FisherInformation;
use nalgebra::{SMatrix, SVector};

use physics::slosh_arc::SloshSample;

/// Scale, scale times delay, bias, trend, curvature.
const THRUST_COLUMNS: usize = 5;

/// Thrust over its command less one, its delay, and their standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustCalibration {
    pub scale_error: f64,
    pub delay_s: f64,
    pub scale_sigma: f64,
    pub delay_sigma_s: f64,
    pub scale_delay_covariance_s: f64,
    pub chi_square: f64,
    pub degrees_of_freedom: f64,
}

impl ThrustCalibration {
    /// The thrust of a command, its scale set right; the delay remains.
    pub fn thrust(&self, commanded_n: f64) -> f64 {
        (1.0 + self.scale_error) * commanded_n
    }
}

/// Why a burst calibrates no thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationError {
    /// Fewer samples than twice the unknowns.
    TooShort { got: usize, need: usize },
    /// The thrust does not change, or does so with the trend alone.
    NotExcited,
    /// The delay found is no part of one interval: sample more slowly, or shift the command first.
    DelayBeyondInterval { delay_s: f64, interval_s: f64 },
}

/// Weighted least squares over a burst whose samples follow each other, the thrust before it
/// `before_n`; where that is not known the first sample tells only the second's edge. Attains the
/// Cramér–Rao bound of its model.
///
/// # Errors
/// [`CalibrationError`]. Cost: 60 ns per sample, no memory.
pub fn calibrate_thrust(
    burst: &[SloshSample],
    base_mass_kg: f64,
    before_n: Option<f64>,
) -> Result<ThrustCalibration, CalibrationError> {
    let (got, need) = (burst.len(), 2 * THRUST_COLUMNS);
    if got < need {
        return Err(CalibrationError::TooShort { got, need });
    }
    let (mut normal, mut right) =
        (SMatrix::<f64, THRUST_COLUMNS, THRUST_COLUMNS>::zeros(), SVector::<f64, THRUST_COLUMNS>::zeros());
    let (mut before_n, mut measured) = (before_n, 0);
    let mut square = 0.0;
    for (k, sample) in burst.iter().enumerate() {
        let t = 2.0 * k as f64 / got as f64 - 1.0;
        let Some(last_n) = before_n.replace(sample.force_n) else { continue };
        let edge_n = (sample.force_n - last_n) / sample.interval_s;
        if !sample.sigma_m_s2.is_finite() {
            continue;
        }
        let row = SVector::<f64, THRUST_COLUMNS>::from([
            sample.force_n / base_mass_kg,
            -edge_n / base_mass_kg,
            1.0,
            t,
            t * t,
        ]);
        let weight = 1.0 / (sample.sigma_m_s2 * sample.sigma_m_s2);
        normal += row * row.transpose() * weight;
        right += row * (sample.acceleration_m_s2 * weight);
        square += sample.acceleration_m_s2 * sample.acceleration_m_s2 * weight;
        measured += 1;
    }
    let covariance =
        FisherInformation::<THRUST_COLUMNS> { matrix: normal }.bound().ok_or(CalibrationError::NotExcited)?;
    let solved = covariance * right;
    let (scale, delay_s, interval_s) = (solved[0], solved[1] / solved[0], burst[0].interval_s);
    let delay_variance =
        covariance[(1, 1)] - 2.0 * delay_s * covariance[(0, 1)] + delay_s * delay_s * covariance[(0, 0)];
    let delay_sigma_s = libm::sqrt(delay_variance) / scale.abs();
    // The model says nothing beyond one interval on the one side, and a thrust does not precede its
    // command on the other.
    if !(delay_s > -5.0 * delay_sigma_s && delay_s < interval_s + 5.0 * delay_sigma_s) {
        return Err(CalibrationError::DelayBeyondInterval { delay_s, interval_s });
    }
    Ok(ThrustCalibration {
        scale_error: scale - 1.0,
        delay_s,
        scale_sigma: libm::sqrt(covariance[(0, 0)]),
        delay_sigma_s,
        scale_delay_covariance_s: (covariance[(0, 1)] - delay_s * covariance[(0, 0)]) / scale,
        chi_square: square - solved.dot(&right),
        degrees_of_freedom: f64::from(measured as u32) - THRUST_COLUMNS as f64,
    })
}

/// Command of the calibration burst at `t_s` from its begin: a square wave that begins with half of
/// a half-cycle.
pub fn calibration_command_n(amplitude_n: f64, frequency_hz: f64, t_s: f64) -> f64 {
    let phase = t_s * frequency_hz + 0.25;
    if phase - libm::floor(phase) < 0.5 { amplitude_n } else { -amplitude_n }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark_tank::{BASE_MASS_KG, TANK};
    use crate::seeded_noise::SeededNoise;
    use physics::slosh::{SloshPropagator, SloshState};

    const INTERVAL_S: f64 = 0.1;
    const SIGMA: f64 = 0.008 / 60.0 / 0.316_227_766_016_837_94;

    /// A minute of ±44 N at 0.5 Hz on a tank that swings already, the thrust 1 % strong and 20 ms
    /// late.
    fn burst(seed: u64, (scale, delay_s): (f64, f64)) -> (Vec<SloshSample>, f64) {
        let start = SloshState { displacement_m: 0.3, velocity_m_s: 0.01 };
        let (mut motion, mut noise) = (SloshPropagator::new(TANK, BASE_MASS_KG, start), SeededNoise::new(seed));
        let (mut before_n, mut stroke) = (0.0, 0.0_f64);
        let sample = |k: u32| {
            let force_n = calibration_command_n(44.0, 0.5, f64::from(k) * INTERVAL_S);
            let late = motion.step(delay_s, scale * before_n) * delay_s;
            let rest = motion.step(INTERVAL_S - delay_s, scale * force_n) * (INTERVAL_S - delay_s);
            before_n = force_n;
            stroke = stroke.max(motion.state().displacement_m.abs());
            let acceleration_m_s2 = (late + rest) / INTERVAL_S + 3e-5 + SIGMA * noise.normal();
            SloshSample { interval_s: INTERVAL_S, force_n, acceleration_m_s2, sigma_m_s2: SIGMA }
        };
        ((0..600).map(sample).collect(), stroke)
    }

    #[test]
    fn a_minute_of_fast_thrust_tells_scale_to_four_parts_in_ten_thousand_and_delay_to_70_microseconds() {
        let (mut squares, seeds) = ([0.0; 2], 60);
        for seed in 0..seeds {
            let found = calibrate_thrust(&burst(seed, (1.01, 0.02)).0, BASE_MASS_KG, Some(0.0)).expect("excited");
            squares[0] += ((found.scale_error - 0.01) / found.scale_sigma).powi(2) / seeds as f64;
            squares[1] += ((found.delay_s - 0.02) / found.delay_sigma_s).powi(2) / seeds as f64;
            // 44 N through N√(1/60 s) and 60 edges of 88 N: the independent study's 0.041 % and
            // 0.065 ms.
            assert!((found.scale_sigma / 4.1e-4 - 1.0).abs() < 0.1, "{}", found.scale_sigma);
            assert!((found.delay_sigma_s / 6.5e-5 - 1.0).abs() < 0.1, "{}", found.delay_sigma_s);
            let z = (found.chi_square - found.degrees_of_freedom) / libm::sqrt(2.0 * found.degrees_of_freedom);
            assert!(z.abs() < 4.5, "{z}");
        }
        // 60 unit normal squares: their mean spreads by 0.18.
        assert!(squares.iter().all(|mean| *mean > 0.45 && *mean < 1.6), "{squares:?}");
    }

    #[test]
    fn the_burst_leaves_the_stroke_as_it_was() {
        let (with, without) = (burst(1, (1.0, 0.0)).1, burst(1, (0.0, 0.0)).1);
        assert!(with < without + 0.01, "{with} {without}"); // f/(m0 ω²) = 4.4 mm
    }

    #[test]
    fn a_delay_of_more_than_an_interval_is_refused_and_so_is_a_steady_thrust() {
        let (mut samples, _) = burst(2, (1.0, 0.0));
        for k in (4..samples.len()).rev() {
            samples[k].acceleration_m_s2 = samples[k - 4].acceleration_m_s2;
        }
        let late = calibrate_thrust(&samples, BASE_MASS_KG, Some(0.0));
        assert!(matches!(late, Err(CalibrationError::DelayBeyondInterval { .. })), "{late:?}");
        for sample in &mut samples {
            sample.force_n = 0.0;
        }
        assert_eq!(calibrate_thrust(&samples, BASE_MASS_KG, Some(0.0)), Err(CalibrationError::NotExcited));
    }

    #[test]
    fn a_burst_that_begins_under_unknown_thrust_is_not_misled_by_its_first_edge() {
        // Cut at an edge: the thrust before was −44 N.
        let whole = burst(4, (1.01, 0.05)).0;
        let cut = (1..whole.len()).find(|k| whole[*k].force_n > whole[k - 1].force_n).expect("an edge");
        let samples = &whole[cut..];
        let off = |before_n| {
            let found = calibrate_thrust(samples, BASE_MASS_KG, before_n).expect("excited");
            (found.delay_s - 0.05) / found.delay_sigma_s
        };
        assert!(off(None).abs() < 4.0 && off(Some(-44.0)).abs() < 4.0, "{} {}", off(None), off(Some(-44.0)));
        // Half of one edge in sixty: 0.4 % of 50 ms, three sigma.
        let misled = off(Some(0.0)) - off(Some(-44.0));
        assert!(misled > 2.0 && misled < 5.0, "{misled}");
    }
}
