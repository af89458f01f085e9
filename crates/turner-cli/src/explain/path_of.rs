//! Checks the name given with `--path-of`.

use std::collections::BTreeSet;

use turner::explain::Names;
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, SceneError};

/// An error if neither an object nor a material has this name.
pub(super) fn check(names: &Names<'_>, wanted: &str) -> Result<(), SceneError> {
    let materials = names.desc.materials.iter().filter_map(|m| m.name.as_deref());
    let objects = names.prepared.scene.object_names().iter().map(String::as_str);
    let valid: BTreeSet<&str> = materials.chain(objects).collect();
    // `sphere #4` stands for an object without a name.
    let number = wanted.rsplit_once('#').and_then(|(_, n)| n.parse::<u64>().ok());
    if valid.contains(wanted) || number.is_some_and(|n| n < names.prepared.scene.stats.primitives) {
        return Ok(());
    }
    let message = format!("--path-of: there is no object and no material \"{}\"", escape(wanted));
    let valid: Vec<&str> = valid.into_iter().collect();
    let help = suggestion(wanted, &valid).unwrap_or_else(|| {
        "no object or material of this scene has a name: use the shape and index of an object, e.g. \"sphere #0\"".to_owned()
    });
    Err(SceneError::new(ErrorCode::UnknownName, message).help(help))
}
