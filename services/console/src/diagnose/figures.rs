//! Measurements of the diagnosis as figures: energy in time–frequency bins before and after,
//! evidence over time, maps of the force, angles of rivals, held-out overlays.

use super::paragraph::percent;
use discovery::diagnose::{Angles, Diagnosis, EvidenceCurve, LawMap, Overlay as Shown, Tile};
use report::text::short;
use report::{Cumulative, Curve, Figure, Matrix, Overlay, Role, Scatter, StateMap, TileMap, Tiles};

/// Figures of one kind; beyond them the tables hold what there is.
const EACH_MAX: usize = 12;
/// Columns of a map of time–frequency bins.
const COLUMNS_MAX: usize = 400;

/// Innovations of every channel over time and frequency, before beside after.
pub fn tiles(diagnosis: &Diagnosis) -> Vec<Figure> {
    let all = &diagnosis.figures.tiles;
    let channels = in_order(all.iter().map(|tile| tile.channel.as_str()));
    let largest = all.iter().flat_map(|t| [t.z_before, t.z_after]).filter(|z| z.is_finite()).fold(1.0, f64::max);
    let draw = |channel: &&str| {
        let own: Vec<&Tile> = all.iter().filter(|tile| tile.channel == *channel).collect();
        let grid = Grid::of(&own)?;
        let most = |z: fn(&Tile) -> f64| own.iter().map(|t| z(t)).filter(|z| z.is_finite()).fold(0.0, f64::max);
        let (before, after) = (most(|t| t.z_before), most(|t| t.z_after));
        let (left, right) = (format!("{channel}, before"), format!("{channel}, after"));
        let figure = TileMap {
            quantity: "power above the stated noise",
            unit: "standard errors",
            // without its sign the scale runs from light to dark, also in grey
            range: Some((0.0, largest)),
            maps: vec![grid.map(&left, |t| t.z_before), grid.map(&right, |t| t.z_after)],
            columns: 2,
        };
        let claim = format!(
            "{channel}: the innovations stand out by {} standard errors before, {} after",
            short(before),
            short(after)
        );
        Some(figure.draw(&claim).caption("Whitened innovations; of an adequate model none stands out."))
    };
    channels.iter().take(EACH_MAX).filter_map(draw).collect()
}

/// Time–frequency bins of unequal size on equal steps of time and octaves.
struct Grid<'a> {
    tiles: &'a [&'a Tile],
    time_s: (f64, f64),
    columns: usize,
    frequency_hz: (f64, f64),
    rows: usize,
}

impl<'a> Grid<'a> {
    fn of(tiles: &'a [&'a Tile]) -> Option<Self> {
        let least = |value: fn(&Tile) -> f64| tiles.iter().map(|t| value(t)).fold(f64::INFINITY, f64::min);
        let most = |value: fn(&Tile) -> f64| tiles.iter().map(|t| value(t)).fold(f64::NEG_INFINITY, f64::max);
        let time_s = (least(|t| t.time[0]), most(|t| t.time[1]));
        let step = least(|t| t.time[1] - t.time[0]);
        // the lowest band may begin at zero: it is drawn as one octave
        let low = least(|t| if t.band_hz[0] > 0.0 { t.band_hz[0] } else { 0.5 * t.band_hz[1] });
        let frequency_hz = (low, most(|t| t.band_hz[1]));
        let usable = step > 0.0 && time_s.1 > time_s.0 && low > 0.0 && frequency_hz.1 > low;
        if !usable || !(time_s.1 - time_s.0).is_finite() || !frequency_hz.1.is_finite() {
            return None;
        }
        let columns = (((time_s.1 - time_s.0) / step).round() as usize).clamp(1, COLUMNS_MAX);
        let rows = (libm::log2(frequency_hz.1 / low).round() as usize).clamp(1, 24);
        Some(Grid { tiles, time_s, columns, frequency_hz, rows })
    }

    /// The most significant of the bins that cover a place.
    fn map<'n>(&self, name: &'n str, z: fn(&Tile) -> f64) -> Tiles<'n> {
        let (begin, step) = (self.time_s.0, (self.time_s.1 - self.time_s.0) / self.columns as f64);
        let octave = libm::log2(self.frequency_hz.1 / self.frequency_hz.0) / self.rows as f64;
        let mut rows = vec![vec![f64::NAN; self.columns]; self.rows];
        for tile in self.tiles {
            let value = z(tile).max(0.0);
            let column =
                |t: f64, round: fn(f64) -> f64| round((t - begin) / step).clamp(0.0, self.columns as f64) as usize;
            let row = |f: f64| {
                let place = libm::log2(f.max(self.frequency_hz.0) / self.frequency_hz.0) / octave;
                place.round().clamp(0.0, self.rows as f64) as usize
            };
            let from = column(tile.time[0] + 1e-6 * step, f64::floor);
            let to = column(tile.time[1] - 1e-6 * step, f64::ceil);
            for cells in rows.iter_mut().take(row(tile.band_hz[1])).skip(row(tile.band_hz[0])) {
                for cell in cells.iter_mut().take(to).skip(from) {
                    *cell = if cell.is_nan() { value } else { cell.max(value) };
                }
            }
        }
        Tiles { name, time_s: self.time_s, frequency_hz: self.frequency_hz, rows }
    }
}

