//! Channels of any plant in MCAP: one channel per series, topic `/NAME`, ROS 1 message
//! `obsid_msgs/Scalar`.
//!
//! The unit is the channel's metadata `unit`; log time = publish time = sample time, sequence =
//! number of the sample in its channel. Messages stand in the order of time. Nothing else goes into
//! the file.
//!
//! Times are unsigned whole nanoseconds: a time is rounded to the nearest, and reads back as
//! `ns / 1e9`, the f64 nearest to that decimal. Times given as such decimals (`0.1`, `3e-6`) come
//! back bit for bit; for others [`write_series_mcap`] notes the largest change. A negative time,
//! and two samples of a channel within one nanosecond, are rejected: CSV holds them.

use crate::error::RecordingError;
use crate::mcap_read::{Entry, read_entries};
use crate::mcap_recorder::{LIBRARY, PROFILE};
use crate::run::RecordedRun;
use crate::schema::{SCALAR_NAME, SCALAR_TEXT, UNIT};
use crate::series::{SeriesSet, check, for_each_time};
use crate::units::{Unit, unit_named};
use crate::whole_file::replace_stream;
use crate::{Imported, file_name};
use channels::{Channel, Recording};
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Times up to which an f64 counts every nanosecond fits a u64 with room to spare [s].
const TIME_MAX_S: f64 = 1e10;

/// Writes channels as MCAP; gives a note when times were rounded.
///
/// # Errors
/// [`RecordingError::BadChannel`] for what would not read back, the device's.
pub fn write_series_mcap(recording: &Recording, path: &Path) -> Result<Vec<String>, RecordingError> {
    check(recording)?;
    let notes = check_times(recording, path)?;
    replace_stream(path, |file| {
        write_messages(recording, file).map_err(|error| match write_error(path, error) {
            RecordingError::Io { reason, .. } => reason,
            other => std::io::Error::other(other.to_string()),
        })
    })?;
    Ok(notes)
}

fn write_messages(recording: &Recording, out: impl Write) -> mcap::McapResult<()> {
    // `disable_seeking`: the place of the writer is never changed, a plain stream will do.
    let mut writer = write_options().create(mcap::write::NoSeek::new(out))?;
    let schema = writer.add_schema(SCALAR_NAME, "ros1msg", SCALAR_TEXT.as_bytes())?;
    let mut channels = Vec::new();
    for channel in &recording.channels {
        let facts = BTreeMap::from([(UNIT.to_string(), channel.unit.clone())]);
        channels.push((writer.add_channel(schema, &format!("/{}", channel.name), "ros1", &facts)?, 0));
    }
    for_each_time(recording, |time_s, values| {
        let time = nanoseconds(time_s);
        for ((channel_id, sequence), value) in channels.iter_mut().zip(values) {
            let Some(value) = value else { continue };
            let header =
                MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &value.to_le_bytes())?;
            *sequence = sequence.wrapping_add(1);
        }
        Ok::<(), mcap::McapError>(())
    })?;
    writer.finish().map(|_| ())
}

/// Chunks are compressed by one thread and written whole: the same samples give the same bytes.
fn write_options() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .profile(PROFILE)
        .library(LIBRARY)
        .disable_seeking(true)
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
}

fn write_error(path: &Path, error: mcap::McapError) -> RecordingError {
    let source = match error {
        mcap::McapError::Io(source) => source,
        other => std::io::Error::other(other.to_string()),
    };
    RecordingError::Io { file: file_name(path), action: "write", reason: source }
}

/// A checked time; what reads back is `ns / 1e9`.
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}

