//! Which events leave a partition, and where its newest ones are kept.
//!
//! Per code and window at most so many are sent; the others are counted, and the next one sent, or
//! a summary, says how many. Alarms always pass. What is sent goes to the topic, and to a ring file
//! in the partition's folder, which `obsid events` reads without joining the run.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use telemetry::{Event, EventCode, MONITOR_HEAD, Severity, Stamps, TableId, TableValues};
use zerocopy::{FromBytes, IntoBytes};

/// Events of one code in a window, unless the table `monitor` says otherwise: an operator reads
/// eight lines, and a recorder writes eight samples of every code and partition without notice.
const MOST_IN_WINDOW: u32 = 8;
/// Answers to the ground, of which the port lets no flood through: commands are released seven
/// frames apart at least.
const MOST_ANSWERS: u32 = 64;
/// That window \[s\].
const WINDOW_S: f64 = 1.0;
const NS_PER_S: f64 = 1e9;

/// Of one code.
#[derive(Clone, Copy, Default)]
struct Window {
    begin_ns: u64,
    sent: u32,
    /// Not sent, and not said yet.
    pending: u64,
}

/// How many events there were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EventCounts {
    /// Sent.
    pub sent: u64,
    /// Too many of their code in a window.
    pub squelched: u64,
    /// Below the least severity, or of a code that is switched off.
    pub filtered: u64,
}

/// Filter and squelch of one partition; takes no memory.
pub struct EventGate {
    window_ns: u64,
    least: u16,
    most: [u32; EventCode::COUNT],
    windows: [Window; EventCode::COUNT],
    counts: EventCounts,
}

const fn most_of(code: EventCode) -> u32 {
    if code.is_answer() { MOST_ANSWERS } else { MOST_IN_WINDOW }
}

impl Default for EventGate {
    fn default() -> Self {
        EventGate {
            window_ns: (WINDOW_S * NS_PER_S) as u64,
            least: Severity::Information.code(),
            most: core::array::from_fn(|index| most_of(EventCode::ALL[index])),
            windows: [Window::default(); EventCode::COUNT],
            counts: EventCounts::default(),
        }
    }
}

impl EventGate {
    /// Values of the table `monitor` that say the same as this gate, for a partition with that
    /// deadline.
    #[must_use]
    pub fn table(&self, deadline_ms: f64) -> Option<TableValues> {
        let mut values = [0.0; MONITOR_HEAD + EventCode::COUNT];
        let (head, most) = values.split_at_mut(MONITOR_HEAD);
        head.copy_from_slice(&[deadline_ms, self.window_ns as f64 / NS_PER_S, f64::from(self.least)]);
        most.iter_mut().zip(&self.most).for_each(|(value, most)| *value = f64::from(*most));
        TableValues::checked(TableId::Monitor, &values).ok()
    }

    /// Takes what the table `monitor` says of events.
    pub fn configure(&mut self, values: &TableValues) {
        let (head, most) = values.as_slice().split_at(MONITOR_HEAD);
        self.window_ns = (head[1] * NS_PER_S) as u64;
        self.least = head[2] as u16;
        self.most.iter_mut().zip(most).for_each(|(own, value)| *own = *value as u32);
    }

    /// Whether an event at `now_ns` is sent; then how many of its code were not, before it.
    pub fn admit(&mut self, code: EventCode, severity: Severity, now_ns: u64) -> Option<u64> {
        let (window, most) = (&mut self.windows[code.index()], self.most[code.index()]);
        if severity != Severity::Alarm {
            if severity.code() < self.least || most == 0 {
                self.counts.filtered += 1;
                return None;
            }
            if now_ns.saturating_sub(window.begin_ns) >= self.window_ns {
                (window.begin_ns, window.sent) = (now_ns, 0);
            }
            if window.sent >= most {
                window.pending += 1;
                self.counts.squelched += 1;
                return None;
            }
            window.sent += 1;
        }
        self.counts.sent += 1;
        Some(core::mem::take(&mut window.pending))
    }

