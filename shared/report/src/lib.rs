//! One self-contained HTML page with figures and tables.
//!
//! A [`Page`] holds the verdict, sections of text, [`Table`]s and [`Figure`]s, and gives the bytes of one file: styles and figures inline, no
//! script, nothing fetched, light and dark by the reader's setting, light on paper. Same input, same bytes.
//!
//! Figures follow one grammar: measured is black dots, the model before is grey, after is the one colour, truth is dashed; the claim stands in the
//! title, the command in the caption. However long the record, a line is drawn from the extremes of every pixel column, so that no spike is lost.
//!
//! May import: libm. Must never know: files (it returns bytes), estimators, processes, clocks.
//!
//! Why not plotters? Its SVG backend writes fixed colours (no dark page), every sample as an element, and leaves text that does not fit to overlap.
#![forbid(unsafe_code)]

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
    Stabilisation, Stability, StateMap, TileMap, Tiles,
};
pub use page::{Block, Page, Section};
pub use svg::Figure;
pub use table::{Cell, Table};
