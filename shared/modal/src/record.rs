//! A record of vibration: outputs, inputs where they are known, and the segments without unknown
//! inputs.

use std::ops::Range;

/// Equidistant samples of all channels, one row after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub sample_rate_hz: f64,
    pub channels: usize,
    /// `outputs[t · channels + c]`.
    pub outputs: Vec<f64>,
    /// Number of known inputs; 0 when only outputs are known.
    pub inputs: usize,
    /// `input[t · inputs + m]`, held from one sample to the next and felt by the sample at which it
    /// begins.
    pub input: Vec<f64>,
    /// Stretches of samples in which only the structure itself moves; output-only methods use these
    /// alone, each by itself.
    pub segments: Vec<Range<usize>>,
}

impl Record {
    /// Outputs alone, one segment.
    #[must_use]
    pub fn of_outputs(sample_rate_hz: f64, channels: usize, outputs: Vec<f64>) -> Self {
        assert!(sample_rate_hz > 0.0);
        assert!(channels > 0);
        assert_eq!(outputs.len() % channels, 0);
        let whole = 0..outputs.len() / channels;
        Self { sample_rate_hz, channels, outputs, inputs: 0, input: Vec::new(), segments: vec![whole] }
    }

    /// The same with known inputs.
    #[must_use]
    pub fn with_input(mut self, inputs: usize, input: Vec<f64>) -> Self {
        assert_eq!(input.len(), inputs * self.samples());
        (self.inputs, self.input) = (inputs, input);
        self
    }

    /// The same with other segments.
    #[must_use]
    pub fn with_segments(mut self, segments: Vec<Range<usize>>) -> Self {
        assert!(segments.iter().all(|segment| segment.start <= segment.end && segment.end <= self.samples()));
        self.segments = segments;
        self
    }

    /// Number of samples per channel.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.outputs.len() / self.channels
    }

    /// Samples of all segments.
    #[must_use]
    pub fn free_samples(&self) -> usize {
        self.segments.iter().map(Range::len).sum()
    }

    /// A stretch of samples with its inputs, as one segment.
    #[must_use]
    pub fn part(&self, over: Range<usize>) -> Self {
        let input = self.input[over.start * self.inputs..over.end * self.inputs].to_vec();
        Self::of_outputs(self.sample_rate_hz, self.channels, self.rows(&over).to_vec()).with_input(self.inputs, input)
    }

    /// One channel over a stretch of samples.
    pub(crate) fn channel(&self, channel: usize, over: Range<usize>) -> Vec<f64> {
        over.map(|t| self.outputs[t * self.channels + channel]).collect()
    }

    /// Rows of a segment.
    pub(crate) fn rows(&self, segment: &Range<usize>) -> &[f64] {
        &self.outputs[segment.start * self.channels..segment.end * self.channels]
    }
}
