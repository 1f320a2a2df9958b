//! Short seeded slices of the campaigns of `obsid bench`: accuracy against the bound, and honesty of the covariance.
//!
//! Tolerances: with n records an RMSE spreads by 1/√(2n), a mean NEES of d parameters by √(2d/n); bands are three of these
//! around what the method attains in long campaigns. Intervals of one record are correlated: the coverage of n records of d
//! parameters spreads at most by √(0.95 · 0.05 / n).

use crate::claims::{Claim, demand};
use console::bench::campaign::{Benchmark, Campaign, statistics};
use console::bench::inertial::{self, Inertial};
use console::bench::modes::Modes;
use console::bench::report::MethodReport;
use console::bench::slosh::{self, Slosh};

/// Not the seed that `obsid bench` takes by default.
const SEED: u64 = 2024;

/// Statistics of every method over `records` records of `flown`, judged by truth and bound of `nominal`.
pub fn methods<B: Benchmark>(flown: &B, nominal: &B, records: usize) -> Vec<MethodReport> {
    let parameters = nominal.parameters().expect("the benchmark excites");
    let answers = Campaign::new(records, SEED).run(flown, &|| ());
    statistics(flown.methods(), &parameters, &answers)
}

/// Three relative standard deviations of an RMSE.
fn spread(records: usize) -> f64 {
    3.0 / (2.0 * records as f64).sqrt()
}

fn honest(report: &MethodReport, records: usize) -> Vec<Claim> {
    let (n, d) = (records as f64, report.dof as f64);
    let nees = 3.0 * (2.0 * d / n).sqrt();
    let coverage: Option<f64> =
        report.parameters.iter().map(|row| row.coverage95).sum::<Option<f64>>().map(|sum| sum / d);
    vec![
        Claim::at_most(format!("{} failures", report.name), report.missed as f64, 0.0),
        Claim::at_most(format!("{} spurious", report.name), report.spurious as f64, 0.0),
        Claim::within(format!("{} NEES", report.name), report.nees, d - nees, d + nees),
        Claim::within(format!("{} coverage", report.name), coverage, 0.95 - 3.0 * (0.0475 / n).sqrt(), 1.0),
    ]
}

/// Efficiency of least squares, total least squares and the estimator that flies, on eight parameters.
pub fn inertial_claims(flown: &Inertial<8, 9>, records: usize) -> Vec<Claim> {
    let reports = methods(flown, &Inertial::bp1a(), records);
    let mut claims = honest(&reports[inertial::FLIGHT], records);
    // The logarithms of eight ratios, correlated, average to 0.4 of the spread of one (200 records: 2 % of 5 %).
    for (report, attained) in reports.iter().zip([1.08, 1.08, 1.0]) {
        let limit = attained * (1.0 + 0.4 * spread(records));
        claims.push(Claim::at_most(format!("{} RMSE/CRLB", report.name), report.geomean_rmse_over_crlb, limit));
    }
    claims
}

/// Worst efficiency of the estimator that flies, on nine parameters.
pub fn mated_claims(flown: &Inertial<9, 10>, records: usize) -> Vec<Claim> {
    let report = &methods(flown, &Inertial::mated(), records)[inertial::FLIGHT];
    let worst = report.parameters.iter().filter_map(|row| row.rmse_over_crlb).fold(0.0, f64::max);
    let mut claims = honest(report, records);
    claims.push(Claim::at_most("mated worst RMSE/CRLB", worst, 1.0 + spread(records)));
    claims
}

/// RMSE of slosh mass, stiffness, damping.
pub fn slosh_claims(flown: &Slosh, records: usize) -> Vec<Claim> {
    let report = &methods(flown, &Slosh::bp2(), records)[slosh::FLIGHT];
    let mut claims = honest(report, records);
    for row in &report.parameters {
        let limit = 1.0 + spread(records);
        claims.push(Claim::at_most(format!("{} RMSE/CRLB", row.name), row.rmse_over_crlb, limit));
    }
    claims
}

/// RMSE of frequencies and damping ratios.
pub fn modal_claims(flown: &Modes, records: usize) -> Vec<Claim> {
    let report = &methods(flown, &Modes::bp3a(), records)[0];
    let mut claims = honest(report, records);
    // SSI-COV with i = 40 and the order given attains this [%]; the order found here must cost nothing.
    for (row, attained) in report.parameters.iter().zip([0.0017, 0.130, 0.0014, 0.139]) {
        let limit = attained * (1.0 + spread(records));
        claims.push(Claim::at_most(format!("{} RMSE %", row.name), row.rmse_percent, limit));
    }
    claims
}

#[test]
fn momentum_estimators_attain_the_bound_from_closed_loop_records() {
    demand(&inertial_claims(&Inertial::bp1a(), 30));
}

#[test]
fn nine_parameters_after_capture_attain_the_bound() {
    demand(&mated_claims(&Inertial::mated(), 10));
}

#[test]
fn slosh_estimator_attains_the_bound_on_the_seed_sine() {
    demand(&slosh_claims(&Slosh::bp2(), 30));
}

#[test]
fn published_slosh_estimator_fails_on_the_damping_of_the_same_records() {
    let report = &methods(&Slosh::bp2(), &Slosh::bp2(), 30)[slosh::SEED_FORM];
    // 200 records of an independent study: median 958 %. The claim is the kind of failure, not its size.
    demand(&[Claim::within("median c_s error %", report.parameters[2].median_percent, 100.0, f64::INFINITY)]);
}

#[test]
fn modes_of_a_free_decay_are_found_without_being_told_the_order() {
    demand(&modal_claims(&Modes::bp3a(), 20));
}

#[test]
fn bounds_of_the_experiments_are_those_of_an_independent_study() {
    let percent = |parameters: Option<Vec<console::bench::campaign::Parameter>>| -> Vec<f64> {
        parameters.expect("exciting").iter().map(|row| 100.0 * row.bound / row.truth.abs()).collect()
    };
    // Relative tolerance: half a unit of the last printed digit of the smallest number, and 0.5 % for details of the motion.
    let printed: [(Vec<f64>, f64, &[f64]); 4] = [
        (
            percent(Inertial::bp1a().parameters()),
            0.015,
            &[0.0052, 0.0075, 0.0092, 0.0136, 0.0128, 0.0230, 0.0229, 0.0146],
        ),
        (
            percent(Inertial::mated().parameters()),
            0.05,
            &[0.100, 0.054, 0.011, 0.079, 0.117, 0.027, 0.059, 0.029, 0.182],
        ),
        (percent(Slosh::bp2().parameters()), 0.01, &[0.155, 0.155, 1.02]),
        (percent(Modes::bp3a().parameters()), 0.01, &[0.000606, 0.0797, 0.000579, 0.0694]),
    ];
    for (bounds, tolerance, printed) in printed {
        for (bound, print) in bounds.iter().zip(printed) {
            assert!((bound / print - 1.0).abs() < tolerance, "{bounds:?} {printed:?}");
        }
    }
}