/// Evidence of the adopted effects and of their rivals, summed over time.
pub fn evidence(diagnosis: &Diagnosis) -> Option<Figure> {
    let curves: Vec<&EvidenceCurve> = diagnosis.figures.evidence.iter().take(EACH_MAX).collect();
    let adopted = |c: &EvidenceCurve| diagnosis.effects.iter().any(|e| e.kind == c.kind && e.site == c.site);
    let labels: Vec<String> = curves.iter().map(|c| super::names::named(&c.kind, &c.site)).collect();
    let first = curves.first()?;
    let drawn: Vec<Curve<'_>> = curves
        .iter()
        .zip(&labels)
        .map(|(c, label)| {
            let (role, n) = (if adopted(c) { Role::After } else { Role::Rival }, c.time_s.len().min(c.gain.len()));
            Curve { label, role, x: &c.time_s[..n], y: &c.gain[..n] }
        })
        .collect();
    let total = first.gain.last().copied().unwrap_or(0.0);
    let claim = match half_of(first) {
        Some((from, to)) => format!(
            "{}: {} nat of evidence, the middle half of it between {} and {} s",
            labels[0],
            short(total),
            short(from),
            short(to)
        ),
        None => format!("{}: {} nat of evidence", labels[0], short(total)),
    };
    let figure = Cumulative { quantity: "evidence", unit: "nat", curves: drawn, ..Cumulative::default() };
    Some(
        figure
            .draw(&claim)
            .caption("Gain in log-likelihood up to each instant; a step is one event, a slope is everywhere."),
    )
}

/// Times at which a quarter and three quarters of the evidence had come in.
fn half_of(curve: &EvidenceCurve) -> Option<(f64, f64)> {
    let total = curve.gain.last().copied().filter(|total| *total > 0.0)?;
    let at = |share: f64| {
        let first = curve.gain.iter().position(|gain| *gain >= share * total)?;
        curve.time_s.get(first).copied()
    };
    Some((at(0.25)?, at(0.75)?))
}

/// Every map of a law: the data, the fitted law on the same scale, and both along each coordinate.
pub fn laws(diagnosis: &Diagnosis) -> Vec<Figure> {
    diagnosis.figures.law_maps.iter().take(EACH_MAX).flat_map(law).collect()
}

fn law(map: &LawMap) -> Vec<Figure> {
    let (xs, ys) = (steps(map.cells.iter().map(|c| c.x)), steps(map.cells.iter().map(|c| c.y)));
    let mut figures = Vec::new();
    if let (Some(x), Some(y)) = (&xs, &ys) {
        let all = map.cells.iter().map(|c| c.value).filter(|f| f.is_finite());
        let range = all.fold(None, |r: Option<(f64, f64)>, v| Some(r.map_or((v, v), |(l, h)| (l.min(v), h.max(v)))));
        let mut rows = vec![vec![f64::NAN; x.count]; y.count];
        map.cells.iter().for_each(|cell| rows[y.place(cell.y)][x.place(cell.x)] = cell.value);
        let figure = StateMap {
            x: (&map.x.0, &map.x.1),
            x_range: x.ends(),
            y: (&map.y.0, &map.y.1),
            y_range: y.ends(),
            force: (&map.quantity, &map.unit),
            range,
            rows,
            visited: (&[], &[]),
        };
        figures.push(figure.draw(&format!("{} that the data ask for over {} and {}", map.quantity, map.x.0, map.y.0)));
    }
    if xs.is_some() {
        figures.extend(profile(map, &map.x, |c| c.x));
    }
    if ys.is_some() {
        figures.extend(profile(map, &map.y, |c| c.y));
    }
    figures
}

/// Equal steps of a coordinate.
struct Steps {
    first: f64,
    step: f64,
    count: usize,
}

impl Steps {
    fn place(&self, value: f64) -> usize {
        (((value - self.first) / self.step).round().max(0.0) as usize).min(self.count - 1)
    }

    fn ends(&self) -> (f64, f64) {
        (self.first - 0.5 * self.step, self.first + (self.count as f64 - 0.5) * self.step)
    }
}

/// Steps of cell centres; `None` where the coordinate does not vary.
fn steps(values: impl Iterator<Item = f64>) -> Option<Steps> {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let fine = 1e-6 * (last - first);
    let step = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > fine).fold(f64::INFINITY, f64::min);
    let count = ((last - first) / step).round() + 1.0;
    (2.0..=1000.0).contains(&count).then_some(Steps { first, step, count: count as usize })
}

