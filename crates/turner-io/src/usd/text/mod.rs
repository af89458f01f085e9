//! Text layers (`.usda`).
//!
//! A recursive descent over the grammar of "USDA File Format" (openusd.org), which skips what has no effect on a
//! picture. Nesting is bounded.

mod lexer;
mod types;
mod values;

use std::collections::BTreeMap;

use lexer::Lexer;
use types::Type;

use super::paths::{child, property, resolve};
use super::value::{Fields, ListEdit, Offset, Read, Value};

/// Deepest nesting of prims, dictionaries and brackets.
const MAX_DEPTH: u32 = 128;

/// The specs of a layer by path.
pub(super) type Specs = BTreeMap<String, Fields>;

/// Reads a text layer.
pub(super) fn read(text: &str) -> Read<Specs> {
    let mut parser = Parser { lexer: Lexer::new(text), specs: Specs::new() };
    parser.layer()?;
    Ok(parser.specs)
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    specs: Specs,
}

/// The names of what a prim contains.
#[derive(Default)]
struct Contents {
    prims: Vec<String>,
    properties: Vec<String>,
    variant_sets: Vec<String>,
}

impl Contents {
    fn into_fields(self, fields: &mut Fields) {
        for (name, list) in [
            ("primChildren", self.prims),
            ("properties", self.properties),
            ("variantSetChildren", self.variant_sets),
        ] {
            if !list.is_empty() {
                fields.push((name.to_owned(), Value::Texts(list)));
            }
        }
    }
}

/// How a list is edited.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Edit {
    Explicit,
    Prepend,
    Add,
    Append,
    Delete,
    /// The order of items only, which is ignored.
    Reorder,
}

fn edit<T>(items: Vec<T>, edit: Edit) -> ListEdit<T> {
    let mut list = ListEdit::default();
    match edit {
        Edit::Explicit => list.explicit = Some(items),
        Edit::Prepend => list.prepended = items,
        Edit::Add => list.added = items,
        Edit::Append => list.appended = items,
        Edit::Delete => list.deleted = items,
        Edit::Reorder => {}
    }
    list
}

