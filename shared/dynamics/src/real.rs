//! The scalars all of the plant's equations are written in: `f64`, and [`Dual`](crate::dual::Dual)
//! for exact derivatives.
//!
//! One formulation serves simulation and linearisation, so a Jacobian can never belong to another
//! model than the one that is simulated. Elementary functions come from `libm`, never from the
//! platform: equal inputs give equal bits everywhere. `sqrt`, `abs` and the four operations are
//! exact in IEEE 754 and need no library.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use num_traits::{One, Zero};

/// A real number, possibly carrying a derivative. Comparisons look at the value alone.
pub trait Real:
    nalgebra::Scalar
    + Copy
    + Default
    + Zero
    + One
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + 'static
{
    /// A number whose derivative is zero.
    fn constant(value: f64) -> Self;
    /// The number without its derivative.
    fn value(self) -> f64;
    /// Product with a constant: `self · factor`, without the work of a dual product.
    fn scale(self, factor: f64) -> Self;

    fn sqrt(self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn tanh(self) -> Self;
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Angle of the point (`x`, `self`), in (−π, π].
    fn atan2(self, x: Self) -> Self;
    /// Magnitude; the derivative at zero is taken from the right.
    fn abs(self) -> Self;
    /// `self^exponent` by repeated squaring: the same bits on every platform.
    fn powi(self, exponent: i32) -> Self;
    /// `self^exponent` for `self > 0` (or `self = 0` with `exponent ≥ 1`).
    fn powf(self, exponent: f64) -> Self;

    #[inline]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    #[inline]
    fn cos(self) -> Self {
        self.sin_cos().1
    }

    /// The larger by value; `self` when equal.
    #[inline]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// The smaller by value; `self` when equal.
    #[inline]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
}

impl Real for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn scale(self, factor: f64) -> Self {
        self * factor
    }

    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }

    #[inline]
    fn sin(self) -> Self {
        libm::sin(self)
    }

    #[inline]
    fn cos(self) -> Self {
        libm::cos(self)
    }

    #[inline]
    fn tanh(self) -> Self {
        libm::tanh(self)
    }

    #[inline]
    fn exp(self) -> Self {
        libm::exp(self)
    }

    #[inline]
    fn ln(self) -> Self {
        libm::log(self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }

    #[inline]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    fn powi(self, exponent: i32) -> Self {
        let mut power = 1.0;
        let mut square = self;
        let mut remaining = exponent.unsigned_abs();
        while remaining > 0 {
            if remaining & 1 == 1 {
                power *= square;
            }
            square *= square;
            remaining >>= 1;
        }
        if exponent < 0 { 1.0 / power } else { power }
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        libm::pow(self, exponent)
    }
}
