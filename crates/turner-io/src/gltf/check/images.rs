//! URIs of buffers, and images whether used or not: URIs, media types and the first bytes.

use std::io::Read;

use super::add;
use super::walk::Faults;
use crate::assets::AssetSource;
use crate::gltf::base64;
use crate::gltf::buffers::{Buffers, strip_scheme};
use crate::gltf::json::{Document, ImageJson, Index};
use crate::image::{ImageFormat, read_metadata};

/// Larger image files are not read here.
const MOST_BYTES: u64 = 1 << 20;

pub(super) fn check(
    document: &Document,
    buffers: &Buffers,
    (uri, assets): (&str, &dyn AssetSource),
    faults: &mut Faults,
) {
    for (i, buffer) in document.buffers.iter().enumerate() {
        let Some(rest) = buffer.uri.as_deref().and_then(strip_scheme) else { continue };
        let Some((kind, _)) = rest.split_once(',') else { continue };
        let kind = kind.to_ascii_lowercase();
        let mut parts = kind.split(';');
        let mime = parts.next().unwrap_or_default();
        if !["application/octet-stream", "application/gltf-buffer"].contains(&mime) {
            let message = format!("is of type {mime}; expected application/octet-stream");
            add(faults, "/buffers", i, "/uri", message);
        }
        if parts.any(str::is_empty) {
            add(faults, "/buffers", i, "/uri", "has an empty parameter");
        }
    }
    let webp = document.extensions_used.iter().any(|name| name == "EXT_texture_webp");
    for (i, image) in document.images.iter().enumerate() {
        let found = match contents(image, buffers, uri, assets) {
            Ok(found) => found,
            Err(message) => {
                add(faults, "/images", i, "", message);
                continue;
            }
        };
        if found == Some(ImageFormat::WebP) && !webp {
            add(faults, "/images", i, "", "is WebP, but EXT_texture_webp is missing in extensionsUsed");
        }
    }
    for (i, texture) in document.textures.iter().enumerate() {
        let is_webp = |image: Index| {
            let image = document.images.get(image.index())?;
            let mime =
                image.mime_type.as_deref().or_else(|| strip_scheme(image.uri.as_deref()?)?.split(';').next());
            Some(mime? == "image/webp")
        };
        if texture.source.and_then(is_webp) == Some(true) {
            add(faults, "/textures", i, "/source", "is WebP; expected it in EXT_texture_webp");
        }
        let other = texture.extensions.as_deref().and_then(|e| e.webp.as_ref()).and_then(|w| w.source);
        if other.and_then(is_webp) == Some(false) {
            add(faults, "/textures", i, "/extensions/EXT_texture_webp/source", "is not WebP");
        }
    }
}

/// The format of an image if its bytes are in the document; otherwise its file is there.
fn contents(
    image: &ImageJson,
    buffers: &Buffers,
    from: &str,
    assets: &dyn AssetSource,
) -> Result<Option<ImageFormat>, String> {
    let sniff = |bytes: &[u8]| match ImageFormat::of_bytes(bytes, "") {
        Ok(format) if read_metadata(bytes, "").is_ok() => Ok(Some(format)),
        Ok(_) => Err("is damaged or truncated".to_owned()),
        // KTX2 and others: reported where they are used.
        Err(_) if bytes.len() > 12 && bytes.starts_with(b"\xabKTX 20") => Ok(None),
        Err(_) => Err("is not an image of a known format".to_owned()),
    };
    match (image.uri.as_deref(), image.buffer_view) {
        (Some(uri), _) => match strip_scheme(uri) {
            Some(rest) => {
                let (kind, data) = rest.split_once(',').ok_or("has a data: URI without a comma")?;
                let mime = kind.split(';').next().unwrap_or_default().to_ascii_lowercase();
                if !["image/png", "image/jpeg", "image/webp", "image/ktx2"].contains(&&mime[..]) {
                    return Err(format!("is of type {mime}; expected image/png or image/jpeg"));
                }
                let bytes = base64::decode(data).ok_or("has a data: URI that is not valid base64")?;
                sniff(&bytes)
            }
            None => {
                let path = assets.resolve(from, uri).map_err(|e| e.to_scene_error().message)?;
                let file = assets.open(&path, u64::MAX).map_err(|e| e.to_scene_error().message)?;
                let mut bytes = Vec::new();
                file.take(MOST_BYTES + 1)
                    .read_to_end(&mut bytes)
                    .map_err(|e| format!("cannot be read: {e}"))?;
                // Only small files are read twice.
                if bytes.len() as u64 > MOST_BYTES { Ok(None) } else { sniff(&bytes) }
            }
        },
        (None, Some(view)) if !buffers.is_absent(view) => match buffers.view(view, "") {
            Ok((bytes, _)) => sniff(bytes),
            Err(_) => Ok(None),
        },
        _ => Ok(None),
    }
}
