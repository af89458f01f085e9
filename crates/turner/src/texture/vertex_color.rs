//! The vertex colours of a mesh.

use super::prepare::{Kind, PrepareContext};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// The vertex colours of a mesh, interpolated over its triangles, or the colours of a point cloud. Byte colours
    /// of PLY files are decoded by the sRGB curve; floating-point colours, also those of OBJ files, are used
    /// unchanged.
    pub struct VertexColorDesc as "vertex-color" {
        /// The colour of shapes without vertex colours.
        fallback: Spectrum = Spectrum::WHITE;
    }
    example r##"[[object]]
type = "mesh"
positions = [[-1, 0, 0], [1, 0, 0], [0, 1.5, 0]]
colors = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]
triangles = [[0, 1, 2]]
material = { color = { type = "vertex-color" } }
"##
}

/// Vertex colours, with the fallback.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexColor(Spectrum);

impl Kind for VertexColorDesc {
    type Prepared = VertexColor;
    const MAX_INPUTS: u64 = 0;

    fn sources(&self, _: &mut dyn FnMut(ColorSource)) {}

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<VertexColor, SceneError> {
        Ok(VertexColor(self.fallback))
    }
}

impl VertexColor {
    pub(super) fn eval(&self, _: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        at.color().map_or(self.0, |[r, g, b, _]| Spectrum::new(r, g, b))
    }

    /// It has no known scale.
    pub(super) fn spacing(&self, _: &Textures, _: &TexturePoint<'_>) -> Option<f64> {
        None
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}
