//! Errors of the command line in the form of all others: the message, the marked argument and a remedy, from what clap
//! reports.

use std::error::Error as _;
use std::ffi::OsString;

use clap::Command;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use turner::schema::error::{escape, nearest};
use turner::schema::value::Span;
use turner::schema::{ErrorCode, SceneError};
use turner_io::scene::{SourceFile, Sources};

use crate::failure::{Failure, Labels, USAGE};
use crate::foreign;

/// The name of the arguments among the sources of an error.
pub(crate) const ARGUMENTS: &str = "the command line";

/// The error for arguments that clap refused; `None` for help and version, which clap also reports as errors.
pub(crate) fn failure(error: &clap::Error, args: &[OsString], cli: &Command) -> Option<Failure> {
    let kind = error.kind();
    if matches!(
        kind,
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    ) {
        return None;
    }
    let words: Vec<String> = args.iter().skip(1).map(|a| escape(&a.to_string_lossy())).collect();
    // Without a command the arguments are those of `render`.
    let first = words.first().map_or("", String::as_str);
    let name = if words.is_empty() || cli.find_subcommand(first).is_some() { first } else { "render" };
    let command = cli.find_subcommand(name).unwrap_or(cli);
    let said = Said { error, command };
    let (message, help) = said.words(cli, name);
    let mut sources = Sources::default();
    let (text, marked) = line(&words, said.wrong());
    let file =
        sources.add(SourceFile { name: ARGUMENTS.to_owned(), uri: String::new(), text, is_argument: true });
    let error = match marked {
        Some((start, end)) => {
            SceneError::at(ErrorCode::Usage, Span { file, start: start as u32, end: end as u32 }, message)
        }
        None => SceneError::new(ErrorCode::Usage, message),
    };
    Some(Failure { errors: vec![error.help(help)], sources, labels: Labels::new(), exit: USAGE })
}

/// The arguments as one line, and the byte range of the wrong one.
fn line(words: &[String], wrong: Option<String>) -> (String, Option<(usize, usize)>) {
    let mut text = String::from("turner");
    let mut marked = None;
    for word in words {
        text.push(' ');
        let start = text.len();
        text.push_str(word);
        let is_wrong = wrong.as_ref().is_some_and(|wrong| {
            word == wrong || word.strip_prefix(wrong.as_str()).is_some_and(|rest| rest.starts_with('='))
        });
        if is_wrong && marked.is_none() {
            marked = Some((start, text.len()));
        }
    }
    (text, marked)
}

/// An error of clap, with the command.
struct Said<'a> {
    error: &'a clap::Error,
    command: &'a Command,
}