    /// A code whose window is over and of which some were not sent, with their number; each once.
    pub fn summary(&mut self, now_ns: u64) -> Option<(EventCode, u64)> {
        let length = self.window_ns;
        let over = |window: &Window| window.pending > 0 && now_ns.saturating_sub(window.begin_ns) >= length;
        let (window, code) = self.windows.iter_mut().zip(EventCode::ALL).find(|(window, _)| over(window))?;
        self.counts.sent += 1;
        Some((*code, core::mem::take(&mut window.pending)))
    }

    /// Since the start, or since [`EventGate::clear`].
    #[must_use]
    pub fn counts(&self) -> EventCounts {
        self.counts
    }

    /// Counts from 0 again; what was squelched and not said yet will still be.
    pub fn clear(&mut self) {
        self.counts = EventCounts::default();
    }
}

const STAMPS: usize = size_of::<Stamps>();
const EVENT_BYTES: usize = STAMPS + size_of::<Event>();
/// Records of a ring: two minutes of one code that is squelched at eight a second.
pub const LOG_RECORDS: u64 = 1024;

/// The newest events of one partition, as a ring of records in a file: stamps, then the sample; the
/// stamps' CRC says whether a record is whole.
pub struct EventLog {
    file: File,
    next: u64,
}

impl EventLog {
    /// Goes on behind the newest record in `path`.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path)?;
        let newest = records(&std::fs::read(path)?).max_by_key(|(_, stamps, event)| (stamps.epoch, event.header.seq));
        Ok(EventLog { file, next: newest.map_or(0, |(slot, ..)| slot + 1) % LOG_RECORDS })
    }

    /// Writes over the oldest record. An event is not worth a failure: one that cannot be written
    /// is left out.
    pub fn write(&mut self, stamps: &Stamps, payload: &[u8]) {
        let mut record = [0; EVENT_BYTES];
        record[..STAMPS].copy_from_slice(stamps.as_bytes());
        if payload.len() == EVENT_BYTES - STAMPS {
            record[STAMPS..].copy_from_slice(payload);
            let _ = self.file.write_all_at(&record, self.next * EVENT_BYTES as u64);
            self.next = (self.next + 1) % LOG_RECORDS;
        }
    }
}

fn records(bytes: &[u8]) -> impl Iterator<Item = (u64, Stamps, Event)> {
    bytes.chunks_exact(EVENT_BYTES).enumerate().filter_map(|(slot, record)| {
        let (stamps, payload) = record.split_at(STAMPS);
        let stamps = Stamps::read_from_bytes(stamps).ok().filter(|stamps| stamps.crc32 == telemetry::crc32(payload))?;
        let event = Event::read_from_bytes(payload).ok()?;
        (event.known_code().is_some()).then_some((slot as u64, stamps, event))
    })
}

