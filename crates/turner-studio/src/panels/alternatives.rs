//! Keys that exclude each other: corners, or centre and size of a box; `from`, or `direction` of a directional light.

use turner::math::DVec3;
use turner::schema::value::{Data, Span, Table, Value};

use crate::widgets::field::numbers;

fn is_a(table: &Table, kind: &str) -> bool {
    matches!(table.get("type").map(|value| &value.data), Some(Data::String(name)) if name == kind)
}

/// Three numbers of a part.
fn vector(table: &Table, key: &str) -> Option<DVec3> {
    let values = numbers(&table.get(key)?.data)?;
    <[f64; 3]>::try_from(values).ok().map(DVec3::from_array)
}

/// The part with these keys instead of `old`.
fn with(table: &Table, old: &[&str], new: &[(&str, DVec3)]) -> Table {
    let mut rest = table.clone();
    rest.entries.retain(|entry| !old.contains(&entry.key.as_str()));
    for (key, v) in new {
        let items = v.to_array().map(|v| Value::new(Data::Number(v))).to_vec();
        rest.set(key, Span::NONE, Value::new(Data::Array(items)));
    }
    rest
}

/// The corner that a corner of a box does not go without.
pub(crate) fn other(table: &Table, key: &str) -> Option<&'static str> {
    match key {
        "min" if is_a(table, "box") => Some("max"),
        "max" if is_a(table, "box") => Some("min"),
        _ => None,
    }
}

/// The keys of a part once it is given the way that `key` belongs to; the part stays what it is. `None` if the key takes
/// any value without a change of others.
pub(crate) fn set(table: &Table, key: &str) -> Option<Table> {
    match key {
        "from" | "direction" if is_a(table, "directional") => {
            let old = if key == "from" { "direction" } else { "from" };
            let v = vector(table, old).filter(|_| table.get(key).is_none())?;
            Some(with(table, &[old], &[(key, -v)]))
        }
        "min" | "max" | "center" | "size" if is_a(table, "box") => set_box(table, key),
        _ => None,
    }
}

fn set_box(table: &Table, key: &str) -> Option<Table> {
    let (min, max) = (vector(table, "min"), vector(table, "max"));
    let by_corners = min.is_some() || max.is_some();
    let wants_corners = matches!(key, "min" | "max");
    if (wants_corners == by_corners && min.is_some() == max.is_some()) || !(wants_corners || by_corners) {
        return None;
    }
    let center = vector(table, "center").unwrap_or(DVec3::ZERO);
    let half = 0.5 * vector(table, "size").unwrap_or(DVec3::splat(2.0));
    let min = min.unwrap_or_else(|| max.map_or(center - half, |max| max - 2.0));
    let max = max.unwrap_or_else(|| if by_corners { min + 2.0 } else { center + half });
    let new = match wants_corners {
        true => [("min", min), ("max", max)],
        false => [("center", 0.5 * (min + max)), ("size", max - min)],
    };
    Some(with(table, &["min", "max", "center", "size"], &new))
}
