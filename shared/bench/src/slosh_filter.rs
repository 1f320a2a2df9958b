//! Slosh parameters by a bank of square-root unscented Kalman filters, in one pass of the record.
//!
//! With `β = ms/(m0+ms)`, `q = β r` and `κ, γ = ks/μ, cs/μ`
//!
//! ```text
//! q̈ + γ q̇ + κ q = −β f/m0          a = f/m0 − β f/m0 − Δq̇/dt          states [q, q̇, β, ln κ, γ], bias on demand
//! ```
//!
//! Given κ this is linear in all that is left, but for the product γ q̇. In
//! `[r, ṙ, ln ms, ln ks, ln cs]` it is not: there one pass from a start 45 % off loses a factor 1.9
//! to the Cramér–Rao bound and its covariance says less than half of that. The one strong
//! nonlinearity that remains is the frequency: a prior on it is a sum of narrow normal densities,
//! each filtered by itself and weighed by its innovations (Alspach & Sorenson 1972); those that the
//! record contradicts are dropped, so that of some forty soon a few are left. There is no process
//! noise: the parameters are constants. A sample is first used, with the motion over its interval
//! predicted from the state at its beginning, then the state is moved on.
//!
//! *Why is this not what flies?* It needs a prior; the maximum likelihood over the arc needs none,
//! attains the same bound in the same memory, and judges itself by χ². The bank gives every
//! sample's innovation at once.

use estimation::Innovation;
use estimation::unscented::{StateSpace, UnscentedError, UnscentedFilter};
use nalgebra::{Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3};

use physics::slosh::{SloshParameters, SloshState};
use physics::slosh_arc::SloshSample;

/// `[q, q̇, β, ln κ, γ]`.
pub const SLOSH_STATES: usize = 5;
/// And the bias of the accelerometer.
pub const SLOSH_STATES_WITH_BIAS: usize = 6;

/// Filters of a bank.
pub const FILTERS_MAX: usize = 48;
/// Standard deviation of ln κ in one filter, and the distance between two: 5 % of the frequency.
/// Half of it changes nothing (60 seeds of the benchmark's sine: RMSE over bound 0.95/0.98/1.10 and
/// 0.89/0.90/1.03), twice of it begins to.
const WIDTH: f64 = 0.1;
/// Standard deviations of the prior that the bank covers.
const REACH: f64 = 2.5;
/// A filter e¹⁴ times less likely than the best is dropped.
const DROPPED: f64 = 14.0;

/// Model of one interval; `X` is [`SLOSH_STATES`] or [`SLOSH_STATES_WITH_BIAS`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct SloshStep {
    base_mass_kg: f64,
    interval_s: f64,
}

impl SloshStep {
    /// `[q, q̇]` at the end of the interval, and the mean acceleration of the base over it without
    /// bias.
    fn run<const X: usize>(&self, state: &SVector<f64, X>, force_n: f64) -> (Vector2<f64>, f64) {
        let (q, v, beta, kappa, gamma, dt) =
            (state[0], state[1], state[2], libm::exp(state[3]), state[4], self.interval_s);
        let (s, s_dot) = response(kappa, gamma, dt);
        let s_integral = integral(kappa, gamma, dt, (s, s_dot));
        let rigid = force_n / self.base_mass_kg;
        let push = beta * rigid;
        let next =
            Vector2::new((s_dot + gamma * s) * q + s * v - s_integral * push, -kappa * s * q + s_dot * v - s * push);
        (next, rigid - push - (next[1] - v) / dt)
    }
}

/// `s̈ + γ ṡ + κ s = 0`, `s(0) = 0`, `ṡ(0) = 1`, and `ṡ`, after `t`: closed form.
fn response(kappa: f64, gamma: f64, t: f64) -> (f64, f64) {
    let (decay, square) = (libm::exp(-0.5 * gamma * t), kappa - 0.25 * gamma * gamma);
    let angle = libm::sqrt(square.abs()) * t;
    let (sine, cosine) = if angle < 1e-4 {
        (t, 1.0 - square * t * t / 2.0)
    } else if square > 0.0 {
        let (sine, cosine) = libm::sincos(angle);
        (sine * t / angle, cosine)
    } else {
        (libm::sinh(angle) * t / angle, libm::cosh(angle))
    };
    let s = decay * sine;
    (s, decay * cosine - 0.5 * gamma * s)
}

