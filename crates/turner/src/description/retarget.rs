//! Animations follow the parts that they target when these are renamed, removed or grouped.

use std::collections::BTreeSet;

use super::animate::Targets;
use crate::description::SceneDesc;
use crate::schema::value::Span;
use crate::schema::{KeyPart, path_part};

impl SceneDesc {
    /// Changes the target of each animation: `change` takes the parts of its key path and returns the new ones; `None`
    /// leaves it as it is.
    pub(super) fn retarget(&mut self, change: impl Fn(&[&str]) -> Option<Vec<String>>) {
        for own in &mut self.animations {
            let parts = KeyPart::split(&own.value.target);
            let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
            if let Some(new) = change(&keys) {
                let quoted: Vec<String> = new.iter().map(|part| path_part(part)).collect();
                own.value.target = quoted.join(".");
            }
        }
    }

    /// Renames the second part of targets that begin with `section` and `old`.
    pub(super) fn retarget_name(&mut self, section: &str, old: &str, new: &str) {
        self.retarget(|keys| match keys {
            [first, name, rest @ ..] if *first == section && *name == old => {
                Some([section, new].iter().chain(rest).map(|part| (*part).to_owned()).collect())
            }
            _ => None,
        });
    }

    /// Whether an object has this name.
    pub(super) fn has_object(&self, name: &str) -> bool {
        self.objects.iter().any(|own| own.name.as_deref() == Some(name))
    }

    /// Renumbers targets by index after items of a list were removed from `before`. Removed ones become a target that
    /// does not exist.
    pub(super) fn retarget_numbers(&mut self, section: &str, before: &SceneDesc, removed: &BTreeSet<usize>) {
        let is_name = |name: &str| match section {
            "object" => before.has_object(name),
            "light" => before.lights.iter().any(|own| own.name.as_deref() == Some(name)),
            _ => before.cameras.iter().any(|own| own.name.as_deref() == Some(name)),
        };
        self.retarget(|keys| match keys {
            [first, key, rest @ ..] if *first == section && !is_name(key) => {
                let index: usize = key.parse().ok()?;
                let new = match removed.contains(&index) {
                    true => "removed".to_owned(),
                    false => (index - removed.range(..index).count()).to_string(),
                };
                let rest = rest.iter().map(|part| (*part).to_owned());
                Some([section.to_owned(), new].into_iter().chain(rest).collect())
            }
            _ => None,
        });
    }

    /// Removes animations whose target is gone.
    pub(super) fn drop_animations_without_target(&mut self) {
        if self.animations.is_empty() {
            return;
        }
        let names = self.names();
        let mut targets = Targets::new(self);
        let is_there = |target: &str| {
            let parts = KeyPart::split(target);
            let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
            let has = |names: &[String], name: &str| names.iter().any(|own| own == name);
            match keys.as_slice() {
                ["texture", name, ..] => has(&names.textures, name),
                ["material", name, ..] => has(&names.materials, name),
                ["medium", name, ..] => has(&names.media, name),
                _ => targets.paths(target, Span::NONE).is_ok(),
            }
        };
        let kept: Vec<bool> =
            self.animations.iter().map(|own| own.value.target.as_str()).map(is_there).collect();
        let mut kept = kept.into_iter();
        self.animations.retain(|_| kept.next().unwrap_or(true));
    }
}
