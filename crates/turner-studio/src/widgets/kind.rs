//! The types of values of the scene format, read from how the documentation writes them: `number`, `[u, v]`,
//! `"none" | "inverse-square" | [constant, linear, quadratic]`, `[[position, color | texture], …]`.

use turner::schema::Field;
use turner::schema::value::{Data, Table, Value};

/// A type of value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    /// true or false.
    Switch,
    /// A number, whole or not.
    Number {
        /// Whether it is whole.
        whole: bool,
    },
    /// Any text.
    Text,
    /// The name of a file.
    File,
    /// A colour.
    Color,
    /// A colour or a texture.
    Source,
    /// A part of the scene by its name: "material", "medium", "group".
    Part(&'static str),
    /// One of some words, each with its meaning.
    Word(Vec<(&'static str, &'static str)>),
    /// A fixed number of values, each with its name.
    Tuple(Vec<(String, Kind)>),
    /// Any number of values of one kind.
    List(Box<Kind>),
    /// Values by names that the user chooses.
    ByName(Box<Kind>),
    /// A shape that is a part of another one: its type is shown, its keys are edited in the file.
    Shape,
    /// Position, rotation and scale.
    Transform,
    /// A word that stands alone.
    Literal(String),
    /// `false` alone: nothing of this kind.
    False,
    /// One of several kinds.
    OneOf(Vec<Kind>),
}

impl Kind {
    /// That of a key.
    pub(crate) fn of(field: &Field) -> Kind {
        let text = (field.kind)();
        let words = (field.words)().to_vec();
        match text.starts_with('[') {
            _ if words.is_empty() => Kind::parse(&text),
            true => Kind::List(Box::new(Kind::Word(words))),
            false => Kind::Word(words),
        }
    }

    /// From the text of the documentation.
    pub(crate) fn parse(text: &str) -> Kind {
        let text = text.trim();
        match text {
            "true | false" => return Kind::Switch,
            "color | texture" => return Kind::Source,
            _ => {}
        }
        let parts = split(text, '|');
        if parts.len() > 1 {
            return Kind::OneOf(parts.into_iter().map(Kind::parse).collect());
        }
        match text {
            "number" => Kind::Number { whole: false },
            "integer" => Kind::Number { whole: true },
            "color" => Kind::Color,
            "texture" => Kind::Source,
            "material" => Kind::Part("material"),
            "medium" => Kind::Part("medium"),
            "group" => Kind::Part("group"),
            "transform" => Kind::Transform,
            "false" => Kind::False,
            "\"text\"" => Kind::Text,
            _ if text.starts_with('"') && text.ends_with("file\"") => Kind::File,
            _ if text.starts_with('"') => Kind::Literal(text.trim_matches('"').to_owned()),
            _ => Kind::in_brackets(text),
        }
    }

    fn in_brackets(text: &str) -> Kind {
        if text.starts_with("{ type = shape") {
            return Kind::Shape;
        }
        if let Some(inner) = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
            let parts = split(inner, ',');
            return match parts.as_slice() {
                [item, "…"] => Kind::List(Box::new(Kind::parse(item))),
                _ => Kind::Tuple(parts.iter().map(|part| component(part)).collect()),
            };
        }
        if let Some(inner) = text.strip_prefix('{').and_then(|t| t.strip_suffix('}'))
            && let Some((_, value)) = split(inner, ',').first().and_then(|entry| entry.split_once('='))
        {
            return Kind::ByName(Box::new(Kind::parse(value)));
        }
        // A name that the documentation gives a number.
        Kind::Number { whole: false }
    }

    /// Whether a value is of this kind.
    pub(crate) fn takes(&self, data: &Data) -> bool {
        let is_number = |data: &Data| matches!(data, Data::Integer(_) | Data::Number(_));
        match (self, data) {
            (Kind::Switch, Data::Bool(_)) | (Kind::False, Data::Bool(false)) => true,
            (Kind::Number { .. }, data) => is_number(data),
            (Kind::Text | Kind::File | Kind::Part(_), Data::String(_)) => true,
            (Kind::Color | Kind::Source, data) => match data {
                Data::Array(items) => items.len() == 3 && items.iter().all(|item| is_number(&item.data)),
                Data::String(_) => *self == Kind::Source,
                data => is_number(data),
            },
            (Kind::Word(words), Data::String(word)) => words.iter().any(|(own, _)| own == word),
            (Kind::Literal(word), Data::String(own)) => word == own,
            (Kind::Tuple(parts), Data::Array(items)) => {
                parts.len() == items.len()
                    && parts.iter().zip(items).all(|((_, kind), item)| kind.takes(&item.data))
            }
            (Kind::List(kind), Data::Array(items)) => items.iter().all(|item| kind.takes(&item.data)),
            (Kind::ByName(kind), Data::Table(table)) => {
                table.entries.iter().all(|entry| kind.takes(&entry.value.data))
            }
            (Kind::Transform | Kind::Shape, Data::Table(_)) => true,
            (Kind::OneOf(kinds), data) => kinds.iter().any(|kind| kind.takes(data)),
            _ => false,
        }
    }

    /// Whether its widgets may take several lines.
    pub(crate) fn has_lines(&self) -> bool {
        match self {
            Kind::List(item) => !matches!(**item, Kind::Word(_)),
            Kind::ByName(_) | Kind::Transform | Kind::OneOf(_) => true,
            _ => false,
        }
    }

    /// A value to start from. `names` are the names of parts of a kind.
    pub(crate) fn start(&self, names: &dyn Fn(&str) -> Vec<String>) -> Option<Data> {
        Some(match self {
            Kind::Switch | Kind::False => Data::Bool(false),
            Kind::Number { whole: true } => Data::Integer(1),
            Kind::Number { whole: false } => Data::Number(1.0),
            Kind::Text => Data::String("name".into()),
            Kind::File => return None,
            Kind::Color | Kind::Source => numbers([0.5; 3]),
            Kind::Part(part) => Data::String(names(part).into_iter().next()?),
            Kind::Word(words) => Data::String(words.first()?.0.to_owned()),
            Kind::Literal(word) => Data::String(word.clone()),
            Kind::Tuple(parts) => {
                let parts: Option<Vec<Value>> =
                    parts.iter().map(|(_, kind)| kind.start(names).map(Value::new)).collect();
                Data::Array(parts?)
            }
            Kind::List(kind) => Data::Array(vec![Value::new(kind.start(names)?)]),
            Kind::ByName(_) => Data::Table(Table::default()),
            Kind::Transform => Data::Table(Table::default()),
            Kind::Shape => {
                let mut table = Table::default();
                table.push("type", Data::String("sphere".into()));
                Data::Table(table)
            }
            Kind::OneOf(kinds) => return kinds.first()?.start(names),
        })
    }

    /// What a choice of several kinds calls it.
    pub(crate) fn label(&self) -> String {
        match self {
            Kind::Literal(word) => word.clone(),
            Kind::Tuple(parts) => parts.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
            Kind::Number { .. } => "one number".into(),
            Kind::List(_) => "list".into(),
            Kind::ByName(_) => "by name".into(),
            Kind::False => "none".into(),
            Kind::Part(part) => (*part).to_owned(),
            Kind::Source | Kind::Color => "colour".into(),
            _ => "value".into(),
        }
    }
}

