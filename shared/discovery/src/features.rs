//! Diagnosis from features: where a recording is a spectrum or a list of modes, frequencies are the evidence.
//!
//! Peaks of the spectrum become modes with standard errors, are brought together with the plant's modes, and leave the residuals
//! `ln f_measured − ln f_plant`. Every change that a plant offers (its appendages' common stiffness, one mode, a root that gives, a mass
//! forgotten at a point, the catalogue's structures) predicts residuals; each is fitted and competes by BIC. The best one is asked to predict the
//! upper modes from the lower ones. Changes that predict the same frequencies are said to be not separable.
//!
//! How a plant file describes such a structure: `deploy/plants/rigs/cantilever.toml`. A sigma on a mode's frequency is what its model is
//! trusted to, mode by mode; without one the size of the discrepancy is estimated.

mod changes;
mod drift;
mod likelihood;
mod matching;
mod peaks;

pub use drift::{ModeInPart, ModeTrack};
pub use peaks::{MeasuredMode, Spectrum};

use crate::diagnose::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectReport, HeldOut, HeldOutChannel, HeldOutKind, Nominal,
    ParameterReport, RIVAL_SPAN, Rival, Verdict, Where,
};
use crate::held_out::{ChannelFit, Status};
use crate::statistics::fisher_tail;
use changes::{Change, frequencies};
use estimation::consistency::normal_two_sided_tail;
use likelihood::{Evidence, Likelihood, golden};
use nalgebra::DMatrix;
use plant::description::Plant;

/// Levels and bounds.
#[derive(Clone, Copy, Debug)]
pub struct FeatureOptions {
    /// Probability of any finding where nothing is missing.
    pub alpha: f64,
    /// Modes from which a change is fitted when it has to predict the others; `None`: the lower half, three at least.
    pub fitted_modes: Option<usize>,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self { alpha: 0.01, fitted_modes: None }
    }
}

/// Below so many matched modes no change of one number can be told from another.
const MODES_MIN: usize = 3;
/// Rivals this close in BIC are not separated.
const TIE_SPAN: f64 = 6.0;
/// Directions this close are one.
const SAME_COSINE: f64 = 0.99;

/// Diagnosis of a plant from a spectrum's magnitude.
pub fn diagnose_spectrum(plant: &Plant, spectrum: &Spectrum, options: &FeatureOptions) -> Diagnosis {
    let found = spectrum.modes();
    if found.is_empty() {
        let reason = format!("spectrum '{}' has no peak that stands above its floor", spectrum.name);
        return Diagnosis::cannot_decide(reason);
    }
    diagnose_modes(plant, &spectrum.name, &found, options)
}

/// Diagnosis of a plant from modes measured in any way.
pub fn diagnose_modes(plant: &Plant, name: &str, measured: &[MeasuredMode], options: &FeatureOptions) -> Diagnosis {
    match Comparison::new(plant, name, measured) {
        Ok(comparison) => comparison.conclude(options),
        Err(reason) => Diagnosis::cannot_decide(reason),
    }
}

/// As [`diagnose_modes`], with the same modes over parts of their record: what is not constant over them is reported beside.
pub fn diagnose_tracked_modes(
    plant: &Plant,
    name: &str,
    measured: &[MeasuredMode],
    tracks: &[ModeTrack],
    options: &FeatureOptions,
) -> Diagnosis {
    let mut diagnosis = diagnose_modes(plant, name, measured, options);
    drift::add_drifts(&mut diagnosis, tracks, options.alpha);
    diagnosis
}

/// Plant and measurement side by side.
struct Comparison<'a> {
    plant: &'a Plant,
    name: &'a str,
    measured: &'a [MeasuredMode],
    /// Mode of the plant, measured mode.
    pairs: Vec<(usize, usize)>,
    nominal: Vec<(f64, String)>,
    evidence: Evidence,
    /// Names, values and sigmas of the unknowns behind `evidence.prior`.
    unknowns: Vec<(String, f64, f64)>,
    residual: Vec<f64>,
    null: Likelihood,
}

/// A change with its best amplitude.
#[derive(Clone)]
struct Fitted {
    change: Change,
    amplitude: f64,
    sigma: f64,
    likelihood: Likelihood,
    /// ln f moved by the change.
    moved: Vec<f64>,
    p: f64,
    bic: f64,
}

