//! Wavefront OBJ: positions with weights and colours, (u, v), normals, polygons, groups, objects, smoothing groups
//! and material names. Points, lines, curves and surfaces are counted and ignored.
//!
//! Large files are parsed in parallel, with a result that does not depend on the number of threads:
//!
//! 1. [`split`] cuts the text into chunks of about 1 MiB at ends of lines.
//! 2. Threads parse chunks independently ([`chunk`]). A chunk does not know how many vertices precede it. Positive
//!    indices count from the start of the file and need no correction; negative indices count back from the current
//!    vertex, so they are stored relative to the chunk.
//! 3. [`check`] verifies all indices from the totals. On an error it parses the chunk again, now with the totals
//!    before it, to report line and face number.
//! 4. [`merge`] concatenates the chunks in order, resolves relative indices, and applies `usemtl`, `o`, `g` and `s`,
//!    which continue across chunk boundaries.
//!
//! All objects and groups become one mesh. A position with several (u, v) or normals becomes several vertices. Faces
//! without normals, among faces with normals, get those of their smoothing group or their plane; corners without (u,
//! v), among corners with (u, v), get (0, 0).

mod chunk;
mod merge;
mod normals;
mod text;

pub(super) use text::{name as name_of, words};

use std::borrow::Cow;
use std::sync::atomic::{AtomicUsize, Ordering};

use chunk::{Before, Chunk, Fail, NONE, Others};
use turner::color::Transfer;
use turner::schema::{MeshData, Warning, WarningKind};

use super::corners::{Attributes, Corners, unify};
use super::error::{reserve, reserve_some};
use super::polygon::PolygonSizes;
use super::{MeshError, Place, ReadMesh, warning};
use crate::assets::printable;
use crate::scene::SceneFormat;

/// Bytes of a chunk.
const PART: usize = 1 << 20;

/// A parsed file, before its corners become vertices.
#[derive(Debug, Default)]
pub(super) struct ObjFile {
    attributes: Attributes,
    corners: Corners,
    /// Smoothing group per triangle, or empty.
    smoothing: Vec<u32>,
    polygons: PolygonSizes,
    face_materials: Vec<u16>,
    pub(super) material_names: Vec<String>,
    /// The rest of each `mtllib` line.
    pub(super) libraries: Vec<Vec<u8>>,
    pub(super) counts: Counts,
    pub(super) warnings: Vec<Warning>,
}

/// Counts for the import summary.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) polygons: u64,
    pub(super) objects: u64,
    pub(super) groups: u64,
}

/// Reads a file as a mesh, without its material libraries.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<ReadMesh, MeshError> {
    let mut file = parse(bytes, name, &[], 0)?;
    let mut ignored = Vec::new();
    if !file.libraries.is_empty() {
        let shown = printable(name);
        let names: Vec<String> = file.material_names.iter().take(8).map(|n| printable(n)).collect();
        let more = if file.material_names.len() > names.len() { ", …" } else { "" };
        ignored.push(match names.len() {
            0 | 1 => format!("{shown}: its materials (mtllib) are ignored: give the object a material"),
            _ => format!(
                "{shown}: its materials (mtllib) are ignored: give the object `materials` by name: {}{more}",
                names.join(", ")
            ),
        });
    }
    file.warnings.splice(0..0, ignored.into_iter().map(|m| Warning::new(WarningKind::Ignored, m)));
    file.finish(name)
}

/// Parses a file. Keeps only faces of the objects and groups named in `nodes`; all if it is empty.
pub(super) fn parse(
    bytes: &[u8],
    name: &str,
    nodes: &[String],
    threads: usize,
) -> Result<ObjFile, MeshError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let bytes = line_feeds(bytes, name)?;
    let parts = split(&bytes);
    let chunks = read_parts(&parts, threads);
    let failed = |f: Fail| MeshError::damaged(name, SceneFormat::Obj, Place::Line(f.line), f.problem);
    check(&parts, &chunks).map_err(failed)?;
    merge::merge(chunks, name, nodes)
}

/// Replaces carriage returns by line feeds in a file that uses only carriage returns.
fn line_feeds<'a>(bytes: &'a [u8], name: &str) -> Result<Cow<'a, [u8]>, MeshError> {
    // Other files have a line feed near the start, so the search is short.
    let start = &bytes[..bytes.len().min(PART)];
    if start.contains(&b'\n') || !start.contains(&b'\r') || bytes.contains(&b'\n') {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut copy = Vec::new();
    reserve(&mut copy, bytes.len(), name)?;
    copy.extend(bytes.iter().map(|&b| if b == b'\r' { b'\n' } else { b }));
    Ok(Cow::Owned(copy))
}

/// Cuts a text at ends of lines, but not after a backslash, which continues the line.
fn split(bytes: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = bytes;
    while rest.len() > PART {
        let mut at = PART;
        loop {
            at += rest[at..].iter().position(|&b| b == b'\n').map_or(rest.len() - at, |n| n + 1);
            let line = rest[..at].strip_suffix(b"\n").unwrap_or(&rest[..at]);
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if at == rest.len() || !line.ends_with(b"\\") {
                break;
            }
        }
        let (part, after) = rest.split_at(at);
        parts.push(part);
        rest = after;
    }
    parts.push(rest);
    parts
}

fn read_parts<'a>(parts: &[&'a [u8]], threads: usize) -> Vec<Chunk<'a>> {
    let available = turner_host::thread::available();
    let threads = if threads == 0 { available } else { threads }.min(parts.len());
    if threads < 2 {
        return parts.iter().map(|part| chunk::read(part, None)).collect();
    }
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(part) = parts.get(i) else { return done };
            done.push((i, chunk::read(part, None)));
        }
    };
    let mut all = turner_host::thread::scope(|scope| {
        let helpers: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        for helper in helpers {
            all.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        all
    });
    all.sort_unstable_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, chunk)| chunk).collect()
}

