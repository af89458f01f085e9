//! The images of a model: each is read and decoded once, several in parallel.
//!
//! Files often contain image paths of the machine that wrote them. An image that is not at its path is searched in
//! the folder of the referring file; if it is not there either, it is reported and omitted.

use std::collections::BTreeMap;
use std::sync::Arc;

use turner::image::Image;
use turner::schema::{Asset, ColorSource, ImageId, Named, TextureId, Warning, WarningKind};
use turner::texture::TextureDesc;

use super::error::shortened;
use crate::assets::{AssetSource, printable};
use crate::image::{ColorOrData, DecodeLimits, EncodedPicture, decode_all};
use crate::import::ImportOptions;

/// Largest encoded image, in bytes: 1 GiB.
const MAX_FILE: u64 = 1 << 30;
/// Most bytes of samples of all images together: 16 GiB.
const MAX_DECODED: u64 = 16 << 30;
/// Images that are read and decoded together; they divide the remaining memory among themselves.
const ROUND: usize = 8;

/// An image reference: the referring file, and the image's path as written there.
pub(super) type PictureName = (String, String);

/// Images and textures of a scene.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    pub(super) images: Vec<Asset<Image>>,
    pub(super) textures: Vec<Named<TextureDesc>>,
    ids: BTreeMap<PictureName, ImageId>,
}

impl Pictures {
    /// Reads and decodes images.
    pub(super) fn load(
        wanted: BTreeMap<PictureName, ColorOrData>,
        assets: &dyn AssetSource,
        options: &ImportOptions,
        warnings: &mut Vec<Warning>,
    ) -> Pictures {
        let mut pictures = Pictures::default();
        let mut by_path: BTreeMap<String, ImageId> = BTreeMap::new();
        let mut left = MAX_DECODED;
        let wanted: Vec<(PictureName, ColorOrData)> = wanted.into_iter().collect();
        for round in wanted.chunks(ROUND) {
            let mut read: Vec<(&PictureName, ColorOrData, String, Vec<u8>)> = Vec::new();
            let mut again: Vec<(&PictureName, String)> = Vec::new();
            for (name, used_as) in round {
                match find(name, assets, |path| {
                    by_path.contains_key(path) || read.iter().any(|r| r.2 == path)
                }) {
                    Found::Known(path) => again.push((name, path)),
                    Found::Bytes { path, bytes, moved } => {
                        if moved {
                            let message = "images missing at their path: read from the folder of the file that names them";
                            warnings.push(Warning::new(WarningKind::Approximated, message));
                        }
                        read.push((name, *used_as, path, bytes));
                    }
                    Found::Nothing(problem) => {
                        let message = format!("the image {}; omitted", shortened(&problem));
                        warnings.push(Warning::new(WarningKind::Ignored, message));
                    }
                }
            }
            let mut limits = DecodeLimits::of_scene(
                &options.limits,
                options.max_texture_size,
                ROUND.min(round.len()) as u64,
            );
            limits.max_bytes = limits.max_bytes.min(left / ROUND as u64);
            let encoded: Vec<EncodedPicture<'_>> =
                read.iter().map(|(_, used_as, path, bytes)| (&bytes[..], &path[..], *used_as)).collect();
            let decoded = decode_all(&encoded, &limits, options.threads, options.max_texture_size);
            for ((name, _, path, bytes), result) in read.into_iter().zip(decoded) {
                match result {
                    Ok(image) => {
                        left = left.saturating_sub(image.memory() as u64);
                        let id = ImageId(pictures.images.len() as u32);
                        pictures.ids.insert(name.clone(), id);
                        let data = Arc::new(image);
                        if let Some(kept) = options.keeps_pictures() {
                            kept.keep(&data, &path, bytes);
                        }
                        pictures.images.push(Asset { uri: printable(&name.1), data });
                        by_path.insert(path, id);
                    }
                    Err(error) => {
                        // The second line holds the remedy.
                        let message = error.to_string();
                        let message = message.lines().next().unwrap_or_default();
                        let message = format!("the image {}; omitted", shortened(message));
                        warnings.push(Warning::new(WarningKind::Ignored, message));
                    }
                }
            }
            for (name, path) in again {
                if let Some(&id) = by_path.get(&path) {
                    pictures.ids.insert(name.clone(), id);
                }
            }
        }
        pictures
    }

    /// An image, if it was decoded.
    pub(super) fn image(&self, name: &PictureName) -> Option<(ImageId, &Image)> {
        let id = *self.ids.get(name)?;
        Some((id, &self.images.get(id.index())?.data))
    }

    /// Adds a texture, or returns a recent equal one.
    pub(super) fn texture(&mut self, texture: TextureDesc) -> ColorSource {
        // Equal textures are usually in neighbouring materials.
        let recent = self.textures.iter().enumerate().rev().take(16);
        let known = recent.filter(|(_, t)| t.value == texture).map(|(i, _)| i).next();
        let index = known.unwrap_or_else(|| {
            self.textures.push(Named { name: None, span: None, value: texture });
            self.textures.len() - 1
        });
        ColorSource::Texture(TextureId(index as u32))
    }
}

enum Found {
    /// The path of an image that was already read.
    Known(String),
    Bytes {
        path: String,
        bytes: Vec<u8>,
        moved: bool,
    },
    /// The reason.
    Nothing(String),
}

/// Searches the path as written, then the folder of the referring file.
fn find((from, name): &PictureName, assets: &dyn AssetSource, known: impl Fn(&str) -> bool) -> Found {
    let mut problem = None;
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let beside = (last != name && !last.is_empty()).then_some((true, last));
    for (moved, name) in [(false, name.as_str())].into_iter().chain(beside) {
        let bytes = assets.resolve(from, name).and_then(|path| {
            if known(&path) {
                return Ok(Found::Known(path));
            }
            let bytes = assets.read(&path, MAX_FILE)?;
            Ok(Found::Bytes { path, bytes, moved })
        });
        match bytes {
            Ok(found) => return found,
            Err(error) => {
                let error = error.to_string();
                let line = error.lines().next().unwrap_or_default().to_owned();
                problem.get_or_insert(line);
            }
        }
    }
    Found::Nothing(problem.unwrap_or_else(|| printable(name)))
}
