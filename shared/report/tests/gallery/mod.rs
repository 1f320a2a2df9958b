//! One page with everything on it, from data like those of an experiment.

use report::{
    Band, Bar, Bars, Block, Cell, Clusters, Cumulative, Curve, Figure, Mark, Matrix, Mode, Overlay, Page, Pole, Role,
    Scatter, Section, Spectrum, Stabilisation, Stability, StateMap, Table, TileMap, Tiles,
};

/// A deterministic noise, about normal with deviation 1.
pub fn noise(i: usize) -> f64 {
    let one = |k: u64| {
        let mut x = (i as u64 * 12 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x >> 40) as f64 / f64::from(1_u32 << 24)
    };
    (0..12).map(one).sum::<f64>() - 6.0
}

/// A free swing: time, measured, model before, model after, truth.
pub struct Swing {
    pub t: Vec<f64>,
    pub measured: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    pub truth: Vec<f64>,
}

pub fn swing(n: usize, end_s: f64) -> Swing {
    let t: Vec<f64> = (0..n).map(|i| end_s * i as f64 / n as f64).collect();
    let of = |decay: f64, f: f64| {
        t.iter().map(|t| (-decay * t).exp() * (std::f64::consts::TAU * f * t).cos()).collect::<Vec<f64>>()
    };
    let truth = of(0.05, 0.8);
    let measured =
        truth.iter().enumerate().map(|(i, y)| y + 0.02 * noise(i) + if i == n / 3 { 0.9 } else { 0.0 }).collect();
    Swing { before: of(0.02, 0.797), after: of(0.0502, 0.8), measured, truth, t }
}

fn residual(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn curve<'a>(label: &'a str, role: Role, x: &'a [f64], y: &'a [f64]) -> Curve<'a> {
    Curve { label, role, x, y }
}

pub fn overlay(n: usize) -> Figure {
    let s = swing(n, 55.0);
    let (low, high): (Vec<f64>, Vec<f64>) = s.after.iter().map(|y| (y - 0.08, y + 0.08)).unzip();
    let (e_before, e_after) = (residual(&s.measured, &s.before), residual(&s.measured, &s.after));
    Overlay {
        quantity: "angle",
        unit: "rad",
        curves: vec![
            curve("measured", Role::Measured, &s.t, &s.measured),
            curve("without friction, fit 43.9 %", Role::Before, &s.t, &s.before),
            curve("with joint_coulomb and drag, fit 92.2 %", Role::After, &s.t, &s.after),
            curve("truth", Role::Truth, &s.t, &s.truth),
        ],
        band: Some(Band { x: &s.t, low: &low, high: &high }),
        residual: vec![curve("", Role::Before, &s.t, &e_before), curve("", Role::After, &s.t, &e_after)],
        marks: vec![Mark { from: 17.0, to: 20.0, what: "spike at 18.3 s".into() }],
        marks_are: "where the two differ",
    }
    .draw(&format!("friction takes the residual from 0.31 to 0.02 rad rms ({n} samples)"))
    .caption("Held-out recording, free run.")
    .command("obsid diagnose swing.csv --plant pendulum.toml --out report")
}

pub fn spectrum() -> Figure {
    let f: Vec<f64> = (1..4000).map(|i| f64::from(i) * 0.0125).collect();
    let of = |peak: f64, q: f64| {
        f.iter()
            .enumerate()
            .map(|(i, f)| {
                peak / ((1.0 - (f / 8.0_f64).powi(2)).powi(2) + (f / 8.0 / q).powi(2)) * (1.0 + 0.2 * noise(i)).abs()
                    + 1e-6
            })
            .collect::<Vec<f64>>()
    };
    let (measured, before, after) = (of(1e-3, 60.0), of(1e-3, 8.0), of(1e-6, 1.0));
    Spectrum {
        quantity: "power density",
        unit: "(rad/s)^2/Hz",
        curves: vec![
            curve("measured", Role::Measured, &f, &measured),
            curve("residual before", Role::Before, &f, &before),
            curve("residual after", Role::After, &f, &after),
        ],
        bands: vec![Mark { from: 6.0, to: 11.0, what: "6 to 11 Hz".into() }],
        bands_are: "band of disagreement",
        noise: Some(1.1e-6),
    }
    .draw("the term removes 94 % of the residual's power at 8 Hz")
}

