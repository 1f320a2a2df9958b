//! Events: what happened, with its arguments as numbers; the text is made where it is read.

use crate::header::Header;
use crate::layout::record;
use crate::names::coded;
use crate::{CodeList, HealthAction, HealthError, HealthLevel, ModeState, Opcode, PartitionId, Refusal, TableId};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// Most arguments of an event.
pub const EVENT_ARGUMENTS_MAX: usize = 4;

coded! {
    /// How grave an event is.
    Severity {
        Information = 0 "information",
        Warning = 1 "warning",
        /// Never filtered, never squelched.
        Alarm = 2 "alarm",
    }
}

coded! {
    /// What an event speaks of.
    EventCode {
        Started = 1 "started",
        BadSamples = 2 "bad samples dropped",
        SamplesLost = 3 "samples lost",
        GivenUp = 4 "partition given up",
        Ended = 5 "ended",
        DeadlineMissed = 6 "deadline missed",
        CycleSlip = 7 "cycles slipped",
        Squelched = 8 "events squelched",
        ModeEntered = 9 "mode entered",
        BeganAnew = 10 "no checkpoint is whole: began anew",
        CommandAccepted = 11 "command accepted",
        CommandRefused = 12 "command refused",
        CommandExecuted = 13 "command executed",
        TableLoaded = 14 "table loaded",
        TableActivated = 15 "table activated",
        TableRefused = 16 "table refused",
        TableNotStored = 17 "table not stored: the file system refuses",
        RecordingReduced = 18 "recording fills up: topics are left out",
        RecordingsRemoved = 19 "older recordings removed",
        HealthActed = 20 "health table acted",
    }
}

/// One argument of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArgumentInfo {
    /// What it is.
    pub name: &'static str,
    /// SI unit, `-` for a count or a code.
    pub unit: &'static str,
    /// Where it is a code: of which list.
    pub codes: Option<CodeList>,
}

const fn number(name: &'static str, unit: &'static str) -> ArgumentInfo {
    ArgumentInfo { name, unit, codes: None }
}

const fn code(name: &'static str, codes: CodeList) -> ArgumentInfo {
    ArgumentInfo { name, unit: "-", codes: Some(codes) }
}

const KEY: ArgumentInfo = number("key", "-");
const OPCODE: ArgumentInfo = code("command", Opcode::LIST);
const TABLE: ArgumentInfo = code("table", TableId::LIST);
const SINCE: ArgumentInfo = number("samples", "-");
const TOTAL: ArgumentInfo = number("in all", "-");

impl EventCode {
    /// How many there are; the length of tables indexed by [`EventCode::index`].
    pub const COUNT: usize = Self::ALL.len();

    /// Place in such a table.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize - 1
    }

    /// Unless whoever reports it says otherwise.
    #[must_use]
    pub const fn severity(self) -> Severity {
        match self {
            Self::GivenUp => Severity::Alarm,
            Self::BadSamples
            | Self::SamplesLost
            | Self::DeadlineMissed
            | Self::CycleSlip
            | Self::Squelched
            | Self::BeganAnew
            | Self::CommandRefused
            | Self::TableRefused
            | Self::TableNotStored
            | Self::RecordingReduced
            | Self::HealthActed => Severity::Warning,
            _ => Severity::Information,
        }
    }

    /// Whether it answers a command: who sent one waits for it.
    #[must_use]
    pub const fn is_answer(self) -> bool {
        matches!(
            self,
            Self::CommandAccepted
                | Self::CommandRefused
                | Self::CommandExecuted
                | Self::TableLoaded
                | Self::TableActivated
                | Self::TableRefused
        )
    }

    /// What its arguments are, in their order.
    #[must_use]
    pub const fn arguments(self) -> &'static [ArgumentInfo] {
        match self {
            Self::Started => {
                const { &[number("restarts", "-"), number("cause: 0 none, 1 to 255 signal, 256 + exit code", "-")] }
            }
            Self::BadSamples | Self::SamplesLost => const { &[SINCE, TOTAL] },
            Self::GivenUp => const { &[code("partition", PartitionId::LIST)] },
            Self::Ended => const { &[number("frames", "-")] },
            Self::DeadlineMissed => const { &[number("after the frame was due", "us"), TOTAL] },
            Self::CycleSlip => const { &[number("cycles", "-"), TOTAL] },
            Self::Squelched => const { &[code("event", Self::LIST), number("not sent", "-")] },
            Self::ModeEntered => const { &[code("mode", ModeState::LIST)] },
            Self::BeganAnew => const { &[number("frame", "-")] },
            Self::CommandAccepted => const { &[KEY, OPCODE, number("sequence", "-"), number("not before frame", "-")] },
            Self::CommandRefused => {
                const { &[KEY, OPCODE, code("reason", Refusal::LIST), number("last sequence", "-")] }
            }
            Self::CommandExecuted => const { &[KEY, OPCODE, number("frame", "-")] },
            Self::TableLoaded => const { &[TABLE, number("version", "-")] },
            Self::TableActivated => const { &[TABLE, number("version", "-"), number("crc32", "-")] },
            Self::TableRefused => const { &[TABLE, number("field", "-"), number("value", "of the field")] },
            Self::TableNotStored => const { &[TABLE] },
            Self::RecordingReduced => {
                const { &[number("topics", "-"), number("size", "B"), number("samples left out so far", "-")] }
            }
            Self::RecordingsRemoved => const { &[number("files", "-"), number("size", "B")] },
            Self::HealthActed => {
                const {
                    &[
                        code("action", HealthAction::LIST),
                        code("error", HealthError::LIST),
                        code("level", HealthLevel::LIST),
                        code("partition", PartitionId::LIST),
                    ]
                }
            }
        }
    }
}

