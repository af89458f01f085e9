//! A scene file as a tree of elements: included files are inserted, `$names` replaced, names of older versions
//! updated.

use std::collections::BTreeMap;

use turner::schema::{ErrorCode, Remedy};

use super::xml::{Event, Reader};
use crate::assets::{AssetSource, printable};
use crate::scene_import::report::Fault;
use crate::scene_import::{self, Place, unknown};

/// Longest chain of includes.
const MAX_CHAIN: usize = 64;
/// Most files of a scene.
const MAX_FILES: usize = 1024;
/// Most bytes of all texts.
const MAX_TEXT: u64 = 256 << 20;
/// Most elements of a scene.
const MAX_ELEMENTS: usize = 1 << 21;
/// Deepest nesting of elements.
const MAX_DEPTH: usize = 64;
/// Most search paths.
const MAX_PATHS: usize = 16;
/// Most bytes that `$names` expand to, in addition to the text itself.
const MAX_REPLACED: usize = 16 << 20;

/// An element.
#[derive(Debug)]
pub(super) struct Node {
    /// Its name: `bsdf`, `float`, …
    pub(super) tag: String,
    attributes: Vec<(String, String)>,
    pub(super) place: Place,
    pub(super) children: Vec<usize>,
}

impl Node {
    /// The value of an attribute.
    pub(super) fn attribute(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }
}

/// A scene and the files that it includes.
#[derive(Debug, Default)]
pub(super) struct Document {
    nodes: Vec<Node>,
    ids: BTreeMap<String, usize>,
    /// The files read; positions refer to them by index.
    pub(super) files: Vec<String>,
    /// Folders to search in addition to that of the scene.
    pub(super) paths: Vec<String>,
    /// Whether the file has the names of Mitsuba 0.6, e.g. toWorld.
    pub(super) is_old: bool,
    /// Parameters that the user set and the scene does not use.
    pub(super) unused: Vec<String>,
}

impl Document {
    /// An element.
    pub(super) fn node(&self, index: usize) -> Option<&Node> {
        self.nodes.get(index)
    }

    /// All elements, in the order of the file.
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The element that a `ref` refers to; any other element itself.
    pub(super) fn resolve(&self, index: usize) -> Result<usize, Fault> {
        let Some(node) = self.nodes.get(index).filter(|n| n.tag == "ref") else { return Ok(index) };
        let Some(id) = node.attribute("id") else {
            return Err(Fault::at(node.place, ErrorCode::MissingKey, "a ref needs an id"));
        };
        self.ids.get(id).copied().ok_or_else(|| {
            let all: Vec<&str> = self.ids.keys().map(String::as_str).collect();
            unknown("id", id, &all).or_at(node.place)
        })
    }
}

/// Reads a scene. `defines` take precedence over the `default` values in the file.
pub(super) struct Loader<'a> {
    assets: &'a dyn AssetSource,
    /// The scene; paths are relative to its folder.
    uri: &'a str,
    values: BTreeMap<String, (String, bool)>,
    chain: Vec<String>,
    open: Vec<usize>,
    left: u64,
    replaced: usize,
    pub(super) document: Document,
}

