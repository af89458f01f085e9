//! Writes a scene's value tree as TOML for people to read and edit.
//!
//! One table per object, light and so on, in the order of the tree. Short values stay on one line. Each key is
//! explained at its first occurrence. Numbers have the fewest digits that read back as the same value.

use turner::schema::value::{Data, Entry, Table, Value};

use super::comments::{Comments, heading};
use crate::assets::printable;
use crate::scene::model::quoted;

/// Longest line.
const COLUMNS: usize = 110;

/// The text of a scene. `source` is the name of its source.
pub(crate) fn scene(root: &Value, source: &str) -> String {
    let mut writer = Writer { out: header(source), comments: Comments::default() };
    let Data::Table(top) = &root.data else { return writer.out };
    for Entry { key, value, .. } in &top.entries {
        writer.out += &format!("\n# {}\n", heading(key));
        match &value.data {
            Data::Table(named) if matches!(key.as_str(), "medium" | "texture" | "material") => {
                for (i, entry) in named.entries.iter().enumerate() {
                    writer.gap(i);
                    writer.table(key, &format!("[{key}.{}]", key_text(&entry.key)), &entry.value);
                }
            }
            Data::Table(groups) if key == "group" => {
                for (i, group) in groups.entries.iter().enumerate() {
                    writer.gap(i);
                    writer.group(&key_text(&group.key), &group.value);
                }
            }
            Data::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    writer.gap(i);
                    writer.table(key, &format!("[[{key}]]"), item);
                }
            }
            _ => writer.table(key, &format!("[{key}]"), value),
        }
    }
    writer.out
}

/// The entries of a table, one `key = value` per line, without comments. Empty for any other value.
pub(crate) fn keys(value: &Value) -> String {
    let mut out = String::new();
    let Data::Table(table) = &value.data else { return out };
    for Entry { key, value, .. } in &table.entries {
        let line = out.len();
        out += &key_text(key);
        out += " = ";
        put(&mut out, &value.data, line);
        out.push('\n');
    }
    out
}

/// The text of one value.
pub(crate) fn value(data: &Data) -> String {
    let mut out = String::new();
    put(&mut out, data, 0);
    out
}

fn header(source: &str) -> String {
    format!(
        "# Converted from {} by Turner {}.\n#\n\
         # Lengths are in scene units, angles in degrees; +y is up. A colour is [red, green, blue], or one number for grey, in linear values.\n\
         # Omitted keys have their defaults: `turner help scene` explains all keys.\n",
        printable(source),
        env!("CARGO_PKG_VERSION"),
    )
}

struct Writer {
    out: String,
    comments: Comments,
}

impl Writer {
    /// A blank line between tables.
    fn gap(&mut self, i: usize) {
        if i > 0 {
            self.out.push('\n');
        }
    }

    fn group(&mut self, name: &str, group: &Value) {
        let Data::Table(table) = &group.data else { return };
        match table.get("object").map(|v| &v.data) {
            Some(Data::Array(objects)) => {
                for (i, object) in objects.iter().enumerate() {
                    self.gap(i);
                    self.table("object", &format!("[[group.{name}.object]]"), object);
                }
            }
            _ => self.out += &format!("[group.{name}]\n"),
        }
    }

    /// Writes a table with its header.
    fn table(&mut self, section: &str, head: &str, value: &Value) {
        self.out += head;
        self.out.push('\n');
        let Data::Table(table) = &value.data else { return };
        let kind = match table.get("type").map(|v| &v.data) {
            Some(Data::String(kind)) => kind.as_str(),
            _ => "",
        };
        for Entry { key, value, .. } in &table.entries {
            let before = self.out.len();
            self.out += &key_text(key);
            self.out += " = ";
            put(&mut self.out, &value.data, before);
            let Some(comment) = self.comments.first(section, kind, key) else {
                self.out.push('\n');
                continue;
            };
            let line = self.out.get(before..).unwrap_or_default();
            if line.contains('\n') || line.len() + comment.len() > COLUMNS {
                self.out.insert_str(before, &format!("# {comment}\n"));
                self.out.push('\n');
            } else {
                self.out += &format!("  # {comment}\n");
            }
        }
    }
}

/// Writes a value. Its line begins at byte `line` of the text; arrays that do not fit in the line are broken.
fn put(out: &mut String, data: &Data, line: usize) {
    match data {
        Data::Bool(b) => *out += if *b { "true" } else { "false" },
        Data::Integer(i) => *out += &i.to_string(),
        Data::Number(v) => *out += &number(*v),
        Data::String(s) => *out += &quoted(s),
        Data::Table(table) => put_table(out, table, line),
        Data::Array(items) => put_array(out, items, line),
    }
}

