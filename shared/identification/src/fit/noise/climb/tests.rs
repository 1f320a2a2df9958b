use super::*;
use crate::fit::fit;
use crate::fit::noise::one_by_one;
use crate::problem::Problem;
use crate::synthetic::{coloured, of_higher_variance, plant, problem, recording};

const SEARCH: Search = Search { sweeps: 8, colour: true, scan: true };

/// Every coordinate of the noise, as both searches begin.
fn coordinates(noise: &NoiseModel) -> Vec<Coordinate> {
    let channels = 0..noise.sensor_sigma.len();
    let sizes = channels.clone().map(Coordinate::Sensor).chain((0..noise.input_sigma.len()).map(Coordinate::Input));
    sizes.chain(channels.map(Coordinate::Pole)).collect()
}

/// `−2 ln p` where coordinate by coordinate ends, and where the gradient does, with its noise.
fn both(problem: &Problem) -> (f64, f64, NoiseModel) {
    let session = EstimationSession::new(problem, 1).unwrap();
    let fitted = fit(&session, &problem.plant, &session.prior(), &session.noise, 4).unwrap();
    let value = |noise: &NoiseModel| {
        let normal = fitted.linearised.normal(&session, &fitted.theta, noise, &[])?;
        Some(normal.minimum()?.0 + session.disturbance_price(noise))
    };
    let start = (&session.noise, value(&session.noise).unwrap());
    let size = fitted.linearised.linears[0].layout.len();
    let (_, one_by_one) = one_by_one(&session, size, start, coordinates(&session.noise), SEARCH, &value);
    let at = ((&session, &fitted.linearised), (&fitted.theta[..], &[][..]));
    let (noise, at_once) = climbed(at.0, at.1, &session.noise, coordinates(&session.noise), SEARCH).unwrap();
    (one_by_one, at_once, noise)
}

#[test]
fn the_gradient_leads_as_low_as_coordinate_by_coordinate() {
    for (name, duration_s) in [("oscillator", 4.0), ("drive_rig", 2.0), ("double_pendulum", 4.0)] {
        for factor in [1.0, 2.5] {
            let nominal = plant(name);
            let problem = problem(&nominal, recording(&of_higher_variance(&nominal, factor), 7, duration_s));
            let (one_by_one, at_once, noise) = both(&problem);
            // poles that are not worth their price are none here
            let poles = noise.pole.iter().filter(|pole| **pole == 0.0).count() as f64;
            assert!(at_once < one_by_one + 0.3 + POLE_PRICE * poles, "{name} {factor}: {one_by_one} {at_once}");
            let own = EstimationSession::new(&problem, 1).unwrap();
            for (found, stated) in noise.sensor_sigma.iter().zip(&own.noise.sensor_sigma) {
                // hundreds of samples
                assert!((0.8..1.25).contains(&(found / (factor * stated))), "{name} {factor}: {found} {stated}");
            }
        }
    }
}

#[test]
fn a_start_ten_times_too_loud_or_too_quiet_ends_in_the_same() {
    let nominal = plant("drive_rig");
    let problem = problem(&nominal, recording(&nominal, 7, 2.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let fitted = fit(&session, &nominal, &session.prior(), &session.noise, 4).unwrap();
    let end = |factor: f64| {
        let at = ((&session, &fitted.linearised), (&fitted.theta[..], &[][..]));
        climbed(at.0, at.1, &session.noise.scaled(factor), coordinates(&session.noise), SEARCH).unwrap().1
    };
    let [quiet, stated, loud] = [0.1, 1.0, 10.0].map(end);
    // both channels may keep a pole or not
    let most = 0.3 + 2.0 * POLE_PRICE;
    assert!((quiet - stated).abs() < most && (loud - stated).abs() < most, "{quiet} {stated} {loud}");
}

#[test]
fn coloured_noise_gets_its_pole_and_white_noise_none() {
    let nominal = plant("oscillator");
    let (_, _, white) = both(&problem(&nominal, recording(&nominal, 5, 3.0)));
    assert!(white.pole.iter().all(|pole| pole.abs() < 0.15), "{white:?}");
    let (one_by_one, at_once, found) = both(&problem(&nominal, coloured(&nominal, 5, 3.0, 0.7)));
    assert!(found.pole.iter().all(|pole| (0.6..0.8).contains(pole)), "{found:?}");
    assert!(at_once < one_by_one + 0.3, "{one_by_one} {at_once}");
}
