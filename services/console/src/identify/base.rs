//! Base parameters of a planar craft with the sigmas of the joint posterior.

use dynamics::description::BaseValue;
use identification::joint::{JointFit, Vehicle};
use nalgebra::{DMatrix, DVector};

/// A base parameter.
pub struct BaseRow {
    pub name: String,
    pub unit: &'static str,
    pub value: f64,
    pub sigma: f64,
    pub prior: f64,
    pub prior_sigma: f64,
}

/// Step of the differences [standard deviations]: base parameters are products of few numbers.
const STEP_SIGMAS: f64 = 1e-3;

/// Those of the first arc's plant; of later ones, whose bodies are others (a target is grasped),
/// those that differ, with the arc's name.
pub fn rows(vehicle: &Vehicle<'_>, fit: &JointFit) -> Vec<BaseRow> {
    let Some(covariance) = fit.knowledge.covariance() else { return Vec::new() };
    let bodies =
        |arc: usize| vehicle.arcs[arc].problem.plant.bodies.iter().map(|body| body.name.as_str()).collect::<Vec<_>>();
    let mut rows = of_arc(vehicle, fit, &covariance, 0);
    let first = rows.len();
    let mut seen = vec![bodies(0)];
    for arc in 1..vehicle.arcs.len() {
        if seen.contains(&bodies(arc)) {
            continue;
        }
        seen.push(bodies(arc));
        let others = of_arc(vehicle, fit, &covariance, arc);
        let changed = others
            .into_iter()
            .filter(|row| !rows[..first].iter().any(|known| known.name == row.name && same(known.value, row.value)));
        let changed: Vec<BaseRow> = changed.collect();
        rows.extend(
            changed.into_iter().map(|row| BaseRow { name: format!("{}@{}", row.name, vehicle.arcs[arc].name), ..row }),
        );
    }
    rows
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}

fn of_arc(vehicle: &Vehicle<'_>, fit: &JointFit, covariance: &DMatrix<f64>, arc: usize) -> Vec<BaseRow> {
    let problem = &vehicle.arcs[arc].problem;
    let values = |theta: &[f64]| -> Vec<BaseValue> {
        problem.instance(&problem.plant, &vehicle.of_arc(arc, theta), 0).planar_base_values()
    };
    let sigma: Vec<f64> = vehicle.unknowns.iter().map(|unknown| unknown.sigma).collect();
    propagated(&values, [&fit.theta, &vehicle.prior()], &sigma, covariance).0
}

/// First-order propagation, `J Σ J'` with J by central differences: of `values` at the estimate
/// with its covariance (per prior standard deviations `sigma`), and at the priors with theirs. With
/// the rows, their covariance at the estimate.
pub fn propagated(
    values: &dyn Fn(&[f64]) -> Vec<BaseValue>,
    [theta, prior]: [&[f64]; 2],
    sigma: &[f64],
    covariance: &DMatrix<f64>,
) -> (Vec<BaseRow>, DMatrix<f64>) {
    let (found, priors) = (values(theta), values(prior));
    let slopes = |center: &[f64]| {
        let column = |k: usize| {
            let moved = |sign: f64| {
                let mut theta = center.to_vec();
                theta[k] += sign * STEP_SIGMAS * sigma[k];
                DVector::from_iterator(found.len(), values(&theta).iter().map(|base| base.value))
            };
            // per prior standard deviation
            (moved(1.0) - moved(-1.0)) / (2.0 * STEP_SIGMAS)
        };
        let columns: Vec<DVector<f64>> = (0..sigma.len()).map(column).collect();
        DMatrix::from_columns(&columns)
    };
    if found.is_empty() {
        return (Vec::new(), DMatrix::zeros(0, 0));
    }
    let (at_fit, at_prior) = (slopes(theta), slopes(prior));
    let posterior = &at_fit * covariance * at_fit.transpose();
    let of_priors = &at_prior * at_prior.transpose();
    let row = |(i, (base, prior_value)): (usize, (&BaseValue, &BaseValue))| BaseRow {
        name: base.name.clone(),
        unit: base.unit,
        value: base.value,
        sigma: libm::sqrt(posterior[(i, i)].max(0.0)),
        prior: prior_value.value,
        prior_sigma: libm::sqrt(of_priors[(i, i)].max(0.0)),
    };
    (found.iter().zip(&priors).enumerate().map(row).collect(), posterior)
}
