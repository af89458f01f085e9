//! Messages of the JSON parser in the words of JSON.

/// A message of serde without names of Rust's types: `invalid type: map, expected struct X` is `found an object, expected
/// an object`.
pub(super) fn in_words(said: &str) -> String {
    let (found, expected) = match said.split_once(", expected ") {
        Some((found, expected)) => (found, Some(expected)),
        None => (said, None),
    };
    let found = match found.strip_prefix("invalid type: ").or_else(|| found.strip_prefix("invalid value: ")) {
        Some(what) => format!("found {}", of_value(what)),
        None => found.to_owned(),
    };
    match expected {
        Some(expected) => format!("{found}, expected {}", of_type(expected)),
        None => found,
    }
}

/// What was found.
fn of_value(found: &str) -> String {
    let words = [
        ("floating point", "the number"),
        ("integer", "the number"),
        ("boolean", "the boolean"),
        ("string", "the text"),
        ("sequence", "an array"),
        ("map", "an object"),
        ("unit value", "null"),
        ("null", "null"),
    ];
    match words.iter().find(|(word, _)| found.starts_with(word)) {
        Some((word, json)) => format!("{json}{}", found.get(word.len()..).unwrap_or_default()),
        None => found.to_owned(),
    }
}

/// What was expected.
fn of_type(expected: &str) -> &str {
    match expected {
        "f64" | "f32" => "a number",
        "a string" => "text",
        "a sequence" | "a list" => "an array",
        "a map" => "an object",
        _ if expected.starts_with("struct ") => "an object",
        _ => expected,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_the_names_of_json() {
        let cases = [
            ("invalid type: integer `7`, expected struct Node", "found the number `7`, expected an object"),
            ("invalid type: map, expected f64", "found an object, expected a number"),
            ("invalid type: string \"a\", expected a list", "found the text \"a\", expected an array"),
            ("invalid type: null, expected a string", "found null, expected text"),
            ("missing field `index`", "missing field `index`"),
            ("expected `,` or `]`", "expected `,` or `]`"),
        ];
        for (said, expected) in cases {
            assert_eq!(in_words(said), expected);
        }
    }
}
