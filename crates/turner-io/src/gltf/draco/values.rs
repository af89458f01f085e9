//! From integers to the values of an attribute.

use super::attributes::Described;
use super::reader::Reader;
use super::{Read, Room, damaged};

/// The component type of an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// An integer.
    I8,
    /// An integer or a truth value.
    U8,
    /// An integer.
    I16,
    /// An integer.
    U16,
    /// An integer.
    I32,
    /// An integer.
    U32,
    /// Single precision.
    F32,
    /// Eight bytes, which glTF does not have.
    Wide,
}

impl Kind {
    /// By its number in the stream.
    pub(super) fn of(number: u8) -> Option<Kind> {
        Some(match number {
            1 => Kind::I8,
            2 | 11 => Kind::U8,
            3 => Kind::I16,
            4 => Kind::U16,
            5 => Kind::I32,
            6 => Kind::U32,
            7 | 8 | 10 => Kind::Wide,
            9 => Kind::F32,
            _ => return None,
        })
    }

    /// Size in bytes.
    fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::Wide => 8,
        }
    }

    /// An integer of this type, from its bits.
    fn whole(self, bits: i32) -> i64 {
        match self {
            Kind::I8 => i64::from(bits as i8),
            Kind::U8 => i64::from(bits as u8),
            Kind::I16 => i64::from(bits as i16),
            Kind::U16 => i64::from(bits as u16),
            Kind::U32 => i64::from(bits as u32),
            Kind::I32 | Kind::F32 | Kind::Wide => i64::from(bits),
        }
    }
}

/// The values of an attribute, entry by entry.
#[derive(Debug)]
pub(super) enum Data {
    /// Floats.
    Floats(Vec<f32>),
    /// Integers, as bits of this type.
    Integers(Kind, Vec<i32>),
    /// Of a type that glTF does not have.
    Other,
}

impl Data {
    /// Value `i`, if it is a float.
    pub(super) fn float(&self, i: usize) -> Option<f32> {
        match self {
            Data::Floats(list) => list.get(i).copied(),
            _ => None,
        }
    }

    /// Value `i`, if it is an integer.
    pub(super) fn integer(&self, i: usize) -> Option<i64> {
        match self {
            Data::Integers(kind, list) => list.get(i).map(|bits| kind.whole(*bits)),
            _ => None,
        }
    }
}

/// How the values of an attribute are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    /// As they are.
    Raw,
    /// As integers.
    Integers,
    /// As multiples of a step above a minimum.
    Quantized,
    /// Unit vectors on an octahedron that is unfolded to a square.
    Octahedral,
}

impl Coding {
    /// Reads the coding of an attribute.
    pub(super) fn read(reader: &mut Reader<'_>, described: &Described) -> Read<Coding> {
        let coding = match reader.byte()? {
            0 => return Ok(Coding::Raw),
            1 => Coding::Integers,
            2 => Coding::Quantized,
            3 => Coding::Octahedral,
            other => return damaged(&format!("has values in coding {other}; expected 0 to 3")),
        };
        let (kind, width) = (described.kind, described.width);
        let fits = match coding {
            Coding::Octahedral => kind == Kind::F32 && width == 3,
            Coding::Quantized => kind == Kind::F32,
            _ => !matches!(kind, Kind::F32 | Kind::Wide),
        };
        if !fits {
            return damaged(&format!("has {width} components of type {kind:?} in coding {coding:?}"));
        }
        Ok(coding)
    }

    /// Integers per entry.
    pub(super) fn width(self, described: &Described) -> usize {
        if self == Coding::Octahedral { 2 } else { described.width }
    }
}

/// What is stored of an attribute.
pub(super) enum Portable {
    /// Integers that the coding turns into values.
    Integers(Vec<i32>),
    /// The values.
    Finished(Data),
}

/// Reads values that are stored as they are.
pub(super) fn read_raw(
    described: &Described,
    entries: usize,
    reader: &mut Reader<'_>,
    room: Room<'_>,
) -> Read<Portable> {
    let (kind, count) = (described.kind, entries.saturating_mul(described.width));
    let size = kind.size();
    let bytes = reader.take(count.saturating_mul(size))?;
    let list = |bits: fn(&[u8]) -> i32| {
        let mut list = room.list(count)?;
        list.extend(bytes.chunks_exact(size).map(bits));
        Ok(list)
    };
    let four = |bytes: &[u8]| bytes.first_chunk().copied().unwrap_or([0; 4]);
    Ok(Portable::Finished(match kind {
        Kind::Wide => Data::Other,
        Kind::F32 => {
            let mut list = room.list(count)?;
            list.extend(bytes.chunks_exact(size).map(|b| f32::from_le_bytes(four(b))));
            Data::Floats(list)
        }
        _ => Data::Integers(kind, list(|b| b.iter().rev().fold(0, |v, byte| v << 8 | i32::from(*byte)))?),
    }))
}

/// Turns integers into values, with the parameters that follow all integers of a group.
pub(super) fn finish(
    described: &Described,
    coding: Coding,
    portable: Portable,
    reader: &mut Reader<'_>,
    room: Room<'_>,
) -> Read<Data> {
    let list = match portable {
        Portable::Integers(list) => list,
        Portable::Finished(data) => return Ok(data),
    };
    match coding {
        Coding::Raw | Coding::Integers => Ok(Data::Integers(described.kind, list)),
        Coding::Quantized => dequantize(&list, described.width, reader, room),
        Coding::Octahedral => unit_vectors(&list, reader, room),
    }
}

/// v ↦ min + v range / (2^bits − 1), with the minimum of each component.
fn dequantize(list: &[i32], width: usize, reader: &mut Reader<'_>, room: Room<'_>) -> Read<Data> {
    let minimum = (0..width).map(|_| reader.f32()).collect::<Read<Vec<_>>>()?;
    let (range, bits) = (reader.f32()?, reader.byte()?);
    if !(1..=30).contains(&bits) {
        return damaged(&format!("has values of {bits} bits; expected 1 to 30"));
    }
    let step = range / ((1u32 << bits) - 1) as f32;
    let mut floats = room.list(list.len())?;
    for entry in list.chunks_exact(width) {
        floats.extend(entry.iter().zip(&minimum).map(|(v, minimum)| *v as f32 * step + minimum));
    }
    Ok(Data::Floats(floats))
}

/// Folds a square to an octahedron: x = 1 − |y| − |z| in the diamond in its middle; its corners are at x < 0.
fn unit_vectors(list: &[i32], reader: &mut Reader<'_>, room: Room<'_>) -> Read<Data> {
    let bits = reader.byte()?;
    if !(2..=30).contains(&bits) {
        return damaged(&format!("has normals of {bits} bits; expected 2 to 30"));
    }
    let scale = 2.0 / ((1u32 << bits) - 2) as f32;
    let mut floats = room.list(list.len() / 2 * 3)?;
    for [s, t] in list.as_chunks().0 {
        let (y, z) = (*s as f32 * scale - 1.0, *t as f32 * scale - 1.0);
        let x = 1.0 - y.abs() - z.abs();
        let beyond = (-x).max(0.0);
        let fold = |v: f32| v + if v < 0.0 { beyond } else { -beyond };
        let (y, z) = (fold(y), fold(z));
        let squared = x * x + y * y + z * z;
        // Not a number for damaged streams.
        if squared >= 1e-6 {
            let inverse = 1.0 / squared.sqrt();
            floats.extend([x * inverse, y * inverse, z * inverse]);
        } else {
            floats.extend([0.0; 3]);
        }
    }
    Ok(Data::Floats(floats))
}
