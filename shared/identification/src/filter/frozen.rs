//! Gains that one pass of a filter found and later passes keep.

/// Frozen gains of one run: per event rows of z times columns of samples, one after the other, and
/// their first places.
#[derive(Clone, Debug, Default)]
pub struct Frozen {
    pub rows: usize,
    pub gain: Vec<f64>,
    /// Of each event.
    pub first: Vec<usize>,
}

impl Frozen {
    /// Of a free run over so many events: none.
    pub fn of_free_run(events: usize) -> Self {
        Self { rows: 0, gain: Vec::new(), first: vec![0; events] }
    }
}
