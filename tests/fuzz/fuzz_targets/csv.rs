#![no_main]

#[path = "../bodies.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (_, body) = bodies::BODIES.iter().find(|(name, _)| *name == "csv").expect("a body");
    body(bytes);
});
