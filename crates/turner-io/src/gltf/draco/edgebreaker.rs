//! Edgebreaker: the faces are glued to a growing boundary in the reverse order of the encoder (Rossignac 1999;
//! Isenburg and Snoeyink, Spirale Reversi, 1999).
//!
//! A stack holds the active edges, each as the corner that faces it. A symbol glues the next face to the newest one.

use std::collections::BTreeMap;

use super::connectivity::{Connectivity, Surface, face_count};
use super::corners::{Corners, NONE, at, next, previous, put};
use super::reader::{Bits, Reader};
use super::traversal::{Symbol, Traversal};
use super::{Read, Room, damaged, seams};

/// A face whose remaining edge becomes active again when the symbol S of a handle is reached.
#[derive(Clone, Copy, Debug)]
struct Split {
    /// The encoder's number of the face's symbol.
    source: u32,
    /// The encoder's number of the symbol S.
    symbol: u32,
    on_right: bool,
}

/// Reads the connectivity of a mesh.
pub(super) fn read(reader: &mut Reader<'_>, room: Room<'_>) -> Read<Connectivity> {
    let kind = reader.byte()?;
    let vertices = reader.varint()? as usize;
    let faces = face_count(reader)?;
    let attributes = reader.byte()?;
    let symbols = reader.varint()? as usize;
    let split_symbols = reader.varint()? as usize;
    // Each component has at most one face without a symbol, and at least three others then.
    if vertices > 3 * faces || symbols > faces || faces > symbols + symbols / 3 || split_symbols > symbols {
        let found = format!("{vertices} vertices, {symbols} symbols and {split_symbols} splits");
        return damaged(&format!("has {found} for {faces} faces, which no mesh has"));
    }
    let splits = read_splits(reader, faces, room)?;
    // Each S makes a vertex superfluous.
    let most = vertices.saturating_add(split_symbols);
    let mut traversal = Traversal::read(kind, (faces, most, attributes), reader, room)?;
    let mut boundary = Boundary {
        corners: Corners {
            vertex: room.filled(3 * faces, NONE)?,
            opposite: room.filled(3 * faces, NONE)?,
            leftmost: room.list(most)?,
        },
        into: room.list(most)?,
        inner: room.filled(most, false)?,
        most,
        merged: Vec::new(),
        active: Vec::new(),
    };
    boundary.glue_all(symbols, splits, &mut traversal)?;
    boundary.close(symbols, &mut traversal)?;
    let Boundary { mut corners, inner, merged, .. } = boundary;
    if attributes == 0 {
        let points = without_merged(&mut corners, &merged, room)?;
        let faces = corners.vertex.as_chunks().0.to_vec();
        let surface = Some(Surface { corners, seamed: Vec::new() });
        return Ok(Connectivity { points, faces, surface });
    }
    let seamed = seams::read(&mut traversal.seams, &corners, room)?;
    let (points, faces) = seams::points(&corners, &seamed, &inner, room)?;
    Ok(Connectivity { points, faces, surface: Some(Surface { corners, seamed }) })
}

fn read_splits(reader: &mut Reader<'_>, faces: usize, room: Room<'_>) -> Read<Vec<Split>> {
    let count = reader.varint()? as usize;
    if count > faces {
        return damaged(&format!("has {count} splits for {faces} faces"));
    }
    let mut splits = room.list(count)?;
    let mut source = 0u32;
    for _ in 0..count {
        source = source.wrapping_add(reader.varint()?);
        let back = reader.varint()?;
        let Some(symbol) = source.checked_sub(back) else {
            return damaged(&format!("has a split {back} symbols before symbol {source}"));
        };
        splits.push(Split { source, symbol, on_right: false });
    }
    let mut bits = Bits::new(*reader);
    for split in &mut splits {
        split.on_right = bits.take(1)? == 1;
    }
    *reader = bits.rest();
    Ok(splits)
}

/// The faces decoded so far and their active edges.
struct Boundary {
    /// Its vertices are those of [`Boundary::vertex`] only after [`Boundary::close`].
    corners: Corners,
    /// The vertex that each vertex was merged into (union-find); itself at first.
    into: Vec<u32>,
    /// Whether a vertex is inside.
    inner: Vec<bool>,
    /// Most vertices.
    most: usize,
    /// Vertices that became part of others.
    merged: Vec<u32>,
    /// Corners that face the active edges.
    active: Vec<u32>,
}

