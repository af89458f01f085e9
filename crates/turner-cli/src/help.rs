//! `turner help`: commands, options, error codes and every name of the scene format, from the tables that parse them.

use clap::Args;
use turner::schema::error::{escape, nearest};
use turner::schema::{ErrorCode, SceneError};

use crate::cli::{self, command_names};
use crate::failure::Failure;
use crate::{color, events, failure, lookup, reference, report, text};

/// Explain a command, an option, an error code, or any word of the scene format
#[derive(Debug, Args)]
pub(crate) struct HelpArgs {
    /// A command, an option, a section, kind, key or value, an error code, `json`, or `scene`
    #[arg(allow_hyphen_values = true)]
    topic: Option<String>,
    /// After `scene`: a section, kind, key or value [default: an overview]
    name: Option<String>,
    /// Print the complete reference of the scene format as Markdown
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
        (Some("scene"), Some(name)) => word(name).map(paint),
        (Some("json"), None) => Ok(events::SCHEMA.to_owned()),
        (None, _) => Ok(command(None, colors).unwrap_or_default()),
        (Some(topic), _) => match command(Some(topic), colors) {
            Some(help) => Ok(help),
            None => word(topic).map(paint),
        },
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

/// The help of a command; `None` if there is no such command.
fn command(name: Option<&str>, colors: bool) -> Option<String> {
    let shown =
        |help: clap::builder::StyledStr| if colors { help.ansi().to_string() } else { help.to_string() };
    let mut cli = cli::command();
    cli.build();
    match name {
        None => Some(shown(cli.render_long_help())),
        Some(name) => cli.find_subcommand_mut(name).map(|command| shown(command.render_help())),
    }
}

fn word(name: &str) -> Result<String, Failure> {
    let mut cli = cli::command();
    cli.build();
    lookup::explain(name, &cli).ok_or_else(|| {
        let mut names: Vec<String> = lookup::words(&cli).into_iter().collect();
        names.extend(command_names());
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error =
            SceneError::new(ErrorCode::UnknownName, format!("there is no help on \"{}\"", escape(name)));
        let near = nearest(name, &names);
        let error = match near {
            Some(near) => error.help(format!("did you mean \"{}\"?", escape(near))),
            None => error.help("`turner help scene` gives an overview, `turner list` lists the names"),
        };
        Failure { exit: failure::USAGE, ..Failure::new(error) }
    })
}
