//! Parameter tables: values that an operator may change in flight, each with its range.

use crate::names::coded;
use crate::{EventCode, PartitionId};

/// Most values of a table.
pub const TABLE_VALUES_MAX: usize = 32;

coded! {
    /// A parameter table.
    TableId {
        /// Every partition: its deadline, which events it sends, and how many.
        Monitor = 0 "monitor",
        /// Supervisor: limits and longest waits of the mode table.
        Guards = 1 "guards",
    }
}

/// One value of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableField {
    /// Unique in its table, with the unit last.
    pub name: &'static str,
    /// SI unit, `-` for a count or a code.
    pub unit: &'static str,
    /// Smallest value that is valid ...
    pub lowest: f64,
    /// ... and largest one.
    pub highest: f64,
    /// Only whole numbers are valid.
    pub whole: bool,
    /// What it is.
    pub what: &'static str,
}

/// The values of a table, in the order of its fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableValues {
    count: usize,
    values: [f64; TABLE_VALUES_MAX],
}

/// Why values are not a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableFault {
    /// Too few or too many values.
    Count {
        /// Of the values.
        found: usize,
        /// Of the table's fields.
        expected: usize,
    },
    /// A value outside its range, or not whole where it has to be.
    Value {
        /// Place of the field in the table.
        index: usize,
        /// The field.
        field: TableField,
        /// What was given.
        value: f64,
    },
}

impl core::fmt::Display for TableFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TableFault::Count { found, expected } => write!(f, "{found} values, the table has {expected}"),
            TableFault::Value { field, value, .. } => {
                let TableField { name, unit, lowest, highest, whole, .. } = field;
                let whole = if *whole { "a whole number from " } else { "" };
                write!(f, "{name} = {value} {unit}: must be {whole}{lowest} to {highest} {unit}")
            }
        }
    }
}

impl TableValues {
    /// Takes `values` as those of `table`.
    ///
    /// # Errors
    /// Names the first field whose value is not valid.
    pub fn checked(table: TableId, values: &[f64]) -> Result<Self, TableFault> {
        let fields = table.fields();
        if values.len() != fields.len() {
            return Err(TableFault::Count { found: values.len(), expected: fields.len() });
        }
        for (index, (field, &value)) in fields.iter().zip(values).enumerate() {
            // Written so that a value that is no number is not valid.
            let valid = value >= field.lowest && value <= field.highest && (!field.whole || is_whole(value));
            if !valid {
                return Err(TableFault::Value { index, field: *field, value });
            }
        }
        let mut own = [0.0; TABLE_VALUES_MAX];
        own[..values.len()].copy_from_slice(values);
        Ok(TableValues { count: values.len(), values: own })
    }

    /// One per field.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }

    /// CRC-32 (IEEE) over table, version and values: equal tables have equal ones.
    #[must_use]
    pub fn crc32(&self, table: TableId, version: u16) -> u32 {
        let head = crate::layout_hash(0, &table.code().to_le_bytes());
        let head = crate::layout_hash(head, &version.to_le_bytes());
        self.as_slice().iter().fold(head, |crc, value| crate::layout_hash(crc, &value.to_le_bytes()))
    }
}

/// All doubles from 2^53 on are whole.
fn is_whole(value: f64) -> bool {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    value.abs() >= EXACT || value as i64 as f64 == value
}

const fn real(name: &'static str, unit: &'static str, range: [f64; 2], what: &'static str) -> TableField {
    TableField { name, unit, lowest: range[0], highest: range[1], whole: false, what }
}

const fn frames(name: &'static str, what: &'static str) -> TableField {
    TableField { name, unit: "frames", lowest: 0.0, highest: FRAMES_HIGHEST, whole: true, what }
}

const fn most(name: &'static str) -> TableField {
    TableField {
        name,
        unit: "-",
        lowest: 0.0,
        highest: 1e6,
        whole: true,
        what: "events of this code sent in a window; 0: none",
    }
}

/// A year at 100 Hz, and more.
const FRAMES_HIGHEST: f64 = 4e9;
/// Fields of [`TableId::Monitor`] before those of the event codes.
pub const MONITOR_HEAD: usize = 3;

