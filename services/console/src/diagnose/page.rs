//! The page of a diagnosis: the verdict for who reads one paragraph, then the figures, then every
//! number.

use super::answer::answer;
use super::names::{in_titles, named, site_in_words, unit};
use super::paragraph::{details_paragraph, gain_words, held_out_words, not_found, percent, verdict_words};
use super::words::status_words;
use super::{Diagnosed, figures, summary};
use crate::doctor::{channels_of, value_of, words_of};
use crate::notes::counted;
use crate::recordings::{Loaded, tool};
use discovery::diagnose::Diagnosis;
use examination::doctor::{p_value, probability};
use identification::held_out::Status;
use report::{Block, Cell, Figure, Page, Section, Table};

/// Files that a diagnosis has, as text.
#[derive(Default)]
pub struct Texts<'a> {
    pub augmented: Option<&'a str>,
    pub next: Option<&'a str>,
}

/// The report of `obsid diagnose`: answer, effects, figures, parameters, detection limits and
/// digests of what was read.
pub fn page(diagnosed: &Diagnosed, texts: &Texts<'_>) -> Page {
    let Diagnosed { case, diagnosis, .. } = diagnosed;
    let mut sections = vec![found(diagnosed), missing(diagnosis), shown(diagnosis), places(diagnosis)];
    sections.push(Section::new("Parameters of the plant", nominal(diagnosis)));
    sections.push(Section::new("What could not be seen", limits(diagnosis)));
    sections.push(Section::new("Next", next(diagnosed, texts)));
    sections.push(Section::new("Recordings", recordings(diagnosed)));
    sections.retain(|section| !section.blocks.is_empty());
    for section in &mut sections {
        for block in &mut section.blocks {
            if let Block::Figure(figure) = block {
                figure.command.clone_from(&case.command);
            }
        }
    }
    let loaded = case.fitted.iter().chain(&case.held_out);
    let mut digests: Vec<(String, String)> = loaded.map(|l| (l.file.clone(), l.digest.clone())).collect();
    digests.extend(case.spectra.iter().map(|(spectrum, digest)| (spectrum.file.clone(), digest.clone())));
    digests.extend(case.modes.iter().map(|modes| (modes.file.clone(), modes.digest.clone())));
    digests.dedup();
    digests.push((case.plant_file.clone(), case.plant_digest.clone()));
    let files = case.fitted.iter().map(|l| l.recording.name.as_str());
    let files = files.chain(case.spectra.iter().map(|(s, _)| s.file.as_str()));
    let files: Vec<&str> = files.chain(case.modes.iter().map(|modes| modes.file.as_str())).collect();
    let what = if files.len() > 3 { format!("{} recordings", files.len()) } else { files.join(", ") };
    Page {
        title: format!("{what} against {}: {}", case.plant_file, verdict_words(diagnosis.verdict)),
        verdict: answer(diagnosed).join(" "),
        sections,
        command: case.command.clone(),
        digests,
        tool: tool(),
    }
}

fn all(figures: Vec<Figure>) -> impl Iterator<Item = Block> {
    figures.into_iter().map(Block::Figure)
}

/// The one table of the answer, and the sentences behind it, folded.
fn found(diagnosed: &Diagnosed) -> Section {
    let mut table = Table::new("", &summary::COLUMNS);
    for row in summary::rows(diagnosed) {
        table.row(
            row.into_iter().map(|cell| if cell.is_empty() { Cell::Text(cell) } else { Cell::Prose(cell) }).collect(),
        );
    }
    let mut blocks = Vec::new();
    if !table.rows.is_empty() {
        blocks.push(Block::Table(table));
    }
    let details = details_paragraph(&diagnosed.diagnosis, &diagnosed.case.plant);
    if !details.is_empty() {
        blocks.push(Block::Details { summary: "Behind the answer".into(), blocks: vec![Block::Text(details)] });
    }
    Section::new("Effects", blocks)
}

/// Effects, rivals, what they do: evidence, force, angles.
fn missing(diagnosis: &Diagnosis) -> Section {
    let mut blocks = Vec::new();
    if !diagnosis.effects.is_empty() {
        let tables = [Some(effects(diagnosis)), rivals(diagnosis)].into_iter().flatten().map(Block::Table).collect();
        blocks.push(Block::Details { summary: "Effects and rivals in full".into(), blocks: tables });
    }
    blocks.extend(figures::evidence(diagnosis).map(Block::Figure));
    blocks.extend(all(figures::laws(diagnosis)));
    blocks.extend(figures::angles(&diagnosis.figures.angles).map(Block::Figure));
    Section::new("What is missing", blocks)
}

