//! Which life of a partition a process is.

/// Which life of a partition a process is, and what ended the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Life {
    /// How often it was started before.
    pub epoch: u32,
    /// 0 none, 1 to 255 signal, 256 + exit code.
    pub cause: u32,
    /// Process id of the warden, whose death is this partition's.
    pub parent: Option<u32>,
}
