//! Colours of the help on terminals.

use std::fmt::Write;
use std::io::IsTerminal;

use clap::builder::styling::{AnsiColor, Style, Styles};

const TITLE: Style = AnsiColor::Green.on_default().bold();
const NAME: Style = AnsiColor::Cyan.on_default().bold();
const CODE: Style = AnsiColor::Yellow.on_default();

/// Styles of the help of commands.
pub const STYLES: Styles = Styles::styled()
    .header(TITLE)
    .usage(TITLE)
    .literal(NAME)
    .placeholder(AnsiColor::Cyan.on_default())
    .error(AnsiColor::Red.on_default().bold())
    .valid(AnsiColor::Green.on_default())
    .invalid(AnsiColor::Yellow.on_default());

/// Whether a stream is a terminal and `NO_COLOR` is not set (<https://no-color.org>).
pub(crate) fn are_wanted(stream: &impl IsTerminal) -> bool {
    let is = |name: &str, value: fn(&str) -> bool| std::env::var(name).is_ok_and(|v| value(&v));
    stream.is_terminal() && !is("NO_COLOR", |v| !v.is_empty()) && !is("TERM", |v| v == "dumb")
}

/// Colours titles, names and examples in the help on the scene format: titles start at the margin, names after two
/// spaces, examples after four.
pub(crate) fn paint(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let words = line.trim_start_matches(' ');
        let indent = line.len() - words.len();
        let (name, rest) = words.split_at(words.find("  ").unwrap_or(words.len()));
        let styled = |out: &mut String, style: Style, text: &str| write!(out, "{style}{text}{style:#}");
        out.extend(std::iter::repeat_n(' ', indent));
        let _ = match indent {
            _ if words.is_empty() => Ok(()),
            0 => styled(&mut out, TITLE, words),
            2 if words.ends_with(':') => styled(&mut out, TITLE, words),
            2 if !rest.is_empty() => styled(&mut out, NAME, name).and_then(|()| out.write_str(rest)),
            4 => styled(&mut out, CODE, words),
            _ => out.write_str(words),
        };
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_changes_no_text() {
        let text = crate::reference::explain("sphere").unwrap();
        let painted = paint(&text);
        let mut plain = String::new();
        let mut rest = painted.as_str();
        while let Some(i) = rest.find('\u{1b}') {
            plain += &rest[..i];
            rest = &rest[i + rest[i..].find('m').unwrap() + 1..];
        }
        assert_eq!((plain + rest).trim_end(), text.trim_end());
        for (style, part) in
            [(TITLE, "The shape \"sphere\""), (NAME, "radius"), (CODE, "radius = 1"), (TITLE, "Example:")]
        {
            assert!(painted.contains(&format!("{style}{part}{style:#}")), "{part}: {painted}");
        }
    }
}
