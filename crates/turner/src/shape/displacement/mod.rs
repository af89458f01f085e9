//! Displacement: the vertices of a mesh are moved along their normals by the values of an image, after its edges have been
//! divided until they are short enough.
//!
//! 1. `dice` divides long edges. Edges that fall into two where they are displaced are longer there, so steep places get
//!    more triangles than flat ones.
//! 2. `heights` reads the image at the (u, v) of vertices. Vertices at one position move as one, by the mean of their
//!    values along the mean of their normals, so that a seam of the (u, v) or a hard edge does not tear the surface.
//! 3. Shading normals are those of the displaced triangles.

mod dice;
mod heights;
#[cfg(test)]
mod tests;

use crate::image::Image;
use crate::math::DVec3;
use crate::schema::{ErrorCode, ImageId, Limits, MeshData, SceneError};

use dice::Diced;
use heights::Heights;

/// Without an edge length, edges are divided until they are shorter than this fraction of the diagonal of the bounds.
const DEFAULT_EDGE: f64 = 1.0 / 200.0;
/// Bytes per triangle while edges are divided: points, vertices, triangles, and the table of divided edges.
const TRIANGLE_BYTES: u64 = 240;

/// How the vertices of a mesh are moved along their normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// The image. Its values are the means of red, green and blue as stored.
    pub image: ImageId,
    /// Units of the object by which a value of 1 moves a vertex further out than a value of 0.
    pub scale: f64,
    /// The value that leaves vertices in place.
    pub midlevel: f64,
}

/// What is done to triangles after subdivision.
pub(super) struct Refinement<'a> {
    pub(super) displacement: Option<(Displacement, &'a Image)>,
    /// Longest edge, in units of the object.
    pub(super) edge_length: Option<f64>,
    /// Whether divided edges curve as the vertex normals say, as on a subdivision surface.
    pub(super) curved: bool,
    /// Whether vertex normals are made.
    pub(super) smooth: bool,
}

impl Refinement<'_> {
    /// Divides the edges of a mesh and displaces its vertices.
    ///
    /// Errors: data that disagree ([`MeshData::check`]); displacement without (u, v); more triangles or memory than the
    /// limits allow.
    pub(super) fn apply(&self, data: &MeshData, limits: &Limits) -> Result<MeshData, SceneError> {
        data.check()?;
        if self.displacement.is_some() && data.uvs.is_empty() && !data.triangles.is_empty() {
            let message = "a displaced mesh has no (u, v), which say where its image belongs";
            return Err(SceneError::new(ErrorCode::Mesh, message)
                .help("unwrap the model in a modelling program, or give `uvs`"));
        }
        let longest = self.edge_length.unwrap_or_else(|| DEFAULT_EDGE * diagonal(data));
        let heights = self.displacement.map(|(by, image)| Heights::new(image, by));
        let width = 2 + 2 * data.more_uvs.len() as u64 + 4 * u64::from(!data.colors.is_empty());
        let need = |triangles: usize| {
            let what = || format!("a mesh with edges of at most {longest:.4}");
            let checked = limits.check_triangles(triangles as u64, what);
            let bytes = (triangles as u64).saturating_mul(TRIANGLE_BYTES + 4 * width);
            let checked = checked.and_then(|()| limits.memory.need(bytes, what));
            checked.map_err(|e| e.help("use a longer `edge_length`"))
        };
        need(data.triangles.len())?;
        let mut diced = Diced::new(data, self.curved);
        diced.displace(heights.as_ref());
        while let Some(triangles) = diced.mark(longest) {
            need(triangles)?;
            diced.divide();
            diced.displace(heights.as_ref());
        }
        Ok(diced.into_mesh(data, self.smooth))
    }
}

/// The diagonal of the bounds of the finite vertices.
fn diagonal(data: &MeshData) -> f64 {
    let all = data.positions.iter().map(|p| DVec3::from(p.map(f64::from))).filter(|p| p.is_finite());
    let ends = all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let size = ends.1 - ends.0;
    if size.is_finite() { size.length() } else { 0.0 }
}
