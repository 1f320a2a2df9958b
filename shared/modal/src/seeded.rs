//! Random numbers of the parametric bootstraps: the same record gives the same answer.

use core::f64::consts::TAU;
use faer::c64;

/// SplitMix64 through Box and Muller.
pub(crate) struct Seeded(u64);

impl Seeded {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Circular complex normal, `E|z|² = 1`.
    pub fn complex_normal(&mut self) -> c64 {
        let radius = libm::sqrt(-libm::log(self.uniform()));
        let (sine, cosine) = libm::sincos(TAU * self.uniform());
        c64::new(radius * cosine, radius * sine)
    }
}
