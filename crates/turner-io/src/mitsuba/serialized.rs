//! Mitsuba's serialized meshes: several in one file, each compressed with zlib; a table of their offsets ends
//! the file.
//!
//! ```text
//! mesh    u16 0x041c, u16 version (3, 4), then compressed:
//!         u32 flags, version 4: name ending in 0, u64 vertices, u64 triangles,
//!         positions, normals, (u, v), colours, each if its flag says so, corners of triangles
//! file    meshes, offset of each (version 3: u32, version 4: u64), u32 count
//! ```

use turner::schema::MeshData;

use crate::gzip;

const NORMALS: u32 = 0x0001;
const UVS: u32 = 0x0002;
const COLORS: u32 = 0x0008;
const DOUBLE: u32 = 0x2000;

/// Most bytes of a decompressed mesh per compressed byte.
const MAX_GROWTH: usize = 256;

/// Decodes the mesh `index` of a file to at most `most` bytes.
///
/// Errors, in words: damaged files, and counts that do not fit the file.
pub(super) fn decode(bytes: &[u8], index: usize, most: usize) -> Result<MeshData, String> {
    let cut = || "the file is truncated".to_owned();
    let version = header(bytes)?;
    let end = bytes.len().checked_sub(4).ok_or_else(cut)?;
    let count = word(bytes, end).ok_or_else(cut)? as usize;
    if index >= count {
        return Err(format!("shape_index {index} of a file of {count} meshes"));
    }
    let size = if version == 4 { 8 } else { 4 };
    let table = count.checked_mul(size).and_then(|n| end.checked_sub(n));
    let table = table.ok_or_else(|| format!("{count} meshes are more than the file holds"))?;
    let at = |i: usize| -> Option<usize> {
        let from = table + i * size;
        let offset = if size == 8 { long(bytes, from)? } else { u64::from(word(bytes, from)?) };
        usize::try_from(offset).ok()
    };
    let start = at(index).ok_or_else(cut)?;
    let next = if index + 1 < count { at(index + 1).ok_or_else(cut)? } else { table };
    let outside = || format!("mesh {index} lies outside the file");
    let part = bytes.get(start..next.min(table)).ok_or_else(outside)?;
    let version = header(part)?;
    let packed = part.get(4..).ok_or_else(cut)?;
    let limit = packed.len().saturating_mul(MAX_GROWTH).saturating_add(1 << 16).min(most);
    mesh(&gzip::decompress_zlib(packed, limit)?, version)
}

fn header(bytes: &[u8]) -> Result<u16, String> {
    match bytes {
        [0x1c, 0x04, version @ (3 | 4), 0, ..] => Ok(u16::from(*version)),
        [0x1c, 0x04, a, b, ..] => Err(format!("version {}; expected 3 or 4", u16::from_le_bytes([*a, *b]))),
        _ => Err("is not a serialized mesh".into()),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

/// The bytes that are left.
struct Rest<'a> {
    bytes: &'a [u8],
    is_double: bool,
}

impl Rest<'_> {
    /// Reads `count` vectors of N numbers. Fails if the data is too short for them.
    fn vectors<const N: usize>(&mut self, count: usize) -> Result<Vec<[f32; N]>, String> {
        let size = if self.is_double { 8 } else { 4 };
        let total = count.checked_mul(N * size).filter(|n| *n <= self.bytes.len());
        let total = total.ok_or_else(|| format!("{count} vertices are more than the mesh holds"))?;
        let (own, rest) = self.bytes.split_at(total);
        self.bytes = rest;
        let number = |b: &[u8]| -> f32 {
            match *b {
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32,
                _ => 0.0,
            }
        };
        let mut out = Vec::new();
        out.try_reserve_exact(count).map_err(|_| "not enough memory for the mesh".to_owned())?;
        for v in own.chunks_exact(N * size) {
            let mut vector = [0.0; N];
            for (slot, b) in vector.iter_mut().zip(v.chunks_exact(size)) {
                *slot = number(b);
            }
            out.push(vector);
        }
        Ok(out)
    }
}

