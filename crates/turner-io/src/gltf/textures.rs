//! Textures: image, sampler and UV transform.

use std::collections::BTreeMap;

use turner::color::Spectrum;
use turner::math::elementary::sin_cos;
use turner::schema::{ColorSource, Named, TextureId};
use turner::texture::{
    Encoding, ImageChannel, ImageDesc, ImageFilter, MultiplyDesc, TextureDesc, VertexColorDesc, Wrap,
};

use super::images::Images;
use super::json::{Document, Index, Texture, TextureInfo};

/// OpenGL's constants.
const NEAREST: u32 = 9728;
const LINEAR: u32 = 9729;
const CLAMP_TO_EDGE: u32 = 33071;
const MIRRORED_REPEAT: u32 = 33648;

/// How a material uses an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Use {
    /// The channels.
    pub(super) channel: ImageChannel,
    /// The encoding of the samples.
    pub(super) encoding: Encoding,
    /// Multiplied with the sample.
    pub(super) factor: Spectrum,
    /// Added after the multiplication.
    pub(super) offset: f32,
}

impl Use {
    /// An sRGB colour.
    pub(super) fn color(factor: Spectrum) -> Use {
        Use { channel: ImageChannel::Rgb, encoding: Encoding::Srgb, factor, offset: 0.0 }
    }

    /// A scalar in one channel.
    pub(super) fn number(channel: ImageChannel, factor: f32) -> Use {
        Use { channel, encoding: Encoding::Linear, factor: Spectrum::grey(factor), offset: 0.0 }
    }

    /// Three linear values, such as a normal.
    pub(super) fn numbers() -> Use {
        Use { channel: ImageChannel::Rgb, ..Use::number(ImageChannel::Rgb, 1.0) }
    }
}

/// Most images of a texture.
pub(super) const MOST_CANDIDATES: usize = 3;

/// The images of a texture in order of preference: those of extensions before the fallback for programs without them.
pub(super) fn candidates(texture: &Texture) -> impl Iterator<Item = Index> {
    let extensions = texture.extensions.as_deref();
    let webp = extensions.and_then(|e| e.webp.as_ref()).and_then(|w| w.source);
    let basisu = extensions.and_then(|e| e.basisu.as_ref()).and_then(|b| b.source);
    webp.into_iter().chain(basisu).chain(texture.source)
}

/// The UV set of a texture reference.
pub(super) fn uv_set(info: &TextureInfo) -> u32 {
    let transform = info.extensions.as_deref().and_then(|e| e.transform.as_ref());
    transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord).0
}

/// `KHR_texture_transform` for coordinates whose v points up: the two rows of the matrix.
///
/// The extension scales, then rotates, then translates, with v down: u' = c·sx·u + s·sy·v + ox, v' = −s·sx·u + c·sy·v
/// + oy.
fn uv_matrix(info: &TextureInfo) -> Option<[f64; 6]> {
    let transform = info.extensions.as_deref()?.transform.as_ref()?;
    let [ox, oy] = transform.offset.unwrap_or([0.0; 2]);
    let [sx, sy] = transform.scale.unwrap_or([1.0; 2]);
    let (s, c) = sin_cos(transform.rotation.unwrap_or(0.0));
    let matrix = [c * sx, -s * sy, ox + s * sy, s * sx, c * sy, 1.0 - oy - c * sy];
    (matrix != [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]).then_some(matrix)
}

/// Collects the scene's textures.
#[derive(Debug, Default)]
pub(super) struct Textures {
    /// The scene's textures.
    pub(super) list: Vec<Named<TextureDesc>>,
    known: BTreeMap<String, TextureId>,
}

/// The filter of a sampler's `magFilter` and `minFilter`. If unspecified, minification uses mipmaps, as viewers do.
fn filter(mag: Option<Index>, min: Option<Index>) -> ImageFilter {
    let nearest = mag == Some(Index(NEAREST));
    // The other four constants use mipmaps.
    let at_points = matches!(min, Some(Index(NEAREST | LINEAR)));
    match (nearest, at_points) {
        (true, true) => ImageFilter::Nearest,
        (true, false) => ImageFilter::NearestMipmap,
        (false, true) => ImageFilter::Bilinear,
        (false, false) => ImageFilter::Mipmap,
    }
}

