//! A drawing of fixed width in user units, which a page scales; and the figure that it becomes.

use crate::data::Data;
use crate::style;
use crate::text::{coordinate, escape, fit, width_em};
use std::fmt::Write;

/// Width of every figure [user units]; a page of 760 px shows them as pixels.
pub const WIDTH: f64 = 760.0;
/// Size of all text in a figure.
pub const FONT: f64 = 12.0;

/// Which side of the text its place is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// Elements of a drawing, in the order in which they cover each other.
#[derive(Default)]
pub struct Svg {
    body: String,
}

impl Svg {
    /// Appends an element as text; the caller escapes it.
    pub fn raw(&mut self, element: &str) {
        self.body.push_str(element);
    }

    /// An element with coordinates as attributes.
    fn shape(&mut self, element: &str, class: &str, attributes: &[(&str, f64)]) {
        let _ = write!(self.body, "<{element} class=\"{class}\"");
        for (name, value) in attributes {
            let _ = write!(self.body, " {name}=\"");
            coordinate(&mut self.body, *value);
            self.body.push('"');
        }
        self.body.push_str("/>");
    }

    /// A rectangle from its upper left corner; a negative width becomes zero.
    pub fn rect(&mut self, class: &str, x: f64, y: f64, width: f64, height: f64) {
        self.shape("rect", class, &[("x", x), ("y", y), ("width", width.max(0.0)), ("height", height.max(0.0))]);
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        self.shape("line", class, &[("x1", from.0), ("y1", from.1), ("x2", to.0), ("y2", to.1)]);
    }

    /// A circle of radius [px].
    pub fn circle(&mut self, class: &str, x: f64, y: f64, radius: f64) {
        self.shape("circle", class, &[("cx", x), ("cy", y), ("r", radius)]);
    }

    /// An ellipse of half-axes [px].
    pub fn ellipse(&mut self, class: &str, centre: (f64, f64), radii: (f64, f64)) {
        self.shape("ellipse", class, &[("cx", centre.0), ("cy", centre.1), ("rx", radii.0), ("ry", radii.1)]);
    }

    /// Straight lines through each run of points.
    pub fn path(&mut self, class: &str, runs: &[Vec<(f64, f64)>]) {
        let _ = write!(self.body, "<path class=\"{class}\" d=\"");
        for run in runs {
            for (i, (x, y)) in run.iter().enumerate() {
                self.body.push(if i == 0 { 'M' } else { 'L' });
                coordinate(&mut self.body, *x);
                self.body.push(' ');
                coordinate(&mut self.body, *y);
            }
            // A run of one point is a dot.
            if run.len() == 1 {
                self.body.push_str("h0");
            }
        }
        self.body.push_str("\"/>");
    }

    /// Round dots of the stroke's width.
    pub fn dots(&mut self, class: &str, points: &[(f64, f64)]) {
        let runs: Vec<Vec<(f64, f64)>> = points.iter().map(|p| vec![*p]).collect();
        self.path(class, &runs);
    }

    /// Text cut to `width`; the full text shows under the pointer.
    pub fn text(&mut self, class: &str, at: (f64, f64), anchor: Anchor, width: f64, text: &str) {
        self.turned_text(class, at, anchor, width, text, 0);
    }

    /// As [`Svg::text`], turned by whole degrees about its place.
    pub fn turned_text(&mut self, class: &str, at: (f64, f64), anchor: Anchor, width: f64, text: &str, degrees: i32) {
        let shown = fit(text, width / FONT);
        self.body.push_str("<text x=\"");
        coordinate(&mut self.body, at.0);
        self.body.push_str("\" y=\"");
        coordinate(&mut self.body, at.1);
        let _ = write!(self.body, "\" class=\"{class}");
        self.body.push_str(match anchor {
            Anchor::Start => "\"",
            Anchor::Middle => " middle\"",
            Anchor::End => " end\"",
        });
        if degrees != 0 {
            let _ = write!(self.body, " transform=\"rotate({degrees} {:.1} {:.1})\"", at.0, at.1);
        }
        self.body.push('>');
        if shown != text {
            let _ = write!(self.body, "<title>{}</title>", escape(text));
        }
        let _ = write!(self.body, "{}</text>", escape(&shown));
    }

    /// Everything of `inner` that lies in the rectangle, in coordinates from its corner;
    /// `attributes` of the element begin with a space where there are any.
    pub fn clipped(&mut self, attributes: &str, (x, y, width, height): (f64, f64, f64, f64), inner: &Svg) {
        let _ = write!(self.body, "<svg{attributes}");
        for (name, value) in [("x", x), ("y", y), ("width", width), ("height", height)] {
            let _ = write!(self.body, " {name}=\"");
            coordinate(&mut self.body, value);
            self.body.push('"');
        }
        let _ = write!(self.body, ">{}</svg>", inner.body);
    }

    /// The drawing as a figure of that height.
    #[must_use]
    pub fn figure(self, title: &str, height: f64) -> Figure {
        let (title, empty) = (title.into(), String::new());
        Figure { title, body: self.body, height, caption: empty.clone(), command: empty, data: None }
    }
}

/// A figure: its claim as title, the drawing, a caption with the command that draws it.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub title: String,
    body: String,
    height: f64,
    pub caption: String,
    pub command: String,
    data: Option<Data>,
}

impl Figure {
    /// Caption: information beyond the axes.
    #[must_use]
    pub fn caption(self, caption: impl Into<String>) -> Self {
        Figure { caption: caption.into(), ..self }
    }

    /// The command that draws it.
    #[must_use]
    pub fn command(self, command: impl Into<String>) -> Self {
        Figure { command: command.into(), ..self }
    }

    /// The numbers behind the drawing, for a reader to download.
    pub(crate) fn data(self, data: Data) -> Self {
        Figure { data: Some(data), ..self }
    }

    /// The link to the numbers; empty without any.
    pub(crate) fn data_link(&self) -> String {
        self.data.as_ref().map_or(String::new(), |data| data.link(&self.title))
    }

    /// The drawing as an element of a page.
    #[must_use]
    pub fn inline(&self) -> String {
        let (title, height) = (escape(&self.title), self.height);
        format!(
            "<svg class=\"figure\" role=\"img\" aria-label=\"{title}\" viewBox=\"0 0 {WIDTH} {height:.0}\">{}</svg>",
            self.body
        )
    }

    /// A file of its own, with the title on top.
    #[must_use]
    pub fn document(&self) -> Vec<u8> {
        let mut head = Svg::default();
        let lines = wrapped(&self.title, (WIDTH - 20.0) / FONT / 1.2);
        for (i, line) in lines.iter().enumerate() {
            head.text("claim", (10.0, 20.0 + 18.0 * i as f64), Anchor::Start, 2.0 * WIDTH, line);
        }
        let top = 12.0 + 18.0 * lines.len() as f64;
        let height = self.height + top;
        let mut body = Svg::default();
        body.raw(&self.body);
        head.clipped("", (0.0, top, WIDTH, self.height), &body);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"figure\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\"><style>{}</style><rect class=\"paper\" width=\"100%\" height=\"100%\"/>{}</svg>\n",
            style::of_figure(),
            head.body
        )
        .into_bytes()
    }
}

/// Lines of whole words.
fn wrapped(text: &str, em_max: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_em(line) + width_em(word) + 0.4 <= em_max => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}
