//! Laws of the whole catalogue.

use super::trial::{Trial, both, defaults, plant};
use super::*;
use dynamics::description::{EffectUse, Plant, Quantity, SiteKind};
use dynamics::dual::Dual;
use dynamics::effect::*;
use dynamics::lags::FilterKind;

mod in_plants;

fn is_snake_case(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

#[test]
fn every_entry_is_named_once_and_says_what_it_is() {
    for (index, effect) in EFFECTS.iter().enumerate() {
        assert!(is_snake_case(effect.kind), "{}", effect.kind);
        assert!(EFFECTS[..index].iter().all(|other| other.kind != effect.kind), "{} twice", effect.kind);
        assert!(EFFECTS[..index].iter().all(|other| other.title != effect.title), "{} twice", effect.title);
        for text in [effect.title, effect.what, effect.signature, effect.confounders, effect.experiment] {
            assert!(text.len() > 10 && !text.contains("  ") && text.is_ascii(), "{}: {text}", effect.kind);
        }
        assert!(!effect.sites.is_empty(), "{}", effect.kind);
    }
}

#[test]
fn every_parameter_has_a_name_of_its_own_and_a_default_within_its_range() {
    for effect in EFFECTS {
        assert!(!effect.parameters.is_empty() && effect.parameters.len() <= PARAMETERS_MAX, "{}", effect.kind);
        assert!(effect.hidden_states <= HIDDEN_MAX, "{}", effect.kind);
        for (index, parameter) in effect.parameters.iter().enumerate() {
            let here = format!("{} {}", effect.kind, parameter.name);
            assert!(is_snake_case(parameter.name), "{here}");
            assert!(effect.parameters[..index].iter().all(|other| other.name != parameter.name), "{here}");
            assert!(parameter.low < parameter.high, "{here}");
            assert!(parameter.low <= parameter.default && parameter.default <= parameter.high, "{here}");
            assert!(!parameter.unit.is_empty() && !parameter.what.is_empty(), "{here}");
        }
        let amplitude = &effect.parameters[..effect.amplitudes()];
        assert!(amplitude.iter().all(|part| part.low <= 0.0 && part.high > 0.0), "{}", effect.kind);
        assert!(amplitude.iter().any(|part| part.default > 0.0), "{}", effect.kind);
    }
}

#[test]
fn confounders_and_experiments_name_effects_that_exist() {
    for effect in EFFECTS {
        let words = effect.confounders.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        for word in words.filter(|word| word.contains('_')) {
            assert!(CATALOGUE.effect(word).is_some(), "{} names '{word}'", effect.kind);
            assert_ne!(word, effect.kind, "{} confounds itself", effect.kind);
        }
    }
}

/// Amplitude zero, all else at every combination of the ends of its range.
fn silent_corners(effect: &Effect) -> Vec<Vec<f64>> {
    let others = &effect.parameters[effect.amplitudes()..];
    let corner = |bits: usize| {
        let ends = others.iter().enumerate().map(|(i, p)| if bits >> i & 1 == 1 { p.high } else { p.low });
        core::iter::repeat_n(0.0, effect.amplitudes()).chain(ends).collect()
    };
    (0..1 << others.len()).map(corner).collect()
}

#[test]
fn at_zero_amplitude_nothing_changes_exactly() {
    for effect in EFFECTS {
        for parameters in silent_corners(effect) {
            match effect.law {
                Law::ActuatorFilter(filter) | Law::SensorFilter(filter) => {
                    assert_eq!(filter(&parameters), FilterKind::None, "{} {parameters:?}", effect.kind);
                }
                Law::Structure(build) => {
                    for site in sites(effect, &plant()) {
                        let mut built = plant();
                        build(&mut built, &site, &parameters).expect("zero amplitude needs nothing");
                        assert_eq!(built, plant(), "{} at {site}", effect.kind);
                    }
                }
                _ => {
                    for k in 0..20 {
                        let state = Trial::random(k);
                        let action = Action { hidden_rate: [0.0; HIDDEN_MAX], ..state.act(effect, &parameters) };
                        assert_eq!(action, state.untouched(effect), "{} {parameters:?}", effect.kind);
                    }
                }
            }
        }
    }
}

fn numbers(action: &Action<f64>) -> Vec<f64> {
    let mut all = vec![action.force, action.value, action.added_mass_kg];
    all.extend(action.wrench);
    all.extend(action.hidden_rate);
    all
}

fn derivatives(action: &Action<Dual>) -> Vec<f64> {
    let mut all = vec![action.force, action.value, action.added_mass_kg];
    all.extend(action.wrench);
    all.extend(action.hidden_rate);
    all.iter().map(|number| number.derivative).collect()
}

/// Every parameter at one and the other end of its range, the rest at their defaults.
fn ends(effect: &Effect) -> Vec<Vec<f64>> {
    let mut all = vec![defaults(effect)];
    for (index, parameter) in effect.parameters.iter().enumerate() {
        for end in [parameter.low, parameter.high] {
            let mut values = defaults(effect);
            values[index] = end;
            all.push(values);
        }
    }
    all
}

#[test]
fn laws_and_their_derivatives_are_finite_at_rest_in_motion_and_at_the_ends_of_every_range() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        for parameters in ends(effect) {
            let still = Trial::default();
            for state in core::iter::once(still).chain((0..50).map(Trial::random)) {
                let here = format!("{} {parameters:?} {state:?}", effect.kind);
                assert!(numbers(&state.act(effect, &parameters)).iter().all(|x| x.is_finite()), "{here}");
                let slope = state.act_dual(effect, &parameters, &Trial::random(1000));
                assert!(derivatives(&slope).iter().all(|x| x.is_finite()), "{here}");
            }
        }
    }
}

