//! Sixel graphics: bands of six rows, one pass per colour; 216 colours with ordered dither.

use std::io::{self, Write};

use super::{Shot, over_black};

/// Values per channel of the palette.
const LEVELS: u32 = 6;

/// Colours of the palette.
const COLORS: usize = (LEVELS * LEVELS * LEVELS) as usize;

/// Bayer's 4 x 4 thresholds.
const BAYER: [[u32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// Writes the picture.
pub(super) fn write(out: &mut impl Write, shot: &Shot<'_>) -> io::Result<()> {
    let width = shot.width as usize;
    let index = |(i, pixel): (usize, &[u8; 4])| {
        let threshold = BAYER[i / width % 4][i % width % 4] * 2 + 1;
        // A level and the remainder in units of 1 / (32 · 255); the remainder decides with the threshold.
        let level = |v: u8| {
            let scaled = u32::from(v) * (LEVELS - 1);
            scaled / 255 + u32::from(scaled % 255 * 32 > threshold * 255)
        };
        let [r, g, b] = over_black(*pixel).map(level);
        (r * LEVELS * LEVELS + g * LEVELS + b) as u8
    };
    let indices: Vec<u8> = shot.pixels.iter().enumerate().map(index).collect();
    write!(out, "\x1bPq\"1;1;{};{}", shot.width, shot.height)?;
    for color in 0..COLORS as u32 {
        let percent = |level: u32| level * 100 / (LEVELS - 1);
        let (r, g, b) = (color / LEVELS / LEVELS, color / LEVELS % LEVELS, color % LEVELS);
        write!(out, "#{color};2;{};{};{}", percent(r), percent(g), percent(b))?;
    }
    for band in indices.chunks(6 * width) {
        let mut used = [false; COLORS];
        band.iter().for_each(|color| used[usize::from(*color)] = true);
        for color in (0..COLORS).filter(|c| used[*c]) {
            write!(out, "#{color}")?;
            line(out, band, width, color as u8)?;
            // Back to the beginning of the band.
            write!(out, "$")?;
        }
        write!(out, "-")?;
    }
    writeln!(out, "\x1b\\")
}

/// Sixel data of the pixels of one colour in a band of six rows: one character per column, run-length encoded.
fn line(out: &mut impl Write, band: &[u8], width: usize, color: u8) -> io::Result<()> {
    let bits = |x: usize| {
        let rows = band[x..].iter().step_by(width).enumerate();
        rows.fold(0u8, |bits, (y, c)| bits | u8::from(*c == color) << y)
    };
    let mut x = 0;
    while x < width {
        let here = bits(x);
        let mut end = x + 1;
        while end < width && bits(end) == here {
            end += 1;
        }
        let letter = char::from(b'?' + here);
        match end - x {
            run @ 1..=3 => (0..run).try_for_each(|_| write!(out, "{letter}"))?,
            run => write!(out, "!{run}{letter}")?,
        }
        x = end;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_hold_six_rows_of_each_colour() {
        // Seven rows: white over black.
        let pixels: Vec<[u8; 4]> =
            (0..7).flat_map(|y| [if y < 6 { [255; 4] } else { [0, 0, 0, 255] }; 5]).collect();
        let mut out = Vec::new();
        write(&mut out, &Shot { width: 5, height: 7, pixels: &pixels }).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.starts_with("\x1bPq\"1;1;5;7#0;2;0;0;0#1;2;0;0;20"), "{}", &text[..40]);
        // All six bits of five columns, then the lowest bit.
        assert!(text.ends_with("#215!5~$-#0!5@$-\x1b\\\n"), "{text:?}");
    }
}
