//! A unit as a factor over SI and its dimension; products, quotients, powers and roots.

use core::f64::consts::PI;

/// Doubled exponents of kg, m, s, A, K.
pub type Dimension = [i32; 5];

/// A unit in SI: `10^(point + ten) · numerator / denominator · √π^root_pi`, and behind it the zero
/// of a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Doubled exponents of kg, m, s, A, K.
    pub dimension: Dimension,
    /// Doubled exponent of angle.
    pub radian: i32,
    /// Doubled exponent of cycles.
    pub hertz: i32,
    numerator: f64,
    denominator: f64,
    /// Place of the decimal point in the numerator.
    point: i32,
    /// Of prefixes.
    ten: i32,
    root_pi: i32,
    offset: f64,
}

/// What a number without a unit has.
pub const NONE: Unit = Unit {
    dimension: [0; 5],
    radian: 0,
    hertz: 0,
    numerator: 1.0,
    denominator: 1.0,
    point: 0,
    ten: 0,
    root_pi: 0,
    offset: 0.0,
};

/// `numerator · 10^point / denominator` of the SI unit of `dimension`, whose exponents are whole.
pub(crate) const fn unit(dimension: [i32; 5], numerator: f64, denominator: f64, point: i32) -> Unit {
    let [kg, m, s, a, k] = dimension;
    Unit { dimension: [2 * kg, 2 * m, 2 * s, 2 * a, 2 * k], numerator, denominator, point, ..NONE }
}

/// `numerator / denominator · π` radians.
pub(crate) const fn angle(numerator: f64, denominator: f64) -> Unit {
    Unit { radian: 2, root_pi: 2, numerator, denominator, ..NONE }
}

impl Unit {
    pub(crate) const fn per_second(self) -> Self {
        let mut unit = self;
        unit.dimension[2] -= 2;
        unit
    }

    pub(crate) const fn of_cycles(self) -> Self {
        Unit { hertz: 2, ..self }
    }

    pub(crate) const fn of_angle(self) -> Self {
        Unit { radian: 2, ..self }
    }

    /// `10^ten` of it.
    pub(crate) const fn prefixed(self, ten: i32) -> Self {
        Unit { ten: self.ten + ten, ..self }
    }

    /// Its zero is at `offset` of the SI unit.
    pub(crate) const fn with_zero_at(self, offset: f64) -> Self {
        Unit { offset, ..self }
    }

    /// Its zero is not that of the SI unit: no multiple of it and no product has a meaning.
    #[must_use]
    pub fn has_own_zero(&self) -> bool {
        self.offset != 0.0
    }

    /// `number`, a decimal literal, in SI; `None` where it is none.
    ///
    /// One rounding where the unit is a whole number times a power of ten, at most four where it
    /// has a quotient or π.
    #[must_use]
    pub fn to_si(&self, number: &str) -> Option<f64> {
        let (mantissa, exponent) = match number.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (number, 0),
        };
        let (scaled, left) = match whole_product(mantissa, self.numerator) {
            Some(product) => (product, 1.0),
            None => (mantissa.to_owned(), self.numerator),
        };
        let scaled: f64 =
            format!("{scaled}e{}", exponent.saturating_add(self.ten).saturating_add(self.point)).parse().ok()?;
        let pi = root_of_pi(self.root_pi.abs());
        let value = scaled * left / self.denominator;
        let value = if self.root_pi > 0 { value * pi } else { value / pi };
        Some(if self.offset == 0.0 { value } else { value + self.offset })
    }

    /// Factor, divisor and offset: `SI = value · factor / divisor + offset`. Powers of ten divide
    /// or multiply by an exact number, so that 5 ms is the double nearest to 0.005.
    #[must_use]
    pub fn conversion(&self) -> [f64; 3] {
        let numerator =
            if self.point < 0 { self.numerator / ten(-self.point) } else { self.numerator * ten(self.point) };
        let pi = root_of_pi(self.root_pi.abs());
        let (up, down) = if self.root_pi > 0 { (pi, 1.0) } else { (1.0, pi) };
        [numerator * up * ten(self.ten), self.denominator * down * ten(-self.ten), self.offset]
    }

    pub(crate) fn times(self, other: Self, sign: i32) -> Self {
        let (up, down) =
            if sign > 0 { (other.numerator, other.denominator) } else { (other.denominator, other.numerator) };
        let add = |a: i32, b: i32| a.saturating_add(sign.saturating_mul(b));
        Self {
            dimension: core::array::from_fn(|i| add(self.dimension[i], other.dimension[i])),
            radian: add(self.radian, other.radian),
            hertz: add(self.hertz, other.hertz),
            numerator: self.numerator * up,
            denominator: self.denominator * down,
            point: add(self.point, other.point),
            ten: add(self.ten, other.ten),
            root_pi: add(self.root_pi, other.root_pi),
            offset: 0.0,
        }
    }

    /// `self^(half_power / 2)`; `None` where a quarter power would be needed.
    pub(crate) fn powered(self, half_power: i32) -> Option<Self> {
        let whole = half_power / 2;
        let mut result = (0..whole.unsigned_abs()).fold(NONE, |product, _| product.times(self, whole.signum()));
        if half_power % 2 != 0 {
            result = result.times(self.square_root()?, half_power.signum());
        }
        Some(result)
    }

    /// Its root; `None` where that is a quarter power.
    pub(crate) fn square_root(self) -> Option<Self> {
        let odd = |exponent: &i32| exponent % 2 != 0;
        if self.dimension.iter().any(odd) || odd(&self.radian) || odd(&self.hertz) || odd(&self.root_pi) {
            return None;
        }
        // √(10^odd) would be irrational twice over: one ten goes into the numerator
        let power = self.ten + self.point;
        let borrowed = power.rem_euclid(2);
        Some(Self {
            dimension: self.dimension.map(|exponent| exponent / 2),
            radian: self.radian / 2,
            hertz: self.hertz / 2,
            numerator: (self.numerator * if borrowed == 1 { 10.0 } else { 1.0 }).sqrt(),
            denominator: self.denominator.sqrt(),
            point: 0,
            ten: (power - borrowed) / 2,
            root_pi: self.root_pi / 2,
            offset: 0.0,
        })
    }
}

/// `10^power`, 1 for a negative power; exact up to 10^22.
fn ten(power: i32) -> f64 {
    (0..power).fold(1.0, |product, _| product * 10.0)
}

/// `√π^power`.
fn root_of_pi(power: i32) -> f64 {
    let whole = (0..power / 2).fold(1.0, |product, _| product * PI);
    if power % 2 == 0 { whole } else { whole * PI.sqrt() }
}

/// The decimal literal times a whole number, exactly; `None` where the factor is not whole or the
/// product too long.
fn whole_product(mantissa: &str, factor: f64) -> Option<String> {
    if factor == 1.0 || factor.fract() != 0.0 || factor.abs() > 9e15 || mantissa.len() > 20 {
        return None;
    }
    let (sign, digits) = match mantissa.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", mantissa.strip_prefix('+').unwrap_or(mantissa)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let product = format!("{whole}{fraction}").parse::<u128>().ok()?.checked_mul(factor as u128)?;
    let padded = format!("{product:0>width$}", width = fraction.len() + 1);
    let (whole, fraction) = padded.split_at(padded.len() - fraction.len());
    Some(format!("{sign}{whole}.{fraction}"))
}
