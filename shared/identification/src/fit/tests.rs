use super::*;
use crate::synthetic::{off_priors, plant, problem, recording, with_effect};
use dynamics::description::Plant;

#[test]
fn estimates_are_within_the_sigmas_they_state() {
    let (mut sum, mut count, mut within) = (0.0, 0.0, 0.0);
    for name in ["oscillator", "drive_rig"] {
        let nominal = plant(name);
        for seed in 1..=6 {
            let truth = off_priors(&nominal, seed);
            let problem = problem(&nominal, recording(&truth, seed, 2.0));
            let session = EstimationSession::new(&problem, 1).unwrap();
            let fitted = fit(&session, &nominal, &session.prior(), &session.noise, 4).unwrap();
            for ((unknown, theta), sigma) in problem.unknowns.iter().zip(&fitted.theta).zip(&fitted.sigma) {
                let true_value = truth.parameters().into_iter().find(|p| p.name == unknown.parameter).unwrap().value;
                let z = (theta - true_value) / sigma;
                (sum, count, within) = (sum + z * z, count + 1.0, within + f64::from(u8::from(z.abs() < 2.0)));
            }
        }
    }
    let rms = f64::sqrt(sum / count);
    // 42 values, some correlated: a chi-squared of 20 degrees leaves [0.7, 1.33] once in 300
    assert!((0.65..1.4).contains(&rms), "{rms}");
    assert!(within / count > 0.85, "{}", within / count);
}

