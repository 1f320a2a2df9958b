//! `obsid completions SHELL`: completion of subcommands and options in a shell.

use crate::{Failure, print};
use clap::CommandFactory;
use clap_complete::Shell;

/// Print the script that completes subcommands and options in a shell
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid completions bash > ~/.local/share/bash-completion/completions/obsid
  obsid completions zsh > ~/.zfunc/_obsid
  obsid completions fish > ~/.config/fish/completions/obsid.fish")]
pub struct Arguments {
    /// The shell
    shell: Shell,
}

/// # Errors
/// None: that standard output cannot be written is seen at the end of the program.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "obsid", &mut script);
    print(&String::from_utf8_lossy(&script));
    Ok(())
}
