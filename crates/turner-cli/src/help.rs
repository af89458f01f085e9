//! `turner help`: of commands, and of the scene format from the tables that read it.

use clap::{Args, CommandFactory};
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, SceneError};

use crate::cli::{Cli, command_names};
use crate::failure::Failure;
use crate::{color, events, failure, reference, report, text};

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
    let colors = color::are_wanted(&std::io::stdout());
    let paint = |text: String| if colors { color::paint(&text) } else { text };
    let help = match (args.topic.as_deref(), args.name.as_deref()) {
        (Some("scene"), None) if args.markdown => Ok(reference::markdown()),
        (Some("scene"), None) => Ok(paint(reference::overview())),
        (Some("scene"), Some(name)) => scene_name(name).map(paint),
        (Some("json"), None) => Ok(events::SCHEMA.to_owned()),
        (None, _) => command(None, colors),
        (Some(topic), _) => command(Some(topic), colors),
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

/// The help of a command, with `colors` if they are wanted.
fn command(name: Option<&str>, colors: bool) -> Result<String, Failure> {
    let shown =
        |help: clap::builder::StyledStr| if colors { help.ansi().to_string() } else { help.to_string() };
    let mut cli = Cli::command();
    cli.build();
    let Some(name) = name else { return Ok(shown(cli.render_long_help())) };
    if let Some(command) = cli.find_subcommand_mut(name) {
        return Ok(shown(command.render_long_help()));
    }
    // Someone who asks for a sphere means the one of the scene format.
    if let Some(help) = reference::explain(name) {
        return Ok(if colors { color::paint(&help) } else { help });
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
