//! Subdivision surfaces: scheme, creases and how far they are divided.

use std::collections::BTreeSet;

use turner::schema::WarningKind;
use turner::shape::{Subdivision, SubdivisionScheme};

use super::meshes::Made;
use super::primvars::{integers, numbers};
use super::scene::Scene;
use super::stage::Prim;
use super::value::{Read, Value};

/// Levels of small meshes; larger ones have fewer.
const LEVELS: u32 = 4;
/// Triangles of a mesh from which one level is enough, and the most that it becomes.
const ENOUGH: u64 = 1 << 17;
const MOST: u64 = 1 << 20;

/// The scheme of a mesh, if it is authored. Without one the schema says Catmull-Clark, but files of polygons often lack
/// the attribute.
pub(super) fn scheme(scene: &Scene<'_>, prim: &Prim) -> Read<Option<SubdivisionScheme>> {
    let word = scene.stage.value(prim, "subdivisionScheme")?;
    Ok(match word.as_ref().and_then(Value::text) {
        Some("catmullClark") => Some(SubdivisionScheme::CatmullClark),
        Some("loop") => Some(SubdivisionScheme::Loop),
        _ => None,
    })
}

/// The subdivision of a mesh; `None`, which is reported, for one that is too large.
pub(super) fn of(
    scene: &mut Scene<'_>,
    prim: &Prim,
    made: &Made,
    scheme: SubdivisionScheme,
) -> Read<Option<Subdivision>> {
    let scheme = match scheme {
        SubdivisionScheme::Loop if !made.mesh.polygons.is_empty() => SubdivisionScheme::CatmullClark,
        scheme => scheme,
    };
    let limit = MOST.min(scene.divisions);
    let triangles = 3 * made.mesh.triangles.len() as u64;
    let fits = |n: &u32| triangles << (2 * n) <= if *n > 1 { ENOUGH.min(limit) } else { limit };
    let Some(levels) = (1..=LEVELS).rev().find(fits) else {
        let message = "a subdivision surface of many faces: its polygons are shown as they are";
        scene.warn(WarningKind::Approximated, message);
        return Ok(None);
    };
    scene.divisions -= triangles << (2 * levels);
    let stage = scene.stage;
    let mut by = Subdivision::new(scheme, levels);
    let boundary = stage.value(prim, "interpolateBoundary")?;
    by.keep_corners = !matches!(boundary.as_ref().and_then(Value::text), Some("edgeOnly" | "none"));
    let vertex = |point: i64| {
        let vertex = usize::try_from(point).ok().and_then(|i| made.of_points.get(i)).copied();
        vertex.filter(|v| *v != u32::MAX)
    };
    let points = integers(stage.value(prim, "creaseIndices")?);
    let lengths = integers(stage.value(prim, "creaseLengths")?);
    let sharpness = numbers(stage.value(prim, "creaseSharpnesses")?.as_ref());
    let edges = edges(made, !points.is_empty());
    let (mut first, mut edge, mut omitted) = (0_usize, 0_usize, false);
    for (crease, length) in lengths.iter().enumerate() {
        let length = usize::try_from(*length).unwrap_or(0);
        let Some(list) = points.get(first..first.saturating_add(length)) else { break };
        for pair in list.windows(2) {
            // One sharpness per crease, or one per edge.
            let at = if sharpness.len() == lengths.len() { crease } else { edge };
            edge += 1;
            let s = sharpness.get(at).copied().filter(|s| *s > 0.0);
            match (vertex(pair[0]), vertex(pair[1]), s) {
                (Some(a), Some(b), Some(s)) if edges.contains(&ends(made, a, b)) => {
                    by.creases.push([f64::from(a), f64::from(b), s.min(10.0)]);
                }
                (_, _, None) => {}
                _ => omitted = true,
            }
        }
        first += length;
    }
    let corners = integers(stage.value(prim, "cornerIndices")?);
    let sharpness = numbers(stage.value(prim, "cornerSharpnesses")?.as_ref());
    for (point, s) in corners.iter().zip(sharpness) {
        match vertex(*point) {
            Some(v) if s > 0.0 => by.creases.push([f64::from(v), f64::from(v), s.min(10.0)]),
            _ => {}
        }
    }
    if omitted {
        scene.warn(WarningKind::Doubtful, "creases that are no edges of their mesh");
    }
    Ok(Some(by))
}

/// Two ends of an edge by their positions: vertices at one position are one vertex.
fn ends(made: &Made, a: u32, b: u32) -> [[u32; 3]; 2] {
    let position =
        |v: u32| made.mesh.positions.get(v as usize).copied().unwrap_or_default().map(f32::to_bits);
    let (a, b) = (position(a), position(b));
    if a < b { [a, b] } else { [b, a] }
}

/// The edges of the polygons.
fn edges(made: &Made, is_needed: bool) -> BTreeSet<[[u32; 3]; 2]> {
    let mut edges = BTreeSet::new();
    if !is_needed {
        return edges;
    }
    let list: Vec<Vec<u32>> = match made.mesh.fans() {
        Some(fans) if !made.mesh.polygons.is_empty() => fans,
        _ => made.mesh.triangles.iter().map(|t| t.to_vec()).collect(),
    };
    for polygon in list {
        let positions: BTreeSet<_> = polygon.iter().map(|v| ends(made, *v, *v)).collect();
        if positions.len() < polygon.len() {
            // Subdivision omits faces that have a position twice.
            continue;
        }
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            edges.insert(ends(made, *a, b));
        }
    }
    edges
}
