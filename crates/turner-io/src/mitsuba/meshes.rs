//! Meshes from files, and those of built-in shapes.

use turner::math::DVec3;
use turner::math::elementary::acos;
use turner::schema::{ErrorCode, MeshData, MeshId, Warning};

use super::assembly::Assembly;
use super::params::Object;
use super::serialized;
use super::textures::Surface;
use crate::assets::printable;
use crate::import::ImportOptions;
use crate::mesh;
use crate::scene_import::report::Fault;
use crate::scene_import::{LoadedFile, LoadedMesh, SceneFile, orient};

/// Largest mesh file, bytes.
pub(super) const MAX_FILE: u64 = 16 << 30;

/// The mesh of a shape.
pub(super) enum Made {
    /// A mesh, and how its (u, v) relate to Mitsuba's.
    Mesh(MeshId, Surface),
    /// Nothing, after a report.
    Nothing,
}

/// `obj`, `ply`, `serialized`. Under a mirroring transform, triangles without vertex normals are flipped: their
/// normals follow the order of the vertices.
pub(super) fn of_file(
    scene: &mut Assembly<'_>,
    object: &Object,
    flip: bool,
    mirrored: bool,
) -> Result<Made, Fault> {
    let place = object.place_of("filename");
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        let message = format!("{} needs a filename", object.title());
        return Err(Fault::at(object.place, ErrorCode::MissingKey, message));
    };
    let face_normals = object.boolean("face_normals")?.unwrap_or(false);
    let flip_v = object.boolean("flip_tex_coords")?.unwrap_or(object.kind == "obj");
    let index = match object.kind.as_str() {
        "serialized" => object.integer("shape_index")?.unwrap_or(0).clamp(0, i64::from(i32::MAX)),
        _ => 0,
    };
    // Options of Mitsuba 0.6 for creases.
    object.pass(&["max_smooth_angle", "collapse", "srgb"]);
    let surface = if flip_v { Surface::Flipped } else { Surface::Same };
    let attribute = super::attributes::of_shape(scene, object)?;
    let colors = attribute.as_deref().unwrap_or_default();
    let key = (format!("{name}\0{index} {face_normals} {mirrored} {colors}"), flip);
    if let Some(known) = scene.mesh_ids.get(&key) {
        return Ok(known.map_or(Made::Nothing, |id| Made::Mesh(id, surface)));
    }
    let path;
    let mut data = match object.kind.as_str() {
        "serialized" => {
            let bytes;
            (path, bytes) = scene.read(&name, MAX_FILE, place)?;
            let left = usize::try_from(scene.options.limits.memory.left() / 2).unwrap_or(usize::MAX);
            let read = serialized::decode(&bytes, index as usize, left);
            read.map_err(|problem| damaged(&path, &problem).or_at(place))?
        }
        kind => {
            let kind = if kind == "obj" { "obj" } else { "ply" };
            let file = match scene.read_ahead(&SceneFile::Mesh(name.clone(), kind)) {
                Some(LoadedFile::Mesh(file)) => *file,
                _ => {
                    let (path, bytes) = scene.read(&name, MAX_FILE, place)?;
                    decode(&bytes, path, kind, scene.options).map_err(|fault| fault.or_at(place))?
                }
            };
            let is_known = |w: &Warning| attribute.is_some() && w.message.contains(mesh::ply::FACE_COLORS);
            for warning in file.warnings.into_iter().filter(|w| !is_known(w)) {
                scene.report.remark(warning);
            }
            path = file.path;
            file.mesh
        }
    };
    (data.face_materials, data.material_names) = (Vec::new(), Vec::new());
    if data.triangles.is_empty() {
        scene.report.doubtful(place, format!("{} has no triangles", printable(&path)));
        scene.mesh_ids.insert(key, None);
        return Ok(Made::Nothing);
    }
    if face_normals {
        data.normals = Vec::new();
    } else if data.normals.is_empty() {
        smooth(&mut data);
        // The computed normals follow the order of the vertices, as the triangles do.
        if mirrored {
            orient(&mut data, true);
        }
    }
    if face_normals && mirrored {
        orient(&mut data, true);
    }
    orient(&mut data, flip);
    if let Some(attribute) = &attribute {
        super::attributes::paint(scene, &mut data, object, &name, attribute)?;
    }
    let id = scene.mesh(printable(&name), data);
    scene.mesh_ids.insert(key, Some(id));
    Ok(Made::Mesh(id, surface))
}

