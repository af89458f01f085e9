//! The files of the page, for programs that serve it.

/// A row of the table: a file of `page` and its media type.
macro_rules! page {
    ($($name:literal $kind:literal;)*) => {
        /// All files of the page but the WebAssembly module: name, media type, bytes.
        pub const PAGE: &[(&str, &str, &[u8])] =
            &[$(($name, $kind, include_bytes!(concat!("../page/", $name)))),*];
    };
}

page! {
    "blank.html" "text/html; charset=utf-8";
    "checks.js" "text/javascript; charset=utf-8";
    "color.js" "text/javascript; charset=utf-8";
    "completion.js" "text/javascript; charset=utf-8";
    "compound.js" "text/javascript; charset=utf-8";
    "core.js" "text/javascript; charset=utf-8";
    "dom.js" "text/javascript; charset=utf-8";
    "editor.css" "text/css; charset=utf-8";
    "editor.js" "text/javascript; charset=utf-8";
    "engine.js" "text/javascript; charset=utf-8";
    "explain.css" "text/css; charset=utf-8";
    "explain.js" "text/javascript; charset=utf-8";
    "fields.js" "text/javascript; charset=utf-8";
    "files.js" "text/javascript; charset=utf-8";
    "gestures.js" "text/javascript; charset=utf-8";
    "highlight.js" "text/javascript; charset=utf-8";
    "hover.js" "text/javascript; charset=utf-8";
    "icon.svg" "image/svg+xml";
    "index.html" "text/html; charset=utf-8";
    "isolate.js" "text/javascript; charset=utf-8";
    "links.js" "text/javascript; charset=utf-8";
    "manifest.webmanifest" "application/manifest+json";
    "menu.js" "text/javascript; charset=utf-8";
    "merge.js" "text/javascript; charset=utf-8";
    "message.js" "text/javascript; charset=utf-8";
    "page.css" "text/css; charset=utf-8";
    "page.js" "text/javascript; charset=utf-8";
    "parts.js" "text/javascript; charset=utf-8";
    "properties.css" "text/css; charset=utf-8";
    "properties.js" "text/javascript; charset=utf-8";
    "remote.js" "text/javascript; charset=utf-8";
    "scene.css" "text/css; charset=utf-8";
    "start.css" "text/css; charset=utf-8";
    "start.js" "text/javascript; charset=utf-8";
    "status.js" "text/javascript; charset=utf-8";
    "sw.js" "text/javascript; charset=utf-8";
    "tabs.js" "text/javascript; charset=utf-8";
    "thread.js" "text/javascript; charset=utf-8";
    "tools.js" "text/javascript; charset=utf-8";
    "value.js" "text/javascript; charset=utf-8";
    "viewport.js" "text/javascript; charset=utf-8";
    "worker.js" "text/javascript; charset=utf-8";
    "zip.js" "text/javascript; charset=utf-8";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_file_of_the_page() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/page");
        let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut files: Vec<String> = files.collect();
        files.sort();
        let names: Vec<&str> = PAGE.iter().map(|(name, _, _)| *name).collect();
        assert_eq!(names, files);
    }
}
