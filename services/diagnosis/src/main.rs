//! The `diagnosis` partition as a binary of its own, for an on-board computer's image.
use std::process::ExitCode;

/// Housekeeping says what the loop allocates.
#[global_allocator]
static ALLOCATOR: runtime::sys::CountingAllocator = runtime::sys::CountingAllocator;

fn main() -> ExitCode {
    runtime::process::main(telemetry::PartitionId::Diagnosis, diagnosis::connect, env!("CARGO_PKG_VERSION"))
}
