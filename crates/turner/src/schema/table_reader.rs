//! Tables of a scene file, key by key.

use super::error::{ErrorCode, SceneError, escape, nearest, suggestion};
use super::foreign;
use super::value::{Data, Entry, Span, Table, Value};
use super::{ParamType, Range, ReadContext, old_names, wrong_type};

/// Reads the keys of one table, remembers which were asked for, and refuses the others.
pub struct TableReader<'a> {
    table: &'a Table,
    span: Span,
    what: String,
    known: Vec<&'static str>,
}

impl<'a> TableReader<'a> {
    /// A reader of a table that is `what` (for messages: "a sphere", "the camera").
    pub fn new(table: &'a Table, span: Span, what: impl Into<String>) -> TableReader<'a> {
        TableReader { table, span, what: what.into(), known: Vec::new() }
    }

    /// A reader of a value that must be a table.
    pub fn of(value: &'a Value, what: impl Into<String>) -> Result<TableReader<'a>, SceneError> {
        match &value.data {
            Data::Table(table) => Ok(TableReader::new(table, value.span, what)),
            _ => Err(wrong_type(value, "a table { key = value, … }")),
        }
    }

    /// Names the table more exactly, once its type is known.
    pub fn rename(&mut self, what: impl Into<String>) {
        self.what = what.into();
    }

    /// Where the table stands.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The value of a key; the key counts as known from here on.
    pub fn take(&mut self, key: &'static str) -> Option<&'a Value> {
        self.known.push(key);
        self.table.get(key)
    }

    /// The value of a key, by its new name or by its old one, with a note about the latter.
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

    /// Where the key or, without it, the table stands.
    pub fn span_of(&self, key: &str) -> Span {
        self.table.get(key).map_or(self.span, |v| v.span)
    }

    /// The value of a key, typed.
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

    /// The value of a key that must be given; `start` where reading continues without it.
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

    /// Refuses keys nobody asked for.
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

/// A value of its type within its range.
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
