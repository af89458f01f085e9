//! Parses TOML 1.1 into a tree of values with spans.

use std::ops::Range;

use toml::de::{DeTable, DeValue};
use turner::schema::value::{Data, Entry, FileId, Span, Table, Value};
use turner::schema::{ErrorCode, SceneError};

use super::{MAX_TEXT, nesting};
use crate::assets::printable;

/// Most digits of a number: enough for the exact decimal of any f64, few enough to parse fast.
const MAX_DIGITS: usize = 1100;

/// Memory for parsing, in bytes per byte of text; measured with lists of numbers and of objects.
pub(super) const PER_BYTE: u64 = 32;

/// Decodes a file as UTF-8; the error names the first invalid byte.
pub(super) fn utf8(bytes: Vec<u8>, name: &str) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let byte = e.as_bytes().get(at).copied().unwrap_or_default();
        let line = e.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        let name = printable(name);
        let message = format!("{name}: not UTF-8 text: byte {at} (line {line}) is {byte:#04x}");
        SceneError::new(ErrorCode::Syntax, message)
            .help(format!("save it as UTF-8; scenes are text files: {}", super::SceneFormat::listing()))
    })
}

/// Parses a file into its top-level table.
pub fn parse(text: &str, file: FileId) -> Result<Value, SceneError> {
    check_size(text)?;
    nesting::check(text, file)?;
    let table = DeTable::parse(text).map_err(|e| syntax(&e, file, 0, text.len()))?;
    let walk = Walk { file, offset: 0 };
    Ok(Value { data: Data::Table(walk.table(table.into_inner())?), span: walk.span(0..text.len()) })
}

/// Parses one value, as after `=`. It begins at byte `offset` of the file.
pub(super) fn parse_value(text: &str, file: FileId, offset: usize) -> Result<Value, SceneError> {
    check_size(text)?;
    nesting::check(text, file)?;
    let value = DeValue::parse(text).map_err(|e| syntax(&e, file, offset, text.len()))?;
    let span = value.span();
    Walk { file, offset }.value(value.into_inner(), span)
}

fn check_size(text: &str) -> Result<(), SceneError> {
    if text.len() as u64 <= MAX_TEXT {
        return Ok(());
    }
    let message = format!("the scene has {} bytes; expected at most {MAX_TEXT}", text.len());
    Err(SceneError::new(ErrorCode::TooLarge, message).help("keep large data in mesh files"))
}

fn syntax(error: &toml::de::Error, file: FileId, offset: usize, len: usize) -> SceneError {
    let span = error.span().unwrap_or(len..len);
    let message = printable(error.message());
    let help = match message.as_str() {
        m if m.starts_with("duplicate key") => {
            "each key and each [table] may appear once; write several objects as [[object]]"
        }
        m if m.contains("quoted") || m.contains("string") => "put text in quotes: color = \"red\"",
        _ => "a scene is TOML 1.1: lines `key = value` below a `[section]`",
    };
    SceneError::at(ErrorCode::Syntax, Walk { file, offset }.span(span), message).help(help)
}

/// Converts the tree of the parser. Its depth is bounded: see [`nesting`].
struct Walk {
    file: FileId,
    offset: usize,
}

impl Walk {
    fn span(&self, range: Range<usize>) -> Span {
        let at = |i: usize| u32::try_from(i + self.offset).unwrap_or(u32::MAX);
        Span { file: self.file, start: at(range.start), end: at(range.end) }
    }

    fn table(&self, table: DeTable<'_>) -> Result<Table, SceneError> {
        let mut entries = Vec::with_capacity(table.len());
        for (key, value) in table {
            let (key_span, span) = (self.span(key.span()), value.span());
            let value = self.value(value.into_inner(), span)?;
            entries.push(Entry { key: key.into_inner().into_owned(), key_span, value });
        }
        // The parser sorts keys by name; a scene keeps the order of its file.
        entries.sort_by_key(|e| e.key_span.start);
        Ok(Table { entries })
    }

