//! Computes the boxes of all primitives and omits those that no ray can hit.

use std::mem::MaybeUninit;

use super::super::BuildError;
use super::Source;
use super::parallel::{at_once, parts};
use super::prims::{Bounds, Prim};

/// Smaller sources are loaded by one thread.
const MIN_PARALLEL: usize = 1 << 15;

/// The usable primitives in order, their bounds, and how many primitives were omitted.
pub(super) struct Loaded {
    pub(super) prims: Vec<Prim>,
    pub(super) bounds: Bounds,
    pub(super) centers: Bounds,
    pub(super) non_finite: usize,
    pub(super) degenerate: usize,
}

/// Why a primitive is omitted.
enum Unusable {
    NonFinite,
    Degenerate,
    OutOfRange(u32),
}

/// The result of one thread.
struct Part {
    loaded: Loaded,
    count: usize,
    out_of_range: Option<(usize, u32)>,
}

pub(super) fn load(source: &Source<'_>, threads: usize) -> Result<Loaded, BuildError> {
    let count = source.len();
    let mut prims: Vec<Prim> = Vec::new();
    let needed = count * size_of::<Prim>();
    prims.try_reserve_exact(count).map_err(|_| BuildError::OutOfMemory { needed })?;
    let threads = if count < MIN_PARALLEL { 1 } else { threads };
    let rooms = parts(&mut prims.spare_capacity_mut()[..count], threads);
    let starts: Vec<usize> = (0..threads).map(|i| count * i / threads).collect();
    let rooms: Vec<_> = rooms.into_iter().map(std::sync::Mutex::new).collect();
    let found = at_once(threads, |i| {
        let mut room = rooms[i].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match *source {
            Source::Triangles { positions, triangles, scale } => {
                fill(&mut room, starts[i], |id| triangle(positions, triangles[id], scale, id))
            }
            Source::Boxes { boxes, scale, .. } => fill(&mut room, starts[i], |id| {
                let b = boxes[id];
                let (min, max) = (b.min.map(|x| x * scale), b.max.map(|x| x * scale));
                let valid = crate::Aabb { min, max }.is_valid();
                if valid { Ok(Prim::new(min, max, id as u32)) } else { Err(Unusable::NonFinite) }
            }),
        }
    });
    drop(rooms);
    if let Some((triangle, vertex)) = found.iter().find_map(|part| part.out_of_range) {
        let Source::Triangles { positions, .. } = source else { unreachable!("boxes have no vertices") };
        return Err(BuildError::VertexOutOfRange { triangle, vertex, vertices: positions.len() });
    }
    let mut all =
        Loaded { prims, bounds: Bounds::empty(), centers: Bounds::empty(), non_finite: 0, degenerate: 0 };
    let mut used = 0;
    for (part, start) in found.iter().zip(starts) {
        let room = all.prims.spare_capacity_mut();
        if used != start {
            room.copy_within(start..start + part.count, used);
        }
        used += part.count;
        all.bounds = all.bounds.union(part.loaded.bounds);
        all.centers = all.centers.union(part.loaded.centers);
        all.non_finite += part.loaded.non_finite;
        all.degenerate += part.loaded.degenerate;
    }
    // SAFETY: each part wrote its first `count` elements, and the parts were moved together.
    unsafe { all.prims.set_len(used) };
    Ok(all)
}

#[inline(always)]
fn triangle(positions: &[[f32; 3]], corners: [u32; 3], scale: f32, id: usize) -> Result<Prim, Unusable> {
    let mut p = [[0.0; 3]; 3];
    for (p, vertex) in p.iter_mut().zip(corners) {
        let Some(position) = positions.get(vertex as usize) else { return Err(Unusable::OutOfRange(vertex)) };
        *p = position.map(|x| x * scale);
    }
    let [a, b, c] = p;
    // Zero for finite coordinates, NaN otherwise.
    let test: f32 = p.iter().flatten().map(|x| x * 0.0).sum();
    if test != 0.0 {
        return Err(Unusable::NonFinite);
    }
    if a == b || b == c || c == a {
        return Err(Unusable::Degenerate);
    }
    let least = |x: f32, y: f32| if x < y { x } else { y };
    let most = |x: f32, y: f32| if x > y { x } else { y };
    let min = std::array::from_fn(|i| least(least(a[i], b[i]), c[i]));
    let max = std::array::from_fn(|i| most(most(a[i], b[i]), c[i]));
    Ok(Prim::new(min, max, id as u32))
}

/// Writes the usable primitives among `room.len()` primitives from `start` on to the front of `room`.
#[inline(always)]
fn fill(
    room: &mut [MaybeUninit<Prim>],
    start: usize,
    prim: impl Fn(usize) -> Result<Prim, Unusable>,
) -> Part {
    let loaded = Loaded {
        prims: Vec::new(),
        bounds: Bounds::empty(),
        centers: Bounds::empty(),
        non_finite: 0,
        degenerate: 0,
    };
    let mut part = Part { loaded, count: 0, out_of_range: None };
    let (mut bounds, mut centers) = (Bounds::empty(), Bounds::empty());
    for id in start..start + room.len() {
        match prim(id) {
            Ok(prim) => {
                bounds = bounds.union(prim.bounds);
                centers = centers.union(Bounds::point(prim.bounds.center()));
                room[part.count].write(prim);
                part.count += 1;
            }
            Err(Unusable::NonFinite) => part.loaded.non_finite += 1,
            Err(Unusable::Degenerate) => part.loaded.degenerate += 1,
            Err(Unusable::OutOfRange(vertex)) => {
                part.out_of_range = Some((id, vertex));
                break;
            }
        }
    }
    part.loaded.bounds = bounds;
    part.loaded.centers = centers;
    part
}
