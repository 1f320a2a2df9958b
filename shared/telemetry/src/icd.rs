//! Rows of the interface control document, derived from the records.

/// One field of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldInfo {
    pub name: &'static str,
    /// Element type in ROS 1 message spelling.
    pub ros: &'static str,
    /// Array length, 0 for a scalar.
    pub length: usize,
    pub unit: &'static str,
    /// Frame of reference the value is expressed in, `-` where none applies.
    pub frame: &'static str,
    pub what: &'static str,
    pub offset: usize,
    pub size: usize,
}
