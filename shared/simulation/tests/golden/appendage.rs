//! A hub with a beam, against an independent finite-element beam of quintic elements.

use crate::{agree, number, numbers, plant};
use core::f64::consts::TAU;
use dynamics::beam::Cantilever;
use dynamics::description::Plant;
use dynamics::system::{System, Workspace};
use serde_json::Value;
use simulation::Simulator;

const GOLDEN: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/appendage_fe.json"));

fn golden() -> Value {
    serde_json::from_str(GOLDEN).unwrap()
}

/// The hub with so many clamped modes of the document.
fn hub_with(golden: &Value, damping_ratios: &[f64]) -> Plant {
    let radius = number(&golden["root_radius_m"]);
    let stations = numbers(&golden["sensors_x_m"]);
    let inertia = number(&golden["total_inertia_kg_m2"]);
    let torque = number(&golden["torque_nm"]);
    let end = number(&golden["pulse_end_s"]);
    let mut text = format!(
        "format = 1\nname = 'golden'\nspace = 'planar'\n\
         [[body]]\nname = 'hub'\nmass = '100 kg'\ninertia = '{inertia} kg*m^2'\njoint = {{ kind = 'revolute', name = 'axis' }}\n\
         [[actuator]]\nname = 'torque'\nkind = 'joint_torque'\njoint = 'axis'\n\
         command = {{ kind = 'pulse', size = '{torque} N*m', width = '{end} s' }}\n\
         [simulation]\nduration = '2 s'\nperiod = '20 ms'\nintegrator = 'exact_zero_order_hold'\n\
         [[appendage]]\nname = 'beam'\nbody = 'hub'\n"
    );
    for (k, x) in stations.iter().enumerate() {
        text += &format!("points.p{k} = ['{} m', 0]\n", radius + x);
    }
    for (i, (mode, damping)) in golden["clamped_modes"].as_array().unwrap().iter().zip(damping_ratios).enumerate() {
        let get = |key: &str| number(&mode[key]);
        text += &format!(
            "[[appendage.mode]]\nname = 'mode_{i}'\nfrequency = '{} Hz'\ndamping_ratio = {damping}\n\
             rotation = '{} sqrt(kg)*m'\ntranslation = [0, '{} sqrt(kg)']\n",
            get("frequency_hz"),
            get("participation_rotation_kg_sqrt_m"),
            get("participation_translation_kg_sqrt")
        );
        for (k, shape) in numbers(&mode["shape"]).iter().enumerate() {
            text += &format!("shape.p{k} = [0, '{shape} 1/sqrt(kg)']\n");
        }
    }
    plant(&text)
}

fn refinement(golden: &Value, of: &str, what: &str) -> f64 {
    number(&golden["refinement"][of][what])
}

/// Frequencies and shapes in closed form (`beam`) against the elements, to what refining the mesh
/// still changes.
#[test]
fn golden_clamped_modes_of_the_elements_are_those_of_the_closed_form() {
    let golden = golden();
    let get = |key: &str| number(&golden[key]);
    let beam = Cantilever {
        length_m: get("length_m"),
        mass_per_length_kg_m: get("mass_per_length_kg_m"),
        bending_stiffness_n_m2: get("bending_stiffness_n_m2"),
    };
    for (i, expected) in golden["clamped_modes"].as_array().unwrap().iter().enumerate() {
        let mode = beam.mode(i + 1);
        let frequency = [mode.angular_frequency_rad_s / TAU];
        let tolerance = refinement(&golden, "clamped_modes", "frequency_hz");
        agree(&format!("mode {i}, frequency"), &frequency, &[number(&expected["frequency_hz"])], 2.0 * tolerance);
        // The elements' sign has the tip positive, the closed form's too but for every second mode.
        let sign = mode.shape(beam.length_m).signum();
        let shape: Vec<f64> = numbers(&golden["sensors_x_m"]).iter().map(|x| sign * mode.shape(*x)).collect();
        let tolerance = refinement(&golden, "clamped_modes", "shape");
        agree(&format!("mode {i}, shape"), &shape, &numbers(&expected["shape"]), 2.0 * tolerance);
    }
}

/// Hub-free frequencies of the plant with the first `modes` clamped ones, lowest first.
fn hub_free_hz(golden: &Value, modes: usize) -> Vec<f64> {
    let system = System::new(&hub_with(golden, &vec![0.0; modes])).unwrap();
    let (x, u) = (vec![0.0; system.states().len()], vec![0.0; system.inputs().len()]);
    let found = system.modes(&mut Workspace::new(&system), 0.0, &x, &u);
    found.modes.iter().map(|mode| mode.frequency_hz).collect()
}

