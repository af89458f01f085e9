//! Reads tables of a scene file, key by key.

use super::error::{ErrorCode, SceneError, escape, nearest, suggestion};
use super::foreign;
use super::value::{Data, Entry, Span, Table, Value};
use super::{ParamType, Range, ReadContext, old_names, wrong_type};

/// Reads the keys of one table. [`TableReader::finish`] reports the keys that were not read as unknown.
pub struct TableReader<'a> {
    table: &'a Table,
    span: Span,
    what: String,
    known: Vec<&'static str>,
}

impl<'a> TableReader<'a> {
    /// A reader of `table`. `what` names the table in messages: "a sphere", "the camera".
    pub fn new(table: &'a Table, span: Span, what: impl Into<String>) -> TableReader<'a> {
        TableReader { table, span, what: what.into(), known: Vec::new() }
    }

    /// A reader of a value.
    ///
    /// Errors: a value that is no table.
    pub fn of(value: &'a Value, what: impl Into<String>) -> Result<TableReader<'a>, SceneError> {
        match &value.data {
            Data::Table(table) => Ok(TableReader::new(table, value.span, what)),
            _ => Err(wrong_type(value, "a table { key = value, … }")),
        }
    }

    /// Changes the name of the table in messages, once its type is known.
    pub fn rename(&mut self, what: impl Into<String>) {
        self.what = what.into();
    }

    /// The position of the table.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The value of a key. The key counts as known from here on.
    pub fn take(&mut self, key: &'static str) -> Option<&'a Value> {
        self.known.push(key);
        self.table.get(key)
    }

    /// The value of a key by its current name or else by its old name, which adds a note.
    pub fn take_renamed(&mut self, key: &'static str, cx: &mut dyn ReadContext) -> Option<&'a Value> {
        let value = self.take(key);
        let Some(old) = old_names::of_key(key).filter(|_| value.is_none()) else { return value };
        let entry = self.table.entries.iter().find(|e| e.key == old)?;
        self.known.push(old);
        old_names::note(old, key, entry.key_span, cx);
        Some(&entry.value)
    }

    /// Whether the table has a key.
    pub fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// The position of the key's value; without the key, the position of the table.
    pub fn span_of(&self, key: &str) -> Span {
        self.table.get(key).map_or(self.span, |v| v.span)
    }

    /// Reads the value of a key; `None` if the key is missing or the value is invalid and its error was recorded.
    pub fn optional<T: ParamType>(
        &mut self,
        key: &'static str,
        range: Option<Range>,
        cx: &mut dyn ReadContext,
    ) -> Result<Option<T>, SceneError> {
        let Some(value) = self.take_renamed(key, cx) else { return Ok(None) };
        let read = read_value(key, value, range, cx);
        cx.noted(read)
    }

    /// Reads the value of a required key. If reading continues after an error, the value is `start`.
    pub fn required<T: ParamType>(
        &mut self,
        key: &'static str,
        range: Option<Range>,
        cx: &mut dyn ReadContext,
        start: impl FnOnce() -> T,
    ) -> Result<T, SceneError> {
        if self.table.get(key).is_none() {
            self.known.push(key);
            let message = format!("{} needs the key `{key}`", self.what);
            cx.fault(
                SceneError::at(ErrorCode::MissingKey, self.span, message)
                    .help(format!("add `{key} = {}`", T::kind())),
            )?;
            return Ok(start());
        }
        Ok(self.optional(key, range, cx)?.unwrap_or_else(start))
    }

    /// Reports keys that were not read.
    pub fn finish(&self, cx: &mut dyn ReadContext) -> Result<(), SceneError> {
        for entry in &self.table.entries {
            if !self.known.contains(&entry.key.as_str()) {
                cx.fault(self.unknown_key(entry))?;
            }
        }
        Ok(())
    }

    fn unknown_key(&self, entry: &Entry) -> SceneError {
        let message = format!("unknown key `{}` in {}", escape(&entry.key), self.what);
        let error = SceneError::at(ErrorCode::UnknownKey, entry.key_span, message);
        let mut valid = self.known.clone();
        valid.sort_unstable();
        valid.dedup();
        if let Some(remedy) = foreign::key(&self.what, &entry.key) {
            return error.help(remedy);
        }
        match nearest(&entry.key, &valid) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help(suggestion("", &valid).unwrap_or_default()),
        }
    }
}

/// Reads a value and checks its range.
fn read_value<T: ParamType>(
    key: &str,
    value: &Value,
    range: Option<Range>,
    cx: &mut dyn ReadContext,
) -> Result<T, SceneError> {
    let read = T::read(value, cx)?;
    if let Some(range) = range
        && let Some(bad) = read.outside(&range)
    {
        let message = format!("`{key}` must be {range}, found {bad}");
        return Err(SceneError::at(ErrorCode::OutOfRange, value.span, message));
    }
    Ok(read)
}
