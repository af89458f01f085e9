//! Prediction of normals in octahedral coordinates: by the entry before, or by the faces around.

use super::super::Read;
use super::super::corners::{at, next, previous};
use super::super::rans::Decisions;
use super::super::reader::Reader;
use super::Neighbours;
use super::transforms::Octahedron;

/// The sum of the absolute components of a predicted normal is at most about this.
const LONGEST: i64 = 1 << 29;

/// Restores entries that are predicted by the entry before.
pub(super) fn differences(list: &mut [i32], octahedron: Octahedron) {
    let mut last = [0, 0];
    for entry in list.as_chunks_mut().0 {
        *entry = octahedron.restore(last, *entry);
        last = *entry;
    }
}

/// Restores entries that are predicted by the normals of the faces around.
pub(super) fn from_faces(list: &mut [i32], mesh: &Neighbours<'_>, reader: &mut Reader<'_>) -> Read<()> {
    let octahedron = Octahedron::read(reader)?;
    let mut flips = Decisions::read(reader)?;
    for (i, entry) in list.as_chunks_mut().0.iter_mut().enumerate() {
        let normal = normal(at(&mesh.order.corners, i as u32), mesh);
        let predicted = octahedron.project(normal, flips.decide());
        *entry = octahedron.restore(predicted, *entry);
    }
    Ok(())
}

/// The normals of the faces around the vertex of a corner, weighted by their areas.
fn normal(corner: u32, mesh: &Neighbours<'_>) -> [i32; 3] {
    let center = mesh.position(mesh.entry(corner));
    let edge = |corner: u32| {
        let p = mesh.position(mesh.entry(corner));
        [0, 1, 2].map(|k| p[k] - center[k])
    };
    let mut sum = [0i64; 3];
    for corner in mesh.table.around(corner) {
        let (a, b) = (edge(next(corner)), edge(previous(corner)));
        let cross = |j: usize, k: usize| a[j].wrapping_mul(b[k]).wrapping_sub(a[k].wrapping_mul(b[j]));
        for (sum, part) in sum.iter_mut().zip([cross(1, 2), cross(2, 0), cross(0, 1)]) {
            *sum = sum.wrapping_add(part);
        }
    }
    let length = sum.iter().fold(0i64, |length, v| length.saturating_add(v.saturating_abs()));
    let divisor = if length > LONGEST { length / LONGEST } else { 1 };
    sum.map(|v| (v / divisor) as i32)
}
