//! Reads values one after the other, from ASCII or binary data: the general path for any layout.

use super::Fail;
use super::header::{Encoding, Scalar};
use crate::assets::printable;
use crate::mesh::Place;
use crate::mesh::number::parse_f64;

/// The data after the header, and the current position.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    encoding: Encoding,
}

impl<'a> Values<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize, line: u64, encoding: Encoding) -> Self {
        Values { bytes, at: at.min(bytes.len()), line, encoding }
    }

    /// The unread bytes.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Skips bytes of a binary file that were decoded elsewhere.
    pub(super) fn advance(&mut self, bytes: usize) {
        self.at = (self.at + bytes).min(self.bytes.len());
    }

    pub(super) fn place(&self) -> Place {
        match self.encoding {
            Encoding::Ascii => Place::Line(self.line),
            _ => Place::Byte(self.at as u64),
        }
    }

    pub(super) fn fail(&self, problem: String) -> Fail {
        Fail { place: self.place(), problem }
    }

    /// Reads the next value.
    pub(super) fn next(&mut self, scalar: Scalar) -> Result<f64, Fail> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            return parse_f64(word).ok_or_else(|| {
                let shown = printable(&String::from_utf8_lossy(&word[..word.len().min(40)]));
                self.fail(format!("expected a number, found \"{shown}\""))
            });
        }
        let Some(bytes) = self.rest().get(..scalar.size()) else {
            return Err(self.fail("the file ends inside a value".into()));
        };
        self.at += bytes.len();
        Ok(binary(bytes, scalar, self.encoding == Encoding::BigEndian))
    }

    fn word(&mut self) -> Result<&'a [u8], Fail> {
        let rest = self.rest();
        let blank = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        self.line += rest[..blank].iter().filter(|&&b| b == b'\n').count() as u64;
        self.at += blank;
        let rest = self.rest();
        let len = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if len == 0 {
            return Err(self.fail("the file ends where a number is expected".into()));
        }
        self.at += len;
        Ok(&rest[..len])
    }

    /// Reads the length of a list; it must be an integer that fits in the rest of the file.
    pub(super) fn list_len(&mut self, count: Scalar, item: Scalar) -> Result<usize, Fail> {
        let n = self.next(count)?;
        let least = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        // The last number of an ASCII file needs no space after it.
        let room = (self.rest().len() + 1) / least;
        if n >= 0.0 && n.fract() == 0.0 && n <= room as f64 {
            return Ok(n as usize);
        }
        Err(self.fail(format!("a list of {n} values, but the rest of the file holds at most {room}")))
    }
}

/// Decodes a binary value; missing bytes count as 0.
pub(super) fn binary(bytes: &[u8], scalar: Scalar, big_endian: bool) -> f64 {
    let mut raw = [0_u8; 8];
    for (i, slot) in raw[..scalar.size()].iter_mut().enumerate() {
        let from = if big_endian { scalar.size() - 1 - i } else { i };
        *slot = bytes.get(from).copied().unwrap_or_default();
    }
    let bits = u64::from_le_bytes(raw);
    match scalar {
        Scalar::I8 => f64::from(bits as u8 as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as u16 as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as u32 as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}
