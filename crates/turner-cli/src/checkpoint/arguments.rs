//! The options of a render as a checkpoint records them: those that the picture depends on.

use clap::parser::ValueSource;
use clap::{ArgAction, ArgMatches, Command};

/// Options that do not change the samples, or that a file must not decide: what may be read, where output goes, how
/// much memory is used. A new option is recorded unless it is listed here.
const NOT_RECORDED: &[&str] = &[
    "scene",
    "output",
    "format",
    "threads",
    "quiet",
    "json",
    "preview",
    "tev",
    "strict",
    "checkpoint",
    "checkpoint_interval",
    "resume",
    "allow_path",
    "allow_outside",
    "max_memory",
    "max_triangles",
    "help",
    "help_all",
];

/// The recorded options, as arguments of `command`; `None` if one is not UTF-8.
pub(crate) fn recorded(command: &Command, matches: &ArgMatches) -> Option<Vec<String>> {
    let mut out = Vec::new();
    for arg in command.get_arguments() {
        let id = arg.get_id().as_str();
        let given = matches.try_contains_id(id).is_ok_and(|given| given)
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        let Some(long) = arg.get_long().filter(|_| given && !NOT_RECORDED.contains(&id)) else { continue };
        if matches!(arg.get_action(), ArgAction::SetTrue) {
            out.push(format!("--{long}"));
            continue;
        }
        for value in matches.get_raw(id).into_iter().flatten() {
            out.push(format!("--{long}={}", value.to_str()?));
        }
    }
    Some(out)
}

/// The first word that is not a recorded option of `command`: an unknown one, one that a file must not decide, or one
/// without its value.
pub(crate) fn refused<'a>(command: &Command, words: &'a [String]) -> Option<&'a String> {
    let is_recorded = |word: &&String| {
        let name = word.strip_prefix("--").map(|word| word.split_once('=').map_or(word, |(name, _)| name));
        let is = |arg: &&clap::Arg| {
            name.is_some() && arg.get_long() == name && !NOT_RECORDED.contains(&arg.get_id().as_str())
        };
        let arg = command.get_arguments().find(is);
        arg.is_some_and(|arg| arg.get_action().takes_values() == word.contains('='))
    };
    words.iter().find(|word| !is_recorded(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_decides_no_output_and_no_permission() {
        let render = crate::cli::render_command();
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let good = words(&["--samples=4", "--dither", "--set=film.seed=3"]);
        assert_eq!(refused(&render, &good), None);
        for bad in [
            "--output=x.png",
            "--allow-outside",
            "--checkpoint=x",
            "--nothing",
            "-o",
            "x.toml",
            "--",
            "--samples",
            "--dither=1",
            "--help",
        ] {
            let all = words(&["--samples=4", bad]);
            assert_eq!(refused(&render, &all).map(String::as_str), Some(bad));
        }
    }

    #[test]
    fn every_option_that_is_not_recorded_exists() {
        let mut cli = crate::cli::command();
        cli.build();
        let render = cli.find_subcommand("render").unwrap();
        for id in NOT_RECORDED {
            assert!(render.get_arguments().any(|arg| arg.get_id() == id), "{id}");
        }
    }
}
