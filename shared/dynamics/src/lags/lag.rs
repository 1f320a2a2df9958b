//! Lags of first and second order, advanced by their closed forms.
//!
//! With the input held at u, the deviation `e = y − u` decays freely: first order `e' = −e/τ`,
//! second order `e'' = −2ζω e' − ω² e`. An input on a straight line of slope s only moves the
//! target: the output settles τ s (first order) or `2ζ s/ω` (second order) behind it, and the
//! deviation from there decays in the same way.

use super::FilterKind;
use core::f64::consts::TAU;
use serde::{Deserialize, Serialize};

/// State of a lag: its output and the output's rate (second order alone uses the rate).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LagState {
    pub output: f64,
    pub rate: f64,
}

impl LagState {
    /// At rest at `output`.
    pub const fn settled(output: f64) -> Self {
        Self { output, rate: 0.0 }
    }
}

/// A lag of first or second order; the others of [`FilterKind`] pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    kind: FilterKind,
}

impl Lag {
    /// The lag of `kind`; `None` for no filter and for a delay.
    pub fn new(kind: FilterKind) -> Option<Self> {
        let lags = match kind {
            FilterKind::None
            | FilterKind::Delay { .. }
            | FilterKind::MinimumImpulse { .. }
            | FilterKind::Stuck { .. } => false,
            FilterKind::FirstOrder { time_constant_s } => time_constant_s > 0.0,
            FilterKind::Asymmetric { rise_s, fall_s } => rise_s > 0.0 || fall_s > 0.0,
            FilterKind::SecondOrder { frequency_hz, .. } => frequency_hz > 0.0 && frequency_hz.is_finite(),
        };
        lags.then_some(Self { kind })
    }

    /// Lag of a first-order low-pass with this cut-off.
    pub fn low_pass(cut_off_hz: f64) -> Option<Self> {
        Self::new(FilterKind::FirstOrder { time_constant_s: 1.0 / (TAU * cut_off_hz) })
    }

    /// Advances by `h_s` with the input held at `input`; returns the mean of the output over the
    /// interval.
    pub fn hold(&self, state: &mut LagState, input: f64, h_s: f64) -> f64 {
        assert!(h_s > 0.0);
        match self.kind {
            FilterKind::FirstOrder { time_constant_s } => first_order(state, input, time_constant_s, h_s),
            FilterKind::Asymmetric { rise_s, fall_s } => asymmetric(state, input, rise_s, fall_s, h_s),
            FilterKind::SecondOrder { frequency_hz, damping_ratio } => {
                let omega = TAU * frequency_hz;
                let e = [state.output - input, state.rate];
                let next = decay(e, omega, damping_ratio, h_s);
                *state = LagState { output: input + next[0], rate: next[1] };
                // ω² ∫e = −[e' + 2ζω e]
                let integral = -((next[1] - e[1]) + 2.0 * damping_ratio * omega * (next[0] - e[0])) / (omega * omega);
                input + integral / h_s
            }
            _ => input,
        }
    }

    /// Advances a first-order lag by `h_s` with the input on the parabola through `from`, `middle`
    /// and `to`; returns the output at the end.
    ///
    /// `τ x' + x = y` has the particular solution `y − τ y' + τ² y''`, from which the deviation
    /// decays. The others take the line.
    pub fn arc(&self, state: &mut LagState, [from, middle, to]: [f64; 3], h_s: f64) -> f64 {
        assert!(h_s > 0.0);
        let FilterKind::FirstOrder { time_constant_s: tau } = self.kind else { return self.ramp(state, from, to, h_s) };
        let slope = (3.0 * to - 4.0 * middle + from) / h_s;
        let curvature = 4.0 * (from - 2.0 * middle + to) / (h_s * h_s);
        let past = from - tau * (slope - curvature * h_s) + tau * tau * curvature;
        let present = to - tau * slope + tau * tau * curvature;
        state.output = present + (state.output - past) * libm::exp(-h_s / tau);
        state.output
    }

    /// Advances by `h_s` with the input on a straight line `from → to`; returns the output at the
    /// end.
    ///
    /// The asymmetric lag takes the line's mean as held.
    pub fn ramp(&self, state: &mut LagState, from: f64, to: f64, h_s: f64) -> f64 {
        assert!(h_s > 0.0);
        let slope = (to - from) / h_s;
        match self.kind {
            FilterKind::FirstOrder { time_constant_s } => {
                let behind = slope * time_constant_s;
                let e = state.output - (from - behind);
                state.output = to - behind + e * libm::exp(-h_s / time_constant_s);
            }
            FilterKind::Asymmetric { .. } => {
                self.hold(state, 0.5 * (from + to), h_s);
            }
            FilterKind::SecondOrder { frequency_hz, damping_ratio } => {
                let omega = TAU * frequency_hz;
                let behind = 2.0 * damping_ratio / omega * slope;
                let e = decay([state.output - (from - behind), state.rate - slope], omega, damping_ratio, h_s);
                *state = LagState { output: to - behind + e[0], rate: slope + e[1] };
            }
            _ => state.output = to,
        }
        state.output
    }
}