impl Parser<'_> {
    fn layer(&mut self) -> Read<()> {
        let mut fields = Fields::new();
        if self.lexer.take(b'(') {
            self.metadata("/", &mut fields)?;
        }
        let mut contents = Contents::default();
        while !self.lexer.is_over() {
            if self.lexer.take_word("reorder") {
                self.lexer.word();
                self.lexer.expect(b'=')?;
                self.any(0)?;
                continue;
            }
            self.prim("/", &mut contents.prims, 0)?;
        }
        contents.into_fields(&mut fields);
        self.specs.insert("/".to_owned(), fields);
        Ok(())
    }

    /// `def Type "name" (metadata) { … }`.
    fn prim(&mut self, parent: &str, siblings: &mut Vec<String>, depth: u32) -> Read<()> {
        if depth > MAX_DEPTH {
            return Err(self.lexer.broken(format!("prims nested more than {MAX_DEPTH} deep")));
        }
        let specifier = self.lexer.peek_word();
        if !matches!(specifier, "def" | "over" | "class") {
            return Err(self.lexer.unexpected("\"def\", \"over\" or \"class\""));
        }
        self.lexer.word();
        let mut fields = vec![("specifier".to_owned(), Value::Text(specifier.to_owned()))];
        let kind = self.lexer.word();
        if !kind.is_empty() {
            fields.push(("typeName".to_owned(), Value::Text(kind.to_owned())));
        }
        let name = self.lexer.string()?;
        if name.is_empty() || name.contains(['/', '.', '{', '}', '[', ']', '<', '>']) {
            return Err(self.lexer.broken(format!("{name:?} is not the name of a prim")));
        }
        let path = child(parent, &name);
        if self.lexer.take(b'(') {
            self.metadata(&path, &mut fields)?;
        }
        self.body(&path, &mut fields, depth)?;
        // A prim that is written twice has the last opinions.
        if !self.specs.contains_key(&path) {
            siblings.push(name);
        }
        self.specs.insert(path, fields);
        Ok(())
    }

    /// `{ … }` of a prim or a variant.
    fn body(&mut self, path: &str, fields: &mut Fields, depth: u32) -> Read<()> {
        self.lexer.expect(b'{')?;
        let mut contents = Contents::default();
        while !self.lexer.take(b'}') {
            match self.lexer.peek_word() {
                "def" | "over" | "class" => self.prim(path, &mut contents.prims, depth + 1)?,
                "variantSet" => {
                    self.lexer.word();
                    self.variant_set(path, &mut contents.variant_sets, depth)?;
                }
                "reorder" => {
                    self.lexer.word();
                    self.lexer.word();
                    self.lexer.expect(b'=')?;
                    self.any(0)?;
                }
                "" => return Err(self.lexer.unexpected("a prim, an attribute or \"}\"")),
                _ => self.property(path, &mut contents.properties)?,
            }
        }
        contents.into_fields(fields);
        Ok(())
    }

    /// `variantSet "name" = { "variant" { … } … }`.
    fn variant_set(&mut self, path: &str, sets: &mut Vec<String>, depth: u32) -> Read<()> {
        if depth >= MAX_DEPTH {
            return Err(self.lexer.broken(format!("prims nested more than {MAX_DEPTH} deep")));
        }
        let set = self.lexer.string()?;
        self.lexer.expect(b'=')?;
        self.lexer.expect(b'{')?;
        let mut variants = Vec::new();
        while !self.lexer.take(b'}') {
            let name = self.lexer.string()?;
            let inner = format!("{path}{{{set}={name}}}");
            let mut fields = Fields::new();
            if self.lexer.take(b'(') {
                self.metadata(&inner, &mut fields)?;
            }
            self.body(&inner, &mut fields, depth + 1)?;
            self.specs.insert(inner, fields);
            variants.push(name);
        }
        let fields = vec![("variantChildren".to_owned(), Value::Texts(variants))];
        self.specs.insert(format!("{path}{{{set}=}}"), fields);
        sets.push(set);
        Ok(())
    }

    fn list_edit(&mut self) -> Edit {
        let edit = match self.lexer.peek_word() {
            "prepend" => Edit::Prepend,
            "add" => Edit::Add,
            "append" => Edit::Append,
            "delete" => Edit::Delete,
            "reorder" => Edit::Reorder,
            _ => return Edit::Explicit,
        };
        self.lexer.word();
        edit
    }

    /// An attribute or a relationship.
    fn property(&mut self, prim: &str, names: &mut Vec<String>) -> Read<()> {
        let edit = self.list_edit();
        while matches!(self.lexer.peek_word(), "custom" | "uniform" | "varying" | "config") {
            self.lexer.word();
        }
        let kind = self.lexer.word();
        if kind.is_empty() {
            return Err(self.lexer.unexpected("the type of an attribute"));
        }
        let is_array = self.lexer.take(b'[');
        if is_array {
            self.lexer.expect(b']')?;
        }
        let name = self.lexer.word();
        if name.is_empty() {
            return Err(self.lexer.unexpected("the name of an attribute"));
        }
        let path = property(prim, name);
        let known = self.specs.remove(&path);
        if known.is_none() {
            names.push(name.to_owned());
        }
        let mut fields = known.unwrap_or_default();
        if kind == "rel" {
            if self.lexer.take(b'=') {
                let paths = self.paths(prim)?;
                set_list(&mut fields, "targetPaths", self::edit(paths, edit));
            }
        } else {
            self.attribute(prim, &mut fields, Type::of(kind, is_array), edit)?;
            set(&mut fields, "typeName", Value::Text(kind.to_owned()));
        }
        if self.lexer.take(b'(') {
            self.metadata(prim, &mut fields)?;
        }
        self.specs.insert(path, fields);
        Ok(())
    }

    /// What follows the name of an attribute.
    fn attribute(&mut self, prim: &str, fields: &mut Fields, kind: Type, edit: Edit) -> Read<()> {
        if !self.lexer.take(b'.') {
            if self.lexer.take(b'=') {
                let value = self.value(kind)?;
                set(fields, "default", value);
            }
            return Ok(());
        }
        let suffix = self.lexer.word();
        self.lexer.expect(b'=')?;
        match suffix {
            "connect" => {
                let paths = self.paths(prim)?;
                set_list(fields, "connectionPaths", self::edit(paths, edit));
            }
            "timeSamples" => {
                let samples = self.samples(kind)?;
                set(fields, "timeSamples", Value::Samples(samples));
            }
            "spline" => {
                self.braces(0)?;
                set(fields, "spline", Value::Other);
            }
            other => return Err(self.lexer.broken(format!("\".{other}\" of an attribute is unknown"))),
        }
        Ok(())
    }

    /// One path, several in brackets, or `None`.
    fn paths(&mut self, prim: &str) -> Read<Vec<String>> {
        if self.lexer.take_word("None") {
            return Ok(Vec::new());
        }
        if self.lexer.peek() == b'<' {
            return Ok(vec![resolve(prim, &self.lexer.path()?)]);
        }
        self.lexer.expect(b'[')?;
        let mut paths = Vec::new();
        while !self.lexer.take(b']') {
            paths.push(resolve(prim, &self.lexer.path()?));
            self.lexer.take(b',');
        }
        Ok(paths)
    }

    /// `( … )` after a prim, a property or the header; the bracket has been taken.
    fn metadata(&mut self, owner: &str, fields: &mut Fields) -> Read<()> {
        while !self.lexer.take(b')') {
            if matches!(self.lexer.peek(), b'"' | b'\'') {
                self.lexer.string()?;
                continue;
            }
            let edit = self.list_edit();
            let name = self.lexer.word();
            if name.is_empty() {
                return Err(self.lexer.unexpected("metadata or \")\""));
            }
            self.lexer.expect(b'=')?;
            match name {
                "references" | "payload" => {
                    let items = self.references(owner)?;
                    let old = fields.iter_mut().find(|(n, _)| n == name);
                    let list = self::edit(items, edit);
                    match old {
                        Some((_, Value::References(old))) => merge(old, list),
                        _ => set(fields, name, Value::References(list)),
                    }
                }
                "inherits" | "specializes" => {
                    let paths = self.paths(owner)?;
                    let key = if name == "inherits" { "inheritPaths" } else { "specializes" };
                    set_list(fields, key, self::edit(paths, edit));
                }
                "variantSets" | "apiSchemas" => {
                    let names = self.texts()?;
                    let key = if name == "variantSets" { "variantSetNames" } else { name };
                    set_list(fields, key, self::edit(names, edit));
                }
                "variants" => {
                    let value = self.dictionary(0)?;
                    set(fields, "variantSelection", Value::Dictionary(value));
                }
                "subLayers" => self.sublayers(fields)?,
                _ => {
                    let value = self.any(0)?;
                    set(fields, name, value);
                }
            }
        }
        Ok(())
    }

    fn sublayers(&mut self, fields: &mut Fields) -> Read<()> {
        self.lexer.expect(b'[')?;
        let (mut files, mut offsets) = (Vec::new(), Vec::new());
        while !self.lexer.take(b']') {
            files.push(self.lexer.asset()?);
            offsets.push(self.offset()?);
            self.lexer.take(b',');
        }
        set(fields, "subLayers", Value::Texts(files));
        set(fields, "subLayerOffsets", Value::Offsets(offsets));
        Ok(())
    }

    /// `(offset = 1; scale = 2)`, or nothing.
    fn offset(&mut self) -> Read<Offset> {
        let mut offset = Offset::default();
        if self.lexer.take(b'(') {
            let mut fields = Fields::new();
            self.metadata("/", &mut fields)?;
            let read = |name, or| super::value::field(&fields, name).and_then(Value::real).unwrap_or(or);
            offset = Offset { offset: read("offset", 0.0), scale: read("scale", 1.0) };
        }
        Ok(offset)
    }
}

/// Sets a field.
fn set(fields: &mut Fields, name: &str, value: Value) {
    match fields.iter_mut().find(|(n, _)| n == name) {
        Some((_, old)) => *old = value,
        None => fields.push((name.to_owned(), value)),
    }
}

/// Adds the edits of a list to those of the field: a list may be prepended to and deleted from.
fn set_list(fields: &mut Fields, name: &str, list: ListEdit<String>) {
    match fields.iter_mut().find(|(n, _)| n == name) {
        Some((_, Value::List(old))) => merge(old, list),
        _ => set(fields, name, Value::List(list)),
    }
}

fn merge<T>(old: &mut ListEdit<T>, new: ListEdit<T>) {
    old.explicit = new.explicit.or(old.explicit.take());
    old.prepended.extend(new.prepended);
    old.added.extend(new.added);
    old.appended.extend(new.appended);
    old.deleted.extend(new.deleted);
}
