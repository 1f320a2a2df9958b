//! Two verdicts on a model: is it *complete* (does it explain the data?), is it *adequate* (is it
//! good enough?).
//!
//! *Complete*: innovations are white on block means at every length, and their mean NIS lies in its
//! χ² band. *Adequate*: a simulation over data the estimate never saw errs less than the scenario's
//! need, and so does every standard deviation for which a need is stated. *Accepted* = adequate,
//! with honest sigmas, physically consistent.
//!
//! Sigmas are *honest* when the mean NIS lies in its band and no block length is coloured: a
//! covariance computed for white residuals is too small for residuals that hang together, by the
//! very factor by which their block means exceed theirs, and the error of the parameters is
//! unknown. So a model that is proven incomplete is never accepted. Only the upper side of the
//! whiteness test counts. Residuals of a fit are tested on the rows that made it; its free
//! parameters take the slow part out of them, so their block means are too small by construction.
//!
//! The held-out error is judged as measured, sensor noise included: taking the noise out would need
//! to know it exactly. Where the signal does not stand out of the noise the figure is independent
//! of the model, and the verdict says that no data were held out.
//!
//! Every limit follows from a stated false-alarm probability and the number of blocks behind the
//! figure.

use estimation::consistency::{coloured_scale, mean_square_band, tested_scales};
use serde::{Deserialize, Serialize};
use telemetry::{Domain, Estimate, Header, PARAMETERS_MAX, Phase, Reason, Verdict, parameters};

use crate::held_out::HeldOut;

/// Probability that an honest, white model is called coloured: shared by all block lengths
/// (Bonferroni).
pub const WHITENESS_FALSE_ALARM: f64 = 1e-3;
/// Probability that honest sigmas are called dishonest, both sides together.
pub const NIS_FALSE_ALARM: f64 = 1e-3;
/// Signal over noise from which a held-out test can fail: at three, a model that predicts nothing
/// at all leaves an error ten times the noise in power (3² signal and 1 of noise), below one no
/// more than twice.
pub const SIGNAL_OVER_NOISE_MIN: f64 = 3.0;
/// `Verdict::parameter` when the reason speaks of none.
const NO_PARAMETER: u16 = u16::MAX;
/// `Verdict::adequate` when it cannot be decided.
const NOT_DECIDABLE: u16 = 2;

/// What the scenario needs of one domain's model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Need {
    /// Largest standard deviation in per cent of the value, per parameter.
    pub sigma_percent: [Option<f64>; PARAMETERS_MAX],
    /// Largest rms error of the held-out simulation: rad/s (inertial) or m/s² (slosh, modal),
    /// sensor noise included.
    pub held_out_rms: Option<f64>,
}

/// The test that decides a verdict: its reason code, the parameter it speaks of, its figure and the
/// limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Finding {
    reason: Reason,
    parameter: u16,
    measured: f64,
    limit: f64,
}

impl Finding {
    const fn new(reason: Reason, measured: f64, limit: f64) -> Self {
        Self { reason, parameter: NO_PARAMETER, measured, limit }
    }
}

/// Judges `estimate`, made before `frame`; `t_ns` is the time of that frame.
///
/// `held_out` is the simulation over held-out data, or why there is none
/// ([`Reason::NoHeldOutData`], [`Reason::OperationalRecord`]).
pub fn validate(estimate: &Estimate, held_out: Result<HeldOut, Reason>, need: &Need, frame: u64, t_ns: u64) -> Verdict {
    let mut verdict = empty_verdict(estimate.domain, estimate.phase, frame, t_ns);
    verdict.estimate_frame = estimate.frame;
    verdict.nis_mean = estimate.nis_mean;
    verdict.block_z_worst = worst_z(estimate);
    if let Ok(held_out) = held_out {
        verdict.held_out_rms = held_out.rms;
        verdict.held_out_noise = held_out.noise;
        verdict.held_out_count = held_out.count;
    }
    if estimate.status != 0 {
        return with_finding(verdict, Finding::new(Reason::NoEstimate, f64::from(estimate.status), 0.0));
    }
    let honest = nis_failure(estimate).or_else(|| whiteness_failure(estimate));
    let adequacy = adequacy_failure(estimate, held_out, need);
    let consistent =
        (estimate.consistent != 1).then(|| Finding::new(Reason::NotConsistent, f64::from(estimate.consistent), 1.0));
    verdict.complete = u16::from(honest.is_none());
    verdict.adequate = match adequacy {
        None => 1,
        Some(Finding { reason: Reason::HeldOutTooLarge | Reason::SigmaTooLarge, .. }) => 0,
        Some(_) => NOT_DECIDABLE,
    };
    let bars = consistent.or(adequacy).or(honest);
    verdict.accepted = u16::from(bars.is_none());
    let passed = Finding::new(Reason::Accepted, verdict.held_out_rms, need.held_out_rms.unwrap_or(0.0));
    with_finding(verdict, bars.unwrap_or(passed))
}

