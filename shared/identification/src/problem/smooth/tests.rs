use super::*;
use crate::noise::Noise;
use core::f64::consts::TAU;

fn times(n: usize, dt_s: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * dt_s).collect()
}

/// Triangle of unit amplitude and period 1 s, 0 at t = 0.
fn triangle(t_s: f64) -> f64 {
    let phase = t_s + 0.25 - libm::floor(t_s + 0.25);
    if phase < 0.5 { 4.0 * phase - 1.0 } else { 3.0 - 4.0 * phase }
}

fn noisy(time_s: &[f64], truth: impl Fn(f64) -> f64, sigma: f64, seed: u64) -> Vec<f64> {
    let mut draw = Noise::new(seed);
    time_s.iter().map(|t| truth(*t) + sigma * draw.normal()).collect()
}

#[test]
fn a_clean_sine_keeps_value_rate_and_acceleration() {
    let t = times(400, 0.005);
    let y: Vec<f64> = t.iter().map(|t| libm::sin(TAU * t)).collect();
    let motion = SmoothMotion::new(&t, &y);
    assert!(motion.kinks_s().is_empty());
    for k in 40..360 {
        let t = (k as f64 + 0.3) * 0.005;
        let at = motion.at(t);
        // cubic splines: 5/384 h⁴ f⁗ = 2e-8, h³ f⁗ / 24 = 8e-6, 3/8 h² f⁗ = 1.5e-2 of 39; the
        // natural ends have decayed
        assert!((at.value - libm::sin(TAU * t)).abs() < 1e-6, "{t}");
        assert!((at.rate - TAU * libm::cos(TAU * t)).abs() < 1e-4, "{t}");
        assert!((at.acceleration + TAU * TAU * libm::sin(TAU * t)).abs() < 3e-2, "{t}");
    }
}

#[test]
fn a_clean_triangle_is_broken_at_its_corners_and_does_not_ring() {
    let t = times(1001, 0.005);
    let y: Vec<f64> = t.iter().map(|t| triangle(*t)).collect();
    let motion = SmoothMotion::new(&t, &y);
    let corners: Vec<f64> = (0..10).map(|k| 0.25 + 0.5 * f64::from(k)).collect();
    let found = motion.kinks_s();
    assert_eq!(found.len(), corners.len(), "{found:?}");
    assert!(found.iter().zip(&corners).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    for k in 0..1000 {
        let t = (k as f64 + 0.5) * 0.005;
        // rounding of second differences of numbers near one
        assert!((motion.at(t).rate.abs() - 4.0).abs() < 1e-9, "{t}: {}", motion.at(t).rate);
    }
}

#[test]
fn noise_of_a_measured_sine_is_found_and_its_acceleration_does_not_explode() {
    let (t, sigma) = (times(4000, 0.001), 1e-3);
    let y = noisy(&t, |t| libm::sin(TAU * t), sigma, 3);
    let motion = SmoothMotion::new(&t, &y);
    // relative standard error 1/√(2n) = 1.1 %, five of them
    assert!((motion.sigma() / sigma - 1.0).abs() < 0.06, "{}", motion.sigma());
    assert!(motion.kinks_s().is_empty());
    let error = |f: &dyn Fn(f64) -> f64| {
        let squares: f64 = (200..3800).map(|k| f(k as f64 * 0.001).powi(2)).sum();
        (squares / 3600.0).sqrt()
    };
    let rate = error(&|t| motion.at(t).rate - TAU * libm::cos(TAU * t));
    let acceleration = error(&|t| motion.at(t).acceleration + TAU * TAU * libm::sin(TAU * t));
    // through all samples: rate √2 σ/h = 1.4, acceleration √6 σ/h² = 2400; signal 4.4 and 28 rms
    assert!(rate < 0.06, "{rate}");
    assert!(acceleration < 4.0, "{acceleration}");
}

#[test]
fn a_noisy_ramp_between_rests_has_two_kinks_and_its_slope() {
    let (t, sigma) = (times(1500, 0.002), 2e-3);
    let truth = |t: f64| (t - 1.0).clamp(0.0, 1.0);
    for seed in 0..5 {
        let motion = SmoothMotion::new(&t, &noisy(&t, truth, sigma, seed));
        let kinks = motion.kinks_s();
        assert_eq!(kinks.len(), 2, "seed {seed}: {kinks:?}");
        // the crossing of two lines through m samples each lies within some σ / (slope √m), m of
        // the order of 500
        assert!((kinks[0] - 1.0).abs() < 0.01 && (kinks[1] - 2.0).abs() < 0.01, "seed {seed}: {kinks:?}");
        for k in 0..8 {
            let t = 1.1 + 0.1 * f64::from(k);
            assert!((motion.at(t).rate - 1.0).abs() < 0.02, "seed {seed} at {t}: {}", motion.at(t).rate);
        }
        assert!(motion.at(0.5).rate.abs() < 0.02 && motion.at(2.5).rate.abs() < 0.02, "seed {seed}");
    }
}

#[test]
fn value_rate_and_acceleration_belong_to_one_function_at_uneven_times() {
    let t: Vec<f64> = (0..300).map(|i| 0.01 * (i as f64 + 0.3 * libm::sin(7.0 * i as f64))).collect();
    let motion = SmoothMotion::new(&t, &noisy(&t, |t| libm::sin(3.0 * t), 1e-2, 9));
    for k in 20..280 {
        let (t, d) = (0.0101 * k as f64, 1e-5);
        let (before, at, after) = (motion.at(t - d), motion.at(t), motion.at(t + d));
        // central differences: d²/6 of the third derivative, and its jumps at knots times d
        assert!(((after.value - before.value) / (2.0 * d) - at.rate).abs() < 1e-3 * (1.0 + at.rate.abs()));
        assert!(
            ((after.rate - before.rate) / (2.0 * d) - at.acceleration).abs() < 1e-2 * (1.0 + at.acceleration.abs())
        );
    }
}

#[test]
fn white_noise_alone_has_no_kinks() {
    let t = times(2000, 0.001);
    let kinks: usize = (0..20).map(|s| SmoothMotion::new(&t, &noisy(&t, |_| 0.0, 1.0, 50 + s)).kinks_s().len()).sum();
    assert!(kinks <= 1, "{kinks}"); // 20 draws at 1e-3 each
}