impl Boundary {
    /// What a vertex is now. Halves the way for later calls, so that many merges take little time.
    fn resolve(&mut self, mut vertex: u32) -> u32 {
        loop {
            let into = at(&self.into, vertex);
            if into == vertex || into == NONE {
                return vertex;
            }
            let further = at(&self.into, into);
            put(&mut self.into, vertex, further);
            vertex = further;
        }
    }

    /// The vertex of a corner.
    fn vertex(&mut self, corner: u32) -> u32 {
        self.resolve(self.corners.vertex(corner))
    }

    fn add_vertex(&mut self, corner: u32) -> Read<()> {
        let vertex = self.into.len();
        if vertex >= self.most {
            return damaged(&format!("has more than the {} vertices that it announces", self.most));
        }
        self.into.push(vertex as u32);
        self.corners.leftmost.push(corner);
        put(&mut self.corners.vertex, corner, vertex as u32);
        Ok(())
    }

    fn newest(&self) -> Read<u32> {
        match self.active.last() {
            Some(corner) => Ok(*corner),
            None => damaged("glues a face to a boundary where there is none"),
        }
    }

    /// Joins edges by the corners that face them.
    fn join<const N: usize>(&mut self, pairs: [(u32, u32); N]) -> Read<()> {
        for (a, b) in pairs {
            let opposite = &mut self.corners.opposite;
            if at(opposite, a) != NONE || at(opposite, b) != NONE || a == b || a == NONE || b == NONE {
                return damaged("glues more than two faces to an edge");
            }
            put(opposite, a, b);
            put(opposite, b, a);
        }
        Ok(())
    }

    /// The corner that faces the boundary edge that follows at a vertex, counter-clockwise around the mesh.
    fn across(&self, vertex: u32) -> u32 {
        next(at(&self.corners.leftmost, vertex))
    }

    /// Glues the faces of all symbols.
    fn glue_all(
        &mut self,
        symbols: usize,
        mut splits: Vec<Split>,
        traversal: &mut Traversal<'_>,
    ) -> Read<()> {
        // Active edges of handles, by the number of the symbol S that needs them.
        let mut of_handles = BTreeMap::new();
        for number in 0..symbols as u32 {
            let symbol = traversal.next()?;
            let corner = 3 * number;
            match symbol {
                Symbol::C => self.glue_c(corner)?,
                Symbol::S => self.glue_s(corner, of_handles.remove(&number), traversal)?,
                Symbol::L | Symbol::R => self.glue_side(corner, symbol == Symbol::R)?,
                Symbol::E => {
                    for corner in corner..corner + 3 {
                        self.add_vertex(corner)?;
                    }
                    self.active.push(corner);
                }
            }
            traversal.glued(symbol, corner, |corner| self.vertex(corner));
            if matches!(symbol, Symbol::C | Symbol::S) {
                continue;
            }
            let from_end = |n: u32| (symbols as u32 - 1).wrapping_sub(n);
            while let Some(split) = splits.pop_if(|split| split.source == from_end(number)) {
                let edge = if split.on_right { next(corner) } else { previous(corner) };
                of_handles.insert(from_end(split.symbol), edge);
            }
        }
        Ok(())
    }

    fn glue_c(&mut self, corner: u32) -> Read<()> {
        let a = self.newest()?;
        let x = self.vertex(next(a));
        let b = self.across(x);
        let (of_a, of_b) = (self.vertex(previous(a)), self.vertex(next(b)));
        if x == of_a || x == of_b {
            return damaged("has a face with two equal vertices");
        }
        self.join([(a, corner + 1), (b, corner + 2)])?;
        for (corner, vertex) in [(corner, x), (corner + 1, of_b), (corner + 2, of_a)] {
            put(&mut self.corners.vertex, corner, vertex);
        }
        put(&mut self.corners.leftmost, of_a, corner + 2);
        self.set_inner(x);
        self.activate(corner);
        Ok(())
    }

    fn glue_side(&mut self, corner: u32, on_right: bool) -> Read<()> {
        let a = self.newest()?;
        let (tip, left, right) =
            if on_right { (corner + 2, corner + 1, corner) } else { (corner + 1, corner, corner + 2) };
        self.join([(a, tip)])?;
        self.add_vertex(tip)?;
        let (of_right, of_left) = (self.vertex(previous(a)), self.vertex(next(a)));
        put(&mut self.corners.vertex, right, of_right);
        put(&mut self.corners.vertex, left, of_left);
        put(&mut self.corners.leftmost, of_right, right);
        self.activate(corner);
        Ok(())
    }

