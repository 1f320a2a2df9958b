//! What the hub-free modes say of the parts: modes with the hub held fast, and the inertia of the hub.
//!
//! Four numbers are measured (frequency and damping of two hub-free modes); a uniform beam clamped to a hub has four unknowns (one
//! stiffness for both locked frequencies, two damping ratios, the inertia), so the map is solved by Newton and the covariance carried
//! through its slope. Coupling and the ratio of the locked frequencies are those of the beam's geometry.

use super::Modes;
use crate::bench::campaign::Campaign;
use modal::maximum_likelihood::{self as ml, Fit, Model};
use nalgebra::{Matrix4, Vector4};
use physics::appendage::Appendage;

/// Records of a campaign that are worked on here: an RMSE is then known to 5 %.
const RECORDS_MAX: usize = 200;
const ITERATIONS_MAX: usize = 30;
const NAMES: [&str; 4] = ["locked f1 [Hz]", "locked zeta1 [-]", "locked zeta2 [-]", "inertia [kg m^2]"];

/// Locked frequency of the first mode, locked damping ratios, inertia of hub and beam.
type Parts = Vector4<f64>;

fn appendage(nominal: &Appendage, parts: &Parts) -> Appendage {
    let mut appendage = *nominal;
    let stiffer = parts[0] / nominal.locked[0].frequency_hz;
    for (mode, zeta) in appendage.locked.iter_mut().zip([parts[1], parts[2]]) {
        mode.frequency_hz *= stiffer;
        mode.damping_ratio = zeta;
    }
    appendage.inertia_kg_m2 = parts[3];
    appendage
}

/// f1, zeta1, f2, zeta2 with the hub free.
fn free(nominal: &Appendage, parts: &Parts) -> Option<Vector4<f64>> {
    let [a, b] = appendage(nominal, parts).hub_free_modes()?;
    Some(Vector4::new(a.frequency_hz, a.damping_ratio, b.frequency_hz, b.damping_ratio))
}

fn slope(nominal: &Appendage, parts: &Parts) -> Option<Matrix4<f64>> {
    let mut slope = Matrix4::zeros();
    for k in 0..4 {
        let step = 1e-5 * parts[k];
        let mut moved = [*parts, *parts];
        moved[0][k] += step;
        moved[1][k] -= step;
        slope.set_column(k, &((free(nominal, &moved[0])? - free(nominal, &moved[1])?) / (2.0 * step)));
    }
    Some(slope)
}

/// The parts that have these hub-free modes, and their covariance.
pub(super) fn parts(nominal: &Appendage, modes: &Vector4<f64>, covariance: &Matrix4<f64>) -> Option<(Parts, Matrix4<f64>)> {
    let [a, b] = nominal.locked;
    let mut parts = Vector4::new(a.frequency_hz, a.damping_ratio, b.damping_ratio, nominal.inertia_kg_m2);
    for _ in 0..ITERATIONS_MAX {
        let inverse = slope(nominal, &parts)?.try_inverse()?;
        let step = inverse * (modes - free(nominal, &parts)?);
        parts += step;
        if step.component_div(&parts).amax() < 1e-10 {
            return Some((parts, inverse * covariance * inverse.transpose()));
        }
    }
    None
}

fn of_fit(nominal: &Appendage, fit: &Fit) -> Option<(Parts, Matrix4<f64>)> {
    let modes = Vector4::from_fn(|p, _| if p % 2 == 0 { fit.frequency_hz(p / 2) } else { fit.damping_ratio(p / 2) });
    parts(nominal, &modes, &Matrix4::from_fn(|r, c| fit.covariance[4 * r + c]))
}

/// Error and honesty of the parts over the records of a campaign.
pub(super) fn remark(benchmark: &Modes, campaign: &Campaign) -> Option<String> {
    let nominal = benchmark.nominal()?;
    let truth = Vector4::new(
        nominal.locked[0].frequency_hz,
        nominal.locked[0].damping_ratio,
        nominal.locked[1].damping_ratio,
        nominal.inertia_kg_m2,
    );
    let (mut squares, mut held, mut claimed) = (Vector4::zeros(), Vector4::zeros(), Vector4::zeros());
    let records = campaign.trials.min(RECORDS_MAX);
    // The nominal model is a per cent or more off: what is solved for must not lean on it.
    let assumed = appendage(&nominal, &truth.component_mul(&Vector4::new(1.01, 1.3, 0.8, 0.97)));
    for k in 0..records {
        let record = benchmark.record(campaign.seed, k);
        let fit = ml::fit(&record, Model::FORCED, &ml::start(&record, 2).ok()?).ok()?;
        let (found, covariance) = of_fit(&assumed, &fit)?;
        let error = found - truth;
        for p in 0..4 {
            let sigma = covariance[(p, p)].sqrt();
            squares[p] += error[p] * error[p];
            claimed[p] += sigma * sigma;
            held[p] += f64::from(u8::from(error[p].abs() < 1.96 * sigma));
        }
    }
    let n = records as f64;
    let row = |p: usize| {
        let percent = |sum: f64| 100.0 * (sum / n).sqrt() / truth[p];
        let (rmse, sigma) = (percent(squares[p]), percent(claimed[p]));
        format!("{} {:.6}: RMSE {rmse:.5} %, sd {sigma:.5} %, cover 95 {:.3}", NAMES[p], truth[p], held[p] / n)
    };
    let rows: Vec<String> = (0..4).map(row).collect();
    Some(format!("Hub held fast and its inertia, from the hub-free modes of ml ({records} records):\n  {}", rows.join("\n  ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_come_back_from_the_modes_of_the_whole() {
        let nominal = Modes::bp3a().nominal().unwrap();
        let truth = Vector4::new(1.07, 0.011, 0.004, 150.0);
        let modes = free(&nominal, &truth).unwrap();
        let found = parts(&nominal, &modes, &Matrix4::identity()).unwrap().0;
        assert!((found - truth).component_div(&truth).amax() < 1e-9, "{found} {truth}"); // Newton ends within 1e-10
    }
}
