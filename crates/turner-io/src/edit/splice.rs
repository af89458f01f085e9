//! Changes of a text: places to replace, insert and cut, applied together.

use std::ops::Range;

use turner::schema::value::{Data, Entry, Value};

/// Changes of one text. Everything between them stays as it is, byte for byte.
pub(super) struct Splices<'a> {
    text: &'a str,
    newline: &'static str,
    cuts: Vec<(Range<usize>, String)>,
    inserts: Vec<(usize, String)>,
}

impl<'a> Splices<'a> {
    pub(super) fn new(text: &'a str) -> Splices<'a> {
        let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
        Splices { text, newline, cuts: Vec::new(), inserts: Vec::new() }
    }

    /// Replaces a range.
    pub(super) fn replace(&mut self, range: Range<usize>, new: String) {
        self.cuts.push((range, self.lines(new)));
    }

    /// Takes back replacements within a range.
    pub(super) fn forget(&mut self, range: &Range<usize>) {
        self.cuts.retain(|(cut, _)| cut.start < range.start || cut.end > range.end);
    }

    /// Inserts whole lines at the beginning of a line, or at the end of the text.
    pub(super) fn insert(&mut self, at: usize, lines: String) {
        let lines = self.lines(lines);
        self.inserts.push((at, lines));
    }

    /// The lines with the line breaks of the text.
    fn lines(&self, text: String) -> String {
        if self.newline == "\n" { text } else { text.replace("\r\n", "\n").replace('\n', self.newline) }
    }

    /// The beginning of the line of a byte. A byte order mark stays before the first line.
    pub(super) fn line_start(&self, at: usize) -> usize {
        let start = self.text[..at].rfind('\n').map_or(0, |i| i + 1);
        if start == 0 && self.text.starts_with('\u{feff}') { 3 } else { start }
    }

    /// The end of the line of a byte, after its line break.
    pub(super) fn line_end(&self, at: usize) -> usize {
        self.text[at..].find('\n').map_or(self.text.len(), |i| at + i + 1)
    }

    /// Whether a value is a table or list under headers, or a table of dotted keys, rather than a value after `=`.
    pub(super) fn is_spread(&self, value: &Value) -> bool {
        let first = || self.text[value.span.start as usize..].chars().next();
        match &value.data {
            Data::Table(_) => first() != Some('{'),
            Data::Array(items) => {
                let header = |item: &Value| {
                    matches!(item.data, Data::Table(_))
                        && self.text[item.span.start as usize..].starts_with("[[")
                };
                items.first().is_some_and(header)
            }
            _ => false,
        }
    }

    /// The end of everything that belongs to a value, after its line break.
    pub(super) fn block_end(&self, value: &Value) -> usize {
        self.line_end(self.content_end(value))
    }

    fn content_end(&self, value: &Value) -> usize {
        let own = value.span.end as usize;
        if !self.is_spread(value) {
            return own;
        }
        match &value.data {
            Data::Table(table) => {
                table.entries.iter().map(|e| self.content_end(&e.value)).fold(own, usize::max)
            }
            Data::Array(items) => items.iter().map(|item| self.content_end(item)).fold(0, usize::max),
            _ => own,
        }
    }

    /// Cuts a table with its header, the comment directly above it and the blank lines below it.
    pub(super) fn cut_block(&mut self, value: &Value) {
        let mut start = self.line_start(value.span.start as usize);
        while start > 0 {
            let above = self.line_start(start - 1);
            if above >= start || !self.text[above..start].trim_start().starts_with('#') {
                break;
            }
            start = above;
        }
        let mut end = self.block_end(value);
        while end < self.text.len() && self.text[end..self.line_end(end)].trim().is_empty() {
            end = self.line_end(end);
        }
        self.cuts.push((start..end, String::new()));
    }

    /// Cuts a key with its value.
    ///
    /// Errors: a key that shares its line with others.
    pub(super) fn cut_entry(&mut self, entry: &Entry) -> Result<(), String> {
        match &entry.value.data {
            Data::Table(table) if self.is_spread(&entry.value) => {
                if self.text[entry.value.span.start as usize..].starts_with('[') {
                    self.cut_block(&entry.value);
                    return Ok(());
                }
                table.entries.iter().try_for_each(|entry| self.cut_entry(entry))
            }
            Data::Array(items) if self.is_spread(&entry.value) => {
                items.iter().for_each(|item| self.cut_block(item));
                Ok(())
            }
            _ => {
                let start = self.line_start(entry.key_span.start as usize);
                if self.text[start..entry.key_span.start as usize].contains(['{', '[', ',', '=']) {
                    return Err("a key shares its line with others".to_owned());
                }
                self.cuts.push((start..self.line_end(entry.value.span.end as usize), String::new()));
                Ok(())
            }
        }
    }

    /// The new text.
    ///
    /// Errors: changes that overlap.
    pub(super) fn apply(mut self) -> Result<String, String> {
        self.cuts.sort_by_key(|(range, _)| range.start);
        if self.cuts.windows(2).any(|pair| pair[0].0.end > pair[1].0.start) {
            return Err("changes overlap".to_owned());
        }
        // What is inserted into a cut comes after it.
        for (at, lines) in &mut self.inserts {
            let next = self.cuts.partition_point(|(range, _)| range.start < *at);
            if let Some((range, _)) = next.checked_sub(1).and_then(|i| self.cuts.get(i)) {
                if range.end > *at {
                    *at = range.end;
                }
                // The blank line above the cut stays; one below is missing.
                let above = self.text.get(..range.start).unwrap_or_default();
                let is_blank = above.ends_with("\n\n") || above.ends_with("\n\r\n");
                if is_blank && range.end == *at && lines.starts_with(['\r', '\n']) {
                    *lines = format!("{}{}", lines.trim_start_matches(['\r', '\n']), self.newline);
                }
            }
        }
        let mut all = self.cuts;
        all.extend(self.inserts.into_iter().map(|(at, text)| (at..at, text)));
        all.sort_by_key(|(range, _)| (range.end, range.start == range.end));
        let mut out = String::with_capacity(self.text.len() + 256);
        let mut at = 0;
        for (range, new) in all {
            out += self.text.get(at..range.start.max(at)).unwrap_or_default();
            if range.is_empty() && !out.is_empty() && !out.ends_with(['\n', '\u{feff}']) {
                out += self.newline;
            }
            out += &new;
            at = range.end.max(at);
        }
        out += self.text.get(at..).unwrap_or_default();
        Ok(out)
    }
}
