//! Values of binary layers.

use std::collections::BTreeMap;

use super::Binary;
use super::cursor::{Cursor, ended};
use super::ints::{MAX_ELEMENTS, integers};
use crate::usd::value::{Broken, ListEdit, Offset, Read, Reference, Value};

/// Deepest nesting of dictionaries.
const MAX_DEPTH: u32 = 32;

const IS_ARRAY: u64 = 1 << 63;
const IS_INLINE: u64 = 1 << 62;
const IS_COMPRESSED: u64 = 1 << 61;

/// The scalar type of a value's components.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scalar {
    Byte,
    Int,
    Uint,
    Long,
    Half,
    Single,
    Double,
}

impl Scalar {
    fn size(self) -> usize {
        match self {
            Scalar::Byte => 1,
            Scalar::Half => 2,
            Scalar::Int | Scalar::Uint | Scalar::Single => 4,
            Scalar::Long | Scalar::Double => 8,
        }
    }

    fn is_whole(self) -> bool {
        matches!(self, Scalar::Byte | Scalar::Int | Scalar::Uint | Scalar::Long)
    }

    /// A number from its bytes.
    fn real(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Scalar::Byte, [a]) => f64::from(*a),
            (Scalar::Half, [a, b]) => half(u16::from_le_bytes([*a, *b])),
            (Scalar::Int, [a, b, c, d]) => f64::from(i32::from_le_bytes([*a, *b, *c, *d])),
            (Scalar::Uint, [a, b, c, d]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (Scalar::Single, [a, b, c, d]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            (Scalar::Double, all) => all.try_into().map_or(0.0, f64::from_le_bytes),
            (Scalar::Long, all) => all.try_into().map_or(0.0, |b| i64::from_le_bytes(b) as f64),
            _ => 0.0,
        }
    }

    /// A whole number from its bytes.
    fn whole(self, bytes: &[u8]) -> i64 {
        match (self, bytes) {
            (Scalar::Long, all) => all.try_into().map_or(0, i64::from_le_bytes),
            _ => self.real(bytes) as i64,
        }
    }
}

/// A half-precision number.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3FF));
    // 2^-24 and powers of two are exact.
    let power = |e: i32| f64::from_bits(((1023 + e) as u64) << 52);
    match exponent {
        0 => sign * fraction * power(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        e => sign * (1024.0 + fraction) * power(e - 25),
    }
}

/// The components of a numeric type; quaternions are flagged.
fn numeric(kind: u64) -> Option<(Scalar, usize, bool)> {
    Some(match kind {
        2 => (Scalar::Byte, 1, false),
        3 => (Scalar::Int, 1, false),
        4 => (Scalar::Uint, 1, false),
        5 | 6 => (Scalar::Long, 1, false),
        7 => (Scalar::Half, 1, false),
        8 => (Scalar::Single, 1, false),
        9 | 56 => (Scalar::Double, 1, false),
        13 => (Scalar::Double, 4, false),
        14 => (Scalar::Double, 9, false),
        15 => (Scalar::Double, 16, false),
        16 => (Scalar::Double, 4, true),
        17 => (Scalar::Single, 4, true),
        18 => (Scalar::Half, 4, true),
        19..=30 => {
            let scalar =
                [Scalar::Double, Scalar::Single, Scalar::Half, Scalar::Int][(kind as usize - 19) % 4];
            (scalar, 2 + (kind as usize - 19) / 4, false)
        }
        _ => return None,
    })
}

