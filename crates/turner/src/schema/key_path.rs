//! Key paths such as `film.width` or `object.0.radius`, and setting the value at the end of one.

use super::error::{ErrorCode, SceneError, escape};
use super::old_names;
use super::value::{Data, Entry, Span, Table, Value};

/// One part of a key path.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyPart {
    /// A key of a table, or the index of an item of a list, counted from 0.
    pub key: String,
    /// Its position in the text of the edit.
    pub span: Span,
}

/// A value to set in a scene, and the key path to set.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyEdit {
    /// The path, e.g. `film` and `width`.
    pub path: Vec<KeyPart>,
    /// The value.
    pub value: Value,
}

impl KeyEdit {
    /// An edit made by a program, without a position in a text. Dots separate the parts of `path`; a part that
    /// contains dots is in quotes, as [`path_part`] writes it.
    pub fn new(path: &str, data: Data) -> KeyEdit {
        KeyEdit { path: KeyPart::split(path), value: Value::new(data) }
    }
}

/// A name as a part of a key path: in quotes, as in `material."Material.001"`, where it needs them.
pub fn path_part(name: &str) -> String {
    if !name.is_empty() && !name.contains(['.', '"', '\\']) {
        return name.to_owned();
    }
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}

impl KeyPart {
    /// The parts of a path, without positions.
    pub fn split(path: &str) -> Vec<KeyPart> {
        let (mut parts, mut key, mut quoted) = (Vec::new(), String::new(), false);
        let mut chars = path.chars().peekable();
        while let Some(c) = chars.next() {
            match c {
                '"' if quoted => quoted = false,
                '"' if key.is_empty() => quoted = true,
                '\\' if quoted => key.extend(chars.next()),
                '.' if !quoted => parts.push(std::mem::take(&mut key)),
                c => key.push(c),
            }
        }
        parts.push(key);
        parts.into_iter().map(|key| KeyPart { key, span: Span::NONE }).collect()
    }
}

impl Value {
    /// Follows `path`, creates missing tables on the way, and sets the value at its end.
    ///
    /// Errors, at the part of the path concerned: a list without such an item; a part below a value that is neither a
    /// table nor a list.
    pub fn set(&mut self, path: &[KeyPart], value: Value) -> Result<(), SceneError> {
        let mut at = self;
        let mut walked = String::new();
        for part in path {
            let shown = escape(&part.key);
            at = at.step(part, &walked, &shown)?;
            if !walked.is_empty() {
                walked.push('.');
            }
            walked += &shown;
        }
        *at = value;
        Ok(())
    }

    /// The value one step down. For messages, `walked` is the path so far and `shown` the step.
    fn step(&mut self, part: &KeyPart, walked: &str, shown: &str) -> Result<&mut Value, SceneError> {
        let span = part.span;
        match &mut self.data {
            Data::Table(table) => {
                let index_of = |name: &str| table.entries.iter().position(|e| e.key == name);
                let found = index_of(&part.key).or_else(|| index_of(old_names::of_key(&part.key)?));
                let i = match found {
                    Some(i) => {
                        table.entries[i].key.clone_from(&part.key);
                        i
                    }
                    None => {
                        let value = Value { data: Data::Table(Table::default()), span };
                        table.entries.push(Entry { key: part.key.clone(), key_span: span, value });
                        table.entries.len() - 1
                    }
                };
                // Errors about this key refer to the edit.
                table.entries[i].key_span = span;
                Ok(&mut table.entries[i].value)
            }
            Data::Array(items) => {
                let len = items.len();
                let Ok(i) = part.key.parse::<usize>() else {
                    let message =
                        format!("`{walked}` is a list; expected an index after it, found `{shown}`");
                    return Err(SceneError::at(ErrorCode::WrongType, span, message)
                        .help(format!("count from 0: {walked}.0")));
                };
                items.get_mut(i).ok_or_else(|| {
                    let message = format!("`{walked}` has {len} entries; there is no entry {shown}");
                    let range =
                        if len == 0 { "it is empty".to_owned() } else { format!("valid: 0 to {}", len - 1) };
                    SceneError::at(ErrorCode::OutOfRange, span, message).help(range)
                })
            }
            other => {
                let message = format!("`{walked}` is {} and has no key `{shown}`", other.kind());
                Err(SceneError::at(ErrorCode::WrongType, span, message)
                    .help(format!("replace its value: -D {walked}=…")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_any_kind_are_parts_of_a_path() {
        for name in ["gold", "Material.001", "a \"b\" \\ .c", "", "ü 椅子"] {
            let parts = KeyPart::split(&format!("material.{}.color", path_part(name)));
            let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
            assert_eq!(keys, ["material", name, "color"]);
        }
        assert_eq!(KeyPart::split("film").len(), 1);
    }
}
