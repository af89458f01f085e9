//! Loop subdivision surfaces (Loop 1987, "Smooth subdivision surfaces based on triangles"; limit: Hoppe et al. 1994).
//!
//! Each step splits every triangle into four. It adds a vertex on each edge and moves the old vertices, both by
//! weighted means of their neighbours:
//!
//! ```text
//!            1/8                     β       β
//!           /   \                     \     /
//!        3/8 ─●─ 3/8             β ─── 1 − nβ ─── β       border: edge 1/2 ─●─ 1/2, vertex 1/8 ─ 3/4 ─ 1/8
//!           \   /                     /     \
//!            1/8                     β       β
//!      new vertex of an edge      vertex with n neighbours: β = 3/16 for n = 3, else 3/(8n)
//! ```
//!
//! The means converge to a smooth limit surface. After the last step each vertex moves onto it with the weights
//! 1 − nγ and γ = 1/(n + 3/(8β)), at a border 3/5 and 1/5. The normal there is the cross product of two
//! tangents: the sums of the n neighbours in cyclic order, weighted by cos(2πj/n) and sin(2πj/n). Vertices
//! without a closed ring of faces use the sum of the faces' normals. The cost grows with 4 to the power of the
//! levels.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use turner::math::DVec3;
use turner::math::elementary::{cos, sin};
use turner::schema::MeshData;

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::light_parts::LightParts;
use super::mesh::corners;
use super::{Made, orient};

/// Most levels: a triangle becomes 4^10.
const MAX_LEVELS: i32 = 10;

/// `loopsubdiv`.
pub(super) fn surface(scene: &mut Assembly<'_>, state: &State, params: &mut Params) -> Result<Made, Fault> {
    let levels = params.integer("levels").or_else(|| params.integer("nlevels")).unwrap_or(3);
    let points = params.take_triples("P");
    let mut triangles: Vec<[u32; 3]> = corners(params, "indices", points.len())?;
    params.pass(&["scheme"]);
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut points: Vec<DVec3> = points.into_iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    for _ in 0..levels.clamp(0, MAX_LEVELS) {
        scene.divide(points.len() as u64 + 3 * triangles.len() as u64, params.place)?;
        (points, triangles) = divide(&points, &triangles);
    }
    let (positions, normals) = limit(&points, &triangles);
    let single = |v: &DVec3| v.as_vec3().to_array();
    let mut data = MeshData {
        positions: positions.iter().map(single).collect(),
        normals: normals.iter().map(single).collect(),
        triangles,
        ..MeshData::default()
    };
    // The faces define the orientation; the normals follow.
    orient(&mut data, state.reverse);
    Ok(Made::Mesh(data, LightParts::Triangles))
}

/// An edge, the lower index first.
type Edge = (u32, u32);

fn edge(a: u32, b: u32) -> Edge {
    (a.min(b), a.max(b))
}

/// The vertices opposite each edge: two inside the surface, one at its border. Of more, the first two count.
fn opposites(triangles: &[[u32; 3]]) -> BTreeMap<Edge, [Option<u32>; 2]> {
    let mut edges: BTreeMap<Edge, [Option<u32>; 2]> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (from, to, other) in [(a, b, c), (b, c, a), (c, a, b)] {
            let slots = edges.entry(edge(from, to)).or_default();
            if let Some(slot) = slots.iter_mut().find(|s| s.is_none()) {
                *slot = Some(other);
            }
        }
    }
    edges
}

/// Neighbours of each vertex: all of them, and those along the border.
struct Neighbours {
    all: Vec<Vec<u32>>,
    border: Vec<Vec<u32>>,
}

fn neighbours(count: usize, edges: &BTreeMap<Edge, [Option<u32>; 2]>) -> Neighbours {
    let mut n = Neighbours { all: vec![Vec::new(); count], border: vec![Vec::new(); count] };
    for (&(a, b), opposite) in edges {
        for (from, to) in [(a, b), (b, a)] {
            if let Some(list) = n.all.get_mut(from as usize) {
                list.push(to);
            }
            if opposite[1].is_none()
                && let Some(list) = n.border.get_mut(from as usize)
            {
                list.push(to);
            }
        }
    }
    n
}

fn at(points: &[DVec3], i: u32) -> DVec3 {
    points.get(i as usize).copied().unwrap_or_default()
}

fn sum(points: &[DVec3], list: &[u32]) -> DVec3 {
    list.iter().fold(DVec3::ZERO, |s, i| s + at(points, *i))
}

