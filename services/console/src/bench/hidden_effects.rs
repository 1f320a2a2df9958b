//! `obsid bench study-case --hidden`: every effect of the catalogue hidden once in the craft, at a
//! site and of a size drawn from the seed; what the flight makes of each.
//!
//! A size is one to eight times the default of the catalogue, log-uniform, of either sign where the
//! effect has two: the first is hardly seen, the last not overlooked. All other parameters have
//! their defaults. The order is drawn, too: of a measurement that is stopped, the rows that it has
//! written are a fair sample.

use super::study_case::flown;
use super::{Answers, Arguments};
use crate::outcome::JointOutcome;
use crate::{Failure, scenario_file, tell};
use dynamics::description::{Plant, Site};
use dynamics::effect::{Effect, EffectParameter, Role, sites};
use dynamics::noise::Stream;
use plant_file::scenario::Opened;
use serde_json::{Value, json};
use std::fmt::Write;
use telemetry::JointVerdict;

/// Largest size, in defaults of the catalogue.
const SIZE_MAX: f64 = 8.0;
/// Errors over sigmas of an estimate that was put right: of all parameters at most, and of all but
/// one.
const PUT_RIGHT_Z: [f64; 2] = [4.0, 3.0];

/// An effect where it is hidden.
struct Hidden {
    kind: &'static str,
    site: Site,
    parameter: &'static str,
    size: f64,
}

/// What a flight made of it.
struct Flight {
    hidden: Hidden,
    /// Why it could not be flown; nothing else is known then.
    failure: Option<String>,
    /// The first model was refused.
    detected: bool,
    words: String,
    /// It is the first effect found, and nothing else was found; it is among the effects found or
    /// those that could replace them.
    named: bool,
    in_set: bool,
    found: Vec<String>,
    confirmed: bool,
    /// Accepted, and no parameter further off than [`PUT_RIGHT_Z`].
    put_right: bool,
    z_max: f64,
    t_detected_s: Option<f64>,
    wall_s: f64,
}

/// # Errors
/// [`Failure::Input`] where `--only` names no effect that the craft could carry.
pub(super) fn measure(arguments: &Arguments, to: &mut Answers) -> Result<(), Failure> {
    let opened = scenario_file::study_case()?;
    let all = effects(&opened, arguments.seed)?;
    let known: Vec<&str> = all.iter().map(|hidden| hidden.kind).collect();
    if let Some(unknown) = arguments.only.iter().find(|kind| !known.contains(&kind.as_str())) {
        return Err(Failure::Input(miette::miette!(
            help = format!("effects that the craft can carry: {}", known.join(", ")),
            "--only: the craft can carry no '{unknown}'"
        )));
    }
    let chosen = |hidden: &Hidden| arguments.only.is_empty() || arguments.only.iter().any(|kind| kind == hidden.kind);
    let flown = |hidden| {
        let flight = Flight::of(hidden, arguments.seed);
        // one that is stopped leaves the rows until then
        tell(&flight.row());
        flight
    };
    let flights: Vec<Flight> = all.into_iter().filter(chosen).map(flown).collect();
    let object = || {
        let rows: Vec<Value> = flights.iter().map(Flight::json).collect();
        format!("{}\n", json!({ "problem": "study-case", "seed": arguments.seed, "hidden": rows }))
    };
    to.add(|| markdown(&flights), Some(markdown(&flights)), object);
    Ok(())
}

/// Every effect of the catalogue that some part of the craft can carry, in an order drawn from the
/// seed.
fn effects(opened: &Opened, seed: u64) -> Result<Vec<Hidden>, Failure> {
    let impossible = |reason: String| Failure::Run(format!("study case: {reason}"));
    let plan = opened.scenario.craft.as_ref().ok_or_else(|| impossible("no craft".into()))?;
    let arc = plan.arcs.first().ok_or_else(|| impossible("no arc".into()))?;
    let plant = plan.known(arc).map_err(|error| impossible(error.to_string()))?;
    let mut all: Vec<Hidden> =
        plant.catalogue.entries().iter().filter_map(|effect| drawn(effect, &plant, seed)).collect();
    let place = |hidden: &Hidden| Stream::of_parts(seed, &["order", hidden.kind]).uniform_pair(0)[0];
    all.sort_by(|a, b| place(a).total_cmp(&place(b)));
    Ok(all)
}

