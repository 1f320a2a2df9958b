//! A decay as averaged windowed segments show it.
//!
//! The expected (cross) spectrum of windowed segments of length T is the transform of the
//! correlation times the autocorrelation v(τ/T) of the window (Welch 1967). A decay `e^{λτ}`, τ >
//! 0, which is `1/(iω − λ)` on an endless record, becomes `∫₀^T v(τ/T) e^{(λ − iω)τ} dτ`: its peak
//! is wider by the window.
//!
//! Of the window `w(x) = Σ_j d_j e^{2πi j x}`, 0 < x < 1, d_j = d_{−j}, with z = (λ − iω) T,
//! `A(z) = ∫(1 − u) e^{zu} = (e^z − 1 − z)/z²` and `E(z) = ∫ e^{zu} = (e^z − 1)/z` over 0 < u < 1,
//!
//! `∫ v(u) e^{zu} du = Σ_j d_j² A(z + 2πi j) + c_j E(z + 2πi j)`,
//! `c_j = −i d_j/π Σ_{k ≠ j} d_k/(k − j)`, v(0) = Σ d_j² = 1.

use faer::c64;

/// Below this size the closed forms lose digits, and a series of [`TERMS`] terms does not.
const SERIES_BELOW: f64 = 0.5;
const TERMS: usize = 14;

/// A window of cosines over a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    /// As programs call it.
    pub name: &'static str,
    /// d₀, d₁, … about the middle of the segment: d_j there is (−1)^j times that about its start.
    cosines: &'static [f64],
}

/// Windows under which programs average segments (Harris 1978; flat top ISO 18431-1), the most
/// frequent first.
pub(crate) const WINDOWS: [Window; 4] = [
    Window { name: "Hann", cosines: &[0.5, 0.25] },
    Window { name: "Hamming", cosines: &[0.54, 0.23] },
    Window { name: "Blackman", cosines: &[0.42, 0.25, 0.04] },
    Window { name: "flat-top", cosines: &[0.215_578_95, 0.208_315_79, 0.138_631_579, 0.041_789_473, 0.003_473_684] },
];

impl Window {
    fn reach(self) -> isize {
        self.cosines.len() as isize - 1
    }

    fn power(self) -> f64 {
        self.cosines[0] * self.cosines[0] + 2.0 * self.cosines[1..].iter().map(|d| d * d).sum::<f64>()
    }

    /// Correlations of a line with itself and its neighbours in the transform of one segment, all
    /// of the phase of its middle: `Σ_j d_j d_{j+m} / Σ d_j²`.
    pub fn of_neighbours(self) -> Vec<f64> {
        let d = |j: isize| self.cosines.get(j.unsigned_abs()).copied().unwrap_or(0.0);
        let product = |m: isize| (-self.reach()..=self.reach()).map(|j| d(j) * d(j + m)).sum::<f64>();
        (0..=2 * self.reach()).map(|m| product(m) / self.power()).collect()
    }

    /// The transform of the window so many cells from its peak, about the middle of the segment.
    pub fn transform(self, cells: f64) -> f64 {
        let sinc = |x: f64| {
            let x = core::f64::consts::PI * x;
            if x.abs() < 1e-9 { 1.0 } else { libm::sin(x) / x }
        };
        let of = |j: isize| self.cosines[j.unsigned_abs()] * sinc(cells - j as f64);
        (-self.reach()..=self.reach()).map(of).sum()
    }

    /// j, d_j² and i c_j of every term, v(0) = 1.
    fn terms(self) -> Vec<(f64, f64, f64)> {
        let d = |j: isize| self.cosines[j.unsigned_abs()] * if j % 2 == 0 { 1.0 } else { -1.0 };
        let all = || -self.reach()..=self.reach();
        let others = |j: isize| all().filter(|k| *k != j).map(|k| d(k) / (k - j) as f64).sum::<f64>();
        let term =
            |j: isize| (j as f64, d(j) * d(j) / self.power(), d(j) / core::f64::consts::PI * others(j) / self.power());
        all().map(term).collect()
    }
}

/// What the lines were made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LagWindow {
    /// No segments, or segments that hold whole decays.
    None,
    /// Segments of a length [s] under windows, and the window's terms.
    Segments { window: Window, segment_s: f64, terms: Vec<(f64, f64, f64)> },
}

/// `e^z`.
fn exp(z: c64) -> c64 {
    let (sine, cosine) = libm::sincos(z.im);
    c64::new(cosine, sine) * libm::exp(z.re)
}

/// `Σ_n z^n/(n + k)!` and its derivative.
fn series(z: c64, k: usize) -> (c64, c64) {
    let mut factor = 1.0;
    (2..=k).for_each(|j| factor /= j as f64);
    let (mut value, mut slope, mut power) = (c64::new(factor, 0.0), c64::new(0.0, 0.0), c64::new(1.0, 0.0));
    for n in 1..TERMS {
        factor /= (n + k) as f64;
        slope += power * (n as f64 * factor);
        power *= z;
        value += power * factor;
    }
    (value, slope)
}

/// E(z) and its derivative, `e_z` being `e^z`.
fn whole(z: c64, e_z: c64) -> (c64, c64) {
    if z.norm_sqr() < SERIES_BELOW * SERIES_BELOW {
        return series(z, 1);
    }
    let value = (e_z - 1.0) / z;
    (value, (e_z - value) / z)
}

