use super::*;
use crate::consistency::{ChiSquareMean, nees};
use crate::seeded_noise::SeededNoise;
use nalgebra::{matrix, vector};

/// Mass on a spring, position and rate measured through a mixing matrix, force held.
struct Linear {
    f: SMatrix<f64, 3, 3>,
    b: SVector<f64, 3>,
    g: SMatrix<f64, 2, 3>,
}

impl StateSpace<3, 1, 2> for Linear {
    fn propagate(&self, state: &SVector<f64, 3>, input: &SVector<f64, 1>) -> SVector<f64, 3> {
        self.f * state + self.b * input[0]
    }
    fn observe(&self, state: &SVector<f64, 3>, _: &SVector<f64, 1>) -> SVector<f64, 2> {
        self.g * state
    }
}

fn linear() -> Linear {
    Linear {
        f: matrix![1.0, 0.1, 0.0; -0.2, 0.95, 0.05; 0.0, 0.0, 0.9],
        b: vector![0.0, 0.1, 0.3],
        g: matrix![1.0, 0.2, 0.0; 0.0, 1.0, -0.4],
    }
}

#[test]
fn on_a_linear_system_it_is_the_kalman_filter_to_rounding() {
    let (model, mut noise) = (linear(), SeededNoise::new(1));
    let process = matrix![0.0; 0.02; 0.05];
    let measurement = matrix![0.1, 0.0; 0.03, 0.2];
    let mut filter = UnscentedFilter::new(vector![1.0, 0.0, 2.0], vector![0.5, 0.3, 1.0]);
    let (mut x, mut p) = (*filter.mean(), filter.covariance());
    for k in 0..200 {
        let input = vector![libm::sin(0.3 * f64::from(k))];
        filter.predict(&model, &input, &process).expect("linear");
        x = model.propagate(&x, &input);
        p = model.f * p * model.f.transpose() + process * process.transpose();
        let z = vector![noise.normal(), noise.normal()];
        let seen = filter.update(&model, &input, &z, &measurement).expect("linear");
        let s = model.g * p * model.g.transpose() + measurement * measurement.transpose();
        let inverse = s.try_inverse().expect("positive");
        let (gain, e) = (p * model.g.transpose() * inverse, z - model.g * x);
        assert!((seen.nis - e.dot(&(inverse * e))).abs() < 1e-12 * (1.0 + seen.nis));
        x += gain * e;
        p -= gain * s * gain.transpose();
        // Differences over the spread lose no digit of note: rounding of 200 steps.
        assert!((filter.mean() - x).amax() < 1e-12, "step {k}");
        assert!((filter.covariance() - p).amax() < 1e-12, "step {k}");
    }
}

#[test]
fn a_component_measured_directly_equals_the_general_update() {
    struct First;
    impl StateSpace<3, 0, 1> for First {
        fn propagate(&self, state: &SVector<f64, 3>, _: &SVector<f64, 0>) -> SVector<f64, 3> {
            *state
        }
        fn observe(&self, state: &SVector<f64, 3>, _: &SVector<f64, 0>) -> SVector<f64, 1> {
            vector![state[1]]
        }
    }
    let mut general = UnscentedFilter::new(vector![1.0, 0.0, 2.0], vector![0.5, 0.3, 1.0]);
    let model = linear();
    general.predict(&model, &vector![0.0], &matrix![0.1; 0.0; 0.2]).expect("linear"); // correlates
    let mut direct = general.clone();
    let seen = general.update(&First, &SVector::zeros(), &vector![0.7], &matrix![0.25]).expect("linear");
    let one = direct.update_component(1, 0.7, 0.25, |_| true).expect("positive");
    assert!((seen.nis - one.normalised() * one.normalised()).abs() < 1e-14);
    assert!((general.mean() - direct.mean()).amax() < 1e-14);
    assert!((general.covariance() - direct.covariance()).amax() < 1e-14);
}

/// Decay `x⁺ = x exp(−λ dt)` of an unknown rate, driven by noise; the rate must be positive.
struct Decay;

const DT: f64 = 0.1;

impl StateSpace<2, 1, 1> for Decay {
    fn propagate(&self, state: &SVector<f64, 2>, input: &SVector<f64, 1>) -> SVector<f64, 2> {
        let decay = libm::exp(-state[1] * DT);
        vector![state[0] * decay + input[0] * (1.0 - decay) / libm::sqrt(state[1]), state[1]]
    }
    fn observe(&self, state: &SVector<f64, 2>, _: &SVector<f64, 1>) -> SVector<f64, 1> {
        vector![state[0]]
    }
    fn is_feasible(&self, state: &SVector<f64, 2>) -> bool {
        state[1] > 0.0
    }
}

fn decay_run(seed: u64, start: f64, sigma_start: f64) -> (UnscentedFilter<2>, ChiSquareMean, SVector<f64, 2>) {
    let mut noise = SeededNoise::new(seed);
    let mut filter = UnscentedFilter::new(vector![0.0, start], vector![1.0, sigma_start]);
    let (mut truth, mut nis) = (vector![noise.normal(), 0.8], ChiSquareMean::default());
    for k in 0..300 {
        let input = vector![2.0 * libm::sin(0.05 * f64::from(k))];
        truth = Decay.propagate(&truth, &input);
        truth[0] += 0.01 * noise.normal();
        filter.predict(&Decay, &input, &matrix![0.01; 0.0]).expect("feasible");
        let z = vector![truth[0] + 0.02 * noise.normal()];
        let seen = filter.update(&Decay, &input, &z, &matrix![0.02]).expect("feasible");
        if k >= 100 {
            nis.push(seen.nis, 1);
        }
    }
    (filter, nis, truth)
}

