//! Rows of the interface control document, derived from the records.

/// One field of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldInfo {
    /// As in the struct.
    pub name: &'static str,
    /// Element type in ROS 1 message spelling.
    pub ros: &'static str,
    /// Array length, 0 for a scalar.
    pub length: usize,
    /// SI unit, `-` for a dimensionless value or a code.
    pub unit: &'static str,
    /// Frame of reference the value is expressed in, `-` where none applies.
    pub frame: &'static str,
    /// Quantity, of what and relative to what.
    pub what: &'static str,
    /// From the first byte of the record \[bytes\].
    pub offset: usize,
    /// Of the whole array where the field is one \[bytes\].
    pub size: usize,
}
