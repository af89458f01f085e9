//! Merges the chunks of an OBJ file.

use std::collections::{BTreeSet, HashMap};

use turner::schema::WarningKind;

use super::chunk::{Change, Chunk, HALF, NONE, Others, RELATIVE};
use super::text::{name as name_of, words};
use super::{ObjFile, remarks};
use crate::mesh::error::{reserve, reserve_some};
use crate::mesh::polygon::Triangulator;
use crate::mesh::{MeshError, warning};

/// The state that applies to the following polygons.
struct State<'a> {
    material: Option<&'a [u8]>,
    smoothing: u32,
    object: &'a [u8],
    group: &'a [u8],
    shown: bool,
}

/// A run of triangles with the same material and smoothing group, from triangle `first`.
struct Run {
    first: usize,
    material: u16,
    smoothing: u32,
}

/// Merges chunks whose indices have been checked.
pub(super) fn merge(mut chunks: Vec<Chunk<'_>>, name: &str, nodes: &[String]) -> Result<ObjFile, MeshError> {
    let mut file = ObjFile::default();
    let bases = attributes(&mut chunks, &mut file, name)?;
    let mut corners = Corners::new(&chunks, &mut file, name)?;
    let mut state = State { material: None, smoothing: 0, object: b"", group: b"", shown: nodes.is_empty() };
    let mut materials = Materials::default();
    let mut runs: Vec<Run> = Vec::new();
    let mut others = Others::default();
    let (mut objects, mut groups) = (BTreeSet::new(), BTreeSet::new());
    for (chunk, base) in chunks.into_iter().zip(bases) {
        let mut reader = Polygons { chunk: &chunk, next: 0, corner: 0, size: 0 };
        for i in 0..=chunk.events.len() {
            let event = chunk.events.get(i);
            let until = event.map_or(chunk.polygons, |e| e.polygon);
            if reader.next < until {
                if state.shown {
                    let material = materials.number(state.material.unwrap_or(b""), name)?;
                    let run = Run { first: corners.count(&file), material, smoothing: state.smoothing };
                    reserve_some(&mut runs, 1, name)?;
                    runs.push(run);
                }
                while reader.next < until {
                    let range = reader.polygon();
                    if state.shown {
                        file.counts.polygons += 1;
                        corners.add(range, &chunk, base, &mut file, name)?;
                    }
                }
            }
            let Some(event) = event else { break };
            match event.change {
                Change::Material => state.material = Some(event.name),
                Change::Smoothing(group) => state.smoothing = group,
                Change::Object => {
                    state.object = event.name;
                    objects.insert(event.name);
                }
                Change::Group => {
                    state.group = event.name;
                    groups.insert(event.name);
                }
            }
            if !nodes.is_empty() && matches!(event.change, Change::Object | Change::Group) {
                state.shown = is_wanted(nodes, state.object, state.group);
            }
        }
        let other = &chunk.others;
        others.points += other.points;
        others.lines += other.lines;
        others.thin += other.thin;
        others.free_form += other.free_form;
        others.unknown += other.unknown;
        file.libraries.extend(chunk.libraries.iter().map(|l| l.to_vec()));
    }
    if corners.cutter.fanned > 0 {
        let message = "self-intersecting or very large polygons: triangulated as fans";
        let count = corners.cutter.fanned as u64;
        file.warnings.push(warning(WarningKind::Approximated, name, count, message));
    }
    file.warnings.extend(remarks(&others, name));
    file.counts.objects = objects.len() as u64;
    file.counts.groups = groups.len() as u64;
    for node in nodes {
        let named = |n: &&[u8]| is_named(node, n);
        if !objects.iter().any(named) && !groups.iter().any(named) {
            let valid: Vec<String> = objects.iter().chain(&groups).map(|n| name_of(n)).collect();
            return Err(MeshError::node(name, node, &valid));
        }
    }
    expand(&runs, &mut file, materials.names, name)?;
    Ok(file)
}

/// Whether `node` is the name of an object, or one of the names of a group.
fn is_named(node: &str, name: &[u8]) -> bool {
    name_of(name) == node || words(name).any(|word| word == node.as_bytes())
}

fn is_wanted(nodes: &[String], object: &[u8], group: &[u8]) -> bool {
    nodes.iter().any(|node| is_named(node, object) || is_named(node, group))
}

/// Material indices in the order of first use.
#[derive(Default)]
struct Materials<'a> {
    /// By the text as written, with comments and white space.
    written: HashMap<&'a [u8], u16>,
    ids: HashMap<String, u16>,
    names: Vec<String>,
}

impl<'a> Materials<'a> {
    fn number(&mut self, written: &'a [u8], name: &str) -> Result<u16, MeshError> {
        if let Some(&id) = self.written.get(written) {
            return Ok(id);
        }
        let wanted = name_of(written);
        let id = match self.ids.get(&wanted) {
            Some(&id) => id,
            None => {
                let id = u16::try_from(self.names.len()).map_err(|_| MeshError::materials(name))?;
                self.ids.insert(wanted.clone(), id);
                self.names.push(wanted);
                id
            }
        };
        self.written.insert(written, id);
        Ok(id)
    }
}

