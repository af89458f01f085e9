//! Textures: colours that vary over a surface or through space. One file each; the table below holds their names
//! in a scene.
//!
//! The contract, which every texture keeps:
//!
//! - It is given a [`TexturePoint`]: (u, v), position and geometric normal in the space of the object, and for meshes the triangle.
//! - It is evaluated at texture coordinates (s, t, r). With `mapping = "uv"` they are the paper's: (2u − 1, 2v − 1, 0), so that (−1..1) spans
//!   the shape; with `mapping = "solid"` they are the object-space position. The texture's own transform is undone and `density`
//!   scales them, before the pattern is looked up.
//! - What comes out is a linear colour, or numbers where a material wants numbers. It may be negative or above 1: each material cuts it to its own range.
//!   It is finite whatever the point.
//! - A `footprint` is what a ray's cone covers of the surface; a texture may return the mean over it. `None` is the point alone, and the same colour to the last
//!   bit wherever the ray came from.
//! - Opacity is apart from colour: the alpha of a picture or a vertex colour; the mean of the colour where a texture has no opacity of its own (`None`).
//! - A texture whose keys name other textures looks them up at the same point; [`Textures::prepare`] refuses cycles, so evaluation ends.
//! - It depends on the point alone: no state, no random numbers.

mod checkerboard;
mod constant;
mod decoder;
mod footprint;
mod gradient;
mod image;
mod mapping;
mod marble;
mod mipmap;
mod mix;
mod multiply;
mod noise;
mod perlin;
mod placement;
mod prepare;
mod reference_noise;
mod stripes;
mod tint;
mod triplanar;
mod vertex_color;
mod wood;
mod wrap;

#[cfg(test)]
mod footprint_tests;
#[cfg(test)]
mod swatches;
#[cfg(test)]
mod tests;

pub use checkerboard::CheckerboardDesc;
pub use constant::ConstantDesc;
pub use footprint::Footprint;
pub use gradient::{GradientDesc, GradientKind, Stop};
pub use image::{Encoding, ImageChannel, ImageDesc, ImageFilter};
pub use mapping::Mapping;
pub use marble::MarbleDesc;
pub use mix::MixDesc;
pub use multiply::MultiplyDesc;
pub use noise::{NoiseDesc, NoiseKind};
pub use perlin::{Fractal, Perlin};
pub use placement::{Axis, Placement};
pub use reference_noise::{PerlinDesc, PerlinKind};
pub use stripes::StripesDesc;
pub use tint::Tint;
pub use vertex_color::VertexColorDesc;
pub use wood::WoodDesc;
pub use wrap::Wrap;

use self::decoder::Decoder;
use self::mapping::Side;
pub use self::prepare::CachedMipmaps;
use self::prepare::{Kind, Preparing};
use crate::color::Spectrum;
use crate::math::{DAffine3, DVec2, DVec3};
use crate::schema::{ColorSource, ImageId, SceneError, TextureId, Transform, family};
use crate::shape::{Shape, ShapeHit, SurfacePoint, TriangleMesh};

