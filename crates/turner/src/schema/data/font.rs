//! Fonts: the outlines of characters, their widths and their kerning.
//!
//! Whoever reads font files implements [`Font`]; this crate knows no file format. All lengths are in em: the size of a
//! text in the scene is the length of one em.

use std::fmt::Debug;
use std::panic::{RefUnwindSafe, UnwindSafe};
use std::sync::Arc;

use crate::math::DVec2;
use crate::schema::value::{Data, Value};
use crate::schema::{ErrorCode, ParamType, ReadContext, SceneError, WriteContext, wrong_type};

/// A piece of an outline, from the end of the piece before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutlinePiece {
    /// A straight line to a point.
    Line(DVec2),
    /// A quadratic Bézier curve: a control point and the end.
    Quadratic(DVec2, DVec2),
    /// A cubic Bézier curve: two control points and the end.
    Cubic(DVec2, DVec2, DVec2),
}

impl OutlinePiece {
    /// The point where it ends.
    pub fn end(self) -> DVec2 {
        match self {
            OutlinePiece::Line(p) | OutlinePiece::Quadratic(_, p) | OutlinePiece::Cubic(_, _, p) => p,
        }
    }
}

/// A closed outline: its end is joined to its start by a straight line if they differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// The first point, em.
    pub start: DVec2,
    /// The pieces, in order.
    pub pieces: Vec<OutlinePiece>,
}

/// A character of a line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Glyph {
    /// The character.
    pub character: char,
    /// The distance to the origin of the next character, em, with the kerning between the two.
    pub advance: f64,
    /// The outlines around the character's own origin on the baseline, em. What they wind around, in either direction,
    /// is filled. `None` if the font lacks the character.
    pub contours: Option<Arc<Vec<Contour>>>,
}

/// A font file: one font, or a collection of several.
pub trait Font: Debug + Send + Sync + UnwindSafe + RefUnwindSafe {
    /// The characters of one line, from left to right.
    ///
    /// Errors: a font (`face`, from 0) that the file does not have; outlines that cannot be read.
    fn set_line(&self, face: u32, line: &str) -> Result<Vec<Glyph>, SceneError>;
    /// The bytes of the file.
    fn bytes(&self) -> &[u8];
}

/// No font: what a new text has.
#[derive(Debug)]
struct NoFont;

impl Font for NoFont {
    fn set_line(&self, _: u32, _: &str) -> Result<Vec<Glyph>, SceneError> {
        let error = SceneError::new(ErrorCode::Font, "a text has no font");
        Err(error.help("name a font file in the scene's folder: `font = \"file.ttf\"`"))
    }
    fn bytes(&self) -> &[u8] {
        &[]
    }
}

/// The font file of a text. Two are equal if their bytes are equal.
#[derive(Clone, Debug)]
pub struct FontFile {
    /// The file name as written in the scene.
    pub uri: String,
    /// The font.
    pub font: Arc<dyn Font>,
}

impl Default for FontFile {
    /// No font: setting a text in it is an error.
    fn default() -> FontFile {
        FontFile { uri: String::new(), font: Arc::new(NoFont) }
    }
}

impl PartialEq for FontFile {
    fn eq(&self, other: &FontFile) -> bool {
        Arc::ptr_eq(&self.font, &other.font) || self.font.bytes() == other.font.bytes()
    }
}

impl ParamType for FontFile {
    fn kind() -> String {
        "\"font file\"".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<FontFile, SceneError> {
        match &value.data {
            Data::String(uri) => Ok(FontFile { uri: uri.clone(), font: cx.font(uri, value.span)? }),
            _ => Err(wrong_type(value, "the name of a font file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.font(self).map(Some)
    }
}
