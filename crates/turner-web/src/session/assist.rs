//! Help while a scene is written: errors, completions and documentation at the cursor.

mod context;
mod vocabulary;

use serde_json::{Value as Json, json};
use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadError, load_text};

use super::calls::Args;
use super::parts::paragraph;
use super::{CallError, Reply, Session};
use context::{Context, Side};
use vocabulary::Vocabulary;

/// Most texts that are checked while they are written.
const MAX_TEXT: usize = 1 << 20;

/// Reads a text as the scene, without showing it.
pub(super) fn check(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let text = Args(args).text("text")?;
    let none = MemoryAssets::default();
    let files = session.document.memory().map_or(&none, |files| &**files);
    let name = session.document.text_name();
    let read = load_text(text.to_owned(), &name, files, &session.load_options());
    let (errors, warnings) = match read {
        Ok(loaded) => {
            let each = loaded.desc.warnings.iter().map(|warning| {
                let at = warning.span.and_then(|span| loaded.sources.locate(span));
                json!({
                    "kind": warning.kind.word(),
                    "message": warning.message,
                    "line": at.as_ref().map(|at| at.line),
                    "column": at.as_ref().map(|at| at.column),
                    "end_column": at.as_ref().map(|at| at.column + at.length),
                })
            });
            (Vec::new(), each.collect())
        }
        Err(error) => (all(&error), Vec::new()),
    };
    Ok(json!({ "errors": errors, "warnings": warnings }).into())
}

/// An error and those that were found with it.
fn all(error: &LoadError) -> Vec<Json> {
    let more = error.error.more.iter();
    let each = std::iter::once(&error.error).chain(more);
    each.map(|own| CallError::of_scene(own, &error.sources).json()).collect()
}

/// The byte of a position in UTF-16 units, which JavaScript counts.
fn byte_of(text: &str, units: usize) -> usize {
    let mut seen = 0;
    for (at, c) in text.char_indices() {
        if seen >= units {
            return at;
        }
        seen += c.len_utf16();
    }
    text.len()
}

fn units_of(text: &str, byte: usize) -> usize {
    text[..byte].encode_utf16().count()
}

/// The text and the byte at the cursor.
fn cursor(args: &Json) -> Result<(&str, usize), CallError> {
    let given = Args(args);
    let text = given.text("text")?;
    if text.len() > MAX_TEXT {
        return Err(CallError::new("the text is too long to be completed while it is written"));
    }
    let units = given.optional_index("offset")?.unwrap_or(0) as usize;
    Ok((text, byte_of(text, units)))
}

pub(super) fn complete(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let (text, at) = cursor(args)?;
    let context = Context::at(text, at);
    let vocabulary = Vocabulary::of(&context, session.document.desc());
    let typed = &text[context.word.start..at.clamp(context.word.start, context.word.end)];
    let mut items = match &context.side {
        Side::Section => vocabulary.sections(),
        Side::Key => vocabulary.keys(&context),
        Side::Value(key) => vocabulary.values(key),
    };
    // What begins with the typed text first, then what contains it.
    let needle = typed.trim_start_matches(['"', '[']).to_lowercase();
    let rank = |item: &vocabulary::Item| {
        let label = item.label.to_lowercase();
        if label.starts_with(&needle) { 0 } else { 1 + usize::from(!label.contains(&needle)) }
    };
    items.retain(|item| rank(item) < 2);
    items.sort_by_key(rank);
    let items: Vec<Json> = items.into_iter().map(|item| item.json()).collect();
    Ok(json!({
        "from": units_of(text, context.word.start),
        "to": units_of(text, context.word.end),
        "items": items,
    })
    .into())
}

pub(super) fn hover(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let (text, at) = cursor(args)?;
    let context = Context::at(text, at);
    let vocabulary = Vocabulary::of(&context, session.document.desc());
    let word = text[context.word.clone()].trim_matches(['"', '[', ']']);
    let range = json!({ "from": units_of(text, context.word.start), "to": units_of(text, context.word.end) });
    let mut out = match &context.side {
        Side::Key => match vocabulary.field(word) {
            Some(field) => json!({
                "title": format!("{word}: {}", (field.kind)()),
                "doc": paragraph(field.doc),
                "range": field.range.map(|range| range.to_string()),
                "default": field.default.map(|show| show()),
            }),
            None => return Ok(Json::Object(Default::default()).into()),
        },
        Side::Value(key) => match vocabulary.values(key).into_iter().find(|item| item.label == word) {
            Some(item) => json!({ "title": word, "doc": item.doc, "range": null, "default": null }),
            None => return Ok(Json::Object(Default::default()).into()),
        },
        Side::Section => return Ok(Json::Object(Default::default()).into()),
    };
    out["from"] = range["from"].clone();
    out["to"] = range["to"].clone();
    Ok(out.into())
}

#[cfg(test)]
mod tests;
