//! Pictures.
//!
//! The picture covers s, t in −1..1 once, upright: (−1, −1) is its lower left corner, (1, 1) its upper right one.
//! Texel (x, y) of a picture of w × h, row 0 at the top, is the square around its centre
//! s = 2(x + ½)/w − 1, t = 1 − 2(y + ½)/h.

use std::sync::Arc;

use super::placement::fract;
use super::prepare::{Kind, Preparing};
use super::{Mapping, Placement, TexturePoint, Textures};
use crate::color::{Spectrum, Transfer};
use crate::image::{Image, Pixels};
use crate::scene::schema::{Range, choice, params};
use crate::scene::transform::Transform;
use crate::scene::{ColorSource, ImageId, SceneError};

choice! {
    /// What stands between the centres of texels.
    pub enum ImageFilter {
        /// The four texels around the point, weighted by nearness.
        Bilinear = "bilinear",
        /// The texel that the point lies in: sharp squares.
        Nearest = "nearest",
    }
}

choice! {
    /// What stands outside the picture.
    pub enum Wrap {
        /// The picture again.
        Repeat = "repeat",
        /// Its mirror image: no seam, whatever the picture.
        Mirror = "mirror",
        /// Its border, drawn out.
        Clamp = "clamp",
        /// Nothing: black.
        Black = "black",
    }
}

