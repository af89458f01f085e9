//! Subdivision surfaces: the smooth limit of a mesh whose faces are divided again and again.
//!
//! The schemes are those of Catmull and Clark 1978 (faces of any number of corners become quadrilaterals) and Loop 1987
//! (triangles). Creases follow DeRose, Kass and Truong 1998, "Subdivision Surfaces in Character Animation": an edge of
//! sharpness s is kept sharp for s levels, then it is smooth; 10 and more means for ever. Borders are creases for ever.
//!
//! 1. `control` joins vertices at one position, which files split where (u, v) or normals differ, and finds the
//!    neighbours of each half-edge.
//! 2. `refine` divides all faces, level by level. (u, v) and colours belong to corners of faces and are interpolated
//!    linearly.
//! 3. `limit` moves the vertices of the last level onto the limit surface, finds the normals there, and makes
//!    triangles.

mod control;
mod limit;
mod masks;
mod refine;
#[cfg(test)]
mod tests;

use crate::schema::{ErrorCode, Limits, MeshData, SceneError, choice};

use control::Surface;

/// Most levels: a quadrilateral becomes 4^10.
pub const MAX_LEVELS: u32 = 10;
/// Sharpness from which an edge or vertex is sharp for ever.
const FOR_EVER: f32 = 10.0;
/// Bytes per triangle of the last level while it is made: half-edges, points, and what becomes of them.
const TRIANGLE_BYTES: u64 = 160;

choice! {
    /// How the faces of a mesh are divided.
    pub enum SubdivisionScheme {
        /// Polygons become quadrilaterals (Catmull and Clark 1978): for models made of quadrilaterals.
        CatmullClark = "catmull_clark",
        /// Triangles become four triangles (Loop 1987): for models made of triangles.
        Loop = "loop",
    }
}

/// How a mesh is subdivided.
#[derive(Clone, Debug, PartialEq)]
pub struct Subdivision {
    /// How faces are divided.
    pub scheme: SubdivisionScheme,
    /// How often, up to [`MAX_LEVELS`]; Catmull–Clark at least once.
    pub levels: u32,
    /// Sharp edges: two vertices and a sharpness of 0 or more; a vertex named twice is a sharp corner.
    pub creases: Vec<[f64; 3]>,
    /// Edges whose faces make a larger angle, in degrees, are sharp for ever.
    pub crease_angle: Option<f64>,
    /// Whether vertices of only one face stay in place.
    pub keep_corners: bool,
    /// Whether vertices at one position are one vertex.
    pub join: bool,
}

impl Subdivision {
    /// Without creases.
    pub fn new(scheme: SubdivisionScheme, levels: u32) -> Subdivision {
        Subdivision {
            scheme,
            levels: levels.clamp(1, MAX_LEVELS),
            creases: Vec::new(),
            crease_angle: None,
            keep_corners: false,
            join: true,
        }
    }
}

/// A subdivided mesh, and what could not be subdivided.
#[derive(Clone, Debug, Default)]
pub struct Subdivided {
    /// Triangles on the limit surface, with normals.
    pub mesh: MeshData,
    /// Faces that were omitted because they name a vertex twice or have a vertex that is not finite.
    pub omitted: usize,
}

/// Subdivides a mesh. Its normals and tangents are not used: those of the limit surface replace them.
///
/// Errors: data that disagree ([`MeshData::check`]); creases that are no edges; more triangles or memory than the limits
/// allow.
pub fn subdivide(data: &MeshData, by: &Subdivision, limits: &Limits) -> Result<Subdivided, SceneError> {
    data.check()?;
    // Without a level, the faces of Catmull–Clark are no quadrilaterals.
    let least = u32::from(by.scheme == SubdivisionScheme::CatmullClark);
    let levels = by.levels.clamp(least, MAX_LEVELS);
    let what = || "a subdivided mesh".to_owned();
    // Catmull-Clark makes a quadrilateral of each corner, then four of each; polygons have up to three corners per
    // triangle.
    let (first, shift) = match by.scheme {
        SubdivisionScheme::CatmullClark => (6 * data.triangles.len() as u64, 2 * (levels - 1)),
        SubdivisionScheme::Loop => (data.triangles.len() as u64, 2 * levels),
    };
    let triangles = first << shift;
    limits.check_triangles(triangles.min(exact_triangles(data, by.scheme) << shift), what)?;
    let width = 2 * u64::from(!data.uvs.is_empty()) + 2 * data.more_uvs.len() as u64;
    let width = width + 4 * u64::from(!data.colors.is_empty());
    limits.memory.need(triangles.saturating_mul(TRIANGLE_BYTES + 12 * width), what)?;
    // Half-edges are numbered in 32 bits, with one number for "none".
    if triangles.saturating_mul(3) >= u64::from(u32::MAX) {
        let message =
            format!("{levels} levels of subdivision make {triangles} triangles; expected fewer than 1.4e9");
        return Err(SceneError::new(ErrorCode::TooLarge, message).help("use fewer `levels`"));
    }
    let (mut surface, omitted) = Surface::new(data, by)?;
    for _ in 0..levels {
        surface = match by.scheme {
            SubdivisionScheme::CatmullClark => surface.catmull_clark(),
            SubdivisionScheme::Loop => surface.of_loop(),
        };
    }
    Ok(Subdivided { mesh: limit::triangles(&surface, by.scheme, data), omitted })
}

/// Triangles after the first level of Catmull–Clark, or of the mesh itself for Loop.
fn exact_triangles(data: &MeshData, scheme: SubdivisionScheme) -> u64 {
    let (triangles, polygons) = (data.triangles.len() as u64, data.polygon_count() as u64);
    match scheme {
        // n - 2 triangles have n corners, each of which makes a quadrilateral.
        SubdivisionScheme::CatmullClark => 2 * (triangles + 2 * polygons),
        SubdivisionScheme::Loop => triangles,
    }
}
