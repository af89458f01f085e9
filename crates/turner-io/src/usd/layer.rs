//! A layer: specs by path, from text or binary files.

use std::borrow::Cow;

use super::binary::{self, Binary};
use super::text::{self, Specs};
use super::value::{Broken, Read, Value, field};

/// A layer.
pub(super) enum Layer {
    Text(Specs),
    Binary(Box<Binary>),
}

impl Layer {
    /// Reads a layer; its first bytes tell whether it is binary.
    pub(super) fn read(bytes: Vec<u8>) -> Read<Layer> {
        if bytes.starts_with(binary::MAGIC) {
            return Binary::read(bytes).map(|b| Layer::Binary(Box::new(b)));
        }
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| Broken::new("is neither text in UTF-8 nor binary USD"))?;
        let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
        if !text.starts_with("#usda") {
            return Err(Broken::new("does not begin with \"#usda\", as text files of USD do"));
        }
        text::read(text).map(Layer::Text)
    }

    /// Whether the layer has opinions about a prim or a property.
    pub(super) fn has(&self, path: &str) -> bool {
        match self {
            Layer::Text(specs) => specs.contains_key(path),
            Layer::Binary(binary) => binary.specs.contains_key(path),
        }
    }

    /// A field of a spec.
    pub(super) fn field(&self, path: &str, name: &str) -> Read<Option<Cow<'_, Value>>> {
        match self {
            Layer::Text(specs) => Ok(specs.get(path).and_then(|f| field(f, name)).map(Cow::Borrowed)),
            Layer::Binary(binary) => {
                binary.stored(path, name).map(|v| binary.decode(v).map(Cow::Owned)).transpose()
            }
        }
    }

    /// A value that a field contains, decoded.
    pub(super) fn open(&self, value: &Value) -> Read<Value> {
        match (self, value) {
            (Layer::Binary(binary), Value::Stored(stored)) => binary.decode(*stored),
            _ => Ok(value.clone()),
        }
    }
}
