//! Values that keys without one begin with. A scene with them can be rendered.

use turner::schema::value::{Data, Value};
use turner::schema::{Field, Range};

use super::field::{Around, number};
use super::kind::{Kind, numbers};

/// Of a number: 1, or the middle of its range.
pub(crate) fn scalar(field: &Field, whole: bool) -> Data {
    let Range { min, max, .. } = field.range.unwrap_or(Range::FINITE);
    let start = if (min..=max).contains(&1.0) { 1.0 } else { (0.5 * (min + max)).clamp(min, max) };
    if whole { Data::Integer(start as i64) } else { Data::Number(start) }
}

fn integers(values: &[i64]) -> Data {
    Data::Array(values.iter().map(|v| Value::new(Data::Integer(*v))).collect())
}

/// Of a value with several parts.
pub(crate) fn value(field: &Field, kind: &Kind, around: &Around<'_>) -> Option<Data> {
    match kind {
        Kind::Tuple(parts) if parts.iter().all(|(_, part)| matches!(part, Kind::Number { .. })) => {
            let whole = parts.iter().any(|(_, part)| *part == Kind::Number { whole: true });
            Some(tuple(field, parts.len(), whole, around))
        }
        // Without a file, the materials of a mesh have no names.
        Kind::OneOf(kinds) => match kinds.as_slice() {
            [Kind::ByName(_), Kind::List(item)] => Some(Data::Array(items(field, item, around))),
            _ if field.name == "viewport" => Some(numbers([6.0; 2])),
            _ => kind.start(&|part| around.names(part)),
        },
        _ => kind.start(&|part| around.names(part)),
    }
}

fn tuple(field: &Field, count: usize, whole: bool, around: &Around<'_>) -> Data {
    match (field.name, count) {
        ("crop", 4) => {
            let [w, h] = around.film.map(i64::from);
            integers(&[0, 0, w, h])
        }
        // The transform that changes nothing.
        (_, 6) => numbers([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        _ if whole => integers(&vec![field.range.map_or(0, |range| range.min.max(0.0) as i64); count]),
        // Sizes must not be 0, nor must directions. A light points down.
        _ if field.range.is_some_and(|range| range.min >= 0.0) => numbers(vec![2.0; count]),
        ("max", _) => numbers(vec![1.0; count]),
        ("min", _) => numbers(vec![-1.0; count]),
        ("center", 3) => numbers([0.0; 3]),
        ("direction", 3) if around.is_directional => numbers([-1.0, -3.0, -2.0]),
        (_, 3) => numbers([1.0, 3.0, 2.0]),
        _ => numbers(vec![1.0; count]),
    }
}

/// Of an empty list: its first items. Lists beside the vertices or triangles of a mesh are as long as those.
pub(crate) fn items(field: &Field, kind: &Kind, around: &Around<'_>) -> Vec<Value> {
    let (item, like) = match field.name {
        "normals" => (Some(numbers([0.0, 1.0, 0.0])), Some("positions")),
        "tangents" => (Some(numbers([1.0, 0.0, 0.0, 1.0])), Some("positions")),
        "uvs" | "uvs_1" => (Some(numbers([0.0; 2])), Some("positions")),
        "colors" => (Some(numbers([1.0; 4])), Some("positions")),
        "radii" => {
            let all = around.part.get("radius").and_then(|radius| number(&radius.data));
            (Some(Data::Number(all.unwrap_or(0.1))), Some("positions"))
        }
        "widths" => {
            let all = around.part.get("width").and_then(|width| number(&width.data));
            (Some(Data::Number(all.unwrap_or(0.1))), Some("points"))
        }
        // One curve of all points.
        "strands" => match around.part.get("points").map(|points| &points.data) {
            Some(Data::Array(points)) => (Some(Data::Integer(points.len() as i64)), None),
            _ => (None, None),
        },
        "face_materials" => (Some(Data::Integer(0)), Some("triangles")),
        // The middle of a gradient.
        "stops" => {
            let color = Value::new(numbers([0.5; 3]));
            (Some(Data::Array(vec![Value::new(Data::Number(0.5)), color])), None)
        }
        // A number is the plainest weight.
        _ if *kind == Kind::Source => (Some(Data::Number(1.0)), None),
        _ => (kind.start(&|part| around.names(part)), None),
    };
    // The points of curves are their vertices.
    let like = like.and_then(|key| around.part.get(key).or_else(|| around.part.get("points")));
    let count = match like.map(|value| &value.data) {
        Some(Data::Array(items)) => items.len(),
        _ => 1,
    };
    item.map_or_else(Vec::new, |item| vec![Value::new(item); count])
}
