//! Wavefront OBJ: `v` (with colours), `vt`, `vn`, `f` and the names after `usemtl`; everything else is counted or
//! passed over.
//!
//! All objects and groups become one mesh. A corner `v/vt/vn` becomes a vertex of its own wherever the same position
//! has another (u, v) or normal. Where only some faces have normals, the others get that of their plane; where only
//! some have (u, v), the others get (0, 0).

use super::error::reserve;
use super::{MeshError, Place, ReadMesh, bad_index};
use crate::assets::printable;
use crate::scene::SceneFormat;
use std::collections::HashMap;
use turner::shape::mesh::MeshData;

/// No (u, v) or normal given.
const NONE: u32 = u32::MAX;
/// How many variants of one position are searched one after the other.
const CHAIN: usize = 16;
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// An index beyond what had been read when it was met; OBJ files may name vertices that follow.
#[derive(Clone, Copy)]
struct Ahead {
    line: u64,
    face: u64,
    index: i64,
}

struct Reader<'a> {
    name: &'a str,
    line: u64,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// As many as positions, or none.
    colors: Vec<[f32; 4]>,
    material_ids: HashMap<String, u16>,
    material_names: Vec<String>,
    /// That of the faces that follow.
    material: Option<u16>,
    /// By triangle.
    face_materials: Vec<u16>,
    /// Corners of triangles: position, (u, v), normal.
    corners: Vec<[u32; 3]>,
    polygon: Vec<[u32; 3]>,
    faces: u64,
    ahead: [Option<Ahead>; 3],
    libraries: usize,
    others: usize,
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let mut reader = Reader {
        name,
        line: 0,
        positions: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        colors: Vec::new(),
        material_ids: HashMap::new(),
        material_names: Vec::new(),
        material: None,
        face_materials: Vec::new(),
        corners: Vec::new(),
        polygon: Vec::new(),
        faces: 0,
        ahead: [None; 3],
        libraries: 0,
        others: 0,
    };
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut joined: Vec<u8> = Vec::new();
    for line in bytes.split(|&b| b == b'\n') {
        reader.line += 1;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        // A backslash at the end continues the line.
        if let Some(part) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(part);
            joined.push(b' ');
        } else if joined.is_empty() {
            reader.statement(line)?;
        } else {
            joined.extend_from_slice(line);
            reader.statement(&joined)?;
            joined.clear();
        }
    }
    reader.statement(&joined)?;
    reader.finish()
}

