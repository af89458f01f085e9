//! Checks of what the specification requires but reading does not need: faults that other programs may refuse, and that
//! tell why a picture is not as expected. Each is a warning with a JSON pointer.
//!
//! ```text
//!   JSON text ── walk, schema, extensions ──> types, ranges, required members, references, places of extensions
//!   Document ── meaning, layout, meshes, skeleton, images ──> what members mean together
//!   accessors ── data ──> values: bounds, unit vectors, indices, times
//! ```

mod data;
mod extensions;
mod images;
mod layout;
mod meaning;
mod meshes;
mod schema;
mod skeleton;
mod walk;

use std::collections::BTreeSet;

use self::walk::{Faults, Walk};
use super::buffers::Buffers;
use super::json::Document;
use super::nodes::Tree;
use super::report::Report;
use crate::assets::AssetSource;

/// Reports the faults of a document that was parsed from `text`.
pub(super) fn check(
    text: &[u8],
    document: &Document,
    (buffers, tree): (&Buffers, &Tree),
    source: (&str, &dyn AssetSource),
    report: &mut Report,
) {
    let d = document;
    let lengths = [
        d.accessors.len(),
        d.buffer_views.len(),
        d.buffers.len(),
        d.cameras.len(),
        d.images.len(),
        d.materials.len(),
        d.meshes.len(),
        d.nodes.len(),
        d.samplers.len(),
        d.scenes.len(),
        d.skins.len(),
        d.textures.len(),
        d.extensions.lights.as_ref().map_or(0, |l| l.lights.len()),
        d.extensions.variants.as_ref().map_or(0, |v| v.variants.len()),
        d.extensions.environments.as_ref().map_or(0, |e| e.lights.len()),
    ];
    let used: BTreeSet<&str> = d.extensions_used.iter().map(String::as_str).collect();
    let mut walk = Walk::new(lengths, used);
    // GLB pads the JSON with spaces or zeros.
    let end = text.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    walk::walk(text.get(..end).unwrap_or_default(), &mut walk, &schema::ROOT);
    let mut faults = walk.faults;
    meaning::check(document, &mut faults);
    layout::check(document, &mut faults);
    meshes::check(document, &mut faults);
    skeleton::check(document, tree, &mut faults);
    data::check(document, buffers, &mut faults);
    images::check(document, buffers, source, &mut faults);
    faults.report(report);
}

/// Adds a fault of an element of a list; all elements with this fault count as one.
fn add(faults: &mut Faults, list: &str, i: usize, member: &str, message: impl AsRef<str>) {
    let message = message.as_ref();
    let kind: String = message.chars().filter(|c| !c.is_ascii_digit()).collect();
    faults.add(format!("{list}/*{member} {kind}"), &format!("{list}/{i}{member}"), message);
}

#[cfg(test)]
mod tests;