params! {
    /// A picture file: PNG, JPEG, EXR or HDR. It covers a shape's surface coordinates once, upright: its lower left corner lies at
    /// u = v = 0, its upper right corner at u = v = 1. With `mapping = "solid"` it covers x and y from −1 to 1 and is the same at every z.
    /// Pictures of 8 and 16 bits are decoded by the film's transfer curve before they are interpolated, float pictures are taken as they are
    /// (samples that are infinite or NaN count as 0). An alpha channel has no effect.
    /// Around a sphere the picture closes without a seam; `wrap_v = "clamp"` keeps the poles from mixing.
    pub struct ImageDesc as "image" {
        /// The picture, relative to the scene file.
        file: ImageId;
        /// What stands between the centres of texels.
        filter: ImageFilter = ImageFilter::Bilinear;
        /// What stands outside the picture: the picture again, its mirror image, its border drawn out, or black.
        wrap: Wrap = Wrap::Repeat;
        /// The same for left and right alone; `wrap` unless given.
        wrap_u: Option<Wrap> = None;
        /// The same for top and bottom alone; `wrap` unless given.
        wrap_v: Option<Wrap> = None;
        /// The colours are multiplied by this.
        gain: f64 = 1.0, in Range::NON_NEGATIVE;
        /// How often the picture covers the surface coordinates, per axis; below 1, the part of it that is seen.
        density: f64 = 1.0;
        /// Whether the picture lies on the surface or goes through the solid along z.
        mapping: Mapping = Mapping::Uv;
        /// Moves the picture.
        transform: Transform = Transform::IDENTITY;
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

/// Tables from the samples of integer pictures to scene values, shared by all pictures of a scene.
#[derive(Clone, Debug)]
pub(super) struct Decoder {
    eight: Box<[f32]>,
    /// Empty until a picture needs it.
    sixteen: Box<[f32]>,
}

impl Default for Decoder {
    fn default() -> Decoder {
        Decoder::new(Transfer::default())
    }
}

impl Decoder {
    pub(super) fn new(transfer: Transfer) -> Decoder {
        let eight = (0..=u8::MAX).map(|v| transfer.decode(f32::from(v) / 255.0)).collect();
        Decoder { eight, sixteen: Box::default() }
    }

    /// Makes the table that a picture needs.
    pub(super) fn include(&mut self, image: &Image, transfer: Transfer) {
        if matches!(image.pixels, Pixels::U16(_)) && self.sixteen.is_empty() {
            self.sixteen = (0..=u16::MAX).map(|v| transfer.decode(f32::from(v) / 65535.0)).collect();
        }
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.eight) + size_of_val(&*self.sixteen)
    }

    /// Texel (x, y), which lies inside the picture.
    #[inline]
    fn texel(&self, image: &Image, x: u32, y: u32) -> Spectrum {
        let n = usize::from(image.channels);
        let i = (y as usize * image.width as usize + x as usize) * n;
        // Grey, with or without alpha, is repeated.
        let (g, b) = if n < 3 { (i, i) } else { (i + 1, i + 2) };
        let bands = match &image.pixels {
            Pixels::U8(v) => [v[i], v[g], v[b]].map(|v| self.eight[usize::from(v)]),
            Pixels::U16(v) => [v[i], v[g], v[b]].map(|v| self.sixteen[usize::from(v)]),
            Pixels::F32(v) => [v[i], v[g], v[b]].map(|v| if v.is_finite() { v } else { 0.0 }),
        };
        Spectrum::from(bands)
    }
}

/// A picture.
#[derive(Clone, Debug)]
pub(super) struct ImageTexture {
    image: Arc<Image>,
    filter: ImageFilter,
    wrap_u: Wrap,
    wrap_v: Wrap,
    gain: f32,
    placement: Placement,
}

impl Kind for ImageDesc {
    type Ready = ImageTexture;
    const AT_ONCE: u64 = 0;

    fn sources(&self, _: &mut dyn FnMut(ColorSource)) {}

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn prepare(&self, cx: &mut Preparing<'_>) -> Result<ImageTexture, SceneError> {
        Ok(ImageTexture {
            image: cx.image(self.file)?,
            filter: self.filter,
            wrap_u: self.wrap_u.unwrap_or(self.wrap),
            wrap_v: self.wrap_v.unwrap_or(self.wrap),
            gain: self.gain as f32,
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

impl ImageTexture {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint) -> Spectrum {
        let c = self.placement.coordinates(at);
        let (u, v) = (0.5 + 0.5 * c.x, 0.5 - 0.5 * c.y);
        let outside = |wrap, x: f64| wrap == Wrap::Black && !(0.0..=1.0).contains(&x);
        if outside(self.wrap_u, u) || outside(self.wrap_v, v) {
            return Spectrum::BLACK;
        }
        let (w, h) = (self.image.width, self.image.height);
        let (decoder, image) = (&textures.decoder, &*self.image);
        let color = match self.filter {
            ImageFilter::Nearest => {
                decoder.texel(image, self.wrap_u.nearest(u, w), self.wrap_v.nearest(v, h))
            }
            ImageFilter::Bilinear => {
                let (x0, x1, fx) = self.wrap_u.around(u, w);
                let (y0, y1, fy) = self.wrap_v.around(v, h);
                let row = |y| decoder.texel(image, x0, y).lerp(decoder.texel(image, x1, y), fx);
                row(y0).lerp(row(y1), fy)
            }
        };
        color * self.gain
    }

    /// The picture is counted by [`Textures::memory`], which knows what is shared.
    pub(super) fn memory(&self) -> usize {
        0
    }
}

impl Wrap {
    /// A coordinate brought into one picture, 0..=1. Black lies inside already.
    #[inline]
    fn fold(self, v: f64) -> f64 {
        match self {
            Wrap::Repeat => fract(v),
            Wrap::Mirror => {
                let v = 2.0 * fract(0.5 * v);
                if v > 1.0 { 2.0 - v } else { v }
            }
            Wrap::Clamp | Wrap::Black => v.clamp(0.0, 1.0),
        }
    }

    /// The texel that a coordinate lies in, of `n`.
    #[inline]
    fn nearest(self, v: f64, n: u32) -> u32 {
        ((self.fold(v) * f64::from(n)) as u32).min(n - 1)
    }

    /// The texels whose centres lie before and after a coordinate, and its way from the one to the other.
    #[inline]
    fn around(self, v: f64, n: u32) -> (u32, u32, f32) {
        let x = self.fold(v) * f64::from(n) - 0.5;
        let floor = x.floor();
        let weight = (x - floor) as f32;
        let texel = |i: f64| {
            if i < 0.0 {
                if self == Wrap::Repeat { n - 1 } else { 0 }
            } else if i >= f64::from(n) {
                if self == Wrap::Repeat { 0 } else { n - 1 }
            } else {
                i as u32
            }
        };
        (texel(floor), texel(floor + 1.0), weight)
    }
}
