//! The page of `obsid doctor`: findings first, then every channel over time and frequency.

use super::{Examined, channels_of, grouped, summary, value_of, words_of};
use crate::recordings::{Loaded, tool};
use channels::{Channel, Uniform};
use examination::doctor::Finding;
use examination::doctor::segments::{Kind, propose};
use examination::spectrum::{Averaging, density};
use identification::statistics::white_floor;
use report::text::short;
use report::{Block, Cell, Curve, Figure, Mark, Overlay, Page, Role, Section, Spectrum, Table};

/// Channels with figures; the tables hold all.
const FIGURES_MAX: usize = 24;

/// The report of `obsid doctor`: a section per recording; figures for the first [`FIGURES_MAX`]
/// channels.
pub fn page(examined: &[Examined], command: &str) -> Page {
    let mut left = FIGURES_MAX;
    let sections = examined.iter().map(|one| section(one, command, &mut left)).collect();
    let mut digests: Vec<(String, String)> =
        examined.iter().map(|e| (e.loaded.file.clone(), e.loaded.digest.clone())).collect();
    digests.dedup();
    let title = match examined {
        [one] => format!("Examination of {}", one.loaded.recording.name),
        several => format!("Examination of {} recordings", several.len()),
    };
    Page { title, verdict: verdict(examined), sections, command: command.into(), digests, tool: tool() }
}

/// Counts, and the worst finding in its own words.
fn verdict(examined: &[Examined]) -> String {
    let all = examined.iter().flat_map(|e| &e.findings);
    let worst = all.reduce(|a, b| if b.severity > a.severity { b } else { a });
    let counted = summary(examined);
    match worst.filter(|f| f.severity > examination::doctor::Severity::Note) {
        Some(f) => format!("{counted}. Worst: {}, {}. Cure: {}.", words_of(f.check), channels_of(f), f.cure),
        None => format!("{counted}."),
    }
}

fn section(one: &Examined, command: &str, left: &mut usize) -> Section {
    let Examined { loaded, findings } = one;
    let mut blocks = vec![Block::Text(format!("{}.", loaded.in_words()))];
    if !loaded.notes.is_empty() {
        blocks.push(Block::List(crate::notes::counted(&loaded.notes)));
    }
    if findings.is_empty() {
        blocks.push(Block::Text("Nothing found.".into()));
    } else {
        let mut table = Table::new("", &["severity", "check", "finding"]);
        for group in grouped(findings) {
            let line = |f: &Finding| format!("{}: {}. {}.", channels_of(f), value_of(f), f.evidence);
            let lines: Vec<String> = group.iter().map(|f| line(f)).collect();
            table.row(vec![
                Cell::Severity(words_of(group[0].severity)),
                Cell::Text(words_of(group[0].check)),
                Cell::Prose(format!("{}\nCure: {}.", lines.join("\n"), group[0].cure)),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    blocks.push(Block::Table(levels(loaded)));
    let marks = segments(loaded);
    for channel in &loaded.recording.channels {
        if *left == 0 {
            let what = format!(
                "Figures stand for the first {FIGURES_MAX} channels; examine fewer recordings at once for the others."
            );
            blocks.push(Block::Text(what));
            break;
        }
        *left -= 1;
        blocks.push(Block::Figure(over_time(channel, one, &marks).command(command)));
        blocks.extend(over_frequency(channel).map(|figure| Block::Figure(figure.command(command))));
    }
    Section::new(&loaded.recording.name, blocks)
}

/// What each channel holds.
fn levels(loaded: &Loaded) -> Table {
    let mut table =
        Table::new("Channels", &["channel", "unit", "role", "samples", "least", "mean", "greatest", "deviation"]);
    for c in &loaded.recording.channels {
        let values: Vec<f64> = c.value.iter().copied().filter(|v| v.is_finite()).collect();
        let (least, greatest) = ends(&values);
        let (mean, rms) = (identification::statistics::mean(&values), identification::statistics::deviation(&values));
        let number = |x: f64| if values.is_empty() { Cell::None } else { Cell::Number(x) };
        table.row(vec![
            c.name.as_str().into(),
            c.unit.as_str().into(),
            Cell::Text(words_of(c.role)),
            Cell::Written(c.value.len().to_string()),
            number(least),
            number(mean),
            number(greatest),
            number(rms),
        ]);
    }
    table
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
}

/// Every second proposed segment and every burst, to be shaded.
fn segments(loaded: &Loaded) -> Vec<Mark> {
    let proposed = propose(&loaded.recording);
    let mark = |s: &examination::doctor::segments::Segment| Mark {
        from: s.start_s,
        to: s.end_s,
        what: format!("{} {} to {} s", words_of(s.kind), short(s.start_s), short(s.end_s)),
    };
    let shown =
        |k: usize, kind: Kind| if proposed.len() > 2 { kind == Kind::Burst || kind == Kind::Quiet } else { k == 1 };
    proposed.iter().enumerate().filter(|(k, s)| shown(*k, s.kind)).map(|(_, s)| mark(s)).collect()
}

fn over_time(channel: &Channel, one: &Examined, marks: &[Mark]) -> Figure {
    let concerned: Vec<String> = grouped(&one.findings)
        .into_iter()
        .filter(|group| group.iter().any(|f| f.channel == channel.name))
        .map(|group| words_of(group[0].check))
        .collect();
    let found = if concerned.is_empty() { "nothing found".into() } else { concerned.join(", ") };
    let (least, greatest) = ends(&channel.value);
    Overlay {
        quantity: &channel.name,
        unit: &channel.unit,
        curves: vec![Curve { label: "measured", role: Role::Measured, x: &channel.time_s, y: &channel.value }],
        marks: marks.to_vec(),
        marks_are: "quiet, burst or next segment",
        ..Overlay::default()
    }
    .draw(&format!("{}: from {} to {} {}; {found}", channel.name, short(least), short(greatest), channel.unit))
}

fn over_frequency(channel: &Channel) -> Option<Figure> {
    let Uniform { value, dt_s, .. } = channel.uniform().filter(|u| u.value.len() >= 64)?;
    let s = density(&value, dt_s, Averaging::for_length(value.len()));
    let lines = 1..s.frequency_hz.len();
    let peak = lines.max_by(|&i, &j| s.density[i].total_cmp(&s.density[j])).filter(|&k| s.density[k] > 0.0)?;
    let nyquist = 0.5 / dt_s;
    let (top, _) = s.band(0.9 * nyquist, 1.01 * nyquist).filter(|(top, _)| *top > 0.0)?;
    let noise = white_floor(&value).filter(|floor| floor.flat).map(|floor| 2.0 * floor.sigma * floor.sigma * dt_s);
    let claim = format!(
        "{}: the spectrum peaks at {} Hz and is {} dB down at the top of its band ({} Hz)",
        channel.name,
        short(s.frequency_hz[peak]),
        short((100.0 * libm::log10(s.density[peak] / top)).round() / 10.0),
        short(nyquist)
    );
    let figure = Spectrum {
        quantity: "power density",
        unit: &format!("({})²/Hz", channel.unit),
        curves: vec![Curve { label: "measured", role: Role::Measured, x: &s.frequency_hz[1..], y: &s.density[1..] }],
        noise,
        ..Spectrum::default()
    };
    Some(figure.draw(&claim))
}
