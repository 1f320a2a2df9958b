//! Short seeded slices of the campaigns of `obsid bench`: accuracy against the bound, and honesty
//! of the covariance.
//!
//! Tolerances: with n records an RMSE spreads by 1/√(2n), a mean NEES of d parameters by √(2d/n);
//! bands are three of these around what the method attains in long campaigns. Intervals of one
//! record are correlated: the coverage of n records of d parameters spreads at most by √(0.95 ·
//! 0.05 / n).

use crate::claims::{Claim, demand};
use bench::campaign::{Benchmark, Campaign, statistics, statistics_against};
use bench::inertial::Inertial;
use bench::inertial::flying::Flying;
use bench::inertial::late::Late;
use bench::inertial::operational::Operational;
use bench::inertial::sheet::Sheet;
use bench::inertial::target::Chain;
use bench::inertial::wheel::Wheel;
use bench::modes::Modes;
use bench::report::MethodReport;
use bench::slosh::{self, Slosh};

/// Not the seed that `obsid bench` takes by default.
pub const SEED: u64 = 2024;

/// Statistics of every method over `records` records of `flown`, judged by truth and bound of
/// `nominal`.
pub fn methods<B: Benchmark>(flown: &B, nominal: &B, records: usize) -> Vec<MethodReport> {
    let parameters = nominal.parameters().expect("the benchmark excites");
    let answers = Campaign::new(records, SEED).run(flown, &|| ());
    statistics(flown.methods(), &parameters, &answers)
}

/// Three relative standard deviations of an RMSE.
pub fn spread(records: usize) -> f64 {
    3.0 / (2.0 * records as f64).sqrt()
}