/// `∫s` over `t`: the equation integrated once; where that is rounding, twice, or its series.
fn integral(kappa: f64, gamma: f64, t: f64, (s, s_dot): (f64, f64)) -> f64 {
    if kappa * t * t > 1e-6 {
        (1.0 - s_dot - gamma * s) / kappa
    } else if gamma * t > 1e-2 {
        (t - s - kappa * t * t * t / 6.0) / gamma
    } else {
        t * t / 2.0 * (1.0 - gamma * t / 3.0 + (gamma * gamma - kappa) * t * t / 12.0)
    }
}

impl<const X: usize> StateSpace<X, 1, 1> for SloshStep {
    fn propagate(&self, state: &SVector<f64, X>, force_n: &Vector1<f64>) -> SVector<f64, X> {
        let mut next = *state;
        next.fixed_rows_mut::<2>(0).copy_from(&self.run(state, force_n[0]).0);
        next
    }

    fn observe(&self, state: &SVector<f64, X>, force_n: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(self.run(state, force_n[0]).1 + state.get(5).copied().unwrap_or(0.0))
    }

    /// Twelve decades of κ about one, growth below e⁵⁰ a step: beyond, the exponentials say
    /// nothing.
    fn is_feasible(&self, state: &SVector<f64, X>) -> bool {
        state[3].abs() < 27.0 && state[4].abs() * self.interval_s < 100.0
    }
}

/// What is believed before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshPrior {
    pub parameters: SloshParameters,
    /// Standard deviations of the logarithms of `[ms, ks, cs]`.
    pub log_sigma: Vector3<f64>,
    /// Of `[r, ṙ]` about rest.
    pub state_sigma: Vector2<f64>,
    /// Of the accelerometer's bias about zero; without a place in the state it is known.
    pub bias_sigma_m_s2: f64,
}

impl SloshPrior {
    /// Variance of ln κ: that of `ln ks − ln μ`.
    fn variance_of_log_kappa(&self, mass_variance: f64) -> f64 {
        self.log_sigma[1] * self.log_sigma[1] + mass_variance
    }
}

/// Estimate of `[ms, ks, cs]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredSlosh {
    pub parameters: SloshParameters,
    pub covariance: Matrix3<f64>,
    pub state: SloshState,
}

/// One filter and the logarithm of its weight.
#[derive(Clone, Debug, PartialEq)]
struct Weighed<const X: usize> {
    filter: UnscentedFilter<X>,
    log_weight: f64,
}

/// The bank; fixed memory, no allocation.
#[derive(Clone, Debug, PartialEq)]
pub struct SloshFilter<const X: usize> {
    base_mass_kg: f64,
    bank: [Option<Weighed<X>>; FILTERS_MAX],
}

