//! Structures drawn at random, their closed responses, and records of them under random force.

use modal::c64;

/// Lines of the closed responses and their highest frequency \[Hz\].
const LINES: usize = 640;
const LAST_HZ: f64 = 80.0;
/// Samples of a segment of a record, and samples a second.
const SEGMENT: usize = 8192;
const RATE_HZ: f64 = 320.0;

/// Uniform and normal numbers from one seed: a 64-bit linear congruential generator, mixed.
pub struct Draw {
    state: u64,
}

impl Draw {
    /// A stream of its own for every seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut draw = Self { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03 };
        (0..8).for_each(|_| {
            draw.uniform();
        });
        draw
    }

    /// In (0, 1].
    pub fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.state ^ (self.state >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
        ((mixed >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    /// In (low, high].
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Log-uniform in (low, high].
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// A whole number from `low` to `high`.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + ((self.uniform() * (high - low + 1) as f64) as usize).min(high - low)
    }

    /// Mean zero, variance one.
    pub fn normal(&mut self) -> f64 {
        let (u_1, u_2) = (self.uniform(), self.uniform());
        libm::sqrt(-2.0 * libm::log(u_1)) * libm::cos(core::f64::consts::TAU * u_2)
    }

    /// A component of a shape, of either sign, not near zero.
    fn component(&mut self) -> f64 {
        let size = self.between(0.3, 1.0);
        if self.uniform() < 0.5 { size } else { -size }
    }
}

/// Modes within the lines, one above them.
pub struct Structure {
    /// Frequency \[Hz\] and damping ratio.
    pub modes: Vec<(f64, f64)>,
    /// Per mode, channel by channel.
    pub shapes: Vec<Vec<f64>>,
    above: (f64, f64),
    shape_above: Vec<f64>,
}

fn pole((f, zeta): (f64, f64)) -> c64 {
    let omega = core::f64::consts::TAU * f;
    c64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt())
}

impl Structure {
    /// Two to four modes, in one of three draws a pair whose half bandwidths touch.
    #[must_use]
    pub fn draw(draw: &mut Draw) -> Self {
        let count = draw.whole(2, 4);
        let pair = draw.uniform() < 1.0 / 3.0;
        let mut modes: Vec<(f64, f64)> = Vec::new();
        let apart = |modes: &[(f64, f64)], (f, zeta): (f64, f64)| {
            modes.iter().all(|(g, other)| (f - g).abs() > 4.0 * (f * zeta + g * other))
        };
        while modes.len() < count {
            let new = (draw.between(8.0, 74.0), draw.log_between(0.003, 0.03));
            if pair && modes.len() == 1 {
                let (g, other) = modes[0];
                let zeta = draw.log_between(0.003, 0.03);
                modes.push((g + draw.between(1.0, 2.0) * g * (zeta + other), zeta));
            } else if apart(&modes, new) {
                modes.push(new);
            }
        }
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let channels = draw.whole(1, 10);
        let mut shape = |_: usize| (0..channels).map(|_| draw.component()).collect::<Vec<f64>>();
        let shapes = (0..count).map(&mut shape).collect();
        let shape_above = shape(0);
        Self { modes, shapes, above: (draw.between(1.2, 2.0) * LAST_HZ, 0.01), shape_above }
    }

    fn all(&self) -> impl Iterator<Item = (c64, &Vec<f64>)> {
        let inside = self.modes.iter().map(|mode| pole(*mode)).zip(&self.shapes);
        inside.chain([(pole(self.above), &self.shape_above)])
    }

    /// Accelerance `Σ φ s²/(s² + 2ζωs + ω²)`, channel by channel.
    fn responses(&self, frequency_hz: &[f64]) -> Vec<Vec<c64>> {
        let at = |c: usize, f: &f64| {
            let s = c64::new(0.0, core::f64::consts::TAU * f);
            let of = |(pole, shape): (c64, &Vec<f64>)| s * s * shape[c] / ((s - pole) * (s - pole.conj()));
            self.all().map(of).fold(c64::new(0.0, 0.0), |sum, x| sum + x)
        };
        (0..self.shape_above.len()).map(|c| frequency_hz.iter().map(|f| at(c, f)).collect()).collect()
    }

    /// Lines with 2–10 % of noise: of the channel's root mean square, or of every line's magnitude
    /// beside a tenth of that.
    pub fn noisy_responses(&self, proportional: bool, draw: &mut Draw) -> (Vec<f64>, Vec<Vec<c64>>) {
        let frequency_hz: Vec<f64> = (1..LINES).map(|k| k as f64 * LAST_HZ / LINES as f64).collect();
        let mut responses = self.responses(&frequency_hz);
        let level = draw.log_between(0.02, 0.1);
        for response in &mut responses {
            let mean = (response.iter().map(|x| x.norm_sqr()).sum::<f64>() / response.len() as f64).sqrt();
            for x in response {
                let sigma = if proportional { level * (x.norm_sqr().sqrt() + 0.1 * mean) } else { level * mean };
                *x += c64::new(draw.normal(), draw.normal()) * (sigma * core::f64::consts::FRAC_1_SQRT_2);
            }
        }
        (frequency_hz, responses)
    }
}

