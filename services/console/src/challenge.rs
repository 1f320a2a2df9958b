//! `obsid challenge`: what the diagnosis is worth on truth that it cannot know.

mod example;
mod seed;

use crate::Failure;
use crate::progress::Share;
use ::challenge::campaign::{Draws, Watch, campaign};
use ::challenge::case::{Class, Sealed, digest};
use ::challenge::score::{Opened, Score, is_false_alarm, score};
use seed::SeedWord;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Diagnose seeded blind cases whose truth comes from other equations, another integrator and other
/// noise
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid challenge                                   20 cases, figures beside the bars
  obsid challenge --cases 200 --seed 7 --json       the figures as one JSON object
  obsid challenge --cases 60 --seed auto            cases that this commit alone has met
  obsid challenge --cases 50 --list cases.json      every case: truth, digest, verdict, names, d, seconds
  obsid challenge --seed 7 --case 4 --out case_4    plant, recordings and truth of one case, nothing diagnosed

Truths are hashed (BLAKE3) before the first diagnosis and opened after the last; the same seed gives the same bytes on any number of
threads (but for the seconds in the list).")]
pub struct Arguments {
    /// Three of ten are nulls
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    cases: u64,
    /// A number, or `auto`: that of the commit, for cases that no change of the code has met
    #[arg(long, default_value = "1")]
    seed: SeedWord,
    /// Complete plants instead, whose readings hold 1 to 3 % that no law of the catalogue makes:
    /// any name is a false alarm
    #[arg(long, conflicts_with = "case")]
    controls: bool,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// Cases at a time
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// Write every case to this file: sealed digests first, everything at the end
    #[arg(long, value_name = "FILE.json")]
    list: Option<PathBuf>,
    /// Diagnose nothing; write the plant file, the recordings and the truth of this case to --out
    #[arg(long, value_name = "INDEX", requires = "out", conflicts_with_all = ["cases", "threads", "list"])]
    case: Option<u64>,
    /// Folder for the files of --case
    #[arg(long, value_name = "DIR", requires = "case")]
    out: Option<PathBuf>,
}

/// # Errors
/// [`Failure::Run`] when a truth is not what was sealed, or a file cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let seed = arguments.seed.number()?;
    if let (Some(case), Some(folder)) = (arguments.case, &arguments.out) {
        return example::write(seed, case, folder, arguments.json);
    }
    let start = Instant::now();
    let bar = Share::new("of the cases sealed and diagnosed");
    let progress = |what: &str, done: usize, all: usize| {
        let half = if what == "sealed" { 0.0 } else { 0.5 };
        bar.show(half + 0.5 * done as f64 / all.max(1) as f64);
    };
    let mut commitment = String::new();
    let mut unwritten = None;
    let opened = campaign(
        arguments.cases,
        (seed, if arguments.controls { Draws::Controls } else { Draws::Blind }),
        usize::from(arguments.threads),
        &mut Watch {
            progress: &progress,
            seconds: &|| start.elapsed().as_secs_f64(),
            sealed: &mut |sealed| {
                commitment = commit(sealed);
                if let Some(path) = &arguments.list {
                    let digests: Vec<&str> = sealed.iter().map(|sealed| sealed.digest.as_str()).collect();
                    unwritten =
                        write(path, &json!({ "seed": seed, "commitment": commitment, "sealed": digests })).err();
                }
            },
        },
    );
    bar.end();
    if let Some(failure) = unwritten {
        return Err(failure);
    }
    let opened = opened.map_err(Failure::Run)?;
    let figures = score(&opened);
    if let Some(path) = &arguments.list {
        write(path, &json!({ "seed": seed, "commitment": commitment, "score": figures, "cases": opened }))?;
    }
    if arguments.json {
        crate::tell(&format!("obsid: truths of seed {seed} sealed as {commitment}"));
    }
    crate::print(&if arguments.json {
        format!("{}\n", json!(figures))
    } else {
        in_words(seed, &commitment, &figures, &opened)
    });
    Ok(())
}