impl Said<'_> {
    fn texts(&self, kind: ContextKind) -> Vec<String> {
        match self.error.get(kind) {
            Some(ContextValue::String(text)) => vec![text.clone()],
            Some(ContextValue::Strings(texts)) => texts.clone(),
            _ => Vec::new(),
        }
    }

    fn text(&self, kind: ContextKind) -> Option<String> {
        self.texts(kind).into_iter().next()
    }

    /// The option without the names of its values.
    fn option(&self) -> Option<String> {
        let text = self.text(ContextKind::InvalidArg)?;
        text.split([' ', '=', '[']).next().map(str::to_owned)
    }

    /// The argument that the error is about, as it was given.
    fn wrong(&self) -> Option<String> {
        match self.error.kind() {
            ErrorKind::InvalidValue | ErrorKind::ValueValidation => {
                self.text(ContextKind::InvalidValue).filter(|v| !v.is_empty()).or_else(|| self.option())
            }
            ErrorKind::InvalidSubcommand => self.text(ContextKind::InvalidSubcommand),
            ErrorKind::MissingRequiredArgument => None,
            _ => self.option(),
        }
    }

    /// The message and the remedy.
    fn words(&self, cli: &Command, name: &str) -> (String, String) {
        let see = if name.is_empty() {
            "`turner help` lists the commands".to_owned()
        } else {
            format!("`turner {name} --help-all` lists the options")
        };
        let option = self.option().unwrap_or_default();
        let value = escape(&self.text(ContextKind::InvalidValue).unwrap_or_default());
        let takes = || self.texts(ContextKind::InvalidArg).join(", ");
        match self.error.kind() {
            ErrorKind::UnknownArgument => {
                let message = if option.starts_with('-') {
                    format!("there is no option `{}`", escape(&option))
                } else {
                    format!("unexpected argument \"{}\"", escape(&option))
                };
                (message, self.instead_of(&option, cli).unwrap_or(see))
            }
            ErrorKind::InvalidValue if value.is_empty() => (
                format!("`{option}` needs a value"),
                self.valid().unwrap_or_else(|| format!("write `{}`", takes())),
            ),
            ErrorKind::InvalidValue if option.is_empty() => {
                let name = takes().trim_matches(['[', ']', '<', '>']).to_lowercase();
                (format!("there is no {name} \"{value}\""), self.valid().unwrap_or(see))
            }
            ErrorKind::InvalidValue => {
                (format!("`{option}` has no value \"{value}\""), self.valid().unwrap_or(see))
            }
            ErrorKind::ValueValidation => {
                let why = self.error.source().map_or_else(String::new, ToString::to_string);
                // The words of the standard library's parsers.
                let why = match why.as_str() {
                    "invalid digit found in string" => "expected a whole number".to_owned(),
                    "invalid float literal" => "expected a number".to_owned(),
                    _ => why,
                };
                let (first, rest) = why.split_once("; ").unwrap_or((why.as_str(), ""));
                let help = if rest.is_empty() { format!("write `{}`", takes()) } else { rest.to_owned() };
                (format!("`{option}` cannot be \"{value}\": {first}"), help)
            }
            ErrorKind::NoEquals | ErrorKind::TooFewValues | ErrorKind::WrongNumberOfValues => {
                (format!("`{option}` needs a value"), format!("write `{}`", takes()))
            }
            ErrorKind::TooManyValues => (format!("`{option}` takes no value \"{value}\""), see),
            ErrorKind::ArgumentConflict => {
                let other = self.texts(ContextKind::PriorArg).join(", ");
                if other.is_empty() || other == takes() {
                    return (format!("`{option}` is given twice"), "give it once".to_owned());
                }
                (format!("`{}` and `{other}` exclude each other", takes()), "give one of the two".to_owned())
            }
            ErrorKind::MissingRequiredArgument => {
                (format!("missing: {}", takes()), self.usage().unwrap_or(see))
            }
            ErrorKind::InvalidSubcommand => {
                let word = self.text(ContextKind::InvalidSubcommand).unwrap_or_default();
                let names: Vec<&str> = cli.get_subcommands().map(Command::get_name).collect();
                let help = match nearest(&word, &names) {
                    Some(near) => format!("did you mean `turner {near}`? commands: {}", names.join(", ")),
                    None => format!("commands: {}", names.join(", ")),
                };
                (format!("there is no command and no file \"{}\"", escape(&word)), help)
            }
            ErrorKind::InvalidUtf8 => ("an argument is not UTF-8".to_owned(), see),
            _ => (self.error.kind().to_string(), see),
        }
    }

    fn usage(&self) -> Option<String> {
        let usage = self.command.clone().render_usage().to_string();
        let usage = usage.strip_prefix("Usage: ")?.trim();
        let usage = usage.strip_prefix("turner ").unwrap_or(usage);
        let example = crate::options::example(self.command.get_name());
        let example = example.map_or(String::new(), |line| format!(", e.g. `{line}`"));
        Some(format!("usage: turner {usage}{example}"))
    }

    /// Valid values, the nearest first.
    fn valid(&self) -> Option<String> {
        let valid = self.texts(ContextKind::ValidValue);
        let names: Vec<&str> = valid.iter().map(String::as_str).collect();
        turner::schema::error::suggestion(&self.text(ContextKind::InvalidValue).unwrap_or_default(), &names)
    }

    /// The remedy for an unknown option: Turner's equivalent of another program's option, the nearest name, or the
    /// command that has the option.
    fn instead_of(&self, option: &str, cli: &Command) -> Option<String> {
        if let Some(remedy) = foreign::option(option).filter(|r| self.has_options_of(r)) {
            return Some(remedy.to_owned());
        }
        let own = options(self.command);
        let names: Vec<&str> = own.iter().map(String::as_str).collect();
        let name = option.trim_start_matches('-');
        if let Some(near) = nearest(name, &names) {
            return Some(format!("did you mean `--{near}`?"));
        }
        let has = |c: &&Command| options(c).iter().any(|o| o == name);
        if let Some(other) = cli.get_subcommands().find(has) {
            return Some(format!("`--{name}` is an option of `turner {}`", other.get_name()));
        }
        foreign::option(option).map(str::to_owned)
    }

    /// Whether the options that a remedy names are options of this command.
    fn has_options_of(&self, remedy: &str) -> bool {
        let own = options(self.command);
        let mut named = remedy.split([' ', '`']).filter_map(|w| w.strip_prefix("--"));
        named.all(|o| own.iter().any(|own| own == o))
    }
}

/// The long names of a command's options.
pub(crate) fn options(command: &Command) -> Vec<String> {
    command
        .get_arguments()
        .filter(|a| !a.is_hide_set())
        .filter_map(|a| a.get_long())
        .map(str::to_owned)
        .collect()
}