/// A clamped mode i that is left out adds `p_i² ω²/(ω_i² − ω²)` to the hub's inertia; Rayleigh's
/// quotient of a mode with hub angle θ and unit modal mass then falls by `θ²` times that. Of the
/// modes behind the fifth only the sum of `p_i²` is known, the beam's inertia less that of the
/// first five, and that they are faster than it.
#[test]
fn golden_hub_free_modes_are_approached_from_above_as_far_as_left_out_modes_allow() {
    let golden = golden();
    let clamped = golden["clamped_modes"].as_array().unwrap();
    let beam = number(&golden["total_inertia_kg_m2"]) - number(&golden["hub_inertia_kg_m2"]);
    let carried = clamped.iter().map(|mode| number(&mode["participation_rotation_kg_sqrt_m"]));
    let rest = beam - carried.map(|p| p * p).sum::<f64>();
    assert!(rest > 0.0 && rest < 0.01 * beam, "{rest}");
    let fifth = number(&clamped[4]["frequency_hz"]);
    let accuracy = 2.0 * refinement(&golden, "free_modes", "frequency_hz");
    let found: Vec<Vec<f64>> = (1..=5).map(|modes| hub_free_hz(&golden, modes)).collect();
    for (k, free) in golden["free_modes"].as_array().unwrap().iter().take(3).enumerate() {
        let (exact, angle) = (number(&free["frequency_hz"]), number(&free["hub_angle"]));
        let errors: Vec<f64> = found[k..].iter().map(|modes| modes[k] / exact - 1.0).collect();
        println!("hub-free mode {k}, {} to 5 clamped ones: {errors:?}", k + 1);
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
        let last = *errors.last().unwrap();
        let bound = 0.5 * angle * angle * rest * exact * exact / (fifth * fifth - exact * exact);
        assert!(last > -accuracy && last < bound + accuracy, "{last:.2e} {bound:.2e}");
    }
}

/// The two documents' frequencies with two modes, whose truth the elements restricted to them do
/// not state: 1.56110 and 6.48443 Hz.
#[test]
fn golden_two_clamped_modes_give_the_hub_free_frequencies_of_the_benchmark() {
    let found = hub_free_hz(&golden(), 2);
    assert!((found[0] - 1.56110).abs() < 5e-6 && (found[1] - 6.48443).abs() < 5e-6, "{found:?}"); // half of the last digit
}

/// Torque pulse and what follows. The exact hold has rounding alone; what the document knows is
/// what refining its mesh changes.
fn history_agrees(name: &str) {
    let golden = golden();
    let histories = golden["histories"].as_array().unwrap();
    let history = histories.iter().find(|history| history["name"] == name).unwrap();
    let damping_ratios = numbers(&history["damping_ratios"]);
    let plant = hub_with(&golden, &damping_ratios);
    let system = System::new(&plant).unwrap();
    let mut workspace = Workspace::new(&system);
    let mut simulator = Simulator::new(&plant, 1, "golden").unwrap();
    let tip_m = number(&golden["root_radius_m"]) + number(&golden["length_m"]);
    let modes = golden["clamped_modes"].as_array().unwrap().iter().take(damping_ratios.len());
    let tip: Vec<f64> = modes.map(|mode| *numbers(&mode["shape"]).last().unwrap()).collect();
    let first = |name: &str| system.states().iter().position(|state| state.name == name).unwrap();
    let (angle, eta) = (first("joint:axis"), first("mode:mode_0"));
    let (rate, eta_rate) = (first("joint:axis.rate"), first("mode:mode_0.rate"));
    let mut found = [const { Vec::new() }; 4];
    let mut rates = vec![0.0; system.states().len()];
    for (time, torque) in numbers(&golden["t_s"]).iter().zip(numbers(&history["torque_nm"])) {
        assert!((simulator.time_s() - time).abs() < 1e-12);
        let x = simulator.truth().state.to_vec();
        system.derivative(&mut workspace, *time, &x, &[torque], &mut rates);
        let bent = |from: &[f64], at: usize| tip.iter().zip(&from[at..]).map(|(phi, eta)| phi * eta).sum::<f64>();
        found[0].push(x[angle]);
        found[1].push(x[rate]);
        found[2].push(bent(&x, eta));
        found[3].push(tip_m * rates[rate] + bent(&rates, eta_rate));
        simulator.step();
    }
    let names = ["hub_angle_rad", "hub_rate_rad_s", "tip_deflection_m", "tip_tangential_acceleration_m_s2"];
    for (found, what) in found.iter().zip(names) {
        let tolerance = (2.0 * refinement(&golden, name, what)).max(1e-9);
        agree(&format!("{name}, {what}"), found, &numbers(&history[what]), tolerance);
    }
}

#[test]
fn golden_history_of_two_damped_modes() {
    history_agrees("damped_clamped_modes_1_2");
}

#[test]
fn golden_history_of_two_undamped_modes() {
    history_agrees("undamped_clamped_modes_1_2");
}

#[test]
fn golden_history_of_five_undamped_modes() {
    history_agrees("undamped_clamped_modes_1_to_5");
}