#[test]
fn covariance_of_states_and_constants_is_honest_over_500_seeds() {
    let (mut statistic, mut nis) = (ChiSquareMean::default(), (0.0, 0.0));
    for seed in 0..500 {
        let mut prior = SeededNoise::new(10_000 + seed);
        let (filter, mine, truth) = decay_run(seed, 0.8 + 0.1 * prior.normal(), 0.1);
        statistic.push(nees(&(filter.mean() - truth), &filter.covariance()).expect("positive"), 2);
        nis = (nis.0 + mine.per_degree().expect("200 values"), nis.1 + 1.0);
    }
    let (low, high) = statistic.band_per_degree(0.999).expect("500 values");
    let mean = statistic.per_degree().expect("500 values");
    assert!(mean > low && mean < high, "{mean} outside [{low}, {high}]");
    // 10⁵ innovations: √(2/10⁵) = 0.0045, four of them.
    assert!((nis.0 / nis.1 - 1.0).abs() < 0.018, "{}", nis.0 / nis.1);
}

#[test]
fn a_start_whose_sigma_points_leave_the_model_converges_and_without_the_hook_it_does_not() {
    // 0.3 ± √3 · 0.3 is negative, where the model is NaN.
    let (filter, _, truth) = decay_run(7, 0.3, 0.3);
    assert!((filter.mean()[1] - truth[1]).abs() < 5.0 * filter.sigmas()[1]);
    struct Careless;
    impl StateSpace<2, 1, 1> for Careless {
        fn propagate(&self, state: &SVector<f64, 2>, input: &SVector<f64, 1>) -> SVector<f64, 2> {
            Decay.propagate(state, input)
        }
        fn observe(&self, state: &SVector<f64, 2>, input: &SVector<f64, 1>) -> SVector<f64, 1> {
            Decay.observe(state, input)
        }
    }
    let mut careless = UnscentedFilter::new(vector![0.0, 0.3], vector![1.0, 0.3]);
    let before = careless.clone();
    let outcome = careless.predict(&Careless, &vector![1.0], &matrix![0.01; 0.0]);
    assert_eq!(outcome, Err(UnscentedError::NotFinite));
    assert_eq!(careless, before);
}

#[test]
fn mean_and_variance_of_a_square_are_those_of_the_normal_density() {
    struct Square;
    impl StateSpace<1, 0, 1> for Square {
        fn propagate(&self, state: &SVector<f64, 1>, _: &SVector<f64, 0>) -> SVector<f64, 1> {
            vector![state[0] * state[0]]
        }
        fn observe(&self, state: &SVector<f64, 1>, _: &SVector<f64, 0>) -> SVector<f64, 1> {
            *state
        }
    }
    let mut filter = UnscentedFilter::new(vector![1.5], vector![0.4]);
    filter.predict(&Square, &SVector::zeros(), &matrix![0.0]).expect("finite");
    // E x² = μ² + σ², Var x² = 4 μ² σ² + 2 σ⁴
    assert!((filter.mean()[0] - 2.41).abs() < 1e-14);
    assert!((filter.covariance()[(0, 0)] - (4.0 * 2.25 * 0.16 + 2.0 * 0.0256)).abs() < 1e-14);
}

#[test]
fn nearly_exact_measurements_leave_a_positive_covariance() {
    let (model, input) = (linear(), vector![0.0]);
    let mut filter = UnscentedFilter::new(SVector::zeros(), vector![1.0, 1.0, 1.0]);
    for _ in 0..1000 {
        filter.predict(&model, &input, &matrix![0.0; 1e-3; 1.0]).expect("linear");
        let tiny = SMatrix::<f64, 2, 2>::identity() * 1e-10; // a variance of 1e-20 beside one of 1
        filter.update(&model, &input, &vector![0.1, 0.1], &tiny).expect("positive");
        assert!(filter.sigmas().iter().all(|sigma| *sigma > 0.0 && sigma.is_finite()));
    }
}

#[test]
fn a_measurement_that_is_not_finite_is_refused_and_a_checkpoint_continues_bit_for_bit() {
    let (model, input) = (linear(), vector![0.3]);
    let mut filter = UnscentedFilter::new(vector![1.0, 0.0, 2.0], vector![0.5, 0.3, 1.0]);
    let refused = filter.update(&model, &input, &vector![f64::NAN, 0.0], &SMatrix::identity());
    assert_eq!(refused, Err(UnscentedError::NotFinite));
    let bytes = postcard::to_stdvec(&filter).expect("plain numbers");
    let mut restored: UnscentedFilter<3> = postcard::from_bytes(&bytes).expect("own bytes");
    for _ in 0..10 {
        for one in [&mut filter, &mut restored] {
            one.predict(&model, &input, &matrix![0.0; 0.02; 0.05]).expect("linear");
            one.update(&model, &input, &vector![0.2, 0.1], &SMatrix::identity()).expect("finite");
        }
    }
    assert_eq!(filter, restored);
}
