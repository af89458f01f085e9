//! Triangle meshes: `trianglemesh` and `plymesh`.

use turner::schema::{ColorSource, ErrorCode, MeshData};

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::source::Place;
use super::super::state::State;
use super::light_parts::LightParts;
use super::{Made, default_uvs, orient};
use crate::assets::printable;
use crate::{gzip, mesh};

/// Largest mesh file, bytes.
const MAX_PLY: u64 = 16 << 30;
/// Most bytes of a decompressed file per byte of the file. Deflate reaches 1032.
const MAX_GROWTH: usize = 64;

/// Index tuples from a flat list, each checked against the number of vertices.
pub(super) fn corners<const N: usize>(
    params: &Params,
    name: &'static str,
    vertices: usize,
) -> Result<Vec<[u32; N]>, Fault> {
    let flat = params.integers(name);
    let (groups, rest) = flat.as_chunks::<N>();
    let place = params.place_of(name);
    if !rest.is_empty() {
        let message = format!("{} indices; expected groups of {N}", flat.len());
        return Err(Fault::at(place, ErrorCode::Mesh, message));
    }
    if let Some(bad) = flat.iter().find(|i| usize::try_from(**i).map_or(true, |i| i >= vertices)) {
        let message = format!("index {bad} of a mesh of {vertices} vertices; they are counted from 0");
        return Err(Fault::at(place, ErrorCode::Mesh, message));
    }
    Ok(groups.iter().map(|g| g.map(|i| i as u32)).collect())
}

/// A list with one entry per vertex; one of another length is omitted, with a report.
pub(super) fn fitting<T>(
    scene: &mut Assembly<'_>,
    params: &Params,
    name: &str,
    list: Vec<T>,
    count: usize,
) -> Vec<T> {
    if !list.is_empty() && list.len() != count {
        let message = format!("{} values {name} for {count} vertices; expected one for each", list.len());
        scene.report.ignored(params.place_of(name), message);
        return Vec::new();
    }
    list
}

/// `trianglemesh`.
pub(super) fn triangles(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &mut Params,
    alpha: Option<ColorSource>,
) -> Result<Made, Fault> {
    let positions = params.take_triples("P");
    let count = positions.len();
    let triangles = if params.has("indices") {
        corners(params, "indices", count)?
    } else if count == 3 {
        params.pass(&["indices"]);
        vec![[0, 1, 2]]
    } else {
        let message = format!("a trianglemesh of {count} vertices needs \"integer indices\"");
        return Err(Fault::at(params.place, ErrorCode::MissingKey, message));
    };
    let normals = params.take_triples("N");
    let uvs = match params.take_pairs("uv") {
        list if list.is_empty() => params.take_pairs("st"),
        list => list,
    };
    // Tangents only rotate anisotropic highlights; face indices are for Ptex.
    params.pass(&["S", "faceIndices", "uv", "st", "edgelength"]);
    let normals = fitting(scene, params, "N", normals, count);
    let uvs = fitting(scene, params, "uv", uvs, count);
    let mut data = MeshData { positions, normals, uvs, triangles, ..MeshData::default() };
    if data.uvs.is_empty() && default_uvs::are_used(scene, state, alpha) {
        add_uvs(scene, &mut data, params.place);
    }
    orient(&mut data, state.reverse);
    Ok(Made::Mesh(data, LightParts::Triangles))
}

/// Gives a mesh the (u, v) of meshes that have none.
fn add_uvs(scene: &mut Assembly<'_>, data: &mut MeshData, place: Place) {
    match default_uvs::with_default_uvs(data, scene.options.limits.memory.left() / 2) {
        Some(with_uvs) => *data = with_uvs,
        None => scene.report.approximated(place, "a textured mesh without uv: too large for default ones"),
    }
}

/// `plymesh`, possibly compressed.
pub(super) fn ply(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    alpha: Option<ColorSource>,
) -> Result<Made, Fault> {
    let place = params.place_of("filename");
    let Some(name) = params.string("filename").map(str::to_owned) else {
        return Err(Fault::at(params.place, ErrorCode::MissingKey, "a plymesh needs \"string filename\""));
    };
    let wants_uvs = default_uvs::are_used(scene, state, alpha) || params.has("displacement");
    let key = (if wants_uvs { format!("{name}\0uv") } else { name.clone() }, state.reverse);
    if let Some(known) = scene.mesh_ids.get(&key) {
        return Ok(known.map_or(Made::Nothing, |id| Made::Shared(id, LightParts::Triangles)));
    }
    let (path, mut bytes) = scene.read(&name, MAX_PLY, place)?;
    let damaged =
        |problem: String| Fault::at(place, ErrorCode::Mesh, format!("{}: {problem}", printable(&path)));
    if gzip::is_gzip(&bytes) {
        let left = usize::try_from(scene.options.limits.memory.left() / 2).unwrap_or(usize::MAX);
        let limit = bytes.len().saturating_mul(MAX_GROWTH).saturating_add(1 << 20).min(left);
        bytes = gzip::decompress(&bytes, limit).map_err(damaged)?;
    }
    let inner = path.strip_suffix(".gz").unwrap_or(&path);
    mesh::need::check(&bytes, inner, &scene.options.limits).map_err(|e| Fault::from_scene(place, e))?;
    let read = mesh::decode_any(&bytes, inner)
        .map_err(|e| damaged(e.to_string().lines().next().unwrap_or_default().to_owned()))?;
    drop(bytes);
    for warning in read.warnings {
        scene.report.remark(warning);
    }
    let mut data = read.mesh;
    if data.triangles.is_empty() {
        scene.report.doubtful(place, format!("{} has no triangles", printable(&path)));
        scene.mesh_ids.insert(key, None);
        return Ok(Made::Nothing);
    }
    if wants_uvs && data.uvs.is_empty() {
        add_uvs(scene, &mut data, place);
    }
    orient(&mut data, state.reverse);
    // pbrt ignores vertex colours.
    data.colors = Vec::new();
    let id = scene.mesh(printable(&name), data);
    scene.mesh_ids.insert(key, Some(id));
    Ok(Made::Shared(id, LightParts::Triangles))
}
