//! The XML of scenes: elements with attributes, comments, the five named entities and numeric ones. Document
//! types are refused, and with them entities that a file defines or loads. Text between elements is an error.

use turner::schema::ErrorCode;

use crate::assets::printable;
use crate::scene_import::Place;
use crate::scene_import::report::Fault;

/// Most attributes of one element.
const MAX_ATTRIBUTES: usize = 64;

/// The next part of a file.
#[derive(Debug, PartialEq)]
pub(super) enum Event {
    /// `<name a="b">`, or `<name a="b"/>`, which also ends the element.
    Start { name: String, attributes: Vec<(String, String)>, ends: bool },
    /// `</name>`.
    End { name: String },
    /// The end of the file.
    Eof,
}

/// Reads the text of one file.
pub(super) struct Reader<'a> {
    text: &'a str,
    at: usize,
    file: u32,
    /// The last position asked for: offset, line and column.
    mark: (usize, u32, u32),
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a str, file: u32) -> Reader<'a> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Reader { text, at: 0, file, mark: (0, 1, 1) }
    }

    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// The current position; each byte is counted once.
    pub(super) fn place(&mut self) -> Place {
        let (from, line, column) = &mut self.mark;
        for c in self.text.get(*from..self.at).unwrap_or_default().chars() {
            if c == '\n' {
                (*line, *column) = (line.saturating_add(1), 1);
            } else {
                *column = column.saturating_add(1);
            }
        }
        *from = self.at;
        Place { file: self.file, line: *line, column: *column }
    }

    fn fault(&mut self, problem: impl Into<String>) -> Fault {
        let place = self.place();
        Fault::at(place, ErrorCode::Syntax, problem)
    }

    /// The next start or end of an element, with its position.
    pub(super) fn next(&mut self) -> Result<(Event, Place), Fault> {
        loop {
            let Some(open) = self.rest().find('<') else {
                if !self.rest().trim().is_empty() {
                    return Err(self.fault("expected an element, found text"));
                }
                self.at = self.text.len();
                return Ok((Event::Eof, self.place()));
            };
            if !self.rest().get(..open).unwrap_or_default().trim().is_empty() {
                self.at += self.rest().len() - self.rest().trim_start().len();
                return Err(self.fault("expected an element, found text"));
            }
            self.at += open;
            let place = self.place();
            let rest = self.rest();
            if rest.starts_with("<!--") {
                self.skip_past("-->", 4, "a comment")?;
            } else if rest.starts_with("<?") {
                self.skip_past("?>", 2, "a processing instruction")?;
            } else if rest.starts_with("<!") {
                return Err(self
                    .fault("document type declarations and CDATA are not supported")
                    .help("write names and values without entities"));
            } else if rest.starts_with("</") {
                self.at += 2;
                let name = self.name()?;
                self.blanks();
                self.expect('>')?;
                return Ok((Event::End { name }, place));
            } else {
                self.at += 1;
                return Ok((self.start()?, place));
            }
        }
    }

    fn skip_past(&mut self, end: &str, from: usize, what: &str) -> Result<(), Fault> {
        match self.rest().get(from..).and_then(|rest| rest.find(end)) {
            Some(found) => {
                self.at += from + found + end.len();
                Ok(())
            }
            None => Err(self.fault(format!("{what} does not end"))),
        }
    }

    fn start(&mut self) -> Result<Event, Fault> {
        let name = self.name()?;
        let mut attributes: Vec<(String, String)> = Vec::new();
        loop {
            let spaced = self.blanks();
            let rest = self.rest();
            if rest.starts_with("/>") {
                self.at += 2;
                return Ok(Event::Start { name, attributes, ends: true });
            }
            if rest.starts_with('>') {
                self.at += 1;
                return Ok(Event::Start { name, attributes, ends: false });
            }
            if !spaced {
                return Err(self.fault("expected a blank, > or />"));
            }
            let key = self.name()?;
            self.blanks();
            self.expect('=')?;
            self.blanks();
            let value = self.value()?;
            if attributes.iter().any(|(k, _)| *k == key) {
                return Err(self.fault(format!("the attribute {} is written twice", printable(&key))));
            }
            if attributes.len() >= MAX_ATTRIBUTES {
                return Err(self.fault(format!("more than {MAX_ATTRIBUTES} attributes")));
            }
            attributes.push((key, value));
        }
    }

    /// Skips whitespace; returns whether there was any.
    fn blanks(&mut self) -> bool {
        let rest = self.rest();
        let count = rest.len() - rest.trim_start().len();
        self.at += count;
        count > 0
    }

    fn expect(&mut self, c: char) -> Result<(), Fault> {
        if self.rest().starts_with(c) {
            self.at += c.len_utf8();
            return Ok(());
        }
        let found = match self.rest().chars().next() {
            Some(c) => format!("\"{}\"", printable(&c.to_string())),
            None => "the end of the file".to_owned(),
        };
        Err(self.fault(format!("expected \"{c}\", found {found}")))
    }

    fn name(&mut self) -> Result<String, Fault> {
        let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ':');
        let rest = self.rest();
        let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        let name = rest.get(..end).unwrap_or_default().to_owned();
        if name.is_empty() || name.len() > 256 {
            return Err(self.fault("expected a name"));
        }
        self.at += end;
        Ok(name)
    }

    /// The text between quotes.
    fn value(&mut self) -> Result<String, Fault> {
        let quote = match self.rest().chars().next() {
            Some(q @ ('"' | '\'')) => q,
            _ => return Err(self.fault("expected a value in quotes")),
        };
        let inner = self.rest().get(1..).unwrap_or_default();
        let Some(end) = inner.find([quote, '<']) else { return Err(self.fault("a value does not end")) };
        let raw = inner.get(..end).unwrap_or_default();
        if !inner.get(end..).unwrap_or_default().starts_with(quote) {
            return Err(self.fault("a value does not end, or contains <").help("write &lt;"));
        }
        let value = match unescaped(raw) {
            Some(value) => value,
            None => {
                return Err(self
                    .fault("an unknown entity")
                    .help("known are &lt; &gt; &amp; &quot; &apos; &#…;"));
            }
        };
        self.at += end + 2;
        Ok(value)
    }
}

