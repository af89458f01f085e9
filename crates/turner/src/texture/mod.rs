//! Textures: colours that vary over a surface or through space. One file each; [`TextureDesc`] is the table of
//! their names in a scene.
//!
//! Every texture is evaluated at texture coordinates (s, t, r). With `mapping = "uv"` they are the paper's:
//! (2u − 1, 2v − 1, 0), so that (−1..1) spans the shape; with `mapping = "solid"` they are the object-space
//! position. `density` scales them and the texture's own transform is undone, before the pattern is looked up.

mod chessboard;
mod placement;

pub use chessboard::ChessboardDesc;
pub use placement::{Mapping, Placement};

use crate::color::Spectrum;
use crate::math::{DVec2, DVec3};
use crate::scene::schema::family;
use crate::scene::{ColorSource, TextureId};

family! {
    /// Textures: a colour that varies. Named ones stand in `[texture.NAME]`; any colour that may be a texture takes the name or a table `{ type = …, … }`.
    pub enum TextureDesc as "texture", "textures" {
        Chessboard(ChessboardDesc),
    }
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePoint {
    /// Surface coordinates.
    pub uv: DVec2,
    /// Position in the space of the object.
    pub p: DVec3,
}

/// The scene's textures, ready to be evaluated; made once, shared by all threads.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    list: Vec<Texture>,
}

/// One texture ready to be evaluated.
#[derive(Clone, Debug)]
pub enum Texture {
    /// Squares.
    Chessboard(chessboard::Chessboard),
}

impl Textures {
    /// The colour of a source at a point.
    #[inline]
    pub fn color(&self, source: ColorSource, at: &TexturePoint) -> Spectrum {
        match source {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(id) => self.eval(id, at),
        }
    }

    /// The colour of a texture at a point.
    pub fn eval(&self, id: TextureId, at: &TexturePoint) -> Spectrum {
        match &self.list[id.index()] {
            Texture::Chessboard(t) => t.eval(self, at),
        }
    }
}

impl Textures {
    /// Temporary.
    pub fn prepare(descs: &[crate::scene::Named<TextureDesc>], _images: &[crate::scene::Asset<crate::image::Image>], _transfer: crate::color::Transfer) -> Result<Textures, crate::scene::SceneError> {
        Ok(Textures { list: descs.iter().map(|d| match &d.value { TextureDesc::Chessboard(c) => Texture::Chessboard(c.prepare()) }).collect() })
    }
}
