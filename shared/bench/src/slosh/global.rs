//! Global start on one axis: tanks drawn at random, nothing known but the mass of the craft.
//!
//! Slosh masses of 10 to 150 kg, modes of 6 to 40 mHz, damping ratios of 0.2 to 5 %, the first and
//! the last two evenly in their logarithms. Five cycles of ±44 N, ever faster, then coasting to
//! 1000 s; start, bias and thrust scale unknown. An answer further than five of its tank's
//! Cramér–Rao sigmas from the truth in any number is a wrong minimum and counts as failed.

use super::{Answer, Benchmark, Cost, Found, Method, NAMES, PARAMETERS, Parameter, Slosh, UNCALIBRATED, method};
use crate::campaign::{Campaign, cost};
use estimation::consistency::nees;
use nalgebra::Vector3;
use physics::slosh::SloshParameters;
use physics::slosh_likelihood::SloshUnknowns;

const METHODS: &[Method] = &[method("ml", &[])];
/// Lengths of the cycles [s]; halves of them are multiples of the sample interval.
const CYCLES_S: [f64; 5] = [100.0, 60.0, 40.0, 30.0, 20.0];
/// Beyond so many sigmas of the bound an answer is another minimum.
const LANDED_SIGMAS: f64 = 5.0;

/// Random tanks under one thrust.
#[derive(Clone, Debug)]
pub struct RandomTanks {
    craft: Slosh,
}

impl RandomTanks {
    /// The craft of BP2 with five cycles of ±44 N and an uncalibrated thrust.
    pub fn new() -> Self {
        let mut craft = Slosh { name: "bp2-global", concealed: UNCALIBRATED, ..Slosh::bp2() };
        super::experiments::quicken(&mut craft.plant, 44.0, &CYCLES_S, 1000.0);
        craft.settings.unknowns = SloshUnknowns::ParametersStateBiasScale;
        Self { craft }
    }

    /// Tank number `record`.
    pub fn tank(&self, seed: u64, record: usize) -> Slosh {
        let base_mass_kg = self.craft.settings.base_mass_kg;
        let draw = |which: u64, low: f64, high: f64| low * (high / low).powf(uniform(seed, record as u64, which));
        let slosh_mass_kg = draw(0, 10.0, 150.0);
        let omega = 2.0 * std::f64::consts::PI * draw(1, 0.006, 0.04);
        let mu = SloshParameters { slosh_mass_kg, ..SloshParameters::default() }.reduced_mass_kg(base_mass_kg);
        let mut tank = self.craft.clone();
        for (name, value) in [
            ("fuel.mass", slosh_mass_kg),
            ("fuel.stiffness.x", mu * omega * omega),
            ("fuel.damping.x", 2.0 * draw(2, 0.002, 0.05) * omega * mu),
        ] {
            tank.plant.set_parameter(name, value).expect("the benchmark's tank has these numbers");
        }
        tank
    }
}

impl Default for RandomTanks {
    fn default() -> Self {
        Self::new()
    }
}

/// SplitMix64 of three numbers, in (0, 1).
fn uniform(seed: u64, record: u64, which: u64) -> f64 {
    let mut z =
        (seed << 32 ^ record << 2 ^ which).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53) + 2f64.powi(-54)
}

impl Benchmark for RandomTanks {
    fn name(&self) -> &'static str {
        "bp2-global"
    }

    /// Every number in units of its own tank's bound, about one.
    fn parameters(&self) -> Option<Vec<Parameter>> {
        Some(NAMES.map(|name| Parameter { name, truth: 1.0, bound: 1.0 }).into())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let tank = self.tank(seed, record);
        let (Ok(estimate), Some(bounds)) = (tank.flight(&tank.record(seed, record)).estimate(), tank.parameters())
        else {
            return vec![Answer::none(PARAMETERS)];
        };
        let error = super::values(&estimate.hypothesis.parameters) - tank.truth();
        let bound = Vector3::from_fn(|i, _| bounds[i].bound);
        let (z, sigmas) = (error.component_div(&bound), estimate.sigmas().component_div(&bound));
        if z.amax() > LANDED_SIGMAS {
            return vec![Answer::none(PARAMETERS)];
        }
        let found = |i: usize| Some(Found { value: 1.0 + z[i], sigma: Some(sigmas[i]) });
        let nees = nees(&error, &estimate.covariance);
        vec![Answer { found: (0..PARAMETERS).map(found).collect(), nees, ..Answer::default() }]
    }

    fn costs(&self) -> Vec<Cost> {
        let (tank, record) = (self.tank(0, 0), self.tank(0, 0).record(0, 0));
        vec![cost(record.len(), || tank.flight(&record), |estimator| estimator.estimate())]
    }

    fn remarks(&self, campaign: &Campaign) -> Vec<String> {
        vec![format!(
            "{} tanks of 10 to 150 kg, 6 to 40 mHz, 0.2 to 5 % damping, drawn from the seed; errors are in units of each tank's own bound, about one. Failed: no answer, or further than {LANDED_SIGMAS} sigma.",
            campaign.trials
        )]
    }
}
