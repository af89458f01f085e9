//! Bytes, variable-length integers and bits of a Draco stream, in order.

use super::{Damage, Read};

/// Reads bytes in order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Reader<'a> {
        Reader { bytes }
    }

    /// Number of bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len()
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Read<&'a [u8]> {
        let Some((taken, rest)) = self.bytes.split_at_checked(count) else {
            let found = self.bytes.len();
            return Err(Damage::Stream(format!("is cut off: it has {found} of {count} bytes")));
        };
        self.bytes = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        Ok(self.take(N)?.first_chunk().copied().unwrap_or([0; N]))
    }

    pub(super) fn byte(&mut self) -> Read<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn u16(&mut self) -> Read<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Read<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub(super) fn i32(&mut self) -> Read<i32> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    pub(super) fn f32(&mut self) -> Read<f32> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    /// An unsigned integer in LEB128: seven bits per byte, lowest first.
    fn leb128(&mut self, bits: u32) -> Read<u64> {
        let mut value = 0u64;
        for shift in (0..bits).step_by(7) {
            let byte = self.byte()?;
            let part = u64::from(byte & 127);
            if shift + 7 > bits && part >> (bits - shift) != 0 {
                break;
            }
            value |= part << shift;
            if byte < 128 {
                return Ok(value);
            }
        }
        Err(Damage::Stream(format!("holds an integer of more than {bits} bits")))
    }

    /// A variable-length integer of up to 32 bits.
    pub(super) fn varint(&mut self) -> Read<u32> {
        Ok(self.leb128(32)? as u32)
    }

    /// A size in bytes of up to 64 bits, and as many bytes.
    pub(super) fn sized(&mut self) -> Read<&'a [u8]> {
        let size = self.leb128(64)?;
        self.take(usize::try_from(size).unwrap_or(usize::MAX))
    }
}

/// Reads bits from the lowest of each byte.
#[derive(Debug)]
pub(super) struct Bits<'a> {
    reader: Reader<'a>,
    held: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(reader: Reader<'a>) -> Bits<'a> {
        Bits { reader, held: 0, count: 0 }
    }

    /// The next `count` bits, at most 32; the first is the lowest.
    pub(super) fn take(&mut self, count: u32) -> Read<u32> {
        while self.count < count {
            self.held |= u64::from(self.reader.byte()?) << self.count;
            self.count += 8;
        }
        let value = self.held & ((1u64 << count) - 1);
        self.held >>= count;
        self.count -= count;
        Ok(value as u32)
    }

    /// What follows the last byte that was begun.
    pub(super) fn rest(self) -> Reader<'a> {
        self.reader
    }
}
