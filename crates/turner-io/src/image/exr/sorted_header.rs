//! Headers in the order of names, while a file is written.

use std::cell::Cell;
use std::io::{self, Seek, SeekFrom, Write};

use super::attributes::sort_attributes;
use crate::image::WriteSeek;

/// Holds the first bytes of an EXR file back until the pixels begin, and sorts the attributes among
/// them: the exr crate keeps them in a hash map, whose order differs between runs.
pub(super) struct SortedHeader<'a> {
    out: &'a mut dyn WriteSeek,
    /// The bytes so far, until they are written.
    start: Option<Vec<u8>>,
    has_long_names: bool,
    /// Whether all bytes before the pixels have been written.
    is_whole: &'a Cell<bool>,
}

impl<'a> SortedHeader<'a> {
    /// `has_long_names`: a channel has a name of more than 31 bytes.
    /// `is_whole` is set by the caller when all bytes before the pixels have been written.
    pub(super) fn new(
        out: &'a mut dyn WriteSeek,
        has_long_names: bool,
        is_whole: &'a Cell<bool>,
    ) -> SortedHeader<'a> {
        SortedHeader { out, start: Some(Vec::new()), has_long_names, is_whole }
    }

    /// Writes what is held back.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        let Some(mut bytes) = self.start.take() else { return Ok(()) };
        sort_attributes(&mut bytes);
        if let Some(flags) = bytes.get_mut(5).filter(|_| self.has_long_names) {
            // Bit 10 of the version field, at byte 4: names of up to 255 bytes. The exr crate sets it for attributes alone.
            *flags |= 1 << 2;
        }
        self.out.write_all(&bytes)
    }
}

impl Write for SortedHeader<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_whole.get() {
            self.finish()?;
        }
        match &mut self.start {
            Some(start) => {
                start.extend_from_slice(bytes);
                Ok(bytes.len())
            }
            None => self.out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.is_whole.get() { self.out.flush() } else { Ok(()) }
    }
}

impl Seek for SortedHeader<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.finish()?;
        self.out.seek(to)
    }
}
