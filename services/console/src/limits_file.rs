//! The warden's table of limits and actions: `deploy/partitions.toml`, or a file of the user's.

use crate::Failure;
use crate::located::Located;
use crate::plants::utf8_text;
use runtime::config::Limits;
use std::path::Path;
use telemetry::PartitionId;

const DEFAULT: &str = include_str!("../../../deploy/partitions.toml");

/// Reads the table and checks that every partition of the run has a row.
///
/// # Errors
/// [`Failure::Input`] with file, place and cure.
pub fn read(path: Option<&Path>, partitions: &[PartitionId]) -> Result<Limits, Failure> {
    let file = path.map_or("deploy/partitions.toml".to_string(), |path| path.display().to_string());
    let unreadable = |(message, cure): (String, Option<String>)| {
        let cure = cure.unwrap_or_else(|| "give the path of a table of limits, see deploy/partitions.toml".into());
        Failure::Input(miette::miette!(help = cure, "{message}"))
    };
    let text = path.map_or(Ok(DEFAULT.to_string()), |path| utf8_text(path).map_err(unreadable))?;
    let limits: Limits = toml::from_str(&text).map_err(|error| refusal(&file, &text, &error))?;
    if limits.format != 1 {
        return Err(Failure::Input(miette::miette!(
            help = "see deploy/partitions.toml for a table of this build",
            "{file}: format = {}: this build reads format 1",
            limits.format
        )));
    }
    let wrong = limits.rules.iter().find_map(|rule| rule.check().err()).or(limits.check_health().err());
    if let Some(wrong) = wrong.or(limits.recording.check().err()) {
        let cure = "see deploy/partitions.toml for [[rule]], [[health]] and [recording]";
        return Err(Failure::Input(miette::miette!(help = cure, "{file}: {wrong}")));
    }
    match limits.missing(partitions) {
        Some(id) => {
            Err(Failure::Input(miette::miette!(help = "add a [[partition]] for it", "{file}: no row for {id}")))
        }
        None => Ok(limits),
    }
}

/// An unknown key or a wrong type, at its place.
fn refusal(file: &str, text: &str, error: &toml::de::Error) -> Failure {
    let span = error.span().unwrap_or(0..0);
    let offending = text.get(span.clone()).unwrap_or("").lines().next().unwrap_or("");
    let message = format!("{} (at '{offending}')", error.message());
    Failure::input(Located::new(file, text, span, message, "see deploy/partitions.toml for every key".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_table_has_a_row_for_every_partition() {
        let limits = read(None, PartitionId::ALL).unwrap();
        assert_eq!(limits.missing(PartitionId::ALL), None);
    }

    /// The built-in table and `rows`.
    fn with(rows: &str) -> Result<Limits, Failure> {
        let path = std::env::temp_dir().join(format!("obsid-health-{}.toml", std::process::id()));
        std::fs::write(&path, format!("{DEFAULT}\n{rows}")).unwrap();
        let limits = read(Some(&path), PartitionId::ALL);
        std::fs::remove_file(&path).unwrap();
        limits
    }

    #[test]
    fn a_health_table_is_read_and_a_row_that_is_never_reached_is_refused() {
        let row = |count: u32| format!("[[health]]\nlevel = \"partition\"\ncount = {count}\naction = \"safe-mode\"\n");
        let Ok(limits) = with(&row(5)) else { panic!("refused") };
        let own = &limits.health[0];
        assert_eq!((own.within_s, own.cool_down_s, own.acts_max, own.partition), (60.0, 0.0, None, None));
        let Err(Failure::Input(report)) = with(&row(6)) else { panic!("accepted") };
        assert!(report.to_string().contains("count = 6 is never reached"), "{report}");
    }

    #[test]
    fn a_table_without_a_row_for_a_partition_is_refused_by_name() {
        let path = std::env::temp_dir().join(format!("obsid-limits-{}.toml", std::process::id()));
        std::fs::write(&path, "format = 1\nstall_s = 9\npartition = []\n").unwrap();
        let refused = read(Some(&path), &[PartitionId::SloshId]);
        std::fs::remove_file(&path).unwrap();
        let Err(Failure::Input(report)) = refused else { panic!("accepted") };
        assert!(report.to_string().contains("slosh-id"), "{report}");
    }
}
