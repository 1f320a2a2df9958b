//! What a run left behind: exit code, result, the warden's log.

use crate::PARTITIONS;
use serde_json::Value;

/// Killed, by us or for a hang.
pub const KILLED: &str = "signal 9";
/// Ended itself, because it found no services.
pub const FOUND_NOTHING: &str = "exit code 5";
/// Ended by the warden, because the services had to be made anew.
pub const TAKEN_DOWN: &str = "taken down, services have vanished";
/// Exit code of a run that got to its end without all that it was to deliver.
pub const DEGRADED: i32 = 4;
const CAUSES: [&str; 3] = [KILLED, FOUND_NOTHING, TAKEN_DOWN];

/// A run that is over.
pub struct Ended {
    pub code: Option<i32>,
    /// The object on standard output; null when there was none.
    pub json: Value,
    /// Standard error: the warden's log and what the partitions said.
    pub log: Vec<String>,
}

/// A line `NAME (pid N) died: CAUSE`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Death {
    pub name: String,
    pub pid: u32,
    pub cause: String,
}

impl Ended {
    /// Identity of the results.
    pub fn digest(&self) -> &str {
        self.json["digest"].as_str().unwrap_or_else(|| panic!("no result: {self}"))
    }

    pub fn partition(&self, name: &str) -> &Value {
        let rows = self.json["partitions"].as_array().map(Vec::as_slice).unwrap_or_default();
        rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("no row of {name}: {self}"))
    }

    pub fn count(&self, name: &str, column: &str) -> u64 {
        self.partition(name)[column].as_u64().unwrap_or_else(|| panic!("{name} has no {column}: {self}"))
    }

    pub fn deaths(&self) -> Vec<Death> {
        let parse = |line: &String| {
            let (who, cause) = line.split_once(" died: ")?;
            let (name, pid) = who.strip_suffix(')')?.split_once(" (pid ")?;
            // What partitions say themselves can share a line with the warden's log.
            let mut partitions = PARTITIONS.into_iter().chain(["diagnosis"]);
            let name = partitions.find(|partition| name.ends_with(partition))?;
            let cause = CAUSES.into_iter().find(|known| cause.starts_with(known)).unwrap_or(cause);
            Some(Death { name: name.into(), pid: pid.parse().ok()?, cause: cause.into() })
        };
        self.log.iter().filter_map(parse).collect()
    }

    /// Names of those whose hang was found.
    pub fn hangs(&self) -> Vec<&str> {
        self.names_before(" hangs: its execution counter stands still")
    }

    pub fn given_up(&self) -> Vec<&str> {
        self.names_before(" was given up")
    }

    fn names_before(&self, what: &str) -> Vec<&str> {
        self.log.iter().filter_map(|line| line.strip_suffix(what)).collect()
    }

    /// Why the console says that the run failed.
    pub fn failure(&self) -> &str {
        self.log.iter().find_map(|line| line.strip_prefix("obsid: ")).unwrap_or_else(|| panic!("no failure: {self}"))
    }

    /// Changes of mode: effective frame, new mode, cause.
    pub fn modes(&self) -> Vec<(u64, &str, &str)> {
        let rows = self.json["modes"].as_array().map(Vec::as_slice).unwrap_or_default();
        rows.iter()
            .map(|row| (row["frame"].as_u64().unwrap(), row["to"].as_str().unwrap(), row["cause"].as_str().unwrap()))
            .collect()
    }

    /// Rows of a domain's parameters.
    pub fn estimates(&self, domain: &str, phase: &str) -> Vec<&Value> {
        let rows = self.json["estimates"][domain].as_array().map(Vec::as_slice).unwrap_or_default();
        rows.iter().filter(|row| row["phase"] == phase).collect()
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "exit code {:?}, modes {:?}, log:\n  {}", self.code, self.modes(), self.log.join("\n  "))
    }
}
