//! The program `obsid`.
use std::process::ExitCode;

/// `obsid bench dynamics` states what a step allocates.
#[global_allocator]
static ALLOCATOR: runtime::sys::CountingAllocator = runtime::sys::CountingAllocator;

fn main() -> ExitCode {
    console::main()
}
