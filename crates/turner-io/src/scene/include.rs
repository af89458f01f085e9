//! `include`: other scene files that are read before the including one.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use turner::schema::value::{Data, Entry, FileId, Span, Table, Value};
use turner::schema::{ErrorCode, Limits, SceneError, wrong_type};

use super::sources::{SourceFile, Sources};
use super::{MAX_TEXT, SceneFormat, model, text};
use crate::assets::{AssetSource, printable};

/// Longest chain of includes, counting the scene itself.
const MAX_CHAIN: usize = 64;
/// Most files of one scene.
const MAX_FILES: usize = 4096;
/// Most bytes of all texts of one scene.
const MAX_TEXTS: u64 = 2 << 30;

/// Reads a scene with everything it includes and returns the merged table.
pub(super) fn read(
    root: SourceFile,
    folder: &str,
    assets: &dyn AssetSource,
    sources: &mut Sources,
    limits: &Limits,
) -> Result<Value, SceneError> {
    let mut seen = HashSet::new();
    // The scene's own URI, as an include of it would resolve.
    let uri = assets.resolve(&root.uri, last_part(&root.uri)).unwrap_or_else(|_| root.uri.clone());
    seen.insert(uri.clone());
    let bytes = root.text.len() as u64;
    let file = sources.add(root);
    Reader { folder, assets, sources, seen, chain: vec![uri], bytes, limits }.file(file)
}

fn last_part(uri: &str) -> &str {
    uri.rsplit(['/', '\\']).next().unwrap_or(uri)
}

struct Reader<'a> {
    /// Prefix of file paths in messages.
    folder: &'a str,
    assets: &'a dyn AssetSource,
    sources: &'a mut Sources,
    /// Files read so far.
    seen: HashSet<String>,
    /// The files from the scene to the one being read: an include of one of them is a cycle.
    chain: Vec<String>,
    bytes: u64,
    limits: &'a Limits,
}

impl Reader<'_> {
    fn file(&mut self, file: FileId) -> Result<Value, SceneError> {
        let (text, name) = self.sources.get(file).map_or(("", ""), |f| (f.text.as_str(), f.name.as_str()));
        self.limits.memory.begin(format!("{name}: reading it"));
        self.limits
            .memory
            .need(text::PER_BYTE.saturating_mul(text.len() as u64), || format!("{name}: reading it"))?;
        let mut value = text::parse(text, file)?;
        let Data::Table(table) = &mut value.data else { return Ok(value) };
        let Some(at) = table.entries.iter().position(|e| e.key == "include") else { return Ok(value) };
        let include = table.entries.remove(at).value;
        let mut merged: Option<Table> = None;
        for (uri, span) in names(&include)? {
            let Some(included) = self.include(uri, span)? else { continue };
            if let Data::Table(included) = included.data {
                match &mut merged {
                    None => merged = Some(included),
                    Some(m) => merge(m, included, &mut Vec::new()),
                }
            }
        }
        if let Some(mut merged) = merged {
            merge(&mut merged, std::mem::take(table), &mut Vec::new());
            *table = merged;
        }
        Ok(value)
    }

    /// The merged table of an included file; `None` if that file was read already.
    fn include(&mut self, uri: &str, span: Span) -> Result<Option<Value>, SceneError> {
        let from = self.chain.last().map_or("", String::as_str);
        let uri = self.assets.resolve(from, uri).map_err(|e| e.to_scene_error().or_at(Some(span)))?;
        if let Some(start) = self.chain.iter().position(|f| *f == uri) {
            let mut chain: Vec<String> = self.chain[start..].iter().map(|f| printable(f)).collect();
            chain.push(printable(&uri));
            if chain.len() > 8 {
                chain.splice(4..chain.len() - 3, ["…".to_owned()]);
            }
            let message = format!("cyclic include: {}", chain.join(" -> "));
            return Err(SceneError::at(ErrorCode::Cycle, span, message).help("remove one of these includes"));
        }
        if self.chain.len() >= MAX_CHAIN {
            let message = format!("includes nest deeper than {MAX_CHAIN} files");
            return Err(
                SceneError::at(ErrorCode::Cycle, span, message).help("include these files from the scene")
            );
        }
        if !self.seen.insert(uri.clone()) {
            return Ok(None);
        }
        let too_large = |message: String| {
            SceneError::at(ErrorCode::TooLarge, span, message)
                .help("join files, or keep large data in mesh files")
        };
        if self.sources.files().len() >= MAX_FILES {
            return Err(too_large(format!("the scene includes more than {MAX_FILES} files")));
        }
        if let Some(format) = SceneFormat::of_path(Path::new(&uri)).filter(|f| f.is_model()) {
            let name = printable(&format!("{}{uri}", self.folder));
            let object = model::object(last_part(&uri), format);
            let text = String::new();
            let file = self.sources.add(SourceFile { name, uri, text, is_argument: false });
            let mut table = Table::default();
            table.push("object", Data::Array(vec![object]));
            let mut value = Value::new(Data::Table(table));
            model::stand_in(&mut value, file);
            return Ok(Some(value));
        }
        let bytes = self.assets.read(&uri, MAX_TEXT).map_err(|e| e.to_scene_error().or_at(Some(span)))?;
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_TEXTS {
            return Err(too_large(format!("the scene's texts have more than {MAX_TEXTS} bytes in all")));
        }
        let name = printable(&format!("{}{uri}", self.folder));
        let text = text::utf8(bytes, &name).map_err(|e| e.or_at(Some(span)))?;
        let file = self.sources.add(SourceFile { name, uri: uri.clone(), text, is_argument: false });
        self.chain.push(uri);
        let value = self.file(file)?;
        self.chain.pop();
        Ok(Some(value))
    }
}