/// Verdict on an experiment that gave no estimate to judge, with the figure that decided and its
/// limit (0: none).
pub fn no_model(domain: Domain, phase: Phase, (reason, measured, limit): Missing, frame: u64, t_ns: u64) -> Verdict {
    with_finding(empty_verdict(domain.code(), phase.code(), frame, t_ns), Finding::new(reason, measured, limit))
}

/// Why there is no model, with figure and limit.
pub type Missing = (Reason, f64, f64);

/// A verdict without figures or a reason yet.
fn empty_verdict(domain: u16, phase: u16, frame: u64, t_ns: u64) -> Verdict {
    Verdict {
        header: Header::at(t_ns),
        frame,
        estimate_frame: 0,
        domain,
        phase,
        complete: 0,
        adequate: NOT_DECIDABLE,
        accepted: 0,
        reason: Reason::NoEstimate.code(),
        parameter: NO_PARAMETER,
        reserved: 0,
        measured: 0.0,
        limit: 0.0,
        nis_mean: 0.0,
        block_z_worst: 0.0,
        held_out_rms: f64::NAN,
        held_out_noise: f64::NAN,
        held_out_count: 0,
    }
}

/// `verdict` with the test that decided it.
fn with_finding(mut verdict: Verdict, finding: Finding) -> Verdict {
    verdict.reason = finding.reason.code();
    verdict.parameter = finding.parameter;
    (verdict.measured, verdict.limit) = (finding.measured, finding.limit);
    verdict
}

/// Sigmas are honest when the mean NIS lies in its band; too small a NIS (sigmas too large) is as
/// dishonest.
fn nis_failure(estimate: &Estimate) -> Option<Finding> {
    let mean = estimate.nis_mean;
    let Some((low, high)) = mean_square_band(estimate.nis_count, NIS_FALSE_ALARM) else {
        return Some(Finding::new(Reason::NisOutOfBand, mean, f64::INFINITY));
    };
    let inside = (low..=high).contains(&mean);
    (!inside).then(|| Finding::new(Reason::NisOutOfBand, mean, if mean < low { low } else { high }))
}

/// The worst block length that lies above its limit. A length of which no three blocks were
/// completed is not tested.
fn whiteness_failure(estimate: &Estimate) -> Option<Finding> {
    let (z, limit) = coloured_scale(tested(estimate))?;
    Some(Finding::new(Reason::InnovationsBiased, z, limit))
}

/// z-score and limit of every block length that has enough blocks.
fn tested(estimate: &Estimate) -> impl Iterator<Item = (f64, f64)> {
    let blocks = |length: f64| if length > 0.0 { (estimate.nis_count / length).floor() } else { 0.0 };
    let scales = estimate.block_length.iter().zip(&estimate.block_z).map(move |(length, z)| (blocks(*length), *z));
    tested_scales(scales, WHITENESS_FALSE_ALARM)
}

/// Largest magnitude of a tested z-score, with its sign; 0 when none was tested.
fn worst_z(estimate: &Estimate) -> f64 {
    tested(estimate).map(|(z, _)| z).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
}

/// Held-out error first, then the standard deviations; what cannot be decided counts only when
/// nothing else fails.
fn adequacy_failure(estimate: &Estimate, held_out: Result<HeldOut, Reason>, need: &Need) -> Option<Finding> {
    let simulation = match (need.held_out_rms, held_out) {
        (None, _) => Some(Finding::new(Reason::NoNeedStated, 0.0, 0.0)),
        (Some(_), Err(reason)) => Some(Finding::new(reason, 0.0, 0.0)),
        (Some(limit), Ok(seen)) if seen.rms <= limit => silence(&seen),
        (Some(limit), Ok(seen)) => return Some(Finding::new(Reason::HeldOutTooLarge, seen.rms, limit)),
    };
    sigma_failure(estimate, need).or(simulation)
}

