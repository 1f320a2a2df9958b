//! The lines of responses as a separable problem, and the noise that their residuals show.
//!
//! `H_c(s) = Σ_k r_ck/(s − λ_k) + r̄_ck/(s − λ̄_k) + Σ_j ρ_cj s^j`, j = −2 … J, s = iω: the powers
//! are what modes below (s⁻², s⁻¹) and above the lines (1 … s^J) leave within them. The noise of a
//! line is complex normal with variance `2 (a_c + b |H_c|²)`: a floor for every channel, and a part
//! in proportion to the response, as a scatter of the input or few averages give it.

use crate::lag_window::LagWindow;
use crate::residual_correlation::{correlations, lines_of};
use crate::separable::{Columns, Evaluation, leverages};
use faer::c64;

/// Powers of s for the modes outside the lines: of a mode at f₁ above the last line f, what is left
/// is its part times (f/f₁)^(J + 2), as modes have pairs of poles; J may be raised.
const POWERS: std::ops::RangeInclusive<i32> = -2..=4;
/// Twice the gain of the log-likelihood for which the proportional part is kept: the price of one
/// unknown (Akaike 1974).
const PROPORTIONAL_GAIN: f64 = 2.0;
/// Rounds of the regression of the squares.
const LINE_ROUNDS: usize = 12;
/// Least floor, beside the proportional part at the mean square of a channel: antiresonances do not
/// measure better than to a hundredth of the mean.
const FLOOR_SHARE: f64 = 1e-4;
/// Least part of a line's freedom that its residual is read for.
const FREEDOM_MIN: f64 = 0.1;

/// Variances `a_c + b x` of the rows, x the square of the model or what leaks into the line.
#[derive(Clone)]
pub(super) struct Noise {
    /// 1/σ of every row of every channel.
    pub weights: Vec<Vec<f64>>,
    /// a of every channel.
    pub floors: Vec<f64>,
    /// b.
    pub proportion: f64,
}

#[derive(Clone)]
pub(super) struct ResponseLines {
    omega: Vec<f64>,
    /// Per channel: real and imaginary parts in turn.
    outputs: Vec<Vec<f64>>,
    window: LagWindow,
    highest_power: i32,
}

pub(super) fn stacked(values: impl Iterator<Item = c64>) -> Vec<f64> {
    values.flat_map(|x| [x.re, x.im]).collect()
}

impl ResponseLines {
    pub fn new(frequency_hz: &[f64], responses: &[Vec<c64>]) -> Self {
        Self {
            omega: frequency_hz.iter().map(|f| core::f64::consts::TAU * f).collect(),
            outputs: responses.iter().map(|response| stacked(response.iter().copied())).collect(),
            window: LagWindow::None,
            highest_power: *POWERS.end(),
        }
    }

    /// Number of lines.
    pub fn count(&self) -> usize {
        self.omega.len()
    }

    /// First line [rad/s].
    pub fn first(&self) -> f64 {
        self.omega[0]
    }

    /// Last line [rad/s].
    pub fn last(&self) -> f64 {
        self.omega[self.omega.len() - 1]
    }

    /// What so many unknowns have to gain in twice the log-likelihood (Schwarz 1978).
    pub fn price(&self, unknowns: usize) -> f64 {
        unknowns as f64 * libm::log((2 * self.omega.len() * self.outputs.len()) as f64)
    }

    /// Distance of lines [rad/s].
    pub fn cell(&self) -> f64 {
        core::f64::consts::TAU / self.segment_s()
    }

    /// Duration of segments that have these lines \[s\].
    pub fn segment_s(&self) -> f64 {
        let last = self.omega.len() - 1;
        core::f64::consts::TAU * last as f64 / (self.omega[last] - self.omega[0])
    }

    fn is_windowed(&self) -> bool {
        self.window != LagWindow::None
    }

    /// The same lines with two more powers of s.
    pub fn with_more_powers(&self) -> Self {
        Self { highest_power: self.highest_power + 2, ..self.clone() }
    }

    fn powers(&self) -> std::ops::RangeInclusive<i32> {
        *POWERS.start()..=self.highest_power
    }

    /// The same lines, of segments with this window.
    pub fn seen_through(self, window: LagWindow) -> Self {
        Self { window, ..self }
    }

