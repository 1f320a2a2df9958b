//! Spring or pendulum? Three levels of axial thrust tell: a pendulum stiffens in proportion, a
//! spring does not.
//!
//! Each level alone gives a stiffness, since at one level both models are the same to first order;
//! their regression `k(a) = k0 + k1 a` on the axial acceleration says which it is. The joint fit of
//! both models over all levels confirms it by the Bayesian information criterion and says whether
//! the winner explains the record.

use super::method;
use super::planar::{hub, noise, samples, summed};
use super::suspension::Judged;
use crate::campaign::{Answer, Benchmark, Campaign, Cost, Found, Method, Parameter, cost};
use crate::simulated::built_in;
use crate::slosh_planar::PlanarHub;
use crate::slosh_planar_fit::{PlanarPrior, bound};
use crate::slosh_planar_id::ONE_AXIS;
use crate::slosh_planar_record::{PlanarNoise, PlanarRecord};
use crate::slosh_planar_scan::PlanarSample;
use crate::slosh_suspension::{SuspensionKind, SuspensionVerdict, decide};
use dynamics::description::{Plant, Quantity, TankModel};
use estimation::consistency::nees;
use nalgebra::SVector;

const METHODS: &[Method] = &[method("ml", &[])];
const SPRING: [&str; ONE_AXIS] = ["m_s", "k", "c", "b_x", "b_y"];
const PENDULUM: [&str; ONE_AXIS] = ["m_s", "L", "D", "d_x", "d_y"];

/// How far from the hub's centre of mass a tank may be.
const REACH_M: f64 = 1.2;

/// A tank under three levels of thrust, and what it truly is.
#[derive(Clone, Debug)]
pub struct TankModelChoice {
    pub plant: Plant,
    pub truth: SuspensionKind,
    pub hub: PlanarHub,
    pub noise: PlanarNoise,
}

impl TankModelChoice {
    /// As the recording r5 of an independent simulator.
    pub fn pendulum() -> Self {
        let plant = built_in("tank_pendulum");
        Self { hub: hub(&plant), noise: noise(&plant), truth: SuspensionKind::Pendulum, plant }
    }

    /// As r6: a spring of 2 N/m across the thrust.
    pub fn spring() -> Self {
        let mut plant = built_in("tank_pendulum");
        let tank = &mut plant.tanks[0];
        tank.position_m = [Quantity::known(-0.9), Quantity::known(0.0), Quantity::known(0.0)];
        tank.model = TankModel::Spring {
            axes: vec![[0.0, 1.0, 0.0]],
            stiffness_n_m: vec![Quantity::known(2.0)],
            damping_n_s_m: vec![Quantity::known(0.25)],
        };
        Self { hub: hub(&plant), noise: noise(&plant), truth: SuspensionKind::Spring, plant }
    }