pub fn tiles() -> Figure {
    let map = |name, strength: f64| Tiles {
        name,
        time_s: (0.0, 80.0),
        frequency_hz: (10.0 / 128.0, 10.0),
        rows: (0..7)
            .map(|r| (0..60).map(|c| noise(r * 60 + c).abs() + if r == 4 && c > 20 { strength } else { 0.0 }).collect())
            .collect(),
    };
    TileMap {
        quantity: "residual above its noise",
        unit: "sigma",
        range: Some((0.0, 9.0)),
        maps: vec![
            map("angle, before", 6.0),
            map("angle, after", 0.0),
            map("a_channel_with_a_very_long_name_that_cannot_fit_in_half_of_the_page, before", 7.0),
            map("rate, after", 0.3),
        ],
        columns: 2,
    }
    .draw("what is missing acts between 0.6 and 1.3 Hz from 27 s on")
}

pub fn scatter() -> Figure {
    let v: Vec<f64> = (0..6000).map(|i| 1.5 * (0.01 * i as f64).sin()).collect();
    let law = |v: f64| 0.3 * (v / 0.02).tanh() + 0.05 * v;
    let force: Vec<f64> = v.iter().enumerate().map(|(i, v)| law(*v) + 0.04 * noise(i)).collect();
    let x: Vec<f64> = (0..400).map(|i| -1.6 + 0.008 * f64::from(i)).collect();
    let y: Vec<f64> = x.iter().map(|v| law(*v)).collect();
    let (low, high): (Vec<f64>, Vec<f64>) = y.iter().map(|y| (y - 0.02, y + 0.02)).unzip();
    Scatter {
        x: ("joint rate", "rad/s"),
        y: ("missing torque", "N*m"),
        curves: vec![
            curve("from the residual", Role::Measured, &v, &force),
            curve("joint_coulomb 0.300 ± 0.004 N m", Role::After, &x, &y),
        ],
        band: Some(Band { x: &x, low: &low, high: &high }),
    }
    .draw("the missing torque jumps by 0.6 N m where the joint turns back")
}

pub fn state_map() -> Figure {
    let rows: Vec<Vec<f64>> = (0..24)
        .map(|r| {
            (0..40)
                .map(|c| {
                    if (r as f64 - 12.0).hypot((c as f64 - 20.0) * 0.6) > 11.5 {
                        f64::NAN
                    } else {
                        (r as f64 - 11.5).signum() * 0.3 + 0.01 * (c as f64 - 20.0)
                    }
                })
                .collect()
        })
        .collect();
    let (x, y): (Vec<f64>, Vec<f64>) =
        (0..300).map(|i| (0.8 * (0.1 * f64::from(i)).sin(), 1.4 * (0.1 * f64::from(i)).cos())).unzip();
    StateMap {
        x: ("angle", "rad"),
        x_range: (-1.0, 1.0),
        y: ("rate", "rad/s"),
        y_range: (-1.6, 1.6),
        force: ("missing torque", "N*m"),
        range: Some((-0.5, 0.5)),
        rows,
        visited: (&x, &y),
    }
    .draw("the force depends on the sign of the rate, not on the angle")
}

pub fn matrix() -> Figure {
    let names = [
        "joint_coulomb@joint:pivot",
        "joint_viscous@joint:pivot",
        "joint_quadratic_damping@joint:pivot",
        "joint_asymmetric_friction@joint:shoulder_of_the_left_manipulator_arm",
        "sensor_bias@sensor:angle",
    ];
    let values = (0..5)
        .map(|i| (0..5).map(|j| if i == j { 0.0 } else { 90.0 / (1.0 + f64::from(i - j).abs()) }).collect())
        .collect();
    Matrix {
        quantity: "angle between effects",
        unit: "deg",
        rows: names.map(String::from).to_vec(),
        columns: Vec::new(),
        values,
        range: Some((0.0, 90.0)),
    }
    .draw("Coulomb and viscous friction are 45 degrees apart on these data")
}

