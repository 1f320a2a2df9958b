//! Every figure and every block on one page:
//! `cargo run -p obsid-report --example gallery > gallery.html`.

#[path = "../tests/gallery/mod.rs"]
mod gallery;

use std::io::Write;

fn main() -> std::io::Result<()> {
    std::io::stdout().write_all(&gallery::page().html())
}
