//! The symbols of edgebreaker: how the next face is glued to the boundary.

use super::corners::{Corners, NONE, next, previous, put};
use super::rans::{self, Decisions};
use super::reader::{Bits, Reader};
use super::{Read, Room, damaged};

/// How a face is glued to the active edge; the letters are those of Rossignac's paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symbol {
    /// To the active edge and its neighbour: closes a vertex.
    C,
    /// To the two newest active edges, of separate boundaries.
    S,
    /// To the active edge; the next active edge is that on the left.
    L,
    /// To the active edge; the next active edge is that on the right.
    R,
    /// To nothing: begins a boundary.
    E,
}

/// Symbols in the order of the coding by valence.
const BY_NUMBER: [Symbol; 5] = [Symbol::C, Symbol::S, Symbol::L, Symbol::R, Symbol::E];

/// Contexts of the coding by valence: of vertices with 2 faces and fewer to 7 and more.
const CONTEXTS: usize = 6;

/// The smallest valence that has its own context.
const MIN_VALENCE: u32 = 2;

/// Where the symbols come from.
enum Source<'a> {
    /// One bit for C, three for the others.
    Standard(Bits<'a>),
    /// By the valence of a vertex of the active edge.
    Valence {
        /// Symbols by context; the last is next.
        symbols: Vec<Vec<u32>>,
        /// The number of faces at each vertex up to now.
        valences: Vec<u32>,
        context: Option<usize>,
    },
}

/// The streams that belong to the symbols of edgebreaker.
pub(super) struct Traversal<'a> {
    source: Source<'a>,
    /// Whether the first face of a component lies inside.
    pub(super) inside: Decisions<'a>,
    /// For each attribute with its own connectivity, whether an edge is a seam.
    pub(super) seams: Vec<Decisions<'a>>,
}

impl<'a> Traversal<'a> {
    /// Reads the streams of a mesh with so many faces, vertices and attributes with seams.
    pub(super) fn read(
        kind: u8,
        (faces, vertices, attributes): (usize, usize, u8),
        reader: &mut Reader<'a>,
        room: Room<'_>,
    ) -> Read<Traversal<'a>> {
        let standard = match kind {
            0 => Some(Bits::new(Reader::new(reader.sized()?))),
            2 => None,
            1 => return damaged("has predictive edgebreaker symbols, which version 2.2 has not"),
            _ => return damaged(&format!("has edgebreaker symbols of type {kind}; expected 0 or 2")),
        };
        let inside = Decisions::read(reader)?;
        let seams = (0..attributes).map(|_| Decisions::read(reader)).collect::<Read<Vec<_>>>()?;
        let source = match standard {
            Some(bits) => Source::Standard(bits),
            None => {
                let mut symbols = Vec::with_capacity(CONTEXTS);
                for _ in 0..CONTEXTS {
                    let count = reader.varint()? as usize;
                    if count > faces {
                        return damaged(&format!("has {count} symbols of a valence, but {faces} faces"));
                    }
                    symbols.push(rans::symbols(reader, count, 1, room)?);
                }
                Source::Valence { symbols, valences: room.filled(vertices, 0)?, context: None }
            }
        };
        Ok(Traversal { source, inside, seams })
    }

    /// The next symbol.
    pub(super) fn next(&mut self) -> Read<Symbol> {
        match &mut self.source {
            Source::Standard(bits) => Ok(match bits.take(1)? {
                0 => Symbol::C,
                _ => match bits.take(2)? {
                    0 => Symbol::S,
                    1 => Symbol::L,
                    2 => Symbol::R,
                    _ => Symbol::E,
                },
            }),
            Source::Valence { context: None, .. } => Ok(Symbol::E),
            Source::Valence { symbols, context: Some(context), .. } => {
                let symbol = symbols.get_mut(*context).and_then(Vec::pop);
                match symbol.and_then(|number| BY_NUMBER.get(number as usize)) {
                    Some(symbol) => Ok(*symbol),
                    None => damaged("has no valid edgebreaker symbol for a valence"),
                }
            }
        }
    }

    /// Takes note of a new face, whose first corner faces the active edge. `vertex` resolves the vertex of a corner.
    pub(super) fn glued(&mut self, symbol: Symbol, corner: u32, mut vertex: impl FnMut(u32) -> u32) {
        let Source::Valence { valences, context, .. } = &mut self.source else { return };
        let added = match symbol {
            Symbol::C | Symbol::S => [0, 1, 1],
            Symbol::R => [1, 1, 2],
            Symbol::L => [1, 2, 1],
            Symbol::E => [2, 2, 2],
        };
        for (corner, added) in [corner, next(corner), previous(corner)].into_iter().zip(added) {
            if let Some(valence) = valences.get_mut(vertex(corner) as usize) {
                *valence = valence.wrapping_add(added);
            }
        }
        let valence = valences.get(vertex(next(corner)) as usize).copied().unwrap_or(0);
        *context = Some((valence.saturating_sub(MIN_VALENCE) as usize).min(CONTEXTS - 1));
    }

    /// Takes note that a vertex becomes part of another.
    pub(super) fn merged(&mut self, into: u32, from: u32) {
        if let Source::Valence { valences, .. } = &mut self.source {
            let sum = [into, from]
                .iter()
                .filter_map(|v| valences.get(*v as usize))
                .fold(0u32, |s, v| s.wrapping_add(*v));
            put(valences, into, sum);
        }
    }
}

/// Reads for each attribute whether its values differ across each edge. `mark(a, corner)` is called for the corners
/// that face a seam of attribute `a`.
pub(super) fn read_seams(seams: &mut [Decisions<'_>], corners: &Corners, mut mark: impl FnMut(usize, u32)) {
    let count = corners.opposite.len() as u32;
    for face in (0..count).step_by(3) {
        for corner in face..face + 3 {
            let opposite = corners.opposite(corner);
            // An edge is stored with the first of its faces; boundaries are not stored.
            if opposite == NONE || opposite < face {
                continue;
            }
            for (a, seam) in seams.iter_mut().enumerate() {
                if seam.decide() {
                    mark(a, corner);
                    mark(a, opposite);
                }
            }
        }
    }
}
