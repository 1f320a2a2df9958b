//! One self-contained HTML page with figures and tables.
//!
//! What it is: a [`Page`] of a verdict, sections of text, [`Table`]s and [`Figure`]s, written to
//! the bytes of one file: styles, figures and a small script inline, no external resource, light
//! and dark by the reader's setting, light on paper. The same input gives the same bytes. Without
//! the script the page loses the readout under the pointer and the zoom, and no content.
//!
//! May import: libm.
//!
//! Must never know: files (it returns bytes), estimators, processes, clocks.
//!
//! ```
//! use report::{Block, Cumulative, Curve, Page, Role, Section};
//!
//! let (time_s, gain) = ([0.0, 1.0, 2.0], [0.0, 4.0, 9.0]);
//! let curve = Curve { label: "viscous friction", role: Role::After, x: &time_s, y: &gain };
//! let figure = Cumulative { quantity: "gain", unit: "nat", ..Cumulative::default() };
//! let figure = Cumulative { curves: vec![curve], ..figure };
//! let drawn = figure.draw("evidence grows evenly");
//! let blocks = vec![Block::Text("p < 0.001".into()), Block::Figure(drawn)];
//! let (title, verdict) = ("Drive rig".into(), "Viscous friction is missing.".into());
//! let sections = vec![Section::new("Evidence", blocks)];
//! let page = Page { title, verdict, sections, ..Page::default() };
//! let html = String::from_utf8(page.html()).expect("a page is UTF-8");
//! // text is escaped, figures are inline
//! assert!(html.contains("p &lt; 0.001") && html.contains("<svg"));
//! assert_eq!(page.html(), html.into_bytes()); // same input, same bytes
//! ```
//!
//! Figures have one grammar: measured data are black dots on top, the model before is grey, the
//! model after has the one colour, truth is dashed; the claim is the title, the command is the
//! caption. A line is drawn from the extremes of every pixel column, so that no spike of a long
//! record is lost.
//!
//! Why not plotters? Its SVG backend writes fixed colours (no dark page), every sample as an
//! element, and text that overlaps if it does not fit.
#![forbid(unsafe_code)]

mod curve;
mod data;
pub mod decimate;
pub mod figures;
mod page;
mod panel;
mod scale;
mod style;
mod svg;
mod table;
pub mod text;

pub use figures::{
    Band, Bar, Bars, Clusters, Cumulative, Curve, Mark, Matrix, Mode, Overlay, Pole, Role, Scatter, Spectrum,
    Stabilisation, Stability, StateMap, Structure, StructureMode, TileMap, Tiles,
};
pub use page::{Block, Page, Section};
pub use svg::Figure;
pub use table::{Cell, Table};