/// A(z) and its derivative.
fn falling(z: c64, e_z: c64) -> (c64, c64) {
    if z.norm_sqr() < SERIES_BELOW * SERIES_BELOW {
        return series(z, 2);
    }
    let value = (e_z - 1.0 - z) / (z * z);
    (value, ((e_z - 1.0) / z - value * 2.0) / z)
}

impl LagWindow {
    /// Segments of this length \[s\] under a window.
    pub fn of(window: Window, segment_s: f64) -> Self {
        Self::Segments { window, segment_s, terms: window.terms() }
    }

    /// The transform of `e^{λτ}` at ω [rad/s], and its derivative by λ.
    pub fn decay(&self, pole: c64, omega: f64) -> (c64, c64) {
        let rate = pole - c64::new(0.0, omega);
        match self {
            LagWindow::None => {
                let value = c64::new(-1.0, 0.0) / rate;
                (value, value * value)
            }
            LagWindow::Segments { segment_s, terms, .. } => {
                let z = rate * *segment_s;
                let e_z = exp(z);
                let (mut value, mut slope) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
                for (j, square, turned) in terms {
                    let shifted = z + c64::new(0.0, core::f64::consts::TAU * j);
                    let (a, e) = (falling(shifted, e_z), whole(shifted, e_z));
                    let c = c64::new(0.0, -turned);
                    value += a.0 * *square + e.0 * c;
                    slope += a.1 * *square + e.1 * c;
                }
                (value * *segment_s, slope * (segment_s * segment_s))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by 20 000 trapezia.
    fn by_sum(window: impl Fn(f64) -> f64, segment_s: f64, pole: c64, omega: f64) -> c64 {
        const STEPS: usize = 20_000;
        let at = |n: usize| {
            let u = n as f64 / STEPS as f64;
            let half = if n == 0 || n == STEPS { 0.5 } else { 1.0 };
            exp((pole - c64::new(0.0, omega)) * (u * segment_s)) * (half * window(u))
        };
        (0..=STEPS).map(at).fold(c64::new(0.0, 0.0), |sum, x| sum + x) * (segment_s / STEPS as f64)
    }

    #[test]
    fn closed_forms_are_the_integrals_and_slopes_their_difference_quotients() {
        let tau = core::f64::consts::TAU;
        let hann = |u: f64| (1.0 - u) * (2.0 + libm::cos(tau * u)) / 3.0 + libm::sin(tau * u) / tau;
        for (pole, omega) in [
            (c64::new(-0.3, 20.0), 20.1),
            (c64::new(-0.01, 20.0), 20.0),
            (c64::new(-2.0, 20.0), 26.0),
            (c64::new(-0.05, 20.0), -20.0),
        ] {
            let (lag, exact) = (LagWindow::of(WINDOWS[0], 3.0), by_sum(hann, 3.0, pole, omega));
            let (value, slope) = lag.decay(pole, omega);
            // trapezia: (ω T)²/12 n² of the largest
            assert!((value - exact).norm_sqr().sqrt() < 1e-5, "{pole} {omega}: {value} {exact}");
            let step = c64::new(0.0, 1e-5);
            let quotient = (lag.decay(pole + step, omega).0 - lag.decay(pole - step, omega).0) / (step * 2.0);
            assert!(
                (slope - quotient).norm_sqr().sqrt() < 1e-6 * (1.0 + slope.norm_sqr().sqrt()),
                "{slope} {quotient}"
            );
        }
    }

    #[test]
    fn every_window_has_the_autocorrelation_of_its_samples() {
        const STEPS: usize = 2000;
        for window in WINDOWS {
            let w = |n: usize| {
                let cosine = |j: usize| libm::cos(core::f64::consts::TAU * j as f64 * (n as f64 + 0.5) / STEPS as f64);
                let sign = |j: usize| if j.is_multiple_of(2) { 2.0 } else { -2.0 };
                window.cosines[0]
                    + (1..window.cosines.len()).map(|j| sign(j) * window.cosines[j] * cosine(j)).sum::<f64>()
            };
            let power: f64 = (0..STEPS).map(|n| w(n) * w(n)).sum();
            let auto = |u: f64| {
                let lag = libm::round(u * STEPS as f64) as usize;
                (lag..STEPS).map(|n| w(n) * w(n - lag)).sum::<f64>() / power
            };
            let (pole, omega, steps) = (c64::new(-1.0, 20.0), 20.4, 200);
            let at = |n: usize| {
                let u = n as f64 / f64::from(steps);
                let half = if n == 0 || n == steps as usize { 0.5 } else { 1.0 };
                exp((pole - c64::new(0.0, omega)) * (u * 3.0)) * (half * auto(u))
            };
            let sum =
                (0..=steps as usize).map(at).fold(c64::new(0.0, 0.0), |sum, x| sum + x) * (3.0 / f64::from(steps));
            let closed = LagWindow::of(window, 3.0).decay(pole, omega).0;
            // Trapezia of a step of 1/200.
            assert!((closed - sum).norm_sqr().sqrt() < 1e-3, "{}: {closed} {sum}", window.name);
        }
    }
}
