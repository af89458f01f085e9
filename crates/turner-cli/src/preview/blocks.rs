//! Half blocks in 24-bit colour: each character shows two pixels.

use std::io::{self, Write};

use super::{Shot, over_black};

/// Writes the picture.
pub(super) fn write(out: &mut impl Write, shot: &Shot<'_>) -> io::Result<()> {
    let width = shot.width as usize;
    for rows in shot.pixels.chunks(2 * width) {
        let (upper, lower) = rows.split_at(width.min(rows.len()));
        let mut last = None;
        for (x, pixel) in upper.iter().enumerate() {
            let colors = (over_black(*pixel), lower.get(x).map(|p| over_black(*p)));
            if last != Some(colors) {
                let [r, g, b] = colors.0;
                write!(out, "\x1b[38;2;{r};{g};{b}")?;
                match colors.1 {
                    Some([r, g, b]) => write!(out, ";48;2;{r};{g};{b}m")?,
                    None => write!(out, ";49m")?,
                }
                last = Some(colors);
            }
            write!(out, "▀")?;
        }
        writeln!(out, "\x1b[0m")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_written_when_they_change() {
        let pixels = [[1, 2, 3, 255], [1, 2, 3, 255], [4, 5, 6, 255]];
        let mut out = Vec::new();
        write(&mut out, &Shot { width: 1, height: 3, pixels: &pixels }).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "\x1b[38;2;1;2;3;48;2;1;2;3m▀\x1b[0m\n\x1b[38;2;4;5;6;49m▀\x1b[0m\n");
    }
}