/// Held-out data in which the signal does not stand out of the noise: any small model would pass.
fn silence(seen: &HeldOut) -> Option<Finding> {
    let limit = SIGNAL_OVER_NOISE_MIN * seen.noise;
    let heard = seen.signal_rms > limit; // false for NaN
    (!heard).then(|| Finding::new(Reason::NoHeldOutData, seen.signal_rms, limit))
}

/// The parameter that misses its need by the largest factor.
fn sigma_failure(estimate: &Estimate, need: &Need) -> Option<Finding> {
    (0..usize::from(estimate.count).min(PARAMETERS_MAX))
        .filter_map(|index| {
            let limit = need.sigma_percent[index]?;
            let sigma = estimate.covariance[index][index].sqrt();
            let percent = 100.0 * sigma / estimate.values[index].abs();
            let met = percent <= limit; // false for NaN: a covariance that is none meets no need
            let finding = Finding { reason: Reason::SigmaTooLarge, parameter: index as u16, measured: percent, limit };
            (!met).then_some((percent / limit, finding))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|worst| worst.1)
}

/// Largest standard deviation over its need, over all parameters with a need; `None` when none is
/// stated. At most one: every need is met.
pub fn sigma_over_need(estimate: &Estimate, need: &Need) -> Option<f64> {
    (0..usize::from(estimate.count).min(PARAMETERS_MAX))
        .filter_map(|index| {
            let limit = need.sigma_percent[index]?;
            Some(100.0 * estimate.covariance[index][index].sqrt() / estimate.values[index].abs() / limit)
        })
        .max_by(f64::total_cmp)
}

/// The verdict as one sentence, with the deciding figure and its limit, for logs and reports.
pub fn explain(verdict: &Verdict) -> String {
    let Some(reason) = Reason::from_code(verdict.reason) else {
        return format!("unknown reason {}", verdict.reason);
    };
    let domain = Domain::from_code(verdict.domain);
    let unit = if domain == Some(Domain::Inertial) { "rad/s" } else { "m/s^2" };
    let parameter = domain.and_then(|domain| parameters(domain).get(usize::from(verdict.parameter)));
    let name = parameter.map_or("?", |parameter| parameter.name);
    let (measured, limit) = (verdict.measured, verdict.limit);
    match reason {
        Reason::Accepted => format!(
            "adequate: held-out simulation error {measured:.1e} {unit} within the need {limit:.1e} {unit}, \
             mean NIS {:.3}, worst block z {:.1}",
            verdict.nis_mean, verdict.block_z_worst
        ),
        Reason::NoEstimate if measured != 0.0 => {
            let status = domain.map_or("unknown status", |domain| telemetry::status_text(domain, measured as u32));
            format!("no estimate was made: {status}")
        }
        Reason::NoHeldOutData if limit > 0.0 => format!(
            "adequacy cannot be judged: the held-out signal of {measured:.1e} {unit} does not stand out of the noise \
             (limit {limit:.1e} {unit})"
        ),
        Reason::OutOfReach if limit > 0.0 => {
            format!("skipped: its predicted sigma misses the need {measured:.1} times over, limit {limit:.1}")
        }
        Reason::InnovationsBiased => {
            format!("sigmas not honest: innovations are not white on block means, z {measured:.1} above {limit:.1}")
        }
        Reason::NisOutOfBand if limit.is_infinite() => {
            "sigmas cannot be called honest: too few rows for a mean NIS".to_string()
        }
        Reason::NisOutOfBand => format!(
            "sigmas not honest: mean NIS {measured:.3} {} {limit:.3}",
            if measured < limit { "below" } else { "above" }
        ),
        Reason::HeldOutTooLarge => {
            format!("inadequate: held-out simulation error {measured:.1e} {unit} above the need {limit:.1e} {unit}")
        }
        Reason::SigmaTooLarge => {
            format!("inadequate: standard deviation of {name} {measured:.2e} % above the need {limit:.2e} %")
        }
        _ => reason.text().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use crate::specimen::closing;
    use estimation::consistency::Whiteness;

    fn estimate() -> Estimate {
        let mut covariance = [[0.0; PARAMETERS_MAX]; PARAMETERS_MAX];
        for (index, row) in covariance.iter_mut().enumerate() {
            row[index] = 1e-4; // sigma 0.01 on values of 100: 0.01 %
        }
        let values = [100.0; PARAMETERS_MAX];
        Estimate { frame: 5000, count: 8, values, covariance, ..closing(Domain::Inertial) }
    }

    const NEED: Need = {
        let mut sigma_percent = [None; PARAMETERS_MAX];
        sigma_percent[2] = Some(0.05);
        Need { sigma_percent, held_out_rms: Some(4e-4) }
    };
    const HELD_OUT: HeldOut = HeldOut { rms: 3e-4, noise: 2.7e-4, signal_rms: 0.2, count: 1200 };

    fn judged(change: impl FnOnce(&mut Estimate)) -> Verdict {
        let mut estimate = estimate();
        change(&mut estimate);
        validate(&estimate, Ok(HELD_OUT), &NEED, 6100, 61_000_000_000)
    }

    fn summary(verdict: &Verdict) -> (u16, u16, u16, Reason) {
        (verdict.complete, verdict.adequate, verdict.accepted, Reason::from_code(verdict.reason).unwrap())
    }

    #[test]
    fn each_failing_test_alone_is_named_and_has_its_own_consequence() {
        type Case = (fn(&mut Estimate), (u16, u16, u16, Reason));
        let none: fn(&mut Estimate) = |_| {};
        // (change, (complete, adequate, accepted, reason))
        let cases: [Case; 9] = [
            (none, (1, 1, 1, Reason::Accepted)),
            (|e| e.block_z[2] = 9.0, (0, 1, 0, Reason::InnovationsBiased)),
            (|e| e.block_z[2] = -5.0, (1, 1, 1, Reason::Accepted)),
            (|e| e.nis_mean = 1.2, (0, 1, 0, Reason::NisOutOfBand)),
            (|e| e.nis_mean = 0.8, (0, 1, 0, Reason::NisOutOfBand)),
            (|e| e.nis_mean = f64::NAN, (0, 1, 0, Reason::NisOutOfBand)),
            (|e| e.consistent = 0, (1, 1, 0, Reason::NotConsistent)),
            (|e| e.covariance[2][2] = 0.01, (1, 0, 0, Reason::SigmaTooLarge)),
            (|e| e.status = 3, (0, 2, 0, Reason::NoEstimate)),
        ];
        for (index, (change, expected)) in cases.into_iter().enumerate() {
            assert_eq!(summary(&judged(change)), expected, "case {index}");
        }
        assert_eq!(judged(|e| e.covariance[2][2] = 0.01).parameter, 2);
    }

    #[test]
    fn adequacy_is_undecidable_without_a_need_or_without_held_out_data() {
        let unstated = validate(&estimate(), Ok(HELD_OUT), &Need::default(), 0, 0);
        assert_eq!(summary(&unstated), (1, 2, 0, Reason::NoNeedStated));
        for reason in [Reason::NoHeldOutData, Reason::OperationalRecord] {
            assert_eq!(summary(&validate(&estimate(), Err(reason), &NEED, 0, 0)), (1, 2, 0, reason));
        }
        // A stated sigma that is missed decides nevertheless.
        let mut poor = estimate();
        poor.covariance[2][2] = 0.01;
        assert_eq!(
            summary(&validate(&poor, Err(Reason::NoHeldOutData), &NEED, 0, 0)),
            (1, 0, 0, Reason::SigmaTooLarge)
        );
    }

    #[test]
    fn a_held_out_error_above_the_need_is_explained_with_both_numbers() {
        let need = Need { held_out_rms: Some(1e-4), ..NEED };
        let seen = HeldOut { rms: 3.1e-4, ..HELD_OUT };
        let verdict = validate(&estimate(), Ok(seen), &need, 0, 0);
        assert_eq!(summary(&verdict), (1, 0, 0, Reason::HeldOutTooLarge));
        let expected = "inadequate: held-out simulation error 3.1e-4 rad/s above the need 1.0e-4 rad/s";
        assert_eq!(explain(&verdict), expected);
        let biased = explain(&judged(|e| e.block_z[2] = 9.0));
        assert!(biased.starts_with("sigmas not honest: innovations are not white"), "{biased}");
    }

    #[test]
    fn a_signal_that_has_decayed_into_the_noise_tests_no_model() {
        let faint = HeldOut { signal_rms: 2.9 * HELD_OUT.noise, ..HELD_OUT };
        let verdict = validate(&estimate(), Ok(faint), &NEED, 0, 0);
        assert_eq!(summary(&verdict), (1, 2, 0, Reason::NoHeldOutData));
        assert!(explain(&verdict).contains("does not stand out of the noise"), "{}", explain(&verdict));
        let heard = HeldOut { signal_rms: 3.1 * HELD_OUT.noise, ..HELD_OUT };
        assert_eq!(validate(&estimate(), Ok(heard), &NEED, 0, 0).accepted, 1);
        // A model that invents a signal where there is none is wrong all the same.
        let invented = HeldOut { rms: 1e-3, ..faint };
        assert_eq!(summary(&validate(&estimate(), Ok(invented), &NEED, 0, 0)).3, Reason::HeldOutTooLarge);
    }

    #[test]
    fn a_nan_in_any_figure_never_lets_a_model_pass() {
        assert_eq!(judged(|e| e.block_z[1] = f64::NAN).complete, 0);
        assert_eq!(judged(|e| e.covariance[2][2] = f64::NAN).accepted, 0);
        assert_eq!(judged(|e| e.values[2] = 0.0).accepted, 0);
        let blind = HeldOut { rms: f64::NAN, ..HELD_OUT };
        assert_eq!(validate(&estimate(), Ok(blind), &NEED, 0, 0).accepted, 0);
        let mute = HeldOut { signal_rms: f64::NAN, ..HELD_OUT };
        assert_eq!(validate(&estimate(), Ok(mute), &NEED, 0, 0).accepted, 0);
    }

    /// `rows` normalised innovations with standard deviation `scale` and mean `bias`, as an
    /// estimator reports them.
    fn innovations(seed: u64, rows: u32, scale: f64, bias: f64) -> Estimate {
        let (mut noise, mut white, mut squares) = (SeededNoise::new(seed), Whiteness::default(), 0.0);
        for _ in 0..rows {
            let innovation = scale * noise.normal() + bias;
            white.push(innovation);
            squares += innovation * innovation;
        }
        let verdicts = white.verdicts();
        Estimate {
            nis_mean: squares / f64::from(rows),
            nis_count: f64::from(rows),
            block_length: verdicts.map(|verdict| f64::from(verdict.block_samples)),
            block_z: verdicts.map(|verdict| verdict.z_score),
            ..estimate()
        }
    }

    #[test]
    fn honest_innovations_are_refused_as_rarely_as_stated() {
        // 20 000 records of 1000 rows, ten blocks of 100 among them. Stated: 1e-3 each. The length
        // of one row repeats the NIS test; Wilson–Hilferty at ten degrees is within 1 % of the
        // quantile, 10 % of so small a tail.
        let (mut biased, mut dishonest) = (0_u32, 0_u32);
        for seed in 0..20_000 {
            let estimate = innovations(seed, 1000, 1.0, 0.0);
            biased += u32::from(whiteness_failure(&estimate).is_some());
            dishonest += u32::from(nis_failure(&estimate).is_some());
        }
        // Expected 20, Poisson: beyond 5..=40 with probability 3e-5.
        assert!((5..=40).contains(&biased), "{biased}");
        assert!((5..=40).contains(&dishonest), "{dishonest}");
    }

    #[test]
    fn a_lasting_tenth_of_a_sigma_and_five_per_cent_of_sigma_are_both_dishonest() {
        for seed in 0..100 {
            // Bias 0.1 over 20 000 rows: block-100 z is 1·√(200/2) = 10 ± √3, limit 4.3.
            let biased = innovations(seed, 20_000, 1.0, 0.1);
            assert_eq!(whiteness_failure(&biased).map(|f| f.reason), Some(Reason::InnovationsBiased), "seed {seed}");
            // Variance 1.1025 or 0.9025: NIS off by ten of its standard deviations √(2/20 000) =
            // 0.01; limit 3.3.
            for scale in [1.05, 0.95] {
                assert!(nis_failure(&innovations(seed, 20_000, scale, 0.0)).is_some(), "seed {seed}, scale {scale}");
            }
        }
    }

    #[test]
    fn a_length_without_three_blocks_is_not_tested() {
        let mut few = estimate();
        (few.nis_count, few.block_z[2]) = (250.0, 99.0);
        assert_eq!(whiteness_failure(&few), None);
        assert_eq!(worst_z(&few), 0.0);
    }
}
