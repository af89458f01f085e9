//! The tree of plain values of a scene file, each with its position in the file.
//!
//! Text formats are parsed into this tree; [`crate::description::read_scene`] turns it into a description.

/// The index of a file among those that were read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A range of bytes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The span of values that a program made and that are in no file.
    pub const NONE: Span = Span { file: FileId(u32::MAX), start: 0, end: 0 };
}

/// A value and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its data.
    pub data: Data,
    /// Its position.
    pub span: Span,
}

/// The data of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// true or false.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A floating-point number, possibly infinite or NaN.
    Number(f64),
    /// Text.
    String(String),
    /// A list.
    Array(Vec<Value>),
    /// Named values.
    Table(Table),
}

impl Data {
    /// The name of its type for messages, with an article.
    pub fn kind(&self) -> &'static str {
        match self {
            Data::Bool(_) => "a boolean",
            Data::Integer(_) => "an integer",
            Data::Number(_) => "a number",
            Data::String(_) => "a string",
            Data::Array(_) => "an array",
            Data::Table(_) => "a table",
        }
    }
}

/// Named values in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The entries. Keys are unique.
    pub entries: Vec<Entry>,
}

/// One `key = value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// The position of the key.
    pub key_span: Span,
    /// The value.
    pub value: Value,
}

impl Table {
    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|e| e.key == key).map(|e| &e.value)
    }

    /// The value of `key`, mutable.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Value> {
        self.entries.iter_mut().find(|e| e.key == key).map(|e| &mut e.value)
    }

    /// Sets `key`; replaces its value if the table has the key.
    pub fn set(&mut self, key: &str, key_span: Span, value: Value) {
        match self.entries.iter_mut().find(|e| e.key == key) {
            Some(e) => (e.key_span, e.value) = (key_span, value),
            None => self.entries.push(Entry { key: key.to_owned(), key_span, value }),
        }
    }
}