/// Decodes a value.
pub(super) fn decode(file: &Binary, stored: u64, depth: u32) -> Read<Value> {
    let kind = stored >> 48 & 0xFF;
    let payload = stored & ((1 << 48) - 1);
    let (is_array, is_inline) = (stored & IS_ARRAY != 0, stored & IS_INLINE != 0);
    if let Some((scalar, width, is_quaternion)) = numeric(kind) {
        return if is_array {
            array(file, stored, payload, (scalar, width, is_quaternion))
        } else if is_inline {
            Ok(inline(payload as u32, kind, scalar, width))
        } else {
            let bytes = Cursor::new(&file.bytes, payload)?.take(scalar.size() * width)?;
            let mut list: Vec<f64> = bytes.chunks_exact(scalar.size()).map(|b| scalar.real(b)).collect();
            if is_quaternion {
                list.rotate_right(1);
            }
            Ok(match (list.as_slice(), scalar.is_whole()) {
                ([_], true) => Value::Int(scalar.whole(bytes)),
                ([v], false) => Value::Real(*v),
                _ => Value::Vector(list),
            })
        };
    }
    let at = || Cursor::new(&file.bytes, payload);
    match kind {
        1 if is_array => {
            let (mut cursor, count) = elements(file, payload, 1)?;
            Ok(Value::Ints(cursor.take(count)?.iter().map(|b| i64::from(*b != 0)).collect()))
        }
        1 => Ok(Value::Bool(if is_inline { payload as u8 != 0 } else { at()?.u8()? != 0 })),
        10 | 57 if is_array => indexed(file, payload, |i| file.string(i)).map(Value::Texts),
        11 | 12 if is_array => indexed(file, payload, |i| file.token(u64::from(i))).map(Value::Texts),
        10 => {
            let index = if is_inline { payload as u32 } else { at()?.u32()? };
            Ok(Value::Text(file.string(index)?.to_owned()))
        }
        11 | 12 => {
            let index = if is_inline { payload as u32 } else { at()?.u32()? };
            let text = file.token(u64::from(index))?.to_owned();
            Ok(if kind == 12 { Value::Asset(text) } else { Value::Text(text) })
        }
        31 if is_inline => Ok(Value::Dictionary(BTreeMap::new())),
        31 => dictionary(file, at()?, depth),
        32..=35 | 55 => list(file, at()?, kind),
        40 => texts(at()?, |i| file.path(i)).map(Value::Texts),
        41 => texts(at()?, |i| file.token(u64::from(i))).map(Value::Texts),
        50 => texts(at()?, |i| file.string(i)).map(Value::Texts),
        42 => Ok(Value::Text(["def", "over", "class"].get(payload as usize).unwrap_or(&"over").to_string())),
        45 => variants(file, at()?),
        46 => samples(file, at()?, depth),
        47 => {
            let items = vec![reference(file, &mut at()?, true)?];
            Ok(Value::References(ListEdit::of(items)))
        }
        48 => {
            let mut cursor = at()?;
            let count = cursor.count(8)?;
            Ok(Value::Doubles(1, (0..count).map(|_| cursor.f64()).collect::<Read<_>>()?))
        }
        49 => {
            let mut cursor = at()?;
            let count = cursor.count(16)?;
            let offset = |c: &mut Cursor<'_>| Ok(Offset { offset: c.f64()?, scale: c.f64()? });
            Ok(Value::Offsets((0..count).map(|_| offset(&mut cursor)).collect::<Read<_>>()?))
        }
        51 => Ok(Value::Blocked),
        _ => Ok(Value::Other),
    }
}

/// A value within the 32 bits of its payload.
fn inline(bits: u32, kind: u64, scalar: Scalar, width: usize) -> Value {
    let small = |i: usize| f64::from(bits.to_le_bytes()[i % 4] as i8);
    match (scalar, width) {
        (Scalar::Byte, 1) => Value::Int(i64::from(bits as u8)),
        (Scalar::Uint, 1) => Value::Int(i64::from(bits)),
        (Scalar::Int | Scalar::Long, 1) => Value::Int(i64::from(bits as i32)),
        (Scalar::Half, 1) => Value::Real(half(bits as u16)),
        (Scalar::Single | Scalar::Double, 1) => Value::Real(f64::from(f32::from_bits(bits))),
        // Two half-precision numbers fit as they are.
        (Scalar::Half, 2) => Value::Vector(vec![half(bits as u16), half((bits >> 16) as u16)]),
        // A diagonal matrix of small whole numbers.
        _ if (13..=15).contains(&kind) => {
            let side = kind as usize - 11;
            let entry = |i: usize| if i.is_multiple_of(side + 1) { small(i / (side + 1)) } else { 0.0 };
            Value::Vector((0..side * side).map(entry).collect())
        }
        // A vector of small whole numbers.
        _ => Value::Vector((0..width).map(small).collect()),
    }
}