impl<'a> Comparison<'a> {
    fn new(plant: &'a Plant, name: &'a str, measured: &'a [MeasuredMode]) -> Result<Self, String> {
        let nominal = frequencies(plant).ok_or("the plant cannot be linearised where it begins")?;
        let plant_hz: Vec<f64> = nominal.iter().map(|mode| mode.0).collect();
        let usable: Vec<MeasuredMode> =
            measured.iter().copied().filter(|m| m.frequency_hz > 0.0 && m.sigma_hz >= 0.0).collect();
        if usable.len() != measured.len() {
            return Err("a measured mode has no positive frequency or no standard deviation".to_owned());
        }
        let pairs = matching::pairs(&plant_hz, measured);
        if pairs.len() < MODES_MIN {
            return Err(format!(
                "{} of {} measured modes belong to modes of the plant, {MODES_MIN} are needed to tell one change from another",
                pairs.len(),
                measured.len()
            ));
        }
        let residual: Vec<f64> =
            pairs.iter().map(|(i, j)| libm::log(measured[*j].frequency_hz / plant_hz[*i])).collect();
        let sigma = pairs.iter().map(|(_, j)| (measured[*j].sigma_hz / measured[*j].frequency_hz).max(1e-9)).collect();
        let (prior, unknowns) = sensitivities(plant, &pairs, &plant_hz);
        let evidence = Evidence { sigma, prior };
        let null = evidence.best(&residual);
        Ok(Self { plant, name, measured, pairs, nominal, evidence, unknowns, residual, null })
    }

    /// ln f of the matched modes after a change, less that of the plant.
    fn moved(&self, change: &Change, amplitude: f64) -> Option<Vec<f64>> {
        let changed = frequencies(&change.applied(self.plant, amplitude)?)?;
        if changed.len() != self.nominal.len() {
            return None;
        }
        let moved = self.pairs.iter().map(|(i, _)| libm::log(changed[*i].0 / self.nominal[*i].0));
        Some(moved.collect())
    }