fn effects(diagnosis: &Diagnosis) -> Table {
    let columns =
        ["effect", "probability", "held-out data", "parameter", "value", "standard errors from zero", "collinear [%]"];
    let mut table = Table::new("Effects", &columns);
    for effect in &diagnosis.effects {
        let probability = match effect.status {
            Status::NotConverged => Cell::None,
            _ => Cell::Written(format!("{:.2}", effect.probability)),
        };
        let first = [
            Cell::Prose(format!("{}\n{} at {}", effect.title, effect.kind, effect.site)),
            probability,
            status_words(effect.status).into(),
        ];
        let last = [Cell::Number(effect.d), Cell::Number(100.0 * effect.kappa)];
        let numbers = effect.parameters.iter().map(|p| {
            let name = if unit(&p.unit).is_empty() {
                p.name.clone()
            } else {
                format!("{} [{}]", p.name, unit(&p.unit).trim())
            };
            [Cell::Text(name), Cell::Estimate(p.value, p.sigma)]
        });
        let mut numbers: Vec<[Cell; 2]> = numbers.collect();
        if numbers.is_empty() {
            numbers.push([Cell::None, Cell::None]);
        }
        for (k, number) in numbers.into_iter().enumerate() {
            let row = if k == 0 {
                [first.to_vec(), number.to_vec(), last.to_vec()]
            } else {
                [vec![Cell::None; 3], number.to_vec(), vec![Cell::None; 2]]
            };
            table.row(row.concat());
        }
    }
    table
}