pub fn honest(report: &MethodReport, records: usize) -> Vec<Claim> {
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

/// The estimator that flies.
const FLIGHT: &str = "momentum-wls-bc-recursive";

/// Efficiency of least squares, total least squares and the estimator that flies, on eight
/// parameters.
pub fn inertial_claims(flown: &Inertial<8, 9>, records: usize) -> Vec<Claim> {
    let flown = flown.clone().only(&["momentum-ls", "momentum-tls", FLIGHT]);
    let reports = methods(&flown, &Inertial::bp1a(), records);
    let mut claims = honest(&reports[2], records);
    // The logarithms of eight ratios, correlated, average to 0.4 of the spread of one (200 records:
    // 2 % of 5 %).
    for (report, attained) in reports.iter().zip([1.08, 1.08, 1.0]) {
        let limit = attained * (1.0 + 0.4 * spread(records));
        claims.push(Claim::at_most(format!("{} RMSE/CRLB", report.name), report.geomean_rmse_over_crlb, limit));
    }
    claims
}

/// Worst efficiency of the estimator that flies, on nine parameters.
pub fn mated_claims(flown: &Inertial<9, 10>, records: usize) -> Vec<Claim> {
    let report = &methods(&flown.clone().only(&[FLIGHT]), &Inertial::mated(), records)[0];
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

/// RMSE of frequencies and damping ratios, the identifier that flies.
pub fn modal_claims(flown: &Modes, records: usize) -> Vec<Claim> {
    let report = &methods(flown, &Modes::flight(), records)[0];
    let mut claims = honest(report, records);
    // SSI-COV with i = 40 and the order given attains this [%]; the order found here must cost
    // nothing.
    for (row, attained) in report.parameters.iter().zip([0.0017, 0.155, 0.0014, 0.146]) {
        let limit = attained * (1.0 + spread(records));
        claims.push(Claim::at_most(format!("{} RMSE %", row.name), row.rmse_percent, limit));
    }
    claims
}

/// Maximum likelihood with the torque known, at the bound with honest intervals.
pub fn likelihood_claims(flown: &Modes, nominal: &Modes, records: usize) -> Vec<Claim> {
    let report = &methods(flown, nominal, records)[0];
    let mut claims = honest(report, records);
    for row in &report.parameters {
        let limit = 1.0 + spread(records);
        claims.push(Claim::at_most(format!("{} RMSE/CRLB", row.name), row.rmse_over_crlb, limit));
    }
    claims.extend(shape_claims(report));
    claims
}

/// Every mode found in every record, with its true shape.
fn shape_claims(report: &MethodReport) -> Vec<Claim> {
    let mut claims = vec![Claim::at_most(format!("{} missed", report.name), report.missed as f64, 0.0)];
    for error in &report.shape_error_max {
        claims.push(Claim::at_most(format!("{} 1 - MAC", report.name), *error, 1e-5));
    }
    claims
}

#[test]
fn momentum_estimators_attain_the_bound_from_closed_loop_records() {
    demand(&inertial_claims(&Inertial::bp1a(), 30));
}

#[test]
fn torques_and_momentum_together_attain_the_bound_of_their_own_model() {
    let (records, bench) = (8, Inertial::bp1a().only(&["de-weak", "ukf", "ukf-momentum", "ml-smoother"]));
    let (parameters, bounds) = (bench.parameters().expect("exciting"), bench.method_bounds().expect("exciting"));
    let answers = Campaign::new(records, SEED).run(&bench, &|| ());
    let reports = statistics_against(bench.methods(), &parameters, Some(&bounds), &answers);
    let mut claims = Vec::new();
    // 200 records attain 1.14, 1.09, 1.06, 1.06. Without the momentum one number, the scale, moves
    // all parameters together: the mean of the logarithms then spreads as one ratio does, not as
    // eight.
    for (report, (attained, share)) in reports.iter().zip([(1.14, 1.0), (1.09, 1.0), (1.06, 0.5), (1.06, 0.5)]) {
        claims.extend(honest(report, records));
        let limit = attained * (1.0 + share * spread(records));
        claims.push(Claim::at_most(format!("{} RMSE/CRLB", report.name), report.geomean_rmse_over_crlb, limit));
    }
    demand(&claims);
}

#[test]
fn the_constraint_of_the_eight_parameters_cuts_the_error_of_a7_by_more_than_half() {
    let (records, bench) = (30, Inertial::bp1a().only(&["momentum-wls-bc-rank1"]));
    let report = &methods(&bench, &bench, records)[0];
    let limit = 0.38 * (1.0 + spread(records));
    demand(&[Claim::at_most("a7 RMSE over the bound of eight", report.parameters[6].rmse_over_crlb, limit)]);
}

#[test]
fn unfiltered_differences_fail_as_the_paper_reports_and_the_same_rows_filtered_do_not() {
    let (records, bench) = (6, Inertial::bp1a().only(&["de-ls-raw", "de-iv-filtered"]));
    let reports = methods(&bench, &bench, records);
    let worst =
        |report: &MethodReport| report.parameters.iter().filter_map(|row| row.median_percent).fold(0.0_f64, f64::max);
    demand(&[
        Claim::within("raw, worst median %", worst(&reports[0]), 20.0, f64::INFINITY),
        Claim::at_most("filtered, worst median %", worst(&reports[1]), 0.05 * (1.0 + spread(records))),
    ]);
}

#[test]
fn the_free_flying_arm_is_found_at_its_bound_with_its_mass_absolute() {
    let (records, bench) = (6, Flying::bp1b());
    let report = &methods(&bench, &bench, records)[1];
    let mut claims = honest(report, records);
    claims.push(Claim::at_most("M RMSE/CRLB", report.parameters[0].rmse_over_crlb, 1.0 + spread(records)));
    demand(&claims);
}

#[test]
fn the_target_is_weighed_through_the_whole_chain() {
    let (records, bench) = (4, Chain::bp1());
    let report = &methods(&bench, &bench, records)[0];
    let mut claims = honest(report, records);
    // Bars of the p95 of long campaigns: 0.1 %, 0.8 mm of 0.6 m and 0.15 m, 0.6 %.
    for (row, limit) in report.parameters.iter().zip([0.1, 0.13, 0.53, 0.6]) {
        claims.push(Claim::at_most(format!("{} p95 %", row.name), row.p95_percent, limit));
    }
    demand(&claims);
}

#[test]
fn latency_and_outside_torque_are_found_along_and_left_out_they_spoil_everything() {
    let (records, bench) = (12, Late::bp1a());
    let reports = methods(&bench, &bench, records);
    let mut claims = honest(&reports[1], records);
    // All ten in proportion to their bounds: the mean of the logarithms spreads as in
    // `inertial_claims`.
    let limit = 1.05 * (1.0 + 0.4 * spread(records));
    claims.push(Claim::at_most("with the columns, RMSE/CRLB", reports[1].geomean_rmse_over_crlb, limit));
    let worst = reports[0].parameters[..8].iter().filter_map(|row| row.rmse_over_crlb).fold(0.0, f64::max);
    claims.push(Claim::within("without them, worst RMSE/CRLB", worst, 10.0, f64::INFINITY));
    demand(&claims);
}

#[test]
fn with_errors_of_the_sheets_drawn_at_random_only_the_considered_covariance_is_honest() {
    let (records, bench) = (30, Sheet::bp1a());
    let reports = methods(&bench, &bench, records);
    let mut claims = honest(&reports[1], records);
    claims.push(Claim::within("NEES of the noise alone", reports[0].nees, 20.0, f64::INFINITY));
    demand(&claims);
}

#[test]
fn an_ordinary_move_sharpens_the_prior_and_its_sigma_stays_honest() {
    let (records, bench) = (40, Operational::bp1a());
    demand(&honest(&methods(&bench, &bench, records)[0], records));
}

#[test]
fn a_modulated_wheel_gives_the_nine_parameters_and_the_momentum_at_their_bound() {
    let (records, bench) = (8, Wheel::mated());
    let report = &methods(&bench, &bench, records)[0];
    let mut claims = honest(report, records);
    // One number, the scale, moves most of them together.
    let limit = 1.0 + spread(records);
    claims.push(Claim::at_most("wheel RMSE/CRLB", report.geomean_rmse_over_crlb, limit));
    demand(&claims);
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
fn modes_of_a_free_decay_are_found_without_being_told_the_order() {
    demand(&modal_claims(&Modes::flight(), 20));
}

#[test]
fn maximum_likelihood_attains_the_bound_whether_or_not_a_loop_is_closed_around_the_hub() {
    for benchmark in [Modes::bp3a(), Modes::bp3b()] {
        let alone = benchmark.only(&["ml".into()]);
        demand(&likelihood_claims(&alone, &alone, 100));
    }
}

#[test]
fn every_other_method_comes_as_near_as_an_independent_study_says() {
    // RMSE [%] that the study demands of 100 records; ten records scatter by a factor of 1 + 3/√20.
    let limits: [(&str, f64, f64); 6] = [
        ("lsce", 0.0010, 0.11),
        ("rfp", 0.0010, 0.12),
        ("ssi-cov", 0.0020, 0.17),
        ("ssi-data", 0.0020, 0.17),
        ("era", 0.0011, 0.14),
        ("po-moesp", 0.0020, 0.22),
    ];
    let records = 6;
    let names: Vec<String> = limits.iter().map(|(name, ..)| (*name).into()).collect();
    let benchmark = Modes::bp3a().only(&names);
    for (report, (_, f, zeta)) in methods(&benchmark, &benchmark, records).iter().zip(limits) {
        let mut claims = shape_claims(report);
        for (row, limit) in report.parameters.iter().zip([f, zeta, f, zeta]) {
            let what = format!("{} {} RMSE %", report.name, row.name);
            claims.push(Claim::at_most(what, row.rmse_percent, limit * (1.0 + spread(records))));
        }
        demand(&claims);
    }
}

#[test]
fn outputs_alone_between_the_steps_of_a_loop_show_the_closed_loop_and_not_the_appendage() {
    let names = ["lsce", "ssi-cov", "ssi-data", "era"];
    let benchmark = Modes::bp3b_outputs().only(&names.map(String::from));
    let records = 6;
    let reports = methods(&benchmark, &benchmark, records);
    for report in &reports {
        let mut claims = shape_claims(report);
        // RMSE [%] of f1, ζ1, ζ2 demanded by the study of its best method.
        for (row, limit) in report.parameters.iter().zip([0.03, 0.12, 0.005, 0.16]) {
            let what = format!("{} {} RMSE %", report.name, row.name);
            claims.push(Claim::at_most(what, row.rmse_percent, limit * (1.0 + spread(records))));
        }
        demand(&claims);
    }
    // Sampled loop of the study: 1.53177 Hz, 0.19988; 6.48349 Hz, 0.013750. The hub-free damping is
    // 0.778 %.
    let printed = [1.531_77, 0.199_88, 6.483_49, 0.013_750];
    for (row, print) in reports[0].parameters.iter().zip(printed) {
        assert!((row.truth / print - 1.0).abs() < 5e-5, "{} {print}", row.truth); // last digit printed
    }
}

/// Bounds [%] of the free decay alone.
fn decay_percent(benchmark: &Modes) -> Vec<f64> {
    let truth = benchmark.true_modes();
    let bounds = benchmark.decay_bounds().expect("the decay shows both modes");
    let percent = |(mode, bound): (_, &(f64, f64))| {
        let mode: &bench::modes::TrueMode = mode;
        [100.0 * bound.0 / mode.frequency_hz(), 100.0 * bound.1 / mode.damping_ratio()]
    };
    truth.iter().zip(&bounds).flat_map(percent).collect()
}

#[test]
fn bounds_of_the_experiments_are_those_of_an_independent_study() {
    let percent = |parameters: Option<Vec<bench::campaign::Parameter>>| -> Vec<f64> {
        parameters.expect("exciting").iter().map(|row| 100.0 * row.bound / row.truth.abs()).collect()
    };
    // Relative tolerance: half a unit of the last printed digit of the smallest number, and 0.5 %
    // for details of the motion.
    let printed: [(Vec<f64>, f64, &[f64]); 6] = [
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
        (percent(Modes::bp3a().parameters()), 0.005, &[0.000558, 0.0725, 0.000522, 0.0626]),
        (percent(Modes::bp3b().parameters()), 0.005, &[0.001660, 0.1956, 0.000523, 0.0624]),
        (decay_percent(&Modes::bp3a()), 0.01, &[0.000606, 0.0797, 0.000579, 0.0694]),
    ];
    for (bounds, tolerance, printed) in printed {
        for (bound, print) in bounds.iter().zip(printed) {
            assert!((bound / print - 1.0).abs() < tolerance, "{bounds:?} {printed:?}");
        }
    }
}