/// `effect` at a site of `plant` and of a size drawn from the seed; `None` where no site fits.
fn drawn(effect: &'static Effect, plant: &Plant, seed: u64) -> Option<Hidden> {
    let stream = Stream::of_parts(seed, &["hidden", effect.kind]);
    let ([place, direction], [size, sign]) = (stream.uniform_pair(0), stream.uniform_pair(1));
    let pick = |of: usize, share: f64| ((share * of as f64) as usize).min(of.saturating_sub(1));
    let possible = sites(effect, plant);
    let site = possible.get(pick(possible.len(), place))?.clone();
    let amplitudes: Vec<&EffectParameter> =
        effect.parameters_in(plant.space).filter(|parameter| parameter.role == Role::Amplitude).collect();
    let parameter = amplitudes.get(pick(amplitudes.len(), direction))?;
    // components of a vector may have none
    let usual = effect.parameters.iter().take(effect.amplitudes()).map(|p| p.default.abs()).fold(0.0, f64::max);
    let size = usual * libm::pow(SIZE_MAX, size);
    let size = if parameter.low < 0.0 && sign < 0.5 { -size } else { size };
    Some(Hidden { kind: effect.kind, site, parameter: parameter.name, size: size.clamp(parameter.low, parameter.high) })
}

impl Hidden {
    /// As `--hide` takes it.
    fn text(&self) -> String {
        format!("{}@{} {}={:.3e}", self.kind, self.site, self.parameter, self.size)
    }

    fn is(&self, kind: &str, site: &Site) -> bool {
        self.kind == kind && self.site == *site
    }
}

impl Flight {
    /// One flight, in lockstep.
    fn of(hidden: Hidden, seed: u64) -> Self {
        tell(&hidden.text());
        let failed = |failure: Failure| match failure {
            Failure::Run(reason) => reason,
            other => format!("{other:?}"),
        };
        let flight = scenario_file::study_case_hiding(&[hidden.text()]).and_then(|opened| flown(opened, seed));
        match flight {
            Ok((joint, wall_s)) => Self::read(hidden, &joint, wall_s),
            Err(failure) => Self::failed(hidden, failed(failure)),
        }
    }

    fn failed(hidden: Hidden, reason: String) -> Self {
        Self {
            hidden,
            failure: Some(reason),
            detected: false,
            words: String::new(),
            named: false,
            in_set: false,
            found: Vec::new(),
            confirmed: false,
            put_right: false,
            z_max: f64::NAN,
            t_detected_s: None,
            wall_s: f64::NAN,
        }
    }

    fn read(hidden: Hidden, joint: &JointOutcome, wall_s: f64) -> Self {
        let missing = joint.missing.as_ref();
        let effects: Vec<_> = missing.map_or(Vec::new(), |missing| missing.named().collect());
        let found: Vec<_> = effects.iter().filter(|one| one.stands_in_for.is_none()).collect();
        let is_it = |one: &craft::missing::Missing| hidden.is(&one.kind, &one.site);
        let rows = joint.generations.last().map_or(&[][..], |last| &last.rows);
        let z: Vec<f64> = rows.iter().map(|row| row.z().abs()).filter(|z| z.is_finite()).collect();
        let accepted = joint.verdict == JointVerdict::Accepted;
        Self {
            failure: None,
            detected: missing.is_some() || !accepted,
            words: joint.words(),
            named: matches!(found[..], [one] if is_it(one)),
            in_set: effects.iter().any(|one| is_it(one)),
            found: found.iter().map(|one| format!("{}@{}", one.kind, one.site)).collect(),
            confirmed: missing.is_some_and(|missing| missing.is_confirmed()),
            put_right: accepted && is_put_right(&z),
            z_max: z.iter().copied().fold(0.0, f64::max),
            t_detected_s: missing.and_then(|missing| missing.t_detected_s()),
            wall_s,
            hidden,
        }
    }

