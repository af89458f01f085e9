//! Reads the `type` of a table, which selects a member of a family.

use super::error::unknown_name;
use super::value::{Data, Span};
use super::{ErrorCode, FamilyDoc, ReadContext, SceneError, TableReader, foreign, old_names, wrong_type};

/// Reads the `type` of a table and the keys of that type, and reports unknown keys. If the type is invalid, the result
/// is the default and the keys are not checked. `kind` is what the family is called, with the types that are valid
/// here beside those of the family.
pub fn read_kind<T: Default>(
    table: &mut TableReader<'_>,
    (kind, others): (&str, &[&str]),
    default: Option<&str>,
    cx: &mut dyn ReadContext,
    doc: &FamilyDoc,
    read: impl Fn(&str, &mut TableReader<'_>, &mut dyn ReadContext) -> Result<Option<T>, SceneError>,
) -> Result<T, SceneError> {
    let mut valid: Vec<&str> = doc.entries.iter().map(|e| e.name).collect();
    valid.extend(others);
    let name = match (table.take("type"), default) {
        (Some(value), _) => match &value.data {
            Data::String(name) => name.as_str(),
            _ => {
                cx.fault(wrong_type(value, &format!("the name of a {kind}")))?;
                return Ok(T::default());
            }
        },
        (None, Some(default)) => default,
        (None, None) => {
            let message = format!("this {kind} needs the key `type`");
            cx.fault(
                SceneError::at(ErrorCode::MissingKey, table.span(), message)
                    .help(format!("add `type = \"…\"`, one of: {}", valid.join(", "))),
            )?;
            return Ok(T::default());
        }
    };
    let span = table.span_of("type");
    let name = match old_names::new_type(name) {
        Some(new) if valid.contains(&new) => {
            old_names::note(name, new, span, cx);
            new
        }
        _ => name,
    };
    let before = cx.faults();
    match read(name, table, cx) {
        Ok(None) => {
            cx.fault(unknown_kind(span, kind, name, &valid))?;
            Ok(T::default())
        }
        read => {
            let read = cx.noted_after(before, read)?.flatten();
            table.finish(cx)?;
            Ok(read.unwrap_or_default())
        }
    }
}

/// The error for a `type` that does not exist.
fn unknown_kind(span: Span, kind: &str, name: &str, valid: &[&str]) -> SceneError {
    let error = unknown_name(ErrorCode::UnknownName, span, kind, name, valid);
    match foreign::kind(kind, name) {
        Some(remedy) => error.help(remedy),
        None => error,
    }
}