    fn value(&self, value: DeValue<'_>, span: Range<usize>) -> Result<Value, SceneError> {
        let span = self.span(span);
        let data = match value {
            DeValue::String(s) => Data::String(s.into_owned()),
            DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
                Ok(v) => Data::Integer(v),
                Err(_) => {
                    let message = format!("the integer {} does not fit 64 bits", printable(&i.to_string()));
                    return Err(SceneError::at(ErrorCode::OutOfRange, span, message)
                        .help("write it with a decimal point"));
                }
            },
            DeValue::Float(f) => match f.as_str().parse::<f64>() {
                _ if f.as_str().len() > MAX_DIGITS => {
                    let message =
                        format!("a number of {} digits; expected at most {MAX_DIGITS}", f.as_str().len());
                    return Err(SceneError::at(ErrorCode::OutOfRange, span, message)
                        .help("17 digits are enough for any value"));
                }
                Ok(v) if v.is_finite() || !f.as_str().contains(|c: char| c.is_ascii_digit()) => {
                    Data::Number(v)
                }
                _ => {
                    let message = format!("the number {} is too large", printable(f.as_str()));
                    return Err(SceneError::at(ErrorCode::OutOfRange, span, message)
                        .help("the largest is 1.7976931348623157e308"));
                }
            },
            DeValue::Boolean(b) => Data::Bool(b),
            DeValue::Datetime(d) => {
                let message = format!("expected a number, text, list or table, found the date or time {d}");
                return Err(SceneError::at(ErrorCode::WrongType, span, message)
                    .help("scenes have no dates; put it in quotes if it is a name"));
            }
            DeValue::Array(items) => {
                let mut out = Vec::with_capacity(items.len());
                for item in items {
                    let at = item.span();
                    out.push(self.value(item.into_inner(), at)?);
                }
                Data::Array(out)
            }
            DeValue::Table(table) => Data::Table(self.table(table)?),
        };
        Ok(Value { data, span })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(text: &str) -> Data {
        match parse(&format!("a = {text}"), FileId(0)).unwrap().data {
            Data::Table(t) => t.entries.into_iter().next().unwrap().value.data,
            other => other,
        }
    }

    #[test]
    fn numbers_of_every_spelling() {
        assert_eq!(get("0xff"), Data::Integer(255));
        assert_eq!(get("1_000"), Data::Integer(1000));
        assert_eq!(get("0b11"), Data::Integer(3));
        assert_eq!(get("-9223372036854775808"), Data::Integer(i64::MIN));
        assert_eq!(get("-inf"), Data::Number(f64::NEG_INFINITY));
        assert!(matches!(get("nan"), Data::Number(v) if v.is_nan()));
        assert_eq!(get("1_0.5e1"), Data::Number(105.0));
    }

    #[test]
    fn numbers_that_do_not_fit_and_dates_are_refused() {
        for (text, code) in [
            ("9223372036854775808", ErrorCode::OutOfRange),
            ("1e999", ErrorCode::OutOfRange),
            ("1979-05-27", ErrorCode::WrongType),
            ("07:32:00", ErrorCode::WrongType),
        ] {
            let error = parse(&format!("a = {text}"), FileId(0)).unwrap_err();
            assert_eq!(error.code, code, "{text}: {error}");
            assert_eq!(error.span.map(|s| s.start), Some(4));
        }
        let long = format!("a = 0.{}", "1".repeat(100_000));
        assert_eq!(parse(&long, FileId(0)).unwrap_err().code, ErrorCode::OutOfRange);
    }

    #[test]
    fn spans_and_order_are_those_of_the_file() {
        let text = "z = 1\n[[object]]\nb = {y = [1, 2], x = 3}\na.c = 4\n[[object]]\n";
        let Data::Table(root) = parse(text, FileId(3)).unwrap().data else { panic!() };
        assert_eq!(root.entries.iter().map(|e| e.key.as_str()).collect::<Vec<_>>(), ["z", "object"]);
        let Data::Array(objects) = &root.entries[1].value.data else { panic!() };
        let at = |s: Span| &text[s.start as usize..s.end as usize];
        assert_eq!((objects.len(), at(objects[0].span)), (2, "[[object]]"));
        let Data::Table(object) = &objects[0].data else { panic!() };
        assert_eq!(
            (object.entries[0].key.as_str(), at(object.entries[0].value.span)),
            ("b", "{y = [1, 2], x = 3}")
        );
        assert_eq!(at(object.entries[1].key_span), "a");
        assert_eq!(object.entries[0].value.span.file, FileId(3));
    }
}