    /// Amplitude of least objective over the modes of `rows`.
    fn fit(&self, change: &Change, evidence: &Evidence, rows: core::ops::Range<usize>) -> Option<(f64, Likelihood)> {
        let objective = |amplitude: f64| -> f64 {
            let Some(moved) = self.moved(change, amplitude) else { return f64::INFINITY };
            let left: Vec<f64> = rows.clone().map(|k| self.residual[k] - moved[k]).collect();
            evidence.best(&left).objective
        };
        let grid = change.grid(self.plant);
        let values: Vec<f64> = grid.iter().map(|a| objective(*a)).collect();
        let least = (0..grid.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
        let (low, high) = (grid[least.saturating_sub(1)], grid[(least + 1).min(grid.len() - 1)]);
        let amplitude = golden(low, high, 18, &objective);
        let amplitude = if objective(amplitude) <= values[least] { amplitude } else { grid[least] };
        let moved = self.moved(change, amplitude)?;
        let left: Vec<f64> = rows.map(|k| self.residual[k] - moved[k]).collect();
        let likelihood = evidence.best(&left);
        likelihood.objective.is_finite().then_some((amplitude, likelihood))
    }

    fn fitted(&self, change: Change, tried: usize) -> Option<Fitted> {
        let n = self.pairs.len();
        let (amplitude, likelihood) = self.fit(&change, &self.evidence, 0..n)?;
        let moved = self.moved(&change, amplitude)?;
        if moved.iter().all(|m| m.abs() < 1e-9) {
            return None;
        }
        // both quadratic forms under the covariance with the change, which the plant without it must meet as well
        let covariance = self.evidence.covariance(likelihood.tau);
        let factor = nalgebra::Cholesky::new(covariance)?;
        let form = |r: Vec<f64>| {
            let r = nalgebra::DVector::from_vec(r);
            r.dot(&factor.solve(&r))
        };
        let after = form(self.residual.iter().zip(&moved).map(|(r, m)| r - m).collect());
        let gained = (form(self.residual.clone()) - after).max(0.0);
        let freedom = (n - 1) as f64;
        let f = gained / (after / freedom).max(1e-300);
        let p = (fisher_tail(f, 1.0, freedom) * tried as f64).min(1.0);
        // linear about the amplitude
        let step = 1e-3 * amplitude;
        let slope: Vec<f64> =
            self.moved(&change, amplitude + step)?.iter().zip(&moved).map(|(a, b)| (a - b) / step).collect();
        let information = form(slope);
        let sigma = if information > 0.0 { (1.0 / information).sqrt() } else { f64::INFINITY };
        let bic = likelihood.objective - self.null.objective + libm::log(n as f64);
        Some(Fitted { change, amplitude, sigma, likelihood, moved, p, bic })
    }

    fn conclude(&self, options: &FeatureOptions) -> Diagnosis {
        let all = Change::all(self.plant);
        let tried = all.len();
        let mut list: Vec<Fitted> = all.into_iter().filter_map(|change| self.fitted(change, tried)).collect();
        list.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let mut diagnosis = Diagnosis::cannot_decide(String::new());
        diagnosis.compare = Compare { channels: vec![self.channel("ln frequency", &self.residual)] };
        diagnosis.located = self.located();
        diagnosis.nominal = self.nominal();
        diagnosis.notes = self.notes(&list);
        diagnosis.figures.angles = self.angles(&list);
        diagnosis.detection_limits = self.limits(&list);
        let best = list.first().filter(|best| best.p < options.alpha && best.bic < 0.0).cloned();
        match best {
            None => {
                diagnosis.verdict = Verdict::None;
                diagnosis.reason = format!(
                    "none of {tried} changes explains the {} matched frequencies better than the plant with its priors (rms {:.2} %)",
                    self.pairs.len(),
                    100.0 * self.null.rms
                );
            }
            Some(best) => self.name(&mut diagnosis, &best, &list, options),
        }
        diagnosis
    }

    /// The best change in the report: rivals, held-out modes, verdict, augmented plant.
    fn name(&self, diagnosis: &mut Diagnosis, best: &Fitted, list: &[Fitted], options: &FeatureOptions) {
        let (held_out, status) = self.held_out(&best.change, options);
        let weight = |f: &Fitted| libm::exp(-0.5 * (f.bic - best.bic));
        let total: f64 = list.iter().map(weight).sum();
        let rivals: Vec<Rival> = list[1..]
            .iter()
            .filter(|f| f.bic - best.bic < RIVAL_SPAN)
            .map(|f| Rival {
                kind: f.change.kind(),
                site: f.change.site(self.plant),
                probability: weight(f) / total,
                reason: self.against(f, best),
            })
            .collect();
        let tied = list[1..].iter().any(|f| f.bic - best.bic < TIE_SPAN && f.p < options.alpha);
        let (name, value, slope, unit) = best.change.parameter(best.amplitude);
        let kind = best.change.kind();
        let site = best.change.site(self.plant);
        diagnosis.verdict = match (status, tied) {
            (Status::Refused, _) => Verdict::CannotDecide,
            (_, true) => Verdict::NotSeparable,
            _ => Verdict::Named,
        };
        diagnosis.reason = format!(
            "{kind} at {site} ({name} {value:.4} {unit}) takes the rms of the frequencies from {:.2} % to {:.2} %{}",
            100.0 * self.null.rms,
            100.0 * best.likelihood.rms,
            match (status, tied) {
                (Status::Refused, _) => "; fitted on the lower modes it predicts the upper ones worse",
                (_, true) => "; others predict the same frequencies",
                _ => "",
            }
        );
        let before = self.null.objective;
        diagnosis.effects = vec![EffectReport {
            kind,
            site,
            probability: 1.0 / total,
            status,
            rivals,
            parameters: vec![ParameterReport { name, value, sigma: slope.abs() * best.sigma, unit }],
            kappa: self.absorbed(best),
            d: (before - best.likelihood.objective).max(0.0).sqrt(),
        }];
        diagnosis.held_out = held_out;
        if status == Status::Confirmed {
            let augmented = best.change.applied(self.plant, best.amplitude);
            diagnosis.augmented_plant = augmented.map(|plant| plant::file::write(&plant));
        }
    }

    /// Why a rival is behind, or is not.
    fn against(&self, rival: &Fitted, best: &Fitted) -> String {
        let cosine = self.evidence.cosine(&rival.moved, &best.moved, best.likelihood.tau).abs();
        if cosine > SAME_COSINE {
            return format!("predicts the same frequencies (cosine {cosine:.4}): shapes would tell them apart");
        }
        format!(
            "leaves {:.2} % rms instead of {:.2} %, BIC {:+.1}",
            100.0 * rival.likelihood.rms,
            100.0 * best.likelihood.rms,
            rival.bic - best.bic
        )
    }

    /// Fitted on the lower modes, asked about the upper ones.
    fn held_out(&self, change: &Change, options: &FeatureOptions) -> (HeldOut, Status) {
        let n = self.pairs.len();
        let fitted = options.fitted_modes.unwrap_or(n.div_ceil(2).max(MODES_MIN)).clamp(1, n);
        let nothing = Diagnosis::cannot_decide(String::new()).held_out;
        if fitted + 2 > n {
            return (nothing, Status::Unconfirmed);
        }
        let low = self.evidence.part(0..fitted);
        let Some((amplitude, likelihood)) = self.fit(change, &low, 0..fitted) else {
            return (nothing, Status::NotConverged);
        };
        let Some(moved) = self.moved(change, amplitude) else { return (nothing, Status::NotConverged) };
        let Some(next) = self.moved(change, amplitude * 1.001) else { return (nothing, Status::NotConverged) };
        let slope: Vec<f64> = next.iter().zip(&moved).map(|(a, b)| (a - b) / (1e-3 * amplitude)).collect();
        // what few modes say of τ and of the amplitude is not exact either
        let tau = likelihood.tau * (fitted as f64 / (fitted as f64 - 1.0)).sqrt();
        let own = low.precision(&slope[..fitted], tau);
        let high = self.evidence.part(fitted..n);
        let before = &self.residual[fitted..];
        let after: Vec<f64> = before.iter().zip(&moved[fitted..]).map(|(r, m)| r - m).collect();
        let null = low.best(&self.residual[..fitted]);
        // mode by mode, so that their scatter says how sure the gain is
        let gains: Vec<f64> = (0..after.len())
            .map(|k| {
                let mode = high.part(k..k + 1);
                let spread = slope[fitted + k] * slope[fitted + k] / own;
                0.5 * (mode.at(&before[k..=k], null.tau) - mode.at(&after[k..=k], (tau * tau + spread).sqrt()))
            })
            .collect();
        let gain: f64 = gains.iter().sum();
        let mean = gain / gains.len() as f64;
        let m = gains.len() as f64;
        let se = (gains.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() * m / (m - 1.0)).sqrt();
        let (rms_before, rms_after) = (crate::statistics::rms(before), crate::statistics::rms(&after));
        let interval = [gain - 1.96 * se, gain + 1.96 * se];
        let channel = HeldOutChannel {
            name: format!("ln frequency of modes {} to {n}, fitted on {fitted}", fitted + 1),
            fit_percent_before: fit_percent(rms_before),
            fit_percent_after: fit_percent(rms_after),
            rms_before,
            rms_after,
        };
        let status = match interval {
            [low, _] if low > 0.0 && rms_after < rms_before => Status::Confirmed,
            [_, high] if high < 0.0 || rms_after > rms_before => Status::Refused,
            _ => Status::Unconfirmed,
        };
        let held_out = HeldOut {
            kind: HeldOutKind::Blocks,
            channels: vec![channel],
            loglik_gain: Some(gain),
            gain_se: Some(se),
            gain_ci95: Some(interval),
            whiteness_p_before: None,
            whiteness_p_after: None,
        };
        (held_out, status)
    }

    /// Share of the change's direction that the plant's unknowns can take, under their priors.
    fn absorbed(&self, fitted: &Fitted) -> f64 {
        let left = self.evidence.left(&fitted.moved, fitted.likelihood.tau);
        let square = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        (1.0 - square(&left) / square(&fitted.moved).max(1e-300)).clamp(0.0, 1.0)
    }

    fn channel(&self, name: &str, residual: &[f64]) -> ChannelFit {
        let rms = crate::statistics::rms(residual);
        ChannelFit { name: name.to_owned(), rms, fit_percent: fit_percent(rms) }
    }

    fn located(&self) -> Vec<Where> {
        let spread = |k: usize| libm::hypot(self.evidence.sigma[k], self.evidence.prior.row(k).norm());
        (0..self.pairs.len())
            .map(|k| {
                let (i, j) = self.pairs[k];
                let (plant_hz, measured_hz) = (self.nominal[i].0, self.measured[j].frequency_hz);
                Where {
                    channel: format!("{} {measured_hz:.3} Hz against {plant_hz:.3} Hz", self.name),
                    site: self.nominal[i].1.clone(),
                    time: [0.0; 2],
                    band_hz: [plant_hz.min(measured_hz), plant_hz.max(measured_hz)],
                    states: vec![self.nominal[i].1.clone()],
                    p: normal_two_sided_tail(self.residual[k] / spread(k)),
                }
            })
            .collect()
    }

    /// What the unknowns of the plant become when they alone explain the residual.
    fn nominal(&self) -> Vec<Nominal> {
        let covariance = self.evidence.covariance(self.null.tau);
        let Some(factor) = nalgebra::Cholesky::new(covariance) else { return Vec::new() };
        let weighted = factor.solve(&nalgebra::DVector::from_row_slice(&self.residual));
        let shift = self.evidence.prior.transpose() * weighted;
        let spread = self.evidence.prior.transpose() * factor.solve(&self.evidence.prior);
        let each = self.unknowns.iter().enumerate().map(|(k, (name, value, sigma))| Nominal {
            name: name.clone(),
            before: *value,
            after: value + sigma * shift[k],
            sigma: sigma * (1.0 - spread[(k, k)]).max(0.0).sqrt(),
            shift_sigma: shift[k],
        });
        each.collect()
    }

    fn notes(&self, list: &[Fitted]) -> Vec<String> {
        let mut notes = vec![format!(
            "{} of {} modes of the plant are among the {} measured ones; {:.2} % of every frequency stay unexplained by the plant, {:.3} % are the peaks' own",
            self.pairs.len(),
            self.nominal.len(),
            self.measured.len(),
            100.0 * self.null.tau,
            100.0 * crate::statistics::rms(&self.evidence.sigma)
        )];
        let paired = |j: usize| self.pairs.iter().any(|pair| pair.1 == j);
        let lost: Vec<String> = (0..self.measured.len())
            .filter(|j| !paired(*j))
            .map(|j| format!("{:.2} Hz", self.measured[j].frequency_hz))
            .take(12)
            .collect();
        if !lost.is_empty() {
            notes.push(format!("peaks that are no mode of the plant: {}", lost.join(", ")));
        }
        let structural: Vec<&Fitted> = list.iter().filter(|f| !matches!(f.change, Change::Single { .. })).collect();
        for (k, a) in structural.iter().enumerate() {
            for b in &structural[k + 1..] {
                // their curves over all amplitudes coincide where the best of both are the same and as good
                let alike = distance(&a.moved, &b.moved) < 0.05 * crate::statistics::rms(&a.moved);
                if alike && (a.bic - b.bic).abs() < TIE_SPAN {
                    notes.push(format!(
                        "{} at {} and {} at {} predict the same frequencies: not separable without shapes",
                        a.change.kind(),
                        a.change.site(self.plant),
                        b.change.kind(),
                        b.change.site(self.plant)
                    ));
                }
            }
        }
        notes
    }

    fn angles(&self, list: &[Fitted]) -> Angles {
        let some: Vec<&Fitted> = list.iter().take(8).collect();
        let tau = some.first().map_or(self.null.tau, |best| best.likelihood.tau);
        let name = |f: &&Fitted| format!("{}@{}", f.change.kind(), f.change.site(self.plant));
        let row = |a: &Fitted| some.iter().map(|b| self.evidence.cosine(&a.moved, &b.moved, tau)).collect();
        Angles { names: some.iter().map(name).collect(), cosine: some.iter().map(|a| row(a)).collect() }
    }

    /// Three standard errors of every change that was not found.
    fn limits(&self, list: &[Fitted]) -> Vec<DetectionLimit> {
        let each = list.iter().skip(1).filter(|f| f.sigma.is_finite()).map(|f| {
            let (_, _, _, unit) = f.change.parameter(f.amplitude);
            // a spring is limited by its flexibility
            let unit = if matches!(f.change, Change::Root { .. }) { "rad/(N*m)".to_owned() } else { unit };
            let (kind, site) = (f.change.kind(), f.change.site(self.plant));
            DetectionLimit { kind, site, amplitude: 3.0 * f.sigma, unit }
        });
        each.collect()
    }
}

/// 100 (1 − rms): of relative errors.
fn fit_percent(rms: f64) -> f64 {
    100.0 * (1.0 - rms)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    crate::statistics::rms(&difference)
}

/// Derivatives of ln f by every number with a prior, times its sigma.
fn sensitivities(plant: &Plant, pairs: &[(usize, usize)], plant_hz: &[f64]) -> (DMatrix<f64>, Vec<(String, f64, f64)>) {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut unknowns = Vec::new();
    for parameter in plant.parameters() {
        let Some(sigma) = parameter.sigma else { continue };
        if parameter.name.starts_with("initial") || parameter.name.starts_with("segment.") {
            continue;
        }
        let step = 1e-3 * sigma;
        let at = |value: f64| {
            let mut moved = plant.clone();
            moved.set_parameter(&parameter.name, value).ok()?;
            frequencies(&moved).filter(|f| f.len() == plant_hz.len())
        };
        let (Some(up), Some(down)) = (at(parameter.value + step), at(parameter.value - step)) else { continue };
        let column: Vec<f64> =
            pairs.iter().map(|(i, _)| libm::log(up[*i].0 / down[*i].0) / (2.0 * step) * sigma).collect();
        if column.iter().any(|c| c.abs() > 1e-9) {
            columns.push(column);
            unknowns.push((parameter.name, parameter.value, sigma));
        }
    }
    (DMatrix::from_fn(pairs.len(), columns.len(), |i, j| columns[j][i]), unknowns)
}

#[cfg(test)]
mod tests;
