//! The target's mass, centre of mass and inertia: the whole chain before capture (BP1A, BP1B) and after it, simulated.
//!
//! The momentum after capture is taken as known here; the chaser's data sheet is drawn anew for every record from the sigmas that the
//! estimator is told.

use super::flying::Flying;
use super::methods::weighted;
use super::{Inertial, planar_arm};
use crate::bench::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::bench::simulated::number;
use estimation::consistency::nees;
use estimation::weighted_least_squares::Estimate;
use nalgebra::Vector4;
use physics::mated::Target;
use physics::target::{ChaserPrior, Identified, TargetEstimate, recover};
use plant::noise::Stream;

const NAMES: [&str; 4] = ["m_t", "x_t", "y_t", "I_t"];
const METHODS: &[Method] = &[Method { name: "alpha, alpha', pi", paper_percent: &[] }];
/// Sigmas of the chaser's data sheet.
const BASE_MASS_RELATIVE_SD: f64 = 0.3;
const LINK_MASS_RELATIVE_SD: f64 = 0.02;
const INERTIA_RELATIVE_SD: f64 = 0.3;
const LENGTH_SD_M: f64 = 0.05;
const LINK_1_LENGTH_SD_M: f64 = 1e-4;
/// What is seen of the target from outside; a start without weight.
const GUESS: Target = Target { mass_kg: 100.0, inertia_com_kg_m2: 60.0, grasp_to_com_m: [0.5, 0.0] };

/// The three experiments.
#[derive(Clone, Debug)]
pub struct Chain {
    before: Inertial<8, 9>,
    flying: Flying,
    after: Inertial<9, 10>,
}

impl Chain {
    pub fn bp1() -> Self {
        Self { before: Inertial::bp1a(), flying: Flying::bp1b(), after: Inertial::mated() }
    }

    fn truth(&self) -> Vector4<f64> {
        let at = |name: &str| number(&self.after.plant, name);
        Vector4::new(at("target.mass"), at("target.com.x"), at("target.com.y"), at("target.inertia.zz"))
    }

    /// The data sheet of one record: the truth, every number off by its sigma times a normal number.
    fn prior(&self, stream: Option<&Stream>) -> ChaserPrior {
        let drawn = |i: u64| stream.map_or(0.0, |stream| stream.normal(i));
        let mut arm = planar_arm(&self.after.plant);
        let mass_relative_sd = [BASE_MASS_RELATIVE_SD, LINK_MASS_RELATIVE_SD, LINK_MASS_RELATIVE_SD];
        for (i, sd) in mass_relative_sd.iter().enumerate() {
            arm.mass_kg[i] *= (sd * drawn(i as u64)).exp();
            arm.inertia_com_kg_m2[i] *= (INERTIA_RELATIVE_SD * drawn(3 + i as u64)).exp();
        }
        for i in 0..2 {
            arm.base_to_joint_m[i] += LENGTH_SD_M * drawn(6 + i as u64);
            let moved = LENGTH_SD_M * drawn(8 + i as u64);
            arm.joint_to_com_m[i] += moved;
            if i == 0 {
                arm.com_to_next_m += LINK_1_LENGTH_SD_M * drawn(10) - moved; // the length of link 1 is known
            }
        }
        ChaserPrior {
            arm,
            mass_relative_sd,
            inertia_relative_sd: [INERTIA_RELATIVE_SD; 3],
            length_sd_m: LENGTH_SD_M,
            link_1_length_sd_m: LINK_1_LENGTH_SD_M,
            grasp_m: number(&self.after.plant, "grasp.position.x"),
        }
    }

    fn identified(&self, seed: u64, record: usize) -> Option<Identified> {
        let before = weighted(&self.before, &self.before.wired(self.before.arm_record(seed, record)))?;
        let after = weighted(&self.after, &self.after.wired(self.after.arm_record(seed, record)))?;
        let flying = self.flying.filtered(&self.flying.record(seed, record))?;
        Some(Identified { before, after, flying: Some(flying) })
    }

    fn answer(&self, found: &TargetEstimate) -> Answer {
        let values = found.values();
        let sigma = |i: usize| Some(found.covariance[(i, i)].sqrt());
        Answer {
            found: (0..4).map(|i| Some(Found { value: values[i], sigma: sigma(i) })).collect(),
            nees: nees(&(values - self.truth()), &found.covariance),
            spurious: 0,
            ..Answer::default()
        }
    }

    /// Sigmas from the bounds of the three experiments.
    fn bound(&self) -> Option<Vector4<f64>> {
        let before = Estimate {
            alpha: super::truth(&self.before.plant),
            covariance: self.before.momentum_information().bound()?,
        };
        let after =
            Estimate { alpha: super::truth(&self.after.plant), covariance: self.after.momentum_information().bound()? };
        let flying = Estimate { alpha: self.flying.truth(), covariance: self.flying.bound()?.covariance };
        let identified = Identified { before, after, flying: Some(flying) };
        let found = recover(&self.prior(None), &identified, &GUESS).ok()?;
        Some(found.covariance.diagonal().map(f64::sqrt))
    }
}

impl Benchmark for Chain {
    fn name(&self) -> &'static str {
        "target"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bound) = (self.truth(), self.bound()?);
        Some((0..4).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let stream = Stream::new(seed, &format!("record{record}.data_sheet"));
        let found =
            self.identified(seed, record).map(|identified| recover(&self.prior(Some(&stream)), &identified, &GUESS));
        vec![match found {
            Some(Ok(found)) => self.answer(&found),
            _ => Answer::none(4),
        }]
    }

    fn costs(&self) -> Vec<Cost> {
        let Some(identified) = self.identified(0, 0) else { return Vec::new() };
        vec![cost(1, || recover(&self.prior(None), &identified, &GUESS), |_| ())]
    }
}
