//! Image textures.
//!
//! The image covers s, t in −1..1 once, upright: (−1, −1) is its lower left corner, (1, 1) its upper right corner.
//! Texel (x, y) of an image of w × h texels, row 0 at the top, is the square around its centre s = 2(x + ½)/w − 1, t
//! = 1 − 2(y + ½)/h.

use std::sync::Arc;

use super::footprint::Ellipse;
use super::mipmap::{Mipmap, Taps};
use super::prepare::{Kind, PrepareContext};
use super::{Mapping, Placement, TexturePoint, Textures, Wrap};
use crate::color::{Spectrum, Transfer};
use crate::image::Image;
use crate::math::DVec2;
use crate::schema::{ColorSource, ImageId, Range, SceneError, Transform, choice, params};

choice! {
    /// How texels are interpolated and averaged.
    pub enum ImageFilter {
        /// Bilinear where texels are larger than pixels; otherwise the mean over the ray's footprint, from a mipmap.
        Mipmap = "mipmap",
        /// Interpolates the four nearest texels, at any distance.
        Bilinear = "bilinear",
        /// The nearest texel, at any distance: sharp squares.
        Nearest = "nearest",
        /// The nearest texel where texels are larger than pixels; otherwise as "mipmap".
        NearestMipmap = "nearest-mipmap",
    }
}

choice! {
    /// The channel of an image that is used.
    pub enum ImageChannel {
        /// The colour.
        Rgb = "rgb",
        /// Red, as grey.
        R = "r",
        /// Green, as grey.
        G = "g",
        /// Blue, as grey.
        B = "b",
        /// Alpha, as grey; 1 for images without alpha.
        A = "a",
    }
}

choice! {
    /// The meaning of the values of an 8- or 16-bit image.
    pub enum Encoding {
        /// Decoded by the film's transfer curve.
        Auto = "auto",
        /// sRGB-encoded: for colours.
        Srgb = "srgb",
        /// Linear values: for roughness, normals and masks.
        Linear = "linear",
    }
}

impl Encoding {
    /// The curve that decodes samples; `film` is the film's.
    pub(super) fn transfer(self, film: Transfer) -> Transfer {
        match self {
            Encoding::Auto => film,
            Encoding::Srgb => Transfer::Srgb,
            Encoding::Linear => Transfer::None,
        }
    }
}

params! {
    /// An image file: PNG, JPEG, WebP, TGA, BMP, KTX2, EXR, HDR or PFM. It covers (u, v) in 0..1 once, upright: the
    /// lower left corner is at u = v = 0, the upper right corner at u = v = 1. With `mapping = "solid"` it covers x
    /// and y from −1 to 1 and is the same for every z. Images of 8 and 16 bits are decoded by `encoding` before
    /// interpolation; float images are used unchanged, with infinite and NaN samples as 0. An alpha channel affects
    /// only the `opacity` of a material. Around a sphere the image closes without a seam; `wrap_v = "clamp"` keeps
    /// the poles from blending.
    pub struct ImageDesc as "image" {
        /// Path of the image, relative to the scene file.
        file: ImageId, required, default ImageId(0);
        /// Interpolation and filtering of texels. Where the film does not filter textures (`texture_filter` in
        /// `[film]`), "mipmap" acts as "bilinear" and "nearest-mipmap" as "nearest".
        filter: ImageFilter = ImageFilter::Mipmap;
        /// How the texture continues outside the image: repeated, mirrored, with its border extended, or black.
        wrap: Wrap = Wrap::Repeat;
        /// The same for the left and right side only; `wrap` unless given.
        wrap_u: Option<Wrap> = None;
        /// The same for top and bottom only; `wrap` unless given.
        wrap_v: Option<Wrap> = None;
        /// Factor for the colours.
        gain: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Number of repetitions of the image per axis; below 1 only its central part is visible.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the image.
        transform: Transform = Transform::IDENTITY;
        /// Affine transform of (u, v) before the lookup, as rows [a, b, c, d, e, f]: u becomes a·u + b·v + c, v
        /// becomes d·u + e·v + f.
        uv_matrix: Option<[f64; 6]> = None;
        /// The channel to use.
        channel: ImageChannel = ImageChannel::Rgb;
        /// How the values of an 8- or 16-bit image are decoded.
        encoding: Encoding = Encoding::Auto;
        /// Further factor for the colours, per band.
        tint: Spectrum = Spectrum::WHITE;
        /// Added to the colours after the factors.
        offset: Spectrum = Spectrum::BLACK;
        /// Index of the mesh's set of texture coordinates, from 0; set 0 if the mesh has no such set.
        uv_set: u32 = 0;
    }
    example r##"[texture.earth]
type = "image"
file = "picture.png"
wrap_v = "clamp"

[[object]]
type = "sphere"
material = { color = "earth" }
"##
}

