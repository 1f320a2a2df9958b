//! Power over frequency, both logarithmic.

use super::overlay::{Mark, entry};
use super::{Curve, Role, draw_lines};
use crate::data::Data;
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};

/// Spectra over each other.
#[derive(Clone, Debug, Default)]
pub struct Spectrum<'a> {
    pub quantity: &'a str,
    /// Of the density, e.g. `(m/s^2)^2/Hz`.
    pub unit: &'a str,
    pub curves: Vec<Curve<'a>>,
    /// Bands worth a look \[Hz\].
    pub bands: Vec<Mark>,
    pub bands_are: &'a str,
    /// White noise under the curves, where it is known.
    pub noise: Option<f64>,
}

const SPECTRUM_HEIGHT: f64 = 190.0;
/// A spectrum is not followed further below its peak: rounding is not physics.
const DECADES_MAX: i32 = 14;

impl Spectrum<'_> {
    /// Power over frequency, both axes logarithmic, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let mut entries: Vec<Entry<'_>> = self
            .curves
            .iter()
            .map(|c| {
                if c.role == Role::Measured {
                    Entry { class: "line measured".into(), label: c.label }
                } else {
                    entry(c)
                }
            })
            .collect();
        if self.noise.is_some() {
            entries.push(Entry { class: "line truth".into(), label: "white noise" });
        }
        if !self.bands.is_empty() {
            entries.push(Entry { class: "area mark".into(), label: self.bands_are });
        }
        let top = legend(&mut svg, 4.0, &entries) + 8.0;
        let x = Axis::logarithmic("frequency", "Hz", self.curves.iter().flat_map(|c| c.x.iter().copied()), 6);
        let ys = self.curves.iter().flat_map(|c| c.y.iter().copied()).chain(self.noise);
        let mut panel = Panel::new(
            Area::full(top, SPECTRUM_HEIGHT),
            x,
            Axis::logarithmic(self.quantity, self.unit, ys, DECADES_MAX),
        );
        for band in &self.bands {
            panel.stretch("area mark", band.from, band.to, &band.what);
        }
        draw_lines(&mut panel, &self.curves);
        if let Some(noise) = self.noise {
            panel.level("line truth", noise);
        }
        panel.draw(&mut svg);
        let data = Data::of_curves(("frequency", "Hz"), (self.quantity, self.unit), &self.curves);
        svg.figure(claim, top + SPECTRUM_HEIGHT + BELOW).data(data)
    }
}