/// The position of the elements of an array and their number.
fn elements(file: &Binary, payload: u64, size: usize) -> Read<(Cursor<'_>, usize)> {
    let mut cursor = Cursor::new(&file.bytes, payload)?;
    if payload == 0 {
        return Ok((cursor, 0));
    }
    if file.version < (0, 5) {
        cursor.u32()?;
    }
    let count = if file.version < (0, 7) { u64::from(cursor.u32()?) } else { cursor.u64()? };
    let count = usize::try_from(count).ok().filter(|n| *n <= MAX_ELEMENTS).ok_or_else(|| {
        Broken::new(format!("an array of {count} elements; at most {MAX_ELEMENTS} are read"))
    })?;
    if count.checked_mul(size).is_none_or(|n| n > file.bytes.len() - cursor.at) {
        return Err(ended());
    }
    Ok((cursor, count))
}

/// An array of numbers.
fn array(file: &Binary, stored: u64, payload: u64, kind: (Scalar, usize, bool)) -> Read<Value> {
    let (scalar, width, is_quaternion) = kind;
    /// Shorter arrays are not compressed.
    const SHORT: usize = 16;
    let may_compress = match scalar {
        Scalar::Int | Scalar::Uint | Scalar::Long => file.version >= (0, 5),
        Scalar::Half | Scalar::Single | Scalar::Double => file.version >= (0, 6),
        Scalar::Byte => false,
    };
    if may_compress && width == 1 && stored & IS_COMPRESSED != 0 {
        let (mut cursor, count) = elements(file, payload, 0)?;
        if count >= SHORT {
            return compressed(&mut cursor, count, scalar);
        }
    }
    let (mut cursor, count) = elements(file, payload, scalar.size() * width)?;
    let bytes = cursor.take(count * scalar.size() * width)?;
    let numbers = bytes.chunks_exact(scalar.size());
    if scalar.is_whole() {
        return Ok(Value::Ints(numbers.map(|b| scalar.whole(b)).collect()));
    }
    if scalar == Scalar::Double {
        let mut list: Vec<f64> = numbers.map(|b| scalar.real(b)).collect();
        if is_quaternion {
            list.chunks_exact_mut(4).for_each(|q| q.rotate_right(1));
        }
        return Ok(Value::Doubles(width, list));
    }
    let mut list: Vec<f32> = numbers.map(|b| scalar.real(b) as f32).collect();
    if is_quaternion {
        list.chunks_exact_mut(4).for_each(|q| q.rotate_right(1));
    }
    Ok(Value::Floats(width, list))
}

fn compressed(cursor: &mut Cursor<'_>, count: usize, scalar: Scalar) -> Read<Value> {
    if scalar.is_whole() {
        let list = integers(cursor, count, scalar == Scalar::Long)?;
        let unsigned = |v: i64| if scalar == Scalar::Uint { i64::from(v as u32) } else { v };
        return Ok(Value::Ints(list.into_iter().map(unsigned).collect()));
    }
    let list: Vec<f64> = match cursor.u8()? {
        // Whole numbers.
        b'i' => integers(cursor, count, false)?.into_iter().map(|v| v as f64).collect(),
        // A table and indices.
        b't' => {
            let size = cursor.u32()? as usize;
            let bytes = cursor.take(size.checked_mul(scalar.size()).ok_or_else(ended)?)?;
            let table: Vec<f64> = bytes.chunks_exact(scalar.size()).map(|b| scalar.real(b)).collect();
            let entry =
                |i: i64| usize::try_from(i).ok().and_then(|i| table.get(i)).copied().ok_or_else(ended);
            integers(cursor, count, false)?.into_iter().map(entry).collect::<Read<_>>()?
        }
        _ => return Err(Broken::new("has numbers in an unknown compression")),
    };
    Ok(match scalar {
        Scalar::Double => Value::Doubles(1, list),
        _ => Value::Floats(1, list.into_iter().map(|v| v as f32).collect()),
    })
}

fn indexed<'a>(file: &'a Binary, payload: u64, of: impl Fn(u32) -> Read<&'a str>) -> Read<Vec<String>> {
    let (mut cursor, count) = elements(file, payload, 4)?;
    (0..count).map(|_| Ok(of(cursor.u32()?)?.to_owned())).collect()
}

fn texts<'a>(mut cursor: Cursor<'_>, of: impl Fn(u32) -> Read<&'a str>) -> Read<Vec<String>> {
    read_texts(&mut cursor, of)
}

fn read_texts<'a>(cursor: &mut Cursor<'_>, of: impl Fn(u32) -> Read<&'a str>) -> Read<Vec<String>> {
    let count = cursor.count(4)?;
    (0..count).map(|_| Ok(of(cursor.u32()?)?.to_owned())).collect()
}

