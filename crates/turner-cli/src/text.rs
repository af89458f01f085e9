//! Human-readable text: numbers, wrapping, standard output.

use std::io::Write;

/// Writes to standard output. A closed pipe (`| head`) is ignored.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A count in thousands, millions or billions: `950`, `12.3 k`, `0.31 M`, `4.2 G`.
pub fn count(n: f64) -> String {
    match n {
        n if n < 1e3 => format!("{n:.0}"),
        n if n < 1e5 => format!("{:.1} k", n / 1e3),
        n if n < 1e6 => format!("{:.2} M", n / 1e6),
        n if n < 1e9 => format!("{:.1} M", n / 1e6),
        n => format!("{:.1} G", n / 1e9),
    }
}

/// Bytes in kB, MB or GB.
pub(crate) fn bytes(n: u64) -> String {
    match n as f64 {
        v if v < 1e3 => format!("{n} B"),
        v if v < 1e6 => format!("{:.1} kB", v / 1e3),
        v if v < 1e9 => format!("{:.1} MB", v / 1e6),
        v => format!("{:.2} GB", v / 1e9),
    }
}

/// Seconds with three significant digits; minutes and hours for long times.
pub fn seconds(s: f64) -> String {
    match s {
        s if s < 0.01 => format!("{:.1} ms", s * 1e3),
        s if s < 0.1 => format!("{s:.3} s"),
        s if s < 10.0 => format!("{s:.2} s"),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

/// `1 warning`, `2 warnings`.
pub fn plural(n: u64, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}

/// A word for a shell: in single quotes if it has special characters.
pub(crate) fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-/+=:,@%#".contains(c);
    if !word.is_empty() && !word.starts_with('#') && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Appends `text` to `out`, wrapped at 96 columns, every line indented.
pub(crate) fn wrap(out: &mut String, text: &str, indent: usize) {
    const WIDTH: usize = 96;
    let mut column = 0;
    for word in text.split_whitespace() {
        let len = word.chars().count();
        if column > 0 && column + 1 + len > WIDTH {
            out.push('\n');
            column = 0;
        }
        if column == 0 {
            out.extend(std::iter::repeat_n(' ', indent));
            column = indent;
        } else {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += len;
    }
    out.push('\n');
}

/// Two columns; the first is as wide as its longest entry.
pub(crate) fn columns<'a>(rows: impl Iterator<Item = (&'a str, String)> + Clone) -> String {
    let width = rows.clone().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let mut out = String::new();
    for (name, what) in rows {
        out += &format!("  {name:width$}  ");
        let mut wrapped = String::new();
        wrap(&mut wrapped, &what, width + 4);
        out += wrapped.trim_start();
        if what.is_empty() {
            out.push('\n');
        }
    }
    out
}

/// `bunny.glb: glTF 2.0, 3 nodes, 69451 triangles, 1 material`.
pub(crate) fn import(import: &turner::description::ImportSummary) -> String {
    let counts = import.counts.iter().filter(|(_, n)| *n > 0);
    let counts: String = counts
        .map(|(what, n)| {
            // The names are plural.
            let one = what.strip_suffix('s').unwrap_or(what);
            let one = if *what == "meshes" { "mesh" } else { one };
            if *n == 1 { format!(", 1 {one}") } else { format!(", {n} {what}") }
        })
        .collect();
    format!("{}: {}{counts}", turner::schema::error::escape(&import.file), import.format)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(count(950.0), "950");
        assert_eq!(count(307_200.0), "0.31 M");
        assert_eq!(count(12_345_678.0), "12.3 M");
        assert_eq!(seconds(0.0123), "0.012 s");
        assert_eq!(seconds(3725.0), "62 min 05 s");
        assert_eq!(bytes(17_203_200), "17.2 MB");
        assert_eq!(plural(1, "warning"), "1 warning");
    }

    #[test]
    fn lines_wrap_between_words() {
        let mut out = String::new();
        wrap(&mut out, &"word ".repeat(40), 4);
        assert!(out.lines().all(|l| l.starts_with("    word") && l.len() <= 96), "{out}");
    }
}
