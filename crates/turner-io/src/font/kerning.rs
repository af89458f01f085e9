//! Kerning: distances of pairs of glyphs.

use skrifa::raw::TableProvider;
use skrifa::raw::tables::gpos::{Gpos, PairPos, PairPosFormat1, PairPosFormat2, PositionSubtables};
use skrifa::raw::tables::kern::{Kern, SubtableKind};
use skrifa::{FontRef, GlyphId, Tag};

/// Most tables that are searched for a pair.
const MAX_SUBTABLES: usize = 256;

/// The tables that kern the pairs of a font, in the order in which they are searched.
pub(super) struct Kerning<'a> {
    pairs: Vec<Vec<PairPos<'a>>>,
    old: Option<Kern<'a>>,
}

impl<'a> Kerning<'a> {
    /// The kerning of Latin script, or of the script that the font names first. Tables that cannot be read are left out.
    pub(super) fn new(font: &FontRef<'a>) -> Kerning<'a> {
        let pairs = font.gpos().ok().and_then(|gpos| lookups(&gpos)).unwrap_or_default();
        let old = if pairs.is_empty() { font.kern().ok() } else { None };
        Kerning { pairs, old }
    }

    /// The change of the distance between two glyphs, font units.
    pub(super) fn between(&self, left: GlyphId, right: GlyphId) -> i32 {
        // Of each lookup the first table that has the pair counts.
        let of_lookup = |tables: &Vec<PairPos<'_>>| tables.iter().find_map(|table| pair(table, left, right));
        let new: i32 = self.pairs.iter().filter_map(of_lookup).map(i32::from).fold(0, i32::saturating_add);
        let Some(old) = &self.old else { return new };
        let mut sum = 0i32;
        for table in old.subtables().take(MAX_SUBTABLES).flatten() {
            if !table.is_horizontal()
                || table.is_cross_stream()
                || table.is_variable()
                || table.is_state_machine()
            {
                continue;
            }
            let value = match table.kind() {
                Ok(SubtableKind::Format0(table)) => table.kerning(left, right),
                Ok(SubtableKind::Format2(table)) => table.kerning(left, right),
                Ok(SubtableKind::Format3(table)) => table.kerning(left, right),
                Ok(SubtableKind::Format1(_)) | Err(_) => None,
            };
            sum = sum.saturating_add(value.unwrap_or(0));
        }
        sum.clamp(-(1 << 16), 1 << 16)
    }
}

/// The pair tables of the feature `kern`, by lookup.
fn lookups<'a>(gpos: &Gpos<'a>) -> Option<Vec<Vec<PairPos<'a>>>> {
    let scripts = gpos.script_list().ok()?;
    let records = scripts.script_records();
    let of = |tag: &[u8; 4]| records.iter().find(|r| r.script_tag() == Tag::new(tag));
    let record = of(b"latn").or_else(|| of(b"DFLT")).or_else(|| records.first())?;
    let language = record.script(scripts.offset_data()).ok()?.default_lang_sys()?.ok()?;
    let features = gpos.feature_list().ok()?;
    let mut numbers: Vec<u16> = Vec::new();
    for index in language.feature_indices() {
        let Some(record) = features.feature_records().get(usize::from(index.get())) else { continue };
        if record.feature_tag() == Tag::new(b"kern")
            && let Ok(feature) = record.feature(features.offset_data())
        {
            numbers.extend(feature.lookup_list_indices().iter().map(|i| i.get()));
        }
    }
    numbers.sort_unstable();
    numbers.dedup();
    let list = gpos.lookup_list().ok()?;
    let (mut out, mut count) = (Vec::new(), 0usize);
    for number in numbers {
        let Ok(lookup) = list.lookups().get(usize::from(number)) else { continue };
        let Ok(PositionSubtables::Pair(tables)) = lookup.subtables() else { continue };
        let tables: Vec<PairPos<'a>> =
            tables.iter().take(MAX_SUBTABLES.saturating_sub(count)).filter_map(Result::ok).collect();
        count = count.saturating_add(tables.len());
        out.push(tables);
    }
    Some(out)
}

fn pair(table: &PairPos<'_>, left: GlyphId, right: GlyphId) -> Option<i16> {
    match table {
        PairPos::Format1(table) => single(table, left, right),
        PairPos::Format2(table) => classes(table, left, right),
    }
}

fn single(table: &PairPosFormat1<'_>, left: GlyphId, right: GlyphId) -> Option<i16> {
    let set = table.pair_sets().get(usize::from(table.coverage().ok()?.get(left)?)).ok()?;
    let records = set.pair_value_records();
    // Records are sorted by the second glyph.
    let (mut low, mut high) = (0usize, records.len());
    while low < high {
        let middle = low.midpoint(high);
        let record = records.get(middle).ok()?;
        match record.second_glyph().to_u32().cmp(&right.to_u32()) {
            std::cmp::Ordering::Less => low = middle.saturating_add(1),
            std::cmp::Ordering::Greater => high = middle,
            std::cmp::Ordering::Equal => return Some(record.value_record1().x_advance().unwrap_or(0)),
        }
    }
    None
}

fn classes(table: &PairPosFormat2<'_>, left: GlyphId, right: GlyphId) -> Option<i16> {
    table.coverage().ok()?.get(left)?;
    let (first, second) = (table.class_def1().ok()?.get(left), table.class_def2().ok()?.get(right));
    let row = table.class1_records().get(usize::from(first)).ok()?;
    let record = row.class2_records().get(usize::from(second)).ok()?;
    Some(record.value_record1().x_advance().unwrap_or(0))
}
