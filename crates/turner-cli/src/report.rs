//! Errors and warnings: as text with an excerpt of the file, or as events.

use std::io::Write;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use serde_json::json;
use turner::description::ImportSummary;
use turner::schema::value::Span;
use turner::schema::{ErrorCode, SceneError, Warning, WarningKind};
use turner_io::scene::{Location, Sources};

use crate::events::Events;
use crate::failure::{Failure, Labels};
use crate::usage::ARGUMENTS;
use crate::{flags, text};

/// Most errors, and most warnings, that are printed.
const MAX_SHOWN: usize = 20;

/// With this many errors the scene may have more: reading stops after 100.
const MAX_READ: usize = 101;

/// The destination of messages.
pub struct Reporter {
    /// Print errors only.
    pub quiet: bool,
    /// Events instead of text.
    pub events: Option<Events>,
}

impl Reporter {
    /// Whether a person may look at its lines: it is not quiet, and sends no events.
    pub(crate) fn shows_progress(&self) -> bool {
        !self.quiet && self.events.is_none()
    }

    /// Reports why the command failed.
    pub fn failure(&self, failure: &Failure) {
        let Some(events) = &self.events else { return print_error(failure) };
        for error in &failure.errors {
            let location = error.span.and_then(|span| failure.sources.locate(span));
            let file = location.as_ref().map(|p| label(p, &failure.labels));
            events.send(json!({
                "event": "error",
                "code": error.code.as_str(),
                "message": error.message,
                "file": file,
                "line": location.as_ref().map(|p| p.line),
                "column": location.as_ref().map(|p| p.column),
                "help": flags::help(error),
            }));
        }
    }

    /// Reports warnings. Equal ones are printed once, with their count.
    pub(crate) fn warnings(&self, warnings: &[Warning], sources: &Sources, labels: &Labels) {
        let warnings = summed(warnings);
        if let Some(events) = &self.events {
            for w in &warnings {
                let location = w.span.and_then(|span| sources.locate(span));
                events.send(json!({
                    "event": "warning",
                    "kind": w.kind.word(),
                    "message": flags::message(w),
                    "count": w.count,
                    "file": location.as_ref().map(|p| label(p, labels)),
                    "line": location.as_ref().map(|p| p.line),
                    "column": location.as_ref().map(|p| p.column),
                }));
            }
            return;
        }
        if self.quiet || warnings.is_empty() {
            return;
        }
        let mut out = String::new();
        for w in warnings.iter().take(MAX_SHOWN) {
            out += &warning_text(w, sources, labels, &renderer());
        }
        let is_warning = |w: &&Warning| w.kind != WarningKind::Note;
        let total: u64 = warnings.iter().filter(is_warning).map(|w| w.count).sum();
        if warnings.len() > MAX_SHOWN {
            out += &format!("… and {} more\n", warnings.len() - MAX_SHOWN);
        }
        if total > 1 {
            out += &format!("{}\n", text::plural(total, "warning"));
        }
        eprint_all(&out);
    }

    /// Reports what the model files contain.
    pub(crate) fn imports(&self, imports: &[ImportSummary]) {
        for import in imports {
            if let Some(events) = &self.events {
                let counts: serde_json::Map<_, _> =
                    import.counts.iter().map(|(what, n)| ((*what).to_owned(), json!(n))).collect();
                events.send(json!({
                    "event": "import",
                    "file": import.file,
                    "format": import.format,
                    "counts": counts,
                }));
            } else {
                self.line(&text::import(import));
            }
        }
    }

    /// Prints a line, unless events are sent or `quiet` is set.
    pub fn line(&self, line: &str) {
        if !self.quiet && self.events.is_none() {
            eprint_all(&format!("{line}\n"));
        }
    }
}

/// Merges equal messages: location of the first, sum of the counts.
pub(crate) fn summed(warnings: &[Warning]) -> Vec<Warning> {
    let mut out: Vec<Warning> = Vec::new();
    let mut seen = std::collections::HashMap::new();
    for w in warnings {
        match seen.get(&w.message) {
            Some(&i) => {
                let first: &mut Warning = &mut out[i];
                first.count = first.count.saturating_add(w.count);
            }
            None => {
                seen.insert(w.message.clone(), out.len());
                out.push(w.clone());
            }
        }
    }
    out
}

/// Warnings as errors, for `--strict`.
pub(crate) fn strict(warnings: &[Warning], sources: &Sources, labels: &Labels) -> Failure {
    let errors = summed(warnings)
        .into_iter()
        .filter(|w| w.kind == WarningKind::Ignored)
        .take(MAX_SHOWN)
        .map(|w| SceneError::new(ErrorCode::Strict, w.message).or_at(w.span))
        .collect();
    Failure { errors, sources: sources.clone(), labels: labels.clone(), exit: crate::failure::FAILED }
}

