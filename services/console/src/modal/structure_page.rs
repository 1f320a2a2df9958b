//! The structure on the page: shapes that move, the MAC matrix, singular values.

use super::uff_export::displacements;
use super::{FoundMode, Outcome};
use modal::mac::modal_assurance_criterion;
use modal::singular_values::SingularValues;
use report::{Block, Curve, Figure, Mark, Matrix, Role, Spectrum, StructureMode};

/// Singular values drawn at most: those of modes that lie closer together are rare.
const CURVES_MAX: usize = 8;

/// Shapes on the structure, where the channels have places.
pub(super) fn motion(outcome: &Outcome) -> Option<Figure> {
    let geometry = outcome.structure.geometry.as_ref()?;
    let modes = outcome.modes.iter().enumerate().filter(|(_, mode)| !mode.shape.is_empty());
    let drawn = modes.map(|(k, mode)| {
        let mut shape = vec![[[0.0; 2]; 3]; geometry.nodes_m.len()];
        displacements(mode, geometry).into_iter().for_each(|(node, by)| shape[node] = by);
        StructureMode { name: label(k, mode), shape }
    });
    let measured = (0..geometry.nodes_m.len()).map(|k| geometry.sensors.iter().any(|sensor| sensor.node == k));
    let structure = report::Structure {
        nodes_m: geometry.nodes_m.clone(),
        measured: measured.collect(),
        strokes: geometry.strokes.clone(),
        modes: drawn.collect(),
    };
    let first = outcome.modes.iter().position(|mode| !mode.shape.is_empty())?;
    let claim = format!("Mode {} on the structure", label(first, &outcome.modes[first]));
    let caption = "Grey: at rest. Dots: nodes with sensors; nodes without rest. A complex shape travels.";
    Some(structure.draw(&claim).caption(caption))
}

fn label(k: usize, mode: &FoundMode) -> String {
    format!("{}: {:.4} Hz", k + 1, mode.frequency_hz)
}

/// Against the reference where there is one, else the modes among themselves.
pub(super) fn assurance(outcome: &Outcome) -> Option<Block> {
    let rows: Vec<String> = outcome.modes.iter().enumerate().map(|(k, mode)| label(k, mode)).collect();
    let empty = Matrix { quantity: "MAC", unit: "-", range: Some((0.0, 1.0)), rows, ..Matrix::default() };
    if let Some(compared) = &outcome.structure.compared {
        let columns = compared.reference.modes.iter().enumerate();
        let columns = columns.map(|(k, mode)| format!("{}: {:.4} Hz", k + 1, mode.frequency_hz)).collect();
        let matrix = Matrix { columns, values: compared.comparison.values.clone(), ..empty };
        let pairs = compared.comparison.pairs.len();
        let claim = format!("{pairs} of {} modes have a partner in the reference", outcome.modes.len());
        let caption = format!("Rows: this record. Columns: {}.", compared.file);
        return (!outcome.modes.is_empty()).then(|| Block::Figure(matrix.draw(&claim).caption(caption)));
    }
    let shaped: Vec<&FoundMode> = outcome.modes.iter().filter(|mode| mode.shape.len() > 1).collect();
    let value = |a: &FoundMode, b: &FoundMode| modal_assurance_criterion(&a.shape, &b.shape);
    let values = shaped.iter().map(|a| shaped.iter().map(|b| value(a, b)).collect()).collect();
    let whole = shaped.len() == outcome.modes.len() && shaped.len() > 1;
    whole.then(|| {
        let caption = "Off the diagonal near 1: the sensors cannot tell the two shapes apart.";
        Block::Figure(Matrix { values, ..empty }.draw("How alike the shapes are among themselves").caption(caption))
    })
}

/// Singular values with the modes marked.
pub(super) fn singular(outcome: &Outcome) -> Option<Figure> {
    let SingularValues { frequency_hz, values } = outcome.structure.singular_values.as_ref()?;
    let count = values.first()?.len().min(CURVES_MAX);
    let columns: Vec<Vec<f64>> = (0..count).map(|k| values.iter().map(|line| line[k]).collect()).collect();
    let names: Vec<String> = (1..=count).map(|k| format!("singular value {k}")).collect();
    let role = |k: usize| match k {
        0 => Role::After,
        1 => Role::Before,
        _ => Role::Rival,
    };
    let curves: Vec<Curve<'_>> = columns
        .iter()
        .enumerate()
        .map(|(k, y)| Curve { label: names[k].as_str(), role: role(k), x: frequency_hz, y })
        .collect();
    let mark = |(k, mode): (usize, &FoundMode)| Mark {
        from: mode.frequency_hz,
        to: mode.frequency_hz,
        what: format!("mode {}", label(k, mode)),
    };
    let bands = outcome.modes.iter().enumerate().map(mark).collect();
    let figure = Spectrum { quantity: "singular value", unit: "", curves, bands, bands_are: "mode", noise: None };
    let caption =
        "Of the matrix of all channels, line by line. Two values that rise together: two modes close to each other.";
    Some(figure.draw("Modes stand out of the first singular value").caption(caption))
}
