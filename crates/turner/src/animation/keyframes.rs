//! The values of keyframes: what a scene file may have at a key, with its position in the file for messages.

use crate::schema::value::{Data, Value};
use crate::schema::write::list;
use crate::schema::{ParamType, ReadContext, SceneError, WriteContext, wrong_type};

/// The values of keyframes, one for each time. Two are equal if their data are, wherever they stand in a file.
#[derive(Clone, Debug, Default)]
pub struct Keyframes(pub Vec<Value>);

impl Keyframes {
    /// One keyframe with a position.
    pub(super) fn position(p: [f64; 3]) -> Keyframes {
        Keyframes(vec![Value::new(list(p.map(Data::Number)))])
    }
}

impl PartialEq for Keyframes {
    fn eq(&self, other: &Keyframes) -> bool {
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(|(a, b)| same(&a.data, &b.data))
    }
}

/// Whether two data are equal apart from their positions. Whole numbers equal their floating-point form.
fn same(a: &Data, b: &Data) -> bool {
    match (a, b) {
        (Data::Array(a), Data::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(&a.data, &b.data))
        }
        (Data::Table(a), Data::Table(b)) => {
            let pairs = a.entries.iter().zip(&b.entries);
            a.entries.len() == b.entries.len()
                && pairs.into_iter().all(|(a, b)| a.key == b.key && same(&a.value.data, &b.value.data))
        }
        (Data::Integer(a), Data::Number(b)) | (Data::Number(b), Data::Integer(a)) => *a as f64 == *b,
        (a, b) => a == b,
    }
}

impl ParamType for Keyframes {
    fn kind() -> String {
        "[value, …]".into()
    }
    fn read(value: &Value, _: &mut dyn ReadContext) -> Result<Keyframes, SceneError> {
        match &value.data {
            Data::Array(items) => Ok(Keyframes(items.clone())),
            _ => Err(wrong_type(value, "a list of values, one for each time")),
        }
    }
    fn show(&self) -> String {
        format!("{} values", self.0.len())
    }
    fn write(&self, _: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        Ok(Some(Data::Array(self.0.clone())))
    }
}
