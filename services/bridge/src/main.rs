//! `obsid-bridge`, which `obsid bridge` starts. Its totals are one JSON object on standard output.

use bridge::{BridgeError, Counts};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|first| first == "--version") {
        println!("obsid-bridge {}, telemetry layout {:08x}", env!("CARGO_PKG_VERSION"), telemetry::generation());
        return ExitCode::SUCCESS;
    }
    match bridge::parse(&arguments).and_then(|arguments| bridge::run(&arguments)) {
        Ok(counts) => {
            println!("{}", report(&counts));
            ExitCode::SUCCESS
        }
        Err(error) => {
            runtime::sys::tell(&format!("bridge: {error}\n"));
            // As `obsid` has them.
            ExitCode::from(match error {
                BridgeError::Usage(_) => 2,
                BridgeError::Place(_) | BridgeError::Line { .. } | BridgeError::Refused(_) => 3,
                BridgeError::Link(_) | BridgeError::File(_) => 1,
            })
        }
    }
}

fn report(counts: &Counts) -> serde_json::Value {
    let Counts { offered, sent, resent, given_up, arrived, repeated, lost, damaged, stale } = *counts;
    serde_json::json!({
        "offered": offered, "sent": sent, "resent": resent, "given_up": given_up, "arrived": arrived,
        "repeated": repeated, "lost": lost, "damaged": damaged, "stale": stale,
    })
}
