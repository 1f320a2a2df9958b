//! `obsid latency`: what the link costs beside what the machine itself costs, and from a sensor's
//! sample to the estimate.

mod floors;
mod link;

use crate::scratch::Scratch;
use crate::{Failure, flight, interrupt, run};
use link::Mode;
use runtime::latency::LatencyHistogram;
use runtime::sys::monotonic_ns;
use runtime::trace::{Mark, Trace};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::time::Instant;
use telemetry::{ACCELEROMETERS, EVENT, TOPICS};

/// Whose frames end in estimates.
const ESTIMATORS: [&str; 3] = ["inertial-id", "slosh-id", "modal-id"];
/// Round trips of a burst: one that spins, one that sleeps.
const SPINNING: u64 = 4000;
const SLEEPING: u64 = 500;
/// Markers whose cost is measured.
const MARKERS: u64 = 200_000;

/// Measure the link beside cache line, futex, pipe and socket, and the way from sample to estimate
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid latency                  10 s of ping-pong and 10 s of flight in real time
  obsid latency --seconds 60     longer, for the rare ones
  obsid latency --json           one JSON object, with the histogram

Links alternate in short bursts with the floors they are compared with, so that whatever else the computer does meets
both: judge the ratios. `poll` is compared with a cache line, `waitset` (asleep until woken) with a futex. Samples are those that the
partitions exchange: 80 B (event) and 6440 B (accelerometers).")]
pub struct Arguments {
    /// Of each of the two parts
    #[arg(long, value_name = "N", default_value_t = 10.0)]
    seconds: f64,
    /// One JSON object on standard output, all else on standard error
    #[arg(long)]
    json: bool,
}

/// A row: a way to hand something to another core.
struct Row {
    name: &'static str,
    mode: &'static str,
    bytes: usize,
    /// Index of the row that it is compared with.
    floor: usize,
    times: LatencyHistogram,
}

impl Row {
    fn new(name: &'static str, mode: &'static str, bytes: usize, floor: usize) -> Self {
        Row { name, mode, bytes, floor, times: LatencyHistogram::default() }
    }
}

/// Rows of the table; the first two are the floors.
const CACHE_LINE: usize = 0;
const FUTEX: usize = 1;

/// Measures, and prints a table or JSON.
///
/// # Errors
/// [`Failure::Run`] when no run can be made, [`Failure::Interrupted`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if !(arguments.seconds > 0.0 && arguments.seconds.is_finite()) {
        return Err(Failure::Input(miette::miette!(help = "give a time above 0", "--seconds {}", arguments.seconds)));
    }
    let interrupted = interrupt::flag()?;
    let scenario = flight::in_real_time(None, &run::Common::default())?;
    let rows = links(&scenario.config, arguments.seconds)?;
    runtime::sys::keep_own_rights();
    let marker_ns = marker_ns()?;
    let end = flight::fly(scenario, arguments.seconds, &interrupted)?;
    let mut end_to_end = LatencyHistogram::default();
    for row in end.rows.iter().filter(|row| ESTIMATORS.contains(&row.name.as_str())) {
        end_to_end.add(&row.times.end_to_end);
    }
    if end_to_end.total() == 0 {
        return Err(Failure::Run("no frame was flown: end to end cannot be measured".into()));
    }
    if arguments.json {
        let links: Vec<Value> = rows.iter().map(|row| link_json(row, &rows)).collect();
        let object = json!({
            "links": links, "end_to_end": end_to_end_json(&end_to_end), "marker_ns": marker_ns[0],
            "clock_ns": marker_ns[1],
        });
        crate::print(&format!("{object}\n"));
    } else {
        crate::print(&table(&rows, &end_to_end, marker_ns));
    }
    Ok(())
}

fn links(run: &runtime::RunConfig, seconds: f64) -> Result<Vec<Row>, Failure> {
    let (small, large) = (TOPICS[EVENT.id].size, TOPICS[ACCELEROMETERS.id].size);
    let mut rows = vec![
        Row::new("cache line", "poll", 8, CACHE_LINE),
        Row::new("futex", "blocking", 4, FUTEX),
        Row::new("pipe", "blocking", floors::MESSAGE_BYTES, FUTEX),
        Row::new("unix socket", "blocking", floors::MESSAGE_BYTES, FUTEX),
        Row::new("link", "poll", small, CACHE_LINE),
        Row::new("link", "poll", large, CACHE_LINE),
        Row::new("link", "waitset", small, FUTEX),
        Row::new("link", "waitset", large, FUTEX),
    ];
    let scratch = Scratch::new()?;
    let started = Instant::now();
    let failed = |error: std::io::Error| Failure::Run(error.to_string());
    while started.elapsed().as_secs_f64() < seconds {
        let [line, futex, pipe, socket, polls @ ..] = &mut rows[..] else { unreachable!("eight rows") };
        floors::cache_line(SPINNING, &mut line.times);
        floors::futex_wake(SLEEPING, &mut futex.times);
        floors::pipe(SLEEPING, &mut pipe.times).map_err(failed)?;
        floors::socket(SLEEPING, &mut socket.times).map_err(failed)?;
        let ways = [(EVENT.id, Mode::Poll), (ACCELEROMETERS.id, Mode::Poll), (EVENT.id, Mode::WaitSet)];
        for ((topic, mode), row) in ways.into_iter().chain([(ACCELEROMETERS.id, Mode::WaitSet)]).zip(polls) {
            let rounds = if mode == Mode::Poll { SPINNING } else { SLEEPING };
            link::ping_pong(run, scratch.root(), (topic, mode), rounds, &mut row.times).map_err(Failure::Run)?;
        }
    }
    Ok(rows)
}

