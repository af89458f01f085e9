//! Textures: image textures with their samplers and UV transforms.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::{Map, Value, json};
use turner::color::{Spectrum, Transfer};
use turner::description::SceneDesc;
use turner::image::{Image, Pixels};
use turner::math::elementary::atan2;
use turner::math::{DVec2, DVec3};
use turner::schema::{ColorSource, ErrorCode, SceneError};
use turner::texture::{
    Encoding, ImageChannel, ImageDesc, ImageFilter, Mapping, TextureDesc, TexturePoint, Textures, Wrap,
};

use super::remarks::Remarks;
use crate::convert::ConvertOptions;
use crate::image::{ImageFormat, png};

/// A texture reference in a material.
#[derive(Clone, Debug)]
pub(super) struct Used {
    /// The scene's texture.
    pub(super) desc: ImageDesc,
    /// `index`, `texCoord` and extensions, as JSON.
    pub(super) info: Value,
}

/// A colour source reduced to a factor, optionally times an image, optionally times the vertex colour.
#[derive(Clone, Debug)]
pub(super) struct Product {
    pub(super) factor: Spectrum,
    pub(super) picture: Option<ImageDesc>,
    pub(super) vertex_colors: bool,
}

/// The textures, images and samplers of the document.
pub(super) struct TextureWriter<'a> {
    desc: &'a SceneDesc,
    options: &'a ConvertOptions,
    /// The scene's prepared textures, for the mean of procedural ones.
    prepared: Option<Textures>,
    pub(super) textures: Vec<Value>,
    pub(super) samplers: Vec<Value>,
    /// Encoded images with their media types and names.
    pub(super) images: Vec<(Arc<[u8]>, &'static str, String)>,
    known_images: BTreeMap<u32, usize>,
    known: BTreeMap<(usize, usize), usize>,
    pub(super) uses_transform: bool,
}

impl<'a> TextureWriter<'a> {
    pub(super) fn new(desc: &'a SceneDesc, options: &'a ConvertOptions) -> Self {
        TextureWriter {
            desc,
            options,
            prepared: None,
            textures: Vec::new(),
            samplers: Vec::new(),
            images: Vec::new(),
            known_images: BTreeMap::new(),
            known: BTreeMap::new(),
            uses_transform: false,
        }
    }

    /// Reduces a colour source. Anything that glTF cannot represent is replaced by its mean colour.
    pub(super) fn product(&mut self, source: ColorSource, depth: u32, remarks: &mut Remarks) -> Product {
        let constant = |factor| Product { factor, picture: None, vertex_colors: false };
        let id = match source {
            ColorSource::Constant(c) => return constant(c),
            ColorSource::Texture(id) => id,
        };
        match self.desc.textures.get(id.index()).map(|t| &t.value) {
            Some(TextureDesc::Image(image)) if image.mapping == Mapping::Uv => {
                let factor = image.tint * image.gain as f32;
                if image.offset != Spectrum::BLACK {
                    remarks.approximated("texture offsets (offset): omitted");
                }
                Product { factor, picture: Some(image.clone()), vertex_colors: false }
            }
            Some(TextureDesc::VertexColor(_)) => {
                Product { factor: Spectrum::WHITE, picture: None, vertex_colors: true }
            }
            Some(TextureDesc::Multiply(p)) if depth < 16 => {
                let a = self.product(p.a, depth + 1, remarks);
                let b = self.product(p.b, depth + 1, remarks);
                if a.picture.is_some() && b.picture.is_some() {
                    remarks.approximated("products of two images: only the first is written");
                }
                Product {
                    factor: a.factor * b.factor,
                    picture: a.picture.or(b.picture),
                    vertex_colors: a.vertex_colors || b.vertex_colors,
                }
            }
            _ => {
                remarks.approximated("procedural and projected textures: written as their mean colour");
                constant(self.mean(source))
            }
        }
    }

    /// The mean of a colour source over the UV square and a cube around the origin.
    fn mean(&mut self, source: ColorSource) -> Spectrum {
        const SIDE: u32 = 16;
        let desc = self.desc;
        let prepared = self.prepared.get_or_insert_with(|| {
            // If textures cannot be prepared, the rest is still written.
            Textures::prepare(&desc.textures, &desc.images, desc.film.transfer, false).unwrap_or_default()
        });
        if let ColorSource::Texture(id) = source
            && (desc.textures.is_empty() || prepared.memory() == 0 || id.index() >= desc.textures.len())
        {
            return Spectrum::grey(0.5);
        }
        let mut sum = Spectrum::BLACK;
        let coordinate = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
        for i in 0..SIDE {
            for j in 0..SIDE {
                let uv = DVec2::new(coordinate(i), coordinate(j));
                let p = DVec3::new(
                    2.0 * uv.x - 1.0,
                    2.0 * uv.y - 1.0,
                    2.0 * coordinate((5 * i + 3 * j) % SIDE) - 1.0,
                );
                sum += prepared.color(source, &TexturePoint::new(uv, p));
            }
        }
        sum * (1.0 / (SIDE * SIDE) as f32)
    }

    /// A texture reference; `None` if the mesh has no UV set.
    pub(super) fn used(
        &mut self,
        picture: &ImageDesc,
        uv_sets: usize,
        is_color: bool,
        remarks: &mut Remarks,
    ) -> Result<Option<Used>, SceneError> {
        let set = picture.uv_set as usize;
        let set = if set < uv_sets { set } else { 0 };
        if uv_sets == 0 {
            remarks.approximated("textures on meshes without UV sets: only their factor is written");
            return Ok(None);
        }
        let wanted = if is_color { Transfer::Srgb } else { Transfer::None };
        let meant = match picture.encoding {
            Encoding::Auto => self.desc.film.transfer,
            Encoding::Srgb => Transfer::Srgb,
            Encoding::Linear => Transfer::None,
        };
        if meant != wanted {
            remarks.approximated("images with another encoding than glTF's (sRGB colours, linear data)");
        }
        let Some(image) = self.image(picture, remarks)? else { return Ok(None) };
        let index = self.texture(picture, image);
        let mut info = json!({ "index": index });
        if set > 0 {
            info["texCoord"] = json!(set);
        }
        if let Some(transform) = texture_transform(picture, remarks) {
            self.uses_transform = true;
            info["extensions"] = json!({ "KHR_texture_transform": transform });
        }
        Ok(Some(Used { desc: picture.clone(), info }))
    }

