//! Little-endian numbers of a byte slice.

use crate::usd::value::{Broken, Read};

/// Reads numbers one after the other.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], at: u64) -> Read<Cursor<'a>> {
        match usize::try_from(at) {
            Ok(at) if at <= bytes.len() => Ok(Cursor { bytes, at }),
            _ => Err(ended()),
        }
    }

    pub(super) fn take(&mut self, count: usize) -> Read<&'a [u8]> {
        let end = self.at.checked_add(count).ok_or_else(ended)?;
        let bytes = self.bytes.get(self.at..end).ok_or_else(ended)?;
        self.at = end;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        self.take(N)?.try_into().map_err(|_| ended())
    }

    pub(super) fn u8(&mut self) -> Read<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self) -> Read<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Read<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn i64(&mut self) -> Read<i64> {
        self.array().map(i64::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Read<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A number of elements of `size` bytes that follow: more than there are bytes is an error.
    pub(super) fn count(&mut self, size: usize) -> Read<usize> {
        let count = self.u64()?;
        let left = (self.bytes.len() - self.at) / size.max(1);
        usize::try_from(count).ok().filter(|n| *n <= left).ok_or_else(ended)
    }

    /// Moves by an offset that is relative to its own position.
    pub(super) fn jump(&mut self) -> Read<()> {
        let from = self.at as i64;
        let to = from.checked_add(self.i64()?).and_then(|to| usize::try_from(to).ok());
        self.at = to.filter(|to| *to <= self.bytes.len()).ok_or_else(ended)?;
        Ok(())
    }
}

/// The error for data that go beyond the file.
pub(super) fn ended() -> Broken {
    Broken::new("its data end too early")
}
