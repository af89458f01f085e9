//! Images from buffer views, `data:` URIs or files. Each image is decoded once, several in parallel.
//!
//! A missing or damaged image does not prevent the import: the report names it, and the properties that use it keep
//! only their factor.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use turner::image::Image;
use turner::schema::{Asset, ImageId};

use super::buffers::{Buffers, read_uri};
use super::fault::Outcome;
use super::json::{Document, ImageJson, Index};
use super::report::Report;
use crate::assets::{AssetSource, printable};
use crate::image::{ColorOrData, DecodeLimits, EncodedPicture, decode_all};
use crate::import::ImportOptions;

/// Largest encoded image, in bytes: 1 GiB.
const MAX_FILE: u64 = 1 << 30;
/// Most bytes of samples of all images together: 16 GiB.
const MAX_DECODED: u64 = 16 << 30;
/// Images that are read and decoded together; they divide the remaining memory among themselves.
const ROUND: usize = 8;

/// The decoded images.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// The scene's images.
    pub(super) assets: Vec<Asset<Image>>,
    ids: BTreeMap<Index, ImageId>,
    /// Bytes of samples of all images.
    memory: u64,
}

impl Images {
    /// Decodes the images of the document that `wanted` contains; the flag is true for colours.
    pub(super) fn decode(
        &mut self,
        document: &Document,
        buffers: &Buffers,
        wanted: &BTreeMap<Index, bool>,
        (uri, assets): (&str, &dyn AssetSource),
        options: &ImportOptions,
        report: &mut Report,
    ) {
        let wanted: Vec<(Index, bool)> = wanted.iter().map(|(i, c)| (*i, *c)).collect();
        for round in wanted.chunks(ROUND) {
            let mut read = Vec::new();
            for &(index, is_color) in round {
                let Some(json) = document.images.get(index.index()) else { continue };
                let name = name_of(json, index);
                match bytes_of(json, index, buffers, uri, assets) {
                    Ok(bytes) => read.push((index, is_color, name, bytes)),
                    Err(fault) => {
                        let error = fault.in_file(uri);
                        report.ignored(format!("the image \"{name}\": {}", error.message));
                    }
                }
            }
            let mut limits = DecodeLimits::of_scene(
                &options.limits,
                options.max_texture_size,
                ROUND.min(round.len()) as u64,
            );
            let left = MAX_DECODED.saturating_sub(self.memory);
            limits.max_bytes = limits.max_bytes.min(left / ROUND as u64);
            let encoded: Vec<EncodedPicture<'_>> = read
                .iter()
                .map(|(_, is_color, name, bytes)| {
                    let used_as = if *is_color { ColorOrData::Color } else { ColorOrData::Data };
                    (&bytes[..], &name[..], used_as)
                })
                .collect();
            let decoded = decode_all(&encoded, &limits, options.threads, options.max_texture_size);
            for ((index, _, name, bytes), result) in read.iter().zip(decoded) {
                match result {
                    Ok(image) => {
                        self.memory = self.memory.saturating_add(image.memory() as u64);
                        self.ids.insert(*index, ImageId(self.assets.len() as u32));
                        let data = Arc::new(image);
                        if let Some(kept) = options.keeps_pictures() {
                            kept.keep(&data, name, bytes.to_vec());
                        }
                        self.assets.push(Asset { uri: name.clone(), data });
                    }
                    Err(error) => {
                        // The second line holds the remedy.
                        let message = error.to_string();
                        let message = message.lines().next().unwrap_or_default();
                        report.ignored(format!("the image {message}"));
                    }
                }
            }
        }
    }

    /// The scene's ID of an image, if it was decoded.
    pub(super) fn id(&self, image: Index) -> Option<ImageId> {
        self.ids.get(&image).copied()
    }
}

/// The name of an image in messages: its file, its name or its index.
fn name_of(json: &ImageJson, index: Index) -> String {
    let file =
        json.uri.as_deref().filter(|uri| !uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:")));
    match file.or(json.name.as_deref()).filter(|name| !name.is_empty()) {
        Some(name) => printable(name),
        None => format!("image {}", index.0),
    }
}

fn bytes_of<'a>(
    json: &ImageJson,
    index: Index,
    buffers: &'a Buffers,
    uri: &str,
    assets: &dyn AssetSource,
) -> Outcome<Cow<'a, [u8]>> {
    let pointer = format!("/images/{}", index.0);
    match (&json.uri, json.buffer_view) {
        (Some(at), _) => Ok(Cow::Owned(read_uri(at, uri, assets, MAX_FILE, &pointer)?.0)),
        (None, Some(view)) => Ok(Cow::Borrowed(buffers.view(view, &pointer)?.0)),
        (None, None) => Err(super::fault::Fault::at(pointer, "has neither uri nor bufferView")),
    }
}

#[cfg(test)]
mod tests {
    use turner::description::SceneDesc;
    use turner::schema::WarningKind;

    use super::super::testing::{floats, glb};
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    /// A triangle whose base colour has a KTX2 image and a PNG for programs that do not read it.
    fn read(ktx2: &[u8], fallback: &str) -> SceneDesc {
        let json = format!(
            r#""extensionsUsed":["KHR_texture_basisu"],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
            "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
            "textures":[{{{fallback}"extensions":{{"KHR_texture_basisu":{{"source":0}}}}}}],
            "images":[{{"uri":"a.ktx2"}},{{"uri":"a.png"}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]"#
        );
        let mut assets = MemoryAssets::default();
        assets.files.insert("a.ktx2".to_owned(), ktx2.to_vec());
        let png = include_bytes!("../../tests/data/basn2c08.png");
        assets.files.insert("a.png".to_owned(), png.to_vec());
        let model = glb(&json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        super::super::import(model, "a.glb", &assets, &ImportOptions::default()).unwrap()
    }

    #[test]
    fn basis_universal_comes_before_the_image_for_other_programs() {
        let good = include_bytes!("../../tests/data/etc1s.ktx2");
        for fallback in ["", r#""source":1,"#] {
            let scene = read(good, fallback);
            let is_ignored = |w: &turner::schema::Warning| w.kind == WarningKind::Ignored;
            assert!(!scene.warnings.iter().any(is_ignored), "{:?}", scene.warnings);
            let image = &scene.images[0];
            assert_eq!((image.uri.as_str(), image.data.width, image.data.channels), ("a.ktx2", 24, 3));
            // The file says that its samples are sRGB-encoded, and they are used as colours.
            assert!(scene.images.len() == 1 && image.data.is_display_encoded());
        }
    }

    #[test]
    fn an_image_that_is_not_read_is_replaced_by_the_next() {
        let mut cube = *include_bytes!("../../tests/data/etc1s.ktx2");
        cube[36] = 6;
        for (fallback, images) in [("", 0), (r#""source":1,"#, 1)] {
            let scene = read(&cube, fallback);
            let told = |w: &turner::schema::Warning| {
                w.kind == WarningKind::Ignored
                    && w.message.contains("a.ktx2")
                    && w.message.contains("cube map")
            };
            assert!(scene.warnings.iter().any(told), "{:?}", scene.warnings);
            assert_eq!(scene.images.len(), images);
            assert!(scene.images.iter().all(|image| image.uri == "a.png" && image.data.width == 32));
        }
    }
}