fn put_table(out: &mut String, table: &Table, line: usize) {
    if table.entries.is_empty() {
        *out += "{}";
        return;
    }
    *out += "{ ";
    for (i, Entry { key, value, .. }) in table.entries.iter().enumerate() {
        *out += if i > 0 { ", " } else { "" };
        *out += &key_text(key);
        *out += " = ";
        put(out, &value.data, line);
    }
    *out += " }";
}

fn put_array(out: &mut String, items: &[Value], line: usize) {
    let start = out.len();
    out.push('[');
    for (i, item) in items.iter().enumerate() {
        *out += if i > 0 { ", " } else { "" };
        put(out, &item.data, line);
        // Stop early if it does not fit.
        if out.len() - line > COLUMNS {
            break;
        }
    }
    out.push(']');
    if out.len() - line <= COLUMNS {
        return;
    }
    out.truncate(start);
    *out += "[\n";
    let mut begin = out.len();
    for item in items {
        let mut one = String::new();
        put(&mut one, &item.data, 0);
        let nested = matches!(item.data, Data::Array(_)) && one.len() > COLUMNS / 4;
        if out.len() > begin && (nested || out.len() - begin + one.len() > COLUMNS - 10) {
            out.push('\n');
            begin = out.len();
        }
        *out += if out.len() == begin { "  " } else { " " };
        *out += &one;
        out.push(',');
    }
    *out += "\n]";
}

/// The shortest text that reads back as this number; 0 for -0.
fn number(v: f64) -> String {
    let size = v.abs();
    if v.is_nan() {
        "nan".into()
    } else if v.is_infinite() {
        if v > 0.0 { "inf".into() } else { "-inf".into() }
    } else if v == 0.0 {
        // Without the sign of -0, which means nothing in a scene.
        "0".into()
    } else if size != 0.0 && !(1e-5..1e16).contains(&size) {
        format!("{v:e}")
    } else {
        v.to_string()
    }
}

/// A key, quoted if necessary.
pub(crate) fn key_text(key: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !key.is_empty() && key.chars().all(plain) { key.to_owned() } else { quoted(key) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse;
    use turner::schema::value::FileId;

    /// Writes a value and reads it back.
    fn back(data: &Data) -> Data {
        let mut text = String::from("a = ");
        put(&mut text, data, 0);
        let Data::Table(table) = parse(&text, FileId(0)).unwrap_or_else(|e| panic!("{e}: {text}")).data
        else {
            panic!("{text}")
        };
        table.get("a").unwrap().data.clone()
    }

    #[test]
    fn numbers_read_back_as_they_were() {
        let mut bits = 1_u64;
        let special =
            [0.0, -0.0, 1.0, -3.0, 1e15, 1e16, 123_456_789_012_345_680.0, f64::MAX, 5e-324, 1e-5, 9.9e-6];
        let random = (0..20_000).map(|_| {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from_bits(bits)
        });
        for v in special.into_iter().chain(random.filter(|v| v.is_finite())) {
            let read = match back(&Data::Number(v)) {
                Data::Integer(i) => i as f64,
                Data::Number(v) => v,
                other => panic!("{other:?}"),
            };
            // Adding 0 turns -0 into 0.
            assert_eq!(read.to_bits(), (v + 0.0).to_bits(), "{v}");
        }
    }

    #[test]
    fn texts_and_names_of_any_kind_read_back_as_they_were() {
        for text in ["", "a", "\"\\", "a\u{0}\u{7f}\u{85}\n\t\r", "ü 椅子 \u{202e}", "'''", "[x]\n[y]"] {
            assert_eq!(back(&Data::String(text.into())), Data::String(text.into()));
            let mut table = Table::default();
            table.push(text, Data::Bool(true));
            let Data::Table(read) = back(&Data::Table(table)) else { panic!() };
            assert_eq!(read.entries[0].key, text);
        }
    }

    #[test]
    fn long_lists_take_several_lines() {
        let row = |n: usize| Value::new(Data::Array(vec![Value::new(Data::Number(0.123_456_789)); n]));
        for rows in [vec![row(3); 4], vec![row(4); 100], vec![row(40); 2]] {
            let data = Data::Array(rows);
            let mut text = String::new();
            put(&mut text, &data, 0);
            assert!(text.lines().all(|line| line.len() < 2 * COLUMNS), "{text}");
            let Data::Array(read) = back(&data) else { panic!() };
            let Data::Array(expected) = &data else { panic!() };
            assert_eq!(read.len(), expected.len());
        }
    }
}
