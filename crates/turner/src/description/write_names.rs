//! Unique names for the textures, materials, media and groups of a scene file.

use std::collections::BTreeSet;

use crate::color::named;
use crate::description::SceneDesc;
use crate::schema::Named;

/// The names of textures, materials, media and groups in key paths and references: for each its own name, or one made
/// from its kind and number, such as `material-3`. By index.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartNames {
    /// Of textures.
    pub textures: Vec<String>,
    /// Of materials.
    pub materials: Vec<String>,
    /// Of media.
    pub media: Vec<String>,
    /// Of groups.
    pub groups: Vec<String>,
}

impl SceneDesc {
    /// The names by which key paths and references find textures, materials, media and groups: those of
    /// [`edit`](SceneDesc::edit), [`value_at`](SceneDesc::value_at) and [`write_scene`](super::write_scene). They take
    /// time proportional to the number of these parts, not of objects.
    pub fn names(&self) -> PartNames {
        fn own<T>(list: &[Named<T>]) -> Vec<Option<&str>> {
            list.iter().map(|item| item.name.as_deref()).collect()
        }
        PartNames {
            // The name of a colour cannot name a texture.
            textures: names(&own(&self.textures), "texture", |name| named(name).is_none()),
            materials: names(&own(&self.materials), "material", |_| true),
            media: names(&own(&self.media), "medium", |_| true),
            groups: names(&own(&self.groups), "group", |_| true),
        }
    }
}

/// A unique name for each item of a list: its own name if `allowed` and not yet taken, otherwise a name made from its
/// own name or from `kind`, with a number.
pub(super) fn names(own: &[Option<&str>], kind: &str, allowed: impl Fn(&str) -> bool) -> Vec<String> {
    // No made name equals the own name of another item.
    let mut taken: BTreeSet<String> = own.iter().flatten().map(|n| (*n).to_owned()).collect();
    let mut given: BTreeSet<&str> = BTreeSet::new();
    let mut out = Vec::with_capacity(own.len());
    // The next number by base name, so that numbering many items of one name takes linear time.
    let mut last = std::collections::BTreeMap::new();
    for (i, name) in own.iter().enumerate() {
        if let Some(name) = name
            && allowed(name)
            && given.insert(name)
        {
            out.push((*name).to_owned());
            continue;
        }
        let base = name.filter(|name| !name.is_empty()).unwrap_or(kind);
        let start = if name.is_some() { 2 } else { i + 1 };
        let next = last.entry(base).or_insert(start);
        *next = (*next).max(start);
        let made = loop {
            let made = format!("{base}-{next}");
            *next += 1;
            if allowed(&made) && taken.insert(made.clone()) {
                break made;
            }
        };
        out.push(made);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_kept_and_made_where_there_are_none() {
        let own = [Some("a"), None, Some("a"), Some("red"), Some("a-2"), None, Some(""), Some(""), Some("a")];
        let made = names(&own, "item", |n| n != "red");
        assert_eq!(made, ["a", "item-2", "a-3", "red-2", "a-2", "item-6", "", "item-7", "a-4"]);
        assert_eq!(made.iter().collect::<BTreeSet<_>>().len(), own.len());
    }
}
