//! Textures: colours that vary over a surface or through space. One file each; the table below holds their names
//! in a scene.
//!
//! Every texture is evaluated at texture coordinates (s, t, r). With `mapping = "uv"` they are the paper's:
//! (2u − 1, 2v − 1, 0), so that (−1..1) spans the shape; with `mapping = "solid"` they are the object-space
//! position. The texture's own transform is undone and `density` scales them, before the pattern is looked up.
//!
//! A texture whose keys name other textures looks them up at the same point; [`Textures::prepare`] refuses
//! cycles, so evaluation ends. Results are finite whatever the point.

mod chessboard;
mod constant;
mod decoder;
mod gradient;
mod image;
mod marble;
mod noise;
mod perlin;
mod placement;
mod prepare;
mod product;
mod stripes;
mod tint;
mod vertex_color;
mod wood;

#[cfg(test)]
mod swatches;
#[cfg(test)]
mod tests;

pub use chessboard::ChessboardDesc;
pub use constant::ConstantDesc;
pub use gradient::{GradientDesc, GradientKind, Stop};
pub use image::{Encoding, ImageChannel, ImageDesc, ImageFilter, Wrap};
pub use marble::MarbleDesc;
pub use noise::{NoiseDesc, NoiseKind};
pub use perlin::{Fractal, Perlin};
pub use placement::{Axis, Mapping, Placement};
pub use product::ProductDesc;
pub use stripes::StripesDesc;
pub use tint::Tint;
pub use vertex_color::VertexColorDesc;
pub use wood::WoodDesc;

use self::decoder::Decoder;
use self::prepare::{Kind, Preparing};
use crate::color::Spectrum;
use crate::math::{DVec2, DVec3};
use crate::scene::schema::family;
use crate::scene::{ColorSource, SceneError, TextureId};
use crate::shape::{ShapeHit, TriangleMesh};

/// The table of textures: `Variant(description => what is evaluated)`.
macro_rules! textures {
    ($($variant:ident($desc:ty => $ready:ty),)*) => {
        family! {
            /// Textures: a colour that varies. Named ones stand in `[texture.NAME]`; any colour that may be a texture takes the name or a table `{ type = …, … }`.
            pub enum TextureDesc as "texture", "textures" { $($variant($desc),)* }
        }

        /// One texture ready to be evaluated.
        #[derive(Clone, Debug)]
        enum Texture { $($variant($ready),)* }

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
            fn prepare(&self, cx: &mut Preparing<'_>) -> Result<Texture, SceneError> {
                match self { $(TextureDesc::$variant(d) => d.prepare(cx).map(Texture::$variant),)* }
            }
        }

        impl Texture {
            #[inline]
            fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
                match self { $(Texture::$variant(t) => t.eval(textures, at),)* }
            }
            fn memory(&self) -> usize {
                match self { $(Texture::$variant(t) => t.memory(),)* }
            }
        }
    };
}

textures! {
    Constant(ConstantDesc => constant::Constant),
    Image(ImageDesc => image::ImageTexture),
    Chessboard(ChessboardDesc => chessboard::Chessboard),
    Stripes(StripesDesc => stripes::Stripes),
    Gradient(GradientDesc => gradient::Gradient),
    Wood(WoodDesc => wood::Wood),
    Marble(MarbleDesc => marble::Marble),
    Noise(NoiseDesc => noise::Noise),
    VertexColor(VertexColorDesc => vertex_color::VertexColor),
    Product(ProductDesc => product::Product),
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Surface coordinates.
    pub uv: DVec2,
    /// Position in the space of the object.
    pub p: DVec3,
    /// The mesh and the place on it, for what only meshes have.
    pub mesh: Option<(&'a TriangleMesh, ShapeHit)>,
    /// The colour of the point of a cloud, linear RGB and opacity.
    pub point_color: Option<[f32; 4]>,
}

impl TexturePoint<'_> {
    /// A point of a shape that is no mesh.
    pub fn new(uv: DVec2, p: DVec3) -> TexturePoint<'static> {
        TexturePoint { uv, p, mesh: None, point_color: None }
    }

    /// The same point with (u, v) of another set, if the shape has one.
    fn with_uv_set(&self, set: u32) -> Self {
        match self.mesh {
            Some((mesh, hit)) if set > 0 => TexturePoint { uv: mesh.uv_set(&hit, set as usize), ..*self },
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
            ColorSource::Texture(id) => match &self.list[id.index()] {
                Texture::Image(image) => image.alpha(at),
                Texture::VertexColor(_) => at.color().map(|c| c[3]),
                Texture::Product(product) => Some(self.opacity(product.a, at) * self.opacity(product.b, at)),
                _ => None,
            },
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

    /// (1 − t)·a + t·b; what has no share is not evaluated.
    #[inline]
    fn mix(&self, a: ColorSource, b: ColorSource, t: f64, at: &TexturePoint<'_>) -> Spectrum {
        if t <= 0.0 || t.is_nan() {
            self.color(a, at)
        } else if t >= 1.0 {
            self.color(b, at)
        } else {
            self.color(a, at).lerp(self.color(b, at), t as f32)
        }
    }
}

/// Sums of the largest numbers overflow: the nearest finite number, 0 for NaN.
#[cold]
fn finite(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(f32::MIN, f32::MAX) }
}
