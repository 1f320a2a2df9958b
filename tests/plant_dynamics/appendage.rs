//! Hub with a flexible appendage (BP3).

use crate::subject::{ROUNDING, STATES, Subject, Worst, plant, value};
use core::f64::consts::TAU;
use dynamics::description::Plant;
use dynamics::system::Workspace;
use physics::appendage::{Appendage, Mode};

fn closed_form(plant: &Plant) -> Appendage {
    let at = |name: &str| value(plant, name);
    let (x, y) = (at("hub.com.x"), at("hub.com.y"));
    let mode = |name: &str| Mode {
        frequency_hz: at(&format!("{name}.frequency")),
        damping_ratio: at(&format!("{name}.damping_ratio")),
    };
    Appendage {
        inertia_kg_m2: at("hub.inertia.zz") + at("hub.mass") * (x * x + y * y),
        coupling: ["bending_1.rotation.z", "bending_2.rotation.z"].map(at),
        locked: ["bending_1", "bending_2"].map(mode),
    }
}

/// Less inertia and another coupling: hub-free far from hub-locked.
const LIGHT: [(&str, f64); 3] =
    [("hub.inertia.zz", 150.0), ("bending_1.rotation.z", -9.3), ("bending_2.rotation.z", 5.7)];

#[test]
fn hub_free_modes_are_those_of_the_quartic_and_of_the_published_table() {
    for (changes, printed_hz) in [(&[][..], Some([1.56110, 6.48443])), (&LIGHT, None)] {
        let plant = plant("hub_appendage", changes);
        let closed = closed_form(&plant).hub_free_modes().expect("possible");
        let subject = Subject::new(plant);
        let found = subject.system.modes(&mut Workspace::new(&subject.system), 0.0, &subject.x, &subject.u);
        assert_eq!((found.modes.len(), found.zeros), (2, 2));
        let mut worst = Worst::default();
        for (mode, closed) in found.modes.iter().zip(&closed) {
            worst.see(mode.frequency_hz - closed.frequency_hz, closed.frequency_hz);
            // the ratio is a small part of the pole
            worst.see(mode.damping_ratio - closed.damping_ratio, 1.0);
        }
        worst.demand("hub-free poles, BP3", 1e-11);
        if let Some(printed) = printed_hz {
            let near =
                |(mode, printed): (&dynamics::system::SystemMode, f64)| (mode.frequency_hz - printed).abs() < 5e-6;
            assert!(found.modes.iter().zip(printed).all(near), "{:?}", found.modes); // half of the last digit
        }
    }
}

#[test]
fn accelerations_of_hub_and_modes_are_those_of_the_closed_form() {
    for changes in [&[][..], &LIGHT] {
        let plant = plant("hub_appendage", changes);
        let closed = closed_form(&plant);
        let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
        for k in 0..STATES {
            subject.draw(k);
            subject.push(k, 20.0);
            let torque = subject.input("torque");
            let modal = ["mode:bending_1", "mode:bending_2"].map(|name| subject.at(name));
            let rate = ["mode:bending_1.rate", "mode:bending_2.rate"].map(|name| subject.at(name));
            let found = subject.rates(["joint:bearing.rate", "mode:bending_1.rate", "mode:bending_2.rate"]);
            let expected = closed.accelerations(torque, modal, rate);
            let pull = [0, 1].map(|i| {
                let w = TAU * closed.locked[i].frequency_hz;
                (w * w * modal[i]).abs() + (2.0 * closed.locked[i].damping_ratio * w * rate[i]).abs()
            });
            let [c1, c2] = closed.coupling.map(f64::abs);
            let hub = (torque.abs() + c1 * pull[0] + c2 * pull[1]) / (closed.inertia_kg_m2 - c1 * c1 - c2 * c2);
            let size = [hub, c1 * hub + pull[0], c2 * hub + pull[1]];
            (0..3).for_each(|i| worst.see(found[i] - expected[i], size[i]));
            // h = J θ' + Σ c d'
            let momentum = closed.inertia_kg_m2 * subject.at("joint:bearing.rate")
                + closed.coupling[0] * rate[0]
                + closed.coupling[1] * rate[1];
            let terms = (closed.inertia_kg_m2 * subject.at("joint:bearing.rate")).abs() + c1 + c2;
            worst.see(subject.totals().angular_momentum_origin_n_m_s[2] - momentum, terms);
        }
        worst.demand("accelerations and momentum, BP3", ROUNDING);
    }
}
