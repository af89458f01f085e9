//! Errors of scenes: what is wrong, where, and how to correct it.

use std::fmt;

use crate::schema::Remedy;
use crate::schema::value::Span;

macro_rules! error_codes {
    ($($(#[doc = $doc:literal])+ $name:ident = $code:literal,)*) => {
        /// Stable codes of errors in a scene or in the files it refers to.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ErrorCode { $($(#[doc = $doc])+ $name,)* }
        impl ErrorCode {
            /// Every code, in order.
            pub const ALL: &[ErrorCode] = &[$(ErrorCode::$name,)*];
            /// The code as printed, e.g. `E0102`.
            pub fn as_str(self) -> &'static str { match self { $(ErrorCode::$name => $code,)* } }
            /// Its meaning, in one sentence.
            pub fn meaning(self) -> &'static str {
                match self { $(ErrorCode::$name => concat!($($doc),+).trim_ascii(),)* }
            }
        }
    };
}

error_codes! {
    /// The file is not valid TOML.
    Syntax = "E0101",
    /// A key that does not exist here.
    UnknownKey = "E0102",
    /// A name (of a type, material, texture, group, colour, …) that does not exist.
    UnknownName = "E0103",
    /// A value of the wrong type.
    WrongType = "E0104",
    /// A number outside its range, or not finite.
    OutOfRange = "E0105",
    /// A required key is missing.
    MissingKey = "E0106",
    /// Two keys contradict each other.
    Conflict = "E0107",
    /// Groups, textures or includes that contain themselves, or that are nested too deeply.
    Cycle = "E0108",
    /// More than a limit on memory, triangles, file size or image size allows.
    TooLarge = "E0109",
    /// A file that cannot be read, or that lies outside the scene's folder.
    File = "E0201",
    /// An image that cannot be decoded.
    Image = "E0202",
    /// A mesh file that cannot be decoded, or mesh data that is inconsistent.
    Mesh = "E0203",
    /// A model file (glTF, …) that is invalid, or that requires an unsupported feature.
    Model = "E0204",
    /// An IES photometric file that is invalid, or that requires an unsupported feature.
    Profile = "E0205",
    /// A density grid file that is invalid.
    Volume = "E0206",
    /// Film data that is damaged, or of another version.
    Film = "E0207",
    /// A font file that is invalid, or that lacks what a text needs.
    Font = "E0208",
    /// A file of a measured BRDF that is invalid.
    Measured = "E0209",
    /// A transform that cannot be inverted.
    Transform = "E0301",
    /// An invalid camera: `position` equals `look_at`, `up` is parallel to the view direction, …
    Camera = "E0302",
    /// The output cannot be written.
    Output = "E0401",
    /// Something in the file would be ignored, which `--strict` makes an error.
    Strict = "E0501",
    /// An option or argument of the command line is wrong.
    Usage = "E0601",
    /// A bug in Turner: please report it.
    Internal = "E0901",
}

/// One error: what is wrong, where, and the remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// Its stable code.
    pub code: ErrorCode,
    /// What was expected and what was found, in one sentence.
    pub message: String,
    /// The position in a file, if the error has one.
    pub span: Option<Span>,
    /// The remedy in words, e.g. the nearest valid name.
    pub help: Option<String>,
    /// A remedy as data that a program can apply. It may differ from `help`.
    pub remedy: Option<Box<Remedy>>,
    /// Further errors of the same scene, in the order of their positions. `more` is empty in each of them.
    pub more: Box<[SceneError]>,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}

impl SceneError {
    /// An error at a position.
    pub fn at(code: ErrorCode, span: Span, message: impl Into<String>) -> SceneError {
        SceneError {
            code,
            message: message.into(),
            span: Some(span),
            help: None,
            remedy: None,
            more: Box::default(),
        }
    }

