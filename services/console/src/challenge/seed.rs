//! The seed of a challenge: a number, or that of the commit.
//!
//! A seed that is chosen can be learned. The first eight hexadecimal digits of the commit are new
//! for every change of the code, and nobody chooses them.

use crate::Failure;
use std::process::Command;
use std::str::FromStr;

/// Hexadecimal digits of a commit that a seed is made of.
const DIGITS: usize = 8;

/// `--seed`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeedWord {
    /// The number itself.
    Number(u64),
    /// The number of the commit of the repository around the working directory.
    Auto,
}

impl FromStr for SeedWord {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "auto" => Ok(Self::Auto),
            _ => word.parse().map(Self::Number).map_err(|_| format!("'{word}' is neither a number nor `auto`")),
        }
    }
}

impl SeedWord {
    /// # Errors
    /// [`Failure::Input`] where `auto` meets no repository, or changes that are not committed.
    pub fn number(self) -> Result<u64, Failure> {
        match self {
            Self::Number(seed) => Ok(seed),
            Self::Auto => of_commit(&git(&["rev-parse", "HEAD"])?, &git(&["status", "--porcelain"])?),
        }
    }
}

fn refused(why: &str) -> Failure {
    Failure::Input(miette::miette!(help = "give a seed of your own: --seed N", "--seed auto: {why}"))
}

/// Standard output of git in the working directory.
fn git(words: &[&str]) -> Result<String, Failure> {
    let said = Command::new("git").args(words).output().map_err(|error| refused(&format!("git: {error}")))?;
    if !said.status.success() {
        let why = String::from_utf8_lossy(&said.stderr);
        return Err(refused(why.lines().next().unwrap_or("git says nothing")));
    }
    Ok(String::from_utf8_lossy(&said.stdout).trim().to_owned())
}

/// The seed of `commit`, where `status` lists no change.
fn of_commit(commit: &str, status: &str) -> Result<u64, Failure> {
    if !status.is_empty() {
        let changes = status.lines().count();
        return Err(refused(&format!(
            "{changes} changes are not committed, and the commit does not say what is judged"
        )));
    }
    let digits = commit.get(..DIGITS).ok_or_else(|| refused("the commit has no name"))?;
    u64::from_str_radix(digits, 16).map_err(|error| refused(&format!("commit '{commit}': {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commit_gives_its_first_eight_digits_and_a_change_that_is_not_committed_gives_none() {
        assert_eq!(of_commit("4fc49220aa00", "").unwrap(), 0x4fc4_9220);
        let Err(Failure::Input(report)) = of_commit("4fc49220aa00", " M src/lib.rs") else { panic!("a seed") };
        assert!(report.help().is_some_and(|help| help.to_string().contains("--seed N")), "{report}");
    }

    #[test]
    fn a_seed_is_a_number_or_auto() {
        assert_eq!("7".parse(), Ok(SeedWord::Number(7)));
        assert_eq!("auto".parse(), Ok(SeedWord::Auto));
        assert!("seven".parse::<SeedWord>().is_err());
    }
}