impl Textures {
    /// Adds a texture; equal descriptions share one.
    fn add(&mut self, desc: TextureDesc) -> ColorSource {
        let key = format!("{desc:?}");
        let id = *self.known.entry(key).or_insert_with(|| {
            self.list.push(Named { name: None, span: None, value: desc });
            TextureId(self.list.len() as u32 - 1)
        });
        ColorSource::Texture(id)
    }

    /// The image texture that `info` refers to; `None` if the image could not be read.
    pub(super) fn picture(
        &mut self,
        document: &Document,
        images: &Images,
        info: &TextureInfo,
        as_what: Use,
    ) -> Option<ColorSource> {
        let texture = document.textures.get(info.index.index())?;
        let file = candidates(texture).find_map(|image| images.id(image))?;
        let sampler = texture.sampler.and_then(|s| document.samplers.get(s.index()));
        let wrap = |mode: Option<Index>| match mode.map(|m| m.0) {
            Some(CLAMP_TO_EDGE) => Wrap::Clamp,
            Some(MIRRORED_REPEAT) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let filter = filter(sampler.and_then(|s| s.mag_filter), sampler.and_then(|s| s.min_filter));
        Some(self.add(TextureDesc::Image(ImageDesc {
            file,
            filter,
            wrap_u: Some(wrap(sampler.and_then(|s| s.wrap_s))),
            wrap_v: Some(wrap(sampler.and_then(|s| s.wrap_t))),
            uv_matrix: uv_matrix(info),
            channel: as_what.channel,
            encoding: as_what.encoding,
            tint: as_what.factor,
            offset: Spectrum::grey(as_what.offset),
            uv_set: uv_set(info),
            ..ImageDesc::default()
        })))
    }

    /// The texture of vertex colours.
    pub(super) fn vertex_color(&mut self) -> ColorSource {
        self.add(TextureDesc::VertexColor(VertexColorDesc { fallback: Spectrum::WHITE }))
    }

    /// The product of two colours; a factor of white is omitted.
    pub(super) fn product(&mut self, a: ColorSource, b: ColorSource) -> ColorSource {
        let white = ColorSource::Constant(Spectrum::WHITE);
        match (a, b) {
            (a, b) if a == white => b,
            (a, b) if b == white => a,
            (ColorSource::Constant(a), ColorSource::Constant(b)) => ColorSource::Constant(a * b),
            (a, b) => self.add(TextureDesc::Multiply(MultiplyDesc { a, b })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::json::{TextureInfoExtensions, TextureTransform};

    #[test]
    fn a_transform_in_upward_coordinates_is_the_extension_s_in_downward_ones() {
        let (offset, rotation, scale) = ([0.25, -0.5], 0.75, [2.0, 3.0]);
        let transform = TextureTransform {
            offset: Some(offset),
            rotation: Some(rotation),
            scale: Some(scale),
            tex_coord: Some(Index(2)),
        };
        let extensions = Some(Box::new(TextureInfoExtensions { transform: Some(transform) }));
        let info =
            TextureInfo { index: Index(0), tex_coord: Index(1), scale: None, strength: None, extensions };
        assert_eq!(uv_set(&info), 2);
        let [a, b, c, d, e, f] = uv_matrix(&info).unwrap();
        let (s, co) = sin_cos(rotation);
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.3, 0.9)] {
            // The extension's formula, v down.
            let (us, vs) = (u * scale[0], v * scale[1]);
            let (u1, v1) = (us * co + vs * s + offset[0], vs * co - us * s + offset[1]);
            let up = 1.0 - v;
            let (u2, up2) = (a * u + b * up + c, d * u + e * up + f);
            assert!((u1 - u2).abs() < 1e-12 && (1.0 - v1 - up2).abs() < 1e-12);
        }
        let plain = TextureInfo { extensions: Some(Box::default()), ..info };
        assert_eq!((uv_set(&plain), uv_matrix(&plain)), (1, None));
    }
}
