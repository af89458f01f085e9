//! The differences of two trees as changes of the text that one of them comes from.

use std::collections::{BTreeMap, HashMap};

use turner::schema::old_names;
use turner::schema::value::{Data, FileId, Span, Table, Value};

use super::splice::Splices;
use super::tree::{IN_PLACE, place_of};
use crate::convert::text::{key_text, keys, value as value_text};
use crate::scene::parse;

/// The new text: `text` with the differences of `before` and `after`.
///
/// `film` is the film of `before` as the new integrator's defaults would have it, if the integrator changed.
///
/// Errors: why the text cannot express them by changes of single places.
pub(super) fn spliced(
    text: &str,
    before: &Value,
    after: &Value,
    film: Option<Value>,
) -> Result<String, String> {
    let raw = parse(text, FileId(0)).map_err(|e| e.to_string())?;
    let empty = Table::default();
    let as_table = |value: &Value| match &value.data {
        Data::Table(table) => table.clone(),
        _ => empty.clone(),
    };
    let (before, after, root) = (as_table(before), as_table(after), as_table(&raw));
    let mut tables = HashMap::new();
    index(&raw, &mut tables);
    let mut diff =
        Diff { tables, root: &root, after: &after, out: Splices::new(text), tail: String::new(), text };
    for section in ["camera", "film", "integrator", "background", "studio"] {
        let old = before.get(section);
        let film = film.as_ref().filter(|_| section == "film").map(|film| diff.only_written(film));
        diff.section(section, film.as_ref().or(old), after.get(section))?;
    }
    for kind in ["texture", "material", "medium"] {
        diff.named(kind, before.get(kind), after.get(kind))?;
    }
    diff.groups(before.get("group"), after.get("group"))?;
    for list in ["view", "light", "object", "animation"] {
        diff.list(list, items(before.get(list)), items(after.get(list)), root.get(list))?;
    }
    let Diff { mut out, tail, .. } = diff;
    if !tail.is_empty() {
        let gap = if text.trim_start_matches('\u{feff}').trim().is_empty() { "" } else { "\n" };
        out.insert(text.len(), format!("{gap}{}", tail.trim_start_matches('\n')));
    }
    out.apply()
}

/// All tables of the text by the position where they begin; the innermost, if a header such as `[a.b]` begins several.
fn index<'a>(value: &'a Value, into: &mut HashMap<u32, &'a Value>) {
    match &value.data {
        Data::Table(table) => {
            for entry in &table.entries {
                if matches!(entry.value.data, Data::Table(_)) {
                    into.insert(entry.value.span.start, &entry.value);
                }
                index(&entry.value, into);
            }
        }
        Data::Array(items) => {
            for item in items {
                if matches!(item.data, Data::Table(_)) {
                    into.insert(item.span.start, item);
                }
                index(item, into);
            }
        }
        _ => {}
    }
}

fn items(section: Option<&Value>) -> &[Value] {
    match section.map(|value| &value.data) {
        Some(Data::Array(items)) => items,
        _ => &[],
    }
}

fn table(value: Option<&Value>) -> Option<&Table> {
    match value.map(|value| &value.data) {
        Some(Data::Table(table)) => Some(table),
        _ => None,
    }
}

/// Whether two values are equal, apart from their positions.
pub(super) fn same(a: &Data, b: &Data) -> bool {
    match (a, b) {
        (Data::Number(a), Data::Number(b)) => a.to_bits() == b.to_bits(),
        (Data::Array(a), Data::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(&a.data, &b.data))
        }
        (Data::Table(a), Data::Table(b)) => {
            let has = |e: &turner::schema::value::Entry| {
                b.get(&e.key).is_some_and(|v| same(&e.value.data, &v.data))
            };
            a.entries.len() == b.entries.len() && a.entries.iter().all(has)
        }
        _ => a == b,
    }
}

/// The reason that parts of included files give.
pub(super) const INCLUDED: &str = "a part that changed comes from an included file";