fn dictionary(file: &Binary, mut cursor: Cursor<'_>, depth: u32) -> Read<Value> {
    if depth > MAX_DEPTH {
        return Err(Broken::new(format!("has dictionaries nested more than {MAX_DEPTH} deep")));
    }
    let mut entries = BTreeMap::new();
    for _ in 0..cursor.count(12)? {
        let key = file.string(cursor.u32()?)?.to_owned();
        cursor.jump()?;
        let value = Value::Stored(cursor.u64()?);
        entries.insert(key, value);
    }
    // Only the entries of interest are decoded: a dictionary may name itself.
    Ok(Value::Dictionary(entries))
}

fn variants(file: &Binary, mut cursor: Cursor<'_>) -> Read<Value> {
    let mut entries = BTreeMap::new();
    for _ in 0..cursor.count(8)? {
        let (key, value) = (file.string(cursor.u32()?)?, file.string(cursor.u32()?)?);
        entries.insert(key.to_owned(), Value::Text(value.to_owned()));
    }
    Ok(Value::Dictionary(entries))
}

fn samples(file: &Binary, mut cursor: Cursor<'_>, depth: u32) -> Read<Value> {
    cursor.jump()?;
    let times = cursor.u64()?;
    if depth > 0 || !matches!(times >> 48 & 0xFF, 9 | 48) {
        return Err(Broken::new("has damaged time samples"));
    }
    let Value::Doubles(1, times) = decode(file, times, depth + 1)? else {
        return Err(Broken::new("has damaged time samples"));
    };
    cursor.jump()?;
    if cursor.count(8)? != times.len() {
        return Err(Broken::new("has damaged time samples"));
    }
    let value = |cursor: &mut Cursor<'_>| cursor.u64().map(Value::Stored);
    let values: Vec<Value> = times.iter().map(|_| value(&mut cursor)).collect::<Read<_>>()?;
    let mut samples: Vec<(f64, Value)> = times.into_iter().zip(values).collect();
    samples.retain(|(time, _)| time.is_finite());
    samples.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(Value::Samples(samples))
}

/// Edits of a list.
fn list(file: &Binary, mut cursor: Cursor<'_>, kind: u64) -> Read<Value> {
    let header = cursor.u8()?;
    match kind {
        32 => edits(header, &mut cursor, |c| read_texts(c, |i| file.token(u64::from(i)))).map(Value::List),
        33 => edits(header, &mut cursor, |c| read_texts(c, |i| file.string(i))).map(Value::List),
        34 => edits(header, &mut cursor, |c| read_texts(c, |i| file.path(i))).map(Value::List),
        _ => {
            let read = |c: &mut Cursor<'_>| {
                let count = c.count(8)?;
                (0..count).map(|_| reference(file, c, kind == 55)).collect()
            };
            edits(header, &mut cursor, read).map(Value::References)
        }
    }
}

fn edits<T>(
    header: u8,
    cursor: &mut Cursor<'_>,
    mut read: impl FnMut(&mut Cursor<'_>) -> Read<Vec<T>>,
) -> Read<ListEdit<T>> {
    let mut edit = ListEdit::default();
    if header & 1 != 0 {
        edit.explicit = Some(Vec::new());
    }
    if header & 2 != 0 {
        edit.explicit = Some(read(cursor)?);
    }
    if header & 4 != 0 {
        edit.added = read(cursor)?;
    }
    if header & 32 != 0 {
        edit.prepended = read(cursor)?;
    }
    if header & 64 != 0 {
        edit.appended = read(cursor)?;
    }
    if header & 8 != 0 {
        edit.deleted = read(cursor)?;
    }
    Ok(edit)
}

fn reference(file: &Binary, cursor: &mut Cursor<'_>, is_payload: bool) -> Read<Reference> {
    let asset = file.string(cursor.u32()?)?.to_owned();
    let prim = file.path(cursor.u32()?)?.to_owned();
    let mut offset = Offset::default();
    if !is_payload || file.version >= (0, 8) {
        offset = Offset { offset: cursor.f64()?, scale: cursor.f64()? };
    }
    if !is_payload {
        // Custom data, which are skipped.
        for _ in 0..cursor.count(12)? {
            cursor.u32()?;
            cursor.jump()?;
            cursor.u64()?;
        }
    }
    let prim = if prim == "/" { String::new() } else { prim };
    Ok(Reference { asset, prim, offset })
}