pub fn bars() -> Figure {
    let bar = |label: &str, value: f64, half: f64, role, note: &str| Bar {
        label: label.into(),
        value,
        interval: (value - half, value + half),
        role,
        note: note.into(),
    };
    Bars {
        quantity: "log-likelihood gain on held-out data",
        unit: "-",
        bars: vec![
            bar("joint_coulomb@joint:pivot", 184.0, 22.0, Role::After, "confirmed"),
            bar("drag@body:bar", 31.0, 14.0, Role::After, "confirmed"),
            bar(
                "joint_asymmetric_friction@joint:shoulder_of_the_left_manipulator_arm",
                2.0,
                6.0,
                Role::Before,
                "unconfirmed: 340 s would decide",
            ),
            bar("joint_viscous@joint:pivot", f64::NAN, 0.0, Role::Before, "not converged"),
        ],
        reference: Some(10.0),
        from_zero: true,
    }
    .draw("two terms are confirmed on data that were not used to fit them")
}

pub fn cumulative() -> Figure {
    let t: Vec<f64> = (0..2000).map(|i| 0.04 * f64::from(i)).collect();
    let of = |slope: f64, seed: usize| {
        let mut sum = 0.0;
        (0..t.len())
            .map(|i| {
                sum += slope + 0.3 * noise(seed + i);
                sum
            })
            .collect::<Vec<f64>>()
    };
    let (named, rival) = (of(0.06, 0), of(0.02, 5000));
    Cumulative {
        quantity: "evidence",
        unit: "nat",
        curves: vec![curve("joint_coulomb", Role::After, &t, &named), curve("joint_viscous", Role::Rival, &t, &rival)],
        threshold: Some(15.0),
        marks: Vec::new(),
        marks_are: "",
    }
    .draw("the evidence grows evenly: it is no single event")
}

pub fn stabilisation() -> Figure {
    let mut poles = Vec::new();
    for order in 1..40_u32 {
        for (k, f) in [3.1, 7.7, 12.4].into_iter().enumerate() {
            if order as usize > 4 * (k + 1) {
                poles.push(Pole {
                    order: f64::from(order * 2),
                    frequency_hz: f + 0.01 * noise(order as usize),
                    stability: Stability::All,
                });
            }
        }
        poles.push(Pole {
            order: f64::from(order * 2),
            frequency_hz: 8.0 + 2.5 * noise(order as usize + 100),
            stability: [Stability::New, Stability::Frequency, Stability::FrequencyAndDamping][order as usize % 3],
        });
    }
    let f: Vec<f64> = (1..1500).map(|i| 0.01 * f64::from(i)).collect();
    let p: Vec<f64> =
        f.iter().map(|f| [3.1, 7.7, 12.4].iter().map(|m| 1.0 / ((f - m).powi(2) + 0.001)).sum()).collect();
    Stabilisation { poles, spectrum: Some(curve("spectrum", Role::Before, &f, &p)), chosen_hz: vec![3.1, 7.7, 12.4] }
        .draw("three modes stay as the order grows")
}

pub fn clusters() -> Figure {
    let f: Vec<f64> = (0..90).map(|i| [3.1, 7.7, 12.4][i % 3] + 0.05 * noise(i)).collect();
    let z: Vec<f64> = (0..90).map(|i| [0.01, 0.004, 0.02][i % 3] + 0.001 * noise(i + 500)).collect();
    let mode = |name: &str, f: f64, z: f64| Mode {
        name: name.into(),
        frequency_hz: f,
        frequency_sigma_hz: 0.05,
        damping_ratio: z,
        damping_sigma: 0.001,
    };
    Clusters {
        pole_frequency_hz: &f,
        pole_damping_ratio: &z,
        modes: vec![mode("1", 3.1, 0.01), mode("2", 7.7, 0.004), mode("3", 12.4, 0.02)],
    }
    .draw("three modes, damped by 0.4 to 2 %")
}