/// Decodes a mesh file of the format `kind`, obj or ply, whatever it is called.
pub(super) fn decode(
    bytes: &[u8],
    path: String,
    kind: &str,
    options: &ImportOptions,
) -> Result<LoadedMesh, Fault> {
    let first = |text: String| text.lines().next().unwrap_or_default().to_owned();
    let called = if kind == "obj" { "a.obj" } else { "a.ply" };
    mesh::need::check(bytes, called, &options.limits).map_err(|mut e| {
        e.message = e.message.replace(called, &printable(&path));
        Fault::from(e)
    })?;
    let read = mesh::decode_any(bytes, called)
        .map_err(|e| damaged(&path, &first(e.to_string()).replace("a.obj: ", "").replace("a.ply: ", "")))?;
    Ok(LoadedMesh { path, mesh: read.mesh, warnings: read.warnings, mark: None })
}

fn damaged(path: &str, problem: &str) -> Fault {
    Fault::new(ErrorCode::Mesh, format!("{}: {problem}", printable(path)))
}

/// Vertex normals: the normals of the adjacent triangles, weighted by their angles at the vertex (Thürmer and
/// Wüthrich 1998).
fn smooth(data: &mut MeshData) {
    let mut sums = vec![DVec3::ZERO; data.positions.len()];
    for t in &data.triangles {
        let corner = |i: u32| {
            let p = data.positions.get(i as usize).copied().unwrap_or_default();
            DVec3::from(p.map(f64::from))
        };
        let p = t.map(corner);
        let Some(n) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
        for (i, vertex) in t.iter().enumerate() {
            let (here, next, last) = (p[i], p[(i + 1) % 3], p[(i + 2) % 3]);
            let (Some(a), Some(b)) = ((next - here).try_normalize(), (last - here).try_normalize()) else {
                continue;
            };
            if let Some(sum) = sums.get_mut(*vertex as usize) {
                *sum += n * acos(a.dot(b).clamp(-1.0, 1.0));
            }
        }
    }
    data.normals = sums.into_iter().map(|n| n.normalize_or(DVec3::Z).as_vec3().to_array()).collect();
}

/// The square from −1 to 1 in x and y.
pub(super) fn rectangle() -> MeshData {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    MeshData {
        positions: corners.iter().map(|[u, v]| [2.0 * u - 1.0, 2.0 * v - 1.0, 0.0]).collect(),
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

/// The cube from −1 to 1; each side has its own (u, v), as in Mitsuba.
pub(super) fn cube() -> MeshData {
    // Vertices of each side in Mitsuba's order.
    const SIDES: [[[i8; 3]; 4]; 6] = [
        [[1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]],
        [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]],
        [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]],
        [[1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]],
        [[-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]],
        [[1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]],
    ];
    let mut data = MeshData::default();
    for (side, first) in SIDES.iter().zip((0..).step_by(4)) {
        data.positions.extend(side.iter().map(|p| p.map(f32::from)));
        data.uvs.extend([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        data.triangles.extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_weighted_by_angles() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]];
        let mut data = MeshData { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshData::default() };
        smooth(&mut data);
        // The result of Mitsuba 3.9.1.
        for (found, expected) in data.normals[0].iter().zip([0.370_482_77, -0.370_482_77, 0.851_754_07]) {
            assert!((found - expected).abs() < 1e-5, "{:?}", data.normals);
        }
    }

    #[test]
    fn cubes_face_outwards() {
        let data = cube();
        for t in &data.triangles {
            let [a, b, c] = t.map(|i| DVec3::from(data.positions[i as usize].map(f64::from)));
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
        }
    }
}