impl<const X: usize> SloshFilter<X> {
    /// The filter at its prior; panics unless masses, stiffness and damping are positive.
    pub fn new(base_mass_kg: f64, prior: &SloshPrior) -> Self {
        const { assert!(X == SLOSH_STATES || X == SLOSH_STATES_WITH_BIAS) }
        let SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m } = prior.parameters;
        assert!(slosh_mass_kg > 0.0);
        assert!(stiffness_n_m > 0.0);
        assert!(damping_n_s_m > 0.0);
        // ln β moves by the hub's share of ln ms.
        let share = base_mass_kg / (base_mass_kg + slosh_mass_kg);
        let by_mass = share * share * prior.log_sigma[0] * prior.log_sigma[0];
        let total = prior.variance_of_log_kappa(by_mass);
        // A sum of densities WIDTH wide, WIDTH apart, has the prior's variance; a narrow prior is
        // one density.
        let spread = libm::sqrt((total - WIDTH * WIDTH).max(0.0));
        let half = FILTERS_MAX as f64 / 2.0 - 1.0;
        let width = if spread == 0.0 { libm::sqrt(total) } else { WIDTH.max(REACH * spread / half) };
        let steps = if spread == 0.0 { 0 } else { libm::ceil((REACH * spread / width).min(half)) as usize };
        let mut bank = [const { None }; FILTERS_MAX];
        for (i, place) in bank.iter_mut().enumerate().take(2 * steps + 1) {
            let offset = (i as f64 - steps as f64) * width;
            let unit = if spread == 0.0 { 0.0 } else { offset / spread };
            let filter = narrow(prior, base_mass_kg, [by_mass, total], offset, width);
            *place = Some(Weighed { filter, log_weight: -0.5 * unit * unit });
        }
        Self { base_mass_kg, bank }
    }

    /// Uses the acceleration where there is one, then moves on; the innovation of what was used.
    ///
    /// # Errors
    /// [`UnscentedError::NotFinite`] for such a sample, the bank is untouched then; that of the
    /// last filter, when none is left: the bank is empty then.
    pub fn step(&mut self, sample: &SloshSample) -> Result<Option<Innovation>, UnscentedError> {
        let heard = sample.sigma_m_s2.is_infinite() || sample.acceleration_m_s2.is_finite();
        if !(heard && sample.interval_s.is_finite() && sample.force_n.is_finite()) {
            return Err(UnscentedError::NotFinite);
        }
        let model = SloshStep { base_mass_kg: self.base_mass_kg, interval_s: sample.interval_s };
        let (mut seen, mut last) = (Mixture::default(), UnscentedError::MeanInfeasible);
        let best = self.weights().fold(f64::NEG_INFINITY, f64::max);
        for place in &mut self.bank {
            let Some(one) = place else { continue };
            match one.step(&model, sample) {
                Ok(None) => {}
                Ok(Some((innovation, variance, before))) => seen.add(libm::exp(before - best), innovation, variance),
                Err(error) => (*place, last) = (None, error),
            }
        }
        let best = self.weights().fold(f64::NEG_INFINITY, f64::max);
        if best == f64::NEG_INFINITY {
            return Err(last);
        }
        for place in &mut self.bank {
            if let Some(one) = place {
                one.log_weight -= best;
                if one.log_weight < -DROPPED {
                    *place = None;
                }
            }
        }
        Ok(seen.innovation(sample.sigma_m_s2))
    }

    fn weights(&self) -> impl Iterator<Item = f64> + '_ {
        self.bank.iter().flatten().map(|one| one.log_weight)
    }

    /// Filters that the record has not contradicted.
    pub fn filters(&self) -> usize {
        self.weights().count()
    }

    /// Mean and covariance of the sum, to first order from the states of each filter.
    pub fn estimate(&self) -> FilteredSlosh {
        let weight: f64 = self.weights().map(libm::exp).sum();
        let (mut mean, mut square, mut state) = (Vector3::zeros(), Matrix3::zeros(), Vector2::zeros());
        // About the first filter's: sums of squares about zero would cancel.
        let about =
            self.bank.iter().flatten().next().map_or_else(Vector3::zeros, |one| one.parameters(self.base_mass_kg).0);
        for one in self.bank.iter().flatten() {
            let share = libm::exp(one.log_weight) / weight;
            let (value, covariance) = one.parameters(self.base_mass_kg);
            let away = value - about;
            mean += away * share;
            square += (covariance + away * away.transpose()) * share;
            let x = one.filter.mean();
            state += Vector2::new(x[0], x[1]) * (share / x[2]);
        }
        let value = about + mean;
        FilteredSlosh {
            parameters: SloshParameters { slosh_mass_kg: value[0], stiffness_n_m: value[1], damping_n_s_m: value[2] },
            covariance: square - mean * mean.transpose(),
            state: SloshState { displacement_m: state[0], velocity_m_s: state[1] },
        }
    }
}

/// The filter of the tanks with `ln κ` within `width` of `offset` from the prior's;
/// `[var ln β, var ln κ]`.
///
/// `ln β` and `ln γ` given `ln κ`: `∓ v/V` of its offset, since all three contain `ln μ`.
fn narrow<const X: usize>(
    prior: &SloshPrior,
    base_mass_kg: f64,
    [by_mass, total]: [f64; 2],
    offset: f64,
    width: f64,
) -> UnscentedFilter<X> {
    let SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m } = prior.parameters;
    let mu = prior.parameters.reduced_mass_kg(base_mass_kg);
    let (part, stiffness_variance) = (by_mass / total, prior.log_sigma[1] * prior.log_sigma[1]);
    let left = part * stiffness_variance;
    let beta = slosh_mass_kg / (base_mass_kg + slosh_mass_kg) * libm::exp(-part * offset);
    let gamma = damping_n_s_m / mu * libm::exp(part * offset);
    let damping = lognormal(gamma, prior.log_sigma[2] * prior.log_sigma[2] + left);
    let share = lognormal(beta, left);
    let (mut mean, mut sigma) = (SVector::<f64, X>::zeros(), SVector::<f64, X>::zeros());
    for (i, [value, spread]) in [(2, share), (3, [libm::log(stiffness_n_m / mu) + offset, width]), (4, damping)] {
        (mean[i], sigma[i]) = (value, spread);
    }
    sigma.fixed_rows_mut::<2>(0).copy_from(&(prior.state_sigma * share[0]));
    if X == SLOSH_STATES_WITH_BIAS {
        sigma[5] = prior.bias_sigma_m_s2;
    }
    UnscentedFilter::new(mean, sigma)
}