/// Refuses times that the format cannot tell apart; notes those it rounds.
fn check_times(recording: &Recording, path: &Path) -> Result<Vec<String>, RecordingError> {
    let mut rounded = 0_u64;
    let mut change_max_s = 0.0_f64;
    for channel in &recording.channels {
        let bad = |found: String, cure: &str| RecordingError::BadChannel {
            file: file_name(path),
            channel: channel.name.clone(),
            found,
            cure: cure.into(),
        };
        if let Some(time) = channel.time_s.iter().find(|time| !(0.0..=TIME_MAX_S).contains(*time)) {
            let found = format!("time {time} s is outside of 0 s to {TIME_MAX_S} s, which MCAP can hold");
            return Err(bad(found, "let the time begin at 0 s, or write a .csv"));
        }
        if let Some(pair) = channel.time_s.windows(2).find(|pair| nanoseconds(pair[0]) == nanoseconds(pair[1])) {
            let found = format!("times {} s and {} s are the same nanosecond", pair[0], pair[1]);
            return Err(bad(found, "check the unit of the times, or write a .csv"));
        }
        for time in &channel.time_s {
            let change_s = (seconds(nanoseconds(*time)) - time).abs();
            rounded += u64::from(change_s > 0.0);
            change_max_s = change_max_s.max(change_s);
        }
    }
    let note = format!("{rounded} time(s) were rounded to whole nanoseconds, by {change_max_s:.1e} s at most");
    Ok(if rounded > 0 { vec![note] } else { Vec::new() })
}

/// Reads an MCAP file: a run of obsid or channels, by what its channels carry.
pub(crate) fn read_imported(path: &Path) -> Result<Imported, RecordingError> {
    let mut run = RecordedRun::new(&file_name(path));
    let mut scalars = Scalars { file: file_name(path), channels: BTreeMap::new() };
    let damage = read_entries(path, &mut |entry| match entry {
        Entry::ScalarChannel { channel, name, unit } => scalars.add(channel, name, unit),
        Entry::Scalar { channel, t_ns, value } => {
            scalars.take(channel, t_ns, value);
            Ok(())
        }
        entry => run.take(path, entry, &|_| true),
    })?;
    if let Some(damage) = damage {
        return Err(damage.into_error(path));
    }
    match (scalars.channels.values().next(), run.is_empty()) {
        (None, _) => Ok(Imported::Run(run)),
        (Some(_), true) => scalars.finish().map(Imported::Series),
        (Some(first), false) => {
            Err(RecordingError::NotARun { file: scalars.file.clone(), channel: first.channel.name.clone() })
        }
    }
}

/// Channels on their way from a file, by their numbers in it: the order in which they were written.
struct Scalars {
    file: String,
    channels: BTreeMap<u16, Scalar>,
}

/// A channel on its way, and what its numbers are in.
struct Scalar {
    channel: Channel,
    unit: Unit,
    unit_in_file: String,
}

impl Scalars {
    /// A channel; its record is repeated at the end of a file.
    fn add(&mut self, channel: u16, name: &str, unit: &str) -> Result<(), RecordingError> {
        if self.channels.contains_key(&channel) {
            return Ok(());
        }
        let Some(found) = unit_named(unit).filter(|_| !unit.is_empty()) else {
            return Err(RecordingError::BadChannel {
                file: self.file.clone(),
                channel: name.into(),
                found: format!("unit `{unit}` is not known"),
                cure: "write the unit into the channel's metadata `unit`, `-` for a number without unit".into(),
            });
        };
        let of_file = Channel::new(name, found.si, Vec::new(), Vec::new());
        self.channels.insert(channel, Scalar { channel: of_file, unit: found, unit_in_file: unit.into() });
        Ok(())
    }

    fn take(&mut self, channel: u16, t_ns: u64, value: f64) {
        if let Some(Scalar { channel, unit, .. }) = self.channels.get_mut(&channel) {
            channel.time_s.push(seconds(t_ns));
            channel.value.push(unit.to_si(value));
        }
    }

    fn finish(self) -> Result<SeriesSet, RecordingError> {
        let mut set = SeriesSet::new(&self.file);
        for Scalar { channel, unit_in_file, .. } in self.channels.into_values() {
            set.push(channel, &unit_in_file);
        }
        check(&set.recording)?;
        Ok(set)
    }
}
