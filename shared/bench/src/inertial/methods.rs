//! The methods of the benchmark by name: one line each in the list, one function each below.

use super::{Answer, Inertial, Model, Record, TORQUE_SCALE_SD, commanded};
use crate::arm_smoother::{SmootherStep, smooth};
use crate::campaign::Method;
use crate::dynamic_equation_methods::{self as row_by_row, RowFilter, Rows};
use crate::momentum_methods as momentum;
use crate::rank_one::constrain;
use estimation::weighted_least_squares::Estimate;
use nalgebra::{SMatrix, SVector};
use physics::arm_filter::{ArmFilter, ArmFilterSettings, self_start};
use physics::arm_live::{LiveEstimators, LiveSettings};
use physics::dynamic_equation::ArmSample;
use physics::inertial_estimator::InertialEstimator;
use physics::weak_form::{WeakEstimate, WeakSettings, weak_form};

/// Table III of the paper, TLS and IV alike.
const TABLE_III_PERCENT: &[f64] = &[0.09, 0.28, 0.25, 0.57, 0.18, 0.10, 0.38, 0.02];
/// Table IV: TLS, IV, UKF.
const TABLE_IV_TLS_PERCENT: &[f64] = &[12.67, 18.46, 5.53, 13.67, 17.31, 8.03, 4.49, 2.95];
const TABLE_IV_IV_PERCENT: &[f64] = &[8.16, 17.44, 5.23, 18.15, 14.64, 4.50, 5.54, 1.64];
const TABLE_IV_UKF_PERCENT: &[f64] = &[0.28, 0.74, 3.66, 10.05, 13.77, 0.00, 8.22, 8.19];

/// Low-pass before the rows of the dynamic equation: six times the top harmonic of trajectory B.
const CUT_HZ: f64 = 1.0;
const STRIDE: usize = 20;
/// Test functions of the weak form.
const WINDOW_S: f64 = 4.0;
/// The stretch a filter starts itself from.
const START_S: f64 = 20.0;
/// What a filter's start is believed to, relative.
const START_RELATIVE_SD: f64 = 1.0;
/// Passes of the smoother.
const SMOOTHER_PASSES: usize = 2;

/// A method, its model, and what it makes of a record.
#[derive(Clone, Debug)]
pub(super) struct Estimator<const P: usize, const A: usize> {
    pub method: Method,
    pub model: Model,
    pub find: fn(&Inertial<P, A>, &Record) -> Answer,
    pub smoother_bound: fn(&Inertial<P, A>, &[ArmSample], bool) -> Option<SMatrix<f64, P, P>>,
}

type Row<const P: usize, const A: usize> =
    (&'static str, &'static [f64], Model, fn(&Inertial<P, A>, &Record) -> Answer);

fn listed<const P: usize, const A: usize, const X: usize>(rows: Vec<Row<P, A>>) -> Vec<Estimator<P, A>> {
    let row = |(name, paper_percent, model, find)| Estimator {
        method: Method { name, paper_percent },
        model,
        find,
        smoother_bound: Inertial::smoother_bound::<X>,
    };
    rows.into_iter().map(row).collect()
}

/// The methods on eight parameters.
pub(super) fn before_capture() -> Vec<Estimator<8, 9>> {
    let (iii, tls, iv, ukf) = (TABLE_III_PERCENT, TABLE_IV_TLS_PERCENT, TABLE_IV_IV_PERCENT, TABLE_IV_UKF_PERCENT);
    listed::<8, 9, 13>(vec![
        ("momentum-ls", iii, Model::Momentum, momentum_ls),
        ("momentum-tls", iii, Model::Momentum, momentum_tls),
        ("momentum-gtls", iii, Model::Momentum, momentum_gtls),
        ("momentum-iv", iii, Model::Momentum, momentum_iv),
        ("momentum-wls-bc", iii, Model::Momentum, momentum_weighted),
        ("momentum-wls-bc-recursive", iii, Model::Momentum, momentum_recursive),
        ("momentum-wls-bc-rank1", iii, Model::RankOne, momentum_rank_one),
        ("de-ls-raw", tls, Model::Torque, |at, record| row_by_row_ls(at, record, &RowFilter::raw())),
        ("de-tls-raw", tls, Model::Torque, |at, record| row_by_row_tls(at, record, &RowFilter::raw())),
        ("de-iv-raw", iv, Model::Torque, |at, record| row_by_row_iv(at, record, &RowFilter::raw())),
        ("de-ls-filtered", tls, Model::Torque, |at, record| row_by_row_ls(at, record, &filtered(at))),
        ("de-tls-filtered", tls, Model::Torque, |at, record| row_by_row_tls(at, record, &filtered(at))),
        ("de-iv-filtered", iv, Model::Torque, |at, record| row_by_row_iv(at, record, &filtered(at))),
        ("de-weak", ukf, Model::Torque, weak),
        ("ukf", ukf, Model::Torque, |at, record| unscented::<8, 9, 13>(at, record, false)),
        ("ukf-momentum", ukf, Model::Joint, |at, record| unscented::<8, 9, 13>(at, record, true)),
        ("ukf-flight", ukf, Model::Torque, flown::<8, 9, 13>),
        ("ukf-flight-scale", ukf, Model::ScaledTorque, flown_scaled::<8, 9, 13>),
        ("ml-smoother-no-h", ukf, Model::Torque, |at, record| smoothed::<8, 9, 13>(at, record, false)),
        ("ml-smoother", ukf, Model::Joint, |at, record| smoothed::<8, 9, 13>(at, record, true)),
    ])
}

