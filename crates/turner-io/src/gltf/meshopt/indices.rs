//! Modes TRIANGLES and INDICES (appendix A): index buffers.
//!
//! TRIANGLES stores one code byte per triangle and exploits that neighbouring triangles share edges and vertices. The
//! decoder keeps the last sixteen edges and the last sixteen vertices:
//!
//! ```text
//! code  high nibble 0..14: reuse that recent edge (a, b); low nibble gives c:
//!         0 next unused vertex | 1.. recent vertex | 13, 14 last explicit ∓ 1 (version 1) | 15 explicit
//!       high nibble 15: no shared edge; a is the next unused vertex (or explicit, low nibble 15);
//!         low nibble 0..13 selects a byte of the 16-byte table, 14 and 15 read a byte from the data;
//!         its nibbles give b and c: 0 next unused | 1..14 recent | 15 recent, in a byte from the data explicit
//! ```
//!
//! Explicit vertices are zigzag differences to the last explicit one, as variable-length integers. INDICES stores
//! only such differences, to one of two previous values.

use super::{Reader, unzigzag};

const TRIANGLES: u8 = 0xe0;
const SEQUENCE: u8 = 0xd0;

/// The last sixteen items pushed.
struct Fifo<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(item: T) -> Self {
        Fifo { items: [item; 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.next & 15] = item;
        self.next += 1;
    }

    /// The item pushed `back` pushes before the last one.
    fn get(&self, back: usize) -> T {
        self.items[self.next.wrapping_sub(1 + back) & 15]
    }
}

fn store(out: &mut [u8], index: u32) {
    match out.len() {
        2 => out.copy_from_slice(&(index as u16).to_le_bytes()),
        _ => out.copy_from_slice(&index.to_le_bytes()),
    }
}

/// Mode TRIANGLES. Fills `out` with triangles whose indices take `stride` bytes, 2 or 4.
pub(super) fn decode_triangles(source: &[u8], stride: usize, out: &mut [u8]) -> Option<()> {
    let count = out.len() / stride / 3;
    let (&header, body) = source.split_first()?;
    if header & 0xf0 != TRIANGLES || header & 15 > 1 {
        return None;
    }
    let nearest = if header & 15 == 1 { 13 } else { 15 };
    let (codes, body) = body.split_at_checked(count)?;
    let (data, table) = body.split_at_checked(body.len().checked_sub(16)?)?;
    let mut data = Reader { bytes: data };
    let mut edges = Fifo::new((u32::MAX, u32::MAX));
    let mut vertices = Fifo::new(u32::MAX);
    // The next unused vertex, and the last explicit one.
    let (mut next, mut last) = (0u32, 0u32);
    let fresh = |next: &mut u32| {
        let v = *next;
        *next = next.wrapping_add(1);
        v
    };
    let free = |data: &mut Reader<'_>, last: &mut u32| {
        *last = last.wrapping_add(unzigzag(data.varint()?));
        Some(*last)
    };
    for (code, triangle) in codes.iter().zip(out.chunks_exact_mut(3 * stride)) {
        let high = usize::from(code >> 4);
        let low = usize::from(code & 15);
        let corners = if high < 15 {
            let (a, b) = edges.get(high);
            let c = if low == 0 {
                let c = fresh(&mut next);
                vertices.push(c);
                c
            } else if low < nearest {
                vertices.get(low)
            } else {
                let c = match low {
                    13 => last.wrapping_sub(1),
                    14 => last.wrapping_add(1),
                    _ => last.wrapping_add(unzigzag(data.varint()?)),
                };
                last = c;
                vertices.push(c);
                c
            };
            edges.push((c, b));
            edges.push((a, c));
            [a, b, c]
        } else {
            let (pair, named) = if low < 14 { (table[low], false) } else { (data.byte()?, true) };
            if named && pair == 0 {
                next = 0;
            }
            let (second, third) = (usize::from(pair >> 4), usize::from(pair & 15));
            // Distances count from before this triangle's own vertices; the first is always pushed.
            let a_is_free = low == 15;
            let a = if a_is_free { 0 } else { fresh(&mut next) };
            let recent = |back: usize| vertices.items[vertices.next.wrapping_sub(back) & 15];
            let b = if second == 0 { fresh(&mut next) } else { recent(second) };
            let c = if third == 0 { fresh(&mut next) } else { recent(third) };
            let a = if a_is_free { free(&mut data, &mut last)? } else { a };
            let b = if named && second == 15 { free(&mut data, &mut last)? } else { b };
            let c = if named && third == 15 { free(&mut data, &mut last)? } else { c };
            vertices.push(a);
            if second == 0 || named && second == 15 {
                vertices.push(b);
            }
            if third == 0 || named && third == 15 {
                vertices.push(c);
            }
            edges.push((b, a));
            edges.push((c, b));
            edges.push((a, c));
            [a, b, c]
        };
        for (slot, index) in triangle.chunks_exact_mut(stride).zip(corners) {
            store(slot, index);
        }
    }
    data.bytes.is_empty().then_some(())
}

/// Mode INDICES. Fills `out` with indices of `stride` bytes, 2 or 4.
pub(super) fn decode_sequence(source: &[u8], stride: usize, out: &mut [u8]) -> Option<()> {
    let (&header, body) = source.split_first()?;
    if header & 0xf0 != SEQUENCE || header & 15 > 1 {
        return None;
    }
    let mut data = Reader { bytes: body.get(..body.len().checked_sub(4)?)? };
    let mut last = [0u32; 2];
    for slot in out.chunks_exact_mut(stride) {
        let v = data.varint()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(unzigzag(v >> 1));
        store(slot, *base);
    }
    data.bytes.is_empty().then_some(())
}
