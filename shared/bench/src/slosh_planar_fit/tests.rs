//! Sensitivities; the estimator itself is tested with the searches that use it (`slosh_planar_id`,
//! `slosh_planar_second`).

use super::*;
use crate::slosh_planar::{Suspension, Wrench};
use crate::slosh_planar_record::PlanarNoise;
use nalgebra::vector;

const HUB: PlanarHub = PlanarHub { mass_kg: 1004.5, inertia_com_kg_m2: 480.0, sensor_m: Vector2::new(0.5, -0.3) };

/// `[ms, k, c, bx, by]`.
fn craft(theta: &SVector<f64, 5>) -> Option<PlanarCraft<1>> {
    let suspension = Suspension::Rail {
        position_m: vector![theta[3], theta[4]],
        direction: Vector2::y(),
        stiffness_n_m: theta[1],
        damping_n_s_m: theta[2],
    };
    Some(PlanarCraft::at_rest(HUB, [PlanarSlosh { mass_kg: theta[0], suspension }]))
}

#[test]
fn an_hour_of_slosh_promises_the_same_sigmas_whatever_small_change_its_sensitivities_are_taken_over() {
    let driven = |k: u32| if k < 250 && k % 80 < 40 { 0.25 } else { -0.05 };
    let samples: Vec<PlanarSample> = (0..1800)
        .map(|k| PlanarSample {
            wrench: Wrench { force_n: vector![0.1, driven(k)], torque_n_m: 0.0 },
            ..PlanarSample::default()
        })
        .collect();
    let record = PlanarRecord::new(&samples, 2.0, PlanarNoise { acceleration_m_s2: 1e-4, rate_rad_s: 2e-5 });
    let truth = SVector::from([28.7, 0.16, 0.03, -0.45, 0.2]);
    let sigmas = |share: f64| {
        let covariance = bound(&record, &craft, (&truth, &(truth.abs() * share)), &PlanarPrior::none());
        covariance.expect("observed").diagonal().map(libm::sqrt)
    };
    let (near, far) = (sigmas(0.1), sigmas(5.0));
    // Truncation: 1e-7 of five times the scale, through 130 rad of phase and a correlation of mass
    // and stiffness of 0.999.
    let off = (far.component_div(&near) - SVector::<f64, 5>::repeat(1.0)).amax();
    assert!(off < 5e-3, "{off}");
}