const MONITOR: [TableField; MONITOR_HEAD + EventCode::COUNT] = [
    real(
        "deadline_ms",
        "ms",
        [1e-3, 1e9],
        "from the moment a frame is due until its outputs are sent; later is a miss",
    ),
    real("window_s", "s", [1e-3, 1e5], "time in which events of a code are counted against its limit"),
    TableField {
        name: "severity",
        unit: "-",
        lowest: 0.0,
        highest: 2.0,
        whole: true,
        what: "least severity that is sent: 0 information, 1 warning, 2 alarm",
    },
    most("started"),
    most("bad_samples"),
    most("samples_lost"),
    most("given_up"),
    most("ended"),
    most("deadline_missed"),
    most("cycle_slip"),
    most("squelched"),
    most("mode_entered"),
    most("began_anew"),
    most("command_accepted"),
    most("command_refused"),
    most("command_executed"),
    most("table_loaded"),
    most("table_activated"),
    most("table_refused"),
    most("table_not_stored"),
    most("recording_reduced"),
    most("recordings_removed"),
    most("health_acted"),
];

const GUARDS: [TableField; 6] = [
    real("base_rate_limit_rad_s", "rad/s", [1e-9, 1e3], "above this base rate nothing new is begun"),
    frames("settle_frames", "from contact to the mated experiment"),
    frames("hold_timeout_frames", "longest wait in STANDBY or APPROACH_HOLD for a guard to hold"),
    frames("capture_timeout_frames", "longest wait for contact in CAPTURE"),
    frames("safe_dwell_frames", "stay in SAFE before the run ends without an operator"),
    frames("accepted_age_limit_frames", "oldest model with which CAPTURE is entered"),
];

impl TableId {
    /// Its fields, in the order of the values.
    #[must_use]
    pub const fn fields(self) -> &'static [TableField] {
        match self {
            Self::Monitor => &MONITOR,
            Self::Guards => &GUARDS,
        }
    }

    /// Whether `partition` may have it.
    #[must_use]
    pub const fn is_of(self, partition: PartitionId) -> bool {
        match self {
            Self::Monitor => true,
            Self::Guards => matches!(partition, PartitionId::Supervisor),
        }
    }

    /// The table whose [`TableId::text`] is `name`; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|id| id.text() == name)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    fn valid(table: TableId) -> std::vec::Vec<f64> {
        table.fields().iter().map(|field| field.highest).collect()
    }

    #[test]
    fn every_field_is_refused_outside_its_range_by_name_value_and_range_and_taken_at_both_ends() {
        for &table in TableId::ALL {
            for (index, field) in table.fields().iter().enumerate() {
                let with = |value: f64| {
                    let mut values = valid(table);
                    values[index] = value;
                    TableValues::checked(table, &values)
                };
                assert!(with(field.lowest).is_ok() && with(field.highest).is_ok(), "{}", field.name);
                let span = 1.0 + field.highest.abs();
                for value in [field.lowest - 1.0, field.highest + span, f64::NAN, f64::INFINITY, -f64::INFINITY] {
                    let text = with(value).unwrap_err().to_string();
                    let names_all = text.contains(field.name) && text.contains(&value.to_string());
                    assert!(names_all && text.contains(&field.highest.to_string()), "{text}");
                }
                assert_eq!(with(field.lowest + 0.5).is_err(), field.whole, "{}", field.name);
            }
        }
    }

    #[test]
    fn names_are_unique_and_values_of_another_number_are_refused() {
        for &table in TableId::ALL {
            let fields = table.fields();
            assert!(fields.len() <= TABLE_VALUES_MAX);
            for field in fields {
                assert_eq!(fields.iter().filter(|other| other.name == field.name).count(), 1, "{}", field.name);
            }
            let few = TableValues::checked(table, &valid(table)[1..]).unwrap_err();
            assert_eq!(few, TableFault::Count { found: fields.len() - 1, expected: fields.len() });
            assert_eq!(TableId::named(table.text()), Some(table));
        }
    }

    #[test]
    fn tables_that_differ_in_a_bit_a_version_or_a_kind_have_other_checksums() {
        let values = TableValues::checked(TableId::Guards, &valid(TableId::Guards)).unwrap();
        let mut moved = valid(TableId::Guards);
        moved[0] = f64::from_bits(moved[0].to_bits() - 1);
        let moved = TableValues::checked(TableId::Guards, &moved).unwrap();
        let crc = values.crc32(TableId::Guards, 1);
        assert_ne!(crc, moved.crc32(TableId::Guards, 1));
        assert_ne!(crc, values.crc32(TableId::Guards, 2));
        assert_ne!(crc, values.crc32(TableId::Monitor, 1));
    }
}