#[test]
fn the_law_over_dual_numbers_is_the_derivative_of_the_law() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        let parameters = defaults(effect);
        let mut compared = 0;
        for k in 0..100 {
            let (state, direction) = (Trial::random(k), Trial::random(k + 5000));
            let slope = derivatives(&state.act_dual(effect, &parameters, &direction));
            let difference = |step: f64| -> Vec<f64> {
                let after = numbers(&state.moved(&direction, step).act(effect, &parameters));
                let before = numbers(&state.moved(&direction, -step).act(effect, &parameters));
                after.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * step)).collect()
            };
            let (coarse, fine) = (difference(2e-6), difference(1e-6));
            for ((slope, fine), coarse) in slope.iter().zip(&fine).zip(&coarse) {
                // Richardson's estimate of the truncation error; where it is large a kink or a jump
                // lies between the two points
                let truncation = (fine - coarse).abs();
                let scale = 1.0 + slope.abs();
                if truncation > 1e-4 * scale {
                    continue;
                }
                compared += 1;
                // rounding of the difference: 1e-16 · (values up to 1e6) / 1e-6 relative to scale
                // is below 1e-4
                assert!((slope - fine).abs() <= 2.0 * truncation + 1e-4 * scale, "{} {slope} {fine}", effect.kind);
            }
        }
        assert!(compared > 1000, "{}: {compared} comparisons of 1300", effect.kind);
    }
}

#[test]
fn every_entry_finds_a_site_in_a_plant_with_one_of_everything() {
    let planar = plant();
    let spatial = Plant { space: dynamics::description::Space::Spatial, ..plant() };
    for effect in EFFECTS {
        assert!(!sites(effect, &planar).is_empty() || !sites(effect, &spatial).is_empty(), "{}", effect.kind);
    }
}