/// The law along one coordinate, cells of equal coordinate averaged by their variances.
fn profile(map: &LawMap, axis: &(String, String), along: fn(&discovery::diagnose::LawCell) -> f64) -> Option<Figure> {
    let steps = steps(map.cells.iter().map(along))?;
    let mut sums = vec![[0.0_f64; 2]; steps.count];
    for cell in map.cells.iter().filter(|c| c.value.is_finite() && c.sigma > 0.0 && c.sigma.is_finite()) {
        let weight = 1.0 / (cell.sigma * cell.sigma);
        let sum = &mut sums[steps.place(along(cell))];
        *sum = [sum[0] + weight, sum[1] + weight * cell.value];
    }
    let seen: Vec<usize> = (0..steps.count).filter(|k| sums[*k][0] > 0.0).collect();
    let x: Vec<f64> = seen.iter().map(|k| steps.first + *k as f64 * steps.step).collect();
    let force: Vec<f64> = seen.iter().map(|k| sums[*k][1] / sums[*k][0]).collect();
    let curves = vec![Curve { label: "from the data", role: Role::Measured, x: &x, y: &force }];
    let (low, high) = force.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let claim = format!("{} along {}: from {} to {} {}", map.quantity, axis.0, short(low), short(high), map.unit);
    let figure = Scatter { x: (&axis.0, &axis.1), y: (&map.quantity, &map.unit), curves, band: None };
    (x.len() > 1).then(|| {
        figure
            .draw(&claim)
            .caption("Mean over the other coordinate, if there is one, weighted by the variances of the cells.")
    })
}

/// Angles between what candidates leave in the data; small ones cannot be told apart.
pub fn angles(angles: &Angles) -> Option<Figure> {
    let n = angles.names.len();
    let cosine = |i: usize, j: usize| angles.cosine.get(i).and_then(|row| row.get(j)).copied().unwrap_or(f64::NAN);
    let degrees = |c: f64| libm::acos(c.abs().min(1.0)).to_degrees();
    let values: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if i == j { 0.0 } else { degrees(cosine(i, j)) }).collect()).collect();
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|(i, j)| values[*i][*j].is_finite());
    let (i, j) = pairs.min_by(|a, b| values[a.0][a.1].total_cmp(&values[b.0][b.1]))?;
    let claim = format!(
        "the nearest of the best candidates are {} degrees apart: {} and {}",
        short(values[i][j].round()),
        angles.names[j],
        angles.names[i]
    );
    let figure = Matrix {
        quantity: "angle between effects",
        unit: "deg",
        rows: angles.names.clone(),
        columns: Vec::new(),
        values,
        range: Some((0.0, 90.0)),
    };
    Some(figure.draw(&claim).caption("0: these data cannot tell them apart; 90: they have nothing in common. Behind what the plant's parameters explain."))
}

/// Held-out data with both free runs and their residuals.
pub fn overlays(diagnosis: &Diagnosis) -> Vec<Figure> {
    diagnosis.figures.overlays.iter().take(EACH_MAX).map(|shown| overlay(diagnosis, shown)).collect()
}

fn overlay(diagnosis: &Diagnosis, shown: &Shown) -> Figure {
    let n = shown.time_s.len().min(shown.measured.len());
    let residual = |model: &[f64]| shown.measured.iter().zip(model).map(|(y, m)| y - m).collect::<Vec<f64>>();
    let (e_before, e_after) = (residual(&shown.before), residual(&shown.after));
    let fits = diagnosis.held_out.channels.iter().find(|c| c.name == shown.channel);
    let fit = fits.map(|c| (percent(c.fit_percent_before), percent(c.fit_percent_after)));
    let label = |what: &str, fit: Option<&String>| fit.map_or(what.to_owned(), |fit| format!("{what}, fit {fit} %"));
    let before = label("plant, refitted", fit.as_ref().map(|f| &f.0));
    let after = label("with what was found, refitted", fit.as_ref().map(|f| &f.1));
    let (nb, na) = (shown.before.len().min(n), shown.after.len().min(n));
    let t = &shown.time_s;
    let figure = Overlay {
        quantity: &shown.channel,
        unit: &shown.unit,
        curves: vec![
            Curve { label: "measured", role: Role::Measured, x: &t[..n], y: &shown.measured[..n] },
            Curve { label: &before, role: Role::Before, x: &t[..nb], y: &shown.before[..nb] },
            Curve { label: &after, role: Role::After, x: &t[..na], y: &shown.after[..na] },
        ],
        residual: vec![
            Curve { label: "", role: Role::Before, x: &t[..nb], y: &e_before[..nb] },
            Curve { label: "", role: Role::After, x: &t[..na], y: &e_after[..na] },
        ],
        ..Overlay::default()
    };
    let claim = match fit {
        Some((before, after)) => format!("{}: fit {before} % before, {after} % after, in free run", shown.channel),
        None => format!("{}: measured, and both models in free run", shown.channel),
    };
    figure.draw(&claim).caption("Both models are refitted to the fitted recordings, then frozen; the initial state comes from the first stretch.")
}

/// Names in the order in which they first occur.
fn in_order<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen: Vec<&str> = Vec::new();
    names.for_each(|name| {
        if !seen.contains(&name) {
            seen.push(name);
        }
    });
    seen
}