impl<'a> Loader<'a> {
    pub(super) fn new(assets: &'a dyn AssetSource, uri: &'a str, defines: &[(String, String)]) -> Loader<'a> {
        Loader {
            assets,
            uri,
            values: defines.iter().map(|(k, v)| (k.clone(), (v.clone(), false))).collect(),
            chain: Vec::new(),
            open: Vec::new(),
            left: MAX_TEXT,
            replaced: 0,
            document: Document::default(),
        }
    }

    /// Reads everything, beginning with the bytes of the scene file.
    pub(super) fn read(&mut self, bytes: Vec<u8>) -> Result<(), Fault> {
        let uri = self.uri.to_owned();
        self.file(uri, bytes)?;
        let given = self.values.iter().filter(|(_, (_, used))| !used);
        self.document.unused = given.map(|(k, _)| k.clone()).collect();
        Ok(())
    }

    fn file(&mut self, uri: String, bytes: Vec<u8>) -> Result<(), Fault> {
        let number = self.document.files.len() as u32;
        self.document.files.push(uri.clone());
        let start = Place { file: number, line: 1, column: 1 };
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or_else(|| {
            Fault::at(start, ErrorCode::TooLarge, format!("more than {MAX_TEXT} bytes of text"))
        })?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Fault::at(start, ErrorCode::Syntax, "the text is not UTF-8"))?;
        self.chain.push(uri);
        let mut reader = Reader::new(&text, number);
        let mut names: Vec<String> = Vec::new();
        let mut roots = 0;
        loop {
            let (event, place) = reader.next()?;
            match event {
                Event::Start { name, attributes, ends } => {
                    if names.is_empty() {
                        roots += 1;
                    }
                    if roots > 1 {
                        let message = "a second element at the top of the file";
                        return Err(Fault::at(place, ErrorCode::Syntax, message));
                    }
                    if names.len() >= MAX_DEPTH || self.open.len() >= 2 * MAX_DEPTH {
                        let message = format!("elements nest deeper than {MAX_DEPTH}");
                        return Err(Fault::at(place, ErrorCode::TooLarge, message));
                    }
                    let is_root = names.is_empty();
                    self.start(&name, attributes, place, is_root)?;
                    names.push(name);
                    if ends {
                        names.pop();
                        self.open.pop();
                    }
                }
                Event::End { name } => {
                    if names.last() != Some(&name) {
                        let open = match names.last() {
                            Some(open) => format!("</{}>", printable(open)),
                            None => "an element".to_owned(),
                        };
                        let message = format!("expected {open}, found </{}>", printable(&name));
                        return Err(Fault::at(place, ErrorCode::Syntax, message));
                    }
                    names.pop();
                    self.open.pop();
                }
                Event::Eof => {
                    if let Some(open) = names.last() {
                        let message = format!("the file ends within <{}>", printable(open));
                        return Err(Fault::at(place, ErrorCode::Syntax, message));
                    }
                    if roots == 0 {
                        return Err(Fault::at(place, ErrorCode::Syntax, "expected <scene>, found nothing"));
                    }
                    self.chain.pop();
                    return Ok(());
                }
            }
        }
    }

    fn start(
        &mut self,
        name: &str,
        mut attributes: Vec<(String, String)>,
        place: Place,
        is_root: bool,
    ) -> Result<(), Fault> {
        let included = self.chain.len() > 1;
        if is_root && !included {
            if name != "scene" {
                let message = format!("expected <scene>, found <{}>", printable(name));
                return Err(Fault::at(place, ErrorCode::Syntax, message)
                    .help("a scene of Mitsuba begins with <scene version=\"3.0.0\">"));
            }
            let version = attributes.iter().find(|(k, _)| k == "version").map_or("", |(_, v)| v.as_str());
            self.document.is_old = version.starts_with("0.") || version.starts_with("1.");
        }
        for (_, value) in &mut attributes {
            if value.contains('$') {
                *value = self.substituted(value, place)?;
            }
        }
        // The file chooses the names of its own parameters.
        if self.document.is_old && name != "default" {
            for (key, value) in &mut attributes {
                if key == "name" {
                    *value = underscored(value);
                }
            }
        }
        let tag = if name == "lookAt" { "lookat".to_owned() } else { name.to_owned() };
        let get = |key: &str| attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone());
        let needed = |key: &str| {
            get(key).ok_or_else(|| {
                let message = format!("<{}> needs the attribute {key}", printable(name));
                Fault::at(place, ErrorCode::MissingKey, message)
            })
        };
        let mut splice = None;
        match name {
            "default" => {
                let (key, value) = (needed("name")?, needed("value")?);
                self.values.entry(key).or_insert((value, true));
            }
            "path" if get("value").is_some() => {
                let folder = needed("value")?;
                if self.document.paths.len() >= MAX_PATHS {
                    let message = format!("more than {MAX_PATHS} paths");
                    return Err(Fault::at(place, ErrorCode::TooLarge, message));
                }
                self.document.paths.push(folder.replace('\\', "/"));
            }
            "alias" => {
                let (id, alias) = (needed("id")?, needed("as")?);
                let Some(&target) = self.document.ids.get(&id) else {
                    let all: Vec<&str> = self.document.ids.keys().map(String::as_str).collect();
                    return Err(unknown("id", &id, &all).or_at(place));
                };
                self.document.ids.insert(alias, target);
            }
            "include" => splice = Some(needed("filename")?),
            _ => {}
        }
        // The contents of an included <scene> take the place of the include.
        let is_spliced = is_root && included && name == "scene";
        let is_silent =
            matches!(name, "default" | "alias" | "include") || name == "path" && get("value").is_some();
        if self.document.nodes.len() >= MAX_ELEMENTS {
            let message = format!("more than {MAX_ELEMENTS} elements");
            return Err(Fault::at(place, ErrorCode::TooLarge, message));
        }
        let index = self.document.nodes.len();
        if is_spliced {
            let parent = self.open.last().copied().unwrap_or_default();
            self.open.push(parent);
        } else {
            if tag != "ref"
                && let Some(id) = get("id")
                && !is_silent
            {
                self.document.ids.insert(id, index);
            }
            self.document.nodes.push(Node { tag, attributes, place, children: Vec::new() });
            if !is_silent && let Some(parent) = self.open.last().and_then(|p| self.document.nodes.get_mut(*p))
            {
                parent.children.push(index);
            }
            self.open.push(index);
        }
        if let Some(file) = splice {
            self.include(&file, place)?;
        }
        Ok(())
    }

    fn include(&mut self, name: &str, place: Place) -> Result<(), Fault> {
        if self.document.files.len() >= MAX_FILES || self.chain.len() >= MAX_CHAIN {
            let message = format!("includes deeper than {MAX_CHAIN}, or more than {MAX_FILES} files");
            return Err(Fault::at(place, ErrorCode::TooLarge, message));
        }
        let (path, bytes, _) = read_file(self.assets, self.uri, &self.document.paths, name, self.left, false)
            .map_err(|f| f.or_at(place))?;
        if self.chain.contains(&path) {
            let message = format!("{} includes itself", printable(&path));
            return Err(Fault::at(place, ErrorCode::File, message));
        }
        // Into the parent of the element `include`.
        let own = self.open.pop();
        let result = self.file(path, bytes);
        self.open.extend(own);
        result
    }

    /// A value with every `$name` replaced; the longest known name wins.
    fn substituted(&mut self, value: &str, place: Place) -> Result<String, Fault> {
        let mut out = String::new();
        let mut rest = value;
        while let Some(at) = rest.find('$') {
            out.push_str(rest.get(..at).unwrap_or_default());
            let after = rest.get(at + 1..).unwrap_or_default();
            let known = self.values.keys().filter(|k| !k.is_empty() && after.starts_with(k.as_str()));
            let Some(name) = known.max_by_key(|k| k.len()).cloned() else {
                let end = after.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(after.len());
                let all: Vec<&str> = self.values.keys().map(String::as_str).collect();
                let missing = after.get(..end).unwrap_or_default();
                let fault = unknown("parameter", missing, &all).or_at(place);
                return Err(fault
                    .help(
                        "define it when the scene is loaded, or with <default name=\"NAME\" value=\"VALUE\"/>",
                    )
                    .remedy(Remedy::Define(missing.to_owned())));
            };
            rest = after.get(name.len()..).unwrap_or_default();
            if let Some((value, used)) = self.values.get_mut(&name) {
                *used = true;
                self.replaced = self.replaced.saturating_add(value.len());
                if self.replaced > MAX_REPLACED {
                    let message = "the values of $names are too long in total";
                    return Err(Fault::at(place, ErrorCode::TooLarge, message));
                }
                out.push_str(value);
            }
        }
        out.push_str(rest);
        Ok(out)
    }
}