/// The table of textures: `Variant(description => what is evaluated)`.
macro_rules! textures {
    ($($variant:ident($desc:ty => $ready:ty),)*) => {
        family! {
            /// Textures: a colour that varies. Named ones stand in `[texture.NAME]`; any colour that may be a texture takes the name or a table `{ type = …, … }`.
            pub enum TextureDesc as "texture", "textures" { $($variant($desc),)* }
        }

        /// One texture ready to be evaluated.
        #[derive(Clone, Debug)]
        enum Texture {
            $($variant($ready),)*
            /// Any of them, looked up along three axes.
            Triplanar(Box<triplanar::Triplanar>),
        }

        impl TextureDesc {
            fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
                match self { $(TextureDesc::$variant(d) => d.sources(visit),)* }
            }
            fn at_once(&self) -> u64 {
                match self { $(TextureDesc::$variant(_) => <$desc as Kind>::AT_ONCE,)* }
            }
            fn uses_uv(&self) -> bool {
                match self { $(TextureDesc::$variant(d) => d.mapping() == Mapping::Uv,)* }
            }
            fn triplanar(&self) -> Option<(f64, Transform)> {
                match self { $(TextureDesc::$variant(d) => d.triplanar(),)* }
            }
            fn prepare(&self, cx: &mut Preparing<'_>) -> Result<Texture, SceneError> {
                let texture = match self { $(TextureDesc::$variant(d) => d.prepare(cx).map(Texture::$variant)?,)* };
                Ok(match self.triplanar() {
                    Some((blend, transform)) => {
                        Texture::Triplanar(Box::new(triplanar::Triplanar::new(texture, blend, transform)))
                    }
                    None => texture,
                })
            }
        }

        impl Texture {
            #[inline]
            fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
                match self {
                    $(Texture::$variant(t) => t.eval(textures, at),)*
                    Texture::Triplanar(t) => t.eval(textures, at),
                }
            }
            /// A step on the surface over which it changes little, for axes of unit length in the footprint of `at`.
            fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
                match self {
                    $(Texture::$variant(t) => t.spacing(textures, at),)*
                    Texture::Triplanar(t) => t.spacing(textures, at),
                }
            }
            fn memory(&self) -> usize {
                match self {
                    $(Texture::$variant(t) => t.memory(),)*
                    Texture::Triplanar(t) => t.memory(),
                }
            }
        }
    };
}

textures! {
    Constant(ConstantDesc => constant::Constant),
    Image(ImageDesc => image::ImageTexture),
    Checkerboard(CheckerboardDesc => checkerboard::Checkerboard),
    Stripes(StripesDesc => stripes::Stripes),
    Gradient(GradientDesc => gradient::Gradient),
    Wood(WoodDesc => wood::Wood),
    Marble(MarbleDesc => marble::Marble),
    Noise(NoiseDesc => noise::Noise),
    Perlin(PerlinDesc => reference_noise::Perlin),
    VertexColor(VertexColorDesc => vertex_color::VertexColor),
    Product(MultiplyDesc => multiply::Product),
    Mix(MixDesc => mix::Mix),
}

impl TextureDesc {
    /// The picture that it shows.
    pub(crate) fn picture(&self) -> Option<ImageId> {
        match self {
            TextureDesc::Image(d) => Some(d.file),
            TextureDesc::Constant(_)
            | TextureDesc::Checkerboard(_)
            | TextureDesc::Stripes(_)
            | TextureDesc::Gradient(_)
            | TextureDesc::Wood(_)
            | TextureDesc::Marble(_)
            | TextureDesc::Noise(_)
            | TextureDesc::Perlin(_)
            | TextureDesc::VertexColor(_)
            | TextureDesc::Product(_)
            | TextureDesc::Mix(_) => None,
        }
    }
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Surface coordinates.
    pub uv: DVec2,
    /// Position in the space of the object.
    pub p: DVec3,
    /// From there to the world; `None` where they are one.
    pub to_world: Option<&'a DAffine3>,
    /// The mesh and the place on it, for what only meshes have.
    pub mesh: Option<(&'a TriangleMesh, ShapeHit)>,
    /// The colour of the point of a cloud, linear RGB and opacity.
    pub point_color: Option<[f32; 4]>,
    /// Geometric normal in the space of the object, unit, for mappings that ask which way the surface faces.
    pub n: DVec3,
    /// What the look-up stands for; `None` for the point alone.
    pub footprint: Option<Footprint>,
    /// The side that a triplanar mapping is looked at from.
    side: Side,
    /// How far it was moved from the hit, in the space of the object.
    moved: DVec3,
}

/// The side that stands where none is chosen.
const FRONT: Side = Side { axis: 2, sign: 1.0 };

impl<'a> TexturePoint<'a> {
    /// A point of a surface with the normal `n`, without a footprint.
    fn on_surface(
        uv: DVec2,
        p: DVec3,
        n: DVec3,
        mesh: Option<(&'a TriangleMesh, ShapeHit)>,
        point_color: Option<[f32; 4]>,
    ) -> TexturePoint<'a> {
        let (footprint, side, moved) = (None, FRONT, DVec3::ZERO);
        TexturePoint { uv, p, to_world: None, mesh, point_color, n, footprint, side, moved }
    }

