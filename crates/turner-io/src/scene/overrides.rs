//! Overrides of single keys from the command line: `-D integrator.max_depth=3`.

use turner::description::drop_foreign_keys;
use turner::schema::value::{Data, Entry, FileId, Span, Value};
use turner::schema::{ErrorCode, KeyEdit, KeyPart, SceneError, old_names};

use super::hash::SceneHash;
use super::model::quoted;
use super::sources::{SourceFile, Sources};
use super::{LoadOptions, text};
use crate::assets::printable;

/// One override `key.path=value`, e.g. `film.width=640` or `object.0.radius=2`. Numbers in the path are indices
/// of lists, from 0. The value is TOML; if it is not valid TOML, it is text: `material.ball.color=red` needs no
/// quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// The key path, before the first `=`.
    pub path: String,
    /// The value, after it.
    pub value: String,
}

impl Override {
    /// From `key.path=value`.
    pub fn parse(text: &str) -> Result<Override, SceneError> {
        let mut quote = None;
        for (i, c) in text.char_indices() {
            match (c, quote) {
                ('"' | '\'', None) => quote = Some(c),
                (c, Some(q)) if c == q => quote = None,
                ('=', None) => {
                    return Ok(Override { path: text[..i].to_owned(), value: text[i + 1..].to_owned() });
                }
                _ => {}
            }
        }
        let message = format!("-D {}: expected key=value, found no `=`", printable(text));
        Err(SceneError::new(ErrorCode::Syntax, message).help("for example -D film.width=640"))
    }

    /// Replaces the type of the integrator.
    pub fn integrator(name: &str) -> Override {
        Override { path: "integrator.type".to_owned(), value: quoted(name) }
    }

    /// The override as it was written.
    pub fn text(&self) -> String {
        format!("{}={}", self.path, self.value)
    }
}

/// All edits that `options` ask for, in order. Paths in the values are relative to `uri`, the scene.
pub(super) fn edits(
    options: &LoadOptions,
    uri: &str,
    sources: &mut Sources,
    hash: &mut SceneHash,
) -> Result<Vec<KeyEdit>, SceneError> {
    let integrator = options.integrator.as_deref().map(Override::integrator);
    let mut one = |change: &Override| {
        if !of_a_part(change) {
            hash.add(b'o', change.text().as_bytes());
        }
        edit(change, uri, sources)
    };
    integrator.iter().chain(&options.overrides).map(&mut one).collect()
}

/// Whether an override says which part of a picture is rendered.
fn of_a_part(change: &Override) -> bool {
    ["film.samples", "film.crop"].contains(&change.path.as_str())
}

/// The hash of everything, and that without the overrides that say which part of a picture is rendered. `hash` holds
/// everything else: texts, other overrides and files.
pub(super) fn hashes(mut hash: SceneHash, options: &LoadOptions) -> (String, String) {
    let shared = hash.hex();
    for change in options.overrides.iter().filter(|o| of_a_part(o)) {
        hash.add(b'o', change.text().as_bytes());
    }
    (hash.hex(), shared)
}

fn edit(change: &Override, uri: &str, sources: &mut Sources) -> Result<KeyEdit, SceneError> {
    let text = change.text();
    let name = printable(&format!("-D {text}"));
    let file = sources.add(SourceFile { name, uri: uri.to_owned(), text, is_argument: true });
    let mut path = parts(change, file)?;
    old_names::update_path(&mut path);
    let value = value(change, file)?;
    if path.first().is_some_and(|p| p.key == "include") {
        let message = "`include` cannot be overridden: files are included before overrides apply";
        return Err(
            SceneError::at(ErrorCode::Conflict, path[0].span, message).help("set it in the scene file")
        );
    }
    Ok(KeyEdit { path, value })
}

/// Applies [`edits`] to the table of a TOML scene. An integrator type from the options drops the keys that it
/// does not have.
pub(super) fn apply(edits: Vec<KeyEdit>, has_integrator: bool, root: &mut Value) -> Result<(), SceneError> {
    for (i, edit) in edits.into_iter().enumerate() {
        root.set(&edit.path, edit.value)?;
        if let (0, true, Data::Table(top)) = (i, has_integrator, &mut root.data)
            && let Some(Value { data: Data::Table(table), .. }) = top.get_mut("integrator")
        {
            drop_foreign_keys("integrator", table, &|_| false);
        }
    }
    Ok(())
}