/// Reads a file from the scene's folder or from one of `paths`; returns its path and bytes, and its mark if it is read
/// `ahead`.
pub(super) fn read_file(
    assets: &dyn AssetSource,
    uri: &str,
    paths: &[String],
    name: &str,
    limit: u64,
    ahead: bool,
) -> Result<(String, Vec<u8>, Option<String>), Fault> {
    let name = name.replace('\\', "/");
    let mut first = None;
    for candidate in candidates(&name, paths) {
        let found = assets.resolve(uri, &candidate).and_then(|path| {
            let (bytes, mark) = scene_import::read_file(assets, &path, limit, ahead)?;
            Ok((path, bytes, mark))
        });
        match found {
            Ok(found) => return Ok(found),
            Err(e) => {
                first.get_or_insert(e);
            }
        }
    }
    Err(first.map_or_else(|| Fault::new(ErrorCode::File, "no file"), |e| e.to_scene_error().into()))
}

/// A name as it is written, and within each of the folders.
pub(super) fn candidates(name: &str, paths: &[String]) -> Vec<String> {
    let mut out = vec![name.to_owned()];
    out.extend(paths.iter().map(|p| format!("{}/{name}", p.trim_end_matches('/'))));
    out
}

/// `toWorld` as `to_world`, `intIOR` as `int_ior`.
fn underscored(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut before = ' ';
    for c in name.chars() {
        if c.is_uppercase() && (before.is_lowercase() || before.is_ascii_digit()) {
            out.push('_');
        }
        out.extend(c.to_lowercase());
        before = c;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::MemoryAssets;

    fn read(text: &str, files: &[(&str, &str)], defines: &[(&str, &str)]) -> Result<Document, Fault> {
        let mut assets = MemoryAssets::default();
        for (name, text) in files {
            assets.files.insert((*name).into(), text.as_bytes().to_vec());
        }
        let defines: Vec<_> = defines.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        let mut loader = Loader::new(&assets, "a.xml", &defines);
        loader.read(text.as_bytes().to_vec())?;
        Ok(loader.document)
    }

    #[test]
    fn names_of_old_files_become_those_of_today() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("specular", "specular"),
            ("fovAxis", "fov_axis"),
        ] {
            assert_eq!(underscored(old), new);
        }
    }

    #[test]
    fn included_elements_stand_where_they_are_included() {
        let parts = [
            ("b.xml", "<scene version='3.0.0'><float name='$n' value='2'/></scene>"),
            ("c.xml", "<bsdf id='x'/>"),
        ];
        let text = "<scene version='3.0.0'><default name='n' value='m'/><include filename='b.xml'/><include filename='c.xml'/><ref id='x'/></scene>";
        let found = read(text, &parts, &[]).unwrap();
        let root = found.node(0).unwrap();
        let tags: Vec<&str> = root.children.iter().map(|c| found.node(*c).unwrap().tag.as_str()).collect();
        assert_eq!(tags, ["float", "bsdf", "ref"]);
        let float = found.node(root.children[0]).unwrap();
        assert_eq!((float.attribute("name"), float.place.file), (Some("m"), 1));
        assert_eq!(found.resolve(root.children[2]).unwrap(), root.children[1]);
        let given = read(text, &parts, &[("n", "given"), ("other", "1")]).unwrap();
        assert_eq!(given.node(given.node(0).unwrap().children[0]).unwrap().attribute("name"), Some("given"));
        assert_eq!(given.unused, ["other"]);
        let old = "<scene version='0.6.0'><default name='aB' value='7'/><float name='rrDepth' value='$aB'/></scene>";
        let old = read(old, &[], &[]).unwrap();
        let float = old.node(old.node(0).unwrap().children[0]).unwrap();
        assert_eq!((float.attribute("name"), float.attribute("value")), (Some("rr_depth"), Some("7")));
    }

    #[test]
    fn files_that_include_themselves_are_refused() {
        let itself = "<scene version='3.0.0'><include filename='a.xml'/></scene>";
        assert!(read(itself, &[("a.xml", itself)], &[]).is_err());
        assert!(read("<scene><float value='$x'/></scene>", &[], &[]).is_err());
        assert!(read("<scene></scene><scene></scene>", &[], &[]).is_err());
        assert!(read("<scene><a></b></scene>", &[], &[]).is_err());
        assert!(read(&"<scene>".repeat(100), &[], &[]).is_err());
    }
}
