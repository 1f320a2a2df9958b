//! What can be wrong with a recording: file, place, offending value, and the cure.
//!
//! The message says what was found and where; the cure is the diagnostic's `help`.

use miette::{Diagnostic, NamedSource, SourceSpan};
use std::sync::Arc;
use thiserror::Error;

/// A cell of a text recording, lines and columns counted from 1; line 0 where a file has no lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub file: String,
    pub line: u64,
    pub column: usize,
    /// The column's header text.
    pub name: String,
}

impl core::fmt::Display for Place {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {}", self.file, self.within_file())
    }
}

impl Place {
    /// The place without the name of the file.
    pub(crate) fn within_file(&self) -> String {
        // datasets of binary files have no lines
        let line = if self.line > 0 { format!("line {}, ", self.line) } else { String::new() };
        let name = if self.name.is_empty() { String::new() } else { format!(" `{}`", self.name) };
        format!("{line}column {}{name}", self.column)
    }
}

/// Where in a map file something is wrong, lines and columns counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapPlace {
    pub file: String,
    pub line: usize,
    pub column: usize,
}

impl core::fmt::Display for MapPlace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: line {}, column {}", self.file, self.line, self.column)
    }
}

/// Every way in which a recording, or the map beside it, can be rejected.
#[derive(Debug, Error, Diagnostic)]
pub enum RecordingError {
    #[error("{file}: cannot {action}: {reason}")]
    #[diagnostic(help("{}", cure_of_io(reason)))]
    // Not called `source`: a report would print it a second time as the cause of this line.
    Io { file: String, action: &'static str, reason: std::io::Error },

    #[error("{file}: line 1: the file is empty")]
    #[diagnostic(help("export the recording again; a header row and at least two rows are needed"))]
    Empty { file: String },

    #[error("{file}: {found}")]
    #[diagnostic(help("{cure}"))]
    UnknownFormat { file: String, found: String, cure: String },

    #[error("{file}: line {line}: {found}")]
    #[diagnostic(help("{cure}"))]
    BadUff { file: String, line: u64, found: String, cure: String },

    #[error("{file}: {place}: {found}")]
    #[diagnostic(help("{cure}"))]
    BadContainer { file: String, place: String, found: String, cure: String },

    #[error("{file}: the format `{format}` cannot hold {what}")]
    #[diagnostic(help(
        "tables and spectra are written as .csv or .csv.gz, runs as .mcap, channels as either; several recordings one by one"
    ))]
    NotWritable { file: String, format: &'static str, what: &'static str },

    #[error("{place}: no column is known to hold the times")]
    #[diagnostic(help("{cure}"))]
    NoTimeColumn { place: Box<Place>, cure: String },

    #[error("{place}: {found}")]
    #[diagnostic(help("{cure}"))]
    BadClock { place: Box<Place>, found: String, cure: String },

    #[error("{place}: no channel beside the clock can be used: {left_out}")]
    #[diagnostic(help(
        "a recording needs a column of numbers with a name; name one by its number, as in --channel 'angle = {} [rad]'",
        first_of(left_out)
    ))]
    NoChannels { place: Box<Place>, left_out: String },

    #[error("{said}: {found}")]
    #[diagnostic(help("{cure}"))]
    BadOption { said: String, found: String, cure: String },

    #[error("{said}: {file} has no column `{found}`")]
    #[diagnostic(help("{cure}"))]
    NoSuchChannel { said: String, file: String, found: String, cure: String },

    #[error("{file}: {found}")]
    #[diagnostic(help("{cure}"))]
    WhichDataset { file: String, found: String, cure: String },

    #[error("{place}: unit `{found}` is not known")]
    #[diagnostic(help("{cure}; accepted: {accepted}"))]
    UnknownUnit { place: Box<Place>, found: String, accepted: String, cure: String },

    #[error("{place}: the unit of `{channel}` is not stated")]
    #[diagnostic(help("{cure}"))]
    UnitNotStated { place: Box<Place>, channel: &'static str, cure: String },

    #[error("{place}: unit `{found}` does not measure `{channel}`; accepted: {accepted}")]
    #[diagnostic(help("correct the header, or map the channel to another column"))]
    ChannelUnit { place: Box<Place>, found: String, channel: &'static str, accepted: String },

    #[error("{file}: line {line}: {found} columns, the header has {expected}; the row is `{row}`")]
    #[diagnostic(help("complete or delete the row; a cut last row is what a stopped writer leaves"))]
    Ragged { file: String, line: u64, found: usize, expected: usize, row: String },

    #[error("{place}: `{value}` is not a number")]
    #[diagnostic(help(
        "write a decimal number with a point, or delete the row: a gap in time is reported, not filled"
    ))]
    NotANumber { place: Box<Place>, value: String },

    #[error("{place}: `{value}` is not finite")]
    #[diagnostic(help("delete the row: a gap in time is reported, not filled"))]
    NotFinite { place: Box<Place>, value: String },

    #[error("{place}: time runs backwards, {before} s is followed by {value} s")]
    #[diagnostic(help("{cure}"))]
    TimeBackwards { place: Box<Place>, before: f64, value: f64, cure: String },

    #[error("{place}: frequency {before} Hz is followed by {value} Hz")]
    #[diagnostic(help("sort the rows by frequency, one row per frequency"))]
    FrequencyOrder { place: Box<Place>, before: f64, value: f64 },

    #[error("{place}: frequency {value} Hz is negative")]
    #[diagnostic(help("export the one-sided spectrum, from 0 Hz"))]
    FrequencyNegative { place: Box<Place>, value: f64 },

    #[error("{place}: time {value} s stands twice, and `{differs}` differs: {first} and {second}")]
    #[diagnostic(help("delete the wrong row, or export the time with more digits"))]
    TimeConflict { place: Box<Place>, value: f64, differs: String, first: f64, second: f64 },

    #[error("{file}: line {line}: {rows} row(s) of data, at least two are needed to know the rate")]
    #[diagnostic(help("export the whole recording"))]
    TooFewRows { file: String, line: u64, rows: usize },

    #[error("{place}: at {value} s the sample interval changes from {} s to {} s for good", rounded(*before_s), rounded(*after_s))]
    #[diagnostic(help("split the file at this line, or resample it to one rate"))]
    RateChanged { place: Box<Place>, value: f64, before_s: f64, after_s: f64 },

    #[error(
        "{place}: at {value} s an interval of {} s stands against a median of {} s; \
         95 % of the intervals lie within {jitter_percent:.0} % of it, {limit_percent:.0} % are accepted",
        rounded(*interval_s),
        rounded(*median_s)
    )]
    #[diagnostic(help("the sampling is too uneven to identify from: resample the recording to one rate"))]
    UnsteadyRate {
        place: Box<Place>,
        value: f64,
        interval_s: f64,
        median_s: f64,
        jitter_percent: f64,
        limit_percent: f64,
    },

    #[error("{file}: replay needs one rate: {reason}")]
    #[diagnostic(help(
        "split the file at this line, or resample the recording to one rate; `obsid diagnose` and `obsid plant` take it as it is"
    ))]
    NeedsOneRate { file: String, reason: String },

    #[error("{file}: channel `{channel}`: {found}")]
    #[diagnostic(help("{cure}"))]
    BadChannel { file: String, channel: String, found: String, cure: String },

    #[error("{file}: the run holds no sample of imu, joints, actuators or accelerometers")]
    #[diagnostic(help("record the run with `obsid run --record FILE`: the results alone say nothing about the plant"))]
    NoMeasurements { file: String },

    #[error("{file}: channel `/{channel}` is a channel of measurements, not a topic of a run")]
    #[diagnostic(help(
        "give the recording of a run (`obsid run --record FILE`); channels are read by `obsid diagnose`"
    ))]
    NotARun { file: String, channel: String },

    #[error("{place}: the recording lasts {value} s, more than {limit} s")]
    #[diagnostic(help("check the unit of the time column"))]
    TooLong { place: Box<Place>, value: f64, limit: f64 },

    #[error("{file}: the gzip stream ends after line {line} ({rows} complete rows): the file is truncated")]
    #[diagnostic(help("copy the file again; what is left can be had with `gzip -dc` and the last row deleted"))]
    TruncatedGzip { file: String, line: u64, rows: usize },

    #[error("{file}: the gzip stream is corrupt behind line {line}: {reason}")]
    #[diagnostic(help("copy the file again from its source"))]
    CorruptGzip { file: String, line: u64, reason: String },

    #[error("{place}: {reason}")]
    #[diagnostic(help("a map reads: [channels], then lines such as imu.accel_x = \"acceleration_x [m/s^2]\""))]
    MapSyntax {
        reason: String,
        place: Box<MapPlace>,
        #[source_code]
        source_code: Arc<NamedSource<String>>,
        #[label("here")]
        span: SourceSpan,
    },

    #[error("{place}: `{found}` is not a channel")]
    #[diagnostic(help("{cure}"))]
    UnknownChannel {
        found: String,
        cure: String,
        place: Box<MapPlace>,
        #[source_code]
        source_code: Arc<NamedSource<String>>,
        #[label("not a channel")]
        span: SourceSpan,
    },

    #[error("{place}: {found}")]
    #[diagnostic(help("{cure}"))]
    MapName {
        found: String,
        cure: String,
        place: Box<MapPlace>,
        #[source_code]
        source_code: Arc<NamedSource<String>>,
        #[label("here")]
        span: SourceSpan,
    },

    #[error("{place}: {table} has no column `{found}`")]
    #[diagnostic(help("{cure}"))]
    NoSuchColumn {
        table: String,
        found: String,
        cure: String,
        place: Box<MapPlace>,
        #[source_code]
        source_code: Arc<NamedSource<String>>,
        #[label("no such column")]
        span: SourceSpan,
    },

    #[error("{file}: {group} is given in part, `{missing}` is missing")]
    #[diagnostic(help("map `{missing}` too, or leave the whole {group} out; a missing value is never taken as zero"))]
    MissingChannel { file: String, group: String, missing: &'static str },

    #[error("{file}: none of the columns is a channel that can be replayed; columns: {columns}")]
    #[diagnostic(help("{cure}"))]
    NothingToReplay { file: String, columns: String, cure: String },

    #[error("{file}: the recording holds {} experiments, each on a system of its own: {experiments}", count)]
    #[diagnostic(help(
        "record one experiment per file: a scenario with one of [modal], [slosh], [inertial] and --record; \
         the whole mission is repeated, bit for bit, by `obsid run` with the same scenario and seed"
    ))]
    SeveralExperiments { file: String, count: usize, experiments: String },

    #[error("{file}: a channel map does not apply to a recorded run")]
    #[diagnostic(help("leave the map out: the samples of a run are typed already"))]
    MapOnRun { file: String },

    #[error(
        "{file}: frame {frame} of {period_ms} ms has {found} rows of {stream} ({rate_hz:.1} Hz), a frame carries {limit}"
    )]
    #[diagnostic(help(
        "take a control period of {period_ms_max} ms or less, decimate the recording, or leave the {stream} channels out of the map"
    ))]
    RateTooHigh {
        file: String,
        stream: &'static str,
        frame: u64,
        found: usize,
        limit: usize,
        rate_hz: f64,
        period_ms: f64,
        period_ms_max: f64,
    },

    #[error("{file}: a control period of {period_ns} ns was asked for, {reason}")]
    #[diagnostic(help("{cure}"))]
    Period { file: String, period_ns: u64, reason: String, cure: String },

    #[error(
        "{file}: byte {offset}: the MCAP file is truncated ({reason}); {readable} samples before that are readable"
    )]
    #[diagnostic(help(
        "copy the file again, or complete it with the MCAP tool: `mcap recover FILE -o NEW` keeps the readable samples"
    ))]
    McapTruncated { file: String, offset: u64, readable: u64, reason: String },

    #[error("{file}: byte {offset}: the MCAP file is corrupt ({reason}); {readable} samples before that are readable")]
    #[diagnostic(help(
        "copy the file again, or keep the readable samples with the MCAP tool: `mcap recover FILE -o NEW`"
    ))]
    McapCorrupt { file: String, offset: u64, readable: u64, reason: String },

    #[error(
        "{file}: topic `{topic}` (encoding `{encoding}`, schema `{schema}`) was not recorded by obsid; \
         the file's channels: {channels}"
    )]
    #[diagnostic(help(
        "supported: MCAP files written by obsid (topics as in `obsid icd`, ros1 messages obsid/Recorded*), \
         scalar channels (ros1 messages obsid_msgs/Scalar, metadata `unit`) and CSV; \
         export the topics as CSV with a `time [s]` column"
    ))]
    ForeignMcap { file: String, topic: String, encoding: String, schema: String, channels: String },

    #[error("{file}: topic `{topic}` was recorded with layout hash {recorded:#010x}, this build has {build:#010x}")]
    #[diagnostic(help(
        "read the file with the build that wrote it (metadata record `build`), or export it there as CSV"
    ))]
    LayoutMismatch { file: String, topic: String, recorded: u32, build: u32 },

    #[error(
        "{file}: topic `{topic}`, seq {seq}: CRC-32 of the sample is {computed:#010x}, its stamp says {stamped:#010x}"
    )]
    #[diagnostic(help("the sample was damaged before it was recorded: record the run again"))]
    SampleCrc { file: String, topic: &'static str, seq: u64, computed: u32, stamped: u32 },

    #[error("topic `{topic}`: a sample of {found} bytes, its type has {expected}")]
    #[diagnostic(help("build recorder and sender from the same sources"))]
    SampleSize { topic: String, found: usize, expected: usize },

    #[error("topic `{topic}`, seq {seq}: two samples with this number differ in byte {byte}")]
    #[diagnostic(help(
        "a restarted partition did not re-send what it had sent: its outputs are not a function of its inputs"
    ))]
    DigestConflict { topic: &'static str, seq: u64, byte: usize },
}

