//! The shapes of modes on the structure: undeformed in grey, deformed on top; the page's script
//! lets it move.
//!
//! Four views: one from an angle, which the pointer turns, and the projections along the axes. A
//! point moves by `Re(ψ e^{iθ})`, so that a complex shape travels. Without the script, on paper,
//! and for a reader who wants less motion it is the still of the first mode at its largest.

use crate::svg::{Anchor, FONT, Figure, Svg, WIDTH};
use crate::text::{escape, width_em};
use std::fmt::Write;

/// Displacement at the largest component, in diagonals of the structure.
const LARGEST: f64 = 0.12;
/// The turned view: about the vertical, and down on it.
const TURN: f64 = 0.6;
const TILT: f64 = 0.45;
const HEIGHT: f64 = 400.0;
const GAP: f64 = 10.0;

/// A mode on the nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StructureMode {
    pub name: String,
    /// Of each node real and imaginary part along x, y, z, in any scale.
    pub shape: Vec<[[f64; 2]; 3]>,
}

/// Nodes, lines between them, and modes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    pub nodes_m: Vec<[f64; 3]>,
    /// Which nodes carry a sensor.
    pub measured: Vec<bool>,
    /// Indices of the nodes of each stroke of the pen.
    pub strokes: Vec<Vec<usize>>,
    pub modes: Vec<StructureMode>,
}

/// A view: its place in the figure and the two axes of the paper.
struct View {
    name: &'static str,
    area: [f64; 4],
    axes: [[f64; 3]; 2],
}

fn views() -> [View; 4] {
    let (left, right) = (440.0, WIDTH - 440.0 - GAP);
    let height = (HEIGHT - 2.0 * GAP) / 3.0;
    let small = |k: usize| [left + GAP, k as f64 * (height + GAP), right, height];
    [
        View { name: "turned", area: [0.0, 0.0, left, HEIGHT], axes: turned(TURN) },
        View { name: "x–y", area: small(0), axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] },
        View { name: "x–z", area: small(1), axes: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] },
        View { name: "y–z", area: small(2), axes: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] },
    ]
}

/// Right and up of the view from an angle.
fn turned(turn: f64) -> [[f64; 3]; 2] {
    let (s, c) = (libm::sin(turn), libm::cos(turn));
    let (down, up) = (libm::sin(TILT), libm::cos(TILT));
    [[c, s, 0.0], [-s * down, c * down, up]]
}

