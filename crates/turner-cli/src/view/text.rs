//! The contents as text.

use turner::schema::error::escape;

use super::contents::{Channel, Contents, Part};
use crate::text::{bytes, plural};

/// Longest metadata value that is printed in full, in characters: `turner:camera` has about 1500.
const MOST: usize = 4000;

/// Characters that `escape` keeps.
const PIECE: usize = 80;

/// Size and format, a table of channels for each part, the pixel, the metadata.
pub(super) fn of(c: &Contents) -> String {
    let name = escape(&c.name);
    let mut out = format!("{name}: {}, {}x{}", c.format.name(), c.width, c.height);
    if let [Part { exr: Some(part), .. }] = c.parts.as_slice() {
        out += &format!(", {}", compression(part.compression));
    }
    if c.parts.len() > 1 {
        out += &format!(", {} parts", c.parts.len());
    }
    out += &format!(", {}\n", bytes(c.bytes));
    for part in &c.parts {
        out += &heading(c, part);
        out += &table(&part.channels, c.pixel);
    }
    if !c.metadata.is_empty() {
        out += "metadata\n";
        let width = c.metadata.keys().map(|k| k.chars().count()).max().unwrap_or(0).min(32);
        for (key, value) in &c.metadata {
            let value = short(value.to_string().trim_end_matches('\n'));
            let value = value.join(&format!("\n  {:width$}  ", ""));
            out += &format!("  {:width$}  {value}\n", escape(key));
        }
    }
    out
}

/// The lines of a value, its end left out if it is long.
fn short(value: &str) -> Vec<String> {
    let shown: String = value.chars().take(MOST).collect();
    let mut lines: Vec<String> = shown.split('\n').map(escaped).collect();
    if shown.len() < value.len()
        && let Some(last) = lines.last_mut()
    {
        last.push('…');
    }
    lines
}

/// A line of any length. In pieces, because `escape` shortens its argument.
fn escaped(line: &str) -> String {
    let mut characters = line.chars();
    let mut out = String::new();
    loop {
        let piece: String = characters.by_ref().take(PIECE).collect();
        if piece.is_empty() {
            return out;
        }
        out += &escape(&piece);
    }
}

fn compression(word: &str) -> String {
    if word == "none" { "uncompressed".to_owned() } else { format!("{word} compression") }
}

/// What is special about a part, on lines of their own.
fn heading(c: &Contents, part: &Part) -> String {
    let Some(exr) = &part.exr else { return String::new() };
    let mut out = String::new();
    if c.parts.len() > 1 {
        let name = exr.name.as_deref().map_or("without a name".to_owned(), |n| format!("\"{}\"", escape(n)));
        out += &format!("part {name}, {}\n", compression(exr.compression));
    }
    let [x, y, width, height] = exr.data;
    if exr.data != [0, 0, c.width as i64, c.height as i64] {
        out += &format!("data window: {width}x{height} from column {x}, row {y}\n");
    }
    if let Some((width, height)) = exr.tiles {
        out += &format!("tiles of {width}x{height}\n");
    }
    if exr.deep {
        out += "deep data, flattened where it is shown as a picture\n";
    }
    out
}

fn table(channels: &[Channel], pixel: Option<(u32, u32)>) -> String {
    let mut rows = vec![vec![
        "channel".to_owned(),
        "type".to_owned(),
        "minimum".to_owned(),
        "maximum".to_owned(),
        "mean".to_owned(),
    ]];
    if let Some((x, y)) = pixel {
        rows[0].push(format!("at {x},{y}"));
    }
    for channel in channels {
        let mut row = vec![escape(&channel.name), channel.kind.to_owned()];
        match channel.statistics.range {
            Some((least, most, mean)) => row.extend([least, most, mean].map(number)),
            None => row.extend(["-", "-", "-"].map(str::to_owned)),
        }
        if pixel.is_some() {
            row.push(channel.value.map_or("-".to_owned(), exact));
        }
        let s = &channel.statistics;
        let bad = [(s.nan, "NaN"), (s.infinite, "infinite")];
        let bad: Vec<String> =
            bad.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        if !bad.is_empty() {
            row.push(format!("({})", bad.join(", ")));
        }
        rows.push(row);
    }
    let columns = rows[0].len();
    let width = |i: usize| rows.iter().filter_map(|r| r.get(i)).map(|v| v.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in &rows {
        let mut line = String::new();
        for (i, cell) in row.iter().enumerate() {
            let width = widths.get(i).copied().unwrap_or(0);
            // Words to the left, numbers to the right.
            line +=
                &if i < 2 || i >= columns { format!("  {cell:width$}") } else { format!("  {cell:>width$}") };
        }
        out += &format!("{}\n", line.trim_end());
    }
    if channels.is_empty() {
        out += &format!("  {}\n", plural(0, "channel"));
    }
    out
}

/// Six significant digits.
fn number(v: f64) -> String {
    if v == 0.0 || v.fract() == 0.0 && v.abs() < 1e10 {
        return format!("{v}");
    }
    if !(1e-4..1e6).contains(&v.abs()) {
        return format!("{v:.5e}");
    }
    // The power of ten of the first digit.
    let exponent = format!("{v:e}").split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    let text = format!("{v:.*}", (5 - exponent).clamp(0, 9) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The value as stored: the shortest that is read back as the same f32.
fn exact(v: f64) -> String {
    if f64::from(v as f32) == v || v.is_nan() { (v as f32).to_string() } else { v.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 255.0, 0.123_456_789, 12.345_678, -1_234.567_89, 1e-9, 2.5e8 + 0.5].map(number);
        assert_eq!(shown, ["0", "255", "0.123457", "12.3457", "-1234.57", "1.00000e-9", "2.50000e8"]);
        assert_eq!(exact(f64::from(0.1f32)), "0.1");
        assert_eq!(exact(4_294_967_295.0), "4294967295");
        assert_eq!(exact(f64::NAN), "NaN");
    }
}
