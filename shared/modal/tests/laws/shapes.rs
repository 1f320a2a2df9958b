//! Shapes over seeds: their stated deviations are standard deviations, of one record and of several
//! setups that share reference sensors.

use crate::cases::noise::Noise;
use modal::gram::output_gram;
use modal::record::Record;
use modal::setups::{Setup, SetupMode, merge, pre_scaled};
use modal::{Config, ModalIdentifier, Mode, SelectionSettings, ShapeScale, StabilityCriteria, c64};

/// Frequency over the sample rate, damping, and a component at every sensor of the structure.
struct Truth {
    modes: Vec<(f64, f64, Vec<f64>)>,
}

/// Two or three modes between 0.03 and 0.3 of the rate, apart by a fifth, damping 0.8 to 3 %.
fn structure(noise: &mut Noise, sensors: usize) -> Truth {
    let count = 2 + usize::from(noise.uniform() < 0.5);
    let mut frequency = noise.between(0.03, 0.06);
    let modes = (0..count).map(|_| {
        let f = frequency;
        frequency *= noise.between(1.4, 2.2);
        let mut component = || noise.between(0.3, 1.0) * if noise.uniform() < 0.5 { -1.0 } else { 1.0 };
        let shape = (0..sensors).map(|_| component()).collect();
        (f, noise.between(0.008, 0.03), shape)
    });
    Truth { modes: modes.collect() }
}

/// Ambient motion at some of the sensors, sensor noise of 2 % of the rms.
fn ambient(truth: &Truth, sensors: &[usize], samples: usize, gain: f64, noise: &mut Noise) -> Record {
    let mut outputs = vec![0.0; samples * sensors.len()];
    for (f, zeta, shape) in &truth.modes {
        let omega = 2.0 * std::f64::consts::PI * f;
        let rho = libm::exp(-zeta * omega);
        let (a_1, a_2) = (2.0 * rho * libm::cos(omega * (1.0 - zeta * zeta).sqrt()), -rho * rho);
        // Unit variance of an oscillation driven by white noise, up to its damping.
        let size = (4.0 * zeta * omega).sqrt() * libm::sin(omega);
        let (mut y_1, mut y_2) = (0.0, 0.0);
        let warm_up = (8.0 / (zeta * omega)) as usize;
        for t in 0..warm_up + samples {
            let y = a_1 * y_1 + a_2 * y_2 + size * noise.normal();
            (y_2, y_1) = (y_1, y);
            if t >= warm_up {
                let row = &mut outputs[(t - warm_up) * sensors.len()..][..sensors.len()];
                row.iter_mut().zip(sensors).for_each(|(out, sensor)| *out += gain * shape[*sensor] * y);
            }
        }
    }
    outputs.iter_mut().for_each(|y| *y += 0.02 * gain * noise.normal());
    Record::of_outputs(1.0, sensors.len(), outputs)
}

fn identified(record: &Record, scale: ShapeScale) -> Vec<Mode> {
    let selection = SelectionSettings { shape_deviations: Some(scale), ..SelectionSettings::default() };
    let config = Config { halvings: 1, block_rows: 20, selection, ..Config::new(record.channels, 1.0) };
    let mut identifier = ModalIdentifier::new(config);
    record.outputs.chunks_exact(record.channels).for_each(|row| identifier.push(row));
    identifier.identify().expect("modes")
}

/// Squared errors over variances, one after the other.
fn squares(shape: &[c64], deviation: &[c64], truth: &[f64]) -> Vec<f64> {
    let parts = |x: c64, sigma: c64, true_x: f64| [((x.re - true_x) / sigma.re), (x.im / sigma.im)];
    let all = shape.iter().zip(deviation).zip(truth);
    let z = all.filter(|((_, sigma), _)| sigma.norm_sqr() > 0.0).flat_map(|((x, sigma), t)| parts(*x, *sigma, *t));
    z.map(|z| z * z).collect()
}