/// Held first order; returns the mean. `τ = 0` follows at once.
fn first_order(state: &mut LagState, input: f64, tau_s: f64, h_s: f64) -> f64 {
    let e = state.output - input;
    let fallen = -libm::expm1(-h_s / tau_s); // 1 − e^{−h/τ}
    state.output = input + e * (1.0 - fallen);
    input + e * fallen * tau_s / h_s
}

/// Held first order whose time constant depends on whether the magnitude grows; through zero it
/// first falls, then rises.
fn asymmetric(state: &mut LagState, input: f64, rise_s: f64, fall_s: f64, h_s: f64) -> f64 {
    let y = state.output;
    if y * input >= 0.0 {
        let tau_s = if input.abs() > y.abs() { rise_s } else { fall_s };
        return first_order(state, input, tau_s, h_s);
    }
    let to_zero_s = fall_s * libm::log((y - input) / -input);
    if to_zero_s >= h_s {
        return first_order(state, input, fall_s, h_s);
    }
    let falling = if to_zero_s > 0.0 { to_zero_s * first_order(state, input, fall_s, to_zero_s) } else { 0.0 };
    state.output = 0.0;
    let rest_s = h_s - to_zero_s;
    (falling + rest_s * first_order(state, input, rise_s, rest_s)) / h_s
}

