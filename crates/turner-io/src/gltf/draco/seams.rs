//! Connectivity of attributes: across a seam, an attribute has different values at the same vertex. Points are the
//! vertices with all their attributes.

use super::corners::{Corners, NONE, at, next, put};
use super::rans::Decisions;
use super::{Read, Room, damaged, traversal};

/// Reads the seams of the attributes and builds their corner tables.
pub(super) fn read(decisions: &mut [Decisions<'_>], corners: &Corners, room: Room<'_>) -> Read<Vec<Corners>> {
    let mut seamed = Vec::with_capacity(decisions.len());
    for _ in 0..decisions.len() {
        let mut opposite = room.list(corners.opposite.len())?;
        opposite.extend_from_slice(&corners.opposite);
        seamed.push(Corners { opposite, ..Corners::default() });
    }
    traversal::read_seams(decisions, corners, |a, corner| {
        if let Some(table) = seamed.get_mut(a) {
            put(&mut table.opposite, corner, NONE);
        }
    });
    for table in &mut seamed {
        number_vertices(table, corners, room)?;
    }
    Ok(seamed)
}

/// Numbers the vertices of an attribute: one for each part of the corners around a vertex between two seams.
fn number_vertices(table: &mut Corners, corners: &Corners, room: Room<'_>) -> Read<()> {
    table.vertex = room.filled(corners.vertex.len(), NONE)?;
    let mut leftmost = room.list(corners.vertex.len())?;
    for &start in corners.leftmost.iter().filter(|corner| **corner != NONE) {
        let mut first = start;
        loop {
            let left = table.swing_left(first);
            if left == NONE {
                break;
            }
            if left == start {
                first = start;
                break;
            }
            first = left;
        }
        let mut corner = first;
        loop {
            if corner == first || table.opposite(next(corner)) == NONE {
                leftmost.push(corner);
            }
            put(&mut table.vertex, corner, leftmost.len() as u32 - 1);
            corner = corners.swing_right(corner);
            if corner == NONE || corner == first {
                break;
            }
        }
    }
    table.leftmost = leftmost;
    Ok(())
}

/// Numbers the points: one for each part of the corners around a vertex without any seam. Returns their number and
/// the points of the faces. `inner` tells for each vertex whether it is inside the mesh.
pub(super) fn points(
    corners: &Corners,
    seamed: &[Corners],
    inner: &[bool],
    room: Room<'_>,
) -> Read<(usize, Vec<[u32; 3]>)> {
    let mut faces = room.filled(corners.vertex.len() / 3, [NONE; 3])?;
    let of_corner = faces.as_flattened_mut();
    let mut count = 0u32;
    for (vertex, &leftmost) in corners.leftmost.iter().enumerate() {
        if leftmost == NONE {
            continue;
        }
        let mut first = leftmost;
        if inner.get(vertex).copied().unwrap_or(false) {
            first = first_seam(corners, seamed, leftmost).unwrap_or(leftmost);
        }
        let mut corner = first;
        let mut before = NONE;
        loop {
            let differs = |table: &Corners| table.vertex(corner) != table.vertex(before);
            if before == NONE || seamed.iter().any(differs) {
                count += 1;
            }
            put(of_corner, corner, count - 1);
            before = corner;
            corner = corners.swing_right(corner);
            if corner == NONE || corner == first {
                break;
            }
        }
    }
    if of_corner.contains(&NONE) {
        return damaged("has a corner without a point");
    }
    Ok((count as usize, faces))
}

/// The first corner to the right of which an attribute has another vertex than at `start`.
fn first_seam(corners: &Corners, seamed: &[Corners], start: u32) -> Option<u32> {
    seamed.iter().find_map(|table| {
        let vertex = table.vertex(start);
        // A vertex whose corners are a ring without seams has none to find.
        if table.swing_left(at(&table.leftmost, vertex)) != NONE {
            return None;
        }
        let mut corner = corners.swing_right(start);
        while corner != start && corner != NONE {
            if table.vertex(corner) != vertex {
                return Some(corner);
            }
            corner = corners.swing_right(corner);
        }
        None
    })
}