impl Structure {
    /// All views under the title `claim`; the modes in the figure's data for the script.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let _ = self.modes.first().map(|mode| {
            svg.raw(&format!("<g class=\"structure\" data-structure=\"{}\">", escape(&self.data())));
            let (centre, size) = self.extent();
            let scale = LARGEST * 2.0 * size / largest(mode);
            for view in views() {
                let [x, y, width, height] = view.area;
                svg.rect("plot", x, y, width, height);
                let mut inner = Svg::default();
                let still = self.points(&view, centre, size, &mut |_| [0.0; 3]);
                let moved = self.points(&view, centre, size, &mut |k| mode.shape[k].map(|[re, _]| scale * re));
                inner.path("line before", &self.runs(&still));
                inner.raw("<g class=\"moving\">");
                inner.path("line after", &self.runs(&moved));
                let dots: Vec<(f64, f64)> = (0..moved.len()).filter(|k| self.measured[*k]).map(|k| moved[k]).collect();
                inner.dots("dot after", &dots);
                inner.raw("</g>");
                let attributes = format!(" class=\"view\" data-view=\"{}\"", view.name);
                svg.clipped(&attributes, (x, y, width, height), &inner);
                svg.rect("frame", x, y, width, height);
                svg.text("tick", (x + 6.0, y + 16.0), Anchor::Start, FONT * width_em(view.name) + 4.0, view.name);
            }
            svg.raw("</g>");
        });
        if self.modes.is_empty() {
            svg.text("faint", (WIDTH / 2.0, 40.0), Anchor::Middle, WIDTH, "no modes");
        }
        svg.figure(claim, HEIGHT)
    }

    /// Centre, and half the diagonal.
    fn extent(&self) -> ([f64; 3], f64) {
        let bound = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
            self.nodes_m.iter().map(|node| node[axis]).fold(start, pick)
        };
        let (mut centre, mut squares) = ([0.0; 3], 0.0);
        for (axis, centre) in centre.iter_mut().enumerate() {
            let (low, high) = (bound(axis, f64::INFINITY, f64::min), bound(axis, f64::NEG_INFINITY, f64::max));
            *centre = 0.5 * (low + high);
            squares += (high - low) * (high - low);
        }
        let size = 0.5 * libm::sqrt(squares);
        (centre, if size > 0.0 { size } else { 1.0 })
    }

    fn points(
        &self,
        view: &View,
        centre: [f64; 3],
        size: f64,
        displacement: &mut dyn FnMut(usize) -> [f64; 3],
    ) -> Vec<(f64, f64)> {
        let [_, _, width, height] = view.area;
        // The diagonal and the displacements at its ends fit into the smaller side.
        let zoom = 0.5 * width.min(height) / (size * (1.0 + 2.5 * LARGEST));
        let place = |(k, node): (usize, &[f64; 3])| {
            let by = displacement(k);
            let along = |axis: &[f64; 3]| (0..3).map(|i| axis[i] * (node[i] + by[i] - centre[i])).sum::<f64>();
            (0.5 * width + zoom * along(&view.axes[0]), 0.5 * height - zoom * along(&view.axes[1]))
        };
        self.nodes_m.iter().enumerate().map(place).collect()
    }

    fn runs(&self, points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        self.strokes.iter().map(|stroke| stroke.iter().map(|k| points[*k]).collect()).collect()
    }

    /// What the script needs, as JSON: places from the centre in half diagonals, shapes of largest
    /// component one.
    fn data(&self) -> String {
        let (centre, size) = self.extent();
        let list = |values: &mut dyn Iterator<Item = String>| format!("[{}]", values.collect::<Vec<_>>().join(","));
        let number = |x: f64| format!("{:.4}", if x.is_finite() { x } else { 0.0 });
        let nodes =
            list(&mut self.nodes_m.iter().map(|node| list(&mut (0..3).map(|i| number((node[i] - centre[i]) / size)))));
        let measured = list(&mut self.measured.iter().map(|m| u8::from(*m).to_string()));
        let strokes = list(&mut self.strokes.iter().map(|stroke| list(&mut stroke.iter().map(ToString::to_string))));
        let modes = list(&mut self.modes.iter().map(|mode| {
            let largest = largest(mode);
            let parts = mode.shape.iter().flatten().flatten().map(|x| number(x / largest));
            let name = mode.name.replace(['"', '\\'], "'");
            format!("{{\"name\":\"{name}\",\"shape\":{}}}", list(&mut parts.into_iter()))
        }));
        let mut text = String::new();
        let _ = write!(
            text,
            "{{\"nodes\":{nodes},\"measured\":{measured},\"strokes\":{strokes},\"modes\":{modes},\"largest\":{LARGEST},\"tilt\":{TILT},\"turn\":{TURN}}}"
        );
        text
    }
}

/// Largest displacement of a node.
fn largest(mode: &StructureMode) -> f64 {
    let size = |node: &[[f64; 2]; 3]| libm::sqrt(node.iter().flatten().map(|x| x * x).sum::<f64>());
    let largest = mode.shape.iter().map(size).filter(|x| x.is_finite()).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam() -> Structure {
        let mode =
            StructureMode { name: "1: 5 Hz".into(), shape: vec![[[0.0; 2]; 3], [[0.0, 0.0], [0.0, 0.0], [2.0, 1.0]]] };
        Structure {
            nodes_m: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            measured: vec![false, true],
            strokes: vec![vec![0, 1]],
            modes: vec![mode],
        }
    }

    #[test]
    fn the_still_shows_four_views_and_the_script_has_the_complex_shape() {
        let html = beam().draw("a beam bends").inline();
        assert_eq!(html.matches("class=\"moving\"").count(), 4);
        assert!(html.contains("&quot;shape&quot;:[0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.8944,0.4472]"), "{html}");
    }

    #[test]
    fn nodes_in_one_place_and_shapes_of_zeros_give_finite_drawings() {
        let mut flat = beam();
        flat.nodes_m[1] = [0.0; 3];
        flat.modes[0].shape[1] = [[0.0; 2]; 3];
        assert!(!flat.draw("nothing moves").inline().contains("NaN"));
        assert!(Structure::default().draw("no modes").inline().contains("no modes"));
    }
}
