//! Stanford PLY: ASCII and binary of either byte order, any scalar types, any extra properties and elements.
//!
//! Vertices: `x y z`, `nx ny nz`, (u, v) under several names, and colours `red green blue`, perhaps `alpha`, or the same after
//! `diffuse_`. Faces: the list `vertex_indices` or `vertex_index`, perhaps `texcoord` with a (u, v) for each corner; or
//! `tristrips`; and `material`, a number for each. More sets of (u, v), tangents and names of materials: see [`write()`]. Without faces the vertices are a cloud of points. `comment TextureFile NAME` names a picture. The layouts
//! that programs write (binary, floats, one list of ints per face) are read straight from the bytes; all others number by number.

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

/// What is wrong, and where.
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

/// Bytes that reading a file takes at its peak, and the triangles that it announces; nothing for one that is damaged.
pub(super) fn need(bytes: &[u8]) -> (u64, u64) {
    /// Of a vertex: position, normal, (u, v), colour.
    const VERTEX: u64 = 12 + 12 + 8 + 16;
    /// Of a face, taken for a triangle: its corners, and those of its (u, v).
    const FACE: u64 = 12;
    let Ok(header) = header::read(bytes) else { return (0, 0) };
    let size = bytes.len() as u64;
    let count = |name: &str| {
        let elements = header.elements.iter().filter(|e| e.name == name);
        // No more than the file can hold.
        elements
            .map(|e| (e.count as u64).min(size / e.least_bytes(header.encoding).max(1) as u64))
            .sum::<u64>()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    (vertices.saturating_mul(VERTEX).saturating_add(faces.saturating_mul(FACE)), faces)
}

/// Reads a whole file.
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
                    let message = "face colours are ignored: use vertex colours";
                    warnings.push(warning(WarningKind::Ignored, name, 1, message));
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
    faces.remarks(&mut warnings);
    if header.textures.len() > 1 {
        let more = header.textures.len() as u64 - 1;
        let message = "images after the first TextureFile are ignored";
        warnings.push(warning(WarningKind::Ignored, name, more, message));
    }
    let Faces { triangles, wedges, wedge_uvs, materials, .. } = faces;
    mesh.triangles = triangles;
    if !wedges.is_empty() && wedges.len() == mesh.triangles.len() {
        let pair = |k: [u32; 3]| [k[1], k[2]].map(f32::from_bits);
        let mut uvs = Vec::new();
        super::error::reserve(&mut uvs, wedge_uvs.keys.len(), name)?;
        uvs.extend(wedge_uvs.keys.iter().copied().map(pair));
        mesh = with_wedges(mesh, wedges, uvs, name)?;
    }
    if materials.len() == mesh.triangles.len() {
        mesh.face_materials = materials;
    }
    mesh.material_names = header.materials;
    Ok(ReadMesh { mesh, warnings, texture: header.textures.into_iter().next() })
}

/// Vertices of their own for corners with another (u, v).
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

/// Refuses a number of elements that the rest of the file cannot hold.
fn check_count(element: &Element, encoding: Encoding, data: &Values<'_>) -> Result<(), Fail> {
    let least = element.least_bytes(encoding);
    if element.count > 0 && least == 0 && matches!(element.name.as_str(), "vertex" | "face" | "tristrips") {
        return Err(data.fail(format!("the element \"{}\" has no properties", element.name)));
    }
    // The last number of a text needs no blank after it.
    let room = (data.rest().len() + 1) / least.max(1);
    if least == 0 || element.count <= room {
        return Ok(());
    }
    let (name, count) = (printable(&element.name), element.count);
    Err(data.fail(format!("{count} elements \"{name}\" announced, but the file has room for {room}")))
}

fn skip(element: &Element, data: &mut Values<'_>) -> Result<(), Fail> {
    // Without properties there is nothing to walk over, however many there are.
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