/// Samples of channels under random force.
pub struct Record {
    force: Vec<f64>,
    outputs: Vec<Vec<f64>>,
}

impl Record {
    /// Displacements of the modes, of one size in acceleration, under one measured random force
    /// held from sample to sample; the sensors with 2–10 % of noise.
    #[must_use]
    pub fn driven(structure: &Structure, draw: &mut Draw) -> Self {
        let averages = draw.whole(10, 40);
        let samples = SEGMENT / 2 * (averages + 1);
        let channels = structure.shape_above.len();
        let period = 1.0 / RATE_HZ;
        let mut force = Vec::with_capacity(samples);
        let mut outputs = vec![Vec::with_capacity(samples); channels];
        let steps: Vec<(c64, c64, f64, &Vec<f64>)> = structure
            .all()
            .map(|(pole, shape)| {
                let (sine, cosine) = libm::sincos(pole.im * period);
                let turn = c64::new(cosine, sine) * libm::exp(pole.re * period);
                (turn, (turn - 1.0) / pole, pole.im, shape)
            })
            .collect();
        let mut states = vec![c64::new(0.0, 0.0); steps.len()];
        // The first segments of the simulation are left out: the motion has to become stationary.
        for sample in 0..samples + 4 * SEGMENT {
            let u = draw.normal();
            if sample >= 4 * SEGMENT {
                force.push(u);
                for (c, output) in outputs.iter_mut().enumerate() {
                    output.push(states.iter().zip(&steps).map(|(z, step)| step.3[c] * step.2 * z.im).sum());
                }
            }
            for (z, (turn, gain, ..)) in states.iter_mut().zip(&steps) {
                *z = turn * *z + gain * u;
            }
        }
        let level = draw.log_between(0.02, 0.1);
        for output in &mut outputs {
            let sigma = level * (output.iter().map(|y| y * y).sum::<f64>() / output.len() as f64).sqrt();
            output.iter_mut().for_each(|y| *y += sigma * draw.normal());
        }
        Self { force, outputs }
    }

    /// Transforms of the segments, half overlapped under Hann windows, at the lines up to 80 Hz
    /// without the first two.
    fn segments(signal: &[f64]) -> Vec<Vec<c64>> {
        let window = |n: usize| 0.5 - 0.5 * libm::cos(core::f64::consts::TAU * n as f64 / SEGMENT as f64);
        let starts = (0..signal.len() / (SEGMENT / 2) - 1).map(|k| k * SEGMENT / 2);
        let of = |start: usize| {
            let mut x: Vec<c64> = (0..SEGMENT).map(|n| c64::new(signal[start + n] * window(n), 0.0)).collect();
            transform(&mut x);
            x[2..=(LAST_HZ / RATE_HZ * SEGMENT as f64) as usize].to_vec()
        };
        starts.map(of).collect()
    }

    fn frequency_hz() -> Vec<f64> {
        (2..=(LAST_HZ / RATE_HZ * SEGMENT as f64) as usize).map(|k| k as f64 * RATE_HZ / SEGMENT as f64).collect()
    }

    /// `S_yu/S_uu`.
    #[must_use]
    pub fn h1(&self) -> (Vec<f64>, Vec<Vec<c64>>) {
        let force = Self::segments(&self.force);
        let of_channel = |y: &Vec<f64>| {
            let output = Self::segments(y);
            let quotient = |k: usize| {
                let cross = force.iter().zip(&output).fold(c64::new(0.0, 0.0), |sum, (u, y)| sum + y[k] * u[k].conj());
                cross / force.iter().map(|u| u[k].norm_sqr()).sum::<f64>()
            };
            (0..force[0].len()).map(quotient).collect()
        };
        (Self::frequency_hz(), self.outputs.iter().map(of_channel).collect())
    }
}

/// Fourier transform in place, of a power of two (Cooley & Tukey 1965).
fn transform(x: &mut [c64]) {
    let n = x.len();
    let mut j = 0;
    for i in 1..n {
        let mut bit = n >> 1;
        while j & bit != 0 {
            j ^= bit;
            bit >>= 1;
        }
        j |= bit;
        if i < j {
            x.swap(i, j);
        }
    }
    let table: Vec<c64> = (0..n / 2)
        .map(|k| {
            let (sine, cosine) = libm::sincos(-core::f64::consts::TAU * k as f64 / n as f64);
            c64::new(cosine, sine)
        })
        .collect();
    let mut length = 2;
    while length <= n {
        for block in x.chunks_exact_mut(length) {
            let (low, high) = block.split_at_mut(length / 2);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = *b * table[k * (n / length)];
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        length *= 2;
    }
}
