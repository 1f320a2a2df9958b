//! Axes: from numbers to places, with ticks at round numbers and labels that stay short.

use crate::text::{power_of_ten, short};

/// A tick: place between 0 and 1, and its label.
pub struct Tick {
    pub place: f64,
    pub label: String,
}

/// A quantity along one side of a panel.
#[derive(Clone, Debug)]
pub struct Axis {
    quantity: String,
    unit: String,
    logarithmic: bool,
    /// `None`: no usable value.
    range: Option<(f64, f64)>,
}

/// Beyond this a difference of two numbers may not be finite any more.
const SIZE_MAX: f64 = 1e150;

impl Axis {
    /// Covers the usable numbers of `values` with a margin of 3 %.
    pub fn linear(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let range = extremes(values.filter(|v| v.abs() < SIZE_MAX)).map(|(low, high)| {
            let least = (1e-9 * low.abs().max(high.abs())).max(1e-150);
            if high - low > least {
                (low - 0.03 * (high - low), high + 0.03 * (high - low))
            } else {
                let margin = (0.05 * low.abs()).max(if low == 0.0 { 1.0 } else { 1e-150 });
                (low - margin, high + margin)
            }
        });
        Axis { quantity: quantity.into(), unit: unit.into(), logarithmic: false, range }
    }

    /// As [`Axis::linear`], without margin: time and frequency fill the panel.
    pub fn tight(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = extremes(values.filter(|v| v.abs() < SIZE_MAX)).unwrap_or((f64::NAN, f64::NAN));
        let wide = Axis::linear(quantity, unit, [low, high].into_iter());
        if high > low { Axis { range: Some((low, high)), ..wide } } else { wide }
    }

    /// Covers the positive numbers of `values`, at most `decades_max` of them from the top.
    pub fn logarithmic(quantity: &str, unit: &str, values: impl Iterator<Item = f64>, decades_max: i32) -> Self {
        let range = extremes(values.filter(|v| *v > 1e-150 && *v < SIZE_MAX)).map(|(low, high)| {
            let low = low.max(high * libm::pow(10.0, -f64::from(decades_max)));
            if high > 1.01 * low { (low / 1.1, high * 1.1) } else { (low / 2.0, high * 2.0) }
        });
        Axis { quantity: quantity.into(), unit: unit.into(), logarithmic: true, range }
    }

    /// Rows of one octave each between the ends of `range`.
    pub fn octaves(quantity: &str, unit: &str, range: (f64, f64)) -> Self {
        let usable = range.0 > 1e-150 && range.1 > range.0 && range.1 < SIZE_MAX;
        Axis { quantity: quantity.into(), unit: unit.into(), logarithmic: true, range: usable.then_some(range) }
    }

    /// Without a range: the axis covers no usable value.
    pub fn is_empty(&self) -> bool {
        self.range.is_none()
    }

    /// Place of a number, 0 at the low end; not finite where it has none.
    pub fn place(&self, value: f64) -> f64 {
        let Some((low, high)) = self.range else { return f64::NAN };
        if self.logarithmic {
            if value <= 0.0 {
                return if value.is_nan() { f64::NAN } else { -10.0 };
            }
            return (libm::log(value) - libm::log(low)) / (libm::log(high) - libm::log(low));
        }
        if value.abs() < SIZE_MAX { (value - low) / (high - low) } else { f64::NAN }
    }

    /// Ticks, about `count` of them.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        match self.range {
            None => Vec::new(),
            Some((low, high)) if self.logarithmic => self.decade_ticks(low, high, count),
            Some((low, high)) => {
                let Steps { first, step, count } = Steps::new(low, high, count);
                let Notation { power, offset, decimals } = Notation::new(low, high, step);
                let unit = libm::pow(10.0, f64::from(power));
                let values = (0..count).map(|k| (first + k as f64) * step);
                let label = |v: f64| {
                    let text = format!("{:.decimals$}", (v - offset) / unit);
                    if text.trim_start_matches(['-', '0', '.']).is_empty() { "0".into() } else { text }
                };
                values.map(|v| Tick { place: self.place(v), label: label(v) }).collect()
            }
        }
    }

    fn decade_ticks(&self, low: f64, high: f64, count: usize) -> Vec<Tick> {
        let (first, last) = (libm::ceil(libm::log10(low) - 1e-9) as i32, libm::floor(libm::log10(high) + 1e-9) as i32);
        let step = (last - first + 1 + count as i32).div_euclid(count as i32 + 1).max(1);
        let between: &[f64] = if last - first < 2 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let mut ticks = Vec::new();
        for decade in (first - 1..=last).filter(|d| (d - first).rem_euclid(step) == 0 || between.len() > 1) {
            for digit in between {
                let value = digit * libm::pow(10.0, f64::from(decade));
                if value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9) {
                    let label =
                        if decade.abs() <= 3 || between.len() > 1 { short(value) } else { power_of_ten(decade) };
                    ticks.push(Tick { place: self.place(value), label });
                }
            }
        }
        if ticks.is_empty() {
            ticks.extend([low, high].map(|v| Tick { place: self.place(v), label: short(v) }));
        }
        ticks
    }

    /// Both ends in the numbers of the labels, and whether the axis is logarithmic; `None` without
    /// a range.
    pub fn ends(&self, count: usize) -> Option<(f64, f64, bool)> {
        let (low, high) = self.range?;
        if self.logarithmic {
            return Some((low, high, true));
        }
        let Notation { power, offset, .. } = Notation::new(low, high, Steps::new(low, high, count).step);
        let unit = libm::pow(10.0, f64::from(power));
        Some(((low - offset) / unit, (high - offset) / unit, false))
    }

    /// Quantity and unit, with the power of ten and the offset that its labels leave out.
    pub fn label(&self, count: usize) -> String {
        let mut quantity = self.quantity.clone();
        let mut unit = if self.unit == "-" {
            String::new()
        } else {
            self.unit.replace('*', "·").replace("^2", "²").replace("^3", "³")
        };
        if let (Some((low, high)), false) = (self.range, self.logarithmic) {
            let notation = Notation::new(low, high, Steps::new(low, high, count).step);
            if notation.offset != 0.0 {
                quantity = format!("{quantity} − {}", precise(notation.offset));
            }
            if notation.power != 0 {
                unit = format!("{} {unit}", power_of_ten(notation.power)).trim_end().into();
            }
        }
        if unit.is_empty() { quantity } else { format!("{quantity} [{unit}]") }
    }
}

