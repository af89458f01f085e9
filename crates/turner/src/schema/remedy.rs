//! What would mend a fault, as data: a front end words it as its own flag, button or call, or carries it out.

use turner_bvh::Quality;

use super::KeyEdit;
use super::value::{Data, Value};

/// Something that a program can do about an error, a warning or a finding.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Set these values of the scene, all together.
    Set(Vec<KeyEdit>),
    /// Raise the limit of [`Limits::memory`](super::Limits::memory).
    MoreMemory,
    /// Raise [`Limits::max_triangles`](super::Limits::max_triangles).
    MoreTriangles,
    /// Let pictures have more columns and rows.
    LargerPictures,
    /// Let the scene read another folder than its own.
    OpenFolder,
    /// Replace the file that is there.
    Replace,
    /// Give a value to this name, which the scene leaves open.
    Define(String),
    /// Take a picture as the environment map.
    Environment,
    /// Prepare with this [`PrepareOptions::quality`](super::PrepareOptions::quality).
    TreeQuality(Quality),
    /// Give an examination so many seconds.
    Seconds(f64),
}

impl Remedy {
    /// One value of the scene; dots separate the parts of `key`.
    pub fn set(key: &str, value: impl Into<Data>) -> Remedy {
        Remedy::Set(Vec::new()).and(key, value)
    }

    /// The same with one value more; remedies that set no values stay as they are.
    pub fn and(mut self, key: &str, value: impl Into<Data>) -> Remedy {
        if let Remedy::Set(edits) = &mut self {
            edits.push(KeyEdit::new(key, value.into()));
        }
        self
    }
}

impl From<bool> for Data {
    fn from(value: bool) -> Data {
        Data::Bool(value)
    }
}

impl From<u32> for Data {
    fn from(value: u32) -> Data {
        Data::Integer(i64::from(value))
    }
}

impl From<f64> for Data {
    fn from(value: f64) -> Data {
        Data::Number(value)
    }
}

impl From<&str> for Data {
    fn from(value: &str) -> Data {
        Data::String(value.to_owned())
    }
}

impl<T: Into<Data>, const N: usize> From<[T; N]> for Data {
    fn from(values: [T; N]) -> Data {
        Data::Array(values.into_iter().map(|v| Value::new(v.into())).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::value::{Span, Table};
    use super::*;

    #[test]
    fn a_remedy_can_be_carried_out() {
        let remedy = Remedy::set("film.samples", 64).and("film.crop", [0, 0, 8, 8u32]);
        let mut scene = Value::new(Data::Table(Table::default()));
        let Remedy::Set(edits) = remedy else { unreachable!() };
        for edit in edits {
            scene.set(&edit.path, edit.value).unwrap();
        }
        let Data::Table(scene) = scene.data else { unreachable!() };
        let Some(Data::Table(film)) = scene.get("film").map(|v| v.data.clone()) else { panic!("{scene:?}") };
        assert_eq!(film.get("samples").map(|v| &v.data), Some(&Data::Integer(64)));
        assert_eq!(film.get("samples").map(|v| v.span), Some(Span::NONE));
        assert!(matches!(film.get("crop").map(|v| &v.data), Some(Data::Array(list)) if list.len() == 4));
        // Nothing is lost where there is nothing to add to.
        assert_eq!(Remedy::Replace.and("film.samples", 1), Remedy::Replace);
    }
}
