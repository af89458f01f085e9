//! Points and lines as surfaces: small balls and thin tubes. The specification gives them the width of a pixel
//! (glTF 2.0 §3.7.2.1), which a ray cannot meet.

use super::budget::Budget;
use super::fault::Outcome;
use turner::math::{DVec3, Frame};
use turner::shape::mesh::MeshData;

/// Radius of a ball, as a share of the longest side of the box around all points.
const BALL: f64 = 1.0 / 400.0;
/// Radius of a tube, likewise.
const TUBE: f64 = 1.0 / 1000.0;
/// Up to so many points are round seen near by; more are octahedra.
const MANY_POINTS: usize = 10_000;
/// Sides of a tube.
const SIDES: usize = 6;

/// Corners and triangles of an octahedron with its faces split into four `levels` times, on the unit sphere.
fn ball(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut corners = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let mut middle = |a: u32, b: u32| {
                    corners.push((corners[a as usize] + corners[b as usize]).normalize());
                    corners.len() as u32 - 1
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (corners, triangles)
}

/// The longest side of the box around the named vertices that are finite.
fn extent(source: &MeshData, vertices: impl Iterator<Item = u32>) -> f64 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for v in vertices {
        let p = DVec3::from(source.positions[v as usize].map(f64::from));
        if p.is_finite() {
            (min, max) = (min.min(p), max.max(p));
        }
    }
    let side = (max - min).max_element();
    if side > 0.0 && side.is_finite() { side } else { 1.0 }
}

/// Copies the vertex `v` of `source` to `p`.
fn put(out: &mut MeshData, source: &MeshData, v: usize, p: DVec3, normal: DVec3) {
    out.positions.push(p.as_vec3().to_array());
    out.normals.push(normal.as_vec3().to_array());
    if let Some(color) = source.colors.get(v) {
        out.colors.push(*color);
    }
    if let Some(uv) = source.uvs.get(v) {
        out.uvs.push(*uv);
    }
}

/// A ball for each of the named vertices.
pub(super) fn balls(source: &MeshData, points: &[u32], budget: &Budget, pointer: &str) -> Outcome<MeshData> {
    let (corners, triangles) = ball(if points.len() > MANY_POINTS { 0 } else { 2 });
    budget.take(points.len(), 48 * corners.len() + 12 * triangles.len(), pointer)?;
    let radius = BALL * extent(source, points.iter().copied());
    let mut out = MeshData::default();
    for &point in points {
        let first = out.positions.len() as u32;
        let center = DVec3::from(source.positions[point as usize].map(f64::from));
        for corner in &corners {
            put(&mut out, source, point as usize, center + radius * *corner, *corner);
        }
        out.triangles.extend(triangles.iter().map(|t| t.map(|v| first + v)));
    }
    Ok(out)
}

/// A tube for each line; none for one without length.
pub(super) fn tubes(
    source: &MeshData,
    lines: &[[u32; 2]],
    budget: &Budget,
    pointer: &str,
) -> Outcome<MeshData> {
    budget.take(lines.len(), 48 * 2 * SIDES + 12 * 2 * SIDES, pointer)?;
    let radius = TUBE * extent(source, lines.as_flattened().iter().copied());
    let mut out = MeshData::default();
    for line in lines {
        let ends = line.map(|v| DVec3::from(source.positions[v as usize].map(f64::from)));
        let Some(axis) = (ends[1] - ends[0]).try_normalize() else { continue };
        let frame = Frame::from_z(axis);
        let first = out.positions.len() as u32;
        for side in 0..SIDES {
            // Corners of a regular hexagon: 60 degrees apart.
            let (s, c) = [(0.0, 1.0), (H, 0.5), (H, -0.5), (0.0, -1.0), (-H, -0.5), (-H, 0.5)][side];
            let out_wards = frame.to_world(DVec3::new(c, s, 0.0));
            for (v, end) in line.iter().zip(ends) {
                put(&mut out, source, *v as usize, end + radius * out_wards, out_wards);
            }
        }
        for side in 0..SIDES as u32 {
            let (a, b) = (first + 2 * side, first + 2 * ((side + 1) % SIDES as u32));
            out.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    Ok(out)
}

/// Half the square root of 3.
const H: f64 = 0.866_025_403_784_438_6;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every face looks away from `inside`.
    fn faces_outwards(mesh: &MeshData, inside: impl Fn(DVec3) -> DVec3) {
        mesh.check().unwrap();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
            let middle = (a + b + c) / 3.0;
            assert!((b - a).cross(c - a).dot(middle - inside(middle)) > 0.0);
        }
    }

    #[test]
    fn balls_and_tubes_are_closed_around_their_vertices() {
        let source = MeshData {
            positions: vec![[0.0; 3], [10.0, 0.0, 0.0]],
            colors: vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]],
            ..MeshData::default()
        };
        let budget = Budget::of_file(0);
        let mesh = balls(&source, &[1], &budget, "").unwrap();
        faces_outwards(&mesh, |_| DVec3::new(10.0, 0.0, 0.0));
        assert!(mesh.colors.iter().all(|c| *c == source.colors[1]));
        let mesh = tubes(&source, &[[0, 1], [1, 1]], &budget, "").unwrap();
        assert_eq!(mesh.triangles.len(), 12);
        faces_outwards(&mesh, |p| DVec3::new(p.x, 0.0, 0.0));
    }
}
