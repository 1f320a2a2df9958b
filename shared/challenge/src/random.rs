//! Named streams of random numbers: PCG64 seeded by BLAKE3 of (seed, case, name).
//!
//! Generator and seeding differ from those of `dynamics::noise`: truth and tool share no noise.

use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// One stream. Adding a stream leaves every other one unchanged.
pub struct Draw(Pcg64);

impl Draw {
    /// The stream `name` of a case; streams of other names, cases and seeds are independent.
    #[must_use]
    pub fn new(seed: u64, case: u64, name: &str) -> Self {
        let digest = blake3::hash(format!("obsid challenge/{seed}/{case}/{name}").as_bytes());
        Self(Pcg64::from_seed(*digest.as_bytes()))
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Uniform between `low` and `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let share: f64 = StandardUniform.sample(&mut self.0);
        low + share * (high - low)
    }

    /// Log-uniform between two positive values.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.uniform(libm::log(low), libm::log(high)))
    }

    /// Index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform(0.0, 1.0) * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// One or minus one.
    pub fn sign(&mut self) -> f64 {
        if self.uniform(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 }
    }
}