impl Reader<'_> {
    fn error(&self, problem: String) -> MeshError {
        self.error_at(self.line, problem)
    }

    fn error_at(&self, line: u64, problem: String) -> MeshError {
        MeshError::damaged(self.name, SceneFormat::Obj, Place::Line(line), problem)
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), MeshError> {
        // A `#` within a word is part of it, as in the `1.#IND` of some C libraries.
        let comment =
            (0..line.len()).find(|&i| line[i] == b'#' && (i == 0 || line[i - 1].is_ascii_whitespace()));
        let line = &line[..comment.unwrap_or(line.len())];
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut p = self.numbers::<3>(&mut words, "v x y z", 3)?;
                // One more number is a weight; three are a colour.
                match [words.next(), words.next(), words.next()] {
                    [Some(w), None, _] => {
                        let w = number(w)
                            .ok_or_else(|| self.error("the weight of a vertex is no number".into()))?;
                        p = p.map(|v| v / w);
                    }
                    [Some(r), Some(g), Some(b)] => {
                        if let [Some(r), Some(g), Some(b)] = [r, g, b].map(number) {
                            self.color([r, g, b, 1.0])?;
                        }
                    }
                    _ => {}
                }
                push(&mut self.positions, p, self.name)
            }
            Some(b"vt") => {
                let uv = self.numbers::<2>(&mut words, "vt u v", 1)?;
                push(&mut self.uvs, uv, self.name)
            }
            Some(b"vn") => {
                let n = self.numbers::<3>(&mut words, "vn x y z", 3)?;
                push(&mut self.normals, n, self.name)
            }
            Some(b"f") => self.face(&mut words),
            Some(b"usemtl") => {
                let words: Vec<_> = words.map(String::from_utf8_lossy).collect();
                self.use_material(words.join(" "))
            }
            Some(b"mtllib") => {
                self.libraries += 1;
                Ok(())
            }
            Some(b"l" | b"p" | b"curv" | b"curv2" | b"surf") => {
                self.others += 1;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The colour of the vertex that comes next; those before it without one are white.
    fn color(&mut self, color: [f32; 4]) -> Result<(), MeshError> {
        let more = self.positions.len() + 1 - self.colors.len();
        reserve_some(&mut self.colors, more, self.name)?;
        self.colors.resize(self.positions.len(), [1.0; 4]);
        self.colors.push(color);
        Ok(())
    }

    fn use_material(&mut self, name: String) -> Result<(), MeshError> {
        let known = self.material_ids.get(&name).copied();
        let id = match known {
            Some(id) => id,
            None => {
                let Ok(id) = u16::try_from(self.material_names.len()) else {
                    return Err(self.error("more than 65536 materials".into()));
                };
                push(&mut self.material_names, name.clone(), self.name)?;
                self.material_ids.insert(name, id);
                id
            }
        };
        self.material = Some(id);
        Ok(())
    }

    /// `N` numbers, of which at least `least` must be there.
    fn numbers<'w, const N: usize>(
        &self,
        words: &mut impl Iterator<Item = &'w [u8]>,
        expected: &str,
        least: usize,
    ) -> Result<[f32; N], MeshError> {
        let mut out = [0.0; N];
        for (i, slot) in out.iter_mut().enumerate() {
            let Some(word) = words.next() else {
                if i >= least {
                    break;
                }
                return Err(self.error(format!("expected `{expected}`, found {i} numbers")));
            };
            *slot = number(word)
                .ok_or_else(|| self.error(format!("expected `{expected}`, found \"{}\"", show(word))))?;
        }
        Ok(out)
    }

    fn face<'w>(&mut self, words: &mut impl Iterator<Item = &'w [u8]>) -> Result<(), MeshError> {
        self.faces += 1;
        let mut polygon = std::mem::take(&mut self.polygon);
        polygon.clear();
        for word in words {
            polygon.push(self.corner(word)?);
        }
        if let [first, rest @ ..] = polygon.as_slice() {
            if rest.len() < 2 {
                self.others += 1;
            }
            if self.material.is_none() {
                self.use_material(String::new())?;
            }
            let triangles = polygon.len().saturating_sub(2);
            reserve_some(&mut self.face_materials, triangles, self.name)?;
            let material = self.material.unwrap_or_default();
            self.face_materials.resize(self.face_materials.len() + triangles, material);
            reserve_some(&mut self.corners, triangles * 3, self.name)?;
            for pair in rest.windows(2) {
                self.corners.extend_from_slice(&[*first, pair[0], pair[1]]);
            }
        } else {
            return Err(self.error("a face without corners; expected `f 1 2 3`".into()));
        }
        self.polygon = polygon;
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, word: &[u8]) -> Result<[u32; 3], MeshError> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corner = [NONE; 3];
        let mut parts = word.split(|&b| b == b'/');
        for i in 0..3 {
            let Some(part) = parts.next() else { break };
            if part.is_empty() && i > 0 {
                continue;
            }
            let index = std::str::from_utf8(part).ok().and_then(|s| s.parse::<i64>().ok());
            let Some(index) = index else { return Err(self.bad_corner(word)) };
            let (count, kind) = (counts[i], KINDS[i]);
            let place = if index < 0 { count as i64 + index } else { index - 1 };
            if index == 0 || place < 0 || place >= i64::from(NONE) {
                return Err(self.error(bad_index(kind, self.faces, index, count, 1)));
            }
            if place >= count as i64 && self.ahead[i].is_none_or(|a| a.index < index) {
                self.ahead[i] = Some(Ahead { line: self.line, face: self.faces, index });
            }
            corner[i] = place as u32;
        }
        if parts.next().is_some() { Err(self.bad_corner(word)) } else { Ok(corner) }
    }

    fn bad_corner(&self, word: &[u8]) -> MeshError {
        self.error(format!("face {}: expected a corner `v/vt/vn`, found \"{}\"", self.faces, show(word)))
    }

    fn finish(mut self) -> Result<ReadMesh, MeshError> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for ((ahead, count), kind) in self.ahead.iter().zip(counts).zip(KINDS) {
            if let Some(a) = ahead.filter(|a| a.index > count as i64) {
                return Err(self.error_at(a.line, bad_index(kind, a.face, a.index, count, 1)));
            }
        }
        let mut warnings = Vec::new();
        let name = printable(self.name);
        if self.libraries > 0 {
            let names: Vec<String> = self.material_names.iter().take(8).map(|n| printable(n)).collect();
            let more = if self.material_names.len() > names.len() { ", …" } else { "" };
            warnings.push(match names.len() {
                0 | 1 => format!("{name}: its materials (mtllib) are ignored: give the object a material"),
                _ => format!(
                    "{name}: its materials (mtllib) are ignored: give the object `materials` by name: {}{more}",
                    names.join(", ")
                ),
            });
        }
        if self.others > 0 {
            warnings.push(format!("{name}: {} points, lines or curves ignored", self.others));
        }
        let (has_uvs, has_normals) = self.complete(&mut warnings)?;
        if !self.colors.is_empty() {
            let missing = self.positions.len() - self.colors.len();
            reserve_some(&mut self.colors, missing, self.name)?;
            self.colors.resize(self.positions.len(), [1.0; 4]);
        }
        let material_names = std::mem::take(&mut self.material_names);
        let mut face_materials = std::mem::take(&mut self.face_materials);
        if material_names.len() < 2 {
            face_materials = Vec::new();
        }
        let mesh = MeshData { face_materials, material_names, ..self.unify(has_uvs, has_normals)? };
        Ok(ReadMesh { mesh, warnings })
    }

    /// Gives every corner a (u, v) if any has one, and a normal if any has one.
    fn complete(&mut self, warnings: &mut Vec<String>) -> Result<(bool, bool), MeshError> {
        let lacks = |i: usize| self.corners.iter().filter(|c| c[i] == NONE).count();
        let (total, no_uv, no_normal) = (self.corners.len(), lacks(1), lacks(2));
        let (has_uvs, has_normals) = (no_uv < total, no_normal < total);
        let name = printable(self.name);
        if has_uvs && no_uv > 0 {
            push(&mut self.uvs, [0.0; 2], self.name)?;
            let made_up = self.uvs.len() as u32 - 1;
            self.corners.iter_mut().filter(|c| c[1] == NONE).for_each(|c| c[1] = made_up);
            warnings.push(format!("{name}: {no_uv} corners have no (u, v), read as (0, 0)"));
        }
        if has_normals && no_normal > 0 {
            for triangle in self.corners.chunks_exact_mut(3) {
                if triangle.iter().any(|c| c[2] == NONE) {
                    let p = |i: usize| self.positions[triangle[i][0] as usize];
                    push(&mut self.normals, plane_normal(p(0), p(1), p(2)), self.name)?;
                    let made_up = self.normals.len() as u32 - 1;
                    triangle.iter_mut().filter(|c| c[2] == NONE).for_each(|c| c[2] = made_up);
                }
            }
            warnings
                .push(format!("{name}: {no_normal} corners have no normal, they take that of their face"));
        }
        Ok((has_uvs, has_normals))
    }

    /// One vertex per distinct corner.
    fn unify(self, has_uvs: bool, has_normals: bool) -> Result<MeshData, MeshError> {
        let name = self.name;
        let mut triangles = Vec::new();
        reserve(&mut triangles, self.corners.len() / 3, name)?;
        if !has_uvs && !has_normals {
            triangles.extend(self.corners.chunks_exact(3).map(|t| [t[0][0], t[1][0], t[2][0]]));
            let (positions, colors) = (self.positions, self.colors);
            return Ok(MeshData { positions, colors, triangles, ..MeshData::default() });
        }
        // Vertices made from each position, as a list through `next`; long lists go on in a map.
        let mut first = Vec::new();
        reserve(&mut first, self.positions.len(), name)?;
        first.resize(self.positions.len(), NONE);
        let mut vertices: Vec<([u32; 3], u32)> = Vec::new();
        let mut map: HashMap<[u32; 3], u32> = HashMap::new();
        let mut vertex = |corner: [u32; 3]| -> Result<u32, MeshError> {
            let start = &mut first[corner[0] as usize];
            let (mut at, mut steps) = (*start, 0);
            while at != NONE && steps < CHAIN {
                let (known, next) = vertices[at as usize];
                if known == corner {
                    return Ok(at);
                }
                (at, steps) = (next, steps + 1);
            }
            if steps == CHAIN
                && let Some(&known) = map.get(&corner)
            {
                return Ok(known);
            }
            let new = vertices.len() as u32;
            if steps == CHAIN {
                map.insert(corner, new);
                push(&mut vertices, (corner, NONE), name)?;
            } else {
                push(&mut vertices, (corner, *start), name)?;
                *start = new;
            }
            Ok(new)
        };
        for t in self.corners.chunks_exact(3) {
            triangles.push([vertex(t[0])?, vertex(t[1])?, vertex(t[2])?]);
        }
        let mut mesh = MeshData { triangles, ..MeshData::default() };
        reserve(&mut mesh.positions, vertices.len(), name)?;
        mesh.positions.extend(vertices.iter().map(|(c, _)| self.positions[c[0] as usize]));
        if !self.colors.is_empty() {
            reserve(&mut mesh.colors, vertices.len(), name)?;
            mesh.colors.extend(vertices.iter().map(|(c, _)| self.colors[c[0] as usize]));
        }
        if has_uvs {
            reserve(&mut mesh.uvs, vertices.len(), name)?;
            mesh.uvs.extend(vertices.iter().map(|(c, _)| self.uvs[c[1] as usize]));
        }
        if has_normals {
            reserve(&mut mesh.normals, vertices.len(), name)?;
            mesh.normals.extend(vertices.iter().map(|(c, _)| self.normals[c[2] as usize]));
        }
        Ok(mesh)
    }
}

/// A number as C's printf writes it, `1.#IND` and `nan(ind)` included.
fn number(word: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| {
        let bare = text.trim_start_matches(['-', '+']);
        bare.get(..3).filter(|b| b.eq_ignore_ascii_case("nan") || *b == "1.#").map(|_| f32::NAN)
    })
}

fn show(word: &[u8]) -> String {
    printable(&String::from_utf8_lossy(&word[..word.len().min(40)]))
}

/// The unit normal of a triangle; zero if it has none.
fn plane_normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let side = |to: [f32; 3]| [0, 1, 2].map(|i| f64::from(to[i]) - f64::from(a[i]));
    let (u, v) = (side(b), side(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 && length.is_finite() { n.map(|x| (x / length) as f32) } else { [0.0; 3] }
}

fn reserve_some<T>(v: &mut Vec<T>, more: usize, name: &str) -> Result<(), MeshError> {
    v.try_reserve(more).map_err(|_| MeshError::OutOfMemory { name: printable(name), count: more })
}

fn push<T>(v: &mut Vec<T>, value: T, name: &str) -> Result<(), MeshError> {
    if v.len() == v.capacity() {
        reserve_some(v, 1, name)?;
    }
    v.push(value);
    Ok(())
}