fn rivals(diagnosis: &Diagnosis) -> Option<Table> {
    let mut table = Table::new("Rivals, and what rules them out", &["instead of", "rival", "probability", "why"]);
    for effect in &diagnosis.effects {
        for rival in &effect.rivals {
            table.row(vec![
                Cell::Text(named(&effect.kind, &effect.site)),
                Cell::Text(named(&rival.kind, &rival.site)),
                Cell::Written(format!("{:.2}", rival.probability)),
                Cell::Prose(rival.reason.clone()),
            ]);
        }
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Before and after on held-out data, else of the fitted recordings.
fn shown(diagnosis: &Diagnosis) -> Section {
    let mut blocks = Vec::new();
    let held = &diagnosis.held_out;
    if let Some(on) = held_out_words(held.kind) {
        blocks.push(Block::Text(format!("In free run on {on}, parameters frozen.")));
        let columns = ["channel", "fit before [%]", "fit after [%]", "rms before", "rms after"];
        let mut table = Table::new("Held out", &columns);
        for c in &held.channels {
            table.row(vec![
                c.name.as_str().into(),
                Cell::Written(percent(c.fit_percent_before)),
                Cell::Written(percent(c.fit_percent_after)),
                Cell::Number(c.rms_before),
                Cell::Number(c.rms_after),
            ]);
        }
        blocks.push(Block::Table(table));
        blocks.extend(gain_words(diagnosis).map(|gain| Block::Text(format!("On these data: {gain}."))));
        if let (Some(before), Some(after)) = (held.whiteness_p_before, held.whiteness_p_after) {
            let text = format!("Innovations white: {} before, {} after.", probability(before), probability(after));
            blocks.push(Block::Text(text));
        }
    }
    if !diagnosis.compare.channels.is_empty() {
        let mut table =
            Table::new("The plant, refitted, in free run on what was fitted", &["channel", "rms", "fit [%]"]);
        for c in &diagnosis.compare.channels {
            table.row(vec![c.name.as_str().into(), Cell::Number(c.rms), Cell::Written(percent(c.fit_percent))]);
        }
        blocks.push(Block::Table(table));
    }
    blocks.extend(all(figures::overlays(diagnosis)));
    Section::new("How well it fits", blocks)
}

fn places(diagnosis: &Diagnosis) -> Section {
    let mut blocks = Vec::new();
    if !diagnosis.located.is_empty() {
        let mut table =
            Table::new("Places", &["channel", "site", "from [s]", "to [s]", "from [Hz]", "to [Hz]", "states", "p"]);
        for place in &diagnosis.located {
            table.row(vec![
                place.channel.as_str().into(),
                Cell::Text(site_in_words(&place.site)),
                Cell::Number(place.time[0]),
                Cell::Number(place.time[1]),
                Cell::Number(place.band_hz[0]),
                Cell::Number(place.band_hz[1]),
                Cell::Text(place.states.join(", ")),
                Cell::Text(p_value(place.p)),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    blocks.extend(all(figures::tiles(diagnosis)));
    Section::new("Where it shows", blocks)
}

fn nominal(diagnosis: &Diagnosis) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !diagnosis.nominal.is_empty() {
        let mut table =
            Table::new("Estimated together with the effects", &["parameter", "before", "after", "shift [sd]"]);
        for n in &diagnosis.nominal {
            table.row(vec![
                n.name.as_str().into(),
                Cell::Number(n.before),
                Cell::Estimate(n.after, n.sigma),
                Cell::Number(n.shift_sigma),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    if !diagnosis.not_found.is_empty() {
        blocks.push(Block::Text(format!("These data do not determine: {}.", diagnosis.not_found.join(", "))));
    }
    blocks
}

fn limits(diagnosis: &Diagnosis) -> Vec<Block> {
    let limits = not_found(diagnosis);
    if limits.is_empty() {
        return Vec::new();
    }
    let mut table = Table::new("", &["effect", "found from", "unit"]);
    for limit in &limits {
        table.row(vec![
            Cell::Text(named(&limit.kind, &limit.site)),
            Cell::Number(limit.amplitude),
            Cell::Text(unit(&limit.unit).trim().to_owned()),
        ]);
    }
    let count = limits.len();
    vec![
        Block::Text("What was not found may be there below these sizes.".into()),
        Block::Details { summary: format!("Detection limits ({count})"), blocks: vec![Block::Table(table)] },
    ]
}

fn next(Diagnosed { case, diagnosis, .. }: &Diagnosed, texts: &Texts<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    if let (Some(path), Some(text)) = (&diagnosis.next_experiment, texts.next) {
        blocks.push(Block::Text(format!("The experiment that would decide is {path}.")));
        blocks.push(Block::Details { summary: "Its TOML".into(), blocks: vec![Block::Listing(text.to_owned())] });
    }
    if let Some(path) = &diagnosis.augmented_plant {
        blocks.push(Block::Text(format!("The plant with what was confirmed is {path}; these show its fit:")));
        blocks.extend(case.commands_of_the_fit(path).into_iter().map(Block::Command));
        let toml = texts.augmented.map(|text| Block::Listing(text.to_owned()));
        blocks.extend(toml.map(|text| Block::Details { summary: "Its TOML".into(), blocks: vec![text] }));
    }
    blocks
}

fn recordings(diagnosed: &Diagnosed) -> Vec<Block> {
    let case = &diagnosed.case;
    let line = |what: &str, l: &Loaded| format!("{what}{}: {}", l.recording.name, l.in_words());
    let mut lines: Vec<String> = Vec::new();
    for (what, loaded) in [("", &case.fitted), ("held out: ", &case.held_out)] {
        for one in loaded {
            lines.push(line(what, one));
            lines.extend(counted(&one.notes).iter().map(|note| format!("{}: {note}", one.recording.name)));
        }
    }
    lines
        .extend(case.spectra.iter().map(|(s, _)| format!("{}: {} lines over frequency", s.file, s.frequency_hz.len())));
    lines.extend(
        case.modes.iter().map(|m| format!("{}: {} modes, {} through its parts", m.file, m.modes.len(), m.tracks.len())),
    );
    lines.extend(counted(&diagnosed.diagnosis.notes).iter().map(|note| in_titles(note)));
    let mut blocks = vec![Block::List(lines)];
    if !diagnosed.findings.is_empty() {
        let mut table = Table::new("Examined before any model", &["severity", "check", "recording", "finding"]);
        for (of, f) in &diagnosed.findings {
            table.row(vec![
                Cell::Severity(words_of(f.severity)),
                Cell::Text(words_of(f.check)),
                case.fitted[*of].recording.name.as_str().into(),
                Cell::Prose(format!("{}: {}. {}.\nCure: {}.", channels_of(f), value_of(f), f.evidence, f.cure)),
            ]);
        }
        blocks.push(Block::Table(table));
    }
    blocks
}

#[cfg(test)]
mod tests;
