//! Decompression of meshes (`KHR_draco_mesh_compression`): the Draco bitstream 2.2 of triangle meshes.
//!
//! ```text
//! header ── metadata ── connectivity ───────────────────────── attributes
//!           skipped     sequential: indices                     per attribute: symbols ── prediction ── values
//!                       edgebreaker: a spiral over the faces
//! ```
//!
//! The connectivity is a list of indices, or a sequence of symbols that glue one face after the other to a boundary
//! (edgebreaker; Rossignac 1999). A walk over the faces then gives the order of the vertices, and each attribute is
//! stored as differences to a prediction from its neighbours, as integers: quantised, octahedral (normals) or
//! as they are. All symbols are entropy-coded by rANS.
//!
//! All counts are checked against the budget before anything is allocated, and all work is linear in what is
//! charged: a damaged stream is rejected or decodes to wrong values.

mod attributes;
mod connectivity;
mod corners;
mod edgebreaker;
mod header;
mod order;
mod prediction;
mod rans;
mod reader;
mod seams;
mod traversal;
mod unpacked;
mod values;

pub(super) use unpacked::Unpacked;
use values::Data;

use std::ops::Range;

use super::budget::Budget;
use super::fault::{Fault, Outcome};
use connectivity::Connectivity;
use reader::Reader;

/// Why a stream is rejected.
#[derive(Debug)]
enum Damage {
    /// It violates the format: a verb and what was found.
    Stream(String),
    /// It exceeds the budget.
    Budget(Fault),
}

type Read<T> = Result<T, Damage>;

/// An error: the stream violates the format.
fn damaged<T>(found: &str) -> Read<T> {
    Err(Damage::Stream(found.to_owned()))
}

/// Allocates within the budget.
#[derive(Clone, Copy, Debug)]
struct Room<'a> {
    budget: &'a Budget,
    pointer: &'a str,
}

impl Room<'_> {
    /// An empty list with capacity for `count` elements.
    fn list<T>(self, count: usize) -> Read<Vec<T>> {
        self.budget.list(count, self.pointer).map_err(Damage::Budget)
    }

    /// A list of `count` equal elements.
    fn filled<T: Clone>(self, count: usize, value: T) -> Read<Vec<T>> {
        let mut list = self.list(count)?;
        list.resize(count, value);
        Ok(list)
    }

    /// An empty list that is soon freed. One byte per element is charged, for the time that it takes to fill.
    fn passing<T>(self, count: usize) -> Read<Vec<T>> {
        self.budget.take(count, 1, self.pointer).map_err(Damage::Budget)?;
        Ok(Vec::with_capacity(count))
    }
}

/// A decoded mesh.
#[derive(Debug)]
struct Mesh {
    /// Number of points: vertices with all their attributes.
    points: usize,
    /// Points of each triangle.
    faces: Vec<[u32; 3]>,
    attributes: Vec<Attribute>,
}

/// An attribute of a decoded mesh.
#[derive(Debug)]
struct Attribute {
    /// The number by which the file refers to it.
    id: u32,
    /// Components per point.
    width: usize,
    /// Whether integers stand for fractions.
    normalized: bool,
    /// The values of its entries.
    data: Data,
    /// The entry of each point; all in order if `None`.
    of_point: Option<Vec<u32>>,
}

impl Attribute {
    /// Where the values of a point are in its data.
    fn values(&self, point: usize) -> Range<usize> {
        let entry = match &self.of_point {
            Some(map) => map.get(point).map_or(usize::MAX, |entry| *entry as usize),
            None => point,
        };
        let first = entry.saturating_mul(self.width);
        first..first.saturating_add(self.width)
    }
}

/// Decodes a mesh. `pointer` is the JSON pointer of the extension, for errors.
fn decode(bytes: &[u8], budget: &Budget, pointer: &str) -> Outcome<Mesh> {
    let mut reader = Reader::new(bytes);
    let room = Room { budget, pointer };
    // For the time that it takes: many primitives may share a stream.
    budget.take(bytes.len(), 1, pointer)?;
    mesh(&mut reader, room).map_err(|damage| match damage {
        Damage::Stream(found) => Fault::at(pointer, format!("its Draco stream {found}")),
        Damage::Budget(fault) => fault,
    })
}

fn mesh(reader: &mut Reader<'_>, room: Room<'_>) -> Read<Mesh> {
    let method = header::read(reader)?;
    let connectivity = connectivity::read(method, reader, room)?;
    let attributes = attributes::read(&connectivity, reader, room)?;
    let Connectivity { points, faces, .. } = connectivity;
    if let Some(point) = faces.as_flattened().iter().find(|point| **point as usize >= points) {
        return damaged(&format!("has a face with point {point}, but there are {points}"));
    }
    Ok(Mesh { points, faces, attributes })
}

#[cfg(test)]
mod tests;
