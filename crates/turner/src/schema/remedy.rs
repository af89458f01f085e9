//! Remedies as data. A front end shows one as its own flag, button or call, or applies it.

use turner_bvh::Quality;

use super::KeyEdit;
use super::value::{Data, Value};

/// An action that resolves an error, a warning or a finding.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Set all these values of the scene.
    Set(Vec<KeyEdit>),
    /// Raise the limit [`Limits::memory`](super::Limits::memory).
    MoreMemory,
    /// Raise [`Limits::max_triangles`](super::Limits::max_triangles).
    MoreTriangles,
    /// Raise the limit on the width and height of images.
    LargerPictures,
    /// Allow the scene to read files outside its own folder.
    OpenFolder,
    /// Replace the existing file.
    Replace,
    /// Define this name, which the scene uses but does not define.
    Define(String),
    /// Use an image as the environment map.
    Environment,
    /// Prepare the scene with this [`PrepareOptions::quality`](super::PrepareOptions::quality).
    TreeQuality(Quality),
    /// Give the doctor this time budget, seconds.
    Seconds(f64),
}

impl Remedy {
    /// Sets one value of the scene. Dots separate the parts of `key`.
    pub fn set(key: &str, value: impl Into<Data>) -> Remedy {
        Remedy::Set(Vec::new()).and(key, value)
    }

    /// Sets one more value. Remedies other than [`Remedy::Set`] stay the same.
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
        // Remedies that set no values stay the same.
        assert_eq!(Remedy::Replace.and("film.samples", 1), Remedy::Replace);
    }
}
