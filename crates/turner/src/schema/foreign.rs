//! Words of other programs, and what Turner calls them.
//!
//! A misspelt word is near a valid one; a word of POV-Ray, three.js, Blender, pbrt or Mitsuba often is not. The tables
//! ([`KEYS`], [`KINDS`]) lead from the context and the word to a sentence that names what to write instead.

pub use super::foreign_words::{KEYS, KINDS};

/// Words with one remedy.
#[derive(Clone, Copy, Debug)]
pub struct Foreign {
    /// Where the remedy applies: parts of what a table is called in messages (`material "classic"`, `[film]`), or the family
    /// of a `type`. Empty: anywhere.
    pub within: &'static [&'static str],
    /// The words in lower case, without `_`, `-` and spaces.
    pub words: &'static [&'static str],
    /// What to write instead. Code stands in backquotes.
    pub remedy: &'static str,
}

/// The remedy for an unknown key of a table that is `what` in messages.
pub fn key(what: &str, key: &str) -> Option<&'static str> {
    let key = plain(key);
    KEYS.iter().find(|f| f.applies(what) && f.words.contains(&key.as_str())).map(|f| f.remedy)
}

/// The remedy for an unknown `type` of a family (`shape`, `light`, …).
pub fn kind(family: &str, name: &str) -> Option<&'static str> {
    let name = plain(name);
    KINDS.iter().find(|f| f.applies(family) && f.words.contains(&name.as_str())).map(|f| f.remedy)
}

/// All remedies for a word, whatever its context, each with where it applies.
pub fn everywhere(word: &str) -> Vec<&'static Foreign> {
    let word = plain(word);
    KEYS.iter().chain(KINDS).filter(|f| f.words.contains(&word.as_str())).collect()
}

impl Foreign {
    fn applies(&self, what: &str) -> bool {
        self.within.is_empty() || self.within.iter().any(|part| what.contains(part))
    }
}

/// A word as the tables have it: `MeshStandardMaterial`, `base color` and `look-at` lose case and separators.
fn plain(word: &str) -> String {
    word.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).flat_map(char::to_lowercase).take(64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_as_they_are_searched_for() {
        for word in KEYS.iter().chain(KINDS).flat_map(|f| f.words) {
            assert_eq!(plain(word), *word);
        }
    }

    #[test]
    fn the_context_decides() {
        assert!(key("the shape \"sphere\"", "color").unwrap().contains("material = {"));
        assert!(key("the material \"classic\"", "roughness").unwrap().contains("`gloss`"));
        assert!(key("the material \"principled\"", "Roughness").unwrap().contains("`specular_roughness`"));
        assert!(kind("material", "MeshStandardMaterial").unwrap().contains("principled"));
        assert_eq!(kind("light", "banana"), None);
    }
}
