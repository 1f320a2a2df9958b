//! What a design is shown as: a table beside trajectory B, and a plant file.

use super::{Designed, HARMONICS};
use crate::experiment_design::{Assessment, Design};
use crate::plants;
use std::fmt::Write;

/// Bounds and peaks of `found` beside those of the reference, for a reader.
pub fn table(design: &Design, reference: &Assessment, found: &Assessment) -> String {
    let mut text = format!("bp1a, {} s, bound of each parameter in %\n\n{:<12}", design.duration_s, "");
    (1..=8).for_each(|i| text.push_str(&format!("{:>9}", format!("a{i}"))));
    for (name, of) in [("trajectory B", reference), ("designed", found)] {
        let _ = write!(text, "{:>9}\n{name:<12}", if name == "designed" { "" } else { "RMS" });
        of.relative_sigma.iter().for_each(|sigma| text.push_str(&format!("{:>9.4}", 100.0 * sigma)));
        let _ = write!(text, "{:>9.4}", 100.0 * of.relative_rms());
    }
    let gain = reference.relative_rms() / found.relative_rms();
    let _ = writeln!(
        text,
        "\n\nThe designed motion's bound is {gain:.2} times as tight: a record {:.2} times as long would do as much.",
        gain * gain
    );
    let _ = writeln!(text, "\n{:<22}{:>12}{:>12}{:>12}", "largest", "trajectory B", "designed", "limit");
    let names = ["joint angle [rad]", "joint rate [rad/s]", "base rate [rad/s]", "torque [N m]", "slosh stroke [m]"];
    let (reference, found, limits) = (reference.peaks.values(), found.peaks.values(), design.limits.values());
    for (i, name) in names.into_iter().enumerate().filter(|(i, _)| limits[*i].is_finite()) {
        let _ = writeln!(text, "{name:<22}{:>12.3}{:>12.3}{:>12.3}", reference[i], found[i], limits[i]);
    }
    text
}

/// The built-in arm with the references of `trajectory`, controller by controller.
pub fn plant_text(trajectory: &Designed) -> String {
    let text = plants::built_in("free_floating_arm").expect("the arm is built in");
    let (mut joint, mut out) = (0, String::new());
    let list = |values: &[f64; HARMONICS]| values.map(|value| format!("{value:.6}")).join(", ");
    let mut in_reference = false;
    for line in text.lines() {
        if line.starts_with('[') {
            in_reference = line.starts_with("[controller.reference]");
        }
        let coefficients = trajectory.joints.get(joint).filter(|_| in_reference);
        let replaced = match (line.split_once(" = ").map(|(key, _)| key), coefficients) {
            (Some("period"), Some(_)) => format!("period = \"{} s\"", trajectory.period_s),
            (Some("offset"), Some(joint)) => format!("offset = \"{:.6} rad\"", joint.offset_rad),
            (Some("sine"), Some(joint)) => {
                format!("sine = {{ unit = \"rad/s\", values = [{}] }}", list(&joint.cosine_rate_rad_s))
            }
            (Some("cosine"), Some(of)) => {
                joint += 1;
                format!("cosine = {{ unit = \"rad/s\", values = [{}] }}", list(&of.sine_rate_rad_s))
            }
            _ => line.to_owned(),
        };
        out.push_str(&replaced);
        out.push('\n');
    }
    out
}