    fn glue_s(&mut self, corner: u32, handle: Option<u32>, traversal: &mut Traversal<'_>) -> Read<()> {
        let b = self.newest()?;
        self.active.pop();
        self.active.extend(handle);
        let a = self.newest()?;
        let (kept, gone) = (self.vertex(previous(a)), self.vertex(next(b)));
        let (of_a, of_b) = (self.vertex(next(a)), self.vertex(previous(b)));
        if kept == gone {
            return damaged("splits a boundary at a single vertex");
        }
        self.join([(a, corner + 2), (b, corner + 1)])?;
        for (corner, vertex) in [(corner, kept), (corner + 1, of_a), (corner + 2, of_b)] {
            put(&mut self.corners.vertex, corner, vertex);
        }
        let leftmost = &mut self.corners.leftmost;
        put(leftmost, of_b, corner + 2);
        let of_gone = at(leftmost, gone);
        put(leftmost, kept, of_gone);
        put(leftmost, gone, NONE);
        put(&mut self.into, gone, kept);
        self.merged.push(gone);
        traversal.merged(kept, gone);
        self.activate(corner);
        Ok(())
    }

    fn activate(&mut self, corner: u32) {
        if let Some(newest) = self.active.last_mut() {
            *newest = corner;
        }
    }

    fn set_inner(&mut self, vertex: u32) {
        if let Some(inner) = self.inner.get_mut(vertex as usize) {
            *inner = true;
        }
    }

    /// Closes the boundaries that a face without a symbol fills, and resolves all vertices.
    fn close(&mut self, symbols: usize, traversal: &mut Traversal<'_>) -> Read<()> {
        let all = self.corners.vertex.len() as u32;
        let mut corner = 3 * symbols as u32;
        while let Some(a) = self.active.pop() {
            if !traversal.inside.decide() {
                continue;
            }
            if corner >= all {
                return damaged("has more faces than it announces");
            }
            let n = self.vertex(next(a));
            let b = self.across(n);
            let x = self.vertex(next(b));
            let c = self.across(x);
            let p = self.vertex(next(c));
            if p != self.vertex(previous(a)) {
                return damaged("fills a boundary of more than three edges with a face");
            }
            self.join([(a, corner), (b, corner + 1), (c, corner + 2)])?;
            for (corner, vertex) in [(corner, x), (corner + 1, p), (corner + 2, n)] {
                put(&mut self.corners.vertex, corner, vertex);
                self.set_inner(vertex);
            }
            corner += 3;
        }
        if corner != all {
            return damaged(&format!("has {} faces; expected {}", corner / 3, all / 3));
        }
        for vertex in 0..self.into.len() as u32 {
            let now = self.resolve(vertex);
            put(&mut self.into, vertex, now);
        }
        for vertex in &mut self.corners.vertex {
            *vertex = at(&self.into, *vertex);
        }
        Ok(())
    }
}

/// Gives the numbers of merged vertices to the last vertices. Returns how many vertices there are.
fn without_merged(corners: &mut Corners, merged: &[u32], room: Room<'_>) -> Read<usize> {
    let leftmost = &mut corners.leftmost;
    let mut count = leftmost.len();
    // Which vertex has each number.
    let mut holder = room.list::<u32>(count)?;
    holder.extend(0..count as u32);
    for &free in merged {
        while count > 0 && leftmost.get(count - 1) == Some(&NONE) {
            count -= 1;
        }
        let Some(last) = count.checked_sub(1).filter(|last| *last > free as usize) else { continue };
        leftmost.swap(last, free as usize);
        holder.swap(last, free as usize);
        count -= 1;
    }
    while count > 0 && leftmost.get(count - 1) == Some(&NONE) {
        count -= 1;
    }
    let mut number = room.filled(holder.len(), NONE)?;
    for (i, vertex) in holder.iter().enumerate().take(count) {
        put(&mut number, *vertex, i as u32);
    }
    for vertex in &mut corners.vertex {
        *vertex = at(&number, *vertex);
    }
    leftmost.truncate(count);
    Ok(count)
}
