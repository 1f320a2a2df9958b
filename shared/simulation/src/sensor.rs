//! What a sensor does to a true value: quantisation, and white noise that is stated as a random
//! walk.

/// Nearest multiple of `lsb`, halves away from zero; `lsb = 0` leaves the value alone.
pub fn quantise(value: f64, lsb: f64) -> f64 {
    if lsb == 0.0 { value } else { libm::round(value / lsb) * lsb }
}

/// Standard deviation of one sample of a rate sensor with angle random walk `N` [unit/√s], or of a
/// mean acceleration with velocity random walk `N`, over the interval `interval_s`: `N / √Δt`.
pub fn random_walk_sample_sigma(random_walk: f64, interval_s: f64) -> f64 {
    assert!(interval_s > 0.0 && interval_s.is_finite());
    random_walk / interval_s.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantised_values_are_multiples_of_the_step_and_zero_step_changes_nothing() {
        assert_eq!(quantise(0.1234, 0.0), 0.1234);
        assert_eq!(quantise(-7.4, 2.0), -8.0);
        assert_eq!(quantise(6.9, 2.0), 6.0);
    }

    #[test]
    fn random_walk_density_does_not_depend_on_the_sampling_rate() {
        let density = 2.618e-5;
        for interval in [0.001, 0.01, 1.0] {
            let sigma = random_walk_sample_sigma(density, interval);
            // the sum of 1/Δt samples of angle increments has variance N² per second
            assert!((sigma * sigma * interval / (density * density) - 1.0).abs() < 1e-14);
        }
    }
}