/// An image texture.
#[derive(Clone, Debug)]
pub(super) struct ImageTexture {
    image: Arc<Image>,
    filter: ImageFilter,
    /// The smaller levels, if they are used.
    mipmap: Option<Arc<Mipmap>>,
    wrap_u: Wrap,
    wrap_v: Wrap,
    /// Gain and tint.
    factor: Spectrum,
    offset: Spectrum,
    placement: Placement,
    uv_set: u32,
    uv_matrix: Option<[f64; 6]>,
    channel: ImageChannel,
    encoding: Encoding,
}

impl Kind for ImageDesc {
    type Prepared = ImageTexture;
    const MAX_INPUTS: u64 = 0;

    fn sources(&self, _: &mut dyn FnMut(ColorSource)) {}

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, cx: &mut PrepareContext<'_>) -> Result<ImageTexture, SceneError> {
        let image = cx.image(self.file, self.encoding)?;
        let mipmap = if self.is_mipmapped() { cx.mipmap(self.file, &image, self.encoding) } else { None };
        Ok(ImageTexture {
            image,
            filter: self.filter,
            mipmap,
            wrap_u: self.wrap_u.unwrap_or(self.wrap),
            wrap_v: self.wrap_v.unwrap_or(self.wrap),
            factor: self.tint * self.gain as f32,
            offset: self.offset,
            placement: Placement::new(self.mapping, self.density, self.transform),
            uv_set: self.uv_set,
            uv_matrix: self.uv_matrix,
            channel: self.channel,
            encoding: self.encoding,
        })
    }
}

impl ImageDesc {
    /// Whether lookups with a footprint use a mipmap.
    pub(super) fn is_mipmapped(&self) -> bool {
        match self.filter {
            ImageFilter::Mipmap | ImageFilter::NearestMipmap => true,
            ImageFilter::Bilinear | ImageFilter::Nearest => false,
        }
    }
}

