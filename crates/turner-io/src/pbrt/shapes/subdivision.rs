//! Loop subdivision surfaces.

use turner::schema::{Limits, MeshData};
use turner::shape::{Subdivision, SubdivisionScheme, subdivide};

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::light_parts::LightParts;
use super::mesh::corners;
use super::{Made, orient};

/// Most levels: a triangle becomes 4^10.
const MAX_LEVELS: i32 = 10;

/// `loopsubdiv`.
pub(super) fn surface(scene: &mut Assembly<'_>, state: &State, params: &mut Params) -> Result<Made, Fault> {
    let levels = params.integer("levels").or_else(|| params.integer("nlevels")).unwrap_or(3);
    let positions = params.take_triples("P");
    let triangles: Vec<[u32; 3]> = corners(params, "indices", positions.len())?;
    params.pass(&["scheme"]);
    let levels = levels.clamp(0, MAX_LEVELS) as u32;
    let faces = (triangles.len() as u64) << (2 * levels);
    scene.divide(faces.saturating_add(faces / 4 + positions.len() as u64), params.place)?;
    let mesh = MeshData { positions, triangles, ..MeshData::default() };
    // Vertices are those of the file, as in pbrt, also where several have one position.
    let by = Subdivision { join: false, levels, ..Subdivision::new(SubdivisionScheme::Loop, 1) };
    let made = subdivide(&mesh, &by, &Limits::default()).map_err(|e| Fault::from(e).or_at(params.place))?;
    let mut data = made.mesh;
    // The faces define the orientation; the normals follow.
    orient(&mut data, state.reverse);
    Ok(Made::Mesh(data, LightParts::Triangles))
}
