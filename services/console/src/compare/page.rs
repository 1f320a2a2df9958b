//! The page of `obsid compare`: the table first, then every channel over time and the spectrum of
//! what is left.

use super::{Compared, alternatives, percent, verdict_words};
use crate::recordings::tool;
use channels::{Channel, common_grid};
use examination::compare::{ChannelComparison, Verdict};
use examination::doctor::p_value;
use examination::spectrum::{Averaging, density};
use report::text::short;
use report::{Block, Cell, Curve, Figure, Mark, Overlay, Page, Role, Section, Spectrum, Table};

/// Channels with figures; the tables hold all.
const FIGURES_MAX: usize = 24;

/// The report of `obsid compare` as one page: a section per pair of recordings, with figures of the
/// first [`FIGURES_MAX`] channels.
pub fn page(compared: &[Compared], command: &str) -> Page {
    let mut left = FIGURES_MAX;
    let sections = compared.iter().map(|one| section(one, command, &mut left)).collect();
    let first = &compared[0];
    let digests = [&first.real, &first.simulated].map(|l| (l.file.clone(), l.digest.clone())).to_vec();
    let title = format!("{} against {}", first.real.file, first.simulated.file);
    Page { title, verdict: verdict(compared), sections, command: command.into(), digests, tool: tool() }
}

/// The channel that fits worst, in its own words, and how many there are besides.
fn verdict(compared: &[Compared]) -> String {
    let all: Vec<&ChannelComparison> = compared.iter().flat_map(|c| &c.result.channels).collect();
    let quiet = |c: &&&ChannelComparison| matches!(c.verdict, Verdict::Identical | Verdict::OnlyNoise);
    let same = all.iter().filter(quiet).count();
    let judged = all.iter().filter(|c| !quiet(c) && c.verdict.compared());
    let worst =
        judged.min_by(|a, b| a.fit_percent.unwrap_or(f64::INFINITY).total_cmp(&b.fit_percent.unwrap_or(f64::INFINITY)));
    let differ = all.len() - same - all.iter().filter(|c| !c.verdict.compared()).count();
    match worst {
        None if same == all.len() => format!("Nothing but noise separates the two in all {} channels.", all.len()),
        None => {
            let lost = all.iter().filter(|c| !c.verdict.compared());
            let sentences: Vec<String> = lost.map(|c| format!("{} {}", c.name, c.conclusion)).collect();
            format!("{}.", sentences.join(". "))
        }
        Some(c) => {
            let fit = c.fit_percent.map_or(String::new(), |f| format!(" (fit {f:.1} %)"));
            format!(
                "{differ} of {} channels differ by more than noise. Worst: {}{fit} {}.",
                all.len(),
                c.name,
                c.conclusion
            )
        }
    }
}

fn section(one: &Compared, command: &str, left: &mut usize) -> Section {
    let mut blocks =
        vec![Block::Text(format!("Real: {}. Simulated: {}.", one.real.in_words(), one.simulated.in_words()))];
    let notes: Vec<String> = one.real.notes.iter().chain(&one.simulated.notes).cloned().collect();
    if !notes.is_empty() {
        blocks.push(Block::List(crate::notes::counted(&notes)));
    }
    blocks.push(Block::Table(overview(one)));
    if !one.result.unmatched.is_empty() {
        let line = |u: &examination::compare::Unmatched| format!("only {}: {}", u.side, u.name);
        blocks.push(Block::List(one.result.unmatched.iter().map(line).collect()));
    }
    for c in &one.result.channels {
        let of = |channels: &[Channel]| channels.iter().find(|x| x.name.eq_ignore_ascii_case(&c.name)).cloned();
        let (Some(real), Some(simulated)) = (of(&one.real.recording.channels), of(&one.simulated.recording.channels))
        else {
            continue;
        };
        if *left == 0 {
            blocks.push(Block::Text(format!("Figures stand for the first {FIGURES_MAX} channels.")));
            break;
        }
        *left -= 1;
        blocks.extend(figures(c, &real, &simulated).into_iter().map(|figure| Block::Figure(figure.command(command))));
        blocks.push(Block::Details { summary: format!("{}: explanations and places", c.name), blocks: places(c) });
    }
    Section::new(&one.real.recording.name, blocks)
}

fn overview(one: &Compared) -> Table {
    let mut table = Table::new(
        "Channels",
        &["channel", "samples", "rms of the difference", "unit", "fit [%]", "verdict", "conclusion"],
    );
    for c in &one.result.channels {
        table.row(vec![
            c.name.as_str().into(),
            Cell::Written(c.samples.to_string()),
            Cell::Number(c.rms),
            c.unit.as_str().into(),
            c.fit_percent.map_or(Cell::None, |fit| Cell::Written(format!("{fit:.1}"))),
            Cell::Text(verdict_words(c.verdict).into()),
            Cell::Prose(c.conclusion.clone()),
        ]);
    }
    table
}