/// The whole records of a ring, the oldest first, each once; none of a file that is not there.
#[must_use]
pub fn read_log(path: &Path) -> Vec<(Stamps, Event)> {
    let bytes = std::fs::read(path).unwrap_or_default();
    let mut all: Vec<_> = records(&bytes).map(|(_, stamps, event)| (stamps, event)).collect();
    all.sort_by_key(|(stamps, event)| (stamps.epoch, event.header.seq, stamps.sent_ns));
    // Who writes a ring may learn of an event twice.
    all.dedup_by_key(|(stamps, event)| (stamps.epoch, event.header.seq));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use telemetry::{PartitionId, Sample};

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn of_a_flood_a_window_sends_its_limit_and_every_other_event_is_counted_once_and_said_once() {
        let mut gate = EventGate::default();
        let mut said = 0;
        let mut sent = 0;
        for k in 0..100_000 {
            if let Some(before) = gate.admit(EventCode::CycleSlip, Severity::Warning, k * SECOND / 10_000) {
                (said, sent) = (said + before, sent + 1);
            }
        }
        // ten seconds of ten thousand a second
        assert_eq!(sent, 10 * u64::from(MOST_IN_WINDOW));
        assert_eq!(gate.summary(10 * SECOND - 1), None, "its window is not over");
        let (code, last) = gate.summary(20 * SECOND).unwrap();
        assert_eq!((code, gate.summary(20 * SECOND)), (EventCode::CycleSlip, None));
        assert_eq!(said + last, 100_000 - sent);
        assert_eq!(gate.counts(), EventCounts { sent: sent + 1, squelched: 100_000 - sent, filtered: 0 });
    }

    #[test]
    fn an_alarm_passes_every_filter_and_every_flood() {
        let mut gate = EventGate::default();
        let mut values = gate.table(1.0).unwrap().as_slice().to_vec();
        values[MONITOR_HEAD..].fill(0.0);
        gate.configure(&TableValues::checked(TableId::Monitor, &values).unwrap());
        let passed = (0..1000).filter(|_| gate.admit(EventCode::GivenUp, Severity::Alarm, 0).is_some());
        assert_eq!(passed.count(), 1000);
        assert_eq!(gate.admit(EventCode::Started, Severity::Warning, 0), None);
        assert_eq!(gate.counts().filtered, 1);
    }

    #[test]
    fn one_code_in_flood_takes_nothing_from_another_and_a_filter_is_per_code_and_severity() {
        let mut gate = EventGate::default();
        (0..1000).for_each(|_| _ = gate.admit(EventCode::CycleSlip, Severity::Warning, 0));
        assert!(gate.admit(EventCode::SamplesLost, Severity::Warning, 0).is_some());
        let mut values = gate.table(1.0).unwrap().as_slice().to_vec();
        values[2] = f64::from(Severity::Warning.code());
        gate.configure(&TableValues::checked(TableId::Monitor, &values).unwrap());
        assert_eq!(gate.table(1.0).unwrap().as_slice(), values, "the table says what the gate does");
        assert!(gate.admit(EventCode::Started, Severity::Information, 0).is_none());
        assert!(gate.admit(EventCode::Started, Severity::Warning, 0).is_some());
    }

    fn stamped(epoch: u32, seq: u64) -> (Stamps, Event) {
        let mut event = Event::new(EventCode::Ended, PartitionId::SloshId, seq, &[seq as f64]);
        event.header_mut().seq = seq;
        (Stamps { epoch, crc32: telemetry::crc32(event.as_bytes()), sent_ns: seq }, event)
    }

    #[test]
    fn a_ring_cut_at_any_byte_gives_the_records_that_are_whole_and_goes_on_behind_the_newest() {
        let path = std::env::temp_dir().join(format!("obsid-events-{}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let mut log = EventLog::open(&path).unwrap();
        for seq in 1..=3 {
            let (stamps, event) = stamped(0, seq);
            log.write(&stamps, event.as_bytes());
        }
        let whole = std::fs::read(&path).unwrap();
        for cut in 0..=whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(read_log(&path).len(), cut / EVENT_BYTES, "cut at byte {cut}");
        }
        std::fs::write(&path, [&whole[EVENT_BYTES..], &whole].concat()).unwrap();
        let numbers: Vec<u64> = read_log(&path).iter().map(|(_, event)| event.header.seq).collect();
        assert_eq!(numbers, [1, 2, 3], "what is there twice is read once");
        std::fs::write(&path, &whole).unwrap();
        // A restarted partition numbers its events anew from its checkpoint.
        let mut log = EventLog::open(&path).unwrap();
        for seq in 2..2 + LOG_RECORDS {
            let (stamps, event) = stamped(1, seq);
            log.write(&stamps, event.as_bytes());
        }
        let all = read_log(&path);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(all.len() as u64, LOG_RECORDS, "bounded");
        assert_eq!(all.last().unwrap().1.header.seq, 1 + LOG_RECORDS);
    }
}
