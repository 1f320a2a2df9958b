//! Numbers of an answer: the plant before and after, held-out data, detection limits.

use super::Shown;
use crate::diagnose::{DetectionLimit, HeldOut, HeldOutChannel, HeldOutKind, Nominal, Verdict, whiteness_p};
use crate::evidence::decide::LEVEL;
use crate::evidence::horizon::Site;
use crate::evidence::model::{Ground, Model};
use crate::evidence::screen::Looked;
use dynamics::description::{EffectUse, Plant};
use identification::held_out::{ChannelFit, Gain};
use identification::problem::Unknown;

impl Shown<'_> {
    pub(super) fn nominal(&self) -> Vec<Nominal> {
        let before = &self.bare().model;
        let moves = self.has_effects() || matches!(self.verdict(), Verdict::ParameterConflict | Verdict::InputTiming);
        let after = if moves { &self.leader().model } else { before };
        let is_new = |own: &&Unknown| {
            let known = before.problem.unknowns.iter().any(|other| other.name == own.name);
            !known && !own.parameter.starts_with("effect.")
        };
        let freed = after.problem.unknowns.iter().filter(is_new);
        let all = before.problem.unknowns.iter().chain(freed);
        all.map(|unknown| {
            let place = |model: &Model| model.problem.unknowns.iter().position(|other| other.name == unknown.name);
            let [from, to] =
                [before, after].map(|model| place(model).map(|at| (model.fit.theta[at], model.fit.sigma[at])));
            let from = from.unwrap_or((unknown.prior, 0.0));
            let (value, sigma) = to.unwrap_or(from);
            let shift_sigma = if sigma > 0.0 { (value - from.0) / sigma } else { 0.0 };
            Nominal { name: unknown.name.clone(), before: from.0, after: value, sigma, shift_sigma }
        })
        .collect()
    }

    /// Share of each channel's misfit that noise cannot explain, which the leading model takes
    /// away.
    pub(super) fn shares(&self) -> Vec<f64> {
        self.compared.iter().flat_map(|compared| &compared.sites).filter_map(|site| site.share).collect()
    }

    /// Free runs over the horizon, in words.
    pub(super) fn horizon(&self) -> Option<String> {
        let compared = self.compared.as_ref().filter(|_| self.decision.leader != self.quiet)?;
        let site = |site: &Site| {
            let worse = if site.is_worse { ", worse" } else { "" };
            let Site { name, before, after, noise, .. } = site;
            format!("{name}: {before:.3e} without, {after:.3e} with (noise {noise:.3e}){worse}")
        };
        let all: Vec<String> = compared.sites.iter().map(site).collect();
        Some(format!("free runs over {:.3} s: {}", compared.window_s, all.join("; ")))
    }

    pub(super) fn held_out(&self) -> HeldOut {
        let both = self.leader().held_out.as_ref().zip(self.bare().held_out.as_ref());
        let unseen = &self.unseen;
        let (kind, before, after) = match both {
            Some((own, bare)) => (HeldOutKind::Recording, &bare.free, &own.free),
            None => (unseen.kind, &unseen.before, &unseen.after),
        };
        let channel = |(before, after): (&ChannelFit, &ChannelFit)| HeldOutChannel {
            name: before.name.clone(),
            fit_percent_before: before.fit_percent,
            fit_percent_after: after.fit_percent,
            rms_before: before.rms,
            rms_after: after.rms,
        };
        let gain = self.gain();
        let p = |model: &Model| {
            let session = model.session(Ground { session: self.session })?;
            whiteness_p(&session, &model.fit, &model.noise)
        };
        HeldOut {
            kind,
            channels: before.iter().zip(after).map(channel).collect(),
            loglik_gain: gain.as_ref().map(|gain| gain.loglik_gain),
            gain_se: gain.as_ref().map(|gain| gain.gain_se),
            gain_ci95: gain.as_ref().map(Gain::interval95),
            whiteness_p_before: p(&self.bare().model),
            whiteness_p_after: p(&self.leader().model),
        }
    }

    /// Amplitudes at which expected log odds reach the level: `d²/2 = ln 9 + ln m`, Occam's factor
    /// left out.
    pub(super) fn limits(&self) -> Vec<DetectionLimit> {
        let d = (2.0 * (libm::log(LEVEL / (1.0 - LEVEL)) + self.pool.log_m)).sqrt();
        let limit = |own: &Looked| {
            let (kind, site) = (own.candidate.effect.kind.to_owned(), own.candidate.site.clone());
            let used = EffectUse { kind: kind.clone(), site: site.clone(), values: Vec::new() };
            let unit = self.session.problem.plant.effect_unit(&used, own.candidate.effect.parameters[0].unit);
            DetectionLimit { kind, site: site.to_string(), amplitude: d * own.sigma, unit }
        };
        self.pool.looked.iter().map(limit).collect()
    }

    /// The leading plant with its numbers and their standard deviations.
    pub(super) fn posterior(&self) -> Plant {
        let model = &self.leader().model;
        let mut plant = model.problem.plant.clone();
        plant.visit_quantities(&mut |name, _, quantity| {
            let shared = model.problem.unknowns.iter().position(|u| u.parameter == name && u.recording.is_none());
            if let Some(at) = shared {
                quantity.value = model.fit.theta[at];
                quantity.sigma = Some(model.fit.sigma[at].max(f64::MIN_POSITIVE));
            }
        });
        plant
    }
}