fn figures(c: &ChannelComparison, real: &Channel, simulated: &Channel) -> Vec<Figure> {
    let Some((r, s)) = common_grid(real, simulated, 32) else { return Vec::new() };
    let time: Vec<f64> = (0..r.value.len()).map(|i| r.time_s(i)).collect();
    let error: Vec<f64> = r.value.iter().zip(&s.value).map(|(r, s)| r - s).collect();
    let windows = c.windows.iter().map(|w| Mark {
        from: w.start_s,
        to: w.end_s,
        what: format!(
            "{} to {} s: {} % of the squared difference",
            short(w.start_s),
            short(w.end_s),
            short(100.0 * w.share)
        ),
    });
    let overlay = Overlay {
        quantity: &c.name,
        unit: &c.unit,
        curves: vec![
            Curve { label: "real", role: Role::Measured, x: &real.time_s, y: &real.value },
            Curve { label: "simulated", role: Role::After, x: &simulated.time_s, y: &simulated.value },
        ],
        residual: vec![Curve { label: "", role: Role::After, x: &time, y: &error }],
        marks: if c.windows.iter().all(|w| w.confined) { windows.collect() } else { Vec::new() },
        marks_are: "window of disagreement",
        ..Overlay::default()
    };
    let fit = c.fit_percent.map_or(String::new(), |fit| format!(" (fit {fit:.1} %)"));
    let over_time = overlay.draw(&format!("{}{fit}: {}", c.name, c.conclusion));
    let (p, e) = [&r.value, &error].map(|v| density(v, r.dt_s, Averaging::for_length(v.len()))).into();
    let bands = c.bands.iter().map(|b| Mark {
        from: b.low_hz,
        to: b.high_hz,
        what: format!("{} to {} Hz", short(b.low_hz), short(b.high_hz)),
    });
    let claim = match c.bands.first() {
        Some(b) => format!(
            "{}: the difference stands {} dB above its noise between {} and {} Hz",
            c.name,
            short(b.above_db),
            short(b.low_hz),
            short(b.high_hz)
        ),
        None => format!("{}: the spectrum of the difference is that of noise", c.name),
    };
    let spectrum = Spectrum {
        quantity: "power density",
        unit: &format!("({})²/Hz", c.unit),
        curves: vec![
            Curve { label: "real", role: Role::Measured, x: &p.frequency_hz[1..], y: &p.density[1..] },
            Curve { label: "difference", role: Role::After, x: &e.frequency_hz[1..], y: &e.density[1..] },
        ],
        bands: bands.collect(),
        bands_are: "band of disagreement",
        noise: c.noise_sigma.map(|sigma| 2.0 * sigma * sigma * r.dt_s),
    };
    vec![over_time, spectrum.draw(&claim)]
}

/// Explanations tried alone, and the places of the difference.
fn places(c: &ChannelComparison) -> Vec<Block> {
    let mut tried = Table::new("Explanations, each alone", &["explanation", "value", "unit", "fit with it [%]"]);
    for a in alternatives(c) {
        let value = a.sigma.map_or(Cell::Number(a.value), |sigma| Cell::Estimate(a.value, sigma));
        tried.row(vec![a.what.into(), value, a.unit.trim().into(), Cell::Written(percent(a.fit))]);
    }
    let mut blocks = vec![Block::Table(tried)];
    if !c.windows.is_empty() || !c.bands.is_empty() {
        let mut table = Table::new(
            "Places",
            &["where", "rms", "unit", "share of the squared difference [%]", "above the noise [dB]", "p"],
        );
        let p = |p: f64| Cell::Text(p_value(p));
        for w in &c.windows {
            let place = format!("{} to {} s", short(w.start_s), short(w.end_s));
            table.row(vec![
                Cell::Text(place),
                Cell::Number(w.rms),
                c.unit.as_str().into(),
                Cell::Number(100.0 * w.share),
                Cell::None,
                p(w.p),
            ]);
        }
        for b in &c.bands {
            let place = format!("{} to {} Hz", short(b.low_hz), short(b.high_hz));
            table.row(vec![
                Cell::Text(place),
                Cell::Number(b.rms),
                c.unit.as_str().into(),
                Cell::None,
                Cell::Number(b.above_db),
                p(b.p),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    if !c.coherence.is_empty() {
        let mut table = Table::new(
            "What the difference follows",
            &["channel", "from [Hz]", "to [Hz]", "coherence", "by chance", "share [%]"],
        );
        for k in &c.coherence {
            table.row(vec![
                k.channel.as_str().into(),
                Cell::Number(k.low_hz),
                Cell::Number(k.high_hz),
                Cell::Number(k.coherence),
                Cell::Number(k.level),
                Cell::Number(100.0 * k.share),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    blocks.push(Block::Text(format!("Stamps: {}.", c.resampling)));
    blocks
}