#[test]
fn at_its_default_every_effect_does_something_at_every_site() {
    for effect in EFFECTS {
        let parameters = defaults(effect);
        match effect.law {
            Law::ActuatorFilter(filter) | Law::SensorFilter(filter) => {
                assert_ne!(filter(&parameters), FilterKind::None, "{}", effect.kind);
            }
            Law::Structure(build) => {
                for site in sites(effect, &plant()) {
                    let mut built = plant();
                    let done = build(&mut built, &site, &parameters);
                    assert!(done.is_ok(), "{} at {site}: {done:?}", effect.kind);
                    assert_ne!(built, plant(), "{} at {site}", effect.kind);
                }
            }
            _ => {
                let acts = |k| {
                    let state = Trial::random(k);
                    state.act(effect, &parameters) != state.untouched(effect)
                };
                assert!((0..200).any(acts), "{}", effect.kind);
            }
        }
    }
}

#[test]
fn a_law_fills_no_more_hidden_states_than_it_says() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        for k in 0..20 {
            let rates = Trial::random(k).act(effect, &defaults(effect)).hidden_rate;
            assert!(rates[effect.hidden_states..].iter().all(|rate| *rate == 0.0), "{}", effect.kind);
        }
    }
}

fn used(kind: &str, site: &str, values: &[(&str, f64)]) -> EffectUse {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), Quantity::known(*value))).collect();
    EffectUse { kind: kind.to_owned(), site: site.parse().unwrap(), values }
}

