//! An explanation of every pixel of a picture as one self-contained file: the core as WebAssembly, the scene and the picture
//! are in it. It needs no network and no host.

use std::fmt::Write as _;

use miniz_oxide::deflate::compress_to_vec_zlib;

use crate::base64;

/// What a page holds.
#[derive(Clone, Copy, Debug)]
pub struct ExplainPage<'a> {
    /// The name of the scene.
    pub title: &'a str,
    /// The WebAssembly module: `turner.wasm` of `cargo xtask web`.
    pub module: &'a [u8],
    /// The files of the scene: name and bytes.
    pub files: &'a [(String, Vec<u8>)],
    /// The scene among them.
    pub main: &'a str,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The picture as a PNG file.
    pub png: &'a [u8],
    /// The pixel that is explained first.
    pub pixel: Option<(u32, u32)>,
}

const PAGE: &str = include_str!("explain_page/page.html");
const STYLE: [&str; 3] = [
    include_str!("../page/page.css"),
    include_str!("../page/explain.css"),
    include_str!("explain_page/own.css"),
];
/// The modules of the page, each after those that it imports.
const SCRIPTS: [&str; 4] = [
    include_str!("../page/core.js"),
    include_str!("../page/dom.js"),
    include_str!("../page/explain.js"),
    include_str!("explain_page/own.js"),
];

/// A module without imports and exports, to stand in one script with those that it imports.
fn joined(module: &str) -> String {
    let own = module.lines().filter(|line| !line.starts_with("import "));
    own.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}

/// Text in the contents of an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The page as HTML.
pub fn explain_page(page: &ExplainPage<'_>) -> String {
    let packed = |bytes: &[u8]| base64::encode(&compress_to_vec_zlib(bytes, 8));
    let mut files = String::new();
    for (name, bytes) in page.files {
        let _ = writeln!(
            files,
            "<script type=\"text/plain\" class=\"file\" data-name=\"{}\">{}</script>",
            escaped(name),
            packed(bytes)
        );
    }
    let pixel = page.pixel.map_or(String::new(), |(x, y)| format!("{x},{y}"));
    let values = [
        ("TITLE", escaped(page.title)),
        ("STYLE", STYLE.concat()),
        ("MAIN", escaped(page.main)),
        ("PIXEL", pixel),
        ("WIDTH", page.size[0].to_string()),
        ("HEIGHT", page.size[1].to_string()),
        ("PNG", base64::encode(page.png)),
        ("SCRIPT", SCRIPTS.map(joined).concat()),
        ("FILES", files),
        ("MODULE", packed(page.module)),
    ];
    // One pass: a value that contains a mark is not replaced again.
    let mut out = String::with_capacity(PAGE.len() + values.iter().map(|(_, v)| v.len()).sum::<usize>());
    let mut rest = PAGE;
    while let Some((before, after)) = rest.split_once("{{") {
        out += before;
        let Some((name, end)) = after.split_once("}}") else { break };
        out += values.iter().find(|(own, _)| *own == name).map_or("", |(_, value)| value);
        rest = end;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_holds_its_files_and_no_marks() {
        let files = [("a \"<b>.toml".to_owned(), b"{{PNG}}".to_vec())];
        let page = ExplainPage {
            title: "A & B",
            module: b"\0asm",
            files: &files,
            main: "a.toml",
            size: [4, 3],
            png: b"png",
            pixel: Some((1, 2)),
        };
        let text = explain_page(&page);
        assert!(text.contains("<title>A &amp; B") && text.contains("data-name=\"a &quot;&lt;b&gt;.toml\""));
        assert!(text.contains("data-pixel=\"1,2\"") && text.contains("width=\"4\" height=\"3\""));
        assert!(!text.contains("{{"), "a mark is left");
        assert!(!text.contains("\nimport ") && !text.contains("\nexport "), "modules are joined");
        // Nothing in the script ends it.
        assert_eq!(text.matches("</script>").count(), 3);
    }
}
