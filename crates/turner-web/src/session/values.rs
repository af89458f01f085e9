//! Values of the scene format as JSON, and back.

use serde_json::{Map, Number, Value as Json};
use turner::schema::value::{Data, Entry, Span, Table, Value};

use super::CallError;

/// Deepest nesting of values, as in scene files.
const MAX_DEPTH: usize = 64;

/// A value as JSON. Numbers that JSON does not have are text: `inf`, `nan`.
pub(super) fn to_json(data: &Data) -> Json {
    match data {
        Data::Bool(v) => Json::Bool(*v),
        Data::Integer(v) => Json::from(*v),
        Data::Number(v) => Number::from_f64(*v).map_or_else(|| Json::String(v.to_string()), Json::Number),
        Data::String(v) => Json::String(v.clone()),
        Data::Array(items) => Json::Array(items.iter().map(|item| to_json(&item.data)).collect()),
        Data::Table(table) => {
            let entries = table.entries.iter().map(|e| (e.key.clone(), to_json(&e.value.data)));
            Json::Object(entries.collect::<Map<_, _>>())
        }
    }
}

/// A value of JSON for the scene.
///
/// Errors: null within lists and tables; nesting that is too deep.
pub(super) fn of_json(json: &Json) -> Result<Data, CallError> {
    nested(json, 0)
}

fn nested(json: &Json, depth: usize) -> Result<Data, CallError> {
    if depth > MAX_DEPTH {
        return Err(CallError::new(format!("values nest deeper than {MAX_DEPTH}")));
    }
    let value = |json: &Json| Ok(Value { data: nested(json, depth + 1)?, span: Span::NONE });
    Ok(match json {
        Json::Null => return Err(CallError::new("null is no value of a scene; leave the key out")),
        Json::Bool(v) => Data::Bool(*v),
        Json::Number(n) => {
            n.as_i64().map_or_else(|| Data::Number(n.as_f64().unwrap_or(f64::NAN)), Data::Integer)
        }
        Json::String(v) => Data::String(v.clone()),
        Json::Array(items) => Data::Array(items.iter().map(value).collect::<Result<_, CallError>>()?),
        Json::Object(map) => {
            let entry = |(key, json): (&String, &Json)| {
                Ok(Entry { key: key.clone(), key_span: Span::NONE, value: value(json)? })
            };
            Data::Table(Table { entries: map.iter().map(entry).collect::<Result<_, CallError>>()? })
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_come_back_as_they_were() {
        let json = json!({ "a": [1, 2.5, "x", true], "b": { "c": [] } });
        assert_eq!(to_json(&of_json(&json).unwrap()), json);
    }

    #[test]
    fn nulls_and_deep_values_are_errors() {
        assert!(of_json(&json!([null])).is_err());
        let deep = (0..100).fold(json!(1), |inner, _| json!([inner]));
        assert!(of_json(&deep).is_err());
    }
}
