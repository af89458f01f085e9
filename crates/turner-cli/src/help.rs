//! `turner help`: of commands, and of the scene format from the tables that read it.

use clap::{Args, CommandFactory};
use turner::scene::error::{ErrorCode, SceneError, escape, suggestion};

use crate::cli::{Cli, command_names};
use crate::failure::Failure;
use crate::{events, failure, reference, report, text};

/// Explain a command, the scene format, or a name in it
#[derive(Debug, Args)]
pub(crate) struct HelpArgs {
    /// A command, `json`, or `scene`
    topic: Option<String>,
    /// After `scene`: a shape, light, section, … [default: an overview]
    name: Option<String>,
    /// The whole reference of the scene format as Markdown
    #[arg(long)]
    markdown: bool,
}

/// Runs the command.
pub(crate) fn run(args: &HelpArgs) -> u8 {
    let help = match (args.topic.as_deref(), args.name.as_deref()) {
        (Some("scene"), None) if args.markdown => Ok(reference::markdown()),
        (Some("scene"), None) => Ok(reference::overview()),
        (Some("scene"), Some(name)) => scene_name(name),
        (Some("json"), None) => Ok(events::SCHEMA.to_owned()),
        (None, _) => command(None),
        (Some(topic), _) => command(Some(topic)),
    };
    match help {
        Ok(help) => {
            text::print(&help);
            0
        }
        Err(failure) => {
            report::print_error(&failure);
            failure.exit
        }
    }
}

fn scene_name(name: &str) -> Result<String, Failure> {
    reference::explain(name).ok_or_else(|| {
        let names = reference::names();
        unknown("scene format has", name, &names)
    })
}

fn command(name: Option<&str>) -> Result<String, Failure> {
    let mut cli = Cli::command();
    cli.build();
    let Some(name) = name else { return Ok(cli.render_long_help().to_string()) };
    if let Some(command) = cli.find_subcommand_mut(name) {
        return Ok(command.render_long_help().to_string());
    }
    // Someone who asks for a sphere means the one of the scene format.
    if let Some(help) = reference::explain(name) {
        return Ok(help);
    }
    let mut names = command_names();
    names.extend(["scene".to_owned(), "json".to_owned()]);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Err(unknown("help has", name, &names))
}

fn unknown(who: &str, name: &str, valid: &[&str]) -> Failure {
    let error = SceneError::new(ErrorCode::UnknownName, format!("the {who} no \"{}\"", escape(name)));
    let error = match suggestion(name, valid) {
        Some(help) => error.help(help),
        None => error,
    };
    Failure { exit: failure::USAGE, ..Failure::new(error) }
}
