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

/// The rooms of `shared/` and what of them each may import.
const ROOMS: &[(&str, &[&str])] = &[
    ("telemetry", &[]),
    ("estimation", &[]),
    ("units", &[]),
    ("channels", &["estimation"]),
    ("dynamics", &["estimation"]),
    ("catalogue", &["dynamics"]),
    ("plant-file", &["catalogue", "dynamics", "telemetry", "units"]),
    ("simulation", &["channels", "dynamics"]),
    ("identification", &["catalogue", "channels", "dynamics", "estimation"]),
    ("recording", &["channels", "telemetry", "units"]),
    ("examination", &["channels", "estimation", "identification"]),
    (
        "discovery",
        &[
            "catalogue",
            "channels",
            "dynamics",
            "estimation",
            "examination",
            "identification",
            "plant-file",
            "simulation",
        ],
    ),
    ("challenge", &["catalogue", "channels", "discovery", "dynamics", "identification", "plant-file"]),
    ("physics", &["estimation"]),
    ("modal", &[]),
    (
        "bench",
        &[
            "channels",
            "dynamics",
            "estimation",
            "examination",
            "identification",
            "modal",
            "physics",
            "plant-file",
            "recording",
            "simulation",
        ],
    ),
    ("report", &[]),
    ("delivery", &[]),
    ("runtime", &["telemetry"]),
    ("craft", &["channels", "dynamics", "estimation", "identification", "plant-file", "runtime", "telemetry"]),
];

/// What flies: partitions on the on-board computer, the recorder and the simulated source apart.
const FLIGHT: [&str; 5] =
    ["obsid-gateway", "obsid-inertial-id", "obsid-slosh-id", "obsid-supervisor", "obsid-modal-id"];

#[test]
fn every_room_imports_what_it_may_and_nothing_else() {
    let graph = Graph::read();
    let known: BTreeSet<String> = ROOMS.iter().map(|(room, _)| format!("obsid-{room}")).collect();
    assert_eq!(known, graph.shared, "every crate of shared/ has its row");
    for (room, may) in ROOMS {
        let may: BTreeSet<String> = may.iter().map(|name| format!("obsid-{name}")).collect();
        let imports: BTreeSet<String> =
            graph.direct[&format!("obsid-{room}")].intersection(&graph.shared).cloned().collect();
        assert!(imports.is_subset(&may), "{room} imports {:?}", imports.difference(&may).collect::<Vec<_>>());
    }
}

#[test]
fn a_flight_partition_carries_no_batch_algebra_no_recordings_and_no_simulator() {
    let graph = Graph::read();
    let desk = ["simulation", "discovery", "examination", "challenge", "bench", "recording", "report"];
    let desk = desk.map(|room| format!("obsid-{room}"));
    for partition in FLIGHT {
        let linked = graph.all(partition);
        assert!(linked.contains("obsid-runtime") && linked.contains("iceoryx2"), "the graph was read: {partition}");
        for crate_name in desk.iter().map(String::as_str).chain(["mcap", "csv"]) {
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
fn of_the_partitions_the_one_that_diagnoses_alone_links_the_search_and_no_recordings() {
    let graph = Graph::read();
    let importers = BTreeSet::from(["obsid-challenge", "obsid-console", "obsid-diagnosis"]);
    assert_eq!(graph.importers("obsid-discovery"), importers);
    let linked = graph.all("obsid-diagnosis");
    for room in ["recording", "report", "challenge", "bench"] {
        assert!(!linked.contains(format!("obsid-{room}").as_str()), "{room}");
    }
}

#[test]
fn the_simulated_truth_is_known_to_the_source_and_the_desk_alone() {
    let graph = Graph::read();
    let importers = graph.importers("obsid-simulation");
    let allowed = BTreeSet::from(["obsid-sensor-sim", "obsid-console", "obsid-discovery", "obsid-bench"]);
    assert!(importers.contains("obsid-sensor-sim") && importers.is_subset(&allowed), "{importers:?}");
}

/// The sealed cases have equations, an integrator and noise of their own: of `dynamics` they know
/// how a plant is described.
#[test]
fn the_challenge_shares_no_equations_with_what_it_tests() {
    let folder = workspace().join("shared/challenge/src");
    let mut open = vec![folder];
    let mut read = 0;
    while let Some(folder) = open.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                open.push(path);
                continue;
            }
            // its tests hold both formulations against each other
            if path.file_name().is_some_and(|name| name == "tests.rs") {
                continue;
            }
            read += 1;
            let text = std::fs::read_to_string(&path).unwrap();
            for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
                for rest in line.split("dynamics::").skip(1) {
                    let is_described = rest.starts_with("description") || rest.starts_with("effect");
                    assert!(is_described, "{} names dynamics::{rest}", path.display());
                }
            }
        }
    }
    assert!(read > 20, "only {read} files were read");
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
fn there_is_one_nalgebra() {
    let lock = std::fs::read_to_string(workspace().join("Cargo.lock")).unwrap();
    assert_eq!(lock.lines().filter(|line| *line == "name = \"nalgebra\"").count(), 1);
}

#[test]
fn unsafe_stands_in_the_allocator_the_scheduling_and_the_probes_of_forbidden_acts_alone() {
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
    let allowed = ["allocations", "probes", "schedule"].map(|file| format!("shared/runtime/src/sys/{file}.rs"));
    assert_eq!(found, BTreeSet::from(allowed));
}
