//! The figures, one per file. Each is a struct of its data, drawn by `draw(claim)`.

mod bars;
mod clusters;
mod cumulative;
mod heat;
mod matrix;
mod overlay;
mod scatter;
mod spectrum;
mod stabilisation;
mod state_map;
mod structure;
mod tiles;

use crate::panel::Panel;

pub use crate::curve::{Curve, Role};

pub use bars::{Bar, Bars};
pub use clusters::{Clusters, Mode};
pub use cumulative::Cumulative;
pub use matrix::Matrix;
pub use overlay::{Band, Mark, Overlay};
pub use scatter::Scatter;
pub use spectrum::Spectrum;
pub use stabilisation::{Pole, Stabilisation, Stability};
pub use state_map::StateMap;
pub use structure::{Structure, StructureMode};
pub use tiles::{TileMap, Tiles};

/// Draws the curves: models as lines, and the dots of measured samples on top of them.
fn draw_curves(panel: &mut Panel, curves: &[Curve<'_>]) {
    for curve in layered(curves) {
        panel.labelled(curve.label, |panel| match curve.role {
            Role::Measured => panel.samples_below(curve.x, curve.y),
            role => panel.line(role.class(), curve.x, curve.y),
        });
    }
    for curve in curves.iter().filter(|curve| curve.role == Role::Measured) {
        panel.labelled(curve.label, |panel| panel.samples(curve.x, curve.y));
    }
}

/// Draws every curve as a line, measured ones below.
fn draw_lines(panel: &mut Panel, curves: &[Curve<'_>]) {
    for curve in layered(curves) {
        panel.labelled(curve.label, |panel| panel.line(curve.role.class(), curve.x, curve.y));
    }
}

/// The curves in the order in which lines are drawn.
fn layered<'a, 'b>(curves: &'b [Curve<'a>]) -> Vec<&'b Curve<'a>> {
    let mut sorted: Vec<&Curve<'_>> = curves.iter().collect();
    sorted.sort_by_key(|curve| curve.role.layer());
    sorted
}
