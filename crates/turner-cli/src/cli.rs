//! Arguments: the commands, and `turner SCENE` as short for `turner render SCENE`.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use turner::schema::error::nearest;
use turner::schema::{ErrorCode, SceneError};

use crate::control::Control;
use crate::failure::Failure;
use crate::{
    bench, checkpoint, color, compare, convert, doctor, explain, failure, farm, help, info, list, merge, new,
    options, remake, render, report, resume, serve, shell, tonemap, usage, verify, view, watch, window,
};

/// Renders scene files by ray tracing.
#[derive(Debug, Parser)]
#[command(
    name = "turner",
    version,
    styles = color::STYLES,
    disable_help_subcommand = true,
    arg_required_else_help = true,
    subcommand_value_name = "COMMAND | SCENE",
    after_help = "`turner scene.toml` is short for `turner render scene.toml` and writes scene.png.\n\
                  `turner help WORD` explains a command, an option, a key, a kind or an error code;\n\
                  `turner help scene` the scene format. `turner list` lists the names."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Resume(Box<resume::ResumeArgs>),
    Merge(merge::MergeArgs),
    Farm(farm::FarmArgs),
    Remake(Box<remake::RemakeArgs>),
    Watch(Box<watch::WatchArgs>),
    Studio(window::WindowArgs),
    Serve(Box<serve::ServeArgs>),
    New(new::NewArgs),
    Explain(Box<explain::ExplainArgs>),
    Doctor(Box<doctor::DoctorArgs>),
    Compare(compare::CompareArgs),
    Tonemap(tonemap::TonemapArgs),
    View(view::ViewArgs),
    Convert(Box<convert::ConvertArgs>),
    Info(Box<info::InfoArgs>),
    List(list::ListArgs),
    Bench(bench::BenchArgs),
    Verify(verify::VerifyArgs),
    Help(help::HelpArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

/// Runs the command and returns the exit code.
pub(crate) fn run(args: Vec<OsString>, control: &Control) -> u8 {
    match parse(args.clone()).map(|cli| cli.command) {
        Ok(Command::Render(args)) => render::run(&args, control),
        Ok(Command::Resume(args)) => resume::run(&args, control),
        Ok(Command::Merge(args)) => merge::run(&args, control),
        Ok(Command::Farm(args)) => farm::run(&args),
        Ok(Command::Remake(args)) => remake::run(&args, control),
        Ok(Command::Watch(args)) => watch::run(&args, control),
        Ok(Command::Studio(args)) => window::run(&args),
        Ok(Command::Serve(args)) => serve::run(&args, control),
        Ok(Command::New(args)) => new::run(&args),
        Ok(Command::Explain(args)) => explain::run(&args, control),
        Ok(Command::Doctor(args)) => doctor::run(&args, control),
        Ok(Command::Compare(args)) => compare::run(&args),
        Ok(Command::Tonemap(args)) => tonemap::run(&args),
        Ok(Command::View(args)) => view::run(&args),
        Ok(Command::Convert(args)) => convert::run(&args, control),
        Ok(Command::Info(args)) => info::run(&args, control),
        Ok(Command::List(args)) => list::run(&args),
        Ok(Command::Bench(args)) => bench::run(&args),
        Ok(Command::Verify(args)) => verify::run(&args),
        Ok(Command::Help(args)) => help::run(&args),
        Ok(Command::Completions(args)) => shell::completions(&args),
        Ok(Command::Man(args)) => shell::man(&args),
        Err(error) => match usage::failure(&error, &args, &command()) {
            Some(failure) => {
                report::print_error(&failure);
                failure.exit
            }
            None => {
                // Standard output may be closed.
                let _ = error.print();
                u8::try_from(error.exit_code()).unwrap_or(failure::USAGE)
            }
        },
    }
}

/// The command line with its help arranged.
pub(crate) fn command() -> clap::Command {
    options::arrange(Cli::command())
}

fn parse(args: Vec<OsString>) -> Result<Cli, Box<clap::Error>> {
    let mut program = command();
    let matches = program.try_get_matches_from_mut(with_command(args)?)?;
    let mut cli = Cli::from_arg_matches(&matches).map_err(Box::new)?;
    let recorded = |matches| {
        let render = program.find_subcommand("render");
        render.and_then(|render| checkpoint::arguments::recorded(render, matches))
    };
    match (&mut cli.command, matches.subcommand()) {
        (Command::Render(args), Some((_, matches))) => args.recorded = recorded(matches),
        (Command::Watch(args), Some((_, matches))) => args.set_recorded(recorded(matches)),
        _ => {}
    }
    Ok(cli)
}

/// The arguments of a render, given those that a checkpoint records and the scene.
///
/// Errors: an option is unknown or has a wrong value.
pub(crate) fn render_args(recorded: &[String], scene: &Path) -> Result<render::RenderArgs, Failure> {
    let words = ["turner", "render"].into_iter().map(OsString::from);
    let options = recorded.iter().map(OsString::from);
    let scene = [OsString::from("--"), scene.as_os_str().to_owned()];
    let words: Vec<OsString> = words.chain(options).chain(scene).collect();
    match parse(words.clone()).map(|cli| cli.command) {
        Ok(Command::Render(args)) => Ok(*args),
        Err(error) if let Some(failure) = usage::failure(&error, &words, &command()) => Err(failure),
        _ => {
            let message = "the file records options that do not render";
            Err(Failure::new(SceneError::new(ErrorCode::Film, message)))
        }
    }
}

/// The command `render`, to look up its options.
pub(crate) fn render_command() -> clap::Command {
    let mut program = Cli::command();
    program.build();
    program.find_subcommand("render").cloned().unwrap_or_default()
}

/// The names of all commands.
pub(crate) fn command_names() -> Vec<String> {
    Cli::command().get_subcommands().map(|c| c.get_name().to_owned()).collect()
}

/// Inserts `render` before arguments that begin with neither a command nor an option of the program itself.
fn with_command(mut args: Vec<OsString>) -> Result<Vec<OsString>, Box<clap::Error>> {
    const OWN_FLAGS: [&str; 4] = ["-h", "--help", "-V", "--version"];
    let Some(first) = args.get(1) else { return Ok(args) };
    let names = command_names();
    let is = |words: &[&str], arg: &OsStr| words.iter().any(|w| arg == *w);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    if is(&names, first) || is(&OWN_FLAGS, first) {
        return Ok(args);
    }
    // A plain word that names no file is a misspelt command.
    let word = first.to_string_lossy();
    let is_plain = !word.starts_with('-') && !word.contains(['.', '/', '\\']) && !Path::new(first).exists();
    if is_plain && nearest(&word, &names).is_some() {
        let mut error = clap::Error::new(ErrorKind::InvalidSubcommand);
        error.insert(ContextKind::InvalidSubcommand, ContextValue::String(word.clone().into_owned()));
        return Err(Box::new(error));
    }
    args.insert(1, "render".into());
    Ok(args)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(args: &[&str]) -> Option<Vec<String>> {
        let args = std::iter::once("turner").chain(args.iter().copied()).map(OsString::from).collect();
        let args = with_command(args).ok()?;
        Some(args.into_iter().skip(1).map(|a| a.into_string().unwrap()).collect())
    }

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_scene_needs_no_command() {
        for args in [&["a.toml"][..], &["-", "-o", "x.png"], &["--samples", "4", "a.toml"], &["some/render"]]
        {
            assert_eq!(words(args).unwrap()[0], "render", "{args:?}");
        }
        assert_eq!(words(&["info", "a.toml"]).unwrap(), ["info", "a.toml"]);
        assert_eq!(words(&["--version"]).unwrap(), ["--version"]);
        assert_eq!(words(&[]).unwrap(), Vec::<String>::new());
        assert!(words(&["rendr"]).is_none());
    }
}
