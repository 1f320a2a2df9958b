//! `--trace FILE`: the markers of all lives as one file that Perfetto (ui.perfetto.dev) opens.
//!
//! Format: JSON of trace events ("Trace Event Format", Google 2016). A process is a partition, its
//! rows are frames, sends and waits; times are microseconds since the first marker.

use crate::partition::PARTITIONS;
use runtime::deaths::DeathRow;
use runtime::trace::{self, Mark, Marker};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use telemetry::{ModeState, PartitionId, TOPICS};

/// Rows of a process.
const FRAMES: u32 = 1;
const SENDS: u32 = 2;
const WAITS: u32 = 3;
const LIVES: u32 = 4;

/// One life's markers.
struct Life {
    partition: PartitionId,
    markers: Vec<Marker>,
}

/// Writes the markers in `folder`, and the `deaths`, to `file`; returns how many events it has.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write(folder: &Path, deaths: &[DeathRow], file: &Path) -> std::io::Result<u64> {
    let mut lives = Vec::new();
    for (id, _) in PARTITIONS {
        let mut epoch = 0;
        // A life that ended before it could note anything has no file.
        let last = deaths.iter().filter(|row| row.partition == id.text()).map(|row| row.epoch + 1).max().unwrap_or(0);
        while epoch <= last {
            if let Ok(markers) = trace::read(&trace::path(folder, *id, epoch)) {
                lives.push(Life { partition: *id, markers });
            }
            epoch += 1;
        }
    }
    let first_ns = lives.iter().flat_map(|life| life.markers.iter().map(|m| m.begin_ns)).min().unwrap_or(0);
    let mut events = Events { out: BufWriter::new(File::create(file)?), first_ns, count: 0 };
    write!(events.out, "{{\"displayTimeUnit\":\"ns\",\"traceEvents\":[")?;
    let has_lived = |id: &PartitionId| lives.iter().any(|life| life.partition == *id);
    for (id, _) in PARTITIONS.iter().filter(|(id, _)| has_lived(id)) {
        events.names(*id)?;
    }
    for life in &lives {
        events.life(life)?;
    }
    for death in deaths {
        events.death(death)?;
    }
    write!(events.out, "\n]}}")?;
    events.out.flush()?;
    Ok(events.count)
}

struct Events {
    out: BufWriter<File>,
    first_ns: u64,
    count: u64,
}

impl Events {
    fn put(&mut self, text: std::fmt::Arguments<'_>) -> std::io::Result<()> {
        let comma = if self.count == 0 { "" } else { "," };
        self.count += 1;
        write!(self.out, "{comma}\n{text}")
    }

    fn names(&mut self, id: PartitionId) -> std::io::Result<()> {
        let pid = id.code() + 1;
        self.put(format_args!(
            "{{\"ph\":\"M\",\"pid\":{pid},\"name\":\"process_name\",\"args\":{{\"name\":\"{id}\"}}}}"
        ))?;
        for (row, name) in [(FRAMES, "frames"), (SENDS, "sends"), (WAITS, "waits"), (LIVES, "lives and modes")] {
            self.put(format_args!(
                "{{\"ph\":\"M\",\"pid\":{pid},\"tid\":{row},\"name\":\"thread_name\",\"args\":{{\"name\":\"{name}\"}}}}"
            ))?;
        }
        Ok(())
    }

    fn us(&self, ns: u64) -> f64 {
        ns.saturating_sub(self.first_ns) as f64 * 1e-3
    }

    fn life(&mut self, life: &Life) -> std::io::Result<()> {
        let pid = life.partition.code() + 1;
        for marker in &life.markers {
            let (ts, dur, argument) = (self.us(marker.begin_ns), marker.length_ns as f64 * 1e-3, marker.argument);
            let mode = || u16::try_from(argument).ok().and_then(ModeState::from_code).map_or("?", ModeState::text);
            let topic = || TOPICS.get(argument as usize).map_or("?", |topic| topic.name);
            let (row, name) = match Mark::of_code(marker.mark) {
                Some(Mark::Frame) => (FRAMES, "frame"),
                Some(Mark::Checkpoint) => (FRAMES, "checkpoint"),
                Some(Mark::Send) => (SENDS, topic()),
                Some(Mark::Wait) => (WAITS, "wait"),
                Some(Mark::Start) => {
                    self.instant(pid, ts, &format!("start of life {argument}"))?;
                    continue;
                }
                Some(Mark::Mode) => {
                    self.instant(pid, ts, mode())?;
                    continue;
                }
                None => continue,
            };
            self.put(format_args!(
                "{{\"ph\":\"X\",\"pid\":{pid},\"tid\":{row},\"ts\":{ts:.3},\"dur\":{dur:.3},\"name\":\"{name}\",\"args\":{{\"n\":{argument}}}}}"
            ))?;
        }
        Ok(())
    }

    fn instant(&mut self, pid: u16, ts: f64, name: &str) -> std::io::Result<()> {
        self.put(format_args!(
            "{{\"ph\":\"i\",\"s\":\"p\",\"pid\":{pid},\"tid\":{LIVES},\"ts\":{ts:.3},\"name\":\"{name}\"}}"
        ))
    }

    /// From the death to the first fresh frame.
    fn death(&mut self, death: &DeathRow) -> std::io::Result<()> {
        let Some(id) = PartitionId::named(&death.partition) else { return Ok(()) };
        let (pid, ts, cause) = (id.code() + 1, self.us(death.noticed_ns), &death.cause);
        match death.recover_ms {
            Some(recover_ms) => self.put(format_args!(
                "{{\"ph\":\"X\",\"pid\":{pid},\"tid\":{LIVES},\"ts\":{ts:.3},\"dur\":{:.3},\"name\":\"restart: {cause}\",\"args\":{{\"n\":{}}}}}",
                recover_ms * 1e3,
                death.epoch
            )),
            None => self.instant(pid, ts, &format!("death: {cause}")),
        }
    }
}