impl RecordingError {
    /// Whether time is sound and only the sampling uneven: methods that take any sample times may
    /// go on.
    pub(crate) fn is_uneven_sampling(&self) -> bool {
        matches!(self, RecordingError::RateChanged { .. } | RecordingError::UnsteadyRate { .. })
    }

    /// The message without the name of the file in front, to be said in a place that names it.
    pub(crate) fn without_file(&self, file: &str) -> String {
        let message = self.to_string();
        message.strip_prefix(file).and_then(|rest| rest.strip_prefix(": ")).map_or(message.clone(), String::from)
    }

    /// Message and cure as plain text.
    #[must_use]
    pub fn explain(&self) -> String {
        match self.help() {
            Some(cure) => format!("{self}\ncure: {cure}"),
            None => self.to_string(),
        }
    }
}

/// The number of the first column that is left out for lack of a name.
fn first_of(left_out: &str) -> &str {
    let digits = |text: &'_ str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let behind = left_out.split("`column ").nth(1).unwrap_or("2");
    &behind[..digits(behind)]
}

/// What to do where the system does not give a file.
fn cure_of_io(reason: &std::io::Error) -> &'static str {
    match reason.kind() {
        std::io::ErrorKind::NotFound => "check the path: no such file or folder is there",
        std::io::ErrorKind::PermissionDenied => "check the permissions of the file and of its folder",
        std::io::ErrorKind::StorageFull => "make room on the device, or write to another one",
        std::io::ErrorKind::IsADirectory => "give a file in this folder",
        _ => "check the path, the permissions and the space on the device",
    }
}

/// A measured number without the digits of rounding: seven significant ones.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// The name of `candidates` nearest to `found` (Levenshtein), when it is near enough to be meant.
pub(crate) fn nearest<'a>(found: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let best = candidates.into_iter().map(|name| (edit_distance(found, name), name)).min_by_key(|(cost, _)| *cost)?;
    (best.0 <= found.chars().count().max(3) / 2).then_some(best.1)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