/// Finds the first error of the file; its chunk is parsed again with the totals before it.
fn check(parts: &[&[u8]], chunks: &[Chunk<'_>]) -> Result<(), Fail> {
    let mut totals = Before::default();
    for (part, chunk) in parts.iter().zip(chunks) {
        let reaches = |k: usize| totals.counts[k] as i64 + chunk.reach[k].1 >= 0;
        if chunk.fail.is_some() || !(0..3).all(reaches) {
            return Err(again(part, &totals));
        }
        totals = after(&totals, chunk);
    }
    // Faces may refer to vertices defined later, but these must exist.
    let counts = totals.counts;
    for (kind, &count) in counts.iter().enumerate() {
        let largest = chunks.iter().map(|c| c.reach[kind].0).max().unwrap_or(0);
        if largest <= count as i64 {
            continue;
        }
        let mut before = Before { too_large: Some((kind, largest, count)), ..Before::default() };
        for (part, chunk) in parts.iter().zip(chunks) {
            if chunk.reach[kind].0 == largest {
                return Err(again(part, &before));
            }
            before = after(&before, chunk);
        }
    }
    Ok(())
}

fn after(before: &Before, chunk: &Chunk<'_>) -> Before {
    let more = [chunk.positions.len(), chunk.uvs.len(), chunk.normals.len()];
    Before {
        lines: before.lines + chunk.lines,
        faces: before.faces + chunk.faces,
        counts: [0, 1, 2].map(|k| before.counts[k] + more[k]),
        ..*before
    }
}

fn again(part: &[u8], before: &Before) -> Fail {
    let unknown = || Fail { line: before.lines + 1, problem: "a malformed statement".to_owned() };
    chunk::read(part, Some(before)).fail.unwrap_or_else(unknown)
}

impl ObjFile {
    /// Builds the mesh.
    pub(super) fn finish(self, name: &str) -> Result<ReadMesh, MeshError> {
        let ObjFile {
            mut attributes,
            mut corners,
            smoothing,
            polygons,
            face_materials,
            material_names,
            mut warnings,
            ..
        } = self;
        // Attributes used only by faces that were dropped.
        for column in [&mut corners.uvs, &mut corners.normals] {
            if column.as_flattened().iter().all(|&i| i == NONE) {
                *column = Vec::new();
            }
        }
        display_colors(&mut attributes, &mut warnings, name);
        complete_uvs(&mut attributes, &mut corners, &mut warnings, name)?;
        let some_normals = corners.normals.iter().any(|t| t.contains(&NONE));
        let none_but_smooth = corners.normals.is_empty() && smoothing.iter().any(|&s| s != 0);
        if some_normals || none_but_smooth {
            let missing = normals::complete(&mut attributes, &mut corners, &smoothing, name)?;
            if some_normals {
                let message =
                    "face vertices without a normal: the normal of their smoothing group or face is used";
                warnings.push(warning(WarningKind::Note, name, missing as u64, message));
            }
        }
        drop(smoothing);
        let polygons = polygons.finish(corners.positions.len(), name)?;
        let mesh = unify(attributes, corners, name)?;
        Ok(ReadMesh {
            mesh: MeshData { polygons, face_materials, material_names, ..mesh },
            warnings,
            texture: None,
        })
    }
}

/// Converts vertex colours that some programs write as display values from 0 to 255.
fn display_colors(attributes: &mut Attributes, warnings: &mut Vec<Warning>, name: &str) {
    let rgb = |c: &[f32; 4]| c[0].max(c[1]).max(c[2]);
    let largest = attributes.colors.iter().map(rgb).fold(0.0, f32::max);
    if !(largest > 1.0 && largest <= 255.0) {
        return;
    }
    // Vertices without a colour are white.
    for color in attributes.colors.iter_mut().filter(|c| **c != [1.0; 4]) {
        (0..3).for_each(|i| color[i] = Transfer::Srgb.decode(color[i] / 255.0));
    }
    let message = "vertex colours above 1: read as display values up to 255";
    warnings.push(warning(WarningKind::Approximated, name, 1, message));
}

/// Gives every corner a (u, v) if any corner has one.
fn complete_uvs(
    attributes: &mut Attributes,
    corners: &mut Corners,
    warnings: &mut Vec<Warning>,
    name: &str,
) -> Result<(), MeshError> {
    let lacking = corners.uvs.as_flattened().iter().filter(|&&i| i == NONE).count();
    if lacking == 0 {
        return Ok(());
    }
    reserve_some(&mut attributes.uvs, 1, name)?;
    attributes.uvs.push([0.0; 2]);
    let made_up = attributes.uvs.len() as u32 - 1;
    corners.uvs.as_flattened_mut().iter_mut().filter(|i| **i == NONE).for_each(|i| *i = made_up);
    let message = "face vertices without (u, v): read as (0, 0)";
    warnings.push(warning(WarningKind::Note, name, lacking as u64, message));
    Ok(())
}

/// Warnings about statements that are not rendered.
fn remarks(others: &Others, name: &str) -> impl Iterator<Item = Warning> {
    let all = [
        (others.points, "`p` elements (points) are ignored"),
        (others.lines, "`l` elements (lines) are ignored"),
        (others.thin, "faces with fewer than three vertices are ignored"),
        (others.free_form, "free-form curves and surfaces are ignored: export the model as polygons"),
        (others.unknown, "unknown statements are ignored"),
    ];
    let all =
        all.map(|(count, message)| (count > 0).then(|| warning(WarningKind::Ignored, name, count, message)));
    all.into_iter().flatten()
}