#[test]
fn values_stand_in_the_order_of_the_catalogue_with_defaults_filled_in() {
    let effect = CATALOGUE.effect("joint_coulomb").unwrap();
    let values = values(effect, &used("joint_coulomb", "joint:elbow", &[("smooth_rate", 0.5)])).unwrap();
    assert_eq!(values, [effect.parameters[0].default, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_wrong_word_is_answered_with_the_nearest_right_one() {
    let said = |used: EffectUse| {
        let mut plant = plant();
        plant.effects.push(used);
        let before = plant.clone();
        let error = apply_structures(&mut plant).unwrap_err().to_string();
        assert_eq!(plant, before);
        error
    };
    let kind = said(used("joint_columb", "joint:elbow", &[]));
    assert_eq!(kind, "there is no effect 'joint_columb'; did you mean 'joint_coulomb'?");
    let site = said(used("joint_coulomb", "joint:elbw", &[]));
    assert_eq!(site, "joint_coulomb cannot sit at joint:elbw; did you mean 'joint:elbow'?");
    let parameter = said(used("joint_coulomb", "joint:elbow", &[("forze", 1.0)]));
    assert_eq!(parameter, "joint_coulomb has no parameter 'forze'; did you mean 'force'?");
    assert_eq!(said(used("zzz", "joint:elbow", &[])), "there is no effect 'zzz'");
}

#[test]
fn structures_are_built_and_taken_off_the_list_and_all_other_effects_stay_in_order() {
    let mut built = plant();
    built.effects = vec![
        used("joint_coulomb", "joint:elbow", &[]),
        used("slosh_second_mode", "tank:oxidiser", &[]),
        used("sensor_lag", "sensor:enc", &[]),
        used("slosh_cubic", "tank:oxidiser_second", &[]), // sits at a part that a structure has made
    ];
    apply_structures(&mut built).unwrap();
    let kinds: Vec<&str> = built.effects.iter().map(|used| used.kind.as_str()).collect();
    assert_eq!(kinds, ["joint_coulomb", "sensor_lag", "slosh_cubic"]);
    assert_eq!(built.tanks.len(), 2);
    let again = built.clone();
    apply_structures(&mut built).unwrap();
    assert_eq!(built, again);
}

#[test]
fn a_part_that_cannot_be_built_is_refused_with_its_reason_and_the_plant_stays() {
    let mut built = plant();
    built.effects =
        vec![used("com_shift", "body:hub", &[]), used("appendage_left_out", "body:hub", &[("lever_z", 1e3)])];
    let before = built.clone();
    let error = apply_structures(&mut built).unwrap_err();
    assert!(matches!(error, EffectError::Impossible { .. }), "{error}");
    assert_eq!(built, before);
}

/// They do not receive it: a law that used the motion of the body would find a body at rest.
#[test]
fn laws_of_joints_and_tanks_do_not_look_at_the_motion_of_the_body() {
    let at = |effect: &Effect| effect.sites.iter().all(|site| matches!(site, SiteKind::Joint | SiteKind::Tank));
    let mut laws = 0;
    for effect in EFFECTS.iter().filter(|effect| matches!(effect.law, Law::Coordinate(_)) && at(effect)) {
        for k in 0..8 {
            let moving = Trial::random(k);
            let still = Trial { body: BodyState::default(), ..moving };
            let parameters = defaults(effect);
            assert_eq!(moving.act(effect, &parameters), still.act(effect, &parameters), "{}", effect.kind);
        }
        laws += 1;
    }
    assert!(laws > 10, "only {laws} laws were looked at");
}

/// Where its hidden state, if there is one, no longer changes.
fn settled(effect: &Effect, parameters: &[f64], state: Trial) -> Trial {
    let with = |z: f64| Trial { hidden: [z, 0.0, 0.0, 0.0], ..state };
    if effect.hidden_states == 0 {
        return state;
    }
    let rises = |z: f64| with(z).act(effect, parameters).hidden_rate[0] > 0.0;
    let (mut low, mut high) = (-10.0, 10.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if rises(middle) { low = middle } else { high = middle }
    }
    with(0.5 * (low + high))
}

#[test]
fn at_its_limit_an_effect_is_the_simpler_law() {
    let mut limits = 0;
    for effect in EFFECTS {
        for limit in effect.limits {
            limits += 1;
            let simple = CATALOGUE.effect(limit.kind).unwrap_or_else(|| panic!("{} names {}", effect.kind, limit.kind));
            let plain = defaults(simple);
            let value = |(place, parameter): (usize, &EffectParameter)| {
                let at = limit.at.iter().find(|(name, _)| *name == parameter.name).map(|(_, value)| *value);
                let same = simple.parameters.iter().position(|p| p.name == parameter.name).map(|place| plain[place]);
                let own = if place < effect.amplitudes() { Some(plain[place]) } else { None };
                at.or(own).or(same).unwrap_or(parameter.default)
            };
            let values: Vec<f64> = effect.parameters.iter().enumerate().map(value).collect();
            // sliding steadily, beyond where a sign turns, slower than any other width
            for rate in [-0.02, 0.01] {
                let state = Trial { t_s: 1.0, coordinate: 0.3, rate, command: 2.0, reading: 1.0, ..Trial::default() };
                let own = settled(effect, &values, state).act(effect, &values);
                let other = state.act(simple, &plain);
                let pairs = [(own.force, other.force), (own.value, other.value)];
                let wrenches = own.wrench.into_iter().zip(other.wrench);
                for (own, other) in pairs.into_iter().chain(wrenches) {
                    // what is left of the widths: 1e-3 of the law
                    assert!((own - other).abs() <= 1e-3 * other.abs(), "{} {}: {own} {other}", effect.kind, limit.kind);
                }
            }
        }
    }
    assert!(limits >= 8, "{limits}");
}

#[test]
fn amplitudes_come_first_and_times_and_angles_stand_once() {
    for effect in EFFECTS {
        let is_amplitude = |parameter: &EffectParameter| parameter.role == Role::Amplitude;
        assert!(effect.amplitudes() > 0, "{}", effect.kind);
        assert!(!effect.parameters[effect.amplitudes()..].iter().any(is_amplitude), "{}", effect.kind);
        let once = |is_it: &dyn Fn(Role) -> bool| effect.parameters.iter().filter(|p| is_it(p.role)).count() <= 1;
        assert!(once(&|role| role == Role::Onset) && once(&|role| role == Role::Duration), "{}", effect.kind);
        assert!(once(&|role| matches!(role, Role::Direction { .. })), "{}", effect.kind);
        assert!(
            effect.with_role(Role::Duration).is_none() || effect.with_role(Role::Onset).is_some(),
            "{}",
            effect.kind
        );
    }
}