/// The methods on nine parameters; the paper has none.
pub(super) fn after_capture() -> Vec<Estimator<9, 10>> {
    listed::<9, 10, 14>(vec![
        ("momentum-ls", &[], Model::Momentum, momentum_ls),
        ("momentum-tls", &[], Model::Momentum, momentum_tls),
        ("momentum-wls-bc", &[], Model::Momentum, momentum_weighted),
        ("momentum-wls-bc-recursive", &[], Model::Momentum, momentum_recursive),
        ("de-weak", &[], Model::Torque, weak),
        ("ukf", &[], Model::Torque, |at, record| unscented::<9, 10, 14>(at, record, false)),
        ("ukf-flight", &[], Model::Torque, flown::<9, 10, 14>),
        ("ukf-flight-scale", &[], Model::ScaledTorque, flown_scaled::<9, 10, 14>),
        ("ml-smoother-no-h", &[], Model::Torque, |at, record| smoothed::<9, 10, 14>(at, record, false)),
        ("ml-smoother", &[], Model::Joint, |at, record| smoothed::<9, 10, 14>(at, record, true)),
    ])
}

/// `P − P g g' P / (g' P g)`: the bound with the constraint, at the truth.
pub(super) fn rank_one_bound<const P: usize>(
    truth: &SVector<f64, P>,
    bound: &SMatrix<f64, P, P>,
) -> Option<SMatrix<f64, P, P>> {
    let gradient = SVector::<f64, P>::from_fn(|i, _| match i {
        3 => truth[6],
        4 => -truth[5],
        5 => -truth[4],
        6 => truth[3],
        _ => 0.0,
    });
    let across = bound * gradient;
    let variance = gradient.dot(&across);
    (variance > 0.0).then(|| bound - across * across.transpose() / variance)
}

/// Values without a covariance.
fn bare<const P: usize, E>(alpha: Result<SVector<f64, P>, E>) -> Answer {
    alpha.map_or_else(|_| Answer::none(P), |alpha| Answer::bare(alpha.iter().copied()))
}

fn claimed<const P: usize, const A: usize, E>(at: &Inertial<P, A>, estimate: Result<Estimate<P>, E>) -> Answer {
    estimate.map_or_else(|_| Answer::none(P), |estimate| at.answer(&estimate))
}

fn momentum_ls<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    claimed(at, momentum::least_squares(&record.motions, at.momentum(), &at.settings.sigma))
}

fn momentum_tls<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    bare(momentum::total_least_squares::<P, A>(&record.motions, at.momentum()))
}

fn momentum_gtls<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    bare(momentum::generalised_total_least_squares::<P, A>(&record.motions, at.momentum(), &at.settings.sigma))
}

fn momentum_iv<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    let (command, interval_s) = (commanded(&at.plant), at.interval_s());
    let reference = |k: usize| command.at(k as f64 * interval_s);
    claimed(at, momentum::instrumental(&record.motions, reference, at.momentum(), &at.settings.sigma))
}

pub(super) fn weighted<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Option<Estimate<P>> {
    let settings = &at.settings;
    momentum::weighted(&record.motions, at.momentum(), &settings.sigma, &settings.prior_alpha)
        .ok()
        .map(|(found, _)| found)
}

fn momentum_weighted<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    claimed(at, weighted(at, record).ok_or(()))
}

fn momentum_recursive<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    let mut estimator = InertialEstimator::new(&at.settings).expect("the momentum of the benchmark is known");
    for sample in &record.motions {
        estimator.push(sample).expect("simulated samples are finite");
    }
    let estimate = estimator.estimate().map(|found| Estimate { alpha: found.alpha, covariance: found.covariance });
    claimed(at, estimate)
}

/// The constrained covariance is singular across the constraint, so there is no NEES.
fn momentum_rank_one(at: &Inertial<8, 9>, record: &Record) -> Answer {
    let found = weighted(at, record).and_then(|estimate| constrain(&estimate));
    Answer { nees: None, ..claimed(at, found.ok_or(())) }
}

fn filtered<const P: usize, const A: usize>(at: &Inertial<P, A>) -> RowFilter {
    RowFilter::low_pass(CUT_HZ, at.interval_s(), STRIDE)
}

