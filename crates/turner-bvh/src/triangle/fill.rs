//! Copies triangles into the blocks of leaves.

use std::mem::MaybeUninit;

use super::{BLOCK, Block};
use crate::build::wide::NO_PRIMITIVE;
use crate::{BuildError, Triangles};

/// The least number of blocks per thread.
const MIN_PARALLEL: usize = 4096;

/// Fills one block per [`BLOCK`] slots, with several threads (0: all that the machine offers).
pub(crate) fn fill_blocks(
    mesh: &Triangles<'_>,
    scale: f32,
    slots: &[u32],
    threads: usize,
) -> Result<Vec<Block>, BuildError> {
    let count = slots.len() / BLOCK;
    let mut blocks = Vec::new();
    blocks
        .try_reserve_exact(count)
        .map_err(|_| BuildError::OutOfMemory { needed: count * size_of::<Block>() })?;
    let threads = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let blocks_per_thread = count.div_ceil(threads).max(MIN_PARALLEL);
    let spare = &mut blocks.spare_capacity_mut()[..count];
    turner_host::thread::scope(|scope| {
        let mut parts = spare.chunks_mut(blocks_per_thread).zip(slots.chunks(blocks_per_thread * BLOCK));
        let first = parts.next();
        for (to, slots) in parts {
            let waiting = std::sync::Mutex::new(Some((to, slots)));
            let work = move || {
                if let Some((to, slots)) = waiting.lock().ok().and_then(|mut part| part.take()) {
                    fill(mesh, scale, slots, to);
                }
            };
            scope.spawn(work);
        }
        if let Some((to, slots)) = first {
            fill(mesh, scale, slots, to);
        }
    });
    // SAFETY: all `count` blocks were written; a panic in a thread would have left the scope.
    unsafe { blocks.set_len(count) };
    Ok(blocks)
}

fn fill(mesh: &Triangles<'_>, scale: f32, slots: &[u32], to: &mut [MaybeUninit<Block>]) {
    for (ids, to) in slots.chunks_exact(BLOCK).zip(to) {
        to.write(block(mesh, scale, ids));
    }
}

/// A block of the triangles `ids`; lanes of `NO_PRIMITIVE` stay empty.
#[inline]
fn block(mesh: &Triangles<'_>, scale: f32, ids: &[u32]) -> Block {
    let mut block = Block::EMPTY;
    for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NO_PRIMITIVE) {
        let corners = mesh.triangles[id as usize].map(|i| mesh.positions[i as usize].map(|x| x * scale));
        block.set(lane, id, corners);
    }
    block
}