impl ImageTexture {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        if self.channel == ImageChannel::A {
            return Spectrum::grey(self.alpha_channel(at)) * self.factor + self.offset;
        }
        let decoder = &textures.decoders[self.encoding as usize];
        let texels = |image: &Image, at| decoder.texels(image, at);
        let color = self.lookup(at, texels, Spectrum::lerp, Spectrum::BLACK);
        let color = match self.channel {
            ImageChannel::Rgb | ImageChannel::A => color,
            ImageChannel::R => Spectrum::grey(color.r),
            ImageChannel::G => Spectrum::grey(color.g),
            ImageChannel::B => Spectrum::grey(color.b),
        };
        color * self.factor + self.offset
    }

    /// The set of (u, v) that it uses.
    pub(super) fn uv_set(&self) -> u32 {
        self.uv_set
    }

    /// The alpha of an image that has an alpha channel and whose colour is used; 0 outside with `wrap = "black"`.
    pub(super) fn alpha(&self, at: &TexturePoint<'_>) -> Option<f32> {
        let has_alpha = matches!(self.image.channels, 2 | 4) && self.channel == ImageChannel::Rgb;
        has_alpha.then(|| self.alpha_channel(at))
    }

    fn alpha_channel(&self, at: &TexturePoint<'_>) -> f32 {
        let texels = |image: &Image, at: [[u32; 2]; 4]| at.map(|[x, y]| image.alpha(x, y));
        self.lookup(at, texels, |a: f32, b, t| a + (b - a) * t, 0.0)
    }

    /// Position in the image, (0, 0) the upper left and (1, 1) the lower right corner, and the axes of the footprint
    /// there.
    #[inline(always)]
    fn image_position(&self, at: &TexturePoint<'_>, with_axes: bool) -> (DVec2, Option<[DVec2; 2]>) {
        let mut at = at.with_uv_set(self.uv_set);
        if let Some([a, b, c, d, e, f]) = self.uv_matrix {
            let linear = |v: DVec2| DVec2::new(a * v.x + b * v.y, d * v.x + e * v.y);
            at.uv = linear(at.uv) + DVec2::new(c, f);
            if let Some(footprint) = &mut at.footprint {
                footprint.uv = footprint.uv.map(linear);
            }
        }
        let c = self.placement.coordinates(&at);
        let axes = if with_axes { self.placement.axes(&at) } else { None };
        let axes = axes.map(|axes| axes.map(|d| DVec2::new(0.5 * d.x, -0.5 * d.y)));
        (DVec2::new(0.5 + 0.5 * c.x, 0.5 - 0.5 * c.y), axes)
    }

    /// The axes of the footprint in the image, as fractions of its width and height, y upwards.
    pub(super) fn axes(&self, at: &TexturePoint<'_>) -> Option<[DVec2; 2]> {
        let (_, axes) = self.image_position(at, true);
        axes.map(|axes| axes.map(|d| DVec2::new(d.x, -d.y)))
    }

    /// Whether it is mapped by the unchanged (u, v).
    pub(super) fn lies_on_uv(&self) -> bool {
        self.placement.is_plain_uv() && self.uv_matrix.is_none()
    }

    /// The length of a step on the surface from texel to texel, for unit axes in the footprint of `at`; `None` if
    /// unknown.
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let (_, axes) = self.image_position(at, true);
        let size = DVec2::new(f64::from(self.image.width), f64::from(self.image.height));
        let texels = Ellipse::new(axes?.map(|d| d * size)).length;
        (texels > 0.0).then(|| 1.0 / texels)
    }

    /// The value at a point, or the mean over its footprint; `texels` returns those at four positions, and `outside` is
    /// the value where the image does not continue.
    #[inline(always)]
    fn lookup<T: Copy>(
        &self,
        at: &TexturePoint<'_>,
        texels: impl Fn(&Image, [[u32; 2]; 4]) -> [T; 4],
        lerp: impl Fn(T, T, f32) -> T,
        outside: T,
    ) -> T {
        let (uv, axes) = self.image_position(at, self.mipmap.is_some());
        let is_nearest = matches!(self.filter, ImageFilter::Nearest | ImageFilter::NearestMipmap);
        if let (Some(mipmap), Some(axes)) = (&self.mipmap, axes) {
            let size = DVec2::new(f64::from(self.image.width), f64::from(self.image.height));
            let ellipse = Ellipse::new(axes.map(|d| d * size));
            if ellipse.length > 1.0 {
                let level = |level: usize, uv: DVec2| {
                    self.bilinear(mipmap.level(&self.image, level), uv, &texels, &lerp, outside)
                };
                if at.footprint.is_some_and(|footprint| footprint.isotropic) {
                    return level(Taps::isotropic(&ellipse, mipmap.count()).level, uv);
                }
                let taps = Taps::new(&ellipse, mipmap.count());
                let (mut mean, mut count) = (outside, 0.0);
                for offset in taps.offsets() {
                    let uv = uv + offset / size;
                    let mut v = level(taps.level, uv);
                    if taps.coarser > 0.0 {
                        v = lerp(v, level(taps.level + 1, uv), taps.coarser);
                    }
                    count += 1.0;
                    mean = if count == 1.0 { v } else { lerp(mean, v, 1.0 / count) };
                }
                return mean;
            }
        }
        if !is_nearest {
            return self.bilinear(&self.image, uv, &texels, &lerp, outside);
        }
        if self.wrap_u.is_outside(uv.x) || self.wrap_v.is_outside(uv.y) {
            return outside;
        }
        let (x, y) =
            (self.wrap_u.nearest(uv.x, self.image.width), self.wrap_v.nearest(uv.y, self.image.height));
        texels(&self.image, [[x, y]; 4])[0]
    }

    /// Bilinear interpolation of the four nearest texels of a level.
    #[inline(always)]
    fn bilinear<T>(
        &self,
        image: &Image,
        uv: DVec2,
        texels: &impl Fn(&Image, [[u32; 2]; 4]) -> [T; 4],
        lerp: &impl Fn(T, T, f32) -> T,
        outside: T,
    ) -> T {
        if self.wrap_u.is_outside(uv.x) || self.wrap_v.is_outside(uv.y) {
            return outside;
        }
        let (x0, x1, fx) = self.wrap_u.neighbours(uv.x, image.width);
        let (y0, y1, fy) = self.wrap_v.neighbours(uv.y, image.height);
        let [a, b, c, d] = texels(image, [[x0, y0], [x1, y0], [x0, y1], [x1, y1]]);
        lerp(lerp(a, b, fx), lerp(c, d, fx), fy)
    }

    /// Images are counted by [`Textures::memory`], because textures share them.
    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{picture, prepare_texture, text};
    use super::*;
    use crate::color::Transfer;
    use crate::image::Pixels;
    use crate::math::{DVec2, DVec3};
    use crate::schema::{Asset, Named, TextureId};
    use crate::texture::{TextureDesc, Wrap};

    /// A texture of [`picture`] with some keys.
    fn with(keys: &[(&str, &str)]) -> Textures {
        let keys: Vec<_> = keys.iter().map(|(k, v)| (*k, text(v))).collect();
        prepare_texture("image", &[vec![("file", text("p.png"))], keys].concat())
    }

    fn at(textures: &Textures, s: f64, t: f64) -> Spectrum {
        let uv = DVec2::new(0.5 + 0.5 * s, 0.5 + 0.5 * t);
        textures.eval(TextureId(0), &TexturePoint::new(uv, DVec3::ZERO))
    }

    /// Texel (x, y) of [`picture`].
    fn texel(x: u32, y: u32) -> Spectrum {
        Spectrum::from(picture().rgb(x, y))
    }

    /// The centre of texel (x, y) of [`picture`], also outside the image.
    fn centre(x: i32, y: i32) -> (f64, f64) {
        (2.0 * (f64::from(x) + 0.5) / 4.0 - 1.0, 1.0 - 2.0 * (f64::from(y) + 0.5) / 2.0)
    }

    #[test]
    fn both_filters_are_exact_at_centres_under_every_wrap() {
        for filter in ImageFilter::WORDS {
            for wrap in Wrap::WORDS {
                let textures = with(&[("filter", filter), ("wrap", wrap)]);
                for (x, y) in (-9..13).flat_map(|x| (-5..7).map(move |y| (x, y))) {
                    let fold = |i: i32, n: i32| match *wrap {
                        "repeat" => Some(i.rem_euclid(n)),
                        "mirror" => Some((i.rem_euclid(2 * n)).min(2 * n - 1 - i.rem_euclid(2 * n))),
                        "clamp" => Some(i.clamp(0, n - 1)),
                        _ => (0..n).contains(&i).then_some(i),
                    };
                    let expected = match (fold(x, 4), fold(y, 2)) {
                        (Some(x), Some(y)) => texel(x as u32, y as u32),
                        _ => Spectrum::BLACK,
                    };
                    let (s, t) = centre(x, y);
                    assert_eq!(at(&textures, s, t), expected, "{filter} {wrap} texel {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn the_corners_of_the_picture_are_the_corners_of_the_surface() {
        let near = with(&[("filter", "nearest"), ("wrap", "clamp")]);
        assert_eq!(at(&near, -1.0, -1.0), texel(0, 1));
        assert_eq!(at(&near, 1.0, -1.0), texel(3, 1));
        assert_eq!(at(&near, -1.0, 1.0), texel(0, 0));
        assert_eq!(at(&near, 1.0, 1.0), texel(3, 0));
        // A border between texels belongs to the right or lower one.
        assert_eq!(at(&near, -0.5, 0.0), texel(1, 1));
        let soft = with(&[("wrap", "black")]);
        assert_eq!(at(&soft, -1.0, 1.0), texel(0, 0));
        assert_eq!(at(&soft, -1.000_001, 1.0), Spectrum::BLACK);
    }

    #[test]
    fn bilinear_is_the_mean_half_way_and_at_the_seam() {
        let mean = |a: Spectrum, b: Spectrum| a.lerp(b, 0.5);
        let soft = with(&[]);
        assert_eq!(at(&soft, -0.5, 0.5), mean(texel(0, 0), texel(1, 0)));
        assert_eq!(at(&soft, 0.25, 0.0), mean(texel(2, 0), texel(2, 1)));
        // Around a sphere the left and right edges are one line.
        let seam = mean(texel(3, 0), texel(0, 0));
        assert_eq!(at(&soft, -1.0, 0.5), seam);
        assert_eq!(at(&soft, 1.0, 0.5), seam);
        let before = at(&soft, 1.0 - 1e-9, 0.5);
        assert!((before.r - seam.r).abs() < 1e-6);
        // Each axis can have its own wrap mode.
        let own = with(&[("wrap_v", "clamp")]);
        assert_eq!(at(&own, -0.75, 1.0), texel(0, 0));
        assert_eq!(at(&own, -0.75, 5.0), texel(0, 0));
        assert_eq!(at(&own, -1.0, 0.5), seam);
    }

    /// An image of two texels, side by side.
    fn two(pixels: Pixels, channels: u8, gain: f64, transfer: Transfer) -> Textures {
        let image = Image { width: 2, height: 1, channels, pixels };
        let scene = super::super::tests::read("image", &[("file", text("p.png"))]).unwrap();
        let TextureDesc::Image(desc) = &scene.textures[0].value else { panic!("expected an image") };
        let value = TextureDesc::Image(ImageDesc { gain, ..desc.clone() });
        let descs = [Named { name: None, span: None, value }];
        Textures::prepare(&descs, &[Asset { uri: "p".into(), data: Arc::new(image) }], transfer, false)
            .unwrap()
    }

    #[test]
    fn integers_are_decoded_before_they_are_mixed() {
        let eight = two(Pixels::U8(vec![0, 255]), 1, 1.0, Transfer::Srgb);
        assert_eq!(at(&eight, 0.0, 0.0), Spectrum::grey(0.5));
        let decoded = Transfer::Srgb.decode(0.2);
        let sixteen = two(Pixels::U16(vec![13_107, 9, 0, 0]), 2, 2.0, Transfer::Srgb);
        assert_eq!(at(&sixteen, -0.5, 0.0), Spectrum::grey(2.0 * decoded));
        let float = two(Pixels::F32(vec![0.2, 7.0, -1.0, 1.0, 0.0, 0.5, 0.25, 1.0]), 4, 1.0, Transfer::Srgb);
        assert_eq!(at(&float, -0.5, 0.0), Spectrum::new(0.2, 7.0, -1.0));
    }

    #[test]
    fn bad_samples_count_as_zero_and_bad_pictures_are_refused() {
        let pixels = Pixels::F32(vec![f32::NAN, 1.0, f32::INFINITY, f32::MAX, f32::MAX, f32::MAX]);
        let image = Image { width: 2, height: 1, channels: 3, pixels: pixels.clone() };
        assert_eq!(image.non_finite(), 2);
        let textures = two(pixels, 3, 4.0, Transfer::None);
        assert_eq!(at(&textures, -0.5, 0.0), Spectrum::new(0.0, 4.0, 0.0));
        assert_eq!(at(&textures, 0.5, 0.0), Spectrum::grey(f32::MAX));
        let short = Image { width: 2, ..picture() };
        assert!(!short.is_consistent() && picture().is_consistent());
    }

    #[test]
    fn density_repeats_the_picture() {
        let keys = [("file", text("p.png")), ("density", crate::schema::value::Data::Integer(3))];
        let (once, thrice) = (with(&[]), prepare_texture("image", &keys));
        for (s, t) in [(0.1, 0.2), (-0.3, 0.33), (0.9, -0.7)] {
            assert_eq!(at(&thrice, s, t), at(&once, 3.0 * s, 3.0 * t));
        }
    }
}
