//! The contents as JSON. docs/reference/images.md documents the keys: new ones may be added, the meaning of a key does
//! not change.

use serde_json::{Map, Value, json};

use super::contents::{Contents, Part};

/// One object.
pub(super) fn of(c: &Contents) -> Value {
    let metadata: Map<String, Value> =
        c.metadata.iter().map(|(key, value)| (key.clone(), json!(value.to_string()))).collect();
    json!({
        "file": c.name,
        "bytes": c.bytes,
        "format": c.format.name(),
        "width": c.width,
        "height": c.height,
        "parts": c.parts.iter().map(part).collect::<Vec<_>>(),
        "metadata": metadata,
        "pixel": c.pixel.map(|(x, y)| json!({ "x": x, "y": y, "values": values(c) })),
    })
}

fn part(part: &Part) -> Value {
    let channels: Vec<Value> = part
        .channels
        .iter()
        .map(|c| {
            let range = c.statistics.range;
            json!({
                "name": c.name,
                "type": c.kind,
                "min": range.map(|r| r.0),
                "max": range.map(|r| r.1),
                "mean": range.map(|r| r.2),
                "nan": c.statistics.nan,
                "infinite": c.statistics.infinite,
            })
        })
        .collect();
    let exr = part.exr.as_ref();
    json!({
        "name": exr.and_then(|p| p.name.clone()),
        "compression": exr.map(|p| p.compression),
        "tiles": exr.and_then(|p| p.tiles).map(|(width, height)| json!({ "width": width, "height": height })),
        "data_window": exr.map(|p| {
            let [x, y, width, height] = p.data;
            json!({ "x": x, "y": y, "width": width, "height": height })
        }),
        "deep": exr.is_some_and(|p| p.deep),
        "channels": channels,
    })
}

/// The values of the pixel by channel; `null` for NaN and infinities, which JSON cannot hold.
fn values(c: &Contents) -> Map<String, Value> {
    let channels = c.parts.iter().flat_map(|p| &p.channels);
    channels.map(|c| (c.name.clone(), json!(c.value.filter(|v| v.is_finite())))).collect()
}
