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

    /// Order of drawing: measured below, truth on top.
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

/// The curves in the order in which they are drawn.
fn layered<'a, 'b>(curves: &'b [Curve<'a>]) -> Vec<&'b Curve<'a>> {
    let mut sorted: Vec<&Curve<'_>> = curves.iter().collect();
    sorted.sort_by_key(|curve| curve.role.layer());
    sorted
}
