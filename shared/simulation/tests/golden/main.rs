//! Plants against numbers that independent engines computed: `tests/golden/*.json`, made by
//! `tests/peers/run dynamics --write`.
//!
//! The plants are written down from the numbers in the documents, so that nothing but the documents
//! states the mechanics. Trees of rigid bodies against Pinocchio and MuJoCo are in
//! `multibody::tests::golden`.

mod appendage;
mod planar_tank;

use dynamics::description::{InitialValue, Plant, Quantity};
use serde_json::Value;

/// A plant from the text of its file.
fn plant(text: &str) -> Plant {
    plant_file::parse("golden", text).unwrap_or_else(|errors| panic!("{errors:?}\n{text}")).plant
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn initial(coordinate: &str, position: f64, rate: f64) -> InitialValue {
    InitialValue { coordinate: coordinate.to_owned(), position: Quantity::known(position), rate: Quantity::known(rate) }
}

/// Demands that `found` is `expected` to `tolerance` of the largest value over the record.
fn agree(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let size = expected.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    let worst = found.iter().zip(expected).fold(0.0f64, |worst, (a, b)| worst.max((a - b).abs()));
    println!("{what}: {:.1e}", worst / size);
    assert!(found.len() == expected.len() && size > 0.0);
    assert!(worst <= tolerance * size, "{what}: {:.3e} > {tolerance:.1e}", worst / size);
}
