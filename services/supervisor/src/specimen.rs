//! An estimate that passes every test, for the tests of this crate to spoil.

use telemetry::{Domain, Estimate, Innovation, Phase};

/// Closing, before capture, of 6000 rows; its numbers are zero.
pub fn closing(domain: Domain) -> Estimate {
    Estimate {
        domain: domain.code(),
        phase: Phase::PreCapture.code(),
        closing: 1,
        consistent: 1,
        innovation: Innovation {
            variance: 1.0,
            gate: 5.0,
            accepted: 1,
            rows: 6000,
            generation: 1,
            ..Innovation::default()
        },
        nis_mean: 1.0,
        nis_count: 6000.0,
        block_length: [1.0, 10.0, 100.0],
        ..Estimate::default()
    }
}