    /// Of a table of Markdown.
    fn row(&self) -> String {
        let word = |is: bool| if is { "yes" } else { "no" };
        let found = match (self.named, &self.found[..]) {
            (true, _) => "it".to_owned(),
            (false, []) => "-".to_owned(),
            (false, found) => found.join(", "),
        };
        format!(
            "| {} | {} | {found} | {} | {} | {} | {:.1} | {} | {} |",
            self.hidden.text(),
            word(self.detected),
            word(self.in_set),
            word(self.confirmed),
            word(self.put_right),
            self.z_max,
            self.t_detected_s.map_or("-".to_owned(), |t_s| format!("{t_s:.0} s")),
            self.failure.as_ref().unwrap_or(&self.words)
        )
    }

    fn json(&self) -> Value {
        json!({
            "kind": self.hidden.kind, "site": self.hidden.site.to_string(), "parameter": self.hidden.parameter,
            "size": self.hidden.size, "failure": self.failure, "detected": self.detected, "verdict": self.words,
            "named": self.named, "in_set": self.in_set, "found": self.found, "confirmed": self.confirmed,
            "put_right": self.put_right, "z_max": self.z_max, "t_detected_s": self.t_detected_s,
            "wall_s": self.wall_s,
        })
    }
}

/// At most one error beyond three sigma, none beyond four.
fn is_put_right(z: &[f64]) -> bool {
    let beyond = |limit: f64| z.iter().filter(|z| **z > limit).count();
    !z.is_empty() && beyond(PUT_RIGHT_Z[0]) == 0 && beyond(PUT_RIGHT_Z[1]) <= 1
}

fn markdown(flights: &[Flight]) -> String {
    let mut text = "| hidden | detected | found | in set | confirmed | parameters right | largest z | detected after | verdict |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    flights.iter().for_each(|flight| {
        let _ = writeln!(text, "{}", flight.row());
    });
    let count = |is: &dyn Fn(&Flight) -> bool| flights.iter().filter(|flight| is(flight)).count();
    let _ = writeln!(
        text,
        "\nOf {}: {} detected, {} named, {} in the set, {} confirmed, {} with every parameter right.",
        flights.len(),
        count(&|one| one.detected),
        count(&|one| one.named),
        count(&|one| one.in_set),
        count(&|one| one.confirmed),
        count(&|one| one.put_right)
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_hides_every_effect_once_at_a_site_of_the_craft_and_the_scenario_can_be_flown() {
        let opened = scenario_file::study_case().unwrap();
        let all = effects(&opened, 5).unwrap();
        assert!(all.len() > 40, "{}", all.len());
        let other = effects(&opened, 6).unwrap();
        let kinds = |all: &[Hidden]| all.iter().map(|hidden| hidden.kind).collect::<Vec<_>>();
        assert_ne!(kinds(&all), kinds(&other));
        let again =
            |own: &Hidden| other.iter().find(|other| other.kind == own.kind).is_some_and(|o| o.site != own.site);
        assert!(all.len() == other.len() && all.iter().any(again));
        for hidden in all.iter().filter(|hidden| ["joint_coulomb", "gyro_g_sensitivity"].contains(&hidden.kind)) {
            assert!(scenario_file::study_case_hiding(&[hidden.text()]).is_ok(), "{}", hidden.text());
        }
    }

    #[test]
    fn one_parameter_beyond_three_sigma_is_right_and_two_or_one_beyond_four_are_not() {
        assert!(is_put_right(&[0.1, 3.9, 2.9]));
        assert!(!is_put_right(&[3.1, 3.2]) && !is_put_right(&[4.1]) && !is_put_right(&[]));
    }
}