/// All digits that a number has, at most twelve.
fn precise(x: f64) -> String {
    let text = format!("{x:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.len() <= 14 { text.into() } else { format!("{x:.6e}") }
}

fn extremes(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((if v < low { v } else { low }, if v > high { v } else { high })),
    })
}

/// Multiples of 1, 2 or 5 times a power of ten.
struct Steps {
    first: f64,
    step: f64,
    count: usize,
}

impl Steps {
    fn new(low: f64, high: f64, count: usize) -> Self {
        let raw = (high - low) / count.max(1) as f64;
        let decade = libm::pow(10.0, libm::floor(libm::log10(raw)));
        let step = decade * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * decade >= raw * 0.7).unwrap_or(10.0);
        let first = libm::ceil(low / step - 1e-9);
        let last = libm::floor(high / step + 1e-9);
        Steps { first, step, count: (last - first + 1.0).clamp(0.0, 50.0) as usize }
    }
}

/// Common format of all labels of an axis.
struct Notation {
    power: i32,
    offset: f64,
    decimals: usize,
}

impl Notation {
    fn new(low: f64, high: f64, step: f64) -> Self {
        let largest = low.abs().max(high.abs());
        // Numbers that agree in five digits are read from the first of them.
        let offset = if largest > 1e5 * (high - low) { libm::ceil(low / step) * step } else { 0.0 };
        let size = libm::floor(libm::log10(if offset == 0.0 { largest } else { high - low })) as i32;
        let power = if (-3..5).contains(&size) { 0 } else { 3 * size.div_euclid(3) };
        let decimals = (power - libm::floor(libm::log10(step) + 1e-9) as i32).clamp(0, 9) as usize;
        Notation { power, offset, decimals }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, count: usize) -> Vec<String> {
        axis.ticks(count).into_iter().map(|t| t.label).collect()
    }

    #[test]
    fn ticks_are_round_distinct_and_inside() {
        for (low, high) in [(0.0, 55.0), (-1.3, 2.7), (1e-9, 4e-9), (1e6, 1e6 + 0.02), (-3e12, 5e12), (-5.0, -4.9)] {
            let axis = Axis::tight("angle", "rad", [low, high].into_iter());
            let ticks = axis.ticks(6);
            assert!((3..=10).contains(&ticks.len()), "{low} to {high}: {}", ticks.len());
            assert!(ticks.iter().all(|t| (-1e-6..=1.0 + 1e-6).contains(&t.place)));
            assert!(ticks.windows(2).all(|w| w[0].label != w[1].label), "{:?}", labels(&axis, 6));
            assert!(ticks.iter().all(|t| t.label.len() <= 8), "{:?}", labels(&axis, 6));
        }
    }

    #[test]
    fn powers_and_offsets_stand_in_the_label_of_the_axis() {
        let small = Axis::tight("rate", "rad/s", [0.0, 4e-9].into_iter());
        assert_eq!(labels(&small, 4), ["0", "1", "2", "3", "4"]);
        assert_eq!(small.label(4), "rate [10⁻⁹ rad/s]");
        let far = Axis::tight("time", "s", [1e6, 1e6 + 4.0].into_iter());
        assert_eq!((far.label(4), labels(&far, 4)[1].as_str()), ("time − 1000000 [s]".into(), "1"));
        assert_eq!(Axis::tight("share", "-", [0.0, 1.0].into_iter()).label(5), "share");
    }

    #[test]
    fn constants_nothing_and_what_is_no_number_have_an_axis_too() {
        let constant = Axis::linear("x", "m", [3.0, 3.0].into_iter());
        assert!((constant.place(3.0) - 0.5).abs() < 1e-9 && !constant.ticks(4).is_empty());
        assert!(Axis::linear("x", "m", [0.0].into_iter()).place(0.0) == 0.5);
        let none = Axis::linear("x", "m", [f64::NAN, f64::INFINITY].into_iter());
        assert!(none.is_empty() && none.ticks(4).is_empty() && none.place(1.0).is_nan());
        assert!(Axis::linear("x", "m", [-1e308, 1e308, 0.0, 1.0].into_iter()).place(0.5).is_finite());
        assert!(Axis::logarithmic("f", "Hz", [0.0, -1.0].into_iter(), 6).is_empty());
    }

    #[test]
    fn a_logarithmic_axis_marks_decades_or_the_digits_between() {
        let wide = Axis::logarithmic("f", "Hz", [1e-6, 1e6].into_iter(), 20);
        assert!(
            labels(&wide, 6).contains(&"10⁻⁶".to_string()) && labels(&wide, 6).len() <= 8,
            "{:?}",
            labels(&wide, 6)
        );
        let narrow = Axis::logarithmic("f", "Hz", [3.0, 40.0].into_iter(), 20);
        assert_eq!(labels(&narrow, 6), ["5", "10", "20"]);
        assert!(Axis::logarithmic("f", "Hz", [3.0, 4.0].into_iter(), 20).ticks(5).len() >= 2);
    }
}