/// Digest of all digests.
fn commit(sealed: &[Sealed]) -> String {
    digest(sealed.iter().map(|sealed| sealed.digest.as_str()).collect::<String>().as_bytes())
}

fn write(path: &Path, value: &Value) -> Result<(), Failure> {
    std::fs::write(path, format!("{value:#}\n"))
        .map_err(|error| Failure::Run(format!("the list cannot be written to {}: {error}", path.display())))
}

fn in_words(seed: u64, commitment: &str, figures: &Score, opened: &[Opened]) -> String {
    let mut page = format!("{} cases of seed {seed}; truths sealed as {commitment}\n\n", figures.cases);
    for (what, value, bar) in rows(figures) {
        let _ = writeln!(page, "{what:<44} {value:>16}   {bar}");
    }
    let _ = writeln!(
        page,
        "\n{:<16} {:>6} {:>10} {:>8}   must: ideal - max(3 SE, 6 %)",
        "realised d", "n", "detected", "ideal"
    );
    for bin in figures.power.iter().filter(|bin| bin.n > 0) {
        let range = format!("{} to {}", bin.d_low, bin.d_high);
        let _ = writeln!(page, "{range:<16} {:>6} {:>10} {:>8.1}", bin.n, bin.detected, bin.ideal);
    }
    let alarms: Vec<String> = opened.iter().filter(|o| is_false_alarm(&o.truth, &o.answer)).map(alarm).collect();
    if !alarms.is_empty() {
        let _ = writeln!(page, "\nfalse alarms\n{}", alarms.join("\n"));
    }
    let undecided =
        opened.iter().filter(|o| o.truth.class == Class::Null && o.answer.verdict == "cannot_decide").count();
    let crashed = opened.iter().filter(|o| o.answer.crashed).count();
    let _ = writeln!(page, "\nnulls that could not be decided: {undecided}; diagnoses that panicked: {crashed}");
    page
}

fn alarm(opened: &Opened) -> String {
    let truth = &opened.truth;
    let name = opened.answer.names.first().map_or(String::new(), |name| format!("{}@{}", name.kind, name.site));
    format!("  case {} {} ({:?}): {} {name}", truth.case, truth.plant, truth.noise, opened.answer.verdict)
}

/// What, measured, the bar of the design.
fn rows(f: &Score) -> Vec<(&'static str, String, &'static str)> {
    let percent = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.1} %", 100.0 * x));
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let of = |a: usize, n: usize| format!("{a} of {n}");
    let first = format!("{} | {}", percent(f.first_name_share_d8), percent(f.ideal_first_name_share_d8));
    vec![
        ("false alarms on nulls", of(f.false_alarms, f.nulls), "must: at most 1 %"),
        ("right first name, d >= 8 | ideal", first, "must: ideal - 3 SE"),
        ("truth in the set, d >= 8", percent(f.in_set_share_d8), "must: 97 %"),
        ("median size of the set", number(f.set_size_median), "must: at most 2"),
        ("both of a pair named", of(f.pairs.both_named, f.pairs.n), "must: 75 %"),
        ("left out: abstained", of(f.leave_one_out.abstained, f.leave_one_out.n), "must: 85 %"),
        ("left out: confident false name", of(f.leave_one_out.false_name, f.leave_one_out.n), "must: at most 8 %"),
        ("parameter error, rms in sigma", number(f.parameter_z_rms), "must: 0.90 to 1.15"),
        ("parameter error below 2 sigma", percent(f.parameter_z_below_2_share), "must: 92 %"),
        ("held-out gain confirmed, d >= 7", percent(f.heldout_confirmed_share), "must: 90 %"),
        ("masked: number corrected", of(f.masked.corrected, f.masked.n), "must: 92 %"),
        ("time x channel, median overlap", number(f.iou_median), "must: 0.75"),
        ("Brier score of first names", number(f.brier), ""),
    ]
}