fn mesh(bytes: &[u8], version: u16) -> Result<MeshData, String> {
    let cut = || "a mesh is truncated".to_owned();
    let flags = word(bytes, 0).ok_or_else(cut)?;
    let mut at = 4;
    if version == 4 {
        let name = bytes.get(at..).unwrap_or_default();
        at += name.iter().position(|b| *b == 0).ok_or_else(cut)? + 1;
    }
    let count = |at| long(bytes, at).and_then(|n| usize::try_from(n).ok()).ok_or_else(cut);
    let (vertices, triangles) = (count(at)?, count(at + 8)?);
    if vertices > u32::MAX as usize {
        return Err(format!("{vertices} vertices; at most {} are read", u32::MAX));
    }
    let mut rest = Rest { bytes: bytes.get(at + 16..).unwrap_or_default(), is_double: flags & DOUBLE != 0 };
    let positions = rest.vectors::<3>(vertices)?;
    let normals = if flags & NORMALS != 0 { rest.vectors::<3>(vertices)? } else { Vec::new() };
    let uvs = if flags & UVS != 0 { rest.vectors::<2>(vertices)? } else { Vec::new() };
    let colors = if flags & COLORS != 0 { rest.vectors::<3>(vertices)? } else { Vec::new() };
    let (corners, _) = rest.bytes.as_chunks::<4>();
    let wanted = triangles.checked_mul(3).filter(|n| *n <= corners.len());
    let wanted = wanted.ok_or_else(|| format!("{triangles} triangles are more than the mesh holds"))?;
    let corners: Vec<u32> = corners.iter().take(wanted).map(|b| u32::from_le_bytes(*b)).collect();
    if let Some(bad) = corners.iter().find(|i| **i as usize >= vertices) {
        return Err(format!("vertex index {bad} in a mesh of {vertices} vertices"));
    }
    let (triangles, _) = corners.as_chunks::<3>();
    let colors = colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
    Ok(MeshData { positions, normals, uvs, colors, triangles: triangles.to_vec(), ..MeshData::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::deflate::compress_to_vec_zlib;

    fn body(version: u16, flags: u32, vertices: u64, triangles: u64) -> Vec<u8> {
        let mut out = flags.to_le_bytes().to_vec();
        if version == 4 {
            out.extend(b"name\0");
        }
        out.extend(vertices.to_le_bytes());
        out.extend(triangles.to_le_bytes());
        let is_double = flags & DOUBLE != 0;
        let mut put = |v: f32| {
            if is_double {
                out.extend(f64::from(v).to_le_bytes());
            } else {
                out.extend(v.to_le_bytes());
            }
        };
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0].into_iter().for_each(&mut put);
        if flags & UVS != 0 {
            [0.0, 0.0, 1.0, 0.0, 0.0, 0.5].into_iter().for_each(&mut put);
        }
        [0u32, 1, 2].iter().for_each(|i| out.extend(i.to_le_bytes()));
        out
    }

    fn file(version: u16, bodies: &[Vec<u8>]) -> Vec<u8> {
        let (mut out, mut offsets) = (Vec::new(), Vec::new());
        for body in bodies {
            offsets.push(out.len() as u64);
            out.extend(0x041c_u16.to_le_bytes());
            out.extend(version.to_le_bytes());
            out.extend(compress_to_vec_zlib(body, 6));
        }
        for o in offsets {
            let o = o.to_le_bytes();
            out.extend(if version == 4 { &o[..] } else { &o[..4] });
        }
        out.extend((bodies.len() as u32).to_le_bytes());
        out
    }

    #[test]
    fn both_versions_are_read() {
        for (version, flags) in [(3, 0x1000), (4, 0x1000 | UVS), (4, DOUBLE | UVS), (3, DOUBLE)] {
            let bytes = file(version, &[body(version, 0x1000, 3, 1), body(version, flags, 3, 1)]);
            let mesh = decode(&bytes, 1, usize::MAX).unwrap();
            assert_eq!(mesh.positions[2], [0.0, 2.0, 0.0]);
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
            assert_eq!(mesh.uvs.len(), if flags & UVS != 0 { 3 } else { 0 });
            assert!(decode(&bytes, 2, usize::MAX).unwrap_err().contains("2 meshes"));
        }
    }

    #[test]
    fn counts_that_lie_are_refused() {
        for (vertices, triangles) in
            [(u64::MAX, 1), (1 << 40, 1), (3, 1 << 60), (3, 2), (2, 1), (4, 1), (1 << 32, 0)]
        {
            let bytes = file(4, &[body(4, 0x1000, vertices, triangles)]);
            assert!(decode(&bytes, 0, usize::MAX).is_err(), "{vertices} {triangles}");
        }
        let good = file(4, &[body(4, 0x1000, 3, 1)]);
        for end in 0..good.len() {
            assert!(decode(&good[..end], 0, usize::MAX).is_err());
        }
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut bad = good.clone();
                bad[at] ^= 1 << bit;
                let _ = decode(&bad, 0, usize::MAX);
            }
        }
        let bomb = file(4, &[vec![0; 1 << 26]]);
        assert!(decode(&bomb, 0, usize::MAX).is_err());
    }
}
