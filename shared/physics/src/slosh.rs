//! Sloshing propellant as an equivalent spring–mass–damper on one axis, in the relative coordinate.
//!
//! `r = x_s − x_0`, `μ = m0 ms/(m0+ms)`, `κ = ks/μ`, `γ = cs/μ`:
//!
//! ```text
//! r̈ + γ ṙ + κ r = −f/m0          Δv0 = (∫f dt − ms Δṙ)/(m0 + ms)      (exact: momentum)
//! ```
//!
//! *Why relative?* With an accelerometer alone the absolute form `[x0, xs, v0, vs, …]` has two
//! directions without any trace (common shift, common velocity); they random-walk and break a
//! filter. `[r, ṙ, ms, ks, cs]` is observable. *Why Δv?* Accelerometers integrate; summed
//! increments keep all information at any block length.
//!
//! Frames: one axis, positive along the thrust. Units: SI throughout.

use estimation::matrix_exponential;
use nalgebra::{Matrix2, SMatrix, Vector2};
use serde::{Deserialize, Serialize};

/// What is to be identified; the base mass is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshParameters {
    pub slosh_mass_kg: f64,
    pub stiffness_n_m: f64,
    /// May come out negative from a short arc: it is an estimate, not a claim.
    pub damping_n_s_m: f64,
}

impl SloshParameters {
    /// `μ = m0 ms / (m0 + ms)`.
    pub fn reduced_mass_kg(&self, base_mass_kg: f64) -> f64 {
        base_mass_kg * self.slosh_mass_kg / (base_mass_kg + self.slosh_mass_kg)
    }

    /// `√(ks/μ) / 2π`: the mode of the free spacecraft, not `√(ks/ms)`.
    pub fn natural_frequency_hz(&self, base_mass_kg: f64) -> f64 {
        libm::sqrt(self.stiffness_n_m / self.reduced_mass_kg(base_mass_kg)) / (2.0 * core::f64::consts::PI)
    }

    /// `cs / (2 √(ks μ))`.
    pub fn damping_ratio(&self, base_mass_kg: f64) -> f64 {
        self.damping_n_s_m / (2.0 * libm::sqrt(self.stiffness_n_m * self.reduced_mass_kg(base_mass_kg)))
    }
}

/// Accelerations of base and slosh mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SloshAccelerations {
    /// Of the base against inertial space.
    pub base_m_s2: f64,
    /// Of the slosh mass against the base.
    pub relative_m_s2: f64,
}

impl SloshParameters {
    /// `ẍ0 = (f + ks r + cs ṙ)/m0`, `r̈ = −f/m0 − (ks r + cs ṙ)/μ` (BP2, Eqs. 12–13) under a force
    /// on the base.
    pub fn accelerations(&self, base_mass_kg: f64, state: &SloshState, force_n: f64) -> SloshAccelerations {
        let pull_n = self.stiffness_n_m * state.displacement_m + self.damping_n_s_m * state.velocity_m_s;
        SloshAccelerations {
            base_m_s2: (force_n + pull_n) / base_mass_kg,
            relative_m_s2: -force_n / base_mass_kg - pull_n / self.reduced_mass_kg(base_mass_kg),
        }
    }
}

/// Displacement and velocity of the slosh mass relative to the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshState {
    pub displacement_m: f64,
    pub velocity_m_s: f64,
}

/// Force over an interval by its zeroth and first moment: `∫f dt` and `∫f (t − t_mid) dt`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceMoments {
    pub impulse_n_s: f64,
    pub first_moment_n_s2: f64,
}

/// `x(t+B) = Φ x(t) + G [impulse, first moment]`, `x = [r, ṙ]`, for the force linear in time with
/// those moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    pub phi: Matrix2<f64>,
    pub gain: Matrix2<f64>,
}

