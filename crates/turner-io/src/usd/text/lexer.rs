//! Characters of a text layer: white space, words, strings, numbers, paths.

use crate::usd::value::{Broken, Read};

/// Reads a text layer from its first byte on.
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    text: &'a str,
    pub(super) at: usize,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Lexer<'a> {
        Lexer { bytes: text.as_bytes(), text, at: 0 }
    }

    /// The error for the current position.
    pub(super) fn broken(&self, problem: impl Into<String>) -> Broken {
        let before = self.bytes.get(..self.at.min(self.bytes.len())).unwrap_or_default();
        let line = before.iter().filter(|b| **b == b'\n').count() as u32 + 1;
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let column = before[start..].iter().filter(|b| **b & 0xC0 != 0x80).count() as u32 + 1;
        Broken { line, column, problem: problem.into() }
    }

    fn byte(&self, at: usize) -> u8 {
        self.bytes.get(at).copied().unwrap_or(0)
    }

    /// Skips white space, comments and the `;` between statements.
    pub(super) fn skip(&mut self) {
        loop {
            match self.byte(self.at) {
                b' ' | b'\t' | b'\r' | b'\n' | b';' => self.at += 1,
                b'#' => self.line(),
                b'/' if self.byte(self.at + 1) == b'/' => self.line(),
                b'/' if self.byte(self.at + 1) == b'*' => {
                    let rest = self.bytes.get(self.at + 2..).unwrap_or_default();
                    let end = rest.windows(2).position(|w| w == b"*/");
                    self.at = end.map_or(self.bytes.len(), |n| self.at + n + 4);
                }
                _ => break,
            }
        }
    }

    fn line(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|b| *b == b'\n');
        self.at = end.map_or(self.bytes.len(), |n| self.at + n);
    }

    /// The next byte after white space; 0 at the end.
    pub(super) fn peek(&mut self) -> u8 {
        self.skip();
        self.byte(self.at)
    }

    /// Whether the text has ended.
    pub(super) fn is_over(&mut self) -> bool {
        self.skip();
        self.at >= self.bytes.len()
    }

    /// Takes a byte if it is next.
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == byte && self.at < self.bytes.len();
        self.at += usize::from(is_next);
        is_next
    }

    pub(super) fn expect(&mut self, byte: u8) -> Read<()> {
        if self.take(byte) {
            return Ok(());
        }
        Err(self.unexpected(&format!("\"{}\"", char::from(byte))))
    }

    /// The error for what is next instead of `wanted`.
    pub(super) fn unexpected(&mut self, wanted: &str) -> Broken {
        self.skip();
        match self.text.get(self.at..).and_then(|rest| rest.chars().next()) {
            Some(c) => self.broken(format!("expected {wanted}, found {c:?}")),
            None => self.broken(format!("expected {wanted}, found the end of the file")),
        }
    }

    /// A name with its namespaces, such as `primvars:st`; empty if none is next.
    pub(super) fn word(&mut self) -> &'a str {
        self.skip();
        let start = self.at;
        while is_word(self.byte(self.at)) && !(self.at == start && self.byte(start).is_ascii_digit()) {
            self.at += 1;
        }
        self.text.get(start..self.at).unwrap_or_default()
    }

    /// The word that is next, which is not taken.
    pub(super) fn peek_word(&mut self) -> &'a str {
        let word = self.word();
        self.at -= word.len();
        word
    }

    /// Takes a word if it is next.
    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let is_next = self.peek_word() == word;
        self.at += if is_next { word.len() } else { 0 };
        is_next
    }

    /// A string in quotes of any kind.
    pub(super) fn string(&mut self) -> Read<String> {
        let quote = self.peek();
        if quote != b'"' && quote != b'\'' {
            return Err(self.unexpected("a string in quotes"));
        }
        let is_long = self.byte(self.at + 1) == quote && self.byte(self.at + 2) == quote;
        let begin = self.at;
        self.at += if is_long { 3 } else { 1 };
        let mut out: Vec<u8> = Vec::new();
        loop {
            let Some(&byte) = self.bytes.get(self.at) else {
                self.at = begin;
                return Err(self.broken("a string without its closing quote"));
            };
            if byte == b'\\' {
                self.escape(&mut out);
                continue;
            }
            if byte == quote
                && (!is_long || (self.byte(self.at + 1) == quote && self.byte(self.at + 2) == quote))
            {
                self.at += if is_long { 3 } else { 1 };
                break;
            }
            if byte == b'\n' && !is_long {
                self.at = begin;
                return Err(self.broken("a string without its closing quote"));
            }
            out.push(byte);
            self.at += 1;
        }
        Ok(String::from_utf8_lossy(&out).into_owned())
    }

    fn escape(&mut self, out: &mut Vec<u8>) {
        let next = self.byte(self.at + 1);
        self.at = (self.at + 2).min(self.bytes.len());
        match next {
            b'n' => out.push(b'\n'),
            b't' => out.push(b'\t'),
            b'r' => out.push(b'\r'),
            b'x' => {
                let digits = self.text.get(self.at..self.at + 2).unwrap_or_default();
                if let Ok(byte) = u8::from_str_radix(digits, 16) {
                    out.push(byte);
                    self.at += 2;
                }
            }
            other => out.push(other),
        }
    }

    /// `@path@` or `@@@path@@@`.
    pub(super) fn asset(&mut self) -> Read<String> {
        self.expect(b'@')?;
        let rest = self.text.get(self.at..).unwrap_or_default();
        let mark = if rest.starts_with("@@") { "@@@" } else { "@" };
        let body = &rest[mark.len() - 1..];
        let Some(end) = body.find(mark) else {
            return Err(self.broken("a path without its closing @"));
        };
        self.at += mark.len() - 1 + end + mark.len();
        Ok(body[..end].replace("\\@@@", "@@@"))
    }

    /// `<path>`.
    pub(super) fn path(&mut self) -> Read<String> {
        self.expect(b'<')?;
        let rest = self.text.get(self.at..).unwrap_or_default();
        let Some(end) = rest.find(['>', '\n']).filter(|n| rest.as_bytes().get(*n) == Some(&b'>')) else {
            return Err(self.broken("a path without its closing >"));
        };
        self.at += end + 1;
        Ok(rest[..end].trim().to_owned())
    }

    /// The characters of a number, among them `inf` and `nan`.
    pub(super) fn number(&mut self) -> Read<&'a str> {
        self.skip();
        let start = self.at;
        while matches!(self.byte(self.at), b'0'..=b'9' | b'+' | b'-' | b'.' | b'a'..=b'z' | b'A'..=b'Z') {
            self.at += 1;
        }
        let text = self.text.get(start..self.at).unwrap_or_default();
        if text.is_empty() {
            return Err(self.unexpected("a number"));
        }
        Ok(text)
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte == b':' || byte >= 0x80
}
