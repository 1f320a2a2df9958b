//! Dual numbers: a value and its derivative in one direction, carried through every operation
//! (forward mode).
//!
//! `f(a + b ε) = f(a) + f′(a) b ε`, `ε² = 0` (Griewank & Walther, Evaluating Derivatives, ch. 3):
//! exact to rounding, no step to choose. One pass gives one column of a Jacobian.
//!
//! Why not a crate: the published ones take sin, exp and powf from std, whose last bits are the
//! platform's; here the value part must have the very bits that the plain program has from libm, or
//! a filter would linearise about another state than it is in.

use crate::real::Real;
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use num_traits::{One, Zero};

/// `value + derivative ε`. Equality and order look at the value alone, as the branches of the plain
/// program would.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dual {
    pub value: f64,
    pub derivative: f64,
}

impl Dual {
    /// A number with its derivative.
    #[inline]
    pub const fn new(value: f64, derivative: f64) -> Self {
        Self { value, derivative }
    }

    /// The variable of the differentiation: derivative one.
    #[inline]
    pub const fn variable(value: f64) -> Self {
        Self { value, derivative: 1.0 }
    }

    /// `f` of this number, from `f(value)` and `f′(value)`.
    #[inline]
    const fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, derivative: slope * self.derivative }
    }
}

impl PartialEq for Dual {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Dual {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self::new(self.value + b.value, self.derivative + b.derivative)
    }
}

impl Sub for Dual {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Self::new(self.value - b.value, self.derivative - b.derivative)
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        Self::new(self.value * b.value, self.derivative * b.value + self.value * b.derivative)
    }
}

impl Div for Dual {
    type Output = Self;
    #[inline]
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self::new(value, (self.derivative - value * b.derivative) / b.value)
    }
}

impl Neg for Dual {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.value, -self.derivative)
    }
}

impl AddAssign for Dual {
    #[inline]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl SubAssign for Dual {
    #[inline]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl MulAssign for Dual {
    #[inline]
    fn mul_assign(&mut self, b: Self) {
        *self = *self * b;
    }
}

impl DivAssign for Dual {
    #[inline]
    fn div_assign(&mut self, b: Self) {
        *self = *self / b;
    }
}

impl Zero for Dual {
    #[inline]
    fn zero() -> Self {
        Self::new(0.0, 0.0)
    }

    /// Neither value nor derivative: a zero that is moving is not zero.
    #[inline]
    fn is_zero(&self) -> bool {
        self.value == 0.0 && self.derivative == 0.0
    }
}

impl One for Dual {
    #[inline]
    fn one() -> Self {
        Self::new(1.0, 0.0)
    }
}

impl Real for Dual {
    #[inline]
    fn constant(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    #[inline]
    fn value(self) -> f64 {
        self.value
    }

    #[inline]
    fn scale(self, factor: f64) -> Self {
        Self::new(self.value * factor, self.derivative * factor)
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.value);
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline]
    fn tanh(self) -> Self {
        let tanh = libm::tanh(self.value);
        self.chain(tanh, (1.0 - tanh) * (1.0 + tanh))
    }

    #[inline]
    fn exp(self) -> Self {
        let exp = libm::exp(self.value);
        self.chain(exp, exp)
    }

    #[inline]
    fn ln(self) -> Self {
        self.chain(libm::log(self.value), 1.0 / self.value)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        let square = self.value * self.value + x.value * x.value;
        Self::new(libm::atan2(self.value, x.value), (x.value * self.derivative - self.value * x.derivative) / square)
    }

    #[inline]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        if exponent == 0 {
            return Self::one();
        }
        self.chain(Real::powi(self.value, exponent), f64::from(exponent) * Real::powi(self.value, exponent - 1))
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        if exponent == 0.0 {
            return Self::one();
        }
        self.chain(libm::pow(self.value, exponent), exponent * libm::pow(self.value, exponent - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Stream;

    type Function = (&'static str, fn(Dual) -> Dual, fn(f64) -> f64);

    /// Each function beside its derivative as a table of derivatives prints it, which is never the
    /// expression of the code.
    const TABLE: [Function; 12] = [
        ("sqrt", |x| x.sqrt(), |x| 1.0 / (2.0 * libm::sqrt(x))),
        ("sin", |x| x.sin(), libm::cos),
        ("cos", |x| x.cos(), |x| -libm::sin(x)),
        ("tanh", |x| x.tanh(), |x| 1.0 / (libm::cosh(x) * libm::cosh(x))),
        ("exp", |x| x.exp(), libm::exp),
        ("ln", |x| x.ln(), |x| 1.0 / x),
        ("powi 5", |x| x.powi(5), |x| 5.0 * x * x * x * x),
        ("powi -2", |x| x.powi(-2), |x| -2.0 / (x * x * x)),
        ("powf 1.7", |x| x.powf(1.7), |x| 1.7 * libm::exp(0.7 * libm::log(x))),
        ("atan2(x, 2)", |x| x.atan2(Dual::constant(2.0)), |x| 2.0 / (4.0 + x * x)),
        ("atan2(2, x)", |x| Dual::constant(2.0).atan2(x), |x| -2.0 / (4.0 + x * x)),
        (
            "(x²+1)/(3−x)",
            |x| (x * x + Dual::one()) / (Dual::constant(3.0) - x),
            |x| (2.0 * x * (3.0 - x) + x * x + 1.0) / ((3.0 - x) * (3.0 - x)),
        ),
    ];

    #[test]
    fn derivatives_of_elementary_functions_are_those_of_the_table() {
        let stream = Stream::new(0, "dual numbers");
        for (name, function, derivative) in TABLE {
            for k in 0..200 {
                let [u, w] = stream.uniform_pair(k);
                let (x, direction) = (2.5 * u + 0.05, w - 0.5);
                let found = function(Dual::new(x, direction)).derivative;
                let expected = derivative(x) * direction;
                // rounding of two formulas of up to ten operations, one of them libm's exp(0.7 log
                // x)
                assert!((found - expected).abs() <= 1e-14 * expected.abs().max(direction.abs()), "{name} at {x}");
            }
        }
    }

    #[test]
    fn a_dual_number_without_derivative_is_a_plain_number_to_the_bit() {
        for k in 0..100 {
            let x = 0.1 + 0.37 * f64::from(k);
            let dual = |y: Dual, plain: f64| {
                assert_eq!(y.value.to_bits(), plain.to_bits());
                assert_eq!(y.derivative, 0.0);
            };
            let c = Dual::constant(x);
            dual(c.sin(), libm::sin(x));
            dual(c.cos(), Real::cos(x));
            dual(c.powi(7), Real::powi(x, 7));
            dual(Real::max(c, Dual::constant(5.0)), f64::max(x, 5.0));
            dual(Real::min(c, Dual::constant(5.0)), f64::min(x, 5.0));
            dual(Real::abs(-c), x);
            dual(c.scale(3.0), c.value * 3.0);
        }
    }

    #[test]
    fn magnitude_and_order_follow_the_value_and_carry_its_derivative() {
        assert_eq!(Real::abs(Dual::new(-2.0, 3.0)).derivative, -3.0);
        assert_eq!(Real::abs(Dual::new(2.0, 3.0)).derivative, 3.0);
        assert_eq!(Real::max(Dual::new(1.0, 7.0), Dual::new(2.0, 8.0)).derivative, 8.0);
        assert!(Dual::new(1.0, 9.0) < Dual::new(2.0, 0.0));
        assert!(!Dual::new(0.0, 1.0).is_zero());
        assert!(Dual::new(1.5, 2.0).powi(0).derivative == 0.0);
    }
}
