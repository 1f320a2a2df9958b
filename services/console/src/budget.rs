//! `obsid budget`: what every partition takes of the computer in real time, beside what it may
//! take.

use crate::{Failure, flight, interrupt, run};
use runtime::config::PartitionLimits;
use runtime::statistics::PartitionRow;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Measure each partition in real time against its budget
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid budget                                     the short scenario in real time (about 45 s)
  obsid budget deploy/scenarios/default.toml --seconds 60 --md
  obsid budget --partitions my.toml --json         against budgets of your own

Budgets are in deploy/partitions.toml: period_ms, runtime_us, deadline_ms, memory_mb, descriptors. Figures are over all
lives of a partition. Exit code 1 when a budget is exceeded.")]
pub struct Arguments {
    /// Scenario file; without one the benchmark's short one (deploy/scenarios/short.toml, built in)
    scenario: Option<PathBuf>,
    /// Ends after this time; without it with the scenario
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Table of limits and budgets; without it deploy/partitions.toml, built in
    #[arg(long, value_name = "FILE")]
    partitions: Option<PathBuf>,
    /// One JSON object on standard output, all else on standard error
    #[arg(long, conflicts_with = "md")]
    json: bool,
    /// The table in Markdown
    #[arg(long)]
    md: bool,
}

/// One budget: what it is of, what was used, what may be.
struct Line {
    name: &'static str,
    used: f64,
    budget: Option<f64>,
}

impl Line {
    /// What is left of the budget [%].
    fn margin_percent(&self) -> Option<f64> {
        self.budget.map(|budget| 100.0 * (budget - self.used) / budget)
    }
}

/// Flies in real time and compares.
///
/// # Errors
/// [`Failure::Run`] when a budget is exceeded, [`Failure::Input`] for files that cannot be used.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let interrupted = interrupt::flag()?;
    let mut common = run::Common::default();
    common.partitions.clone_from(&arguments.partitions);
    let scenario = flight::in_real_time(arguments.scenario.as_deref(), &common)?;
    let limits = scenario.config.limits.clone();
    let seconds = arguments.seconds.unwrap_or(f64::INFINITY);
    if seconds.is_nan() || seconds < 2.0 {
        return Err(Failure::Input(miette::miette!(
            help = "give 2 or more: the first second is the start",
            "--seconds {seconds}"
        )));
    }
    let end = flight::fly(scenario, seconds, &interrupted)?;
    let of = |row: &PartitionRow| limits.partitions.iter().find(|own| own.name.text() == row.name).cloned();
    let rows: Vec<(PartitionRow, Vec<Line>)> = end
        .rows
        .into_iter()
        .map(|row| {
            let lines = of(&row).map_or_else(Vec::new, |own| lines(&row, &own));
            (row, lines)
        })
        .collect();
    let flown_s = rows.iter().map(|(row, _)| row.wall_s).fold(0.0, f64::max);
    let text = match (arguments.json, arguments.md) {
        (true, _) => format!("{}\n", object(flown_s, &rows)),
        (_, true) => table(flown_s, &rows, " | "),
        _ => table(flown_s, &rows, "  "),
    };
    crate::print(&text);
    let over: Vec<String> = rows.iter().filter(|(_, lines)| exceeded(lines).is_some()).map(verdict_of).collect();
    if over.is_empty() { Ok(()) } else { Err(Failure::Run(format!("budget exceeded: {}", over.join("; ")))) }
}

fn verdict_of((row, lines): &(PartitionRow, Vec<Line>)) -> String {
    format!("{}: {}", row.name, verdict(lines))
}

fn lines(row: &PartitionRow, own: &PartitionLimits) -> Vec<Line> {
    let share = own.period_ms.zip(own.runtime_us).map(|(period_ms, runtime_us)| 0.1 * runtime_us / period_ms);
    let mb = row.usage.rss_max_kb as f64 / 1024.0;
    vec![
        Line { name: "cpu_percent", used: cpu_percent(row), budget: share },
        Line { name: "memory_mb", used: mb, budget: own.memory_mb },
        Line {
            name: "descriptors",
            used: row.usage.descriptors as f64,
            budget: own.descriptors.map(|most| most as f64),
        },
    ]
}

/// Behind the start, which no period pays for.
fn cpu_percent(row: &PartitionRow) -> f64 {
    100.0 * row.cpu_s / row.wall_s.max(1e-3)
}

fn wait_percent(row: &PartitionRow) -> f64 {
    100.0 * row.usage.wait_s / row.wall_s.max(1e-3)
}

/// The smallest of all margins.
fn margin_percent(lines: &[Line]) -> Option<f64> {
    lines.iter().filter_map(Line::margin_percent).min_by(f64::total_cmp)
}

fn exceeded(lines: &[Line]) -> Option<&Line> {
    lines.iter().find(|line| line.margin_percent().is_some_and(|margin| margin < 0.0))
}

