//! Binary STL: 80 bytes of any content, the number of facets, then 50 bytes per facet.

use turner::schema::WarningKind;

use super::{FACET, HEADER, StlFile, Welder, is_against};
use crate::mesh::error::reserve;
use crate::mesh::{MeshError, Place, warning};
use crate::scene::SceneFormat;

/// How the attribute bytes of facets store colours.
#[derive(Clone, Copy, PartialEq)]
enum Stored {
    Nothing,
    /// VisCAM and SolidView: the top bit is set if the facet has a colour.
    Marked,
    /// Materialise Magics: the top bit is set if the facet has this colour of the object.
    Whole([u8; 3]),
}

pub(super) fn read(bytes: &[u8], name: &str) -> Result<StlFile, MeshError> {
    let damaged = |at: usize, problem: String| {
        MeshError::damaged(name, SceneFormat::Stl, Place::Byte(at as u64), problem)
    };
    let Some(count) = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes) else {
        let problem =
            format!("expected 80 bytes and the number of facets, found {} bytes in total", bytes.len());
        return Err(damaged(0, problem));
    };
    let data = bytes.get(HEADER..).unwrap_or(&[]);
    let room = data.len() / FACET;
    if count as usize > room {
        let problem = format!("{count} facets announced, but the file holds at most {room}");
        return Err(damaged(80, problem));
    }
    let count = count as usize;
    let facets = data.get(..count * FACET).unwrap_or(&[]);
    let mut file = StlFile { solids: 1, ..StlFile::default() };
    if data.len() > facets.len() {
        let more = (data.len() - facets.len()) as u64;
        let message = "bytes after the last facet are ignored";
        file.warnings.push(warning(WarningKind::Ignored, name, more, message));
    }
    let mut welder = Welder::new();
    let triangles = &mut file.mesh.triangles;
    reserve(triangles, count, name)?;
    let mut against = 0;
    for facet in facets.chunks_exact(FACET) {
        let number = |i: usize| {
            let bytes = facet.get(4 * i..4 * i + 4).and_then(|b| b.try_into().ok());
            f32::from_le_bytes(bytes.unwrap_or_default())
        };
        let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
        let corners = [vector(3), vector(6), vector(9)];
        against += u64::from(is_against(vector(0), corners));
        let mut triangle = [0; 3];
        for (slot, corner) in triangle.iter_mut().zip(corners) {
            *slot = welder.vertex(corner, name)?;
        }
        triangles.push(triangle);
    }
    file.mesh.positions = welder.into_positions();
    if against > 0 {
        let message = "facets whose normal opposes the order of their vertices: the order is used";
        file.warnings.push(warning(WarningKind::Doubtful, name, against, message));
    }
    colors(bytes, facets, &mut file, name)?;
    Ok(file)
}

fn attribute(facet: &[u8]) -> u16 {
    facet.get(48..50).and_then(|b| b.try_into().ok()).map_or(0, u16::from_le_bytes)
}

/// Creates a material per facet colour, in order of first use: at most 32769.
fn colors(bytes: &[u8], facets: &[u8], file: &mut StlFile, name: &str) -> Result<(), MeshError> {
    let header = bytes.get(..80).unwrap_or(&[]);
    let whole = header.windows(6).position(|w| w == b"COLOR=");
    let whole = whole.and_then(|at| header.get(at + 6..at + 9)).and_then(|c| <[u8; 3]>::try_from(c).ok());
    let attributes = || facets.chunks_exact(FACET).map(attribute);
    let stored = match whole {
        Some(color) => Stored::Whole(color),
        None if attributes().any(|a| a & 0x8000 != 0) => Stored::Marked,
        None => Stored::Nothing,
    };
    if stored == Stored::Nothing {
        if attributes().any(|a| a != 0) {
            let message = "the attribute bytes of facets are not in a known colour format";
            file.warnings.push(warning(WarningKind::Ignored, name, 1, message));
        }
        return Ok(());
    }
    // The key of facets without a colour of their own.
    const PLAIN: usize = 0x8000;
    let mut numbers = vec![u16::MAX; PLAIN + 1];
    let materials = &mut file.mesh.face_materials;
    reserve(materials, file.mesh.triangles.len(), name)?;
    for attribute in attributes() {
        let own = (attribute & 0x8000 != 0) == (stored == Stored::Marked);
        let key = if own { usize::from(attribute & 0x7fff) } else { PLAIN };
        if numbers[key] == u16::MAX {
            numbers[key] = file.colors.len() as u16;
            let part = |shift: u16| ((attribute >> shift & 31) * 255 / 31) as u8;
            let color = match stored {
                Stored::Whole(_) if own => [part(0), part(5), part(10)],
                Stored::Whole(color) => color,
                _ if own => [part(10), part(5), part(0)],
                // 0.8 in linear values.
                _ => [231; 3],
            };
            let [r, g, b] = color;
            let plain = if key == PLAIN { "plain" } else { "" };
            file.colors.push(color);
            file.mesh.material_names.push(format!("{plain}#{r:02x}{g:02x}{b:02x}"));
        }
        materials.push(numbers[key]);
    }
    if file.colors.len() == 1 {
        file.mesh.face_materials = Vec::new();
        file.mesh.material_names = Vec::new();
    }
    Ok(())
}
