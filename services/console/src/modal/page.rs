//! The page of `obsid modal`: the modes first, then how they stand out of the orders, their shapes,
//! and what they explain.

use super::{Arguments, FoundMode, Outcome, Synthesis, structure_page};
use crate::recordings::{digest_of, tool};
use examination::spectrum::{Averaging, density};
use modal::record::Record;
use report::{
    Bar, Bars, Block, Cell, Clusters, Curve, Figure, Mark, Mode, Overlay, Page, Pole, Role, Section, Spectrum,
    Stabilisation, Stability, Table,
};

/// Modes with a figure of their shape; the table holds all.
const SHAPES_MAX: usize = 12;

pub(super) fn page(outcome: &Outcome, arguments: &Arguments, command: &str) -> Page {
    let mut sections = vec![modes(outcome)];
    let mut order = Vec::new();
    if let Some(figure) = stabilisation(outcome) {
        order.push(Block::Figure(figure.command(command)));
    }
    if !outcome.sweep.is_empty() {
        order.push(Block::Figure(clusters(outcome).command(command)));
    }
    order.extend(structure_page::singular(outcome).map(|figure| Block::Figure(figure.command(command))));
    if !outcome.rejected.is_empty() {
        order.push(Block::Table(rejected(outcome)));
    }
    if !order.is_empty() {
        sections.push(Section::new("Which poles are modes", order));
    }
    let mut figures: Vec<Block> =
        structure_page::motion(outcome).map(|figure| Block::Figure(figure.command(command))).into_iter().collect();
    if outcome.modes.iter().any(|mode| mode.shape.len() > 1) {
        figures.extend(shapes(outcome, command));
    }
    if !figures.is_empty() {
        sections.push(Section::new("Mode shapes", figures));
    }
    if let Some(matrix) = structure_page::assurance(outcome) {
        let title =
            if outcome.structure.compared.is_some() { "Against the reference" } else { "Shapes against shapes" };
        sections.push(Section::new(title, vec![matrix]));
    }
    if let Some(synthesis) = &outcome.synthesis {
        let figure = synthesised(synthesis).command(command);
        sections.push(Section::new("What the modes explain", vec![Block::Figure(figure)]));
    }
    let files = arguments.files.iter();
    Page {
        title: "Modes of a recording".into(),
        verdict: verdict(outcome),
        sections,
        command: command.into(),
        digests: files.map(|file| (file.display().to_string(), digest_of(file))).collect(),
        tool: tool(),
    }
}

fn verdict(outcome: &Outcome) -> String {
    let first = outcome
        .modes
        .iter()
        .take(6)
        .map(|mode| format!("{} Hz", super::words::estimate(Some(mode.frequency_hz), mode.frequency_sd)));
    let listed = first.collect::<Vec<_>>().join(", ");
    match outcome.modes.len() {
        0 => "No modes were found.".into(),
        1 => format!("One mode: {listed}."),
        n => format!("{n} modes: {listed}{}.", if n > 6 { ", …" } else { "" }),
    }
}

fn modes(outcome: &Outcome) -> Section {
    let mut table = Table::new("Modes", &["mode", "frequency [Hz]", "damping [%]", "MPC"]);
    let cell = |value: Option<f64>, sigma: Option<f64>| match (value, sigma) {
        (Some(value), Some(sigma)) if sigma > 0.0 => Cell::Estimate(value, sigma),
        (Some(value), _) => Cell::Number(value),
        (None, _) => Cell::None,
    };
    for (k, mode) in outcome.modes.iter().enumerate() {
        table.row(vec![
            Cell::Text((k + 1).to_string()),
            cell(Some(mode.frequency_hz), mode.frequency_sd),
            cell(mode.damping.map(|z| 100.0 * z), mode.damping_sd.map(|z| 100.0 * z)),
            mode.phase_collinearity.into(),
        ]);
    }
    let said = format!(
        "{}. Method: {}. These are {}. Standard deviations: {}.",
        outcome.record, outcome.method, outcome.kind, outcome.deviations
    );
    let mut blocks = vec![Block::Text(said), Block::Table(table)];
    let lines: Vec<String> = outcome.advice.iter().cloned().chain(crate::notes::counted(&outcome.notes)).collect();
    if !lines.is_empty() {
        blocks.push(Block::List(lines));
    }
    Section::new("Modes", blocks)
}

