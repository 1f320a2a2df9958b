//! The target's mass, centre of mass and inertia: the whole chain before capture (BP1A, BP1B) and
//! after it, simulated.
//!
//! The momentum after capture is known, or found from a modulated wheel; or it is known and the
//! target states its parameters with honest sigmas, which are tested and fused. The chaser's data
//! sheet is drawn anew for every record from the sigmas that the estimator assumes.

use super::flying::Flying;
use super::methods::weighted;
use super::wheel::Wheel;
use super::{Inertial, planar_arm};
use crate::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::simulated::number;
use dynamics::noise::Stream;
use estimation::consistency::nees;
use estimation::weighted_least_squares::Estimate;
use nalgebra::{Matrix4, Vector4};
use physics::mated::Target;
use physics::target::{ChaserPrior, Identified, TargetEstimate, recover};
use physics::target_statement::fuse;

const NAMES: [&str; 4] = ["m_t", "x_t", "y_t", "I_t"];
const METHODS: &[Method] = &[
    Method { name: "h' known", paper_percent: &[] },
    Method { name: "h' from a wheel", paper_percent: &[] },
    Method { name: "h' known, target states", paper_percent: &[] },
];
/// Sigmas of what the target states of itself.
const STATED_SD: [f64; 4] = [0.05, 5e-4, 5e-4, 0.1];
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
    wheel: Wheel,
}

impl Chain {
    /// The chain of BP1: arm before capture, flying base, arm after capture, wheel.
    pub fn bp1() -> Self {
        Self { before: Inertial::bp1a(), flying: Flying::bp1b(), after: Inertial::mated(), wheel: Wheel::mated() }
    }

    fn truth(&self) -> Vector4<f64> {
        let at = |name: &str| number(&self.after.plant, name);
        Vector4::new(at("target.mass"), at("target.com.x"), at("target.com.y"), at("target.inertia.zz"))
    }

    /// The data sheet of one record: the truth, every number off by its sigma times a normal
    /// number.
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
            grasp_sd_m: 0.0,
        }
    }

    /// Before and after capture, the momentum known; and after capture from the wheel.
    fn identified(&self, seed: u64, record: usize) -> Option<(Identified, Identified)> {
        let before = weighted(&self.before, &self.before.wired(self.before.arm_record(seed, record)))?;
        let after = weighted(&self.after, &self.after.wired(self.after.arm_record(seed, record)))?;
        let flying = Some(self.flying.filtered(&self.flying.record(seed, record))?);
        let wheel = first_nine(&self.wheel.found(seed, record)?);
        Some((Identified { before, after, flying }, Identified { before, after: wheel, flying }))
    }

    /// What the target says of itself, off by its sigmas.
    fn stated(&self, stream: &Stream) -> TargetEstimate {
        let v = Vector4::from_fn(|i, _| self.truth()[i] + STATED_SD[i] * stream.normal(100 + i as u64));
        let target = Target { mass_kg: v[0], grasp_to_com_m: [v[1], v[2]], inertia_com_kg_m2: v[3] };
        let covariance = Matrix4::from_diagonal(&Vector4::from(STATED_SD).map(|sd| sd * sd));
        TargetEstimate { target, covariance, chi_square: 0.0, degrees: 0 }
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

    /// Covariances from the bounds of the experiments: momentum known, from the wheel, known with
    /// what the target states.
    fn bounds(&self) -> Option<[Matrix4<f64>; 3]> {
        let alpha = super::truth(&self.before.plant);
        let before = Estimate { alpha, covariance: self.before.momentum_information().bound()? };
        let alpha = super::truth(&self.after.plant);
        let after = Estimate { alpha, covariance: self.after.momentum_information().bound()? };
        let wheel = self.wheel.information().bound()?.fixed_view::<9, 9>(0, 0).into_owned();
        let flying = Some(Estimate { alpha: self.flying.truth(), covariance: self.flying.bound()?.covariance });
        let of = |after| recover(&self.prior(None), &Identified { before, after, flying }, &GUESS).ok();
        let (known, unknown) = (of(after)?, of(Estimate { alpha, covariance: wheel })?);
        let stated = Matrix4::from_diagonal(&Vector4::from(STATED_SD).map(|sd| 1.0 / (sd * sd)));
        let both = (known.covariance.try_inverse()? + stated).try_inverse()?;
        Some([known.covariance, unknown.covariance, both])
    }
}

/// Without the momentum itself.
fn first_nine(found: &Estimate<10>) -> Estimate<9> {
    let alpha = found.alpha.fixed_rows::<9>(0).into_owned();
    Estimate { alpha, covariance: found.covariance.fixed_view::<9, 9>(0, 0).into_owned() }
}

impl Benchmark for Chain {
    fn name(&self) -> &'static str {
        "target"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, [bound, ..]) = (self.truth(), self.bounds()?);
        Some((0..4).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[(i, i)].sqrt() }).collect())
    }

    fn method_bounds(&self) -> Option<Vec<Vec<f64>>> {
        let sigmas = |bound: &Matrix4<f64>| bound.diagonal().map(f64::sqrt).as_slice().to_vec();
        Some(self.bounds()?.iter().map(sigmas).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let stream = Stream::new(seed, &format!("record{record}.data_sheet"));
        let Some((known, wheel)) = self.identified(seed, record) else { return vec![Answer::none(4); METHODS.len()] };
        let found = |identified: &Identified| recover(&self.prior(Some(&stream)), identified, &GUESS).ok();
        let (known, wheel) = (found(&known), found(&wheel));
        let both = known.and_then(|known| fuse(&known, &self.stated(&stream)).ok().map(|(both, _)| both));
        [known, wheel, both]
            .iter()
            .map(|found| found.as_ref().map_or_else(|| Answer::none(4), |found| self.answer(found)))
            .collect()
    }

    fn costs(&self) -> Vec<Cost> {
        let Some((identified, _)) = self.identified(0, 0) else { return Vec::new() };
        (0..METHODS.len()).map(|_| cost(1, || recover(&self.prior(None), &identified, &GUESS), |_| ())).collect()
    }
}
