//! Normals for OBJ faces without normals.
//!
//! A corner of a face in a smoothing group gets the sum of the normals of the group's triangles at that position,
//! weighted by each triangle's angle there. With these weights the result does not depend on how polygons are
//! triangulated (Thürmer and Wüthrich 1998, "Computing vertex normals from polygonal facets"). Other faces get the
//! normal of their plane.

use super::chunk::NONE;
use crate::mesh::MeshError;
use crate::mesh::corners::{Attributes, Corners};
use crate::mesh::error::{push, reserve, reserve_some};
use std::collections::HashMap;
use turner::math::elementary::acos;

/// Replaces [`NONE`] by computed normals. `groups` are the smoothing groups of the triangles (0 is none), or empty.
/// Returns the number of corners that had no normal.
pub(super) fn complete(
    attributes: &mut Attributes,
    corners: &mut Corners,
    groups: &[u32],
    name: &str,
) -> Result<usize, MeshError> {
    if corners.normals.is_empty() {
        reserve(&mut corners.normals, corners.positions.len(), name)?;
        corners.normals.resize(corners.positions.len(), [NONE; 3]);
    }
    let Attributes { positions, normals, .. } = attributes;
    let given = normals.len();
    // The normal index per position and group: the first group of a position in a list, further ones in a map.
    let mut first: Vec<(u32, u32)> = Vec::new();
    if !groups.is_empty() {
        reserve(&mut first, positions.len(), name)?;
        first.resize(positions.len(), (0, NONE));
    }
    let mut more: HashMap<(u32, u32), u32> = HashMap::new();
    let mut sums: Vec<[f64; 3]> = Vec::new();
    let mut missing = 0;
    for (i, (triangle, named)) in corners.positions.iter().zip(&mut corners.normals).enumerate() {
        if !named.contains(&NONE) {
            continue;
        }
        missing += named.iter().filter(|&&n| n == NONE).count();
        let area = area_normal(triangle.map(|p| positions[p as usize]));
        let group = groups.get(i).copied().unwrap_or(0);
        if group == 0 {
            let new = normals.len() as u32;
            push(normals, unit(area), name)?;
            named.iter_mut().filter(|n| **n == NONE).for_each(|n| *n = new);
            continue;
        }
        let direction = unit(area).map(f64::from);
        let angles = angles(triangle.map(|p| positions[p as usize]));
        for ((&p, slot), angle) in triangle.iter().zip(named).zip(angles).filter(|((_, n), _)| **n == NONE) {
            let known = match &mut first[p as usize] {
                (g, n) if *n == NONE || *g == group => {
                    *g = group;
                    n
                }
                _ => more.entry((p, group)).or_insert(NONE),
            };
            if *known == NONE {
                // A placeholder until the sum is complete.
                *known = normals.len() as u32;
                push(normals, [0.0; 3], name)?;
            }
            let sum = (*known as usize) - given;
            if sums.len() <= sum {
                let more = sum + 1 - sums.len();
                reserve_some(&mut sums, more, name)?;
                sums.resize(sum + 1, [0.0; 3]);
            }
            (0..3).for_each(|k| sums[sum][k] += angle * direction[k]);
            *slot = *known;
        }
    }
    for (normal, sum) in normals[given..].iter_mut().zip(&sums) {
        if *normal == [0.0; 3] {
            *normal = unit(*sum);
        }
    }
    Ok(missing)
}

/// The normal of a triangle, with twice its area as length.
fn area_normal([a, b, c]: [[f32; 3]; 3]) -> [f64; 3] {
    let side = |to: [f32; 3]| [0, 1, 2].map(|i| f64::from(to[i]) - f64::from(a[i]));
    let (u, v) = (side(b), side(c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// The angles of a triangle at its corners; 0 if degenerate.
fn angles(corners: [[f32; 3]; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let [a, b, c] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
        let side = |to: [f32; 3]| [0, 1, 2].map(|k| f64::from(to[k]) - f64::from(a[k]));
        let (u, v) = (side(b), side(c));
        let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        let cos = dot(u, v) / (dot(u, u) * dot(v, v)).sqrt();
        if cos.is_finite() { acos(cos.clamp(-1.0, 1.0)) } else { 0.0 }
    })
}

/// Normalises a vector; zero if it has no length.
fn unit(n: [f64; 3]) -> [f32; 3] {
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 && length.is_finite() { n.map(|x| (x / length) as f32) } else { [0.0; 3] }
}
