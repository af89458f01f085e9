//! Bounds on what drawing a glyph costs: a small file may name components of components, or subroutines that call
//! subroutines, whose number is a power.

use std::cell::Cell;
use std::collections::HashMap;

use skrifa::raw::TableProvider;
use skrifa::raw::ps::cff::index::Index;
use skrifa::raw::ps::cff::{CffFontRef, blend::BlendState};
use skrifa::raw::ps::cs::{CharstringContext, CharstringKind, CommandSink, evaluate};
use skrifa::raw::ps::error::Error;
use skrifa::raw::tables::glyf::{Glyf, Glyph};
use skrifa::raw::tables::loca::Loca;
use skrifa::raw::types::Fixed;
use skrifa::{FontRef, GlyphId, Tag};

/// Most components of a glyph, those of components included.
const MAX_COMPONENTS: u64 = 4096;
/// Deepest nesting of components.
const MAX_DEPTH: u32 = 16;
/// Most bytes of a glyph's program, each subroutine counted as often as it is called.
const MAX_PROGRAM: usize = 1 << 22;

/// Checks that a glyph can be drawn in bounded time; whether there is anything to draw.
///
/// Errors: more components or a longer program than a font needs; tables that cannot be read.
pub(super) fn check(font: &FontRef<'_>, glyph: GlyphId) -> Result<bool, String> {
    if font.data_for_tag(Tag::new(b"VARC")).is_some() {
        return Err("variable components (VARC) cannot be read".to_owned());
    }
    if let (Ok(glyf), Ok(loca)) = (font.glyf(), font.loca(None)) {
        if matches!(loca.get_glyf(glyph, &glyf), Ok(Some(Glyph::Simple(simple))) if simple.num_points() == 0)
        {
            return Ok(false);
        }
        let mut known = HashMap::new();
        let count = components(&loca, &glyf, glyph, 0, &mut known)?;
        if count > MAX_COMPONENTS {
            return Err(format!("more than {MAX_COMPONENTS} components"));
        }
    }
    let data = font.data_for_tag(Tag::new(b"CFF2")).or_else(|| font.data_for_tag(Tag::new(b"CFF ")));
    if let Some(data) = data {
        program(data.as_bytes(), glyph).map_err(|e| e.to_string())?;
    }
    Ok(true)
}

/// The number of components of a glyph, saturating.
fn components(
    loca: &Loca<'_>,
    glyf: &Glyf<'_>,
    glyph: GlyphId,
    depth: u32,
    known: &mut HashMap<u32, u64>,
) -> Result<u64, String> {
    if depth > MAX_DEPTH {
        return Err(format!("components are nested deeper than {MAX_DEPTH}"));
    }
    if let Some(count) = known.get(&glyph.to_u32()) {
        return Ok(*count);
    }
    let mut count = 1u64;
    match loca.get_glyf(glyph, glyf) {
        Ok(Some(Glyph::Composite(composite))) => {
            for (component, _) in composite.component_glyphs_and_flags() {
                let own = components(loca, glyf, component.into(), depth.saturating_add(1), known)?;
                count = count.saturating_add(own);
            }
        }
        // The crate skrifa 0.44 panics on it.
        Ok(Some(Glyph::Simple(simple))) if simple.num_points() == 0 && !simple.glyph_data().is_empty() => {
            return Err("a component without contours has points".to_owned());
        }
        Ok(_) | Err(_) => {}
    }
    known.insert(glyph.to_u32(), count);
    Ok(count)
}

/// Runs the program of a glyph without drawing, and counts its bytes.
fn program(data: &[u8], glyph: GlyphId) -> Result<(), Error> {
    let font = CffFontRef::new(data, 0, None)?;
    let subfont = font.subfont(font.subfont_index(glyph).unwrap_or(0), &[])?;
    let own = match subfont.subrs_offset() {
        0 => Index::Empty,
        offset => Index::new(data.get(offset as usize..).unwrap_or_default(), font.version() == 2)?,
    };
    let store = font.var_store().and_then(|s| BlendState::new(s.clone(), &[], subfont.vs_index()).ok());
    let plain = (data, font.charstrings(), font.global_subrs(), &own);
    let program = font.charstrings().get(glyph.to_u32() as usize)?;
    let counted = Counted { plain, left: Cell::new(MAX_PROGRAM.saturating_sub(program.len())) };
    evaluate(&counted, store, program, &mut Nothing).map(drop)
}

/// The subroutines of a font, until their bytes exceed the bound.
struct Counted<'a> {
    plain: (&'a [u8], &'a Index<'a>, &'a Index<'a>, &'a Index<'a>),
    left: Cell<usize>,
}

impl Counted<'_> {
    fn count<'b>(&self, program: &'b [u8]) -> Result<&'b [u8], Error> {
        // An empty subroutine takes time as well.
        match self.left.get().checked_sub(program.len().saturating_add(1)) {
            Some(left) => {
                self.left.set(left);
                Ok(program)
            }
            None => Err(Error::CharstringNestingDepthLimitExceeded),
        }
    }
}

impl CharstringContext for Counted<'_> {
    fn kind(&self) -> CharstringKind {
        CharstringKind::Type2
    }
    fn seac_components(&self, base: i32, accent: i32) -> Result<[&[u8]; 2], Error> {
        let [base, accent] = self.plain.seac_components(base, accent)?;
        Ok([self.count(base)?, self.count(accent)?])
    }
    fn global_subr(&self, index: i32) -> Result<&[u8], Error> {
        self.count(self.plain.global_subr(index)?)
    }
    fn subr(&self, index: i32) -> Result<&[u8], Error> {
        self.count(self.plain.subr(index)?)
    }
}

/// Draws nothing.
struct Nothing;

impl CommandSink for Nothing {
    fn move_to(&mut self, _: Fixed, _: Fixed) {}
    fn line_to(&mut self, _: Fixed, _: Fixed) {}
    fn curve_to(&mut self, _: Fixed, _: Fixed, _: Fixed, _: Fixed, _: Fixed, _: Fixed) {}
    fn close(&mut self) {}
}