    fn texture(&mut self, picture: &ImageDesc, image: usize) -> usize {
        let wrap = |wrap: Option<Wrap>| match wrap.unwrap_or(picture.wrap) {
            Wrap::Mirror => 33648,
            Wrap::Repeat => 10497,
            _ => 33071,
        };
        let (mag, min) = match picture.filter {
            ImageFilter::Mipmap => (9729, 9987),
            ImageFilter::Bilinear => (9729, 9729),
            ImageFilter::Nearest => (9728, 9728),
            ImageFilter::NearestMipmap => (9728, 9986),
        };
        let sampler = json!({
            "magFilter": mag, "minFilter": min, "wrapS": wrap(picture.wrap_u), "wrapT": wrap(picture.wrap_v),
        });
        let sampler = self.samplers.iter().position(|s| *s == sampler).unwrap_or_else(|| {
            self.samplers.push(sampler);
            self.samplers.len() - 1
        });
        *self.known.entry((image, sampler)).or_insert_with(|| {
            self.textures.push(json!({ "source": image, "sampler": sampler }));
            self.textures.len() - 1
        })
    }

    /// The index of an image in the document.
    fn image(&mut self, picture: &ImageDesc, remarks: &mut Remarks) -> Result<Option<usize>, SceneError> {
        let Some(asset) = self.desc.images.get(picture.file.index()) else { return Ok(None) };
        if let Some(known) = self.known_images.get(&picture.file.0) {
            return Ok(Some(*known));
        }
        let kept = self.options.pictures.find(&asset.data).and_then(|(name, bytes)| {
            match ImageFormat::of_bytes(&bytes, &name).ok()? {
                ImageFormat::Png => Some((bytes, "image/png")),
                ImageFormat::Jpeg => Some((bytes, "image/jpeg")),
                _ => None,
            }
        });
        let failed = |e: crate::image::ImageError| crate::scene::two_lines(ErrorCode::Image, &e.to_string());
        let (bytes, kind) = match kept {
            Some(kept) => kept,
            None if asset.data.is_display_encoded() => {
                (png::encode_samples(&asset.data).map_err(failed)?.into(), "image/png")
            }
            None => {
                remarks.approximated("floating-point images: written with 8 bits, clamped to 1");
                (png::encode_samples(&display(&asset.data)).map_err(failed)?.into(), "image/png")
            }
        };
        self.images.push((bytes, kind, crate::convert::file_names::stem(&asset.uri).to_owned()));
        self.known_images.insert(picture.file.0, self.images.len() - 1);
        Ok(Some(self.images.len() - 1))
    }
}

/// Converts an image of floats to 8-bit display values.
fn display(image: &Image) -> Image {
    let n = usize::from(image.channels);
    let Pixels::F32(samples) = &image.pixels else { return image.clone() };
    let byte = |(i, v): (usize, &f32)| {
        let is_alpha = n % 2 == 0 && i % n == n - 1;
        let v = if is_alpha { *v } else { Transfer::Srgb.encode(v.clamp(0.0, 1.0)) };
        (v.clamp(0.0, 1.0) * 255.0).round() as u8
    };
    Image { pixels: Pixels::U8(samples.iter().enumerate().map(byte).collect()), ..image.clone() }
}

/// The `KHR_texture_transform` of a texture; `None` for the identity.
fn texture_transform(picture: &ImageDesc, remarks: &mut Remarks) -> Option<Value> {
    if !picture.transform.is_identity() {
        remarks.approximated("textures with a transform: written without it");
    }
    let d = picture.density;
    let [a, b, c, e, f, g] = picture.uv_matrix.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    // Density scales about the centre of the image.
    let center = (1.0 - d) / 2.0;
    let [a, b, c] = [d * a, d * b, d * c + center];
    let [e, f, g] = [d * e, d * f, d * g + center];
    if [a, b, c, e, f, g] == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        return None;
    }
    // The rows are [c·sx, −s·sy, ox + s·sy] and [s·sx, c·sy, 1 − oy − c·sy], with v up.
    let sx = (a * a + e * e).sqrt();
    let (cos, sin) = if sx > 0.0 { (a / sx, e / sx) } else { (1.0, 0.0) };
    let sy = cos * f - sin * b;
    if (b + sin * sy).abs() > 1e-6 * (1.0 + sy.abs()) || (f - cos * sy).abs() > 1e-6 * (1.0 + sy.abs()) {
        remarks.approximated("sheared textures: written without shear");
    }
    let mut out = Map::new();
    let offset = [c - sin * sy, 1.0 - g - cos * sy];
    if offset != [0.0; 2] {
        out.insert("offset".into(), json!(offset));
    }
    if sin != 0.0 || cos != 1.0 {
        out.insert("rotation".into(), json!(atan2(sin, cos)));
    }
    if [sx, sy] != [1.0; 2] {
        out.insert("scale".into(), json!([sx, sy]));
    }
    Some(Value::Object(out))
}

/// Whether a texture uses this channel.
pub(super) fn is_channel(picture: &ImageDesc, channel: ImageChannel) -> bool {
    picture.channel == channel
}
