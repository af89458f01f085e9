//! Textures: colours that vary over a surface or through space. Each texture has its own file; the table below lists
//! their names in a scene.
//!
//! Every texture keeps this contract:
//!
//! - Its input is a [`TexturePoint`]: (u, v), position and geometric normal in object space, and for meshes the
//!   triangle.
//! - It is evaluated at texture coordinates (s, t, r). With `mapping = "uv"` they are (2u − 1, 2v − 1, 0), as in the
//!   classic documents, so that −1..1 spans the shape; with `mapping = "solid"` they are the position in object
//!   space. First the inverse of the texture's transform is applied, then `density` scales the coordinates.
//! - The result is a linear colour, or values where a material expects values. It may be negative or above 1: each
//!   material clamps it to its own range. It is finite for any input.
//! - A `footprint` is the area that a ray cone covers on the surface; a texture may return the mean over it. Without
//!   a footprint the result belongs to the point alone, and is the same bit for bit for any ray.
//! - Opacity is separate from colour: the alpha of an image or a vertex colour. Where a texture has no opacity of its
//!   own (`None`), opacity is the mean of the colour's bands.
//! - Inputs that are textures are evaluated at the same point. [`Textures::prepare`] rejects cycles, so evaluation
//!   ends.
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
pub(crate) mod reference_noise;
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
use self::prepare::{Kind, PrepareContext};
use crate::color::Spectrum;
use crate::math::{DAffine3, DVec2, DVec3};
use crate::schema::{ColorSource, ImageId, SceneError, TextureId, Transform, family};
use crate::shape::{Shape, ShapeHit, SolidGeometry, SurfacePoint, TriangleMesh};

/// The table of textures: `Variant(description => prepared form)`.
macro_rules! textures {
    ($($variant:ident($desc:ty => $prepared:ty),)*) => {
        family! {
            /// Textures: colours that vary. Named textures are tables `[texture.NAME]`; every colour key that accepts
            /// textures takes such a name or an inline table `{ type = …, … }`.
            pub enum TextureDesc as "texture", "textures" { $($variant($desc),)* }
        }

        /// A prepared texture.
        #[derive(Clone, Debug)]
        enum Texture {
            $($variant($prepared),)*
            /// Any other texture, projected along three axes.
            Triplanar(Box<triplanar::Triplanar>),
        }

        impl TextureDesc {
            fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
                match self { $(TextureDesc::$variant(d) => d.sources(visit),)* }
            }
            fn max_inputs(&self) -> u64 {
                match self { $(TextureDesc::$variant(_) => <$desc as Kind>::MAX_INPUTS,)* }
            }
            fn uses_uv(&self) -> bool {
                match self { $(TextureDesc::$variant(d) => d.mapping() == Mapping::Uv,)* }
            }
            fn triplanar(&self) -> Option<(f64, Transform)> {
                match self { $(TextureDesc::$variant(d) => d.triplanar(),)* }
            }
            fn prepare(&self, cx: &mut PrepareContext<'_>) -> Result<Texture, SceneError> {
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
            /// A step on the surface over which it changes little, for unit axes in the footprint of `at`.
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
    Multiply(MultiplyDesc => multiply::Multiply),
    Mix(MixDesc => mix::Mix),
}

impl TextureDesc {
    /// The image of an image texture.
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
            | TextureDesc::Multiply(_)
            | TextureDesc::Mix(_) => None,
        }
    }
}

/// The point at which textures are evaluated.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Texture coordinates of the surface.
    pub uv: DVec2,
    /// Position in object space.
    pub p: DVec3,
    /// From object space to world space; `None` if they are the same.
    pub to_world: Option<&'a DAffine3>,
    /// The mesh and the hit on it, for attributes that only meshes have.
    pub mesh: Option<(&'a TriangleMesh, ShapeHit)>,
    /// The colour of a point of a point cloud, linear RGB and opacity.
    pub point_color: Option<[f32; 4]>,
    /// Unit geometric normal in object space, for mappings that depend on it.
    pub n: DVec3,
    /// The area that the lookup represents; `None` for the point alone.
    pub footprint: Option<Footprint>,
    /// The projection side of a triplanar mapping.
    side: Side,
    /// Offset from the hit, in object space.
    moved: DVec3,
}

/// The default projection side.
const FRONT: Side = Side { axis: 2, sign: 1.0 };

impl<'a> TexturePoint<'a> {
    /// A surface point with the normal `n`, without a footprint.
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
            Shape::Solid(solid) => solid.mesh_at(hit),
            _ => None,
        };
        let point_color = match shape {
            Shape::Points(points) => points.color(hit),
            Shape::Curves(curves) => curves.color(hit),
            _ => None,
        };
        TexturePoint::on_surface(shape.uv(hit, point), point.p, point.ng, mesh, point_color)
    }
}

