//! Noise of the tests: a 64-bit linear congruential generator and Box–Muller.

pub struct Noise {
    state: u64,
}

#[allow(dead_code)] // each test takes what it needs
impl Noise {
    pub fn new(seed: u64) -> Self {
        let mut noise = Self { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03 };
        for _ in 0..8 {
            noise.uniform();
        }
        noise
    }

    /// Uniform in (0, 1].
    pub fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.state ^ (self.state >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
        ((mixed >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub fn normal(&mut self) -> f64 {
        let (u_1, u_2) = (self.uniform(), self.uniform());
        libm::sqrt(-2.0 * libm::log(u_1)) * libm::cos(2.0 * std::f64::consts::PI * u_2)
    }
}
