//! Prediction of texture coordinates: the triangle of the entry has the same shape in texture space as in space, up
//! to its size (Isenburg and Snoeyink 2003). All in integers.

use super::super::corners::at;
use super::super::rans::Decisions;
use super::super::reader::Reader;
use super::super::{Read, Room, damaged};
use super::transforms::Wrap;
use super::{Neighbours, each};

/// Restores the entries.
pub(super) fn restore(
    list: &mut [i32],
    mesh: &Neighbours<'_>,
    reader: &mut Reader<'_>,
    room: Room<'_>,
) -> Read<()> {
    let count = reader.u32()? as usize;
    if count > mesh.order.corners.len() {
        return damaged(&format!("has {count} orientations for {} entries", mesh.order.corners.len()));
    }
    // Of the last triangle first: whether the entry lies on the left of the edge that it faces. Stored as changes.
    let mut orientations = room.list(count)?;
    let mut changes = Decisions::read(reader)?;
    let mut on_left = true;
    for _ in 0..count {
        on_left ^= !changes.decide();
        orientations.push(on_left);
    }
    let wrap = Wrap::read(reader)?;
    let mut missing = false;
    let predict = |i: usize, done: &[i32], predicted: &mut [i32]| {
        let orientation = || {
            let next = orientations.pop();
            missing |= next.is_none();
            next.unwrap_or(true)
        };
        predicted.copy_from_slice(&uv(i, done, mesh, orientation));
    };
    each(list, 2, predict, |p, e| wrap.restore(p, e));
    if missing {
        return damaged("has fewer orientations than triangles");
    }
    Ok(())
}

/// Predicts the texture coordinates of entry `i`.
fn uv(i: usize, done: &[i32], mesh: &Neighbours<'_>, orientation: impl FnOnce() -> bool) -> [i32; 2] {
    let entry = |i: usize| done.as_chunks().0.get(i).copied();
    let [a, b] = mesh.sides(at(&mesh.order.corners, i as u32));
    let (Some(uv_a), uv_b) = (entry(a), entry(b)) else {
        // The entry before.
        return i.checked_sub(1).and_then(entry).unwrap_or_default();
    };
    let Some(uv_b) = uv_b.filter(|uv_b| *uv_b != uv_a) else { return uv_a };
    let [tip, a, b] = [i, a, b].map(|entry| mesh.position(entry));
    let edge = subtract(b, a);
    let squared = dot(edge, edge);
    if squared == 0 {
        return uv_a;
    }
    // All texture coordinates are scaled by the squared length of the edge.
    let along = dot(subtract(tip, a), edge);
    let (uv_a, uv_b) = (uv_a.map(i64::from), uv_b.map(i64::from));
    let uv_edge = [uv_b[0] - uv_a[0], uv_b[1] - uv_a[1]];
    let foot: [i64; 3] =
        std::array::from_fn(|k| a[k].wrapping_add(along.wrapping_mul(edge[k]).wrapping_div(squared)));
    let height = subtract(tip, foot);
    let height = (dot(height, height) as u64).wrapping_mul(squared as u64).isqrt() as i64;
    let height = if orientation() { height } else { height.wrapping_neg() };
    let across = [uv_edge[1], -uv_edge[0]];
    std::array::from_fn(|k| {
        let base = uv_a[k].wrapping_mul(squared).wrapping_add(along.wrapping_mul(uv_edge[k]));
        base.wrapping_add(across[k].wrapping_mul(height)).wrapping_div(squared) as i32
    })
}

fn subtract(a: [i64; 3], b: [i64; 3]) -> [i64; 3] {
    std::array::from_fn(|k| a[k].wrapping_sub(b[k]))
}

fn dot(a: [i64; 3], b: [i64; 3]) -> i64 {
    a.iter().zip(b).fold(0, |sum, (a, b)| sum.wrapping_add(a.wrapping_mul(b)))
}