/// Concatenates the attributes; returns the number of elements before each chunk.
fn attributes(chunks: &mut [Chunk<'_>], file: &mut ObjFile, name: &str) -> Result<Vec<[i64; 3]>, MeshError> {
    let all = &mut file.attributes;
    reserve(&mut all.positions, chunks.iter().map(|c| c.positions.len()).sum(), name)?;
    reserve(&mut all.uvs, chunks.iter().map(|c| c.uvs.len()).sum(), name)?;
    reserve(&mut all.normals, chunks.iter().map(|c| c.normals.len()).sum(), name)?;
    if chunks.iter().any(|c| !c.colors.is_empty()) {
        reserve(&mut all.colors, all.positions.capacity(), name)?;
    }
    let has_colors = all.colors.capacity() > 0;
    let mut bases = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        bases.push([all.positions.len(), all.uvs.len(), all.normals.len()].map(|n| n as i64));
        all.positions.extend(std::mem::take(&mut chunk.positions));
        all.uvs.extend(std::mem::take(&mut chunk.uvs));
        all.normals.extend(std::mem::take(&mut chunk.normals));
        if has_colors {
            all.colors.extend(std::mem::take(&mut chunk.colors));
            all.colors.resize(all.positions.len(), [1.0; 4]);
        }
    }
    Ok(bases)
}

/// Iterates over the polygons of a chunk.
struct Polygons<'a, 'b> {
    chunk: &'a Chunk<'b>,
    next: u32,
    corner: usize,
    size: usize,
}

impl Polygons<'_, '_> {
    /// The corner range of the next polygon.
    #[inline]
    fn polygon(&mut self) -> std::ops::Range<usize> {
        let n = match self.chunk.sizes.get(self.size) {
            Some(&(polygon, n)) if polygon == self.next => {
                self.size += 1;
                n as usize
            }
            _ => 3,
        };
        self.next += 1;
        self.corner += n;
        self.corner - n..self.corner
    }
}

/// Collects triangles.
struct Corners {
    has: [bool; 3],
    cutter: Triangulator,
    polygon: Vec<[u32; 3]>,
}

impl Corners {
    fn new(chunks: &[Chunk<'_>], file: &mut ObjFile, name: &str) -> Result<Corners, MeshError> {
        let more = |c: &Chunk<'_>| c.sizes.iter().map(|s| s.1 as usize - 3).sum::<usize>();
        let count = chunks.iter().map(|c| c.polygons as usize + more(c)).sum();
        let has = [0, 1, 2].map(|k| chunks.iter().any(|c| !c.corners[k].is_empty()));
        let corners = &mut file.corners;
        let columns = [&mut corners.positions, &mut corners.uvs, &mut corners.normals];
        for (column, has) in columns.into_iter().zip(has) {
            reserve(column, if has { count } else { 0 }, name)?;
        }
        Ok(Corners { has, cutter: Triangulator::new(), polygon: Vec::new() })
    }

    fn count(&self, file: &ObjFile) -> usize {
        file.corners.positions.len()
    }

    /// Adds the triangles of a polygon. Memory for them is already reserved.
    #[inline]
    fn add(
        &mut self,
        range: std::ops::Range<usize>,
        chunk: &Chunk<'_>,
        base: [i64; 3],
        file: &mut ObjFile,
        name: &str,
    ) -> Result<(), MeshError> {
        let resolve = |k: usize, i: usize| -> u32 {
            match chunk.corners[k].get(i) {
                None | Some(&NONE) => NONE,
                Some(&v) if v & RELATIVE != 0 => (base[k] + i64::from(v & !RELATIVE) - HALF) as u32,
                Some(&v) => v,
            }
        };
        let all = &mut file.corners;
        if range.len() == 3 {
            let at = range.start;
            all.positions.push([at, at + 1, at + 2].map(|i| resolve(0, i)));
            if self.has[1] {
                all.uvs.push([at, at + 1, at + 2].map(|i| resolve(1, i)));
            }
            if self.has[2] {
                all.normals.push([at, at + 1, at + 2].map(|i| resolve(2, i)));
            }
            return Ok(());
        }
        file.polygons.add(all.positions.len(), range.len().saturating_sub(2), name)?;
        self.polygon.clear();
        reserve_some(&mut self.polygon, range.len(), name)?;
        self.polygon.extend(range.map(|i| [resolve(0, i), resolve(1, i), resolve(2, i)]));
        let (polygon, has, positions) = (&self.polygon, self.has, &file.attributes.positions);
        let position = |i: usize| positions[polygon[i][0] as usize];
        self.cutter.cut(polygon.len(), position, &mut |t| {
            all.positions.push(t.map(|i| polygon[i][0]));
            if has[1] {
                all.uvs.push(t.map(|i| polygon[i][1]));
            }
            if has[2] {
                all.normals.push(t.map(|i| polygon[i][2]));
            }
        });
        Ok(())
    }
}

/// Expands the runs to materials and smoothing groups per triangle, if there are several.
fn expand(runs: &[Run], file: &mut ObjFile, names: Vec<String>, name: &str) -> Result<(), MeshError> {
    let count = file.corners.positions.len();
    let ends = runs.iter().skip(1).map(|r| r.first).chain([count]);
    if names.len() > 1 {
        reserve(&mut file.face_materials, count, name)?;
        for (run, end) in runs.iter().zip(ends.clone()) {
            file.face_materials.resize(end, run.material);
        }
    }
    if runs.iter().any(|r| r.smoothing != 0) {
        reserve(&mut file.smoothing, count, name)?;
        for (run, end) in runs.iter().zip(ends) {
            file.smoothing.resize(end, run.smoothing);
        }
    }
    file.material_names = names;
    Ok(())
}