fn rows<'a, const P: usize, const A: usize>(
    at: &Inertial<P, A>,
    record: &'a Record,
    filter: &'a RowFilter,
) -> Rows<'a> {
    Rows { samples: &record.samples, filter, interval_s: at.interval_s() }
}

fn row_by_row_ls<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record, filter: &RowFilter) -> Answer {
    bare(row_by_row::least_squares::<P>(&rows(at, record, filter)))
}

fn row_by_row_tls<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record, filter: &RowFilter) -> Answer {
    bare(row_by_row::total_least_squares::<P, A>(&rows(at, record, filter)))
}

/// Instruments from the commanded motion; the start is that of all methods, 55 % of the truth.
fn row_by_row_iv<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record, filter: &RowFilter) -> Answer {
    let command = commanded(&at.plant);
    let start = &at.settings.prior_alpha;
    bare(row_by_row::instrumental(&rows(at, record, filter), |time_s| command.at(time_s), start))
}

fn weak_estimate<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Option<WeakEstimate<P>> {
    let settings = WeakSettings {
        interval_s: at.interval_s(),
        window_samples: (WINDOW_S / at.interval_s()).round() as usize,
        channel_sigma: at.settings.sigma.in_channel_order(),
        torque_sigma_n_m: at.torque_sigma_n_m(),
    };
    weak_form::<P>(&record.samples, &settings).ok()
}

fn weak<const P: usize, const A: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    claimed(at, weak_estimate(at, record).map(|found| found.estimate).ok_or(()))
}

fn unscented<const P: usize, const A: usize, const X: usize>(
    at: &Inertial<P, A>,
    record: &Record,
    momentum_known: bool,
) -> Answer {
    // the filter knows what it is started with, and nothing of the truth
    let scale = at.settings.prior_alpha.map(f64::abs);
    let prior = ArmFilterSettings {
        start: at.settings.prior_alpha,
        start_sd: scale * START_RELATIVE_SD,
        scale,
        sigma: at.settings.sigma,
        torque_sigma_n_m: at.torque_sigma_n_m(),
        interval_s: at.interval_s(),
        h_nms: momentum_known.then_some(at.settings.h_nms),
    };
    let stretch = ((START_S / at.interval_s()) as usize).min(record.samples.len());
    let settings = self_start(&record.samples[..stretch], &prior).unwrap_or(prior);
    let mut filter = ArmFilter::<P, X>::new(&settings);
    let done = record.samples.iter().try_for_each(|sample| filter.push(sample));
    claimed(at, done.map(|()| filter.estimate()))
}

/// The filter as it flies beside the momentum's estimate, started by it.
fn flown<const P: usize, const A: usize, const X: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    claimed(at, live::<P, X>(&record.samples, &live_settings(at)).ok_or(()))
}

/// The same with the momentum believed wrongly and torque sensors whose common scale is off by a
/// sigma that is declared.
fn flown_scaled<const P: usize, const A: usize, const X: usize>(at: &Inertial<P, A>, record: &Record) -> Answer {
    let mut settings = LiveSettings { torque_scale_sd: TORQUE_SCALE_SD, ..live_settings(at) };
    settings.momentum.h_nms *= 1.0 + record.unknown.momentum;
    let mut samples = record.samples.clone();
    let scaled = |torque_n_m: f64| torque_n_m * (1.0 + record.unknown.torque_scale);
    samples.iter_mut().for_each(|sample| sample.torque_n_m = sample.torque_n_m.map(scaled));
    claimed(at, live::<P, X>(&samples, &settings).ok_or(()))
}

fn live_settings<const P: usize, const A: usize>(at: &Inertial<P, A>) -> LiveSettings<P> {
    LiveSettings {
        momentum: at.settings,
        torque_sigma_n_m: Some(at.torque_sigma_n_m()),
        torque_scale_sd: 0.0,
        interval_ns: (1e9 * at.interval_s()).round() as u64,
    }
}

/// From motion and torques, as it is published.
fn live<const P: usize, const X: usize>(samples: &[ArmSample], settings: &LiveSettings<P>) -> Option<Estimate<P>> {
    let mut live = LiveEstimators::<P, X>::new(settings).ok()?;
    for (k, sample) in samples.iter().enumerate() {
        live.push(k as u64 * settings.interval_ns, sample).ok()?;
    }
    live.torque()
}

fn smoothed<const P: usize, const A: usize, const X: usize>(
    at: &Inertial<P, A>,
    record: &Record,
    momentum_known: bool,
) -> Answer {
    let Some(start) = weak_estimate(at, record) else { return Answer::none(P) };
    let mut steps = vec![SmootherStep::<X>::default(); record.samples.len()];
    let settings = at.smoother_settings(momentum_known);
    let found = smooth(&record.samples, &start.estimate.alpha, &settings, SMOOTHER_PASSES, &mut steps);
    claimed(at, found.map(|found| found.estimate))
}
