//! The `supervisor` partition as a binary of its own, for an on-board computer's image.
use std::process::ExitCode;

fn main() -> ExitCode {
    runtime::process::main(telemetry::PartitionId::Supervisor, supervisor::connect, env!("CARGO_PKG_VERSION"))
}
