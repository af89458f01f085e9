//! A model by itself: a small scene around it.

use super::sources::{SourceFile, Sources};
use super::{LoadError, LoadOptions, Loaded, SceneFormat, read};
use crate::assets::{AssetSource, printable};

/// The scene that shows a model: on a stage, in physical light. What it says can be replaced as in any other scene, its one
/// object being `object.0`.
pub(super) fn scene_around(file: &str, format: SceneFormat) -> String {
    let up = if format == SceneFormat::Stl { "z" } else { "y" };
    format!(
        "[film]\ntransfer = \"srgb\"\ntonemap = \"neutral\"\nantialias = \"monte-carlo\"\nsamples = 32\n\n[integrator]\ntype = \"path\"\n\n\
         [background]\ncolor = 1\n\n\
         [stage]\n\n\
         [[object]]\ntype = \"model\"\nfile = {}\nup = \"{up}\"\n",
        quoted(file)
    )
}

/// The text that brings a model into the scene which includes it.
pub(super) fn included(file: &str, format: SceneFormat) -> String {
    let up = if format == SceneFormat::Stl { "z" } else { "y" };
    format!("[[object]]\ntype = \"model\"\nfile = {}\nup = \"{up}\"\n", quoted(file))
}

/// As a string of TOML.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Loads a model whose bytes were read; `name` is the path as the user wrote it, `uri` its last part.
pub(super) fn load(
    bytes: Vec<u8>,
    format: SceneFormat,
    name: &str,
    uri: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let text = scene_around(uri, format);
    let mut sources = Sources::default();
    let given = assets.resolve(uri, uri).ok().map(|path| (path, bytes));
    match read(text, (name, uri), assets, options, &mut sources, given) {
        Ok((desc, hash)) => Ok(Loaded { desc, sources, hash }),
        Err(mut error) => {
            // A place in the text above would tell nobody anything.
            let is_ours = |file: &SourceFile| !file.is_argument && file.name == printable(name);
            if error.span.is_some_and(|span| sources.get(span.file).is_some_and(is_ours)) {
                error.span = None;
            }
            Err(LoadError { error, sources })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_is_quoted() {
        assert_eq!(quoted("a \"b\" \\ c\n"), "\"a \\\"b\\\" \\\\ c\\u000A\"");
    }
}
