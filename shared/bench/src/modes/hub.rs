//! What the hub-free modes say of the parts: modes with the hub held fast, and the inertia of the
//! hub.
//!
//! [`physics::appendage::parts`] over records of the campaign: errors, and whether they are what is
//! claimed.

use super::Modes;
use crate::campaign::Campaign;
use modal::maximum_likelihood::{self as ml, Fit, Model};
use nalgebra::{Matrix4, Vector4};
use physics::appendage::Appendage;
use physics::appendage::parts::Parts;

/// Records of a campaign that are worked on here: an RMSE is then known to 5 %.
const RECORDS_MAX: usize = 200;
const NAMES: [&str; 4] = ["locked f1 [Hz]", "locked zeta1 [-]", "locked zeta2 [-]", "inertia [kg m^2]"];

fn of_fit(nominal: &Appendage, fit: &Fit) -> Option<(Parts, Matrix4<f64>)> {
    let modes = Vector4::from_fn(|p, _| if p % 2 == 0 { fit.frequency_hz(p / 2) } else { fit.damping_ratio(p / 2) });
    nominal.parts(&modes, &Matrix4::from_fn(|r, c| fit.covariance[4 * r + c]))
}

/// One part over some records.
pub(super) struct Part {
    name: &'static str,
    truth: f64,
    rmse_percent: f64,
    /// Root mean square of what was claimed.
    sd_percent: f64,
    coverage95: f64,
}

/// Error and honesty of the parts over the first records of a campaign.
fn statistics(benchmark: &Modes, seed: u64, records: usize) -> Option<Vec<Part>> {
    let nominal = benchmark.nominal()?;
    let [a, b] = nominal.locked;
    let truth = Vector4::new(a.frequency_hz, a.damping_ratio, b.damping_ratio, nominal.inertia_kg_m2);
    // What is solved for must not lean on the nominal model.
    let assumed = nominal.with_parts(&truth.component_mul(&Vector4::new(1.01, 1.3, 0.8, 0.97)));
    let (mut squares, mut held, mut claimed) = (Parts::zeros(), Parts::zeros(), Parts::zeros());
    for k in 0..records {
        let record = benchmark.record(seed, k);
        let fit = ml::fit(&record, Model::FORCED, &ml::start(&record, 2).ok()?).ok()?;
        let (found, covariance) = of_fit(&assumed, &fit)?;
        for p in 0..4 {
            let error = found[p] - truth[p];
            squares[p] += error * error;
            claimed[p] += covariance[(p, p)];
            held[p] += f64::from(u8::from(error.abs() < 1.96 * covariance[(p, p)].sqrt()));
        }
    }
    let n = records as f64;
    let part = |p: usize| {
        let percent = |sum: f64| 100.0 * (sum / n).sqrt() / truth[p];
        Part {
            name: NAMES[p],
            truth: truth[p],
            rmse_percent: percent(squares[p]),
            sd_percent: percent(claimed[p]),
            coverage95: held[p] / n,
        }
    };
    Some((0..4).map(part).collect())
}

/// Said under the table of the campaign.
pub(super) fn remark(benchmark: &Modes, campaign: &Campaign) -> Option<String> {
    let records = campaign.trials.min(RECORDS_MAX);
    let row = |part: &Part| {
        let Part { name, truth, rmse_percent, sd_percent, coverage95 } = part;
        format!("{name} {truth:.6}: RMSE {rmse_percent:.5} %, sd {sd_percent:.5} %, cover 95 {coverage95:.3}")
    };
    let rows: Vec<String> = statistics(benchmark, campaign.seed, records)?.iter().map(row).collect();
    let head = format!("Hub-locked modes and the inertia, from the hub-free modes of ml ({records} records):");
    Some(format!("{head}\n  {}", rows.join("\n  ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_scatter_as_much_as_they_claim() {
        const RECORDS: usize = 40;
        let parts = statistics(&Modes::bp3a(), 7, RECORDS).unwrap();
        for Part { name, rmse_percent, sd_percent, coverage95, .. } in &parts {
            // An RMSE of 40 records spreads by 11 %, a coverage by 3.4 %: three of each.
            assert!((rmse_percent / sd_percent - 1.0).abs() < 0.34, "{name}: {rmse_percent} of {sd_percent}");
            assert!(*coverage95 > 0.85, "{name}: {coverage95}");
        }
        // Asked of the locked frequency from a fit of all samples: 0.0005 %. The modes alone keep
        // most of that.
        assert!(parts[0].sd_percent < 0.002, "{}", parts[0].sd_percent);
    }
}
