//! The commands and options as Markdown, from the definitions that parse them: docs/reference/command-line.md.

use clap::{Arg, Command};

/// The document.
pub fn markdown() -> String {
    let mut cli = crate::cli::command();
    cli.build();
    let mut out = String::from(
        "# Command line\n\n`turner scene.toml` is short for `turner render scene.toml`. `turner COMMAND --help` shows the common options,\n\
         `--help-all` all of them. `turner help WORD` explains an option, a key, a kind or an error code.\n\n\
         This page is generated: `TURNER_UPDATE=1 cargo test -p turner-cli docs` rewrites it.\n\n\
         | command | what it does |\n| --- | --- |\n",
    );
    let commands: Vec<&Command> = cli.get_subcommands().filter(|c| !c.is_hide_set()).collect();
    for command in &commands {
        let name = command.get_name();
        out += &format!("| [`turner {name}`](#turner-{name}) | {} |\n", cell(&about(command)));
    }
    for command in commands {
        one(&mut out, command);
    }
    out
}

fn about(command: &Command) -> String {
    command.get_about().map(ToString::to_string).unwrap_or_default()
}

fn one(out: &mut String, command: &Command) {
    let long = command.get_long_about().map_or_else(|| about(command), ToString::to_string);
    *out += &format!("\n## turner {}\n\n{}.\n", command.get_name(), long.trim_end_matches('.'));
    let usage = command.clone().render_usage().to_string();
    *out += &format!("\n```text\n{}\n", usage.trim_start_matches("Usage: ").trim());
    if let Some(examples) = command.get_before_help() {
        *out += &format!("\n{examples}\n");
    }
    *out += "```\n";
    let args: Vec<&Arg> = command.get_arguments().filter(|a| !a.is_hide_set()).collect();
    let mut headings: Vec<Option<&str>> = Vec::new();
    for arg in &args {
        if !headings.contains(&arg.get_help_heading()) {
            headings.push(arg.get_help_heading());
        }
    }
    for heading in headings {
        *out += &format!("\n| {} | meaning |\n| --- | --- |\n", heading.unwrap_or("argument"));
        for arg in args.iter().filter(|a| a.get_help_heading() == heading) {
            row(out, arg);
        }
    }
    if let Some(after) = command.get_after_long_help().or(command.get_after_help()) {
        let after = after.to_string();
        if !after.trim().is_empty() {
            *out += &format!("\n{}\n", after.trim());
        }
    }
}

fn row(out: &mut String, arg: &Arg) {
    let values: Vec<_> = arg.get_possible_values().into_iter().filter(|v| !v.is_hide_set()).collect();
    let takes = arg.get_action().takes_values() && !arg.is_positional();
    let names = arg.get_value_names().map(|names| names.iter().map(ToString::to_string).collect::<Vec<_>>());
    let value = names.unwrap_or_default().join(" ");
    let mut name = match (arg.get_short(), arg.get_long()) {
        (Some(short), Some(long)) => format!("-{short}, --{long}"),
        (None, Some(long)) => format!("--{long}"),
        (Some(short), None) => format!("-{short}"),
        (None, None) => value.clone(),
    };
    if takes {
        name += &format!(" {value}");
    }
    let mut text = cell(&arg.get_help().map(ToString::to_string).unwrap_or_default());
    if takes && !arg.is_hide_default_value_set() {
        let defaults: Vec<_> = arg.get_default_values().iter().map(|v| v.to_string_lossy()).collect();
        if !defaults.is_empty() {
            text += &format!(". Default: `{}`", defaults.join(" "));
        }
    }
    if takes && !values.is_empty() {
        let meaning = |v: &clap::builder::PossibleValue| match v.get_help() {
            Some(help) => format!("<br>`{}`: {}", v.get_name(), cell(&help.to_string())),
            None => format!("<br>`{}`", v.get_name()),
        };
        text += &values.iter().map(meaning).collect::<String>();
    }
    *out += &format!("| `{}` | {text} |\n", cell(&name));
}

/// Escapes text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ").replace('<', "&lt;")
}