/// Motion tells ratios of forces and inertias alone. Their common factor has the width that the
/// priors leave it: a constant of 5 %, an inertia of 7 % and a friction of 50 %.
#[test]
fn what_no_motion_tells_stays_as_wide_as_its_priors_beside_a_sharp_sign_of_friction() {
    let sharp = [("force", 0.1), ("smooth_rate", 1e-4)];
    let truth = with_effect(&plant("drive_rig"), "joint_coulomb", "joint:drive", &sharp);
    let mut nominal = truth.clone();
    let free = |name: &str| if name == "force" { Some(2.0) } else { None };
    nominal.effects[0].values.iter_mut().for_each(|(name, quantity)| quantity.sigma = free(name));
    let problem = problem(&nominal, recording(&truth, 5, 10.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let fitted = fit(&session, &nominal, &session.prior(), &session.noise, 4).unwrap();
    let i = problem.unknowns.iter().position(|unknown| unknown.name == "motor.constant").unwrap();
    let share = fitted.sigma[i] / fitted.theta[i];
    let inertia = f64::hypot(0.02 * 0.047, 0.1 * 0.12) / (0.047 + 0.12);
    let priors = [0.05, inertia, 0.5].iter().map(|sigma: &f64| sigma.powi(-2)).sum::<f64>().sqrt().recip();
    assert!((0.98..1.02).contains(&(share / priors)), "{}", share / priors);
}

/// A sensitivity that is the swing of a start and not the number's makes its sigma too small by as
/// much as it swings.
#[test]
fn a_hidden_mode_costs_as_many_sigma_as_it_is_off_and_is_found_from_afar() {
    let at = |values: [f64; 3]| {
        let names = ["mass_ratio", "frequency", "damping_ratio"];
        let values: Vec<(&str, f64)> = names.into_iter().zip(values).collect();
        with_effect(&plant("hub_appendage"), "mode_left_out", "mode:bending_2", &values)
    };
    let truth = at([0.04, 17.0, 0.02]);
    let mut start = at([0.055, 17.1, 0.03]);
    start.effects[0].values.iter_mut().for_each(|(_, quantity)| quantity.sigma = Some(0.5 * quantity.value));
    let problem = problem(&start, recording(&truth, 3, 4.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let fitted = fit(&session, &start, &session.prior(), &session.noise, 6).unwrap();
    for (name, truth) in [("mass_ratio", 0.04), ("frequency", 17.0), ("damping_ratio", 0.02)] {
        let i = problem
            .unknowns
            .iter()
            .position(|unknown| unknown.name.ends_with(&format!("left_out@mode:bending_2.{name}")));
        let i = i.unwrap();
        let z = (fitted.theta[i] - truth) / fitted.sigma[i];
        assert!(z.abs() < 4.0, "{name}: {} ± {}", fitted.theta[i], fitted.sigma[i]);
        // alone, by its own curvature: half as much again is what it may bend
        let normal = fitted.linearised.normal(&session, &fitted.theta, &session.noise, &[]).unwrap();
        let alone = problem.unknowns[i].sigma / normal.matrix[(i, i)].sqrt();
        let mut moved = fitted.theta.clone();
        moved[i] += 3.0 * alone;
        let nu = session.innovations(&start, &moved, &fitted.linearised.linears, &|_| true).unwrap();
        let cost = fitted.linearised.objective(&session, &nu, &moved, &session.noise).unwrap() - fitted.objective;
        assert!((6.0..13.5).contains(&cost), "{name}: {cost}");
    }
}

/// A wide prior on its start, which the recording narrows to nothing, would cost a mode more than
/// it explains.
#[test]
fn a_mode_that_an_effect_adds_starts_within_what_the_commands_do_to_it() {
    let nominal = plant("hub_appendage");
    let small = [("mass_ratio", 4e-3), ("frequency", 16.0), ("damping_ratio", 0.005)];
    let augmented = with_effect(&nominal, "mode_left_out", "mode:bending_2", &small);
    let without = problem(&nominal, recording(&augmented, 3, 6.0));
    let session = EstimationSession::new(&without, 1).unwrap();
    let with = without.with_plant(&augmented);
    let like = EstimationSession::like(&session, &with).unwrap();
    let least = |session: &EstimationSession<'_>, plant: &Plant| {
        let fitted = fit(session, plant, &session.prior(), &session.noise, 4).unwrap();
        (fitted.objective, fitted.chi2_per_sample * session.samples as f64)
    };
    let (before, after) = (least(&session, &nominal), least(&like, &augmented));
    let (gained, explained) = (before.0 - after.0, before.1 - after.1);
    assert!(explained > 30.0, "{explained}");
    assert!(gained > explained - 25.0, "{gained} of {explained}");
    // of the two components of an unknown start 0.3 would cost as much again
    let wide = EstimationSession { added: session.added.clone(), ..like.clone() };
    assert!(least(&wide, &augmented).0 > after.0 + 15.0);
    // whichever session it is like
    let own = EstimationSession::new(&with, 1).unwrap();
    assert_eq!(own.added, like.added);
    assert!(own.added[0].iter().all(|(name, sigma)| name.contains("left_out") && *sigma > 0.0 && *sigma < 0.3));
    assert_eq!(own.added[0].len(), 2);
    let again = EstimationSession::like(&like, &without).unwrap();
    assert!(again.added[0].is_empty());
}

#[test]
fn a_masked_parameter_is_corrected_by_the_effect_that_masked_it() {
    let nominal = plant("pendulum");
    let truth = with_effect(&nominal, "joint_coulomb", "joint:pivot", &[("force", 4e-3)]);
    let recorded = recording(&truth, 3, 12.0);
    let without = problem(&nominal, recorded.clone());
    let session = EstimationSession::new(&without, 1).unwrap();
    let biased = fit(&session, &nominal, &session.prior(), &session.noise, 4).unwrap();
    let mut augmented = with_effect(&nominal, "joint_coulomb", "joint:pivot", &[("force", 1e-3)]);
    augmented.effects[0].values[0].1.sigma = Some(0.1);
    let with = without.with_plant(&augmented);
    let session = EstimationSession::like(&session, &with).unwrap();
    let corrected = fit(&session, &augmented, &session.prior(), &session.noise, 4).unwrap();
    let at = |name: &str| with.unknowns.iter().position(|u| u.name == name).unwrap();
    let friction = at("pivot.friction");
    assert!((biased.theta[friction] - 1.5e-3).abs() > 5.0 * biased.sigma[friction]);
    assert!((corrected.theta[friction] - 1.5e-3).abs() < 4.0 * corrected.sigma[friction]);
    let force = with.unknowns.iter().position(|u| u.name.ends_with("force")).unwrap();
    assert!((corrected.theta[force] - 4e-3).abs() < 4.0 * corrected.sigma[force]);
    assert!(corrected.objective < biased.objective - 20.0);
}

/// Unknowns that a recording tells apart only together: a sensitivity bent by its own step would
/// tell them apart alone.
#[test]
fn what_a_recording_tells_does_not_hang_on_how_wide_a_prior_is() {
    let nominal = plant("double_pendulum");
    let truth = with_effect(&nominal, "joint_quadratic_damping", "joint:pivot_1", &[("damping", 1e-4)]);
    let recorded = recording(&truth, 3, 6.0);
    let sigma = |prior: f64| {
        let mut start = truth.clone();
        start.effects[0].values[0].1.sigma = Some(prior);
        let problem = problem(&start, recorded.clone());
        let session = EstimationSession::new(&problem, 1).unwrap();
        let fitted = fit(&session, &start, &session.prior(), &session.noise, 4).unwrap();
        let damping = problem.unknowns.iter().position(|unknown| unknown.name.contains("damping@")).unwrap();
        fitted.sigma[damping]
    };
    let (narrow, wide) = (sigma(1e-3), sigma(1.0));
    assert!((0.8..1.25).contains(&(wide / narrow)), "{narrow:e} {wide:e}");
}

/// A slosh mass whose frequency is off by more than a cycle over the recording: the nearest maximum
/// is another plant's.
#[test]
fn a_slosh_frequency_that_slips_cycles_is_found_by_way_of_disturbances() {
    let nominal = plant("tank_planar");
    let (stiffness_n_m, mass_kg) = (0.12, 38.0);
    let mut truth = nominal.clone();
    truth.set_parameter("fuel.stiffness.y", stiffness_n_m).unwrap();
    truth.set_parameter("fuel.mass", mass_kg).unwrap();
    let problem = problem(&nominal, recording(&truth, 1, 1500.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let direct = fit(&session, &nominal, &session.prior(), &session.noise, 6).unwrap();
    let found = fit_by_continuation(&session, 6).unwrap();
    assert!(direct.chi2_per_sample > 10.0, "{}", direct.chi2_per_sample);
    assert!((0.85..1.15).contains(&found.chi2_per_sample), "{}", found.chi2_per_sample);
    for (name, value) in [("fuel.stiffness.y", stiffness_n_m), ("fuel.mass", mass_kg)] {
        let at = problem.unknowns.iter().position(|unknown| unknown.name == name).unwrap();
        let z = (found.theta[at] - value) / found.sigma[at];
        assert!(z.abs() < 4.0, "{name}: {} ± {}", found.theta[at], found.sigma[at]);
    }
}

/// A fit from far off ends at the limit of its work, half as much again and the sensitivities that
/// any answer needs, and says so; with room it goes on.
#[test]
fn a_fit_keeps_the_limit_of_its_work_and_says_where_it_ended_early() {
    let nominal = plant("drive_rig");
    let truth = off_priors(&nominal, 5);
    let problem = problem(&nominal, recording(&truth, 5, 4.0));
    let spent = |most: f64| {
        let work = std::sync::Arc::new(crate::work::Work::of(most));
        let session = EstimationSession::counted(&problem, 1, work.clone()).unwrap();
        let round = session.round_work();
        let found = fit_by_continuation(&session, 6).unwrap();
        (work.spent(), round, work.note(), found.converged)
    };
    let (whole, round, note, converged) = spent(1e12);
    assert!(converged && note.is_none() && whole > 3.0 * round, "{whole:e} {round:e}");
    for share in [0.0, 0.2, 0.5] {
        let most = share * whole;
        let (spent, _, note, _) = spent(most);
        // a first step, whose sensitivities take up to three passes each, and those of the end
        assert!(spent < crate::work::OVERRUN * most + 6.0 * round, "{share}: {spent:e} of {most:e}, {round:e} a round");
        assert!(note.is_some(), "{share}");
    }
}

#[test]
fn a_session_like_another_one_has_the_commands_of_its_own_plant() {
    let mut stated = plant("drive_rig");
    let mut constant = stated.actuators[0].clone();
    (constant.name, constant.recorded) = ("offset".to_owned(), false);
    let at = |value: f64| {
        let kind = dynamics::description::SignalKind::Constant { value: dynamics::description::Quantity::known(value) };
        vec![dynamics::description::Signal { kind, begin_s: dynamics::description::Quantity::known(0.0), end_s: None }]
    };
    constant.command = at(0.0);
    stated.actuators.push(constant);
    let mut offset = stated.clone();
    offset.actuators.last_mut().unwrap().command = at(0.05);
    let recorded = recording(&offset, 4, 2.0);
    let (stated, moved) = (problem(&stated, recorded.clone()), problem(&offset, recorded));
    let of = |session: &EstimationSession<'_>| {
        let plant = &session.problem.plant;
        LinearisedProblem::new(session, plant, &session.prior(), &session.noise).unwrap().nu
    };
    let other = EstimationSession::new(&stated, 1).unwrap();
    let like = of(&EstimationSession::like(&other, &moved).unwrap());
    assert_eq!(like, of(&EstimationSession::new(&moved, 1).unwrap()));
    assert_ne!(like, of(&other));
}