impl Transition {
    /// Exact for any κ, γ, zero and negative included: the exponential of `[r, ṙ, p, q]`,
    /// `−f/m0 = −(p + q t)`.
    pub fn new(kappa: f64, gamma: f64, length_s: f64, base_mass_kg: f64) -> Self {
        let (k, g) = (kappa * length_s * length_s, gamma * length_s);
        // Time in units of the block: every entry is free of units and the norm is max(κB², γB).
        let mut generator = SMatrix::<f64, 4, 4>::zeros();
        generator[(0, 1)] = 1.0;
        generator[(1, 0)] = -k;
        generator[(1, 1)] = -g;
        generator[(1, 2)] = -1.0;
        generator[(2, 3)] = 1.0;
        let e = matrix_exponential(generator);
        unscale(&e.fixed_view::<2, 2>(0, 0).into(), &e.fixed_view::<2, 2>(0, 2).into(), length_s, base_mass_kg)
    }

    /// The state at the end of the block.
    pub fn apply(&self, state: &Vector2<f64>, force: &Vector2<f64>) -> Vector2<f64> {
        self.phi * state + self.gain * force
    }
}

/// Impulse response `s` of the mode (`s̈ + γ ṡ + κ s = 0`, `s(0) = 0`, `ṡ(0) = 1`), or its
/// derivative by κ or γ, at one length: `s`, its derivatives by time, `S1 = ∫s`, `S2 = ∫∫s`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Response {
    derivatives: [f64; RESPONSE_ORDER + 1],
    first_integral: f64,
    second_integral: f64,
}

/// `s`, `ṡ`, `S1`, `S2` at a neighbouring length.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ResponseAt {
    s: f64,
    s_dot: f64,
    s1: f64,
    s2: f64,
}

/// Order of the Taylor series of `s`.
const RESPONSE_ORDER: usize = 5;

impl Response {
    /// Read from a transition of `length_s`: `Φ = [ṡ + γ s, s; −κ s, ṡ]`, and the force `p + q t`
    /// moves the state by `−[S1 p + S2 q, s p + S1 q]/m0`. The n-th derivative is
    /// `−γ s⁽ⁿ⁻¹⁾ − κ s⁽ⁿ⁻²⁾ − drive(n)`.
    fn of(at: &Transition, point: &Mode, drive: impl Fn(usize) -> f64) -> Self {
        let mut derivatives = [0.0; RESPONSE_ORDER + 1];
        (derivatives[0], derivatives[1]) = (at.phi[(0, 1)], at.phi[(1, 1)]);
        for n in 2..=RESPONSE_ORDER {
            derivatives[n] = -point.gamma * derivatives[n - 1] - point.kappa * derivatives[n - 2] - drive(n);
        }
        // Back from [impulse, first moment] to [p, q]: I0 = p B + q B²/2, I1 = q B³/12.
        let (b, m_0) = (point.length_s, point.base_mass_kg);
        let by_q = at.gain * Vector2::new(b * b / 2.0, b * b * b / 12.0);
        Self { derivatives, first_integral: -at.gain[(0, 0)] * b * m_0, second_integral: -by_q[0] * m_0 }
    }

    #[inline]
    fn at(&self, t: f64) -> ResponseAt {
        let [d0, d1, d2, d3, d4, d5] = self.derivatives;
        let (i1, i2) = (self.first_integral, self.second_integral);
        ResponseAt {
            s: d0 + t * (d1 + t / 2.0 * (d2 + t / 3.0 * (d3 + t / 4.0 * (d4 + t / 5.0 * d5)))),
            s_dot: d1 + t * (d2 + t / 2.0 * (d3 + t / 3.0 * (d4 + t / 4.0 * d5))),
            s1: i1 + t * (d0 + t / 2.0 * (d1 + t / 3.0 * (d2 + t / 4.0 * (d3 + t / 5.0 * (d4 + t / 6.0 * d5))))),
            s2: i2 + t * (i1 + t / 2.0 * (d0 + t / 3.0 * (d1 + t / 4.0 * (d2 + t / 5.0 * (d3 + t / 6.0 * d4))))),
        }
    }
}

impl ResponseAt {
    /// `p = I0/B − 6 I1/B²`, `q = 12 I1/B³`.
    #[inline]
    fn gain(&self, length_s: f64, base_mass_kg: f64) -> Matrix2<f64> {
        let inverse = 1.0 / length_s;
        let (per_impulse, per_moment) = (-inverse / base_mass_kg, inverse * inverse / base_mass_kg);
        Matrix2::new(
            self.s1 * per_impulse,
            per_moment * (6.0 * self.s1 - 12.0 * inverse * self.s2),
            self.s * per_impulse,
            per_moment * (6.0 * self.s - 12.0 * inverse * self.s1),
        )
    }
}

