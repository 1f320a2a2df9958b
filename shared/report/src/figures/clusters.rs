//! Frequency and damping of poles, gathered into modes.

use crate::data::{Data, number};
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Anchor, Figure, Svg};
use crate::text::with_sigma;

/// A mode: the middle of a cluster.
#[derive(Clone, Debug)]
pub struct Mode {
    pub name: String,
    pub frequency_hz: f64,
    pub frequency_sigma_hz: f64,
    pub damping_ratio: f64,
    pub damping_sigma: f64,
}

/// Poles as dots, modes as ellipses of two sigmas.
#[derive(Clone, Debug, Default)]
pub struct Clusters<'a> {
    pub pole_frequency_hz: &'a [f64],
    pub pole_damping_ratio: &'a [f64],
    pub modes: Vec<Mode>,
}

const CLUSTERS_HEIGHT: f64 = 280.0;

impl Clusters<'_> {
    /// Poles and modes over damping ratio and frequency, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let entries = [
            Entry { class: "dot before".into(), label: "pole" },
            Entry { class: "line after".into(), label: "mode, two sigma" },
        ];
        let top = legend(&mut svg, 4.0, &entries) + 8.0;
        let ends = |middle: f64, sigma: f64| [middle - 2.5 * sigma, middle, middle + 2.5 * sigma];
        let f = self.modes.iter().flat_map(|m| ends(m.frequency_hz, m.frequency_sigma_hz));
        let z = self.modes.iter().flat_map(|m| ends(m.damping_ratio, m.damping_sigma));
        let x = Axis::linear("frequency", "Hz", f.chain(self.pole_frequency_hz.iter().copied()));
        let percent: Vec<f64> = z.chain(self.pole_damping_ratio.iter().copied()).map(|z| 100.0 * z).collect();
        let mut panel =
            Panel::new(Area::full(top, CLUSTERS_HEIGHT), x, Axis::linear("damping ratio", "%", percent.into_iter()));
        let damping: Vec<f64> = self.pole_damping_ratio.iter().map(|z| 100.0 * z).collect();
        panel.dots("dot before", self.pole_frequency_hz, &damping);
        for mode in &self.modes {
            draw_mode(&mut panel, mode);
        }
        panel.draw(&mut svg);
        svg.figure(claim, top + CLUSTERS_HEIGHT + BELOW).data(self.data())
    }

    /// One row per pole.
    fn data(&self) -> Data {
        let count = self.pole_frequency_hz.len().min(self.pole_damping_ratio.len());
        Data::new(&["frequency [Hz]", "damping ratio"], count, |k| {
            vec![number(self.pole_frequency_hz[k]), number(self.pole_damping_ratio[k])]
        })
    }
}

fn draw_mode(panel: &mut Panel, mode: &Mode) {
    let (x, y) = (panel.x_px(mode.frequency_hz), panel.y_px(100.0 * mode.damping_ratio));
    if !(x.is_finite() && y.is_finite()) {
        return;
    }
    let half = |from: f64, to: f64| if (to - from).is_finite() { (to - from).abs().max(4.0) } else { 4.0 };
    let across = half(x, panel.x_px(mode.frequency_hz + 2.0 * mode.frequency_sigma_hz));
    let up = half(y, panel.y_px(100.0 * (mode.damping_ratio + 2.0 * mode.damping_sigma)));
    panel.inner.ellipse("ring after", (x, y), (across, up));
    let (f, sigma) = with_sigma(mode.frequency_hz, mode.frequency_sigma_hz);
    let label = format!("{} {f} ± {sigma} Hz", mode.name);
    // On the side where there is room.
    let right = x < panel.area.width / 2.0;
    let (at, anchor, room) = if right {
        (x + across + 6.0, Anchor::Start, panel.area.width - x - across - 8.0)
    } else {
        (x - across - 6.0, Anchor::End, x - across - 8.0)
    };
    panel.inner.text("label", (at, y + 4.0), anchor, room, &label);
}
