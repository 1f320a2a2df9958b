//! What the best model leaves: an unknown law, a time–frequency bin, isolated outliers.

use super::Findings;
use crate::diagnose::ALPHA_SHARE_UNIDENTIFIED;
use crate::diagnose::report::{Verdict, Where};
use crate::omnibus::{Outliers, StrongestBin};
use crate::unknown_law::{Acts, UnknownLaw};
use identification::fit::EstimationSession;
use identification::held_out::Status;

/// A significant map: evidence beyond the correction for the maps tried, and confirmed on parts
/// that it was not fitted to.
pub(super) fn residual_law<'f>(findings: &Findings<'f>) -> Option<&'f UnknownLaw> {
    findings.map.filter(|map| {
        let price = 2.0 * libm::log(map.tried.max(1) as f64 / (ALPHA_SHARE_UNIDENTIFIED * findings.alpha));
        map.evidence > price && map.held_out.status() == Status::Confirmed
    })
}

/// A time–frequency bin of higher energy than chance allows.
pub(super) fn significant_bin<'f>(findings: &'f Findings<'_>) -> Option<&'f StrongestBin> {
    findings.left.strongest_bin.as_ref().filter(|bin| bin.is_significant(ALPHA_SHARE_UNIDENTIFIED * findings.alpha))
}

/// The deviation is due to isolated outliers: with them clipped none is significant.
pub(super) fn has_lone_outliers(findings: &Findings<'_>) -> bool {
    let is_significant = |bin: &StrongestBin| bin.is_significant(ALPHA_SHARE_UNIDENTIFIED * findings.alpha);
    let left = &findings.left;
    significant_bin(findings).is_some()
        && left.outliers.iter().all(Outliers::is_rare)
        && !left.beside.as_ref().is_some_and(is_significant)
}

/// `angle has 3 outliers of 2000, the largest of 17.2 standard deviations at 7.000 s of run.csv`,
/// of every channel.
pub(super) fn outlying(findings: &Findings<'_>) -> String {
    let session = findings.session;
    let reported = |own: &Outliers| {
        format!(
            "{} has {} of {}, the largest of {:.1} standard deviations at {:.3} s of {}",
            session.problem.plant.sensors[own.channel].name,
            own.count,
            own.samples,
            own.largest,
            own.time_s,
            session.problem.recordings[session.problem.runs[own.run].recording]
        )
    };
    findings.left.outliers.iter().map(reported).collect::<Vec<_>>().join("; ")
}

/// Where a time–frequency bin lies.
pub(crate) fn bin_location(session: &EstimationSession<'_>, bin: &StrongestBin) -> Where {
    let channel = session.problem.plant.sensors[bin.channel].name.clone();
    Where { site: channel.clone(), channel, time: bin.time_s, band_hz: bin.band_hz, states: Vec::new(), p: bin.p() }
}

/// The recording that contains a time–frequency bin.
fn recording<'e>(session: &'e EstimationSession<'_>, bin: &StrongestBin) -> &'e str {
    &session.problem.recordings[session.problem.runs[bin.run].recording]
}

pub(super) fn bin_in_words(findings: &Findings<'_>, bin: &StrongestBin) -> String {
    format!(
        "{} of {} from {:.3} to {:.3} s between {:.3} and {:.3} Hz, evidence {:.0}",
        findings.session.problem.plant.sensors[bin.channel].name,
        recording(findings.session, bin),
        bin.time_s[0],
        bin.time_s[1],
        bin.band_hz[0],
        bin.band_hz[1],
        bin.evidence
    )
}

/// Where an unknown law acts.
pub(crate) fn located(session: &EstimationSession<'_>, map: &UnknownLaw, alpha: f64) -> Where {
    let (begin, end) = session
        .problem
        .runs
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(b, e), run| (b.min(run.begin_s), e.max(run.end_s)));
    let channel = match map.place.acts {
        Acts::Reading(channel) => session.problem.plant.sensors[channel].name.clone(),
        Acts::Force(_) => String::new(),
    };
    Where {
        channel,
        site: map.place.site.clone(),
        time: [begin, end],
        band_hz: [0.0, 0.5 / session.timelines[0].period_s],
        states: map.names.clone(),
        p: (libm::exp(-0.5 * map.evidence) * map.tried as f64).min(alpha),
    }
}

pub(super) fn not_named(map: &UnknownLaw) -> (Verdict, String) {
    let what = if matches!(map.place.acts, Acts::Force(_)) { "a force" } else { "an error of the reading" };
    let reason = match &map.plain {
        Some(reported) => format!(
            "something acts at {} that no effect of the catalogue describes: {what} with one parameter, {}, explains as much as effects with {} \
             (ahead by {:.0} in BIC)",
            map.place.site, reported.formula, reported.numbers, map.evidence
        ),
        None => format!(
            "something acts at {} that no effect of the catalogue describes: {what}, smooth over {}, gains {:.0} in evidence \
             and predicts parts of this recording that it was not fitted to (gain {:.1} ± {:.1})",
            map.place.site,
            map.names.join(" and "),
            map.evidence,
            map.held_out.loglik_gain,
            map.held_out.gain_se
        ),
    };
    if map.place.is_of_time() {
        let cure = "an unknown law or a disturbance: repeat the experiment; a residual that recurs at the same states is deterministic, not noise";
        return (Verdict::CannotDecide, format!("{reason}; {cure}"));
    }
    (Verdict::NotInCatalogue, reason)
}