/// Free decay of `e'' + 2ζω e' + ω² e = 0` over `h_s`, from and to `(e, e')`.
fn decay(e: [f64; 2], omega: f64, zeta: f64, h_s: f64) -> [f64; 2] {
    let s = zeta * omega;
    let square = omega * omega * (1.0 - zeta * zeta);
    let tiny = 1e-12 * omega * omega;
    // even = e^{−sh} cos dh, odd = e^{−sh} sin(dh)/d, or their hyperbolic counterparts from two
    // exponentials that cannot overflow
    let (even, odd) = if square > tiny {
        let d = square.sqrt();
        let (sin, cos) = libm::sincos(d * h_s);
        let envelope = libm::exp(-s * h_s);
        (envelope * cos, envelope * sin / d)
    } else if square < -tiny {
        let d = (-square).sqrt();
        let (fast, slow) = (libm::exp(-(s + d) * h_s), libm::exp(-omega * omega / (s + d) * h_s));
        (0.5 * (slow + fast), 0.5 * (slow - fast) / d)
    } else {
        let envelope = libm::exp(-s * h_s);
        (envelope, envelope * h_s)
    };
    [(even + s * odd) * e[0] + odd * e[1], -omega * omega * odd * e[0] + (even - s * odd) * e[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lag(kind: FilterKind) -> Lag {
        Lag::new(kind).unwrap()
    }

    const SECOND: [FilterKind; 4] = [
        FilterKind::SecondOrder { frequency_hz: 2.0, damping_ratio: 0.3 },
        FilterKind::SecondOrder { frequency_hz: 2.0, damping_ratio: 1.0 },
        FilterKind::SecondOrder { frequency_hz: 2.0, damping_ratio: 2.5 },
        FilterKind::SecondOrder { frequency_hz: 2.0, damping_ratio: 0.0 },
    ];

    #[test]
    fn a_step_through_first_order_is_the_exponential_and_its_mean_the_integral() {
        for (tau, h) in [(0.05, 0.01), (1e-4, 0.01), (10.0, 1e-3)] {
            let (filter, mut state) = (lag(FilterKind::FirstOrder { time_constant_s: tau }), LagState::default());
            let mean = filter.hold(&mut state, 2.0, h);
            // rounding; the mean of a slow lag is a difference near 2: one ε of 2
            assert!((state.output - 2.0 * (1.0 - (-h / tau).exp())).abs() < 1e-15);
            assert!((mean - 2.0 * (1.0 - tau / h * -(-h / tau).exp_m1())).abs() < 1e-15);
        }
    }

    #[test]
    fn a_lag_behind_a_parabola_does_not_care_how_the_interval_is_divided_and_a_line_is_one_of_them() {
        let input = |t: f64| 0.4 - 1.3 * t + 7.0 * t * t;
        for tau in [1e-4, 0.03, 2.0] {
            let filter = lag(FilterKind::FirstOrder { time_constant_s: tau });
            let (mut whole, mut split) = (LagState::settled(-0.2), LagState::settled(-0.2));
            filter.arc(&mut whole, [0.0, 0.1, 0.2].map(input), 0.2);
            for k in 0..8 {
                let begin = 0.025 * f64::from(k);
                filter.arc(&mut split, [begin, begin + 0.0125, begin + 0.025].map(input), 0.025);
            }
            // rounding of second differences, 4 ε τ² / h² of numbers near 1
            let rounding = 1e-13 * (1.0 + tau * tau / 0.025 / 0.025);
            assert!((whole.output - split.output).abs() < rounding, "{tau}: {} {}", whole.output, split.output);
            let (mut arc, mut line) = (LagState::settled(-0.2), LagState::settled(-0.2));
            assert!((filter.arc(&mut arc, [1.0, 2.0, 3.0], 0.2) - filter.ramp(&mut line, 1.0, 3.0, 0.2)).abs() < 1e-13);
        }
    }

    #[test]
    fn splitting_an_interval_changes_neither_the_end_nor_the_mean() {
        let kinds =
            [FilterKind::FirstOrder { time_constant_s: 0.07 }, FilterKind::Asymmetric { rise_s: 0.03, fall_s: 0.2 }];
        for kind in kinds.into_iter().chain(SECOND) {
            for (from, input) in [(0.0, 1.0), (2.0, 0.5), (-1.0, 0.4)] {
                let (mut whole, mut split) = (LagState::settled(from), LagState::settled(from));
                let mean = lag(kind).hold(&mut whole, input, 0.3);
                let parts = lag(kind).hold(&mut split, input, 0.1) * 0.1 + lag(kind).hold(&mut split, input, 0.2) * 0.2;
                assert!((whole.output - split.output).abs() < 1e-14, "{kind:?}");
                assert!((whole.rate - split.rate).abs() < 1e-13, "{kind:?}");
                assert!((mean - parts / 0.3).abs() < 1e-13, "{kind:?}: {mean} {}", parts / 0.3);
            }
        }
    }

    #[test]
    fn second_order_follows_its_differential_equation() {
        for kind in SECOND {
            let FilterKind::SecondOrder { frequency_hz, damping_ratio } = kind else { unreachable!() };
            let omega = TAU * frequency_hz;
            let (filter, mut state, h) = (lag(kind), LagState { output: 0.4, rate: -1.0 }, 1e-4);
            for _ in 0..2000 {
                let before = state;
                filter.hold(&mut state, 1.5, h);
                // trapezoid over the step: h³/12 times ω⁴ · 2
                let acceleration =
                    |s: LagState| omega * omega * (1.5 - s.output) - 2.0 * damping_ratio * omega * s.rate;
                let rate = before.rate + 0.5 * h * (acceleration(before) + acceleration(state));
                assert!((state.rate - rate).abs() < 1e-12 / 12.0 * omega.powi(4) * 200.0, "{kind:?}");
            }
        }
    }

    #[test]
    fn a_ramp_settles_its_lag_behind_the_input() {
        let cases = [(FilterKind::FirstOrder { time_constant_s: 0.05 }, 0.05), (SECOND[0], 0.6 / (TAU * 2.0))];
        for (kind, behind_s) in cases {
            let (filter, mut state) = (lag(kind), LagState::default());
            for step in 0..1000 {
                filter.ramp(&mut state, 3.0 * 0.01 * f64::from(step), 3.0 * 0.01 * f64::from(step + 1), 0.01);
            }
            assert!((state.output - 3.0 * (10.0 - behind_s)).abs() < 1e-12, "{kind:?}"); // rounding of 1000 steps
        }
    }

    #[test]
    fn a_ramp_is_the_limit_of_many_held_steps() {
        for kind in [FilterKind::FirstOrder { time_constant_s: 0.05 }, SECOND[0], SECOND[2]] {
            let (filter, mut ramp, mut stairs) = (lag(kind), LagState::settled(0.3), LagState::settled(0.3));
            filter.ramp(&mut ramp, 1.0, 2.0, 0.2);
            let n = 20_000;
            for k in 0..n {
                filter.hold(&mut stairs, 1.0 + (f64::from(k) + 0.5) / f64::from(n), 0.2 / f64::from(n));
            }
            // mid-point stairs: error of order (h ω)² with h = 1e-5 s
            assert!((ramp.output - stairs.output).abs() < 1e-8, "{kind:?}");
        }
    }

    #[test]
    fn a_valve_opens_and_closes_with_its_own_time_constants() {
        let (filter, mut state) = (lag(FilterKind::Asymmetric { rise_s: 0.01, fall_s: 0.1 }), LagState::default());
        filter.hold(&mut state, 1.0, 0.01);
        assert!((state.output - (1.0 - (-1.0f64).exp())).abs() < 1e-15);
        state = LagState::settled(1.0);
        filter.hold(&mut state, 0.0, 0.1);
        assert!((state.output - (-1.0f64).exp()).abs() < 1e-15);
        // through zero: e^{−t/0.1}·2 − 1 = 0 after 0.1 ln 2, then it rises
        state = LagState::settled(1.0);
        filter.hold(&mut state, -1.0, 0.1 * 2.0f64.ln() + 0.01);
        assert!((state.output + 1.0 - (-1.0f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn filters_that_do_nothing_are_none() {
        for kind in [
            FilterKind::None,
            FilterKind::Delay { delay_s: 1.0 },
            FilterKind::FirstOrder { time_constant_s: 0.0 },
            FilterKind::Asymmetric { rise_s: 0.0, fall_s: 0.0 },
        ] {
            assert!(Lag::new(kind).is_none());
        }
    }
}