fn stabilisation(outcome: &Outcome) -> Option<Figure> {
    let (x, y) = outcome.spectrum.as_ref()?;
    let poles = outcome.sweep.iter().map(|pole| Pole {
        order: pole.order as f64,
        frequency_hz: pole.frequency_hz,
        stability: pole.stability,
    });
    let chosen_hz: Vec<f64> = outcome.modes.iter().map(|mode| mode.frequency_hz).collect();
    if outcome.sweep.is_empty() {
        let bands = chosen_hz.iter().map(|f| Mark { from: *f, to: *f, what: "mode".into() }).collect();
        let curves = vec![Curve { label: "measured", role: Role::Measured, x, y }];
        let figure = Spectrum { quantity: "magnitude", unit: "", curves, bands, bands_are: "mode", noise: None };
        return Some(figure.draw(&format!("{} peaks stand above the floor", chosen_hz.len())));
    }
    let stable = outcome.sweep.iter().filter(|pole| pole.stability == Stability::All).count();
    let spectrum = Some(Curve { label: "spectrum", role: Role::Before, x, y });
    let claim = format!(
        "{} modes; {stable} of {} poles repeat in frequency, damping and shape",
        chosen_hz.len(),
        outcome.sweep.len()
    );
    let figure = Stabilisation { poles: poles.collect(), spectrum, chosen_hz }.draw(&claim);
    Some(figure.caption("Stable from one order to the next: 1 % in frequency, 30 % in damping, MAC 0.95."))
}

fn clusters(outcome: &Outcome) -> Figure {
    let frequency: Vec<f64> = outcome.sweep.iter().map(|pole| pole.frequency_hz).collect();
    let damping: Vec<f64> = outcome.sweep.iter().map(|pole| pole.damping_ratio).collect();
    let mode = |(k, mode): (usize, &FoundMode)| Mode {
        name: (k + 1).to_string(),
        frequency_hz: mode.frequency_hz,
        frequency_sigma_hz: mode.frequency_sd.unwrap_or(0.0),
        damping_ratio: mode.damping.unwrap_or(0.0),
        damping_sigma: mode.damping_sd.unwrap_or(0.0),
    };
    let modes = outcome.modes.iter().enumerate().map(mode).collect();
    Clusters { pole_frequency_hz: &frequency, pole_damping_ratio: &damping, modes }
        .draw("Poles of all orders gather at the modes")
}

fn rejected(outcome: &Outcome) -> Table {
    let mut table = Table::new("Poles left out", &["reason", "poles"]);
    for (reason, count) in &outcome.rejected {
        table.row(vec![Cell::Prose(reason.clone()), Cell::Number(*count as f64)]);
    }
    table
}

fn shapes(outcome: &Outcome, command: &str) -> Vec<Block> {
    let figure = |(k, mode): (usize, &FoundMode)| {
        let sd = (0..mode.shape.len()).map(|k| mode.shape_sd.get(k).copied().unwrap_or(modal::c64::new(0.0, 0.0)));
        let bars = outcome.channels.iter().zip(&mode.shape).zip(sd).map(|((channel, psi), sd)| Bar {
            label: channel.clone(),
            value: psi.re,
            interval: (psi.re - sd.re, psi.re + sd.re),
            role: Role::After,
            note: if psi.im.abs() > 0.05 { format!("imaginary {:.2}", psi.im) } else { String::new() },
        });
        let bars = Bars { quantity: "component", unit: "-", bars: bars.collect(), reference: None, from_zero: true };
        let collinear = mode.phase_collinearity.map_or(String::new(), |mpc| format!(", phase collinearity {mpc:.3}"));
        let claim = format!("Mode {} at {:.4} Hz{collinear}", k + 1, mode.frequency_hz);
        Block::Figure(
            bars.draw(&claim)
                .caption("Largest component 1; lines over one standard deviation, where it is known.")
                .command(command),
        )
    };
    let shaped = outcome.modes.iter().enumerate().filter(|(_, mode)| !mode.shape.is_empty());
    shaped.take(SHAPES_MAX).map(figure).collect()
}

fn synthesised(synthesis: &Synthesis) -> Figure {
    let Synthesis { channel, unit, x, measured, modelled, .. } = synthesis;
    let residual: Vec<f64> = measured.iter().zip(modelled).map(|(y, m)| y - m).collect();
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let power = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let fit = 100.0 * (1.0 - power(&mut residual.iter().copied()) / power(&mut measured.iter().map(|y| y - mean)));
    let claim = format!("The modes explain {fit:.2} % of {channel}");
    let curves = vec![
        Curve { label: "measured", role: Role::Measured, x, y: measured },
        Curve { label: "synthesised", role: Role::After, x, y: modelled },
    ];
    if synthesis.over_frequency {
        return Spectrum { quantity: "response", unit, curves, ..Spectrum::default() }.draw(&claim);
    }
    let residual = vec![Curve { label: "residual", role: Role::After, x, y: &residual }];
    Overlay { quantity: channel, unit, curves, residual, ..Overlay::default() }.draw(&claim)
}

/// Spectral density of all channels together.
pub(super) fn density_of(record: &Record) -> (Vec<f64>, Vec<f64>) {
    let (mut frequency_hz, mut sum): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    if record.samples() < 8 {
        return (frequency_hz, sum);
    }
    for channel in 0..record.channels {
        let y: Vec<f64> = record.outputs.iter().skip(channel).step_by(record.channels).copied().collect();
        let found = density(&y, 1.0 / record.sample_rate_hz, Averaging::for_length(y.len()));
        sum.resize(found.density.len(), 0.0);
        sum.iter_mut().zip(&found.density).for_each(|(sum, x)| *sum += x);
        frequency_hz = found.frequency_hz;
    }
    (frequency_hz, sum)
}
