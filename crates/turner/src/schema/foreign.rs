//! Keys and types of other programs, and what to write in Turner instead.
//!
//! A misspelt word is close to a valid one, but a word of POV-Ray, three.js, Blender, pbrt or Mitsuba often is not. The
//! tables [`KEYS`] and [`KINDS`] map such a word, in its context, to a sentence that says what to write instead.

pub use super::foreign_words::{KEYS, KINDS};

/// Words that share one remedy.
#[derive(Clone, Copy, Debug)]
pub struct Foreign {
    /// The contexts of the remedy: for a key, parts of the table's name in messages (`material "classic"`, `[film]`);
    /// for a `type`, its family. Empty: any context.
    pub within: &'static [&'static str],
    /// The words, in lower case and without `_`, `-` and spaces.
    pub words: &'static [&'static str],
    /// What to write instead, with code in backquotes.
    pub remedy: &'static str,
}

/// The remedy for an unknown key of the table that messages call `what`.
pub fn key(what: &str, key: &str) -> Option<&'static str> {
    let key = plain(key);
    KEYS.iter().find(|f| f.applies(what) && f.words.contains(&key.as_str())).map(|f| f.remedy)
}

/// The remedy for an unknown `type` of a family (`shape`, `light`, …).
pub fn kind(family: &str, name: &str) -> Option<&'static str> {
    let name = plain(name);
    KINDS.iter().find(|f| f.applies(family) && f.words.contains(&name.as_str())).map(|f| f.remedy)
}

/// All remedies for a word, in any context.
pub fn everywhere(word: &str) -> Vec<&'static Foreign> {
    let word = plain(word);
    KEYS.iter().chain(KINDS).filter(|f| f.words.contains(&word.as_str())).collect()
}

impl Foreign {
    fn applies(&self, what: &str) -> bool {
        self.within.is_empty() || self.within.iter().any(|part| what.contains(part))
    }
}

/// A word in the form of the tables, in lower case and without separators: `meshstandardmaterial`, `basecolor`.
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
