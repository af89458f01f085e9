//! Font files: TrueType and OpenType, with outlines of quadratic (`glyf`) or cubic (`CFF `, `CFF2`) curves, and
//! collections of them.
//!
//! A character is the glyph that the font's `cmap` gives it. Glyphs are placed by their advance widths and by the kerning
//! of pairs: the feature `kern` of `GPOS`, or the table `kern` of fonts without it. Variable fonts have their default
//! instance. The crate `skrifa` reads the tables; the work that a file may ask for is bounded here, since components of
//! components and subroutines of subroutines multiply.

mod kerning;
#[cfg(test)]
mod tests;
mod work;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::raw::{FileRef, TableProvider};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use turner::math::DVec2;
use turner::schema::{Contour, ErrorCode, Font, Glyph, OutlinePiece, SceneError};

use crate::assets::printable;
use crate::image::contain::caught;
use kerning::Kerning;

/// Largest accepted file, in bytes. Fonts of all Chinese characters have some 20 MiB.
pub const MAX_FONT: u64 = 128 << 20;

/// Most curves and lines of one glyph.
const MAX_PIECES: usize = 1 << 16;
/// What is said of a panic in the crate that reads tables.
const FAILED: &str = "its tables contradict each other";
/// Most fonts of a collection.
const MAX_FACES: u32 = 1024;

/// Why a font file could not be read: file, problem and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FontError {
    /// The file is not valid.
    #[error("{name}: damaged font: {problem}\n  obtain the file again, or choose another font")]
    Damaged {
        /// The file.
        name: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// No font that is known.
    #[error("{name}: {what}\n  TrueType and OpenType can be read: .ttf, .otf, .ttc")]
    Unsupported {
        /// The file.
        name: String,
        /// What it is.
        what: String,
    },
}

/// The outlines of glyphs that were read, by face and glyph.
type Known = HashMap<(u32, u32), Arc<Vec<Contour>>>;

/// A font file in memory.
#[derive(Debug)]
struct FontBytes {
    name: String,
    bytes: Vec<u8>,
    faces: u32,
    known: Mutex<Known>,
}

/// Reads a font file.
///
/// Errors: a file of another kind, a damaged one.
pub fn decode(bytes: Vec<u8>, name: &str) -> Result<Arc<dyn Font>, FontError> {
    let name = printable(name);
    let damaged = |problem: String| FontError::Damaged { name: name.clone(), problem };
    let unsupported = |what: &str| FontError::Unsupported { name: name.clone(), what: what.to_owned() };
    match bytes.get(..4) {
        Some([0, 1, 0, 0] | b"OTTO" | b"true" | b"ttcf") => {}
        Some(b"wOFF" | b"wOF2") => return Err(unsupported("a font for web pages (WOFF) cannot be read")),
        Some([0x80, 1, ..] | b"%!PS" | b"%!Fo") => return Err(unsupported("a Type 1 font cannot be read")),
        _ => return Err(unsupported("no font file")),
    }
    let faces = match caught(|| FileRef::new(&bytes)) {
        Some(Ok(FileRef::Font(_))) => 1,
        Some(Ok(FileRef::Collection(fonts))) => fonts.len(),
        Some(Err(error)) => return Err(damaged(error.to_string())),
        None => return Err(damaged(FAILED.to_owned())),
    };
    if !(1..=MAX_FACES).contains(&faces) {
        return Err(damaged(format!("a collection of {faces} fonts: expected 1 to {MAX_FACES}")));
    }
    let font = FontBytes { name: name.clone(), bytes, faces, known: Mutex::default() };
    for face in 0..faces {
        caught(|| font.face(face).map(drop)).unwrap_or_else(|| Err(FAILED.to_owned())).map_err(damaged)?;
    }
    Ok(Arc::new(font))
}

/// The extension of a font file.
pub(crate) fn extension(bytes: &[u8]) -> &'static str {
    match bytes.get(..4) {
        Some(b"OTTO") => "otf",
        Some(b"ttcf") => "ttc",
        _ => "ttf",
    }
}

/// One font of a file.
struct Face<'a> {
    font: FontRef<'a>,
    /// Font units per em.
    units: f64,
}

