//! `turner completions` and `turner man`: completion scripts and manual pages, from the definitions of the arguments.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use turner::schema::ErrorCode;
use turner_io::image::OutputFile;

use crate::failure::{Failure, two_lines};
use crate::{cli, report, text};

/// Write the completion script of a shell to standard output
#[derive(Debug, Args)]
#[command(
    after_help = "For bash: turner completions bash > ~/.local/share/bash-completion/completions/turner\n\
                        For zsh:  turner completions zsh > ~/.zfunc/_turner   (with ~/.zfunc in $fpath)\n\
                        For fish: turner completions fish > ~/.config/fish/completions/turner.fish"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Write the manual page to standard output, or all pages to a folder
#[derive(Debug, Args)]
#[command(after_help = "To read it: turner man | man -l -\n\
                        To install: turner man --into ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// Folder for turner.1, turner-render.1 and so on
    #[arg(long, value_name = "FOLDER")]
    into: Option<PathBuf>,
}

/// Runs `turner completions`.
pub(crate) fn completions(args: &CompletionsArgs) -> u8 {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut cli::command(), "turner", &mut script);
    text::print(&String::from_utf8_lossy(&script));
    0
}

/// Runs `turner man`.
pub(crate) fn man(args: &ManArgs) -> u8 {
    let result = match &args.into {
        None => page(cli::command()).map(|page| text::print(&String::from_utf8_lossy(&page))),
        Some(folder) => write_all(folder),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => {
            report::print_error(&failure);
            failure.exit
        }
    }
}

fn failed(error: &dyn std::fmt::Display) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, &error.to_string()))
}

fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(|e| failed(&e))?;
    Ok(page)
}

/// The page of the program and one for each command.
fn write_all(folder: &std::path::Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|e| failed(&format!("{}: cannot create the folder: {e}", folder.display())))?;
    let mut cli = cli::command();
    cli.build();
    let mut pages = vec![("turner".to_owned(), cli.clone())];
    for command in cli.get_subcommands().filter(|c| !c.is_hide_set()) {
        let name = format!("turner-{}", command.get_name());
        // Pages are named with a hyphen. clap takes names with static lifetime only, so the name is set separately.
        pages.push((name, command.clone().display_name(format!("turner {}", command.get_name()))));
    }
    for (name, command) in pages {
        let path = folder.join(format!("{name}.1"));
        let page = page(command)?;
        OutputFile::create(&path).and_then(|file| file.commit(&page)).map_err(|e| failed(&e))?;
    }
    Ok(())
}