    /// A point of a shape, without a footprint.
    pub fn of_shape(shape: &'a Shape, hit: &ShapeHit, point: &SurfacePoint) -> TexturePoint<'a> {
        let mesh = match shape {
            Shape::Mesh(mesh) => Some((&**mesh, *hit)),
            _ => None,
        };
        let point_color = match shape {
            Shape::Points(points) => points.color(hit),
            _ => None,
        };
        TexturePoint::on_surface(shape.uv(hit, point), point.p, point.ng, mesh, point_color)
    }
}

impl TexturePoint<'_> {
    /// A point of a shape that is no mesh.
    pub fn new(uv: DVec2, p: DVec3) -> TexturePoint<'static> {
        TexturePoint::on_surface(uv, p, DVec3::Z, None, None)
    }

    /// A point beside it: moved by so much in the space of the object and in the first set of (u, v).
    pub(crate) fn beside(&self, p: DVec3, uv: DVec2) -> Self {
        TexturePoint { p: self.p + p, uv: self.uv + uv, moved: self.moved + p, ..*self }
    }

    /// The same point without a footprint.
    pub fn sharp(&self) -> Self {
        TexturePoint { footprint: None, ..*self }
    }

    /// The same point with (u, v) of another set, if the shape has one.
    fn with_uv_set(&self, set: u32) -> Self {
        match self.mesh {
            Some((mesh, hit)) if set > 0 => {
                let footprint =
                    self.footprint.map(|f| Footprint { uv: mesh.uv_change(&hit, set as usize, f.p), ..f });
                let [moved, _] = mesh.uv_change(&hit, set as usize, [self.moved, DVec3::ZERO]);
                TexturePoint { uv: mesh.uv_set(&hit, set as usize) + moved, footprint, ..*self }
            }
            _ => *self,
        }
    }

    /// The vertex colour, linear RGB and opacity, where there is one.
    fn color(&self) -> Option<[f32; 4]> {
        self.point_color.or_else(|| self.mesh.and_then(|(mesh, hit)| mesh.color(&hit)))
    }
}

/// The scene's textures, ready to be evaluated; made once, shared by all threads.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    list: Vec<Texture>,
    /// Per texture: whether it or one that it names looks at (u, v).
    uv: Vec<bool>,
    /// By [`Encoding`].
    decoders: [Decoder; 3],
    image_memory: usize,
}

impl Textures {
    /// The colour of a source at a point.
    #[inline]
    pub fn color(&self, source: ColorSource, at: &TexturePoint<'_>) -> Spectrum {
        match source {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(id) => self.eval(id, at),
        }
    }

    /// The colour of a texture at a point: finite, whatever the point.
    pub fn eval(&self, id: TextureId, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.list[id.index()].eval(self, at);
        if c.is_finite() { c } else { c.map(finite) }
    }

    /// How opaque a source is at a point: its alpha if it is a picture with alpha or a vertex colour, the mean of
    /// its colour if not.
    pub fn opacity(&self, source: ColorSource, at: &TexturePoint<'_>) -> f32 {
        let alpha = match source {
            ColorSource::Texture(id) => self.list[id.index()].opacity(self, at),
            ColorSource::Constant(_) => None,
        };
        alpha.unwrap_or_else(|| {
            let c = self.color(source, at);
            (c.r + c.g + c.b) / 3.0
        })
    }

    /// Which set of (u, v) a picture is looked up at; 0 for other textures.
    pub fn uv_set(&self, id: TextureId) -> u32 {
        match &self.list[id.index()] {
            Texture::Image(image) => image.uv_set(),
            _ => 0,
        }
    }