pub fn figures() -> Vec<Figure> {
    vec![
        overlay(25_000),
        overlay(120),
        spectrum(),
        tiles(),
        scatter(),
        state_map(),
        matrix(),
        bars(),
        cumulative(),
        stabilisation(),
        clusters(),
    ]
}

/// The same figures without anything to show.
pub fn empty_figures() -> Vec<Figure> {
    let nothing = [f64::NAN, f64::INFINITY];
    let c = |role| curve("nothing", role, &nothing, &nothing);
    vec![
        Overlay {
            quantity: "angle",
            unit: "rad",
            curves: vec![c(Role::Measured)],
            residual: vec![c(Role::After)],
            ..Overlay::default()
        }
        .draw("a"),
        Overlay::default().draw("b"),
        Spectrum { curves: vec![c(Role::After)], ..Spectrum::default() }.draw("c"),
        TileMap::default().draw("d"),
        TileMap {
            maps: vec![Tiles { name: "x", time_s: (0.0, 1.0), frequency_hz: (0.0, 0.0), rows: vec![vec![f64::NAN]] }],
            ..TileMap::default()
        }
        .draw("e"),
        Scatter { curves: vec![c(Role::Measured)], ..Scatter::default() }.draw("f"),
        StateMap::default().draw("g"),
        Matrix { rows: vec!["one".into()], values: vec![vec![f64::NAN]], ..Matrix::default() }.draw("h"),
        Bars::default().draw("i"),
        Cumulative { curves: vec![c(Role::After)], ..Cumulative::default() }.draw("j"),
        Stabilisation::default().draw("k"),
        Clusters::default().draw("l"),
    ]
}

pub fn table() -> Table {
    let mut table = Table::new("Parameters", &["parameter", "before", "after", "shift [sigma]", "unit", "remark"]);
    table.row(vec![
        "bar.mass".into(),
        Cell::Number(1.35),
        Cell::Estimate(1.3512, 0.0021),
        Cell::Number(0.6),
        "kg".into(),
        Cell::Prose("known".into()),
    ]);
    table.row(vec![
        "pivot.friction".into(),
        Cell::Number(1.5e-3),
        Cell::Estimate(1.21e-3, 3.4e-4),
        Cell::Number(-0.4),
        "N*m*s/rad".into(),
        Cell::Severity("note".into()),
    ]);
    table.row(vec!["tank <1> & more".into(), Cell::None, Cell::Estimate(1004.2, 12.0), Cell::Number(f64::NAN), "kg".into(), Cell::Prose("it was not estimated, since nothing in these data depends on it, and a long sentence has to wrap somewhere".into())]);
    table
}

pub fn page() -> Page {
    let mut blocks: Vec<Block> = figures().into_iter().map(Block::Figure).collect();
    blocks.push(Block::Figure(empty_figures().remove(0)));
    Page {
        title: "single_free_swing.csv.gz: what is missing is Coulomb friction in the pivot".into(),
        verdict: "Named: joint_coulomb@joint:pivot, 0.300 ± 0.004 N m (probability 0.98). It takes the fit on held-out data from 43.9 to 92.2 %.".into(),
        sections: vec![
            Section::new("Numbers", vec![
                Block::Table(table()),
                Block::Text("A paragraph with \"quotes\", <brackets> & an ampersand.".into()),
                Block::List(vec!["first".into(), "second".into()]),
                Block::Command("obsid simulate augmented.toml --out again.csv".into()),
                Block::Details { summary: "What else was tried".into(), blocks: vec![Block::Text("Nothing.".into()), Block::Table(table())] },
            ]),
            Section::new("Figures", blocks),
        ],
        command: "obsid diagnose swing.csv --plant 'pendulum one.toml' --out report".into(),
        digests: vec![("swing.csv".into(), "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262".into())],
        tool: "obsid 0.1.0".into(),
    }
}
