//! Lines as thin tubes. The specification gives lines a width of one pixel (glTF 2.0 §3.7.2.1), which rays cannot
//! hit.

use turner::math::{DVec3, Frame};
use turner::schema::MeshData;

use super::budget::Budget;
use super::fault::Outcome;

/// Radius of a tube, as a fraction of the longest side of the bounding box of all lines.
const TUBE: f64 = 1.0 / 1000.0;
/// Sides of a tube.
const SIDES: usize = 6;

/// The longest side of the bounding box of the given vertices, without non-finite ones.
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

/// Appends a copy of vertex `v` of `source`, at position `p`.
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

/// One tube per line; none for lines of length 0.
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
            // Corners of a regular hexagon, 60 degrees apart.
            let (s, c) = [(0.0, 1.0), (H, 0.5), (H, -0.5), (0.0, -1.0), (-H, -0.5), (-H, 0.5)][side];
            let outward = frame.to_world(DVec3::new(c, s, 0.0));
            for (v, end) in line.iter().zip(ends) {
                put(&mut out, source, *v as usize, end + radius * outward, outward);
            }
        }
        for side in 0..SIDES as u32 {
            let (a, b) = (first + 2 * side, first + 2 * ((side + 1) % SIDES as u32));
            out.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    Ok(out)
}

/// √3 / 2.
const H: f64 = 0.866_025_403_784_438_6;

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that every face points away from `inside`.
    fn faces_outwards(mesh: &MeshData, inside: impl Fn(DVec3) -> DVec3) {
        mesh.check().unwrap();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
            let center = (a + b + c) / 3.0;
            assert!((b - a).cross(c - a).dot(center - inside(center)) > 0.0);
        }
    }

    #[test]
    fn tubes_are_closed_around_their_lines() {
        let source = MeshData {
            positions: vec![[0.0; 3], [10.0, 0.0, 0.0]],
            colors: vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]],
            ..MeshData::default()
        };
        let budget = Budget::of_file(0);
        let mesh = tubes(&source, &[[0, 1], [1, 1]], &budget, "").unwrap();
        assert_eq!(mesh.triangles.len(), 12);
        faces_outwards(&mesh, |p| DVec3::new(p.x, 0.0, 0.0));
    }
}
