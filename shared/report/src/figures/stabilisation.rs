//! Stabilisation diagram: poles over model order. Physical poles persist as the order grows.

use super::Curve;
use crate::data::{Data, number, quoted};
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};

/// Agreement of a pole with one of the order below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    New,
    Frequency,
    FrequencyAndDamping,
    /// Frequency, damping and shape.
    All,
}

/// A pole.
#[derive(Clone, Copy, Debug)]
pub struct Pole {
    pub order: f64,
    pub frequency_hz: f64,
    pub stability: Stability,
}

/// Poles over order, on the spectrum they were found in.
#[derive(Clone, Debug, Default)]
pub struct Stabilisation<'a> {
    pub poles: Vec<Pole>,
    /// Drawn behind, on a logarithmic scale of its own.
    pub spectrum: Option<Curve<'a>>,
    /// Modes that were taken \[Hz\].
    pub chosen_hz: Vec<f64>,
}

const STABILISATION_HEIGHT: f64 = 300.0;
const KINDS: [(Stability, &str, &str); 4] = [
    (Stability::New, "before-fill", "new"),
    (Stability::Frequency, "ring before", "frequency stable"),
    (Stability::FrequencyAndDamping, "ring after", "and damping"),
    (Stability::All, "after-fill", "and shape"),
];

impl Stabilisation<'_> {
    /// Poles by stability over frequency and model order, with the spectrum behind them, under the
    /// title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let mut entries: Vec<Entry<'_>> =
            KINDS.iter().map(|(_, class, label)| Entry { class: (*class).into(), label }).collect();
        if let Some(spectrum) = &self.spectrum {
            entries.push(Entry { class: "line before".into(), label: spectrum.label });
        }
        let top = legend(&mut svg, 4.0, &entries) + 8.0;
        let frequencies =
            self.poles.iter().map(|p| p.frequency_hz).chain(self.spectrum.iter().flat_map(|s| s.x.iter().copied()));
        let x = Axis::tight("frequency", "Hz", frequencies);
        let mut panel = Panel::new(
            Area::full(top, STABILISATION_HEIGHT),
            x,
            Axis::linear("model order", "-", self.poles.iter().map(|p| p.order)),
        );
        for f in &self.chosen_hz {
            panel.stretch("area band", *f, *f, "chosen");
        }
        if let Some(spectrum) = &self.spectrum {
            self.behind(&mut panel, spectrum);
        }
        for pole in &self.poles {
            let (px, py) = (panel.x_px(pole.frequency_hz), panel.y_px(pole.order));
            if px.is_finite() && py.is_finite() {
                let class = KINDS
                    .iter()
                    .find(|(kind, ..)| *kind == pole.stability)
                    .map_or("before-fill", |(_, class, _)| class);
                panel.inner.circle(class, px, py, if pole.stability == Stability::New { 1.6 } else { 3.0 });
            }
        }
        panel.draw(&mut svg);
        svg.figure(claim, top + STABILISATION_HEIGHT + BELOW).data(self.data())
    }

    /// One row per pole.
    fn data(&self) -> Data {
        Data::new(&["model order", "frequency [Hz]", "stability"], self.poles.len(), |k| {
            let pole = &self.poles[k];
            let label = KINDS.iter().find(|(kind, ..)| *kind == pole.stability).map_or("", |(.., label)| label);
            vec![number(pole.order), number(pole.frequency_hz), quoted(label)]
        })
    }

    fn behind(&self, panel: &mut Panel, spectrum: &Curve<'_>) {
        let own = Axis::logarithmic("", "", spectrum.y.iter().copied(), 8);
        let height = panel.area.height;
        let points = spectrum.x.iter().zip(spectrum.y).map(|(x, y)| (panel.x_px(*x), (1.0 - own.place(*y)) * height));
        let runs = crate::decimate::line(points);
        panel.inner.path("line before", &runs);
    }
}
