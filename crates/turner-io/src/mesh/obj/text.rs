//! Tokenizer for OBJ.
//!
//! A statement ends with its line, unless the line ends with a backslash. A `#` at the start of a word begins a
//! comment; inside a word it does not, because some C libraries print NaN as `1.#IND`.

use crate::mesh::number::{parse_f32, quick_f32};

/// A text and the current position.
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Line ends before the position.
    pub(super) lines: u64,
}

/// The result of reading a number.
pub(super) enum Found<'a> {
    Number(f32),
    /// A word that is not a number.
    Word(&'a [u8]),
    /// The end of the statement.
    End,
}

impl<'a> Text<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Text<'a> {
        Text { bytes, at: 0, lines: 0 }
    }

    /// The byte `ahead` bytes from here; a line feed beyond the end of the text.
    #[inline(always)]
    pub(super) fn peek(&self, ahead: usize) -> u8 {
        self.bytes.get(self.at + ahead).copied().unwrap_or(b'\n')
    }

    #[inline(always)]
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or(&[])
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, bytes: usize) {
        self.at += bytes;
    }

    pub(super) fn back(&mut self, bytes: usize) {
        self.at = self.at.saturating_sub(bytes);
    }

    /// Advances to the next statement; false at the end of the text.
    #[inline]
    pub(super) fn next_statement(&mut self) -> bool {
        loop {
            self.skip_blanks();
            if self.at >= self.bytes.len() {
                return false;
            }
            if self.bytes[self.at] != b'\n' {
                return true;
            }
            self.at += 1;
            self.lines += 1;
        }
    }

    /// Length of a line continuation (backslash and line end) here; 0 if there is none.
    #[inline]
    fn continuation(&self) -> usize {
        match (self.peek(0), self.peek(1), self.peek(2)) {
            (b'\\', b'\n', _) if self.at + 1 < self.bytes.len() => 2,
            (b'\\', b'\r', b'\n') if self.at + 2 < self.bytes.len() => 3,
            // A backslash at the very end of the text.
            (b'\\', ..) if self.at + 1 >= self.bytes.len() => 1,
            _ => 0,
        }
    }

    /// Skips white space and line continuations.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        loop {
            let byte = self.peek(0);
            if byte == b' ' {
                self.at += 1;
            } else if byte > b'\\' || byte == b'\n' {
                return;
            } else if byte == b'\\' {
                let len = self.continuation();
                if len == 0 {
                    return;
                }
                self.at += len;
                self.lines += u64::from(len > 1);
            } else if byte.is_ascii_whitespace() {
                self.at += 1;
            } else {
                return;
            }
        }
    }

    /// Whether a word ends here.
    #[inline(always)]
    pub(super) fn ends_word(&self) -> bool {
        let byte = self.peek(0);
        byte <= b' ' && byte.is_ascii_whitespace() || byte == b'\\' && self.continuation() > 0
    }

    /// Whether the statement ends here; white space must have been skipped.
    #[inline(always)]
    pub(super) fn ends_statement(&self) -> bool {
        matches!(self.peek(0), b'\n' | b'#')
    }

    /// Reads the word that begins here.
    #[inline]
    pub(super) fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while !self.ends_word() {
            self.at += 1;
        }
        self.bytes.get(start..self.at).unwrap_or(&[])
    }

    /// Reads the next number of the statement, in any form that C's printf writes, such as `1.#IND` and
    /// `nan(ind)`.
    #[inline]
    pub(super) fn number(&mut self) -> Found<'a> {
        self.skip_blanks();
        if self.ends_statement() {
            return Found::End;
        }
        let start = self.at;
        if let Some((value, len)) = quick_f32(self.rest()) {
            self.at += len;
            if self.ends_word() {
                return Found::Number(value);
            }
            self.at = start;
        }
        let word = self.word();
        match number(word) {
            Some(value) => Found::Number(value),
            None => Found::Word(word),
        }
    }

    /// Skips to the end of the statement; returns the skipped text, including comments.
    #[inline]
    pub(super) fn skip_statement(&mut self) -> &'a [u8] {
        let start = self.at;
        loop {
            let rest = self.rest();
            self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            let line = self.bytes.get(start..self.at).unwrap_or(&[]);
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if self.at >= self.bytes.len() || !line.ends_with(b"\\") {
                return line;
            }
            self.at += 1;
            self.lines += 1;
        }
    }
}

/// A number; NaN for C's spellings of non-finite values.
fn number(word: &[u8]) -> Option<f32> {
    parse_f32(word).or_else(|| {
        let bare = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
        bare.get(..3).filter(|b| b.eq_ignore_ascii_case(b"nan") || *b == b"1.#").map(|_| f32::NAN)
    })
}

/// The words of the rest of a statement, without a comment.
pub(in crate::mesh) fn words(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            at += rest.get(at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
            let word = rest.get(at..)?.split(u8::is_ascii_whitespace).next()?;
            at += word.len();
            if word.starts_with(b"#") {
                at = rest.len();
                return None;
            }
            // A backslash that continues the line, not one in a path.
            let continues = matches!(rest.get(at), Some(b'\n' | b'\r'));
            let word = if continues { word.strip_suffix(b"\\").unwrap_or(word) } else { word };
            if !word.is_empty() {
                return Some(word);
            }
        }
    })
}

/// A name: the words joined by single spaces.
pub(in crate::mesh) fn name(rest: &[u8]) -> String {
    let words: Vec<_> = words(rest).map(String::from_utf8_lossy).collect();
    words.join(" ")
}