/// An array of numbers.
pub(crate) fn numbers(values: impl IntoIterator<Item = f64>) -> Data {
    Data::Array(values.into_iter().map(|v| Value::new(Data::Number(v))).collect())
}

/// A component of a tuple: a type, or a name for a number.
fn component(text: &str) -> (String, Kind) {
    let is_type = matches!(text, "number" | "integer") || text.contains(['[', '|', '"']) || text == "color";
    let name = if is_type { String::new() } else { text.to_owned() };
    (name, Kind::parse(text))
}

/// Parts of a text between separators that are not in brackets.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (i, c) in text.char_indices() {
        match c {
            '[' | '{' => depth += 1,
            ']' | '}' => depth -= 1,
            c if c == separator && depth == 0 => {
                parts.push(text[start..i].trim());
                start = i + c.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number() -> Kind {
        Kind::Number { whole: false }
    }

    #[test]
    fn kinds_are_read_from_the_documentation() {
        let tuple =
            |names: &[&str]| Kind::Tuple(names.iter().map(|name| ((*name).to_owned(), number())).collect());
        let list = |kind: Kind| Kind::List(Box::new(kind));
        for (text, expected) in [
            ("number", number()),
            ("[u, v]", tuple(&["u", "v"])),
            ("[[x, y, z], …]", list(tuple(&["x", "y", "z"]))),
            ("[number, …]", list(number())),
            ("[integer, integer]", Kind::Tuple(vec![(String::new(), Kind::Number { whole: true }); 2])),
            ("[\"text\", …]", list(Kind::Text)),
            ("\"IES file\"", Kind::File),
            ("[width, height] | height", Kind::OneOf(vec![tuple(&["width", "height"]), number()])),
            ("{ NAME = material, … }", Kind::ByName(Box::new(Kind::Part("material")))),
            (
                "[[position, color | texture], …]",
                list(Kind::Tuple(vec![("position".into(), number()), (String::new(), Kind::Source)])),
            ),
            (
                "\"none\" | \"inverse-square\" | [constant, linear, quadratic]",
                Kind::OneOf(vec![
                    Kind::Literal("none".into()),
                    Kind::Literal("inverse-square".into()),
                    tuple(&["constant", "linear", "quadratic"]),
                ]),
            ),
        ] {
            assert_eq!(Kind::parse(text), expected, "{text}");
        }
    }

    #[test]
    fn values_to_start_from_are_of_their_kind() {
        let names = |_: &str| vec!["gold".to_owned()];
        for text in [
            "number",
            "[u, v]",
            "[[x, y, z], …]",
            "[[position, color | texture], …]",
            "[material | false, …]",
            "{ NAME = material, … }",
            "transform",
        ] {
            let kind = Kind::parse(text);
            assert!(kind.takes(&kind.start(&names).unwrap()), "{text}");
        }
    }
}
