//! Modes as a table: a row for each, what is not known left empty, the components of the shape
//! behind.

use super::{FoundMode, Outcome};

/// Whole file; numbers with the fewest digits that read back.
pub(super) fn table(outcome: &Outcome) -> String {
    let shaped = outcome.modes.iter().any(|mode| !mode.shape.is_empty());
    let mut header: Vec<String> =
        ["mode", "frequency [Hz]", "frequency_sd [Hz]", "damping [-]", "damping_sd [-]", "mpc [-]", "kind"]
            .map(String::from)
            .into();
    for channel in outcome.channels.iter().filter(|_| shaped) {
        header.extend(["re", "im"].map(|part| cell(&format!("shape_{channel}_{part} [-]"))));
    }
    let known = outcome.modes.iter().any(|mode| !mode.shape_sd.is_empty());
    for channel in outcome.channels.iter().filter(|_| known) {
        header.extend(["re", "im"].map(|part| cell(&format!("shape_{channel}_{part}_sd [-]"))));
    }
    let rows = outcome.modes.iter().enumerate().map(|(k, mode)| row(k + 1, mode, outcome.kind));
    std::iter::once(header.join(",")).chain(rows).map(|line| line + "\n").collect()
}

fn row(number: usize, mode: &FoundMode, kind: &str) -> String {
    let known = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let numbers = [Some(mode.frequency_hz), mode.frequency_sd, mode.damping, mode.damping_sd, mode.phase_collinearity];
    let mut cells = vec![number.to_string()];
    cells.extend(numbers.map(known));
    cells.push(cell(kind));
    cells.extend(mode.shape.iter().chain(&mode.shape_sd).flat_map(|psi| [psi.re.to_string(), psi.im.to_string()]));
    cells.join(",")
}

/// In quotes where a comma or a quote stands in it.
fn cell(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use modal::c64;

    #[test]
    fn every_row_has_the_cells_of_the_header_and_what_is_not_known_is_empty() {
        let mode = |shape: &[f64]| FoundMode {
            frequency_hz: 1.5,
            damping: Some(0.25),
            shape: shape.iter().map(|x| c64::new(*x, 0.0)).collect(),
            phase_collinearity: Some(1.0),
            ..FoundMode::default()
        };
        let outcome = Outcome {
            kind: "closed loop, all",
            channels: vec!["a,b".into(), "c".into()],
            modes: vec![mode(&[1.0, -0.5])],
            ..Outcome::default()
        };
        let text = table(&outcome);
        let (header, row) = text.trim_end().split_once('\n').unwrap();
        // Two names of channels and the kind stand in quotes, for the comma in them.
        assert!(header.contains(",\"shape_a,b_re [-]\",\"shape_a,b_im [-]\",shape_c_re [-],"), "{header}");
        assert_eq!(row, "1,1.5,,0.25,,1,\"closed loop, all\",1,0,-0.5,0");
        assert_eq!(header.split(',').count() - 2, row.split(',').count() - 1, "{text}");
        let none = Outcome { modes: vec![mode(&[])], ..outcome };
        assert_eq!(table(&none).lines().next().unwrap().split(',').count(), 7, "no phase, no shapes");
    }
}
