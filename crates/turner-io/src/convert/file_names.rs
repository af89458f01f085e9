//! Safe file names from arbitrary names in a scene.

use std::collections::BTreeSet;

/// Longest name without its extension, in bytes.
const LONGEST: usize = 64;
/// Windows device names, reserved with any extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// Converts a name to a part of a file name: letters and digits of any script, `_`, and `-` for everything else;
/// bounded in length. Empty if nothing usable remains.
pub(super) fn safe(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        let c = if c.is_alphanumeric() || c == '_' { c } else { '-' };
        if c == '-' && (out.is_empty() || out.ends_with('-')) {
            continue;
        }
        if out.len() + c.len_utf8() > LONGEST {
            break;
        }
        out.push(c);
    }
    let mut out = out.trim_end_matches('-').to_owned();
    let lower = out.to_lowercase();
    let port = ["com", "lpt"].iter().any(|p| lower.strip_prefix(p).is_some_and(|n| n.len() == 1));
    if DEVICES.contains(&lower.as_str()) || port {
        out.push('_');
    }
    out
}

/// The last part of a path or URI, without its extension.
pub(super) fn stem(uri: &str) -> &str {
    let last = uri.rsplit(['/', '\\']).next().unwrap_or(uri);
    match last.rsplit_once('.') {
        Some((stem, extension)) if !stem.is_empty() && extension.len() <= 5 => stem,
        _ => last,
    }
}

/// The names already used in a folder. Names that differ only in letter case count as equal, as on case-insensitive
/// file systems.
#[derive(Debug, Default)]
pub(super) struct Taken(BTreeSet<String>, std::collections::BTreeMap<String, usize>);

impl Taken {
    /// A unique name based on `wanted`, or on `kind` if nothing usable remains of it.
    pub(super) fn name(&mut self, wanted: &str, kind: &str, extension: &str) -> String {
        let base = Some(safe(wanted)).filter(|name| !name.is_empty()).unwrap_or_else(|| kind.to_owned());
        let mut name = format!("{base}.{extension}");
        let count = self.1.entry(name.to_lowercase()).or_insert(1);
        while !self.0.insert(name.to_lowercase()) {
            *count += 1;
            name = format!("{base}-{count}.{extension}");
        }
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_becomes_a_safe_one() {
        for (name, expected) in [
            ("Chair leg.001", "Chair-leg-001"),
            ("../../etc/passwd", "etc-passwd"),
            ("C:\\boot", "C-boot"),
            ("a\u{0}b\u{202e}c\n", "a-b-c"),
            ("....", ""),
            ("", ""),
            ("nul", "nul_"),
            ("COM7", "COM7_"),
            ("Stuhlbein Ärmel", "Stuhlbein-Ärmel"),
            ("椅子", "椅子"),
            ("%2e%2e", "2e-2e"),
        ] {
            assert_eq!(safe(name), expected, "{name:?}");
        }
        assert!(safe(&"ß".repeat(10_000)).len() <= LONGEST);
    }

    #[test]
    fn no_two_names_are_the_same_anywhere() {
        let mut taken = Taken::default();
        let names = ["a", "A", "a", "a-2", "", "//", "mesh"].map(|n| taken.name(n, "mesh", "ply"));
        assert_eq!(
            names,
            ["a.ply", "A-2.ply", "a-3.ply", "a-2-2.ply", "mesh.ply", "mesh-2.ply", "mesh-3.ply"]
        );
    }

    #[test]
    fn stems_are_what_stands_between() {
        for (uri, expected) in [
            ("a/b/tree.obj", "tree"),
            ("x\\y.png", "y"),
            (".hidden", ".hidden"),
            ("v1.2 of it", "v1.2 of it"),
        ] {
            assert_eq!(stem(uri), expected);
        }
    }
}
