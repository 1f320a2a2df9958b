//! Steps of a state along its derivative.

/// Classical Runge–Kutta of fourth order and the midpoint rule, with their scratch; no allocation
/// after [`Self::new`].
///
/// Error of one step O(h⁵), O(h³) of the midpoint rule. What moves on no straight line
/// (quaternions) is normalised by the caller behind each step
/// ([`System::normalise`](super::System::normalise)).
#[derive(Clone, Debug, Default)]
pub struct RungeKutta {
    slopes: [Vec<f64>; 4],
    stage: Vec<f64>,
}

impl RungeKutta {
    /// Scratch for `states` numbers.
    pub fn new(states: usize) -> Self {
        let zeros = || vec![0.0; states];
        Self { slopes: [zeros(), zeros(), zeros(), zeros()], stage: zeros() }
    }

    /// One step of length `h` from `x`. `slope(share, x, x')` writes the derivative at a share of
    /// the step: at its begin, twice in its middle, at its end.
    pub fn step(&mut self, h: f64, x: &mut [f64], mut slope: impl FnMut(f64, &[f64], &mut [f64])) {
        let Self { slopes: [k_1, k_2, k_3, k_4], stage } = self;
        slope(0.0, x, k_1);
        move_along(stage, x, k_1, 0.5 * h);
        slope(0.5, stage, k_2);
        move_along(stage, x, k_2, 0.5 * h);
        slope(0.5, stage, k_3);
        move_along(stage, x, k_3, h);
        slope(1.0, stage, k_4);
        let (first, inner, last) = (k_1.iter(), k_2.iter().zip(k_3.iter()), k_4.iter());
        for (x, (k_1, ((k_2, k_3), k_4))) in x.iter_mut().zip(first.zip(inner.zip(last))) {
            *x += (k_1 + (k_2 + k_3) * 2.0 + k_4) * (h / 6.0);
        }
    }

    /// One step of the midpoint rule; `slope` as in [`Self::step`], at the begin and in the middle.
    pub fn midpoint(&mut self, h: f64, x: &mut [f64], mut slope: impl FnMut(f64, &[f64], &mut [f64])) {
        let Self { slopes: [k_1, k_2, ..], stage } = self;
        slope(0.0, x, k_1);
        move_along(stage, x, k_1, 0.5 * h);
        slope(0.5, stage, k_2);
        x.iter_mut().zip(k_2.iter()).for_each(|(x, k)| *x += k * h);
    }

    /// State in the middle of the last [`Self::step`], which began in `x` with length `h`; to third
    /// order in `h`.
    pub fn middle(&self, x: &[f64], h: f64, out: &mut [f64]) {
        move_along(out, x, &self.slopes[1], 0.5 * h);
    }
}

/// `to = from + h k`.
fn move_along(to: &mut [f64], from: &[f64], k: &[f64], h: f64) {
    for ((to, from), k) in to.iter_mut().zip(from).zip(k) {
        *to = from + h * k;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x' = −x³` from one: `x = 1/√(1 + 2 t)`.
    fn error_at_one(steps: u32, midpoint: bool) -> f64 {
        let (mut x, h) = ([1.0], 1.0 / f64::from(steps));
        let mut scratch = RungeKutta::new(1);
        let slope = |_: f64, x: &[f64], x_dot: &mut [f64]| x_dot[0] = -x[0] * x[0] * x[0];
        for _ in 0..steps {
            if midpoint {
                scratch.midpoint(h, &mut x, slope);
            } else {
                scratch.step(h, &mut x, slope);
            }
        }
        x[0] - 1.0 / f64::sqrt(3.0)
    }

    #[test]
    fn errors_fall_with_the_order_of_the_method() {
        for (midpoint, order) in [(false, 4), (true, 2)] {
            let ratio = error_at_one(160, midpoint) / error_at_one(320, midpoint);
            // the next order is a share h of the leading one
            assert!((ratio.log2() - f64::from(order)).abs() < 0.1, "{ratio}");
        }
    }

    #[test]
    fn a_cubic_in_time_is_integrated_exactly_and_its_middle_is_within_the_step() {
        let (mut scratch, mut x, mut middle) = (RungeKutta::new(1), [0.0], [0.0]);
        scratch.step(2.0, &mut x, |share, _, x_dot| x_dot[0] = 4.0 * (2.0 * share) * (2.0 * share) * (2.0 * share));
        assert!((x[0] - 16.0).abs() < 1e-14);
        scratch.middle(&[0.0], 2.0, &mut middle);
        assert_eq!(middle, [4.0]); // the slope in the middle, over half the step
    }
}