/// One step: each triangle becomes four.
fn divide(points: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let edges = opposites(triangles);
    let near = neighbours(points.len(), &edges);
    let mut new: Vec<DVec3> = points
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let (all, border) =
                (near.all.get(i).map_or(&[][..], |v| v), near.border.get(i).map_or(&[][..], |v| v));
            if border.len() == 2 {
                *p * 0.75 + sum(points, border) * 0.125
            } else if all.is_empty() || !border.is_empty() {
                *p
            } else {
                let beta = if all.len() == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * all.len() as f64) };
                *p * (1.0 - all.len() as f64 * beta) + sum(points, all) * beta
            }
        })
        .collect();
    let mut middles: BTreeMap<Edge, u32> = BTreeMap::new();
    for (&(a, b), opposite) in &edges {
        let ends = at(points, a) + at(points, b);
        let middle = match opposite {
            [Some(c), Some(d)] => ends * 0.375 + (at(points, *c) + at(points, *d)) * 0.125,
            _ => ends * 0.5,
        };
        middles.insert((a, b), new.len() as u32);
        new.push(middle);
    }
    let mut out = Vec::with_capacity(triangles.len() * 4);
    for &[a, b, c] in triangles {
        let middle = |x, y| middles.get(&edge(x, y)).copied().unwrap_or_default();
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        out.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    (new, out)
}

/// The limit positions of the vertices, and the normals there.
fn limit(points: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<DVec3>) {
    let edges = opposites(triangles);
    let near = neighbours(points.len(), &edges);
    let positions: Vec<DVec3> = points
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let (all, border) =
                (near.all.get(i).map_or(&[][..], |v| v), near.border.get(i).map_or(&[][..], |v| v));
            if border.len() == 2 {
                *p * 0.6 + sum(points, border) * 0.2
            } else if all.is_empty() || !border.is_empty() {
                *p
            } else {
                let n = all.len() as f64;
                let beta = if all.len() == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * n) };
                let gamma = 1.0 / (n + 3.0 / (8.0 * beta));
                *p * (1.0 - n * gamma) + sum(points, all) * gamma
            }
        })
        .collect();
    // Tangents are sums over the ring of neighbours in cyclic order; without a ring the faces' normals are used.
    let mut faces = vec![DVec3::ZERO; points.len()];
    let mut next: Vec<Vec<(u32, u32)>> = vec![Vec::new(); points.len()];
    for &[a, b, c] in triangles {
        let normal = (at(&positions, b) - at(&positions, a)).cross(at(&positions, c) - at(&positions, a));
        for (v, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            if let (Some(f), Some(n)) = (faces.get_mut(v as usize), next.get_mut(v as usize)) {
                *f += normal;
                n.push((from, to));
            }
        }
    }
    let normals = faces
        .iter()
        .zip(&next)
        .map(|(face, steps)| {
            let ring = ring(steps);
            let n = ring.len() as f64;
            let (mut s, mut t) = (DVec3::ZERO, DVec3::ZERO);
            for (j, v) in ring.iter().enumerate() {
                let angle = TAU * j as f64 / n;
                s += at(points, *v) * cos(angle);
                t += at(points, *v) * sin(angle);
            }
            let normal = s.cross(t);
            let normal = if ring.is_empty() || normal.dot(*face) <= 0.0 { *face } else { normal };
            normal.normalize_or(DVec3::Z)
        })
        .collect();
    (positions, normals)
}

/// The neighbours of a vertex in cyclic order; empty unless the faces around it form a closed ring.
fn ring(steps: &[(u32, u32)]) -> Vec<u32> {
    let Some(&(first, mut at)) = steps.first() else { return Vec::new() };
    // For vertices of very many faces the faces' normals are as good.
    if steps.len() > 64 {
        return Vec::new();
    }
    let mut ring = vec![first];
    while at != first {
        ring.push(at);
        match steps.iter().find(|(from, _)| *from == at) {
            Some((_, to)) if ring.len() <= steps.len() => at = *to,
            _ => return Vec::new(),
        }
    }
    if ring.len() == steps.len() { ring } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octahedron.
    fn octahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let points = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        (points, faces.to_vec())
    }

    #[test]
    fn an_octahedron_becomes_round() {
        let (mut points, mut faces) = octahedron();
        let (exact, _) = limit(&points, &faces);
        for _ in 0..5 {
            (points, faces) = divide(&points, &faces);
        }
        assert_eq!(faces.len(), 8 << 10);
        assert_eq!(points.len(), faces.len() / 2 + 2);
        let (limits, normals) = limit(&points, &faces);
        // Subdivision converges to the limit positions, and the normals point outwards.
        assert!((limits[0] - exact[0]).length() < 1e-9, "{} {}", limits[0], exact[0]);
        for (p, n) in limits.iter().zip(&normals) {
            assert!((n.length() - 1.0).abs() < 1e-9 && p.normalize().dot(*n) > 0.9, "{p} {n}");
        }
    }

    #[test]
    fn borders_stay_and_odd_meshes_do_no_harm() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let (divided, faces) = divide(&points, &[[0, 1, 2]]);
        assert_eq!((divided.len(), faces.len()), (6, 4));
        assert!(divided.iter().all(|p| p.z == 0.0));
        // Three faces at one edge, a repeated face, vertices without a face.
        let odd = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [0, 1, 2]];
        let points: Vec<DVec3> = (0..6).map(|i| DVec3::new(f64::from(i), f64::from(i * i), 1.0)).collect();
        let (points, faces) = divide(&points, &odd);
        let (p, n) = limit(&points, &faces);
        assert!(p.iter().chain(&n).all(|v| v.is_finite()));
    }
}