/// The names in `include = …` with their spans.
fn names<'a>(value: &'a Value) -> Result<Vec<(&'a str, Span)>, SceneError> {
    let expected = "the name of a scene file, or a list of names";
    let items = match &value.data {
        Data::Array(items) => items.as_slice(),
        _ => std::slice::from_ref(value),
    };
    let name = |item: &'a Value| match &item.data {
        Data::String(name) => Ok((name.as_str(), item.span)),
        _ => Err(wrong_type(item, expected).help("write include = [\"parts.toml\"]")),
    };
    items.iter().map(name).collect()
}

/// Merges `over` into `base`: tables key by key; lists of objects, lights and views are appended; any other
/// value is replaced. `path` is the key path of these tables.
fn merge(base: &mut Table, over: Table, path: &mut Vec<String>) {
    // With many keys, look them up by name: a scene may have a hundred thousand materials.
    let many = over.entries.len() > 8;
    let entries = base.entries.iter().enumerate().filter(|_| many);
    let index: HashMap<String, usize> = entries.map(|(i, e)| (e.key.clone(), i)).collect();
    for Entry { key, key_span, value } in over.entries {
        let at = if many { index.get(&key).copied() } else { base.entries.iter().position(|e| e.key == key) };
        let Some(old) = at.and_then(|i| base.entries.get_mut(i)) else {
            base.entries.push(Entry { key, key_span, value });
            continue;
        };
        path.push(key);
        match (&mut old.value.data, value) {
            (Data::Table(old_table), Value { data: Data::Table(table), span }) => {
                merge(old_table, table, path);
                (old.key_span, old.value.span) = (key_span, span);
            }
            (Data::Array(old_items), Value { data: Data::Array(items), .. }) if is_appended(path) => {
                old_items.extend(items);
            }
            (_, value) => (old.key_span, old.value) = (key_span, value),
        }
        path.pop();
    }
}

fn is_appended(path: &[String]) -> bool {
    match path {
        [list] => matches!(list.as_str(), "object" | "light" | "view" | "animation"),
        [group, _, object] => group == "group" && object == "object",
        _ => false,
    }
}
