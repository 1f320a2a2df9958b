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
mod tiles;

use crate::panel::Panel;

pub use bars::{Bar, Bars};
pub use clusters::{Clusters, Mode};
pub use cumulative::Cumulative;
pub use matrix::Matrix;
pub use overlay::{Band, Mark, Overlay};
pub use scatter::Scatter;
pub use spectrum::Spectrum;
pub use stabilisation::{Pole, Stabilisation, Stability};
pub use state_map::StateMap;
pub use tiles::{TileMap, Tiles};

/// Role of a line, which decides its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Black dots.
    Measured,
    /// The model before: grey.
    Before,
    /// The model after: the one colour.
    After,
    /// Dashed.
    Truth,
    /// One of the others: dotted grey.
    Rival,
}

impl Role {
    fn class(self) -> &'static str {
        match self {
            Role::Measured => "line measured",
            Role::Before => "line before",
            Role::After => "line after",
            Role::Truth => "line truth",
            Role::Rival => "line rival",
        }
    }

    /// Order of drawing among the lines: measured ones are wide and lie below, truth lies on top.
    fn layer(self) -> u8 {
        match self {
            Role::Measured => 0,
            Role::Rival => 1,
            Role::Before => 2,
            Role::After => 3,
            Role::Truth => 4,
        }
    }
}

/// A line or a cloud of samples.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a> {
    pub label: &'a str,
    pub role: Role,
    pub x: &'a [f64],
    pub y: &'a [f64],
}

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
