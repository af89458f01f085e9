//! The codebooks of an ETC1S file: colours with an intensity table, and selectors (KTX 2.0, appendix BasisLZ/ETC1S).

use super::super::fault::{Fault, Outcome, list};
use super::bits::Bits;
use super::huffman::Huffman;

/// The four colours of a block, from the darkest to the brightest.
pub(super) type Palette = [[u8; 3]; 4];

/// What ETC1 adds to the base colour, by intensity table and selector.
const MODIFIERS: [[i16; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

/// The colours of a 5-bit base colour and an intensity table.
fn palette(base: [u8; 3], table: usize) -> Palette {
    let expanded = base.map(|v| i16::from(v << 3 | v >> 2));
    MODIFIERS[table & 7].map(|add| expanded.map(|v| (v + add).clamp(0, 255) as u8))
}

/// Reads `count` palettes. Colours and tables are stored as differences from the entry before, modulo 32 and 8; the
/// Huffman table of a difference depends on the value before it.
pub(super) fn read_palettes(bytes: &[u8], count: usize) -> Outcome<Vec<Palette>> {
    let mut bits = Bits::new(bytes);
    let mut table = || Huffman::read(&mut bits);
    let color_tables = [table()?, table()?, table()?];
    let intensity_table = table()?;
    let is_grey = bits.take(1) == 1;
    let mut palettes = list::<Palette>(count)?;
    let (mut color, mut intensity) = ([16u8; 3], 0);
    for entry in &mut palettes {
        intensity = (intensity + intensity_table.decode(&mut bits)?) & 7;
        for channel in color.iter_mut().take(if is_grey { 1 } else { 3 }) {
            let by_value = match *channel {
                0..=9 => 0,
                10..=21 => 1,
                _ => 2,
            };
            let difference = color_tables[by_value].decode(&mut bits)?;
            *channel = (u32::from(*channel) + difference) as u8 & 31;
        }
        if is_grey {
            color = [color[0]; 3];
        }
        *entry = palette(color, intensity as usize);
    }
    bits.check("endpoints")?;
    Ok(palettes)
}

/// Reads `count` selector entries: two bits for each of the 16 pixels, row by row, the first pixel lowest. Entries
/// after the first may be stored as differences (exclusive or) from the entry before.
pub(super) fn read_selectors(bytes: &[u8], count: usize) -> Outcome<Vec<u32>> {
    let mut bits = Bits::new(bytes);
    if bits.take(2) != 0 {
        return Err(Fault::damaged("the selectors do not begin with two zero bits"));
    }
    let is_raw = bits.take(1) == 1;
    let table = if is_raw { None } else { Some(Huffman::read(&mut bits)?) };
    let mut selectors = list::<u32>(count)?;
    let mut previous = [0u8; 4];
    for (i, entry) in selectors.iter_mut().enumerate() {
        for row in &mut previous {
            *row = match &table {
                Some(table) if i > 0 => table.decode(&mut bits)? as u8 ^ *row,
                _ => bits.take(8) as u8,
            };
        }
        *entry = u32::from_le_bytes(previous);
    }
    bits.check("selectors")?;
    Ok(selectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the Khronos Data Format Specification, ETC1: base (231, 8, 16), table 2, the brightest.
    #[test]
    fn colors_are_expanded_and_clamped() {
        assert_eq!(palette([28, 1, 2], 2)[3], [255, 37, 45]);
        assert_eq!(palette([28, 4, 3], 0)[2], [233, 35, 26]);
        assert_eq!(palette([0, 31, 16], 7)[0], [0, 72, 0]);
    }
}
