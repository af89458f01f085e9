//! Primvars: values per point, face or corner, with indices or without (UsdGeomPrimvar).

use super::stage::{Prim, Stage};
use super::value::{Read, Value};

/// What a primvar has one value for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Per {
    Mesh,
    Face,
    Point,
    Corner,
}

/// A primvar with vectors of `N` components.
#[derive(Clone, Debug)]
pub(super) struct Primvar<const N: usize> {
    pub(super) values: Vec<[f32; N]>,
    indices: Vec<u32>,
    pub(super) per: Per,
}

impl<const N: usize> Primvar<N> {
    /// The index of the value at a corner of a face; `None` without one.
    pub(super) fn index(&self, face: usize, corner: usize, point: usize) -> Option<u32> {
        let at = match self.per {
            Per::Mesh => 0,
            Per::Face => face,
            Per::Point => point,
            Per::Corner => corner,
        };
        let index = if self.indices.is_empty() { u32::try_from(at).ok()? } else { *self.indices.get(at)? };
        ((index as usize) < self.values.len()).then_some(index)
    }

    /// Whether all is one value per point, in the order of the points.
    pub(super) fn is_by_point(&self) -> bool {
        self.per == Per::Point && self.indices.is_empty()
    }

    /// The value at a point, or the only one.
    pub(super) fn at_point(&self, point: usize) -> Option<[f32; N]> {
        self.index(usize::MAX, usize::MAX, point).and_then(|i| self.values.get(i as usize)).copied()
    }
}

/// The vectors of an array, or of one vector.
pub(super) fn vectors<const N: usize>(value: &Value) -> Option<Vec<[f32; N]>> {
    let single = |list: &[f64]| list.as_chunks::<N>().0.iter().map(|v| v.map(|v| v as f32)).collect();
    match value {
        Value::Floats(width, list) if *width == N => Some(list.as_chunks::<N>().0.to_vec()),
        Value::Doubles(width, list) if *width == N => Some(single(list)),
        Value::Vector(list) if list.len() == N => Some(single(list)),
        Value::Real(v) if N == 1 => Some(vec![[*v as f32; N]]),
        _ => None,
    }
}

/// Whole numbers.
pub(super) fn integers(value: Option<Value>) -> Vec<i64> {
    match value {
        Some(Value::Ints(list)) => list,
        Some(Value::Int(v)) => vec![v],
        _ => Vec::new(),
    }
}

/// Numbers without vectors.
pub(super) fn numbers(value: Option<&Value>) -> Vec<f64> {
    match value {
        Some(Value::Floats(1, list)) => list.iter().map(|v| f64::from(*v)).collect(),
        Some(Value::Doubles(1, list)) => list.clone(),
        Some(Value::Real(v)) => vec![*v],
        _ => Vec::new(),
    }
}

/// The primvar or attribute with a name; `None` if it has no value or another type. `otherwise` is its interpolation if
/// none is authored.
pub(super) fn read<const N: usize>(
    stage: &Stage<'_>,
    prim: &Prim,
    name: &str,
    otherwise: Per,
) -> Read<Option<Primvar<N>>> {
    let Some(values) = stage.value(prim, name)?.as_ref().and_then(vectors::<N>) else { return Ok(None) };
    if values.is_empty() {
        return Ok(None);
    }
    let interpolation = stage.field(prim, Some(name), "interpolation")?;
    let per = match interpolation.as_ref().and_then(Value::text) {
        Some("constant") => Per::Mesh,
        Some("uniform") => Per::Face,
        Some("vertex" | "varying") => Per::Point,
        Some("faceVarying") => Per::Corner,
        _ => otherwise,
    };
    // A negative index has no value.
    let indices = integers(stage.value(prim, &format!("{name}:indices"))?);
    let indices = indices.into_iter().map(|i| u32::try_from(i).unwrap_or(u32::MAX)).collect();
    Ok(Some(Primvar { values, indices, per }))
}