struct Diff<'a> {
    text: &'a str,
    tables: HashMap<u32, &'a Value>,
    root: &'a Table,
    after: &'a Table,
    out: Splices<'a>,
    /// New sections at the end of the text.
    tail: String,
}

impl<'a> Diff<'a> {
    /// The table of the text at a position.
    fn raw(&self, span: Span) -> Result<&'a Value, String> {
        if span.file != FileId(0) {
            return Err(INCLUDED.to_owned());
        }
        self.tables.get(&span.start).copied().ok_or_else(|| "a part has no table in the text".to_owned())
    }

    /// The film without the keys that the text does not have.
    fn only_written(&self, film: &Value) -> Value {
        let written = table(self.root.get("film"));
        let mut film = film.clone();
        if let Data::Table(table) = &mut film.data {
            table.entries.retain(|entry| written.is_some_and(|own| own.get(&entry.key).is_some()));
        }
        film
    }

    /// A section without items.
    fn section(&mut self, key: &str, before: Option<&Value>, after: Option<&Value>) -> Result<(), String> {
        let empty = Table::default();
        let keeps_header = !matches!(key, "camera" | "studio");
        let entry = self
            .root
            .entries
            .iter()
            .find(|entry| entry.key == key || key == "studio" && entry.key == "stage");
        match (before, after, entry) {
            (Some(a), Some(b), _) if same(&a.data, &b.data) => Ok(()),
            (None, None, _) => Ok(()),
            (_, None, Some(entry)) if !keeps_header => self.out.cut_entry(entry),
            (_, _, Some(entry)) => {
                self.update(&entry.value, table(before).unwrap_or(&empty), table(after).unwrap_or(&empty))
            }
            (_, Some(after), None) => {
                self.tail += &self.block(&format!("[{key}]"), after);
                Ok(())
            }
            (Some(_), None, None) => Err(INCLUDED.to_owned()),
        }
    }

    /// `[kind.NAME]` sections, and parts of this kind that are written in place.
    fn named(&mut self, kind: &str, before: Option<&Value>, after: Option<&Value>) -> Result<(), String> {
        let empty = Table::default();
        let (before, after) = (table(before).unwrap_or(&empty), table(after).unwrap_or(&empty));
        let by_name: HashMap<&str, &Value> =
            before.entries.iter().map(|e| (e.key.as_str(), &e.value)).collect();
        let by_span: HashMap<Span, &str> = before
            .entries
            .iter()
            .filter(|e| e.value.span.file == FileId(0))
            .map(|e| (e.value.span, e.key.as_str()))
            .collect();
        let mut seen: Vec<&str> = Vec::new();
        let mut new = String::new();
        for entry in &after.entries {
            let old = match by_name.get_key_value(entry.key.as_str()) {
                Some((name, _)) => Some(*name),
                None => by_span.get(&entry.value.span).copied().filter(|name| {
                    // A part that was written in place and has a name now gets a section of its own.
                    after.get(name).is_none() && name.starts_with(IN_PLACE) == entry.key.starts_with(IN_PLACE)
                }),
            };
            let Some(old) = old else {
                if !entry.key.starts_with(IN_PLACE) {
                    new += &self.block(&format!("[{kind}.{}]", key_text(&entry.key)), &entry.value);
                }
                continue;
            };
            seen.push(old);
            let value = by_name[old];
            if old != entry.key {
                self.rename(kind, old, &entry.key)?;
            }
            if let (false, Data::Table(a), Data::Table(b)) =
                (same(&value.data, &entry.value.data), &value.data, &entry.value.data)
            {
                let span = match place_of(old) {
                    Some((file, start)) => Span { file, start, end: start },
                    None => value.span,
                };
                self.update(self.raw(span)?, a, b)?;
            }
        }
        let seen: std::collections::HashSet<&str> = seen.into_iter().collect();
        for entry in before.entries.iter().filter(|e| !e.key.starts_with(IN_PLACE)) {
            if !seen.contains(entry.key.as_str()) {
                let raw =
                    table(self.root.get(kind)).and_then(|t| t.entries.iter().find(|e| e.key == entry.key));
                self.out.cut_entry(raw.ok_or(INCLUDED)?)?;
            }
        }
        let last = table(self.root.get(kind))
            .and_then(|t| t.entries.iter().max_by_key(|e| self.out.block_end(&e.value)));
        self.append(new, last.map(|entry| self.out.block_end(&entry.value)));
        Ok(())
    }

    /// Changes the name of a section.
    fn rename(&mut self, kind: &str, old: &str, new: &str) -> Result<(), String> {
        let section = table(self.root.get(kind));
        let entry = section.and_then(|t| t.entries.iter().find(|e| e.key == old)).ok_or(INCLUDED)?;
        if new.starts_with(IN_PLACE) {
            return Err("a section lost its name".to_owned());
        }
        let key = entry.key_span.start as usize..entry.key_span.end as usize;
        self.out.replace(key, key_text(new));
        Ok(())
    }

    fn groups(&mut self, before: Option<&Value>, after: Option<&Value>) -> Result<(), String> {
        let empty = Table::default();
        let (before, after) = (table(before).unwrap_or(&empty), table(after).unwrap_or(&empty));
        let raw = table(self.root.get("group"));
        for entry in &after.entries {
            let objects = |value: Option<&'_ Value>| -> Vec<Value> {
                items(table(value).and_then(|t| t.get("object"))).to_vec()
            };
            let own = raw.and_then(|t| table(t.get(&entry.key))).and_then(|t| t.get("object"));
            let head = format!("group.{}.object", key_text(&entry.key));
            let new = objects(Some(&entry.value));
            if before.get(&entry.key).is_none() && new.is_empty() {
                self.tail += &format!("\n[group.{}]\n", key_text(&entry.key));
            }
            self.list(&head, &objects(before.get(&entry.key)), &new, own)?;
        }
        for entry in before.entries.iter().filter(|e| after.get(&e.key).is_none()) {
            let own = raw.and_then(|t| t.entries.iter().find(|e| e.key == entry.key)).ok_or(INCLUDED)?;
            let objects = table(Some(&own.value)).and_then(|t| t.get("object"));
            match objects {
                Some(list)
                    if self.out.is_spread(list)
                        && !self.text[own.value.span.start as usize..].starts_with("[group") =>
                {
                    items(Some(list)).iter().for_each(|item| self.out.cut_block(item));
                }
                _ => self.out.cut_entry(own)?,
            }
        }
        Ok(())
    }

    /// The items of a list, headed `[[head]]`.
    fn list(
        &mut self,
        head: &str,
        before: &[Value],
        after: &[Value],
        raw: Option<&'a Value>,
    ) -> Result<(), String> {
        let mut old: BTreeMap<u32, &Value> = BTreeMap::new();
        let mut included = 0;
        for item in before {
            match item.span.file {
                FileId(0) => _ = old.insert(item.span.start, item),
                _ => included += 1,
            }
        }
        let mut new = String::new();
        for item in after {
            if item.span.file != FileId(0) && item.span.file != Span::NONE.file {
                let same = before.iter().any(|own| own.span == item.span && same(&own.data, &item.data));
                included -= 1;
                if !same {
                    return Err(INCLUDED.to_owned());
                }
                continue;
            }
            let own = Some(item.span).filter(|s| s.file == FileId(0)).and_then(|s| old.remove(&s.start));
            match (own, own.map(|own| &own.data), &item.data) {
                (Some(own), Some(Data::Table(a)), Data::Table(b)) => {
                    if !same(&own.data, &item.data) {
                        self.update(self.raw(own.span)?, a, b)?;
                    }
                }
                _ => new += &self.block(&format!("[[{head}]]"), item),
            }
        }
        if included != 0 {
            return Err(INCLUDED.to_owned());
        }
        let is_inline = raw.is_some_and(|list| !items(Some(list)).is_empty() && !self.out.is_spread(list));
        if let (true, Some(raw)) = (is_inline, raw) {
            if !old.is_empty() || !new.is_empty() {
                self.rebuild_list(raw, before, after)?;
            }
            return Ok(());
        }
        for item in old.into_values() {
            let raw = self.raw(item.span)?;
            self.out.cut_block(raw);
        }
        let last = raw.and_then(|list| items(Some(list)).last());
        self.append(new, last.map(|item| self.out.block_end(item)));
        Ok(())
    }

    /// Writes a list in brackets again, one item on a line, with the text of the items that did not change.
    fn rebuild_list(&mut self, raw: &Value, before: &[Value], after: &[Value]) -> Result<(), String> {
        let range = raw.span.start as usize..raw.span.end as usize;
        self.out.forget(&range);
        let mut used = std::collections::HashSet::new();
        let mut lines = String::new();
        for item in after {
            let is_old = item.span.file == FileId(0) && used.insert(item.span.start);
            let old =
                before.iter().find(|old| is_old && old.span == item.span && same(&old.data, &item.data));
            let own = old.map(|old| self.raw(old.span)).transpose()?.map(|own| own.span);
            lines += "  ";
            match own {
                Some(span) => lines += &self.text[span.start as usize..span.end as usize],
                None => lines += &self.text_of(&item.data),
            }
            lines += ",\n";
        }
        self.out.replace(range, format!("[\n{lines}]"));
        Ok(())
    }

    /// Adds blocks after a position, or at the end of the text.
    fn append(&mut self, blocks: String, at: Option<usize>) {
        match at {
            _ if blocks.is_empty() => {}
            Some(at) => self.out.insert(at, blocks),
            None => self.tail += &blocks,
        }
    }

    /// A table with its header, after a blank line.
    fn block(&self, head: &str, value: &Value) -> String {
        format!("\n{head}\n{}", keys(&Value::new(self.resolved(&value.data))))
    }

    /// The value with the parts that are written in place.
    fn resolved(&self, data: &Data) -> Data {
        match data {
            Data::String(name) if name.starts_with(IN_PLACE) => {
                let section = match name.as_bytes().get(1) {
                    Some(b't') => "texture",
                    Some(b'm') => "material",
                    _ => "medium",
                };
                let part = table(self.after.get(section)).and_then(|t| t.get(name));
                part.map_or_else(|| data.clone(), |part| self.resolved(&part.data))
            }
            Data::Array(items) => {
                Data::Array(items.iter().map(|v| Value::new(self.resolved(&v.data))).collect())
            }
            Data::Table(table) => {
                let mut out = Table::default();
                table.entries.iter().for_each(|e| out.push(&e.key, self.resolved(&e.value.data)));
                Data::Table(out)
            }
            other => other.clone(),
        }
    }

    fn text_of(&self, data: &Data) -> String {
        value_text(&self.resolved(data))
    }

    /// Changes the keys of one table of the text.
    fn update(&mut self, raw: &'a Value, before: &Table, after: &Table) -> Result<(), String> {
        let Data::Table(own) = &raw.data else { return Err("a part is no table in the text".to_owned()) };
        let inline = !self.out.is_spread(raw);
        let mut removed: Vec<&str> = Vec::new();
        let find = |key: &str| {
            let by = |name: &str| own.entries.iter().find(|e| e.key == name);
            by(key).or_else(|| by(old_names::of_key(key)?))
        };
        // The `medium` of an object stands for its material.
        let medium = |key: &str| find("medium").filter(|_| key == "material");
        for entry in &before.entries {
            if after.get(&entry.key).is_none() {
                let own = find(&entry.key).or_else(|| medium(&entry.key));
                let own = own.ok_or_else(|| format!("`{}` is not in the text", entry.key))?;
                removed.push(&own.key);
            }
        }
        let mut added = Vec::new();
        for entry in &after.entries {
            let old = before.get(&entry.key);
            if old.is_some_and(|old| same(&old.data, &entry.value.data)) {
                continue;
            }
            match find(&entry.key) {
                None => {
                    removed.extend(medium(&entry.key).map(|own| own.key.as_str()));
                    added.push(format!("{} = {}", key_text(&entry.key), self.text_of(&entry.value.data)));
                }
                Some(own) if self.out.is_spread(&own.value) => {
                    match (old.map(|v| &v.data), &entry.value.data) {
                        (Some(Data::Table(a)), Data::Table(b)) => self.update(&own.value, a, b)?,
                        _ => return Err(format!("`{}` is a table of its own", entry.key)),
                    }
                }
                Some(own) => {
                    let span = own.value.span.start as usize..own.value.span.end as usize;
                    let new = self.text_of(&entry.value.data);
                    self.out.replace(span, new);
                }
            }
        }
        if inline && !(removed.is_empty() && added.is_empty()) {
            return self.rebuild(raw, own, &removed, before, after);
        }
        for entry in own.entries.iter().filter(|e| removed.contains(&e.key.as_str())) {
            self.out.cut_entry(entry)?;
        }
        if !added.is_empty() {
            self.add_keys(raw, own, &added)?;
        }
        Ok(())
    }

    /// Adds lines after the last key of a table.
    fn add_keys(&mut self, raw: &Value, own: &Table, added: &[String]) -> Result<(), String> {
        let last = own.entries.iter().rfind(|e| !self.out.is_spread(&e.value));
        let (at, prefix) = match last {
            Some(entry) => {
                let start = self.out.line_start(entry.key_span.start as usize);
                let prefix = &self.text[start..entry.key_span.start as usize];
                (self.out.line_end(entry.value.span.end as usize), prefix)
            }
            None if self.text[raw.span.start as usize..].starts_with('[') => {
                (self.out.line_end(raw.span.end as usize), "")
            }
            None => return Err("a table has no header".to_owned()),
        };
        if prefix.contains(['{', '[', ',', '=']) {
            return Err("a key shares its line with others".to_owned());
        }
        let lines: String = added.iter().map(|line| format!("{prefix}{line}\n")).collect();
        self.out.insert(at, lines);
        Ok(())
    }

    /// Writes a table in braces again, with the text of the entries that did not change.
    fn rebuild(
        &mut self,
        raw: &Value,
        own: &Table,
        removed: &[&str],
        before: &Table,
        after: &Table,
    ) -> Result<(), String> {
        let range = raw.span.start as usize..raw.span.end as usize;
        self.out.forget(&range);
        let mut parts = Vec::new();
        let mut seen = Vec::new();
        for entry in own.entries.iter().filter(|e| !removed.contains(&e.key.as_str())) {
            let is_it = |key: &str| key == entry.key || old_names::of_key(key) == Some(entry.key.as_str());
            let new = after.entries.iter().find(|e| is_it(&e.key));
            let old = new.and_then(|new| before.get(&new.key));
            seen.extend(new.map(|new| new.key.as_str()));
            let key = &self.text[entry.key_span.start as usize..entry.key_span.end as usize];
            match new {
                Some(new) if !old.is_some_and(|old| same(&old.data, &new.value.data)) => {
                    parts.push(format!("{key} = {}", self.text_of(&new.value.data)));
                }
                _ if self.out.is_spread(&entry.value) => return Err("a dotted key in braces".to_owned()),
                _ => {
                    let value = &self.text[entry.value.span.start as usize..entry.value.span.end as usize];
                    parts.push(format!("{key} = {value}"));
                }
            }
        }
        for entry in after.entries.iter().filter(|e| !seen.contains(&e.key.as_str())) {
            if before.get(&entry.key).is_none_or(|old| !same(&old.data, &entry.value.data)) {
                parts.push(format!("{} = {}", key_text(&entry.key), self.text_of(&entry.value.data)));
            }
        }
        self.out.replace(range, format!("{{ {} }}", parts.join(", ")));
        Ok(())
    }
}
