//! A comparison as a diagnosis: verdict, reason, effects with rivals, and what the modes cannot
//! decide.

use super::FeatureOptions;
use super::changes::Change;
use super::comparison::{Comparison, Fitted, Member};
use super::likelihood::{Group, Likelihood};
use super::search::{Adopted, adopt};
use super::upper_modes;
use crate::diagnose::{
    Angles, Compare, DetectionLimit, Diagnosis, EffectReport, Nominal, ParameterReport, Rival, Verdict, Where,
};
use estimation::consistency::normal_two_sided_tail;
use identification::held_out::{ChannelFit, Status};
use identification::statistics::chi_squared_tail;

/// ΔBIC within which a rival is reported: posterior weight exp(−12/2) = 0.25 % at its edge.
const RIVAL_SPAN: f64 = 12.0;
/// ΔBIC within which rivals are not separated: odds of 20 : 1.
const TIE_SPAN: f64 = 6.0;
/// Absolute cosine from which two directions count as one. Chosen, no derivation.
const SAME_COSINE: f64 = 0.99;
/// MAC below which the shapes of a matched mode are reported as different. Chosen by custom, no
/// derivation.
const POOR_MAC: f64 = 0.8;

impl Comparison<'_> {
    pub(super) fn conclude(&self, options: &FeatureOptions) -> Diagnosis {
        let mut adopted = adopt(self, options.alpha);
        let rejected = self.without_rejected(&mut adopted, options);
        let mut diagnosis = Diagnosis::cannot_decide(String::new());
        diagnosis.compare = Compare { channels: self.channels() };
        diagnosis.located = self.located();
        diagnosis.nominal = self.nominal();
        diagnosis.notes = self.notes(&adopted.alone);
        diagnosis.notes.extend(rejected);
        diagnosis.figures.angles = self.angles(&adopted.alone);
        diagnosis.detection_limits = self.limits(&adopted);
        if adopted.members.is_empty() {
            diagnosis.verdict = Verdict::None;
            diagnosis.reason = self.nothing(adopted.tried);
        } else {
            self.name(&mut diagnosis, &adopted, options);
        }
        diagnosis
    }

    /// Removes from several changes those that predict the upper modes worse than the others do
    /// without them; a sentence for each.
    fn without_rejected(&self, adopted: &mut Adopted, options: &FeatureOptions) -> Vec<String> {
        let mut notes = Vec::new();
        while adopted.members.len() > 1 {
            let (_, statuses) = upper_modes::test_upper_modes(self, &adopted.members, options.fitted_modes);
            // the last came in with the least gain
            let Some(place) = statuses.iter().rposition(|status| *status == Status::Rejected) else { break };
            let change = &adopted.members[place].change;
            notes.push(format!(
                "{} at {} is not adopted: fitted on the lower modes it predicts the upper ones worse",
                change.kind(),
                change.site(self.plant)
            ));
            adopted.without(self, place);
        }
        notes
    }

    fn nothing(&self, tried: usize) -> String {
        let modes = self.frame.pairs.len();
        let rms = |group: Group| format!("{:.2} %", 100.0 * self.null.rms[group as usize]);
        let measured = self.frame.rows.iter().filter(|row| row.group == Group::Damping).count();
        let mut what = format!("{modes} matched frequencies");
        let mut sizes = rms(Group::Frequency);
        if measured > 0 {
            what.push_str(&format!(", {measured} damping ratios"));
            sizes.push_str(&format!(", {}", rms(Group::Damping)));
        }
        if self.evidence.has(Group::Shape) {
            what.push_str(", shapes");
            sizes.push_str(&format!(", {}", rms(Group::Shape)));
        }
        format!("none of {tried} changes explains the {what} better than the plant with its priors (rms {sizes})")
    }

    /// The adopted changes in the report: rivals, held-out modes, verdict, augmented plant.
    fn name(&self, diagnosis: &mut Diagnosis, adopted: &Adopted, options: &FeatureOptions) {
        let members = &adopted.members;
        let (held_out, statuses) = upper_modes::test_upper_modes(self, members, options.fitted_modes);
        let rows = self.all_rows();
        let likelihood_of = |set: &[Member]| self.left(set, &rows).map_or(self.null, |left| self.evidence.best(&left));
        let with = likelihood_of(members);
        let spread = self.spread(members, &rows, &with.tau);
        let sigma = |place: usize| spread.as_ref().map_or(f64::INFINITY, |(sigma, _)| sigma[place]);
        let mut tied = Vec::new();
        diagnosis.effects = Vec::new();
        for (place, member) in members.iter().enumerate() {
            let mut others = members.clone();
            others.remove(place);
            let Some(own) = adopted.places[place].iter().find(|fitted| fitted.change == member.change) else {
                continue;
            };
            let rivals = adopted.places[place].iter().filter(|fitted| fitted.change != member.change);
            let rivals: Vec<&Fitted> = rivals.collect();
            tied.push(rivals.iter().any(|f| f.bic - own.bic < TIE_SPAN && f.p < options.alpha));
            let without = likelihood_of(&others);
            let report = self.effect(member, own, &rivals, sigma(place), statuses[place]);
            let d = (without.objective - with.objective).max(0.0).sqrt();
            diagnosis.effects.push(EffectReport { d, ..report });
        }
        let (rejected, tied) = (statuses.contains(&Status::Rejected), tied.contains(&true));
        diagnosis.verdict = match (rejected, tied) {
            (true, _) => Verdict::CannotDecide,
            (_, true) => Verdict::NotSeparable,
            _ => Verdict::Named,
        };
        let besides = match (rejected, tied) {
            (true, _) => "; fitted on the lower modes it predicts the upper ones worse",
            (_, true) => "; others predict the same features",
            _ => "",
        };
        diagnosis.reason = format!("{}{besides}", self.taken(members, &with));
        diagnosis.held_out = held_out;
        let confirmed = members.iter().zip(&statuses).filter(|(_, status)| **status == Status::Confirmed);
        let confirmed: Vec<Member> = confirmed.map(|(member, _)| member.clone()).collect();
        if !confirmed.is_empty() {
            diagnosis.augmented_plant = self.changed(&confirmed).map(|plant| plant_file::write(&plant));
        }
    }

    fn effect(&self, member: &Member, own: &Fitted, rivals: &[&Fitted], sigma: f64, status: Status) -> EffectReport {
        let weight = |f: &Fitted| libm::exp(-0.5 * (f.bic - own.bic));
        let total: f64 = 1.0 + rivals.iter().map(|f| weight(f)).sum::<f64>();
        let rivals = rivals.iter().filter(|f| f.bic - own.bic < RIVAL_SPAN).map(|f| Rival {
            kind: f.change.kind(),
            site: f.change.site(self.plant),
            probability: weight(f) / total,
            reason: self.against(f, own),
        });
        let (name, value, slope, unit) = member.change.parameter(member.amplitude);
        EffectReport {
            kind: member.change.kind(),
            title: member.change.title(),
            site: member.change.site(self.plant),
            probability: 1.0 / total,
            status,
            rivals: rivals.collect(),
            parameters: vec![ParameterReport::inside(name, (value, slope.abs() * sigma), unit)],
            kept: Vec::new(),
            kappa: self.absorbed(own),
            d: 0.0,
            evidence: None,
        }
    }

    /// The members and the share of the residual that they explain.
    fn taken(&self, members: &[Member], with: &Likelihood) -> String {
        let each = members.iter().map(|member| {
            let (name, value, _, unit) = member.change.parameter(member.amplitude);
            format!("{} at {} ({name} {value:.4} {unit})", member.change.kind(), member.change.site(self.plant))
        });
        let each: Vec<String> = each.collect();
        let change = |group: &Group| {
            let (before, after) = (self.null.rms[*group as usize], with.rms[*group as usize]);
            // to the digits printed
            let same = (before - after).abs() < 5e-5;
            let of = format!("the {} from {:.2} % to {:.2} %", group.words(), 100.0 * before, 100.0 * after);
            (self.evidence.has(*group) && !same).then_some(of)
        };
        let taken: Vec<String> = Group::ALL.iter().filter_map(change).collect();
        let verb = if each.len() > 1 { "take" } else { "takes" };
        format!("{} {verb} the rms of {}", each.join(" and "), taken.join(", of "))
    }

    /// Why a rival is behind, or is not.
    fn against(&self, rival: &Fitted, best: &Fitted) -> String {
        let cosine = self.evidence.cosine(&rival.moved, &best.moved, &best.likelihood.tau).abs();
        if cosine > SAME_COSINE {
            let cure = if self.evidence.has(Group::Shape) { "more sensors" } else { "shapes" };
            let what = self.compared();
            return format!("predicts the same {what} (cosine {cosine:.4}): {cure} would separate them");
        }
        let moves = |group: &Group| {
            (0..best.moved.len()).any(|k| {
                self.evidence.group[k] == *group && (best.moved[k].abs() > 1e-9 || rival.moved[k].abs() > 1e-9)
            })
        };
        let each: Vec<String> = Group::ALL
            .iter()
            .filter(|group| moves(group))
            .map(|group| {
                let of = if *group == Group::Frequency { String::new() } else { format!(" of the {}", group.words()) };
                let k = *group as usize;
                let (left, instead) = (100.0 * rival.likelihood.rms[k], 100.0 * best.likelihood.rms[k]);
                format!("{left:.2} % rms{of} instead of {instead:.2} %")
            })
            .collect();
        format!("leaves {}, BIC {:+.1}", each.join(", "), rival.bic - best.bic)
    }

    fn compared(&self) -> &'static str {
        if self.evidence.has(Group::Damping) || self.evidence.has(Group::Shape) { "features" } else { "frequencies" }
    }

    /// Share of the change's direction that the plant's unknowns can take, under their priors.
    fn absorbed(&self, fitted: &Fitted) -> f64 {
        let left = self.evidence.left(&fitted.moved, &fitted.likelihood.tau);
        let square = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        (1.0 - square(&left) / square(&fitted.moved).max(1e-300)).clamp(0.0, 1.0)
    }

    fn channels(&self) -> Vec<ChannelFit> {
        let names =
            [(Group::Frequency, "ln frequency"), (Group::Damping, "ln damping ratio"), (Group::Shape, "shapes")];
        let there = names.iter().filter(|(group, _)| self.evidence.has(*group));
        let channel = |(group, name): &(Group, &str)| {
            let rms = self.evidence.rms_of(&self.residual, *group);
            ChannelFit { name: (*name).to_owned(), rms, fit_percent: fit_percent(rms) }
        };
        there.map(channel).collect()
    }

    fn located(&self) -> Vec<Where> {
        let spread = |k: usize| libm::hypot(self.evidence.sigma[k], self.evidence.prior.row(k).norm());
        let place = |pair: usize, channel: String, p: f64| {
            let (i, j) = self.frame.pairs[pair];
            let (mode, measured_hz) = (&self.frame.nominal[i], self.measured[j].frequency_hz);
            Where {
                channel,
                site: mode.name.clone(),
                time: [0.0; 2],
                band_hz: [mode.frequency_hz.min(measured_hz), mode.frequency_hz.max(measured_hz)],
                states: vec![mode.name.clone()],
                p,
            }
        };
        let mut list = Vec::new();
        for (k, row) in self.frame.rows.iter().enumerate().filter(|(_, row)| row.group != Group::Shape) {
            let (i, j) = self.frame.pairs[row.pair];
            let (mode, measured) = (&self.frame.nominal[i], &self.measured[j]);
            let channel = match row.group {
                Group::Frequency => {
                    format!("{} {:.3} Hz against {:.3} Hz", self.name, measured.frequency_hz, mode.frequency_hz)
                }
                _ => format!(
                    "{} damping of {:.3} Hz, {:.3} % against {:.3} %",
                    self.name,
                    measured.frequency_hz,
                    100.0 * measured.damping_ratio,
                    100.0 * mode.damping_ratio
                ),
            };
            list.push(place(row.pair, channel, normal_two_sided_tail(self.residual[k] / spread(k))));
        }
        for pair in 0..self.frame.pairs.len() {
            let rows = self.frame.rows_of(pair..pair + 1);
            let rows: Vec<usize> = rows.into_iter().filter(|k| self.frame.rows[*k].group == Group::Shape).collect();
            let (i, j) = self.frame.pairs[pair];
            let Some(mac) = self.frame.mac(pair, &self.frame.nominal[i]) else { continue };
            let tau = self.null.tau[Group::Shape as usize];
            let square: f64 = rows.iter().map(|k| (self.residual[*k] / libm::hypot(spread(*k), tau)).powi(2)).sum();
            let channel = format!("{} shape of {:.3} Hz, MAC {mac:.4}", self.name, self.measured[j].frequency_hz);
            list.push(place(pair, channel, chi_squared_tail(square, rows.len() as f64)));
        }
        list
    }

    /// Values of the plant's unknowns where they alone explain the residual.
    fn nominal(&self) -> Vec<Nominal> {
        let factor = self.evidence.factor(&self.null.tau);
        let weighted = factor.solve(&nalgebra::DVector::from_row_slice(&self.residual));
        let shift = self.evidence.prior.transpose() * weighted;
        let each = self.unknowns.iter().enumerate().map(|(k, (name, value, sigma))| {
            let column: Vec<f64> = self.evidence.prior.column(k).iter().copied().collect();
            let left = (1.0 - factor.form(&column, &column)).max(0.0).sqrt();
            Nominal {
                name: name.clone(),
                before: *value,
                after: value + sigma * shift[k],
                sigma: sigma * left,
                shift_sigma: shift[k],
            }
        });
        each.collect()
    }

    fn notes(&self, list: &[Fitted]) -> Vec<String> {
        let sigma = |group| self.evidence.rms_of(&self.evidence.sigma, group);
        let mut notes = vec![format!(
            "{} of {} modes of the plant are among the {} measured ones; {:.2} % of every frequency stay unexplained by the plant, {:.3} % are the peaks' own",
            self.frame.pairs.len(),
            self.frame.nominal.len(),
            self.measured.len(),
            100.0 * self.null.tau[0],
            100.0 * sigma(Group::Frequency)
        )];
        if self.evidence.has(Group::Damping) {
            notes.push(format!(
                "{} damping ratios are evidence; {:.0} % of each stay unexplained by the plant, {:.1} % are the measurement's own",
                self.evidence.count(Group::Damping),
                100.0 * self.null.tau[1],
                100.0 * sigma(Group::Damping)
            ));
        }
        notes.extend(self.frame.notes.iter().cloned());
        notes.extend(self.macs());
        let paired = |j: usize| self.frame.pairs.iter().any(|pair| pair.1 == j);
        let lost = (0..self.measured.len()).filter(|j| !paired(*j));
        let lost: Vec<String> = lost.map(|j| format!("{:.2} Hz", self.measured[j].frequency_hz)).take(12).collect();
        if !lost.is_empty() {
            notes.push(format!("peaks that are no mode of the plant: {}", lost.join(", ")));
        }
        notes.extend(self.inseparable(list));
        notes
    }

    /// The MAC of every pair, and which modes have other shapes.
    fn macs(&self) -> Vec<String> {
        if self.frame.channels.is_empty() {
            return Vec::new();
        }
        let of = |pair: usize| {
            let (i, j) = self.frame.pairs[pair];
            let mac = self.frame.mac(pair, &self.frame.nominal[i])?;
            Some((format!("{} {:.3} Hz {mac:.3}", self.frame.nominal[i].name, self.measured[j].frequency_hz), mac))
        };
        let all: Vec<(String, f64)> = (0..self.frame.pairs.len()).filter_map(of).collect();
        let list = |all: &[&(String, f64)]| all.iter().map(|(text, _)| text.as_str()).collect::<Vec<_>>().join(", ");
        let mut notes = vec![format!(
            "shapes over {} sensors, MAC: {}; {:.1} % of a shape's length stay unexplained by the plant in each component",
            self.frame.channels.len(),
            list(&all.iter().collect::<Vec<_>>()),
            100.0 * self.null.tau[2]
        )];
        let poor: Vec<&(String, f64)> = all.iter().filter(|(_, mac)| *mac < POOR_MAC).collect();
        if !poor.is_empty() {
            notes.push(format!("matched by frequency, not by shape (MAC below {POOR_MAC}): {}", list(&poor)));
        }
        notes
    }

    fn inseparable(&self, list: &[Fitted]) -> Vec<String> {
        let own = |f: &&Fitted| !matches!(f.change, Change::Single { .. } | Change::DampingSingle { .. });
        let structural: Vec<&Fitted> = list.iter().filter(own).collect();
        let cure = if self.evidence.has(Group::Shape) { "without more sensors" } else { "without shapes" };
        let mut notes = Vec::new();
        for (k, a) in structural.iter().enumerate() {
            for b in &structural[k + 1..] {
                // their curves over all amplitudes coincide where the best of both are the same and
                // as good
                let alike = distance(&a.moved, &b.moved) < 0.05 * identification::statistics::rms(&a.moved);
                if alike && (a.bic - b.bic).abs() < TIE_SPAN {
                    notes.push(format!(
                        "{} at {} and {} at {} predict the same {}: not separable {cure}",
                        a.change.kind(),
                        a.change.site(self.plant),
                        b.change.kind(),
                        b.change.site(self.plant),
                        self.compared()
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
        let row = |a: &Fitted| some.iter().map(|b| self.evidence.cosine(&a.moved, &b.moved, &tau)).collect();
        Angles { names: some.iter().map(name).collect(), cosine: some.iter().map(|a| row(a)).collect() }
    }

    /// Three standard errors of every change that was not found.
    fn limits(&self, adopted: &Adopted) -> Vec<DetectionLimit> {
        // the nearest candidate bounds nothing when none was adopted
        let near = usize::from(adopted.members.is_empty());
        let found = |f: &&Fitted| adopted.members.iter().any(|member| member.change == f.change);
        let others = adopted.alone.iter().skip(near).filter(|f| f.sigma.is_finite() && !found(f));
        let each = others.map(|f| {
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
pub(super) fn fit_percent(rms: f64) -> f64 {
    100.0 * (1.0 - rms)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    identification::statistics::rms(&difference)
}