/// The parts of a key path, parsed as a TOML key so that quotes mean the same.
fn parts(change: &Override, file: FileId) -> Result<Vec<KeyPart>, SceneError> {
    let span = Span { file, start: 0, end: change.path.len() as u32 };
    let wrong = || {
        SceneError::at(ErrorCode::Syntax, span, "expected a key such as film.width before `=`")
            .help("a part has letters, digits, _ and -; put any other part in quotes")
    };
    if change.path.contains(['\n', '\r', '[', '{', '#', '=']) && !change.path.contains(['"', '\'']) {
        return Err(wrong());
    }
    let mut value = text::parse(&format!("{} = 0", change.path), file).map_err(|_| wrong())?;
    let mut parts = Vec::new();
    while let Data::Table(table) = value.data {
        let mut entries = table.entries.into_iter();
        let (Some(Entry { key, key_span, value: next }), None) = (entries.next(), entries.next()) else {
            return Err(wrong());
        };
        parts.push(KeyPart { key, span: key_span });
        value = next;
    }
    Ok(parts)
}

fn value(change: &Override, file: FileId) -> Result<Value, SceneError> {
    let trimmed = change.value.trim_matches([' ', '\t']);
    let lead = change.value.len() - change.value.trim_start_matches([' ', '\t']).len();
    let start = change.path.len() + 1 + lead;
    let bare = || {
        let span = Span { file, start: start as u32, end: (start + trimmed.len()) as u32 };
        Value { data: Data::String(trimmed.to_owned()), span }
    };
    match text::parse_value(trimmed, file, start) {
        Ok(value) => Ok(value),
        // A value that begins like a list, a table or a quoted string was meant as one.
        Err(error) if trimmed.starts_with(['[', '{', '"', '\'']) => Err(error),
        Err(error) if error.code == ErrorCode::OutOfRange => Err(error),
        Err(_) => Ok(bare()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str, change: &str) -> Result<Value, SceneError> {
        let mut sources = Sources::default();
        let mut root = text::parse(text, FileId(0)).unwrap();
        let edit = edit(&Override::parse(change)?, "a.toml", &mut sources)?;
        apply(vec![edit], false, &mut root).map(|()| root)
    }

    fn get(value: &Value, path: &str) -> Data {
        let mut at = value;
        for part in path.split('.') {
            at = match &at.data {
                Data::Table(t) => t.get(part).unwrap(),
                Data::Array(a) => &a[part.parse::<usize>().unwrap()],
                _ => panic!("{path}"),
            };
        }
        at.data.clone()
    }

    #[test]
    fn values_are_toml_or_text() {
        for (given, expected) in [
            ("3", Data::Integer(3)),
            (" 0x10 ", Data::Integer(16)),
            ("true", Data::Bool(true)),
            ("red", Data::String("red".into())),
            ("\"3\"", Data::String("3".into())),
            ("a b=c", Data::String("a b=c".into())),
            ("", Data::String(String::new())),
            ("2024-01-01", Data::String("2024-01-01".into())),
        ] {
            assert_eq!(get(&changed("", &format!("a.b={given}")).unwrap(), "a.b"), expected, "{given}");
        }
        assert_eq!(get(&changed("", "\"x=y\".z=[1, {q = 2}]").unwrap(), "x=y.z.1.q"), Data::Integer(2));
    }

    #[test]
    fn lists_are_reached_by_number() {
        let text = "[[object]]\nradius = 1\n[[object]]\nradius = 2\n";
        assert_eq!(get(&changed(text, "object.1.radius=9").unwrap(), "object.1.radius"), Data::Integer(9));
        for (change, code, words) in [
            ("object.2.radius=9", ErrorCode::OutOfRange, "2 entries"),
            ("object.x=9", ErrorCode::WrongType, "expected an index"),
            ("object.0.radius.x=9", ErrorCode::WrongType, "an integer"),
            ("object", ErrorCode::Syntax, "no `=`"),
            ("=3", ErrorCode::Syntax, "expected a key"),
            ("a b=3", ErrorCode::Syntax, "expected a key"),
            ("[a]\nb=3", ErrorCode::Syntax, "expected a key"),
            ("\"a\"=1\nb=3", ErrorCode::Syntax, "expected a key"),
            ("include=x.toml", ErrorCode::Conflict, "include"),
            ("a=[1, 2", ErrorCode::Syntax, "array"),
        ] {
            match changed(text, change) {
                Err(e) => assert!(e.code == code && e.message.contains(words), "{change}: {e:?}"),
                Ok(_) if change.starts_with("\"a\"") => {}
                Ok(v) => panic!("{change}: {v:?}"),
            }
        }
    }
}