    fn numbers(&self) -> SVector<f64, ONE_AXIS> {
        let tank = &self.plant.tanks[0];
        let [x, y, _] = &tank.position_m;
        let (second, third) = match &tank.model {
            TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } => (stiffness_n_m[0].value, damping_n_s_m[0].value),
            // Of a torque per rate the force per speed.
            TankModel::Pendulum { length_m, damping_n_m_s_rad, .. } => {
                (length_m.value, damping_n_m_s_rad.value / (length_m.value * length_m.value))
            }
        };
        [tank.mass_kg.value, second, third, x.value, y.value].into()
    }

    fn names(&self) -> [&'static str; ONE_AXIS] {
        if self.truth == SuspensionKind::Spring { SPRING } else { PENDULUM }
    }

    /// The samples of one record of the plant; sensors without bias.
    pub fn record(&self, seed: u64, record: usize) -> Vec<PlanarSample> {
        samples(&self.plant, seed, record, [0.0; 3])
    }

    fn record_of<'a>(&self, samples: &'a [PlanarSample]) -> PlanarRecord<'a> {
        PlanarRecord::new(samples, self.plant.simulation.period_s, self.noise)
    }

    /// What the record says of the suspension, from sums of four samples: 23 per period, whose
    /// integration is exact to 5e-5 of the frequency, a seventh of what the record tells of it.
    pub fn decide(&self, samples: &[PlanarSample]) -> Option<SuspensionVerdict> {
        const SUMMED: usize = 4;
        let (sums, interval_s) = (summed(samples, SUMMED), SUMMED as f64 * self.plant.simulation.period_s);
        let share = 1.0 / (SUMMED as f64).sqrt();
        let noise = PlanarNoise {
            acceleration_m_s2: self.noise.acceleration_m_s2 * share,
            rate_rad_s: self.noise.rate_rad_s * share,
        };
        let record = PlanarRecord::new(&sums, interval_s, noise);
        decide(&record, REACH_M, &self.hub).ok()
    }

    /// Both models beside the truth.
    pub fn judge(&self, seed: u64, record: usize) -> Option<Judged> {
        let verdict = self.decide(&self.record(seed, record))?;
        let (right, wrong) = (verdict.estimate(self.truth).estimate, verdict.estimate(self.truth.other()).estimate);
        Some(Judged {
            is_right: verdict.kind.map(|kind| kind == self.truth),
            z_right: right.z_score(),
            z_wrong: wrong.z_score(),
            error: right.theta[1] / self.numbers()[1] - 1.0,
            mass_sigmas: (right.theta[0] - self.numbers()[0]) / right.sigmas()[0],
            margin: verdict.bic(self.truth.other()) - verdict.bic(self.truth),
            offset_sigmas: verdict.regression.offset_sigmas(),
            slope_sigmas: verdict.regression.slope_sigmas(),
        })
    }
}

impl Benchmark for TankModelChoice {
    fn name(&self) -> &'static str {
        match self.truth {
            SuspensionKind::Spring => "bp2-tank-model, truth: spring",
            SuspensionKind::Pendulum => "bp2-tank-model, truth: pendulum",
        }
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, samples) = (self.numbers(), samples(&self.plant, 0, 0, [0.0; 3]));
        let mut scale = truth.abs();
        scale[4] = 0.3;
        let craft = |theta: &SVector<f64, ONE_AXIS>| self.truth.craft(self.hub, theta);
        let bound =
            bound(&self.record_of(&samples), &craft, (&truth, &scale), &PlanarPrior::none())?.diagonal().map(f64::sqrt);
        let names = self.names();
        // The last one is zero: there is no relative error of it.
        Some((0..ONE_AXIS - 1).map(|i| Parameter { name: names[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    /// The wrong choice, or one that χ² does not accept, is no answer.
    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let right = self.decide(&self.record(seed, record)).filter(|verdict| verdict.kind == Some(self.truth));
        let Some(verdict) = right else { return vec![Answer::none(ONE_AXIS - 1)] };
        let estimate = verdict.estimate(self.truth).estimate;
        let (theta, sigmas) = (estimate.theta, estimate.sigmas());
        let error = (theta - self.numbers()).fixed_rows::<{ ONE_AXIS - 1 }>(0).into_owned();
        let covariance = estimate.covariance.fixed_view::<{ ONE_AXIS - 1 }, { ONE_AXIS - 1 }>(0, 0).into_owned();
        vec![Answer {
            found: (0..ONE_AXIS - 1).map(|i| Some(Found { value: theta[i], sigma: Some(sigmas[i]) })).collect(),
            nees: nees(&error, &covariance),
            spurious: 0,
            ..Answer::default()
        }]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        vec![cost(record.len(), || (), |()| self.decide(&record))]
    }

    fn remarks(&self, _: &Campaign) -> Vec<String> {
        vec!["A wrong choice, or one that chi2 does not accept, counts as failed; 'obsid bench bp2-suspension' shows both models.".to_owned()]
    }
}