impl TexturePoint<'_> {
    /// A point of a shape other than a mesh.
    pub fn new(uv: DVec2, p: DVec3) -> TexturePoint<'static> {
        TexturePoint::on_surface(uv, p, DVec3::Z, None, None)
    }

    /// A nearby point, offset in object space and in the first set of (u, v).
    pub(crate) fn beside(&self, p: DVec3, uv: DVec2) -> Self {
        TexturePoint { p: self.p + p, uv: self.uv + uv, moved: self.moved + p, ..*self }
    }

    /// The same point without a footprint.
    pub fn sharp(&self) -> Self {
        TexturePoint { footprint: None, ..*self }
    }

    /// The same point with (u, v) of another set, if the shape has it.
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

    /// The vertex or point colour, linear RGB and opacity, if there is one.
    fn color(&self) -> Option<[f32; 4]> {
        self.point_color.or_else(|| self.mesh.and_then(|(mesh, hit)| mesh.color(&hit)))
    }
}

/// The prepared textures of a scene, shared by all threads.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    list: Vec<Texture>,
    /// Per texture: whether it or one of its inputs uses (u, v).
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

    /// The colour of a texture at a point; always finite.
    pub fn eval(&self, id: TextureId, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.list[id.index()].eval(self, at);
        if c.is_finite() { c } else { c.map(finite) }
    }

    /// The opacity of a source at a point: the alpha of an image or a vertex colour if there is one, else the mean of
    /// the colour's bands.
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

    /// The set of (u, v) that an image texture uses; 0 for other textures.
    pub fn uv_set(&self, id: TextureId) -> u32 {
        match &self.list[id.index()] {
            Texture::Image(image) => image.uv_set(),
            _ => 0,
        }
    }

    /// The length of a step on the surface over which a source changes little, for unit axes in the footprint of
    /// `at`; `None` if unknown.
    pub(crate) fn spacing(&self, source: ColorSource, at: &TexturePoint<'_>) -> Option<f64> {
        match source {
            ColorSource::Constant(_) => None,
            ColorSource::Texture(id) => self.list[id.index()].spacing(self, at),
        }
    }

    /// The projections of an image texture and how it is mapped in each, for the axes of the footprint of `at`; none
    /// for other textures.
    pub(crate) fn projections(&self, id: TextureId, at: &TexturePoint<'_>) -> [Option<Projection>; 3] {
        match &self.list[id.index()] {
            Texture::Triplanar(t) => t.projections(at),
            other => [other.projection(at), None, None],
        }
    }

    /// The colour of an image in one of its [`Textures::projections`].
    pub(crate) fn look(&self, id: TextureId, from: &Projection, at: &TexturePoint<'_>) -> Spectrum {
        let at = TexturePoint { side: from.side, ..*at };
        match &self.list[id.index()] {
            Texture::Triplanar(t) => t.inner.eval(self, &at),
            other => other.eval(self, &at),
        }
    }

    /// Whether a texture is an image mapped by the surface's own (u, v).
    pub(crate) fn lies_on_uv(&self, id: TextureId) -> bool {
        matches!(&self.list[id.index()], Texture::Image(image) if image.lies_on_uv())
    }

    /// Whether a source uses (u, v). If not, [`TexturePoint::uv`] may have any value.
    pub fn uses_uv(&self, source: ColorSource) -> bool {
        match source {
            ColorSource::Constant(_) => false,
            ColorSource::Texture(id) => self.uv[id.index()],
        }
    }

    /// Bytes of memory, including images (each counted once).
    pub fn memory(&self) -> usize {
        let own: usize = self.list.iter().map(Texture::memory).sum();
        own + self.list.capacity() * size_of::<Texture>()
            + self.uv.capacity()
            + self.decoders.iter().map(Decoder::memory).sum::<usize>()
            + self.image_memory
    }

    /// Bytes of the images in use, each counted once, including mipmap levels.
    pub fn picture_memory(&self) -> usize {
        self.image_memory
    }

    /// (1 − t)·a + t·b; a source with weight 0 is not evaluated.
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

/// One projection of an image texture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// The weight of this projection.
    pub(crate) weight: f64,
    side: Side,
    /// The axes of the footprint in the image, as fractions of its width and height, y upwards.
    pub(crate) axes: [DVec2; 2],
}

impl Texture {
    /// The projection of an image texture; `None` for other textures.
    fn projection(&self, at: &TexturePoint<'_>) -> Option<Projection> {
        let Texture::Image(image) = self else { return None };
        Some(Projection { weight: 1.0, side: at.side, axes: image.axes(at)? })
    }

    /// The texture's own opacity, if it has one.
    fn opacity(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f32> {
        match self {
            Texture::Image(image) => image.alpha(at),
            Texture::VertexColor(_) => at.color().map(|c| c[3]),
            Texture::Multiply(p) => Some(textures.opacity(p.a, at) * textures.opacity(p.b, at)),
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

/// For sums that overflow: the nearest finite value, 0 for NaN.
#[cold]
fn finite(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(f32::MIN, f32::MAX) }
}
