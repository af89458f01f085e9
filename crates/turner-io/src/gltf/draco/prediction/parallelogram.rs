//! Prediction by parallelograms (Touma and Gotsman 1998): beyond an edge, a triangle is completed to a
//! parallelogram.

use super::super::rans::Decisions;
use super::super::reader::Reader;
use super::super::{Read, Room, damaged};
use super::transforms::Wrap;
use super::{Neighbours, before, each};

/// Most parallelograms of an entry.
const MOST: usize = 4;

/// Completes the triangle across the edge that a corner faces, if its entries are among those `done`.
#[inline]
fn complete(mesh: &Neighbours<'_>, corner: u32, done: &[i32], predicted: &mut [i32]) -> bool {
    let width = predicted.len();
    let entry = |i: usize| done.get(i.checked_mul(width)?..)?.get(..width);
    let tip = mesh.table.opposite(corner);
    let [a, b] = mesh.sides(tip);
    let (Some(tip), Some(a), Some(b)) = (entry(mesh.entry(tip)), entry(a), entry(b)) else { return false };
    for (k, value) in predicted.iter_mut().enumerate() {
        *value = a[k].wrapping_add(b[k]).wrapping_sub(tip[k]);
    }
    true
}

/// The corner of an entry.
#[inline]
fn corner(mesh: &Neighbours<'_>, i: usize) -> u32 {
    super::super::corners::at(&mesh.order.corners, i as u32)
}

/// Restores entries that are predicted by one parallelogram, or by the entry before.
pub(super) fn one(list: &mut [i32], width: usize, mesh: &Neighbours<'_>, wrap: Wrap) {
    let predict = |i: usize, done: &[i32], predicted: &mut [i32]| {
        if !complete(mesh, corner(mesh, i), done, predicted) {
            before(done, predicted);
        }
    };
    each(list, width, predict, |p, e| wrap.restore(p, e));
}

/// Restores entries that are predicted by the mean of parallelograms. Those across creases, which the stream marks,
/// do not count.
pub(super) fn several(
    list: &mut [i32],
    width: usize,
    mesh: &Neighbours<'_>,
    reader: &mut Reader<'_>,
    room: Room<'_>,
) -> Read<()> {
    // By the number of parallelograms of the entry.
    let mut creases: [Option<(usize, Decisions<'_>)>; MOST] = Default::default();
    for creases in &mut creases {
        let count = reader.varint()? as usize;
        if count > mesh.table.vertex.len() {
            return damaged(&format!("has {count} creases for {} corners", mesh.table.vertex.len()));
        }
        if count > 0 {
            *creases = Some((count, Decisions::read(reader)?));
        }
    }
    let wrap = Wrap::read(reader)?;
    let mut sides = room.filled(MOST * width, 0)?;
    let mut missing = false;
    let predict = |i: usize, done: &[i32], predicted: &mut [i32]| {
        let mut count = 0;
        // The first entry has no neighbours that are done.
        for corner in mesh.table.around(corner(mesh, i)) {
            let Some(side) = sides.get_mut(count * width..(count + 1) * width) else { break };
            count += usize::from(complete(mesh, corner, done, side));
            if count == MOST {
                break;
            }
        }
        predicted.fill(0);
        let mut used = 0;
        for side in sides.chunks_exact(width).take(count) {
            let Some(Some((left, creases))) =
                creases.get_mut(count - 1).filter(|c| c.as_ref().is_some_and(|c| c.0 > 0))
            else {
                missing = true;
                break;
            };
            *left -= 1;
            if !creases.decide() {
                used += 1;
                for (sum, value) in predicted.iter_mut().zip(side) {
                    *sum = sum.wrapping_add(*value);
                }
            }
        }
        match used {
            0 => before(done, predicted),
            _ => predicted.iter_mut().for_each(|sum| *sum /= used),
        }
    };
    each(list, width, predict, |p, e| wrap.restore(p, e));
    if missing {
        return damaged("has fewer marks of creases than parallelograms");
    }
    Ok(())
}