/// A mode and the length its responses were computed for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mode {
    kappa: f64,
    gamma: f64,
    length_s: f64,
    base_mass_kg: f64,
}

impl Mode {
    /// Where the series is taken for a length: within `reach` of ω δ and γ δ.
    #[inline]
    fn offset(&self, length_s: f64, reach: f64) -> Option<f64> {
        let delta = length_s - self.length_s;
        (delta * delta * self.kappa.abs() <= reach * reach && delta.abs() * self.gamma.abs() <= reach).then_some(delta)
    }
}

/// [`Transition`] of one length, from which those of nearly the same length follow without an
/// exponential.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NeighbouringTransitions {
    mode: Mode,
    response: Response,
}

impl NeighbouringTransitions {
    /// Truncation below 0.5⁵/5! = 3e-4 of ṡ at the very end of the reach: good for a search.
    const SEARCH_REACH: f64 = 0.5;

    /// About the transition `at` of `length_s` \[s\]; `kappa` [1/s²] and `gamma` [1/s] are
    /// stiffness and damping of the relative motion over its mass.
    pub fn new(at: &Transition, kappa: f64, gamma: f64, length_s: f64, base_mass_kg: f64) -> Self {
        let mode = Mode { kappa, gamma, length_s, base_mass_kg };
        Self { mode, response: Response::of(at, &mode, |_| 0.0) }
    }

    /// The transition of `length_s`; `None` out of the reach of the series.
    #[inline]
    pub fn at(&self, length_s: f64) -> Option<Transition> {
        let Mode { kappa, gamma, base_mass_kg, .. } = self.mode;
        let at = self.response.at(self.mode.offset(length_s, Self::SEARCH_REACH)?);
        let phi = Matrix2::new(at.s_dot + gamma * at.s, at.s, -kappa * at.s, at.s_dot);
        Some(Transition { phi, gain: at.gain(length_s, base_mass_kg) })
    }
}

/// The same for [`TransitionWithSensitivity`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NeighbouringSensitivities {
    mode: Mode,
    response: Response,
    by_kappa: Response,
    by_gamma: Response,
}

impl NeighbouringSensitivities {
    /// Truncation below 0.03⁵/5! = 2e-10 of ṡ: hidden by any noise.
    const LIKELIHOOD_REACH: f64 = 0.03;

    /// As [`NeighbouringTransitions::new`], with derivatives by `kappa` and `gamma`.
    pub fn new(at: &TransitionWithSensitivity, kappa: f64, gamma: f64, length_s: f64, base_mass_kg: f64) -> Self {
        let mode = Mode { kappa, gamma, length_s, base_mass_kg };
        let response = Response::of(&at.value, &mode, |_| 0.0);
        // s̈ = −γ ṡ − κ s differentiated by κ and by γ.
        let by_kappa = Response::of(&at.by_kappa, &mode, |n| response.derivatives[n - 2]);
        let by_gamma = Response::of(&at.by_gamma, &mode, |n| response.derivatives[n - 1]);
        Self { mode, response, by_kappa, by_gamma }
    }

    /// The transition of `length_s`; `None` out of the reach of the series.
    pub fn at(&self, length_s: f64) -> Option<TransitionWithSensitivity> {
        let Mode { kappa, gamma, base_mass_kg, .. } = self.mode;
        let delta = self.mode.offset(length_s, Self::LIKELIHOOD_REACH)?;
        let (at, z, y) = (self.response.at(delta), self.by_kappa.at(delta), self.by_gamma.at(delta));
        let transition = |of: &ResponseAt, phi| Transition { phi, gain: of.gain(length_s, base_mass_kg) };
        Some(TransitionWithSensitivity {
            value: transition(&at, Matrix2::new(at.s_dot + gamma * at.s, at.s, -kappa * at.s, at.s_dot)),
            by_kappa: transition(&z, Matrix2::new(z.s_dot + gamma * z.s, z.s, -at.s - kappa * z.s, z.s_dot)),
            by_gamma: transition(&y, Matrix2::new(y.s_dot + gamma * y.s + at.s, y.s, -kappa * y.s, y.s_dot)),
        })
    }
}