record! {
    /// Something happened that an operator would want to read.
    Event {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frames that the partition had done";
        partition: u16, "-", "-", "reporting partition, code of PartitionId";
        severity: u16, "-", "-", "code of Severity";
        code: u16, "-", "-", "code of EventCode, which says what the arguments are";
        count: u16, "-", "-", "arguments in use";
        squelched: u64, "-", "-", "events of the same code that were not sent since the last one that was";
        argument: [f64; EVENT_ARGUMENTS_MAX], "of the code", "-", "arguments";
    }
}

impl Event {
    /// An event of `partition` that has done `frame` frames; arguments beyond the fourth are left
    /// out.
    #[must_use]
    pub fn new(code: EventCode, partition: PartitionId, frame: u64, arguments: &[f64]) -> Self {
        let count = arguments.len().min(EVENT_ARGUMENTS_MAX);
        let mut argument = [0.0; EVENT_ARGUMENTS_MAX];
        argument[..count].copy_from_slice(&arguments[..count]);
        Event {
            header: Header::at(0),
            frame,
            partition: partition.code(),
            severity: code.severity().code(),
            code: code.code(),
            count: count as u16,
            squelched: 0,
            argument,
        }
    }

    /// `None` for a code of another build.
    #[must_use]
    pub fn known_code(&self) -> Option<EventCode> {
        EventCode::from_code(self.code)
    }

    /// Of an unknown code an alarm: it is shown.
    #[must_use]
    pub fn known_severity(&self) -> Severity {
        Severity::from_code(self.severity).unwrap_or(Severity::Alarm)
    }
}

impl core::fmt::Display for Event {
    /// `deadline missed: after the frame was due 10400 us, in all 3`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Some(code) = self.known_code() else { return write!(f, "event {} of another build", self.code) };
        f.write_str(code.text())?;
        let used = &self.argument[..usize::from(self.count).min(EVENT_ARGUMENTS_MAX)];
        for (index, (info, value)) in code.arguments().iter().zip(used).enumerate() {
            f.write_str(if index == 0 { ": " } else { ", " })?;
            f.write_str(info.name)?;
            let named = |codes: CodeList| codes.codes.iter().find(|(code, _)| f64::from(*code) == *value);
            match (info.codes.and_then(named), info.unit) {
                (Some((_, text)), _) => write!(f, " {text}")?,
                (None, "-" | "of the field") => write!(f, " {value}")?,
                (None, unit) => write!(f, " {value} {unit}")?,
            }
        }
        if self.squelched > 0 {
            write!(f, " ({} more of these were squelched)", self.squelched)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn codes_are_contiguous_from_one_and_no_event_has_more_arguments_than_a_sample_holds() {
        for (at, code) in EventCode::ALL.iter().enumerate() {
            assert_eq!((usize::from(code.code()), code.index()), (at + 1, at));
            assert!(code.arguments().len() <= EVENT_ARGUMENTS_MAX, "{code}");
        }
    }

    #[test]
    fn an_event_reads_as_a_sentence_with_codes_as_names() {
        let lost = Event::new(EventCode::GivenUp, PartitionId::Supervisor, 7, &[2.0]);
        assert_eq!(lost.to_string(), "partition given up: partition slosh-id");
        let late = Event { squelched: 12, ..Event::new(EventCode::CycleSlip, PartitionId::SensorSim, 7, &[1.0, 3.0]) };
        assert_eq!(late.to_string(), "cycles slipped: cycles 1, in all 3 (12 more of these were squelched)");
        assert_eq!(Event { code: 999, ..late }.to_string(), "event 999 of another build");
    }
}
