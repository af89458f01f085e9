//! Stanford PLY: ASCII and binary of either byte order, any scalar types, any extra properties and elements.
//!
//! - `vertex`: `x y z`, `nx ny nz`, (u, v) under several names, colours `red green blue` with optional `alpha`, also with
//!   the prefix `diffuse_`. For further UV sets and tangents see [`write()`].
//! - `face`: the list `vertex_indices` or `vertex_index`; optionally `texcoord`, a (u, v) per corner, and `material`, an
//!   index.
//! - `tristrips`: triangle strips.
//!
//! Without faces the vertices are a point cloud. `comment TextureFile NAME` names an image. The common layout
//! (binary, floats, one list of integers per face) is decoded directly from the bytes, any other layout value by
//! value.

pub(crate) mod attribute;
mod faces;
mod header;
mod values;
mod vertices;
mod write;

use faces::Faces;
use header::{Element, Encoding, Scalar};
use turner::schema::{MeshData, WarningKind};
use values::Values;

use super::corners::{Attributes, Corners, unify};
use super::polygon::Triangulator;
use super::{MeshError, Place, ReadMesh, bad_index, warning};
use crate::assets::printable;
use crate::scene::SceneFormat;
pub use write::write;

/// The warning about colours of faces. Mitsuba's importer reads them itself.
pub(crate) const FACE_COLORS: &str = "face colours are ignored: use vertex colours";

/// An error and its position.
#[derive(Debug)]
struct Fail {
    place: Place,
    problem: String,
}

/// Why a file could not be read.
enum Stop {
    Damaged(Fail),
    Other(MeshError),
}

impl From<Fail> for Stop {
    fn from(fail: Fail) -> Stop {
        Stop::Damaged(fail)
    }
}

impl From<MeshError> for Stop {
    fn from(error: MeshError) -> Stop {
        Stop::Other(error)
    }
}

/// Peak memory of reading a file, in bytes, and the announced number of triangles; zero for damaged files.
pub(super) fn need(bytes: &[u8]) -> (u64, u64) {
    /// Bytes of a vertex: position, normal, (u, v), colour.
    const VERTEX: u64 = 12 + 12 + 8 + 16;
    /// Bytes of a face, counted as a triangle with its corners.
    const FACE: u64 = 12;
    let Ok(header) = header::read(bytes) else { return (0, 0) };
    let size = bytes.len() as u64;
    let count = |name: &str| {
        let elements = header.elements.iter().filter(|e| e.name == name);
        // Not more than fit in the file.
        elements
            .map(|e| (e.count as u64).min(size / e.least_bytes(header.encoding).max(1) as u64))
            .sum::<u64>()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    (vertices.saturating_mul(VERTEX).saturating_add(faces.saturating_mul(FACE)), faces)
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    read_all(bytes, name).map_err(|stop| match stop {
        Stop::Damaged(f) => MeshError::damaged(name, SceneFormat::Ply, f.place, f.problem),
        Stop::Other(error) => error,
    })
}

fn read_all(bytes: &[u8], name: &str) -> Result<ReadMesh, Stop> {
    let header = header::read(bytes)?;
    let mut data = Values::new(bytes, header.len, header.lines + 1, header.encoding);
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut mesh = MeshData::default();
    let mut faces = Faces::new(vertices, name);
    let mut warnings = Vec::new();
    for element in &header.elements {
        check_count(element, header.encoding, &data)?;
        match element.name.as_str() {
            "vertex" => vertices::read(element, header.encoding, &mut data, &mut mesh, name)?,
            "face" => {
                faces.read(element, header.encoding, &mut data, &mesh.positions)?;
                if ["red", "green", "blue"].iter().all(|n| element.has(n)) {
                    warnings.push(warning(WarningKind::Ignored, name, 1, FACE_COLORS));
                }
            }
            "tristrips" => faces.read_strips(element, &mut data)?,
            other => {
                skip(element, &mut data)?;
                if element.count > 0 {
                    let message = format!("elements \"{}\" are ignored", printable(other));
                    warnings.push(warning(WarningKind::Ignored, name, element.count as u64, &message));
                }
            }
        }
    }
    if let (count @ 1.., first) = &header.unknown {
        let message = format!("lines of the header are ignored, the first is \"{}\"", printable(first));
        warnings.push(warning(WarningKind::Ignored, name, *count, &message));
    }
    faces.remarks(&mut warnings);
    if header.textures.len() > 1 {
        let more = header.textures.len() as u64 - 1;
        let message = "images after the first TextureFile are ignored";
        warnings.push(warning(WarningKind::Ignored, name, more, message));
    }
    let Faces { triangles, polygons, wedges, wedge_uvs, materials, .. } = faces;
    let polygons = polygons.finish(triangles.len(), name)?;
    mesh.triangles = triangles;
    if !wedges.is_empty() && wedges.len() == mesh.triangles.len() {
        let pair = |k: [u32; 3]| [k[1], k[2]].map(f32::from_bits);
        let mut uvs = Vec::new();
        super::error::reserve(&mut uvs, wedge_uvs.keys.len(), name)?;
        uvs.extend(wedge_uvs.keys.iter().copied().map(pair));
        mesh = with_wedges(mesh, wedges, uvs, name)?;
    }
    mesh.polygons = polygons;
    if materials.len() == mesh.triangles.len() {
        mesh.face_materials = materials;
    }
    mesh.material_names = header.materials;
    Ok(ReadMesh { mesh, warnings, texture: header.textures.into_iter().next() })
}

/// Splits vertices whose corners have different (u, v).
fn with_wedges(
    mesh: MeshData,
    wedges: Vec<[u32; 3]>,
    uvs: Vec<[f32; 2]>,
    name: &str,
) -> Result<MeshData, MeshError> {
    let MeshData { positions, normals, colors, triangles, .. } = mesh;
    let mut corners = Corners { uvs: wedges, ..Corners::default() };
    if !normals.is_empty() {
        super::error::reserve(&mut corners.normals, triangles.len(), name)?;
        corners.normals.extend_from_slice(&triangles);
    }
    corners.positions = triangles;
    unify(Attributes { positions, colors, uvs, normals }, corners, name)
}

/// Refuses an element count that does not fit in the rest of the file.
fn check_count(element: &Element, encoding: Encoding, data: &Values<'_>) -> Result<(), Fail> {
    let least = element.least_bytes(encoding);
    if element.count > 0 && least == 0 && matches!(element.name.as_str(), "vertex" | "face" | "tristrips") {
        return Err(data.fail(format!("the element \"{}\" has no properties", element.name)));
    }
    // The last number of an ASCII file needs no space after it.
    let room = (data.rest().len() + 1) / least.max(1);
    if least == 0 || element.count <= room {
        return Ok(());
    }
    let (name, count) = (printable(&element.name), element.count);
    Err(data.fail(format!(
        "{count} elements \"{name}\" announced, but the rest of the file holds at most {room}"
    )))
}

fn skip(element: &Element, data: &mut Values<'_>) -> Result<(), Fail> {
    // Records without properties take no bytes; do not loop over them.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.count {
                None => data.next(property.item).map(|_| ())?,
                Some(count) => skip_list(count, property.item, data)?,
            }
        }
    }
    Ok(())
}

fn skip_list(count: Scalar, item: Scalar, data: &mut Values<'_>) -> Result<(), Fail> {
    for _ in 0..data.list_len(count, item)? {
        data.next(item)?;
    }
    Ok(())
}