/// Text with its entities replaced; `None` if one is unknown.
fn unescaped(raw: &str) -> Option<String> {
    if !raw.contains('&') {
        return Some(raw.to_owned());
    }
    let mut out = String::with_capacity(raw.len());
    let mut rest = raw;
    while let Some(at) = rest.find('&') {
        out.push_str(rest.get(..at)?);
        let after = rest.get(at + 1..)?;
        let end = after.find(';')?;
        let name = after.get(..end)?;
        out.push(match name {
            "lt" => '<',
            "gt" => '>',
            "amp" => '&',
            "quot" => '"',
            "apos" => '\'',
            _ => {
                let number = name.strip_prefix('#')?;
                let code = match number.strip_prefix('x') {
                    Some(hex) => u32::from_str_radix(hex, 16).ok()?,
                    None => number.parse().ok()?,
                };
                char::from_u32(code)?
            }
        });
        rest = after.get(end + 1..)?;
    }
    out.push_str(rest);
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(text: &str) -> Result<Vec<(Event, u32, u32)>, Fault> {
        let mut reader = Reader::new(text, 0);
        let mut out = Vec::new();
        loop {
            let (event, place) = reader.next()?;
            if event == Event::Eof {
                return Ok(out);
            }
            out.push((event, place.line, place.column));
        }
    }

    #[test]
    fn elements_have_attributes_and_places() {
        let found = events("<?xml?>\n<!-- é > <a> -->\n  <a x='1 &lt; &#50;' y = \"é\">\n<b/></a >").unwrap();
        let pair = |k: &str, v: &str| (k.to_owned(), v.to_owned());
        let a = Event::Start {
            name: "a".into(),
            attributes: vec![pair("x", "1 < 2"), pair("y", "é")],
            ends: false,
        };
        assert_eq!(found[0], (a, 3, 3));
        assert_eq!((found[1].1, found[1].2), (4, 1));
        assert_eq!(found[2], (Event::End { name: "a".into() }, 4, 5));
    }

    #[test]
    fn what_is_no_xml_is_refused() {
        for bad in [
            "<a x=1/>",
            "<a x='1/>",
            "<a",
            "<",
            "<a x='1' x='2'/>",
            "text",
            "<a/> text",
            "<!DOCTYPE a [<!ENTITY b 'c'>]><a/>",
            "<a x='&b;'/>",
            "<a x='&#xD800;'/>",
            "<a x='<'/>",
            "<!-- ",
            "<a x='1'y='2'/>",
            "<1 2>",
        ] {
            assert!(events(bad).is_err(), "{bad}");
        }
    }
}