/// Cost of a marker of `obsid run --trace`, its share of the writing of the file included, and of
/// one reading of the clock \[ns\].
fn marker_ns() -> Result<[f64; 2], Failure> {
    let scratch = Scratch::new()?;
    let path = scratch.file("markers");
    let mut trace = Trace::create(&path).map_err(|error| Failure::Run(error.to_string()))?;
    let mut last_ns = 0;
    let of = |act: &mut dyn FnMut(u64)| {
        let begin_ns = monotonic_ns();
        (0..MARKERS).for_each(act);
        (monotonic_ns() - begin_ns) as f64 / MARKERS as f64
    };
    let marker = of(&mut |k| trace.mark(Mark::Frame, std::hint::black_box(k), k, k + 1));
    let clock = of(&mut |_| last_ns = std::hint::black_box(monotonic_ns()));
    Ok([marker, clock])
}

fn ratio(row: &Row, rows: &[Row]) -> f64 {
    row.times.percentile_us(0.5) / rows[row.floor].times.percentile_us(0.5)
}

fn link_json(row: &Row, rows: &[Row]) -> Value {
    json!({
        "name": row.name, "mode": row.mode, "bytes": row.bytes,
        "p50_us": row.times.percentile_us(0.5), "p99_us": row.times.percentile_us(0.99),
        "p999_us": row.times.percentile_us(0.999), "max_us": row.times.max_us(),
        "round_trips": row.times.total(), "ratio_to_floor": ratio(row, rows),
    })
}

fn end_to_end_json(times: &LatencyHistogram) -> Value {
    let histogram: Vec<Value> =
        times.buckets().map(|(up_to_us, count)| json!({ "up_to_us": up_to_us, "count": count })).collect();
    json!({
        "p50_us": times.percentile_us(0.5), "p99_us": times.percentile_us(0.99), "p999_us": times.percentile_us(0.999),
        "max_us": times.max_us(), "frames": times.total(), "histogram": histogram,
    })
}

fn table(rows: &[Row], end_to_end: &LatencyHistogram, [marker_ns, clock_ns]: [f64; 2]) -> String {
    let mut text = format!(
        "{:<12} {:<9} {:>6} {:>10} {:>10} {:>10} {:>10} {:>7}\n",
        "one way", "mode", "bytes", "p50 [us]", "p99", "p99.9", "max", "ratio"
    );
    for row in rows {
        let at = |p| row.times.percentile_us(p);
        let _ = writeln!(
            text,
            "{:<12} {:<9} {:>6} {:>10.2} {:>10.2} {:>10.2} {:>10.1} {:>7.2}",
            row.name,
            row.mode,
            row.bytes,
            at(0.5),
            at(0.99),
            at(0.999),
            row.times.max_us(),
            ratio(row, rows)
        );
    }
    let at = |p| end_to_end.percentile_us(p);
    let (total, max_us) = (end_to_end.total(), end_to_end.max_us());
    let _ = writeln!(
        text,
        "\nsample sent -> frame published, {total} frames in real time: p50 {:.0} us, p99 {:.0} us, p99.9 {:.0} us, max {max_us:.0} us",
        at(0.5),
        at(0.99),
        at(0.999)
    );
    for (up_to_us, count) in coarse(end_to_end) {
        let bar = "#".repeat((60 * count).div_ceil(total.max(1)) as usize);
        let _ = writeln!(text, "{up_to_us:>10.0} us {count:>8}  {bar}");
    }
    let _ = writeln!(text, "\na marker of --trace costs {marker_ns:.0} ns, one reading of the clock {clock_ns:.0} ns");
    text
}

/// Octaves of the histogram: upper limit \[µs\] and count.
fn coarse(times: &LatencyHistogram) -> Vec<(f64, u64)> {
    let mut octaves: Vec<(f64, u64)> = Vec::new();
    for (up_to_us, count) in times.buckets() {
        let limit_us = up_to_us.log2().ceil().exp2();
        match octaves.last_mut().filter(|(last, _)| *last == limit_us) {
            Some((_, sum)) => *sum += count,
            None => octaves.push((limit_us, count)),
        }
    }
    octaves
}
