//! Values of glTF's JSON.

use serde_json::{Map, Value};
use turner::color::Spectrum;

/// Clamps to 0..=1.
pub(super) fn unit(v: f32) -> f64 {
    f64::from(v.clamp(0.0, 1.0))
}

pub(super) fn unit_color(c: Spectrum) -> [f64; 3] {
    c.to_array().map(unit)
}

/// Inserts `key: value`.
pub(super) fn put(out: &mut Map<String, Value>, key: &str, value: impl Into<Value>) {
    out.insert(key.into(), value.into());
}

/// One more than the highest UV set that the material's textures refer to; 0 without textures.
pub(super) fn sets_asked_for(json: &Value) -> usize {
    let Value::Object(map) = json else { return 0 };
    let set = map.get("texCoord").and_then(Value::as_u64).unwrap_or(0) as usize;
    let own = if map.contains_key("index") { set + 1 } else { 0 };
    map.values().map(sets_asked_for).fold(own, usize::max)
}

/// Inserts the values that are present.
pub(super) fn put_all<const N: usize>(out: &mut Map<String, Value>, named: [(&str, Option<Value>); N]) {
    out.extend(named.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))));
}
