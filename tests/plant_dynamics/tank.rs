//! Propellant on one axis (BP2).

use crate::subject::{ROUNDING, STATES, Subject, Worst, plant, value};
use physics::slosh::{SloshParameters, SloshState};

/// The benchmark's tank, and one in which no term is small.
const TANKS: [&[(&str, f64)]; 2] =
    [&[], &[("fuel.mass", 310.0), ("fuel.stiffness.x", 47.0), ("fuel.damping.x", 11.0), ("craft.mass", 640.0)]];

#[test]
fn accelerations_and_momentum_of_a_sloshing_craft_are_those_of_the_closed_form() {
    for changes in TANKS {
        let plant = plant("tank_1d", changes);
        let tank = SloshParameters {
            slosh_mass_kg: value(&plant, "fuel.mass"),
            stiffness_n_m: value(&plant, "fuel.stiffness.x"),
            damping_n_s_m: value(&plant, "fuel.damping.x"),
        };
        let base_mass_kg = value(&plant, "craft.mass");
        let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
        for k in 0..STATES {
            subject.draw(k);
            subject.push(k, 44.0);
            let state =
                SloshState { displacement_m: subject.at("tank:fuel"), velocity_m_s: subject.at("tank:fuel.rate") };
            let force = subject.input("thrust");
            let closed = tank.accelerations(base_mass_kg, &state, force);
            let [base, relative] = subject.rates(["joint:track.rate", "tank:fuel.rate"]);
            let pull =
                (tank.stiffness_n_m * state.displacement_m).abs() + (tank.damping_n_s_m * state.velocity_m_s).abs();
            let size = (force.abs() + pull) / base_mass_kg;
            worst.see(base - closed.base_m_s2, size);
            worst.see(relative - closed.relative_m_s2, size + pull / tank.slosh_mass_kg);
            let speed = subject.at("joint:track.rate");
            let momentum = (base_mass_kg + tank.slosh_mass_kg) * speed + tank.slosh_mass_kg * state.velocity_m_s;
            let size = (base_mass_kg + tank.slosh_mass_kg) * (speed.abs() + state.velocity_m_s.abs());
            worst.see(subject.totals().linear_momentum_n_s[0] - momentum, size);
        }
        worst.demand("accelerations and momentum, BP2", ROUNDING);
    }
}
