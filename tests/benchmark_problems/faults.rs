//! One symbol wrong at a time: the law that guards it must turn red. A check never seen to fail
//! does not count.

use crate::campaigns::{inertial_claims, mated_claims, modal_claims, slosh_claims};
use crate::claims::broken;
use crate::models::{
    acceleration_discrepancy, closed_form_appendage, decay_residual, is_angle, momentum_discrepancy, number, off_axis,
    one_kind_noisy, residual_over_claim, skewed, slosh_discrepancy,
};
use bench::inertial::{Inertial, sigma, truth};
use bench::modes::Modes;
use bench::slosh::Slosh;
use dynamics::description::Plant;
use physics::appendage::{Appendage, Mode};

#[test]
fn a_wrong_symbol_in_the_arm_breaks_momentum_and_acceleration() {
    let arm = skewed();
    let right = truth::<8>(&arm.plant);
    let swap = |i: usize, j: usize| {
        let mut alpha = right;
        alpha.swap_rows(i, j);
        alpha
    };
    let mut mirrored = right;
    mirrored[7] = -mirrored[7];
    // Rounding times the condition of the mass matrix, some hundreds; `plant_dynamics` has the law.
    assert!(acceleration_discrepancy(&arm.plant, &right) < 1e-10);
    for (fault, alpha) in [("a4 with a5", swap(3, 4)), ("a6 with a7", swap(5, 6)), ("sign of a8", mirrored)] {
        assert!(momentum_discrepancy(&arm, &alpha) > 1e-2, "momentum, {fault}"); // law: 1e-8
        assert!(acceleration_discrepancy(&arm.plant, &alpha) > 1e-2, "acceleration, {fault}");
    }
    let mated = off_axis();
    let mut mirrored = truth::<9>(&mated.plant);
    mirrored[8] = -mirrored[8];
    assert!(momentum_discrepancy(&mated, &mirrored) > 1e-2);
}

#[test]
fn the_arm_of_the_table_alone_would_hide_a_swap() {
    let table = Inertial::bp1a();
    let mut swapped = truth::<8>(&table.plant);
    swapped.swap_rows(5, 6);
    assert!(momentum_discrepancy(&table, &swapped) < 1e-8); // green, although wrong: hence the skewed arm
}

#[test]
fn a_sigma_of_one_sensor_off_by_ten_percent_breaks_the_claim_of_its_residual() {
    let experiment = one_kind_noisy(is_angle, 1e-3, 0.0);
    let mut claimed = sigma(&experiment.plant);
    claimed.joint_angle_rad = [1.1e-3; 2];
    assert!(residual_over_claim(&experiment, &claimed) < 0.9); // law: 0.948
}

#[test]
fn a_wrong_mass_or_inertia_breaks_the_model_of_slosh_and_appendage() {
    assert!(slosh_discrepancy(1014.5) > 1e-5); // law: 1e-12
    let right = closed_form_appendage();
    let hub_alone = Appendage { inertia_kg_m2: 0.99 * right.inertia_kg_m2, ..right };
    let modes = hub_alone.hub_free_modes().expect("still heavy");
    assert!(mode_discrepancy(&right.hub_free_modes().expect("heavy")) < 1e-10); // rounding; `plant_dynamics` has the law
    assert!(mode_discrepancy(&modes) > 1e-4 && decay_residual(&modes) > 1e-4); // law of the decay: 2e-6
    assert!(mode_discrepancy(&right.locked) > 0.1 && decay_residual(&right.locked) > 0.1);
}

/// Worst relative difference of frequency and damping from the eigenvalues of the simulated plant.
fn mode_discrepancy(modes: &[Mode; 2]) -> f64 {
    let differ = |(closed, numeric): (&Mode, &Mode)| {
        let frequency = (closed.frequency_hz / numeric.frequency_hz - 1.0).abs();
        frequency.max((closed.damping_ratio / numeric.damping_ratio - 1.0).abs())
    };
    modes.iter().zip(&Modes::bp3a().truth()).map(differ).fold(0.0, f64::max)
}

#[test]
fn a_wrong_symbol_before_the_momentum_estimator_breaks_its_campaign() {
    type Break = fn(&mut Inertial<8, 9>);
    let faults: [(&str, Break); 6] = [
        ("sigmas of gyro and joint rates exchanged", |b| {
            let sigma = &mut b.settings.sigma;
            (sigma.omega0_rad_s, sigma.joint_rate_rad_s) = (sigma.joint_rate_rad_s[0], [sigma.omega0_rad_s; 2]);
        }),
        ("gyro sigma in degrees", |b| b.settings.sigma.omega0_rad_s *= 180.0 / core::f64::consts::PI),
        ("joint rates exchanged", |b| {
            b.wiring = |mut sample| {
                sample.joint_rate_rad_s.swap(0, 1);
                sample
            }
        }),
        ("sign of joint 2", |b| {
            b.wiring = |mut sample| {
                sample.joint_angle_rad[1] = -sample.joint_angle_rad[1];
                sample
            }
        }),
        ("momentum wrong by 0.1 %", |b| b.settings.h_nms *= 1.001),
        ("link 2 of the simulator lighter by 0.1 %", |b| scale(&mut b.plant, "link_2.mass", 0.999)),
    ];
    for (fault, wound) in faults {
        let mut wounded = Inertial::bp1a();
        wound(&mut wounded);
        expect_red(fault, &broken(&inertial_claims(&wounded, 10)));
    }
}

#[test]
fn a_target_on_the_axis_where_it_is_not_breaks_the_mated_campaign() {
    let mut wounded = Inertial::mated();
    scale(&mut wounded.plant, "target.com.y", -1.0);
    expect_red("sign of the target's offset (a9)", &broken(&mated_claims(&wounded, 4)));
}

#[test]
fn a_wrong_symbol_before_the_slosh_estimator_breaks_its_campaign() {
    type Break = fn(&mut Slosh);
    let faults: [(&str, Break); 4] = [
        ("base mass 10 kg off", |b| b.settings.base_mass_kg += 10.0),
        ("base mass is the total mass", |b| b.settings.base_mass_kg += number(&b.plant, "fuel.mass")),
        ("density taken for the sigma of a sample", |b| b.sigma_m_s2 *= 0.1_f64.sqrt()),
        ("thrust one sample late", |b| b.thrust_lag_samples = 1),
    ];
    for (fault, wound) in faults {
        let mut wounded = Slosh::bp2();
        wound(&mut wounded);
        expect_red(fault, &broken(&slosh_claims(&wounded, 10)));
    }
}

#[test]
fn a_wrong_symbol_before_the_modal_identifier_breaks_its_campaign() {
    type Break = fn(&mut Modes);
    let faults: [(&str, Break); 3] = [
        ("sample rate 0.1 % off", |b| b.config.sample_rate_hz *= 1.001),
        ("segment opened under torque", |b| b.segment_start_s = 0.5),
        ("damping of mode 1 is 0.6 %", |b| scale(&mut b.plant, "bending_1.damping_ratio", 1.2)),
    ];
    for (fault, wound) in faults {
        let mut wounded = Modes::flight();
        wound(&mut wounded);
        expect_red(fault, &broken(&modal_claims(&wounded, 5)));
    }
}

fn scale(plant: &mut Plant, name: &str, factor: f64) {
    let value = factor * number(plant, name);
    plant.set_parameter(name, value).expect("a number of the benchmark");
}

fn expect_red(fault: &str, broken: &[String]) {
    println!("{fault}:\n  {}", broken.join("\n  "));
    assert!(!broken.is_empty(), "not noticed: {fault}");
}