    /// An error without a position.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> SceneError {
        SceneError {
            code,
            message: message.into(),
            span: None,
            help: None,
            remedy: None,
            more: Box::default(),
        }
    }

    /// Adds a remedy in words.
    pub fn help(mut self, help: impl Into<String>) -> SceneError {
        self.help = Some(help.into());
        self
    }

    /// Sets the remedy as data; `None` keeps the one it has.
    pub fn remedy(mut self, remedy: impl Into<Option<Remedy>>) -> SceneError {
        self.remedy = remedy.into().map(Box::new).or(self.remedy);
        self
    }

    /// Combines errors into one: the first in the scene, with the others as [`SceneError::more`]. `None` for an empty
    /// list.
    pub fn all(mut errors: Vec<SceneError>) -> Option<SceneError> {
        // Errors without a position come last.
        errors.sort_by_key(|e| e.span.map_or((u32::MAX, u32::MAX), |s| (s.file.0, s.start)));
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        first.more = errors.collect();
        Some(first)
    }

    /// Sets the position, if it has none yet.
    pub fn or_at(mut self, span: Option<Span>) -> SceneError {
        self.span = self.span.or(span);
        self
    }
}

/// The error `there is no KIND "NAME"`, with the nearest valid name and the list of all valid names as help.
pub fn unknown_name(code: ErrorCode, span: Span, kind: &str, name: &str, valid: &[&str]) -> SceneError {
    let error = SceneError::at(code, span, format!("there is no {kind} \"{}\"", escape(name)));
    match suggestion(name, valid) {
        Some(help) => error.help(help),
        None => error,
    }
}

/// Text with the nearest valid name, if one is close enough, and all valid names.
pub fn suggestion(name: &str, valid: &[&str]) -> Option<String> {
    if valid.is_empty() {
        return None;
    }
    let list = || {
        const SHOWN: usize = 24;
        let mut names = valid.iter().take(SHOWN).map(|n| escape(n)).collect::<Vec<_>>().join(", ");
        if valid.len() > SHOWN {
            names += &format!(", … ({} in all)", valid.len());
        }
        names
    };
    Some(match nearest(name, valid) {
        Some(near) => format!("did you mean \"{}\"? valid: {}", escape(near), list()),
        None => format!("valid: {}", list()),
    })
}

/// The valid name closest to `name` (Damerau–Levenshtein distance), if it is close enough to be a misspelling.
pub fn nearest<'a>(name: &str, valid: &[&'a str]) -> Option<&'a str> {
    let wanted = name.to_lowercase().replace(['-', ' '], "_");
    valid
        .iter()
        .map(|v| (strsim::damerau_levenshtein(&wanted, &v.to_lowercase().replace('-', "_")), *v))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, v)| *distance <= 1 + v.len().min(wanted.len()) / 4)
        .map(|(_, v)| v)
}

/// Makes text from a file safe for a terminal: escapes control characters and shortens long text.
pub fn escape(text: &str) -> String {
    let mut out: String = text
        .chars()
        .take(80)
        .flat_map(|c| if is_hidden(c) { c.escape_default().collect::<Vec<_>>() } else { vec![c] })
        .collect();
    if text.chars().count() > 80 {
        out.push('…');
    }
    out
}

/// Whether a character is a control character, is invisible, or changes the direction of text.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_find_their_word() {
        let valid = ["sphere", "plane", "box", "look_at", "k_reflect"];
        assert_eq!(nearest("spere", &valid), Some("sphere"));
        assert_eq!(nearest("Sphere", &valid), Some("sphere"));
        assert_eq!(nearest("look-at", &valid), Some("look_at"));
        assert_eq!(nearest("banana", &valid), None);
    }

    #[test]
    fn names_from_files_cannot_drive_the_terminal() {
        assert_eq!(escape("a\u{1b}[31mb"), "a\\u{1b}[31mb");
        assert!(escape(&"x".repeat(500)).chars().count() < 90);
    }

    #[test]
    fn codes_are_unique() {
        let mut codes: Vec<_> = ErrorCode::ALL.iter().map(|c| c.as_str()).collect();
        codes.dedup();
        assert_eq!(codes.len(), ErrorCode::ALL.len());
    }
}