fn verdict(lines: &[Line]) -> String {
    match (exceeded(lines), margin_percent(lines)) {
        (Some(line), _) => format!("over: {} {:.2} of {}", line.name, line.used, line.budget.unwrap_or(0.0)),
        (None, Some(_)) => "within".into(),
        (None, None) => "no budget".into(),
    }
}

fn object(flown_s: f64, rows: &[(PartitionRow, Vec<Line>)]) -> Value {
    let partition = |(row, lines): &(PartitionRow, Vec<Line>)| {
        let (times, usage) = (&row.times, &row.usage);
        json!({
            "name": row.name, "restarts": row.restarts,
            "cpu_run_percent": cpu_percent(row), "cpu_wait_percent": wait_percent(row),
            "start_cpu_ms": 1e3 * row.start_cpu_s,
            "frame_us": {
                "p50": times.frame.percentile_us(0.5), "p99": times.frame.percentile_us(0.99),
                "p999": times.frame.percentile_us(0.999), "max": times.frame.max_us(),
            },
            "frames": row.frames, "deadline_misses": times.deadline_misses,
            "jitter_us_p99": times.jitter.percentile_us(0.99),
            "rss_mb": usage.rss_kb as f64 / 1024.0, "rss_max_mb": usage.rss_max_kb as f64 / 1024.0,
            "stack_kb": usage.stack_kb, "descriptors": usage.descriptors,
            "minor_faults": usage.minor_faults, "major_faults": usage.major_faults,
            "voluntary_switches": usage.voluntary_switches, "involuntary_switches": usage.involuntary_switches,
            "allocations_after_start": row.allocations_after_start,
            "bytes_sent_per_s": row.bytes_sent as f64 / row.wall_s.max(1e-3),
            "margin_percent": margin_percent(lines), "verdict": verdict(lines),
        })
    };
    json!({
        "seconds": flown_s,
        "partitions": rows.iter().map(partition).collect::<Vec<_>>(),
        "sum_cpu_percent": sum_percent(rows),
    })
}

fn sum_percent(rows: &[(PartitionRow, Vec<Line>)]) -> f64 {
    rows.iter().map(|(row, _)| cpu_percent(row)).sum()
}

/// Columns between `bar`s: Markdown with ` | `.
fn table(flown_s: f64, rows: &[(PartitionRow, Vec<Line>)], bar: &str) -> String {
    let is_markdown = bar.contains('|');
    let head =
        ["partition", "CPU %", "wait %", "frame p50 [us]", "p99", "max", "misses", "jitter p99 [us]", "RSS [MB]"];
    let more = ["start CPU [ms]", "fd", "faults", "switches", "allocations", "kB/s", "margin %", "verdict"];
    let head: Vec<String> = head.into_iter().chain(more).map(String::from).collect();
    let mut cells = vec![head];
    for (row, lines) in rows {
        let (times, usage) = (&row.times, &row.usage);
        cells.push(vec![
            row.name.clone(),
            format!("{:.2}", cpu_percent(row)),
            format!("{:.2}", wait_percent(row)),
            format!("{:.1}", times.frame.percentile_us(0.5)),
            format!("{:.1}", times.frame.percentile_us(0.99)),
            format!("{:.0}", times.frame.max_us()),
            times.deadline_misses.to_string(),
            format!("{:.0}", times.jitter.percentile_us(0.99)),
            format!("{:.1}", usage.rss_max_kb as f64 / 1024.0),
            format!("{:.0}", 1e3 * row.start_cpu_s),
            usage.descriptors.to_string(),
            usage.major_faults.to_string(),
            (usage.voluntary_switches + usage.involuntary_switches).to_string(),
            row.allocations_after_start.to_string(),
            format!("{:.0}", row.bytes_sent as f64 / row.wall_s.max(1e-3) / 1e3),
            margin_percent(lines).map_or("-".into(), |margin| format!("{margin:.0}")),
            verdict(lines),
        ]);
    }
    let columns = cells[0].len();
    let width = |column: usize| cells.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let mut text = String::new();
    for (at, row) in cells.iter().enumerate() {
        let padded: Vec<String> = (0..columns)
            .map(|k| {
                if k == 0 || k + 1 == columns {
                    format!("{:<w$}", row[k], w = width(k))
                } else {
                    format!("{:>w$}", row[k], w = width(k))
                }
            })
            .collect();
        let edge = if is_markdown { "|" } else { "" };
        let _ = writeln!(text, "{}", format!("{edge} {} {edge}", padded.join(bar)).trim());
        if is_markdown && at == 0 {
            let _ = writeln!(text, "|{}", "---|".repeat(columns));
        }
    }
    let _ = writeln!(text, "\n{flown_s:.1} s in real time, all partitions {:.2} % of a core", sum_percent(rows));
    text
}