fn root_mean(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// The true shape over some sensors, component `unit` of them 1.
fn true_shape(truth: &Truth, frequency_hz: f64, sensors: &[usize], unit: usize) -> Vec<f64> {
    let near = |mode: &&(f64, f64, Vec<f64>)| ((mode.0 - frequency_hz).abs() * 1e9) as u64;
    let shape = &truth.modes.iter().min_by_key(near).expect("there are modes").2;
    sensors.iter().map(|sensor| shape[*sensor] / shape[sensors[unit]]).collect()
}

fn unit_of(shape: &[c64]) -> usize {
    (0..shape.len()).max_by(|a, b| shape[*a].norm_sqr().total_cmp(&shape[*b].norm_sqr())).expect("channels")
}

#[test]
fn deviations_of_shape_components_are_standard_deviations_on_ambient_records() {
    let mut all = Vec::new();
    for seed in 0..30 {
        let mut noise = Noise::new(7100 + seed);
        let sensors: Vec<usize> = (0..3 + (seed % 4) as usize).collect();
        let truth = structure(&mut noise, sensors.len());
        let record = ambient(&truth, &sensors, 8000, 1.0, &mut noise);
        for mode in identified(&record, ShapeScale::Largest) {
            let unit = unit_of(&mode.mode_shape);
            let truth = true_shape(&truth, mode.frequency_hz, &sensors, unit);
            assert_eq!(mode.shape_deviation[unit].norm_sqr(), 0.0, "the component that holds the scale");
            all.extend(squares(&mode.mode_shape, &mode.shape_deviation, &truth));
        }
    }
    let rms = root_mean(&all);
    println!("rms z {rms:.3} of {} parts", all.len());
    // Some 400 parts of 75 modes: the rms of independent ones scatters by 4 %.
    assert!((0.8..1.25).contains(&rms), "rms z {rms} of {} parts", all.len());
}

#[test]
fn three_setups_with_two_references_give_the_shape_of_the_whole_within_its_deviations() {
    let mut all = Vec::new();
    let mut worst: f64 = 1.0;
    for seed in 0..12 {
        let mut noise = Noise::new(8200 + seed);
        let truth = structure(&mut noise, 8);
        let places = [[0, 1, 2, 3], [0, 1, 4, 5], [0, 1, 6, 7]];
        // The excitation changes between setups.
        let records: Vec<Record> =
            places.iter().zip([1.0, 0.3, 2.5]).map(|(of, gain)| ambient(&truth, of, 8000, gain, &mut noise)).collect();
        let setup = |(record, of): (&Record, &[usize; 4])| Setup {
            channels: of.iter().map(|sensor| sensor.to_string()).collect(),
            modes: identified(record, ShapeScale::FirstChannels(2)).iter().map(of_setup).collect(),
        };
        let merged = merge(&records.iter().zip(&places).map(setup).collect::<Vec<_>>(), 2);
        let order: Vec<usize> = merged.channels.iter().map(|name| name.parse().expect("a number")).collect();
        for mode in merged.modes.iter().filter(|mode| mode.found_in.iter().all(Option::is_some)) {
            assert!(mode.references_agree(), "{mode:?}");
            // The scale is that of the references: compare at the true one of them.
            let unit = unit_of(&mode.shape);
            let truth = true_shape(&truth, mode.frequency_hz, &order, unit);
            let scale = along(&mode.shape, &truth, 2);
            let shape: Vec<c64> = mode.shape.iter().map(|psi| *psi / scale).collect();
            all.extend(squares(&shape, &mode.shape_deviation, &truth));
        }
        let grams: Vec<_> = records.iter().map(|record| output_gram(record, 20)).collect();
        let poles = pre_scaled(&grams, 2, 20, 1.0, &StabilityCriteria::default()).unwrap();
        for (f, _, shape) in &truth.modes {
            let pole = poles.iter().min_by(|a, b| (a.frequency_hz - f).abs().total_cmp(&(b.frequency_hz - f).abs()));
            let shape: Vec<c64> = order.iter().map(|sensor| c64::new(shape[*sensor], 0.0)).collect();
            let mac = pole.map_or(0.0, |pole| modal::mac::modal_assurance_criterion(&pole.mode_shape, &shape));
            worst = worst.min(mac);
        }
    }
    let rms = root_mean(&all);
    println!("rms z {rms:.3} of {} parts; worst MAC scaled before {worst:.4}", all.len());
    assert!((0.8..1.25).contains(&rms), "rms z {rms} of {} parts", all.len());
    assert!(worst > 0.98, "worst MAC of one identification {worst}");
}

/// Least-squares amplitude of a shape along the true one over the first channels.
fn along(shape: &[c64], truth: &[f64], count: usize) -> c64 {
    let power: f64 = truth[..count].iter().map(|x| x * x).sum();
    shape[..count].iter().zip(truth).fold(c64::new(0.0, 0.0), |sum, (psi, x)| sum + *psi * *x) / power
}

fn of_setup(mode: &Mode) -> SetupMode {
    SetupMode {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        sigma_frequency_hz: mode.sigma_frequency_hz,
        sigma_damping: mode.sigma_damping,
        shape: mode.mode_shape.clone(),
        shape_deviation: mode.shape_deviation.clone(),
    }
}