    /// How long a step on the surface is over which a source changes little, for axes of unit length in the footprint of `at`; `None` where that is not known.
    pub(crate) fn spacing(&self, source: ColorSource, at: &TexturePoint<'_>) -> Option<f64> {
        match source {
            ColorSource::Constant(_) => None,
            ColorSource::Texture(id) => self.list[id.index()].spacing(self, at),
        }
    }

    /// From where a picture is looked at and how it lies there, for axes of the footprint of `at`; none of other textures.
    pub(crate) fn projections(&self, id: TextureId, at: &TexturePoint<'_>) -> [Option<Projection>; 3] {
        match &self.list[id.index()] {
            Texture::Triplanar(t) => t.projections(at),
            other => [other.projection(at), None, None],
        }
    }

    /// The colour of a picture from one of its [`Textures::projections`].
    pub(crate) fn look(&self, id: TextureId, from: &Projection, at: &TexturePoint<'_>) -> Spectrum {
        let at = TexturePoint { side: from.side, ..*at };
        match &self.list[id.index()] {
            Texture::Triplanar(t) => t.inner.eval(self, &at),
            other => other.eval(self, &at),
        }
    }

    /// Whether a texture is a picture that lies on the surface by its own (u, v).
    pub(crate) fn lies_on_uv(&self, id: TextureId) -> bool {
        matches!(&self.list[id.index()], Texture::Image(image) if image.lies_on_uv())
    }

    /// Whether a source looks at (u, v). Where it does not, [`TexturePoint::uv`] may be anything.
    pub fn uses_uv(&self, source: ColorSource) -> bool {
        match source {
            ColorSource::Constant(_) => false,
            ColorSource::Texture(id) => self.uv[id.index()],
        }
    }

    /// Bytes they take, with their pictures (each counted once).
    pub fn memory(&self) -> usize {
        let own: usize = self.list.iter().map(Texture::memory).sum();
        own + self.list.capacity() * size_of::<Texture>()
            + self.uv.capacity()
            + self.decoders.iter().map(Decoder::memory).sum::<usize>()
            + self.image_memory
    }

    /// Bytes of the pictures that are looked at, each counted once, with their smaller sizes.
    pub fn picture_memory(&self) -> usize {
        self.image_memory
    }

    /// (1 − t)·a + t·b; what has no share is not evaluated.
    #[inline]
    fn mix(&self, a: ColorSource, b: ColorSource, t: f64, at: &TexturePoint<'_>) -> Spectrum {
        if t <= 0.0 || t.is_nan() || a == b {
            self.color(a, at)
        } else if t >= 1.0 {
            self.color(b, at)
        } else {
            self.color(a, at).lerp(self.color(b, at), t as f32)
        }
    }
}

/// A look at a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// The share of this look.
    pub(crate) weight: f64,
    side: Side,
    /// How far one comes in the picture along each axis of the footprint, (1, 1) being its width and its height, upwards.
    pub(crate) axes: [DVec2; 2],
}

impl Texture {
    /// How a picture lies on the surface; `None` of others.
    fn projection(&self, at: &TexturePoint<'_>) -> Option<Projection> {
        let Texture::Image(image) = self else { return None };
        Some(Projection { weight: 1.0, side: at.side, axes: image.axes(at)? })
    }

    /// Its own opacity, if it has one.
    fn opacity(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f32> {
        match self {
            Texture::Image(image) => image.alpha(at),
            Texture::VertexColor(_) => at.color().map(|c| c[3]),
            Texture::Product(p) => Some(textures.opacity(p.a, at) * textures.opacity(p.b, at)),
            Texture::Triplanar(t) => t.opacity(textures, at),
            Texture::Mix(m) => Some(m.opacity(textures, at)),
            Texture::Constant(_)
            | Texture::Checkerboard(_)
            | Texture::Stripes(_)
            | Texture::Gradient(_)
            | Texture::Wood(_)
            | Texture::Marble(_)
            | Texture::Noise(_)
            | Texture::Perlin(_) => None,
        }
    }
}

/// Sums of the largest numbers overflow: the nearest finite number, 0 for NaN.
#[cold]
fn finite(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(f32::MIN, f32::MAX) }
}