    /// Noise that makes every channel's mean square one.
    pub fn first_noise(&self) -> Noise {
        let mean = |y: &Vec<f64>| (y.iter().map(|x| x * x).sum::<f64>() / y.len() as f64).max(f64::MIN_POSITIVE);
        let floors: Vec<f64> = self.outputs.iter().map(mean).collect();
        let weights = self.outputs.iter().zip(&floors).map(|(y, floor)| vec![1.0 / floor.sqrt(); y.len()]).collect();
        Noise { weights, floors, proportion: 0.0 }
    }

    /// Variance that leakage gives to a response measured under random force, in shares of one
    /// segment: `|W|² ∗ |H|² − ||W|² ∗ H|²`, line by line (Bendat & Piersol 2010, ch. 9: the
    /// incoherent power over that of the input).
    ///
    /// `|H|² = H(s) H(−s)` has the residues `r_k H(−λ_k)`; what the window changes in it is what it
    /// changes in those fractions.
    pub fn leakage(&self, at: &Evaluation, channel: usize) -> Vec<f64> {
        let q = &at.channels[channel].coefficients;
        let residues: Vec<c64> = (0..at.poles.len()).map(|k| c64::new(q[2 * k], q[2 * k + 1])).collect();
        let last = self.omega[self.omega.len() - 1];
        let response = |s: c64| {
            let of = |(pole, r): (&c64, &c64)| r / (s - pole) + r.conj() / (s - pole.conj());
            let powers = self.powers().zip(&q[2 * at.poles.len()..]).map(|(power, q)| (s / last).powi(power) * *q);
            at.poles.iter().zip(&residues).map(of).chain(powers).fold(c64::new(0.0, 0.0), |sum, x| sum + x)
        };
        let of_square: Vec<c64> = at.poles.iter().zip(&residues).map(|(pole, r)| r * response(-pole)).collect();
        let model = lines_of(&at.channels[channel].model, 2);
        let one = |(w, seen): (&f64, &c64)| {
            let change = |pole: &c64, w: f64| self.window.decay(*pole, w).0 - LagWindow::None.decay(*pole, w).0;
            let of = |(pole, q): (&c64, &c64)| 2.0 * (q * (change(pole, *w) + change(pole, -w))).re;
            let widened: f64 = at.poles.iter().zip(&of_square).map(of).sum();
            (response(c64::new(0.0, *w)).norm_sqr() + widened - seen.norm_sqr()).max(0.0)
        };
        self.omega.iter().zip(&model).map(one).collect()
    }

    /// Square of the residual, of the model, and freedom of every line of a channel.
    fn squares(&self, at: &Evaluation, channel: usize, weights: &[f64], leverage: &[f64]) -> Vec<(f64, f64, f64)> {
        let fitted = &at.channels[channel];
        let leakage = self.is_windowed().then(|| self.leakage(at, channel));
        (0..self.omega.len())
            .map(|line| {
                let rows = 2 * line..2 * line + 2;
                let square: f64 = rows.clone().map(|row| (fitted.residual[row] / weights[row]).powi(2)).sum();
                let size: f64 = match &leakage {
                    Some(leakage) => leakage[line],
                    None => fitted.model[rows.clone()].iter().map(|x| x * x).sum(),
                };
                let freedom: f64 = rows.map(|row| 1.0 - leverage[row]).sum();
                (square, size, if freedom > FREEDOM_MIN { freedom } else { 0.0 })
            })
            .collect()
    }
}

/// Floors `a_c` and the proportional part `b` of squares `t` with expectation
/// `freedom · (a_c + b x)`: the regression of maximum likelihood, weighted with the variance it
/// finds.
fn floors(squares: &[Vec<(f64, f64, f64)>], proportional: bool) -> (Vec<f64>, f64) {
    let sums = |of: fn(&(f64, f64, f64)) -> f64| -> Vec<f64> {
        squares.iter().map(|lines| lines.iter().filter(|l| l.2 > 0.0).map(of).sum::<f64>()).collect()
    };
    let freedom = sums(|l| l.2);
    let mut a: Vec<f64> = sums(|l| l.0).iter().zip(&freedom).map(|(t, f)| t / f.max(f64::MIN_POSITIVE)).collect();
    let size: Vec<f64> = sums(|l| l.1).iter().zip(squares).map(|(x, lines)| x / lines.len() as f64).collect();
    let mut b = 0.0;
    if !proportional {
        return (a, b);
    }
    for _ in 0..LINE_ROUNDS {
        let (mut above, mut below) = (0.0, 0.0);
        let mut of_channels = Vec::new();
        for (lines, a) in squares.iter().zip(&a) {
            let mut s = [0.0; 5];
            for (t, x, f) in lines.iter().filter(|l| l.2 > 0.0) {
                let v = a + b * x;
                let w = f / (v * v).max(f64::MIN_POSITIVE);
                let t = t / f;
                for (s, part) in s.iter_mut().zip([w, w * x, w * x * x, w * t, w * x * t]) {
                    *s += part;
                }
            }
            above += s[4] - s[1] * s[3] / s[0];
            below += s[2] - s[1] * s[1] / s[0];
            of_channels.push(s);
        }
        b = if below > 0.0 { (above / below).max(0.0) } else { 0.0 };
        for ((a, s), size) in a.iter_mut().zip(&of_channels).zip(&size) {
            *a = ((s[3] - b * s[1]) / s[0]).max(FLOOR_SHARE * b * size);
        }
    }
    (a, b)
}

