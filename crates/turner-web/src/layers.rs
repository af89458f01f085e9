//! AOVs as layers: the channels of each side by side.

use serde_json::{Value as Json, json};
use turner::film::Aov;
use turner::render::{AovChannel, AovValues};

use crate::picture::PictureJob;
use crate::session::Reply;

/// An AOV, or one layer of it.
struct Layer {
    name: String,
    channels: Vec<AovChannel>,
}

/// The name of the layer that a channel belongs to.
fn layer_of(channel: &AovChannel) -> String {
    match channel.aov {
        // `light.key.R`: one layer for each light group.
        Aov::LightGroups => {
            channel.name.rsplit_once('.').map_or(channel.name.clone(), |(layer, _)| layer.to_owned())
        }
        aov => aov.word().to_owned(),
    }
}

/// Channels as layers, in order. A layer has values of one type.
fn layers(channels: Vec<AovChannel>) -> Vec<Layer> {
    let mut out: Vec<Layer> = Vec::new();
    for channel in channels {
        let name = layer_of(&channel);
        match out.last_mut() {
            Some(last) if last.name == name => last.channels.push(channel),
            _ => out.push(Layer { name, channels: vec![channel] }),
        }
    }
    out
}

fn bits(values: &AovValues, at: usize) -> Option<[u8; 4]> {
    match values {
        AovValues::Float(values) => values.get(at).map(|v| v.to_le_bytes()),
        AovValues::Uint(values) => values.get(at).map(|v| v.to_le_bytes()),
    }
}

/// All AOVs of a picture: a list of layers, and their values one after another, little-endian, pixel by pixel.
pub(crate) fn reply(job: &PictureJob) -> Reply {
    let layers = layers(job.renderer.develop_aovs(job.threads));
    let pixels = job.size().map(|side| side as usize).iter().product::<usize>();
    let (mut list, mut bytes) = (Vec::new(), Vec::new());
    for Layer { name, channels } in layers {
        let is_whole = channels.iter().all(|channel| matches!(channel.values, AovValues::Uint(_)));
        let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        list.push(
            json!({ "name": name, "channels": names, "type": if is_whole { "uint32" } else { "float32" } }),
        );
        for at in 0..pixels {
            bytes.extend(channels.iter().flat_map(|channel| bits(&channel.values, at).unwrap_or_default()));
        }
    }
    Reply { json: Json::Array(list), bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::PictureRequest;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;

    /// A wall that fills the picture, two units in front of the camera, and AOVs of one and three channels.
    const WALL: &str = "[film]\nwidth = 3\nheight = 2\naovs = [\"albedo\", \"depth\", \"object_id\"]\n\
        [camera]\nposition = [0, 0, 2]\nlook_at = [0, 0, 0]\n[integrator]\ntype = \"path\"\n\
        [background]\ncolor = 1\n[[object]]\ntype = \"plane\"\nnormal = [0, 0, 1]\n\
        material = { type = \"principled\", base_color = [0.5, 0.25, 0.75] }\n";

    #[test]
    fn channels_lie_side_by_side() {
        let files = vec![("wall.toml".to_owned(), WALL.as_bytes().to_vec())];
        let wanted = PictureRequest { main: "wall.toml".into(), threads: 1, ..PictureRequest::default() };
        let mut job = PictureJob::begin(files, &wanted).map_err(|e| e.message).unwrap();
        while !job.step(Duration::MAX, &AtomicBool::new(false)).unwrap() {}
        let Reply { json, bytes } = reply(&job);
        let names: Vec<_> = json.as_array().unwrap().iter().map(|layer| &layer["name"]).collect();
        assert_eq!(names, ["albedo", "depth", "object_id"]);
        assert_eq!(json[0]["channels"], json!(["albedo.R", "albedo.G", "albedo.B"]));
        assert_eq!(json[2]["type"], "uint32");
        let floats: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(floats.len(), 6 * 5);
        for pixel in floats[..18].chunks(3) {
            for (value, wanted) in pixel.iter().zip([0.5, 0.25, 0.75]) {
                assert!((value - wanted).abs() < 1e-5, "{pixel:?}");
            }
        }
        assert!(floats[18..24].iter().all(|depth| (depth - 2.0).abs() < 1e-5));
        assert!(bytes.chunks(4).skip(24).all(|b| b == 1u32.to_le_bytes()));
    }
}