/// Writes errors to standard error, with excerpts.
pub(crate) fn print_error(failure: &Failure) {
    let renderer = renderer();
    let mut out = String::new();
    for error in failure.errors.iter().take(MAX_SHOWN) {
        out += &error_text(error, &failure.sources, &failure.labels, &renderer);
    }
    let count = failure.errors.len();
    match count {
        MAX_READ.. => out += "… and more: reading stopped after 100 errors\n",
        _ if count > MAX_SHOWN => out += &format!("… and {} more\n{count} errors\n", count - MAX_SHOWN),
        2.. => out += &format!("{count} errors\n"),
        _ => {}
    }
    eprint_all(&out);
}

/// With colours on terminals, unless they are turned off.
fn renderer() -> Renderer {
    let plain = !crate::color::are_wanted(&std::io::stderr());
    if plain { Renderer::plain() } else { Renderer::styled() }
}

fn error_text(error: &SceneError, sources: &Sources, labels: &Labels, renderer: &Renderer) -> String {
    let title = Level::ERROR.primary_title(error.message.as_str()).id(error.code.as_str());
    let excerpt = Excerpt::of(error.span, sources, labels);
    let help = flags::help(error);
    let help = help.as_deref();
    if let Some(excerpt) = &excerpt {
        let group = title.element(excerpt.snippet()).elements(help.map(|help| Level::HELP.message(help)));
        return format!("{}\n", renderer.render(&[group]));
    }
    // Rendered separately: one call would put an empty margin between them.
    let groups =
        [Some(Group::with_title(title)), help.map(|h| Group::with_title(Level::HELP.secondary_title(h)))];
    groups.into_iter().flatten().map(|group| format!("{}\n", renderer.render(&[group]))).collect()
}

/// `warning[ignored]: …`, with the kind where errors have their code; notes are `note: …`.
fn warning_text(warning: &Warning, sources: &Sources, labels: &Labels, renderer: &Renderer) -> String {
    let times = if warning.count > 1 { format!(" ({} times)", warning.count) } else { String::new() };
    let excerpt = Excerpt::of(warning.span, sources, labels);
    let at = excerpt.as_ref().map_or(String::new(), |p| format!("{}: ", p.title));
    let message = format!("{at}{}{times}", flags::message(warning));
    let title = match warning.kind {
        WarningKind::Note => Level::NOTE.primary_title(message),
        kind => Level::WARNING.primary_title(message).id(kind.word()),
    };
    format!("{}\n", renderer.render(&[Group::with_title(title)]))
}

/// An excerpt with a marked range.
struct Excerpt {
    /// `file:line:column`, or the argument.
    title: String,
    file: String,
    line: usize,
    excerpt: String,
    /// Bytes of the excerpt.
    range: std::ops::Range<usize>,
    is_argument: bool,
}

impl Excerpt {
    fn of(span: Option<Span>, sources: &Sources, labels: &Labels) -> Option<Excerpt> {
        let at = sources.locate(span?)?;
        let file = label(&at, labels);
        let (before, length) = (at.excerpt_column.saturating_sub(1), at.length);
        if !at.is_argument {
            return Some(Excerpt {
                title: format!("{file}:{}:{}", at.line, at.column),
                range: byte_range(&at.excerpt, before, length),
                line: at.line,
                excerpt: at.excerpt,
                file,
                is_argument: false,
            });
        }
        if at.file == ARGUMENTS {
            return Some(Excerpt {
                title: file,
                range: byte_range(&at.excerpt, before, length),
                file: String::new(),
                line: 1,
                excerpt: at.excerpt,
                is_argument: true,
            });
        }
        // An option is shown as given; in a `-D` the wrong part is marked.
        let is_set = file == at.file;
        let excerpt = if is_set { format!("-D {}", at.excerpt) } else { file.clone() };
        let range = if is_set { byte_range(&excerpt, before + 3, length) } else { 0..excerpt.len() };
        Some(Excerpt {
            title: excerpt.clone(),
            file: String::new(),
            line: 1,
            excerpt,
            range,
            is_argument: true,
        })
    }

    fn snippet(&self) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
        Snippet::source(self.excerpt.as_str())
            .path((!self.is_argument).then_some(self.file.as_str()))
            .line_start(self.line)
            .line_numbering(!self.is_argument)
            .fold(false)
            .annotation(AnnotationKind::Primary.span(self.range.clone()))
    }
}

fn label(at: &Location<'_>, labels: &Labels) -> String {
    labels.get(at.file).cloned().unwrap_or_else(|| at.file.to_owned())
}

/// A range of characters as a range of bytes.
fn byte_range(text: &str, start: usize, length: usize) -> std::ops::Range<usize> {
    let at = |n: usize| text.char_indices().nth(n).map_or(text.len(), |(i, _)| i);
    at(start)..at(start + length)
}

/// Writes to standard error and ignores errors: it may be closed.
fn eprint_all(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}