impl FontBytes {
    fn face(&self, face: u32) -> Result<Face<'_>, String> {
        let font = FontRef::from_index(&self.bytes, face).map_err(|e| e.to_string())?;
        let units = font.head().map_err(|e| format!("table head: {e}"))?.units_per_em();
        if !(16..=16384).contains(&units) {
            return Err(format!("{units} units per em: expected 16 to 16384"));
        }
        Ok(Face { font, units: f64::from(units) })
    }

    /// The outlines of a glyph, em.
    fn outlines(&self, of: &Face<'_>, face: u32, glyph: GlyphId) -> Result<Arc<Vec<Contour>>, String> {
        let key = (face, glyph.to_u32());
        if let Some(known) = self.known().get(&key) {
            return Ok(known.clone());
        }
        let is_drawn = work::check(&of.font, glyph)?;
        let mut pen = Pen { contours: Vec::new(), pieces: 0, scale: 1.0 / of.units };
        if is_drawn && let Some(outline) = of.font.outline_glyphs().get(glyph) {
            let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
            outline.draw(settings, &mut pen).map_err(|e| e.to_string())?;
        }
        if pen.pieces > MAX_PIECES {
            return Err(format!("more than {MAX_PIECES} curves"));
        }
        let contours = Arc::new(pen.contours);
        self.known().insert(key, contours.clone());
        Ok(contours)
    }

    fn known(&self) -> std::sync::MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Font for FontBytes {
    fn set_line(&self, face: u32, line: &str) -> Result<Vec<Glyph>, SceneError> {
        let error = |problem: String| {
            SceneError::new(ErrorCode::Font, format!("{}: {problem}", self.name))
                .help("obtain the file again, or choose another font")
        };
        if face >= self.faces {
            let count = self.faces;
            let fonts = if count == 1 { "font" } else { "fonts" };
            let message = format!("{}: `face` is {face}, but the file has {count} {fonts}", self.name);
            return Err(
                SceneError::new(ErrorCode::Font, message).help(format!("write `face = {}`", count - 1))
            );
        }
        caught(|| self.glyphs(face, line)).unwrap_or_else(|| Err(FAILED.to_owned())).map_err(error)
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

impl FontBytes {
    /// The characters of one line, of a face that the file has.
    fn glyphs(&self, face: u32, line: &str) -> Result<Vec<Glyph>, String> {
        let of = self.face(face)?;
        let charmap = of.font.charmap();
        let widths = of.font.glyph_metrics(Size::unscaled(), LocationRef::default());
        let kerning = Kerning::new(&of.font);
        // 0 is the glyph that stands for missing ones.
        let glyph_of = |c: char| charmap.map(c).filter(|glyph| glyph.to_u32() != 0);
        let characters: Vec<(char, Option<GlyphId>)> = line.chars().map(|c| (c, glyph_of(c))).collect();
        let next = characters.iter().skip(1).map(|(_, glyph)| *glyph).chain([None]);
        let mut out = Vec::with_capacity(characters.len());
        for (&(character, glyph), next) in characters.iter().zip(next) {
            let Some(glyph) = glyph else {
                out.push(Glyph { character, advance: 0.0, contours: None });
                continue;
            };
            let shown = u32::from(character);
            let contours = self
                .outlines(&of, face, glyph)
                .map_err(|e| format!("the outlines of U+{shown:04X} cannot be read: {e}"))?;
            let kern = next.map_or(0.0, |next| f64::from(kerning.between(glyph, next)));
            let width = f64::from(widths.advance_width(glyph).unwrap_or(0.0));
            out.push(Glyph { character, advance: (width + kern) / of.units, contours: Some(contours) });
        }
        Ok(out)
    }
}

/// Collects outlines.
struct Pen {
    contours: Vec<Contour>,
    pieces: usize,
    /// Em per font unit.
    scale: f64,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> DVec2 {
        DVec2::new(f64::from(x), f64::from(y)) * self.scale
    }

    fn add(&mut self, piece: OutlinePiece) {
        self.pieces += 1;
        if self.pieces <= MAX_PIECES
            && let Some(contour) = self.contours.last_mut()
        {
            contour.pieces.push(piece);
        }
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.pieces += 1;
        if self.pieces <= MAX_PIECES {
            let start = self.at(x, y);
            self.contours.push(Contour { start, pieces: Vec::new() });
        }
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.add(OutlinePiece::Line(self.at(x, y)));
    }
    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.add(OutlinePiece::Quadratic(self.at(cx, cy), self.at(x, y)));
    }
    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        self.add(OutlinePiece::Cubic(self.at(ax, ay), self.at(bx, by), self.at(x, y)));
    }
    fn close(&mut self) {}
}