/// Twice the negative log-likelihood of the squares.
fn cost(squares: &[Vec<(f64, f64, f64)>], (a, b): &(Vec<f64>, f64)) -> f64 {
    let of = |(lines, a): (&Vec<(f64, f64, f64)>, &f64)| -> f64 {
        let one = |(t, x, f): &(f64, f64, f64)| {
            let v = (a + b * x).max(f64::MIN_POSITIVE);
            f * libm::log(v) + t / v
        };
        lines.iter().filter(|l| l.2 > 0.0).map(one).sum()
    };
    squares.iter().zip(a).map(of).sum()
}

impl ResponseLines {
    /// The lines, channel by channel, real and imaginary parts in turn.
    pub fn outputs(&self) -> &[Vec<f64>] {
        &self.outputs
    }

    /// Columns of the model at some poles.
    pub fn columns(&self, poles: &[c64]) -> Columns {
        let last = self.omega[self.omega.len() - 1];
        let mut columns = Columns { of_poles: Vec::new(), slopes: Vec::new(), fixed: Vec::new() };
        let i = c64::new(0.0, 1.0);
        for pole in poles {
            let at = |w: &f64| (self.window.decay(*pole, *w), self.window.decay(pole.conj(), *w));
            let both: Vec<((c64, c64), (c64, c64))> = self.omega.iter().map(at).collect();
            columns.of_poles.push(stacked(both.iter().map(|(g, h)| g.0 + h.0)));
            columns.of_poles.push(stacked(both.iter().map(|(g, h)| i * (g.0 - h.0))));
            columns.slopes.push(stacked(both.iter().map(|(g, h)| g.1 + h.1)));
            columns.slopes.push(stacked(both.iter().map(|(g, h)| i * (g.1 - h.1))));
        }
        for power in self.powers() {
            let at = |w: &f64| {
                let size = libm::pow(w / last, f64::from(power));
                match power.rem_euclid(4) {
                    0 => c64::new(size, 0.0),
                    1 => c64::new(0.0, size),
                    2 => c64::new(-size, 0.0),
                    _ => c64::new(0.0, -size),
                }
            };
            columns.fixed.push(stacked(self.omega.iter().map(at)));
        }
        columns
    }

    /// The noise that the residuals of a fit with the weights `held` show.
    pub fn noise(&self, at: &Evaluation, held: &[Vec<f64>]) -> Noise {
        let leverages = leverages(at, held);
        let squares: Vec<_> = (0..held.len()).map(|c| self.squares(at, c, &held[c], &leverages[c])).collect();
        let plain = floors(&squares, false);
        let proportional = floors(&squares, true);
        let noise = if cost(&squares, &plain) - cost(&squares, &proportional) > PROPORTIONAL_GAIN {
            proportional
        } else {
            plain
        };
        let of_channel = |c: usize| -> Vec<f64> {
            let weight = |x: &(f64, f64, f64)| {
                let variance = noise.0[c] + noise.1 * x.1;
                [1.0 / variance.max(f64::MIN_POSITIVE).sqrt(); 2]
            };
            squares[c].iter().flat_map(weight).collect()
        };
        Noise { weights: (0..held.len()).map(of_channel).collect(), floors: noise.0, proportion: noise.1 }
    }

    /// Of the normalised residuals of neighbouring lines.
    pub fn correlations(&self, at: &Evaluation) -> Vec<c64> {
        correlations(&at.channels.iter().map(|channel| lines_of(&channel.residual, 2)).collect::<Vec<_>>())
    }
}
