//! What a partition that flies links.

use std::process::Command;

/// Readers of other programs' files: a database and an archive format, in C and in Rust.
const OF_THE_DESK: &[&str] = &["rusqlite", "libsqlite3-sys", "hdf5-reader", "clap", "indicatif", "syn"];

/// Names of the packages that `package` links, as cargo resolves it alone.
fn linked(package: &str) -> Vec<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let tree = ["tree", "--offline", "--edges", "no-proc-macro,normal", "--prefix", "none", "--package", package];
    let output = Command::new(cargo).args(tree).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = String::from_utf8(output.stdout).unwrap();
    names.lines().filter_map(|line| line.split(' ').next()).map(String::from).collect()
}

#[test]
fn a_partition_that_flies_links_no_reader_of_other_programs_files() {
    for partition in
        ["sensor-sim", "gateway", "inertial-id", "slosh-id", "modal-id", "supervisor", "recorder", "diagnosis"]
    {
        let linked = linked(&format!("obsid-{partition}"));
        assert!(linked.iter().any(|name| name == "obsid-runtime"), "{partition}: {linked:?}");
        let wrong: Vec<_> = linked.iter().filter(|name| OF_THE_DESK.contains(&name.as_str())).collect();
        assert!(wrong.is_empty(), "{partition} links {wrong:?}");
    }
    assert!(linked("obsid-console").iter().any(|name| name == "rusqlite"), "the desk reads them");
}
