//! Values and specs of layers, without composition.

use std::collections::BTreeMap;

/// Why a layer cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Broken {
    /// Line and column from 1 in a text layer; 0 in a binary one.
    pub(super) line: u32,
    pub(super) column: u32,
    pub(super) problem: String,
}

impl Broken {
    /// Without a position.
    pub(super) fn new(problem: impl Into<String>) -> Broken {
        Broken { line: 0, column: 0, problem: problem.into() }
    }
}

/// Shorthand for results of this module.
pub(super) type Read<T> = Result<T, Broken>;

/// A value of a field. Scalars and vectors of all numeric types share a variant: the precision of the file is that of
/// single or double precision.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// A value block: no value, also in weaker layers.
    Blocked,
    Bool(bool),
    Int(i64),
    Real(f64),
    /// A string or a token.
    Text(String),
    /// The path of a file.
    Asset(String),
    /// One vector, quaternion (w, x, y, z) or matrix (by rows).
    Vector(Vec<f64>),
    /// Integers and booleans.
    Ints(Vec<i64>),
    /// Vectors of `0` components one after the other.
    Floats(usize, Vec<f32>),
    /// The same in double precision.
    Doubles(usize, Vec<f64>),
    Texts(Vec<String>),
    Dictionary(BTreeMap<String, Value>),
    /// Edits of a list of texts or paths.
    List(ListEdit<String>),
    /// Edits of a list of references or payloads.
    References(ListEdit<Reference>),
    /// Time offsets of sublayers.
    Offsets(Vec<Offset>),
    /// Values by time.
    Samples(Vec<(f64, Value)>),
    /// A value of a binary layer that is not decoded yet.
    Stored(u64),
    /// A value of a type without effect on a picture.
    Other,
}

/// A map of times: `offset + scale * t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Offset {
    pub(super) offset: f64,
    pub(super) scale: f64,
}

impl Default for Offset {
    fn default() -> Offset {
        Offset { offset: 0.0, scale: 1.0 }
    }
}

impl Offset {
    /// `self` after `inner`.
    pub(super) fn of(self, inner: Offset) -> Offset {
        Offset { offset: self.offset + self.scale * inner.offset, scale: self.scale * inner.scale }
    }

    /// The time of the layer at a time of the stage.
    pub(super) fn inverse(self, time: f64) -> f64 {
        let t = (time - self.offset) / self.scale;
        if t.is_finite() { t } else { time }
    }
}

/// A reference or a payload.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Reference {
    /// The file; empty for one in the same layer stack.
    pub(super) asset: String,
    /// The prim; empty for the default prim.
    pub(super) prim: String,
    pub(super) offset: Offset,
}

/// A list that edits that of weaker layers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ListEdit<T> {
    /// Replaces the list.
    pub(super) explicit: Option<Vec<T>>,
    pub(super) prepended: Vec<T>,
    /// At the end, unless they are there already.
    pub(super) added: Vec<T>,
    pub(super) appended: Vec<T>,
    pub(super) deleted: Vec<T>,
}

impl<T> Default for ListEdit<T> {
    fn default() -> ListEdit<T> {
        ListEdit {
            explicit: None,
            prepended: Vec::new(),
            added: Vec::new(),
            appended: Vec::new(),
            deleted: Vec::new(),
        }
    }
}

impl<T: Clone + PartialEq> ListEdit<T> {
    /// A list that replaces those of weaker layers.
    pub(super) fn of(items: Vec<T>) -> ListEdit<T> {
        ListEdit { explicit: Some(items), ..ListEdit::default() }
    }

    /// Edits the list of the weaker layers.
    pub(super) fn apply(&self, list: &mut Vec<T>) {
        if let Some(items) = &self.explicit {
            list.clone_from(items);
            return;
        }
        list.retain(|item| {
            !self.deleted.contains(item) && !self.prepended.contains(item) && !self.appended.contains(item)
        });
        let first = self.prepended.iter().cloned();
        list.splice(0..0, first);
        for item in &self.added {
            if !list.contains(item) {
                list.push(item.clone());
            }
        }
        list.extend(self.appended.iter().cloned());
    }
}

/// The fields of a prim, a property, a variant or a layer.
pub(super) type Fields = Vec<(String, Value)>;

/// The field with a name.
pub(super) fn field<'a>(fields: &'a Fields, name: &str) -> Option<&'a Value> {
    fields.iter().find(|(n, _)| n == name).map(|(_, value)| value)
}

impl Value {
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Value::Text(text) | Value::Asset(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn real(&self) -> Option<f64> {
        match self {
            Value::Real(v) => Some(*v),
            Value::Int(v) => Some(*v as f64),
            Value::Bool(v) => Some(f64::from(u8::from(*v))),
            _ => None,
        }
    }

    pub(super) fn flag(&self) -> Option<bool> {
        match self {
            Value::Bool(v) => Some(*v),
            Value::Int(v) => Some(*v != 0),
            _ => None,
        }
    }
}
