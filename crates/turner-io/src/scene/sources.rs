//! The texts of a scene, and the positions of spans in them.

use turner::schema::value::{FileId, Span};

use crate::assets::printable;

/// Most characters of an excerpt.
const EXCERPT: usize = 160;

/// Names and texts of all files of a scene, by [`FileId`]. Each override from the command line counts as a file.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

/// One text.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Its name in messages: a path, or `-D key=value`.
    pub name: String,
    /// Its path relative to the scene's folder. Paths in the text are relative to it.
    pub uri: String,
    /// Its text.
    pub text: String,
    /// Whether it is an argument of the command line rather than a file.
    pub is_argument: bool,
}

/// The position of a span, for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1; a tab is one character.
    pub column: usize,
    /// Characters from `column` to the end of the span, at least 1, within the line.
    pub length: usize,
    /// The line without its line break, with control characters escaped; a long line is cut around the column.
    pub excerpt: String,
    /// Column of the span's start within `excerpt`, from 1.
    pub excerpt_column: usize,
    /// Whether `file` is an argument of the command line.
    pub is_argument: bool,
}

impl Sources {
    /// Adds a text.
    pub fn add(&mut self, file: SourceFile) -> FileId {
        self.files.push(file);
        FileId(self.files.len() as u32 - 1)
    }

    /// A text by its id.
    pub fn get(&self, id: FileId) -> Option<&SourceFile> {
        self.files.get(id.0 as usize)
    }

    /// All texts in the order in which they were read; the scene file is the first.
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// The position of `span`; `None` if its file is not one of these.
    pub fn locate(&self, span: Span) -> Option<Location<'_>> {
        let file = self.get(span.file)?;
        let text = file.text.as_str();
        let start = boundary(text, span.start as usize);
        let end = boundary(text, span.end as usize).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
        let line = text[..line_start].bytes().filter(|&b| b == b'\n').count() + 1;
        // A byte order mark is not a column.
        let visible = line_start + if text[line_start..].starts_with('\u{feff}') { 3 } else { 0 };
        let content = text[visible..line_end.max(visible)].trim_end_matches('\r');
        let column = text[visible.min(start)..start].chars().count() + 1;
        let length = text[start..end.min(visible + content.len()).max(start)].chars().count().max(1);
        let (excerpt, excerpt_column) = excerpt(content, column);
        let (file, is_argument) = (file.name.as_str(), file.is_argument);
        Some(Location { file, line, column, length, excerpt, excerpt_column, is_argument })
    }
}

/// The nearest character boundary at or before `at`.
fn boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// The part of a line around a column (from 1), and the column within that part.
fn excerpt(line: &str, column: usize) -> (String, usize) {
    let first = if column <= EXCERPT * 3 / 4 { 0 } else { column - EXCERPT / 2 };
    let mut out = String::new();
    let mut at = 1;
    for (i, c) in line.chars().enumerate().skip(first).take(EXCERPT) {
        if i + 1 == column {
            at = out.chars().count() + 1;
        }
        // One space for a tab keeps the marker under its character.
        if c == '\t' { out.push(' ') } else { out += &printable(c.encode_utf8(&mut [0; 4])) }
    }
    if column > first + line.chars().skip(first).take(EXCERPT).count() {
        at = out.chars().count() + 1;
    }
    (out, at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str, start: usize, end: usize) -> (usize, usize, usize, String) {
        let mut sources = Sources::default();
        let (name, uri) = ("a.toml".to_owned(), "a.toml".to_owned());
        let file = sources.add(SourceFile { name, uri, text: text.to_owned(), is_argument: false });
        let l = sources.locate(Span { file, start: start as u32, end: end as u32 }).unwrap();
        (l.line, l.column, l.length, l.excerpt)
    }

    #[test]
    fn lines_and_columns_count_characters() {
        assert_eq!(at("a = 1\r\nbé = 2\r\n", 12, 13), (2, 5, 1, "bé = 2".into()));
        assert_eq!(at("\u{feff}a = 1", 3, 4), (1, 1, 1, "a = 1".into()));
        assert_eq!(at("\u{feff}a = 1", 0, 1), (1, 1, 1, "a = 1".into()));
        assert_eq!(at("\tx = 1\n", 1, 2), (1, 2, 1, " x = 1".into()));
        assert_eq!(at("a", 1, 1), (1, 2, 1, "a".into()));
        assert_eq!(at("a\n", 9, 99), (2, 1, 1, String::new()));
        assert_eq!(at("ab\ncd", 1, 5), (1, 2, 1, "ab".into()));
    }

    #[test]
    fn long_lines_are_cut() {
        let text = format!("{}é{}", "x".repeat(5000), "y".repeat(5000));
        let mut sources = Sources::default();
        let (name, uri) = (String::new(), String::new());
        let file = sources.add(SourceFile { name, uri, text, is_argument: false });
        let l = sources.locate(Span { file, start: 5000, end: 5002 }).unwrap();
        assert_eq!(l.column, 5001);
        assert!(l.excerpt.chars().count() <= EXCERPT);
        assert_eq!(l.excerpt.chars().nth(l.excerpt_column - 1), Some('é'));
    }
}