/// [`Transition`] and its derivatives with respect to κ and γ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TransitionWithSensitivity {
    pub value: Transition,
    pub by_kappa: Transition,
    pub by_gamma: Transition,
}

impl TransitionWithSensitivity {
    /// The state augmented by its own derivatives obeys a linear equation too; one exponential (8 ×
    /// 8) gives all.
    pub fn new(kappa: f64, gamma: f64, length_s: f64, base_mass_kg: f64) -> Self {
        let (k, g) = (kappa * length_s * length_s, gamma * length_s);
        let mut generator = SMatrix::<f64, 8, 8>::zeros();
        for block in [0, 2, 4] {
            generator[(block, block + 1)] = 1.0;
            generator[(block + 1, block)] = -k;
            generator[(block + 1, block + 1)] = -g;
        }
        generator[(1, 6)] = -1.0;
        generator[(6, 7)] = 1.0;
        generator[(3, 0)] = -1.0; // ∂/∂κ of −κ r
        generator[(5, 1)] = -1.0; // ∂/∂γ of −γ ṙ
        let e = matrix_exponential(generator);
        let part = |row: usize| {
            let (phi, force) = (e.fixed_view::<2, 2>(row, 0).into(), e.fixed_view::<2, 2>(row, 6).into());
            unscale(&phi, &force, length_s, base_mass_kg)
        };
        let (mut by_kappa, mut by_gamma) = (part(2), part(4));
        by_kappa.phi *= length_s * length_s;
        by_kappa.gain *= length_s * length_s;
        by_gamma.phi *= length_s;
        by_gamma.gain *= length_s;
        Self { value: part(0), by_kappa, by_gamma }
    }
}

/// From block time and `[p, q]` back to seconds and `[impulse, first moment]`:
/// `p = (I0/B − 6 I1/B²)/m0`, `q = 12 I1/(B³ m0)`.
fn unscale(phi: &Matrix2<f64>, force: &Matrix2<f64>, b: f64, base_mass_kg: f64) -> Transition {
    let phi = Matrix2::new(phi[(0, 0)], phi[(0, 1)] * b, phi[(1, 0)] / b, phi[(1, 1)]);
    // Columns of `force` belong to p B² and q B³; rows to r and ṙ B.
    let moments = Matrix2::new(b, -6.0, 0.0, 12.0) / base_mass_kg;
    let scaled = force * moments;
    Transition { phi, gain: Matrix2::new(scaled[(0, 0)], scaled[(0, 1)], scaled[(1, 0)] / b, scaled[(1, 1)] / b) }
}

/// Free run of the model: the supervisor's held-out prediction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshPropagator {
    parameters: SloshParameters,
    base_mass_kg: f64,
    state: SloshState,
}

impl SloshPropagator {
    /// A tank on a craft of `base_mass_kg` \[kg\]; panics unless both masses are positive.
    pub fn new(parameters: SloshParameters, base_mass_kg: f64, state: SloshState) -> Self {
        assert!(base_mass_kg > 0.0);
        assert!(parameters.slosh_mass_kg > 0.0);
        Self { parameters, base_mass_kg, state }
    }

    /// Displacement and rate of the slosh mass relative to the craft.
    pub fn state(&self) -> SloshState {
        self.state
    }

    /// Holds `force_n` for `interval_s`; returns the mean acceleration of the base over it [m/s²].
    pub fn step(&mut self, interval_s: f64, force_n: f64) -> f64 {
        let mu = self.parameters.reduced_mass_kg(self.base_mass_kg);
        let (kappa, gamma) = (self.parameters.stiffness_n_m / mu, self.parameters.damping_n_s_m / mu);
        let transition = Transition::new(kappa, gamma, interval_s, self.base_mass_kg);
        let before = Vector2::new(self.state.displacement_m, self.state.velocity_m_s);
        let after = transition.apply(&before, &Vector2::new(force_n * interval_s, 0.0));
        self.state = SloshState { displacement_m: after[0], velocity_m_s: after[1] };
        let m_s = self.parameters.slosh_mass_kg;
        (force_n - m_s * (after[1] - before[1]) / interval_s) / (self.base_mass_kg + m_s)
    }
}

#[cfg(test)]
pub(crate) mod tests;
