//! Who may import whom: the resolved dependency graph against the rules of the architecture.

use crate::desk::workspace;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Normal dependencies of every package in the resolved graph, by package name.
struct Graph {
    direct: BTreeMap<String, BTreeSet<String>>,
    services: BTreeSet<String>,
    shared: BTreeSet<String>,
}

impl Graph {
    fn read() -> Self {
        // Packages of other platforms need not be on this machine.
        let rustc = Command::new("rustc").arg("-vV").output().unwrap();
        let rustc = String::from_utf8(rustc.stdout).unwrap();
        let host = rustc.lines().find_map(|line| line.strip_prefix("host: ")).expect("rustc names its host");
        let output = Command::new(env!("CARGO"))
            .args(["metadata", "--offline", "--locked", "--format-version", "1", "--filter-platform", host])
            .current_dir(workspace())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
        let packages = metadata["packages"].as_array().unwrap();
        let name_of: BTreeMap<&str, &str> = packages.iter().map(|p| (text(&p["id"]), text(&p["name"]))).collect();
        let mut direct: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for node in metadata["resolve"]["nodes"].as_array().unwrap() {
            let dependencies = node["deps"].as_array().unwrap().iter().filter(|dependency| is_normal(dependency));
            let names = dependencies.map(|dependency| name_of[text(&dependency["pkg"])].to_string());
            direct.entry(name_of[text(&node["id"])].to_string()).or_default().extend(names);
        }
        let members = |folder: &str| {
            let folder = workspace().join(folder).display().to_string();
            let inside =
                packages.iter().filter(|p| p["source"].is_null() && text(&p["manifest_path"]).starts_with(&folder));
            inside.map(|p| text(&p["name"]).to_string()).collect()
        };
        Graph { direct, services: members("services"), shared: members("shared") }
    }

    /// Everything that is linked into `package`.
    fn all(&self, package: &str) -> BTreeSet<&str> {
        let mut found = BTreeSet::new();
        let mut open = vec![package];
        while let Some(next) = open.pop() {
            for dependency in self.direct.get(next).into_iter().flatten() {
                if found.insert(dependency.as_str()) {
                    open.push(dependency);
                }
            }
        }
        found
    }

    fn importers(&self, package: &str) -> BTreeSet<&str> {
        let members = self.services.iter().chain(&self.shared);
        members.filter(|member| self.direct[*member].contains(package)).map(String::as_str).collect()
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

fn is_normal(dependency: &Value) -> bool {
    dependency["dep_kinds"].as_array().unwrap().iter().any(|kind| kind["kind"].is_null())
}

#[test]
fn a_flight_partition_carries_no_batch_algebra_no_files_and_no_simulator() {
    let graph = Graph::read();
    let desk = ["obsid-discovery", "obsid-recording", "obsid-report", "obsid-plant", "mcap", "csv"];
    for partition in ["obsid-inertial-id", "obsid-slosh-id", "obsid-supervisor", "obsid-modal-id"] {
        let linked = graph.all(partition);
        assert!(linked.contains("obsid-runtime") && linked.contains("iceoryx2"), "the graph was read: {partition}");
        for crate_name in desk {
            assert!(!linked.contains(crate_name), "{partition} links {crate_name}");
        }
        for crate_name in ["faer", "obsid-modal"] {
            assert_eq!(linked.contains(crate_name), partition == "obsid-modal-id", "{partition}, {crate_name}");
        }
    }
    // faer comes into modal-id through modal alone.
    let faer: BTreeSet<&str> =
        graph.all("obsid-modal-id").into_iter().filter(|name| name.starts_with("obsid-")).collect();
    let direct: Vec<&&str> = faer.iter().filter(|name| graph.direct[**name].contains("faer")).collect();
    assert_eq!(direct, [&"obsid-modal"]);
    assert!(!graph.direct["obsid-modal-id"].contains("faer"));
}

#[test]
fn the_simulated_truth_is_known_to_the_source_and_the_desk_alone() {
    let graph = Graph::read();
    let importers = graph.importers("obsid-plant");
    let allowed = BTreeSet::from(["obsid-sensor-sim", "obsid-console", "obsid-discovery", "obsid-challenge"]);
    assert!(importers.contains("obsid-sensor-sim") && importers.is_subset(&allowed), "{importers:?}");
}

#[test]
fn shared_memory_is_reached_through_the_runtime_alone() {
    let graph = Graph::read();
    let importers = graph.importers("iceoryx2");
    assert!(importers.contains("obsid-runtime"), "{importers:?}");
    assert!(importers.is_subset(&BTreeSet::from(["obsid-runtime", "obsid-telemetry"])), "{importers:?}");
}

#[test]
fn services_meet_in_samples_only_and_no_library_knows_a_service() {
    let graph = Graph::read();
    assert!(graph.services.len() >= 7 && graph.shared.len() >= 7, "{:?} {:?}", graph.services, graph.shared);
    for service in graph.services.iter().filter(|service| *service != "obsid-console") {
        let met: Vec<&String> = graph.direct[service].intersection(&graph.services).collect();
        assert!(met.is_empty(), "{service} depends on {met:?}");
    }
    for library in &graph.shared {
        let met: Vec<&String> = graph.direct[library].intersection(&graph.services).collect();
        assert!(met.is_empty(), "{library} depends on {met:?}");
    }
}

#[test]
fn libraries_import_downwards_only() {
    let graph = Graph::read();
    let own = |library: &str| -> BTreeSet<&str> {
        graph.all(library).into_iter().filter(|name| graph.shared.contains(*name)).collect()
    };
    assert!(own("obsid-telemetry").is_empty());
    assert!(own("obsid-estimation").is_empty());
    assert!(!own("obsid-physics").contains("obsid-plant"));
    assert!(!own("obsid-plant").contains("obsid-physics") && !own("obsid-plant").contains("obsid-estimation"));
    assert_eq!(own("obsid-recording"), BTreeSet::from(["obsid-telemetry"]));
}

#[test]
fn there_is_one_nalgebra() {
    let lock = std::fs::read_to_string(workspace().join("Cargo.lock")).unwrap();
    assert_eq!(lock.lines().filter(|line| *line == "name = \"nalgebra\"").count(), 1);
}

#[test]
fn unsafe_stands_in_the_allocator_alone() {
    let mut open: Vec<_> = ["services", "shared", "tests"].map(|folder| workspace().join(folder)).into();
    let mut found = BTreeSet::new();
    let mut read = 0;
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                open.push(entry);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                read += 1;
                let text = std::fs::read_to_string(&entry).unwrap();
                // spelled in two parts, or this file would find itself
                if ["fn ", "impl ", "{"].iter().any(|after| text.contains(&format!("{}{after}", "unsafe "))) {
                    found.insert(entry.strip_prefix(workspace()).unwrap().display().to_string());
                }
            }
        }
    }
    assert!(read > 100, "only {read} files were read");
    assert_eq!(found, BTreeSet::from(["shared/runtime/src/sys/allocations.rs".to_string()]));
}
