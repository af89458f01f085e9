//! The bytes of one file as a window that moves over them, so that a text of any length is read in little memory.

pub(super) use crate::scene_import::Place;
use std::io::Read;

/// Bytes that are read at a time.
const CHUNK: usize = 1 << 18;

/// Bytes that are at hand wherever a token begins, if the file has so many left: more than any number takes.
const AHEAD: usize = 512;

/// A file that is being read.
pub(super) struct Source<'a> {
    reader: Box<dyn Read + 'a>,
    window: Vec<u8>,
    /// Where in the window reading goes on.
    at: usize,
    /// Whether the reader has no more.
    ended: bool,
    /// The last place that was asked for: index in the window and what is there.
    mark: (usize, Place),
}

impl<'a> Source<'a> {
    /// Reads from `reader`; `file` is its number in places.
    pub(super) fn new(reader: Box<dyn Read + 'a>, file: u32) -> Source<'a> {
        let start = Place { file, line: 1, column: 1 };
        Source { reader, window: Vec::new(), at: 0, ended: false, mark: (0, start) }
    }

    /// The bytes from here on that are at hand: at least [`AHEAD`], or all that are left.
    #[inline]
    pub(super) fn rest(&mut self) -> std::io::Result<&[u8]> {
        if self.window.len() - self.at < AHEAD && !self.ended {
            self.fill()?;
        }
        Ok(self.window.get(self.at..).unwrap_or_default())
    }

    /// Goes on by `count` bytes of [`Source::rest`].
    #[inline]
    pub(super) fn skip(&mut self, count: usize) {
        self.at = (self.at + count).min(self.window.len());
    }

    /// Where reading goes on. Places are asked for in the order of the file; each byte is looked at once for them.
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