/// Mean and standard deviation of a lognormal number; a factor of four and more is believed no
/// wider, its tail would be all.
fn lognormal(median: f64, log_variance: f64) -> [f64; 2] {
    let variance = log_variance.min(2.0);
    let mean = median * libm::exp(variance / 2.0);
    [mean, mean * libm::sqrt(libm::expm1(variance))]
}

impl<const X: usize> Weighed<X> {
    /// `[innovation, its variance, log weight before]` of what was used.
    fn step(&mut self, model: &SloshStep, sample: &SloshSample) -> Result<Option<(f64, f64, f64)>, UnscentedError> {
        let force = Vector1::new(sample.force_n);
        let mut used = None;
        if sample.sigma_m_s2.is_finite() {
            let (measured, noise) = (Vector1::new(sample.acceleration_m_s2), Vector1::new(sample.sigma_m_s2));
            let seen = self.filter.update(model, &force, &measured, &noise)?;
            let deviation = seen.factor[(0, 0)];
            used = Some((seen.innovation[0], deviation * deviation, self.log_weight));
            self.log_weight -= 0.5 * seen.nis + libm::log(deviation);
        }
        self.filter.predict::<1, 1, 1>(model, &force, &SMatrix::zeros())?;
        Ok(used)
    }

    /// `[ms, ks, cs] = [m0 β/(1−β), κ μ, γ μ]`, `μ = m0 β`, and its covariance.
    fn parameters(&self, base_mass_kg: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let x = self.filter.mean();
        let (beta, kappa, gamma) = (x[2], libm::exp(x[3]), x[4]);
        let mu = base_mass_kg * beta;
        let value = Vector3::new(mu / (1.0 - beta), kappa * mu, gamma * mu);
        let by = Matrix3::new(
            base_mass_kg / ((1.0 - beta) * (1.0 - beta)),
            0.0,
            0.0, //
            kappa * base_mass_kg,
            kappa * mu,
            0.0, //
            gamma * base_mass_kg,
            0.0,
            mu,
        );
        let states: Matrix3<f64> = self.filter.covariance().fixed_view::<3, 3>(2, 2).into();
        (value, by * states * by.transpose())
    }
}

/// Innovation of a sum of densities.
#[derive(Default)]
struct Mixture {
    weight: f64,
    mean: f64,
    square: f64,
}

impl Mixture {
    fn add(&mut self, weight: f64, innovation: f64, variance: f64) {
        self.weight += weight;
        self.mean += weight * innovation;
        self.square += weight * (variance + innovation * innovation);
    }

    fn innovation(&self, sigma: f64) -> Option<Innovation> {
        (self.weight > 0.0).then(|| {
            let mean = self.mean / self.weight;
            let noise = sigma * sigma;
            Innovation::new(mean, noise, (self.square / self.weight - mean * mean - noise).max(0.0))
        })
    }
}

/// How many of its standard deviations the first pass leaves open to the second: what it said then
/// weighs one per cent, and what it was wrong by lies inside.
const SECOND_PASS_WIDENING: f64 = 10.0;

/// Two passes: the second begins at the result of the first with a tenfold standard deviation and
/// forgets the rest.
///
/// # Errors
/// Those of [`SloshFilter::step`]; [`UnscentedError::MeanInfeasible`] when the first pass leaves no
/// tank.
pub fn filter_twice<const X: usize>(
    record: &[SloshSample],
    base_mass_kg: f64,
    prior: &SloshPrior,
) -> Result<[FilteredSlosh; 2], UnscentedError> {
    let pass = |prior: &SloshPrior| {
        let mut filter = SloshFilter::<X>::new(base_mass_kg, prior);
        record.iter().try_for_each(|sample| filter.step(sample).map(|_| ()))?;
        Ok(filter.estimate())
    };
    let first = pass(prior)?;
    let SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m } = first.parameters;
    let value = Vector3::new(slosh_mass_kg, stiffness_n_m, damping_n_s_m);
    if value.min() <= 0.0 {
        return Err(UnscentedError::MeanInfeasible);
    }
    let relative = first.covariance.diagonal().map(libm::sqrt).component_div(&value);
    let log_sigma = (relative * SECOND_PASS_WIDENING).zip_map(&prior.log_sigma, f64::min);
    let second = pass(&SloshPrior { parameters: first.parameters, log_sigma, ..*prior })?;
    Ok([first, second])
}

#[cfg(test)]
mod tests;
