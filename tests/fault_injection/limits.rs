//! Tables of limits for drills: the built-in actions without its patience.

use crate::PARTITIONS;
use crate::world::World;

/// Restarts at once; one second until a hang for those `hanging`, for the others so long that load
/// is no hang.
pub fn table(world: &World, hanging: &[&str]) -> String {
    let row = |name: &&str| {
        let hang_ms = if hanging.contains(name) { 1000 } else { 60_000 };
        let given_up = if name.ends_with("-id") { "go-on" } else { "end-run" };
        format!(
            "[[partition]]\nname = \"{name}\"\nhang_ms = {hang_ms}\nrestarts_max = 5\nrestarts_within_s = 60\n\
             back_off_ms = [0]\ngiven_up = \"{given_up}\"\n"
        )
    };
    let table = format!("format = 1\nstall_s = 60\n{}", PARTITIONS.iter().map(row).collect::<String>());
    let file = world.file("partitions.toml");
    std::fs::write(&file, table).unwrap();
    file.to_str().expect("made of letters and digits").into()
}
