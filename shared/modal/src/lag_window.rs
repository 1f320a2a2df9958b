//! A decay as averaged windowed segments show it.
//!
//! The expected (cross) spectrum of windowed segments of length T is the transform of the
//! correlation times the autocorrelation w(τ/T) of the window (Welch 1967). A decay `e^{λτ}`, τ >
//! 0, which is `1/(iω − λ)` on an endless record, becomes `∫₀^T w(τ/T) e^{(λ − iω)τ} dτ`: its peak
//! is wider by the window. With z = (λ − iω) T the integrals are closed: rectangle `w = 1 − u`,
//! Hann `w = (1 − u)(2 + cos 2πu)/3 + sin(2πu)/2π`, by `A(z) = ∫(1 − u) e^{zu} = (e^z − 1 − z)/z²`
//! and `E(z) = ∫ e^{zu} = (e^z − 1)/z`.

use faer::c64;

/// Below this size the closed forms lose digits, and a series of [`TERMS`] terms does not.
const SERIES_BELOW: f64 = 0.5;
const TERMS: usize = 14;

/// Correlations of the products of a line with its neighbours behind a Hann window, `(2/3)²` and
/// `(1/6)²`; those behind are none.
pub(crate) const HANN_NEIGHBOURS: [f64; 2] = [4.0 / 9.0, 1.0 / 36.0];

/// What the lines were made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LagWindow {
    /// No segments, or segments that hold whole decays.
    None,
    /// Segments of this length \[s\] under Hann windows.
    Hann(f64),
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
    /// The transform of `e^{λτ}` at ω [rad/s], and its derivative by λ.
    pub fn decay(self, pole: c64, omega: f64) -> (c64, c64) {
        let rate = pole - c64::new(0.0, omega);
        match self {
            LagWindow::None => {
                let value = c64::new(-1.0, 0.0) / rate;
                (value, value * value)
            }
            LagWindow::Hann(segment_s) => {
                let (z, turn) = (rate * segment_s, c64::new(0.0, core::f64::consts::TAU));
                let e_z = exp(z);
                let (a, above, below) = (falling(z, e_z), falling(z + turn, e_z), falling(z - turn, e_z));
                let (plus, minus) = (whole(z + turn, e_z), whole(z - turn, e_z));
                // sin x = (e^{ix} − e^{−ix})/2i
                let sine = c64::new(0.0, -0.25 / core::f64::consts::PI);
                let of = |a: c64, above: c64, below: c64, plus: c64, minus: c64| {
                    a * (2.0 / 3.0) + (above + below) * (1.0 / 6.0) + sine * (plus - minus)
                };
                let value = of(a.0, above.0, below.0, plus.0, minus.0);
                let slope = of(a.1, above.1, below.1, plus.1, minus.1);
                (value * segment_s, slope * (segment_s * segment_s))
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
            {
                let (lag, exact) = (LagWindow::Hann(3.0), by_sum(hann, 3.0, pole, omega));
                let (value, slope) = lag.decay(pole, omega);
                // trapezia: (ω T)²/12 n² of the largest
                assert!((value - exact).norm_sqr().sqrt() < 1e-5, "{lag:?} {pole} {omega}: {value} {exact}");
                let step = c64::new(0.0, 1e-5);
                let quotient = (lag.decay(pole + step, omega).0 - lag.decay(pole - step, omega).0) / (step * 2.0);
                assert!(
                    (slope - quotient).norm_sqr().sqrt() < 1e-6 * (1.0 + slope.norm_sqr().sqrt()),
                    "{lag:?}: {slope} {quotient}"
                );
            }
        }
    }
}
