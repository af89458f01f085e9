//! A scene's tree of values as TOML that a person can read and change.
//!
//! A table per thing, in the order of the tree; short values on one line; each key explained where it first stands. Numbers are the shortest that read
//! back as the same.

use turner::schema::value::{Data, Entry, Table, Value};

use super::comments::{Comments, heading};
use crate::assets::printable;
use crate::scene::model::quoted;

/// Columns that a line may have.
const COLUMNS: usize = 110;

/// The text of a scene. `source` is what it was made from.
pub(super) fn scene(root: &Value, source: &str) -> String {
    let mut writer = Writer { out: header(source), comments: Comments::default() };
    let Data::Table(top) = &root.data else { return writer.out };
    for Entry { key, value, .. } in &top.entries {
        writer.out += &format!("\n# {}\n", heading(key));
        match &value.data {
            Data::Table(named) if matches!(key.as_str(), "medium" | "texture" | "material") => {
                for (i, entry) in named.entries.iter().enumerate() {
                    writer.gap(i);
                    writer.thing(key, &format!("[{key}.{}]", bare(&entry.key)), &entry.value);
                }
            }
            Data::Table(groups) if key == "group" => {
                for (i, group) in groups.entries.iter().enumerate() {
                    writer.gap(i);
                    writer.group(&bare(&group.key), &group.value);
                }
            }
            Data::Array(things) => {
                for (i, thing) in things.iter().enumerate() {
                    writer.gap(i);
                    writer.thing(key, &format!("[[{key}]]"), thing);
                }
            }
            _ => writer.thing(key, &format!("[{key}]"), value),
        }
    }
    writer.out
}

fn header(source: &str) -> String {
    format!(
        "# Converted from {} by Turner {}.\n#\n\
         # Lengths are in units of the scene, angles in degrees, +y is up. A colour is [red, green, blue] or one number for grey, linear.\n\
         # Keys that are not here have their defaults: `turner help scene` explains all of them.\n",
        printable(source),
        env!("CARGO_PKG_VERSION"),
    )
}

struct Writer {
    out: String,
    comments: Comments,
}

impl Writer {
    /// An empty line between things.
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
                    self.thing("object", &format!("[[group.{name}.object]]"), object);
                }
            }
            _ => self.out += &format!("[group.{name}]\n"),
        }
    }

    /// A table with its head.
    fn thing(&mut self, section: &str, head: &str, value: &Value) {
        self.out += head;
        self.out.push('\n');
        let Data::Table(table) = &value.data else { return };
        let kind = match table.get("type").map(|v| &v.data) {
            Some(Data::String(kind)) => kind.as_str(),
            _ => "",
        };
        for Entry { key, value, .. } in &table.entries {
            let before = self.out.len();
            self.out += &bare(key);
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

/// Writes a value; its line begins at byte `line` of the text. Arrays that do not fit their line take several.
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
        *out += &bare(key);
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
        // No use to go on if it does not fit.
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

/// A key, in quotes where it needs them.
fn bare(key: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !key.is_empty() && key.chars().all(plain) { key.to_owned() } else { quoted(key) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse;
    use turner::schema::value::FileId;

    /// What a text of one key reads back as.
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
