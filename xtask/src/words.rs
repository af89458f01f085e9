//! `cargo xtask words`: phrases that documents, comments and messages do not use, and what to say instead.

use std::path::{Path, PathBuf};

/// Banned phrases in lower case, with the words to use. A phrase matches whole words; `*` at its end matches any ending.
const PHRASES: &[(&str, &str)] = &[
    ("of chance", "stochastic, random"),
    ("by chance", "random; a BSDF sample that hits the light"),
    ("no number", "NaN or infinite"),
    ("no numbers", "NaN or infinite, non-finite"),
    ("no finite number*", "not finite, non-finite"),
    ("manieth", "every Nth"),
    ("surroundings", "environment"),
    ("what is around the scene", "the environment"),
    ("files of strangers", "untrusted files"),
    ("strangers", "untrusted files"),
    ("stranger's", "untrusted"),
    ("light as it is", "physically based light transport"),
    ("a picture all around", "environment map"),
    ("made ready", "prepared"),
    ("shines", "emits"),
    ("that shine", "emissive, that emit light"),
    ("what shines", "emitters"),
    ("shining", "emissive, emitter"),
    ("looking at things", "debug views"),
    ("so to say", "(leave it out)"),
    ("is there at all", "is visible, is opaque"),
    ("it was asked for, and has no effect", "ignored"),
    ("asked for and has no effect", "ignored"),
    ("dearest", "most expensive, costliest"),
    ("sieve*", "sphere culler"),
    ("chessboard*", "checkerboard"),
    ("who looks", "the viewer, the camera"),
    ("walk about", "random walk"),
    ("the same whatever", "independent of"),
    ("none the less", "still"),
    ("people's own", "users'"),
    ("by itself", "alone, on its own"),
    ("each by itself", "each on its own"),
    ("goes on", "continues"),
    ("went on", "continued"),
    ("go on", "continue"),
    ("leave off", "stop"),
    ("in truth", "exactly, in the limit"),
    ("way of light", "path of light, distance"),
    ("mean way", "mean free path"),
];

/// Files, or folders with a slash at their end, that may use a phrase, because they quote other people or test the words themselves.
const EXCEPT: &[(&str, &str)] = &[
    ("xtask/src/words.rs", ""),
    ("crates/turner/src/schema/old_names.rs", ""),
    ("crates/turner-io/tests/suite/files/old_names.rs", ""),
    ("CHANGELOG.md", "chessboard"),
    ("CHANGELOG.md", "shining"),
    ("CHANGELOG.md", "surroundings"),
    ("docs/reference/classic.md", "chessboard"),
    // The board of a game of chess.
    ("docs/tutorial/first-scene.md", "chessboard"),
    // The words of statistics.
    ("crates/turner/src/testing/compare.rs", "by chance"),
    ("crates/turner/src/testing/tails.rs", "by chance"),
];

/// Every use of a banned phrase below `root`: file, line, phrase, words to use instead.
pub(crate) fn check(root: &Path) -> Result<usize, String> {
    let mut files = Vec::new();
    for top in ["crates", "docs", "scenes", "examples", "xtask", "benches", "fuzz"] {
        collect(&root.join(top), &mut files)?;
    }
    let documents = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"];
    files.extend(documents.map(|name| root.join(name)));
    files.sort();
    let mut found = Vec::new();
    for path in &files {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
        for (number, line) in text.lines().enumerate() {
            for (phrase, instead) in uses(line) {
                if !EXCEPT
                    .iter()
                    .any(|(file, only)| *file == name && (only.is_empty() || phrase.starts_with(only)))
                {
                    found.push(format!("{name}:{}: \"{phrase}\": say: {instead}", number + 1));
                }
            }
        }
    }
    if found.is_empty() {
        Ok(files.len())
    } else {
        Err(format!("{}\n{} uses", found.join("\n"), found.len()))
    }
}

/// Banned phrases in a line.
fn uses(line: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let line = line.to_lowercase();
    PHRASES.iter().copied().filter(move |(phrase, _)| {
        let (word, any_ending) = match phrase.strip_suffix('*') {
            Some(word) => (word, true),
            None => (*phrase, false),
        };
        line.match_indices(word).any(|(at, _)| {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let before = line[..at].chars().next_back();
            let after = line[at + word.len()..].chars().next();
            !before.is_some_and(is_word) && (any_ending || !after.is_some_and(is_word))
        })
    })
}

/// Text files of a folder and of the folders below it.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for path in entries.filter_map(|entry| entry.ok().map(|e| e.path())) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if !["target", "seeds", "assets", "data", "corpus"].contains(&name.as_str()) {
                collect(&path, files)?;
            }
        } else if [".md", ".rs", ".toml", ".py"].iter().any(|ending| name.ends_with(ending)) {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phrases_match_whole_words() {
        let phrases = |line| uses(line).map(|(p, _)| p).collect::<Vec<_>>();
        assert_eq!(phrases("An integrator Of Chance."), ["of chance"]);
        assert_eq!(phrases("the sieved ones"), ["sieve*"]);
        assert!(phrases("it outshines all; a bargain of chances").is_empty());
    }

    #[test]
    fn nothing_written_here_uses_them() {
        check(crate::root()).unwrap_or_else(|found| panic!("{found}"));
    }
}
