//! `obsid man`: manual pages of the program and of every subcommand.

use crate::{Failure, print};
use clap::CommandFactory;
use std::path::{Path, PathBuf};

/// Print the manual page of obsid, or write the pages of all subcommands to a folder
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid man | man -l -
  obsid man --out ~/.local/share/man/man1    obsid.1, obsid-run.1, obsid-plant-check.1, ...; then `man obsid-run`")]
pub struct Arguments {
    /// Write one page per subcommand to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// # Errors
/// [`Failure::Run`] when a page cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let command = crate::Arguments::command().disable_help_subcommand(true);
    let Some(folder) = &arguments.out else {
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page).map_err(|error| cannot(Path::new("obsid.1"), &error))?;
        print(&String::from_utf8_lossy(&page));
        return Ok(());
    };
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(command, folder))
        .map_err(|error| cannot(folder, &error))?;
    print(&format!("{}\n", folder.display()));
    Ok(())
}

fn cannot(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Run(format!("{}: manual pages cannot be written: {error}", path.display()))
}
