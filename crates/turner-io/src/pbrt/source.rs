//! The bytes of a file through a moving window: a text of any length takes little memory.

pub(super) use crate::scene_import::Place;
use std::io::Read;

/// Bytes read at a time.
const CHUNK: usize = 1 << 18;

/// Bytes available wherever a token begins, unless the file ends: more than any number has.
const AHEAD: usize = 512;

/// A file that is being read.
pub(super) struct Source<'a> {
    reader: Box<dyn Read + 'a>,
    window: Vec<u8>,
    /// Position in the window.
    at: usize,
    /// Whether the reader is at its end.
    ended: bool,
    /// The last position asked for: index in the window, line and column.
    mark: (usize, Place),
}

impl<'a> Source<'a> {
    /// Reads from `reader`; `file` is its index in positions.
    pub(super) fn new(reader: Box<dyn Read + 'a>, file: u32) -> Source<'a> {
        let start = Place { file, line: 1, column: 1 };
        Source { reader, window: Vec::new(), at: 0, ended: false, mark: (0, start) }
    }

    /// The available bytes from here on: at least [`AHEAD`], or all that are left.
    #[inline]
    pub(super) fn rest(&mut self) -> std::io::Result<&[u8]> {
        if self.window.len() - self.at < AHEAD && !self.ended {
            self.fill()?;
        }
        Ok(self.window.get(self.at..).unwrap_or_default())
    }

    /// Skips `count` bytes of [`Source::rest`].
    #[inline]
    pub(super) fn skip(&mut self, count: usize) {
        self.at = (self.at + count).min(self.window.len());
    }

    /// The current line and column. Calls follow the order of the file, so that each byte is counted once.
    pub(super) fn place(&mut self) -> Place {
        let (from, place) = &mut self.mark;
        let passed = self.window.get(*from..self.at).unwrap_or_default();
        let characters = |bytes: &[u8]| bytes.iter().filter(|b| **b & 0xc0 != 0x80).count() as u32;
        match memchr::memrchr(b'\n', passed) {
            None => place.column = place.column.saturating_add(characters(passed)),
            Some(last) => {
                let lines = memchr::memchr_iter(b'\n', passed).count() as u32;
                place.line = place.line.saturating_add(lines);
                place.column = 1 + characters(passed.get(last + 1..).unwrap_or_default());
            }
        }
        *from = self.at;
        *place
    }

    #[cold]
    fn fill(&mut self) -> std::io::Result<()> {
        self.place();
        self.window.drain(..self.at);
        (self.at, self.mark.0) = (0, 0);
        while self.window.len() < CHUNK {
            let have = self.window.len();
            self.window.resize(CHUNK, 0);
            let count = loop {
                match self.reader.read(self.window.get_mut(have..).unwrap_or_default()) {
                    Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                    other => break other,
                }
            };
            self.window.truncate(have + *count.as_ref().unwrap_or(&0));
            if count? == 0 {
                self.ended = true;
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_over_chunks() {
        let mut text = String::new();
        for i in 0..60_000 {
            text += &format!("é line {i}\n");
        }
        let mut source = Source::new(Box::new(text.as_bytes()), 3);
        let mut expected = Vec::new();
        let (mut line, mut column) = (1, 1);
        for c in text.chars() {
            expected.push((line, column, c.len_utf8()));
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        for (i, (line, column, bytes)) in expected.into_iter().enumerate() {
            assert!(!source.rest().unwrap().is_empty());
            if i % 97 == 0 {
                assert_eq!(source.place(), Place { file: 3, line, column });
            }
            source.skip(bytes);
        }
        assert!(source.rest().unwrap().is_empty());
    }
}
