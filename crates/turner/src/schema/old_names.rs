//! Old names in the scene format. The reader accepts them and adds a note with the new name.

use super::value::Span;
use super::{KeyPart, ReadContext, Warning, WarningKind};

/// Keys: new name, old name. A table is searched for the new name first.
const KEYS: &[(&str, &str)] = &[
    ("clamp_sample", "max_sample"),
    ("fallback", "otherwise"),
    ("focus_distance", "focus"),
    ("fov", "angle"),
    ("lights", "studio"),
    ("rotation", "studio_rotation"),
    ("shared_paths", "reuse"),
    ("strength", "studio_strength"),
    ("studio", "stage"),
];

/// Values of `type`: new name, old name.
const TYPES: &[(&str, &str)] =
    &[("checkerboard", "chessboard"), ("interface", "boundary"), ("multiply", "product")];

/// Keys in key paths: section, new name, old name.
const PATHS: &[(&str, &str, &str)] = &[
    ("film", "clamp_sample", "max_sample"),
    ("camera", "focus_distance", "focus"),
    ("integrator", "shared_paths", "reuse"),
    ("studio", "lights", "studio"),
    ("studio", "rotation", "studio_rotation"),
    ("studio", "strength", "studio_strength"),
];

/// The old name of a key, if it has one.
pub fn of_key(new: &str) -> Option<&'static str> {
    KEYS.iter().find(|(name, _)| *name == new).map(|(_, old)| *old)
}

/// The new name of a type, if `name` is its old one.
pub fn new_type(name: &str) -> Option<&'static str> {
    TYPES.iter().find(|(_, old)| *old == name).map(|(new, _)| *new)
}

/// Replaces old names in a key path such as `film.max_sample`.
pub fn update_path(path: &mut [KeyPart]) {
    if let Some(section) = path.first_mut()
        && section.key == "stage"
    {
        section.key = "studio".to_owned();
    }
    if let [section, _, key] = path
        && (section.key.as_str(), key.key.as_str()) == ("light", "group")
    {
        key.key = "light_group".to_owned();
    }
    if let [section, key, ..] = path
        && let Some((_, new, _)) = PATHS.iter().find(|(name, _, old)| *name == section.key && *old == key.key)
    {
        key.key = (*new).to_owned();
    }
}

/// Records the note about an old name.
pub fn note(old: &str, new: &str, span: Span, cx: &mut dyn ReadContext) {
    let message = format!("`{old}` is now called `{new}`; the old name is still read");
    cx.remark(Warning { span: Some(span), ..Warning::new(WarningKind::Note, message) });
}
