use crate::diagnose::{Options, Verdict};
use crate::evidence::diagnose;
use crate::noise::Noise;
use channels::{Channel, Recording, Role};
use identification::problem::Problem;
use identification::work::QUICK_WORK;

/// A cart on a rail, its force commanded; nothing is known of what slows it.
const CART: &str = r#"
    format = 1
    name = "cart"
    space = "planar"

    [[body]]
    name = "cart"
    mass = { value = "2 kg", sigma = "0.02 kg" }
    inertia = 0

    [body.joint]
    kind = "prismatic"
    name = "rail"
    axis = "x"

    [[actuator]]
    name = "force"
    kind = "joint_torque"
    joint = "rail"
    command = { kind = "square", amplitude = "5 N", frequency = "0.1 Hz" }

    [[sensor]]
    name = "velocity"
    kind = "joint_rate"
    joint = "rail"
    noise = "0.005 m/s"

    [initial]
    "joint:rail" = { rate = { value = 0, sigma = "0.05 m/s", scope = "per recording" } }

    [simulation]
    duration = "10 s"
    period = "0.01 s"
"#;

const PERIOD_S: f64 = 0.01;
const MASS_KG: f64 = 2.0;
const DRAG_N_S_M: f64 = 0.8;
const FRICTION_N: f64 = 0.35;

/// `m v' = f − d v − c sign(v)` under a force that is linear between the stamps of its samples.
fn cart(seed: u64, samples: usize) -> Recording {
    let mut draw = Noise::new(seed);
    let phases: Vec<f64> = (0..3).map(|_| core::f64::consts::TAU * draw.normal()).collect();
    let tones = [2.3, 5.1, 9.7];
    let force = |t_s: f64| tones.iter().zip(&phases).map(|(w, phase)| 2.0 * (w * t_s + phase).sin()).sum::<f64>();
    let time_s: Vec<f64> = (0..samples).map(|k| PERIOD_S * k as f64).collect();
    let sampled: Vec<f64> = time_s.iter().map(|t_s| force(*t_s)).collect();
    const PARTS: usize = 100;
    let mut v = 0.0;
    let velocity = (0..samples).map(|k| {
        let reading = v + 0.005 * draw.normal();
        let next = sampled[(k + 1).min(samples - 1)];
        for part in 0..PARTS {
            let share = (part as f64 + 0.5) / PARTS as f64;
            let drive = sampled[k] + share * (next - sampled[k]) - DRAG_N_S_M * v;
            let dt_s = PERIOD_S / PARTS as f64;
            // friction opposes the motion and ends it, and turns none round
            let pushed = v + dt_s * drive / MASS_KG;
            let most = dt_s * FRICTION_N / MASS_KG;
            v = pushed - pushed.clamp(-most, most);
        }
        reading
    });
    let velocity = velocity.collect();
    let channel = |name: &str, unit: &str, value: Vec<f64>, role: Role| Channel {
        name: name.to_owned(),
        unit: unit.to_owned(),
        time_s: time_s.clone(),
        value,
        role,
    };
    let channels =
        vec![channel("velocity", "m/s", velocity, Role::Output), channel("force", "N", sampled.clone(), Role::Input)];
    Recording { name: format!("seed_{seed}"), channels }
}

/// Half a sample of shift is nothing beside a motion that lacks friction, and a compliance beside
/// one that has it.
#[test]
fn a_force_that_is_linear_between_its_samples_is_a_matter_of_timing_beside_the_laws_that_are_missing() {
    let nominal = plant_file::parse("cart", CART).unwrap().plant;
    let problem = Problem::new(&nominal, &[cart(7, 500)], &[]).unwrap();
    let options = Options { work_max: QUICK_WORK, ..Options::default() };
    let found = diagnose(&problem, &options, &mut |_, _| {});
    let [timing] = &found.input_timing[..] else { panic!("{:?}: {}", found.verdict, found.reason) };
    assert!((timing.shift_samples + 0.5).abs() < 0.3 && timing.probability > 0.9, "{timing:?}");
    assert!([Verdict::Named, Verdict::NotSeparable].contains(&found.verdict), "{:?}", found.verdict);
    let kinds: Vec<&str> = found.effects.iter().map(|own| &*own.kind).collect();
    let viscous = ["joint_viscous", "linear_drag"];
    assert!(kinds.len() == 2 && kinds.contains(&"joint_coulomb"), "{kinds:?}");
    assert!(kinds.iter().any(|kind| viscous.contains(kind)), "{kinds:?}");
    for effect in &found.effects {
        let truth = if effect.kind == "joint_coulomb" { FRICTION_N } else { DRAG_N_S_M };
        let number = &effect.parameters[0];
        assert!((number.value - truth).abs() < 4.0 * number.sigma, "{} {number:?}", effect.kind);
    }
}
