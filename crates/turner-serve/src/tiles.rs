//! Pictures as messages: the tiles that differ from the picture before.
//!
//! ```text
//!  0  u8   1: a picture                     24  u16  x ┐
//!  1  u8   flags: 1 RGBA, 2 packed          26  u16  y │ of each tile,
//!  2  u16  0                                28  u16  w │ in pixels
//!  4  u32  number of the picture            30  u16  h ┘
//!  8  u32  width                            …   the data of the event `frame`, JSON in UTF-8
//! 12  u32  height                           …   the pixels of all tiles, row by row: RGB, or RGBA
//! 16  u32  number of tiles
//! 20  u32  bytes of the JSON
//! ```
//!
//! Numbers are little-endian. Packed pixels are differences, modulo 256, from the pixel to the left in the tile (the
//! first of a row: from zero), compressed in the zlib format. Where a picture has another size than the one before, the
//! tiles cover all of it.

use miniz_oxide::deflate::compress_to_vec_zlib;

/// Pixels of a side of a tile.
pub(crate) const TILE: u32 = 64;

/// Effort of the compression, of 10: more takes far longer and gains little.
const EFFORT: u8 = 1;

/// A picture that is shown.
#[derive(Debug)]
pub(crate) struct Shown {
    pub(crate) number: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// The data of the event.
    pub(crate) detail: String,
    pub(crate) pixels: Vec<[u8; 4]>,
    pub(crate) has_alpha: bool,
}

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Tile {
    x: u32,
    y: u32,
    w: u32,
    h: u32,
}

impl Shown {
    /// The pixels of a row of a tile.
    fn row(&self, tile: Tile, row: u32) -> &[[u8; 4]] {
        let start = (tile.y + row) as usize * self.width as usize + tile.x as usize;
        self.pixels.get(start..start + tile.w as usize).unwrap_or_default()
    }

    fn tiles(&self) -> impl Iterator<Item = Tile> {
        let (width, height) = (self.width, self.height);
        let starts = |end: u32| (0..end).step_by(TILE as usize);
        starts(height).flat_map(move |y| {
            starts(width).map(move |x| Tile { x, y, w: TILE.min(width - x), h: TILE.min(height - y) })
        })
    }
}

/// The message for a viewer who has the picture `base`.
pub(crate) fn message(base: Option<&Shown>, shown: &Shown, packed: bool) -> Vec<u8> {
    // A change of coverage changes pixels that are not sent as RGB.
    let base = base.filter(|base| {
        (base.width, base.height, base.has_alpha) == (shown.width, shown.height, shown.has_alpha)
    });
    let differs = |tile: &Tile| {
        base.is_none_or(|base| (0..tile.h).any(|row| base.row(*tile, row) != shown.row(*tile, row)))
    };
    let tiles: Vec<Tile> = shown.tiles().filter(differs).collect();
    let flags = u8::from(shown.has_alpha) | u8::from(packed) << 1;
    let channels = if shown.has_alpha { 4 } else { 3 };
    let mut out = vec![1, flags, 0, 0];
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    for value in [shown.number, shown.width, shown.height, count(tiles.len()), count(shown.detail.len())] {
        out.extend(value.to_le_bytes());
    }
    for tile in &tiles {
        for value in [tile.x, tile.y, tile.w, tile.h] {
            // Pictures have at most 65,536 columns and rows, so tiles begin below.
            out.extend((value as u16).to_le_bytes());
        }
    }
    out.extend(shown.detail.as_bytes());
    let size = tiles.iter().map(|tile| (tile.w * tile.h) as usize * channels).sum();
    let mut pixels = Vec::with_capacity(size);
    for (tile, row) in tiles.iter().flat_map(|tile| (0..tile.h).map(move |row| (*tile, row))) {
        let row = shown.row(tile, row);
        match (packed, shown.has_alpha) {
            (false, true) => pixels.extend_from_slice(row.as_flattened()),
            (false, false) => row.iter().for_each(|p| pixels.extend_from_slice(&p[..3])),
            (true, _) => differences(row, channels, &mut pixels),
        }
    }
    if packed {
        out.extend(compress_to_vec_zlib(&pixels, EFFORT))
    } else {
        out.append(&mut pixels)
    }
    out
}

/// Appends the differences of a row's pixels.
fn differences(row: &[[u8; 4]], channels: usize, out: &mut Vec<u8>) {
    let mut last = [0; 4];
    for pixel in row {
        let each = pixel.iter().zip(&last).take(channels);
        out.extend(each.map(|(own, last)| own.wrapping_sub(*last)));
        last = *pixel;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(number: u32, width: u32, height: u32) -> Shown {
        let pixels = (0..width * height).map(|i| [(i % 251) as u8, (i / 7) as u8, 9, 255]).collect();
        Shown { number, width, height, detail: "{}".into(), pixels, has_alpha: false }
    }

    fn tiles(message: &[u8]) -> u32 {
        u32::from_le_bytes(message[16..20].try_into().unwrap())
    }

    #[test]
    fn only_changed_tiles_are_sent() {
        let (a, mut b) = (shown(1, 150, 70), shown(2, 150, 70));
        assert_eq!(tiles(&message(None, &a, false)), 6);
        assert_eq!(message(None, &a, false).len(), 24 + 6 * 8 + 2 + 150 * 70 * 3);
        assert_eq!(tiles(&message(Some(&a), &b, false)), 0);
        b.pixels[149][2] = 10;
        let one = message(Some(&a), &b, false);
        assert_eq!(one.len(), 24 + 8 + 2 + 22 * 64 * 3);
        assert_eq!(one[24..32], [128, 0, 0, 0, 22, 0, 64, 0]);
        assert_eq!(tiles(&message(Some(&a), &shown(3, 151, 70), false)), 6);
        b.has_alpha = true;
        assert_eq!(tiles(&message(Some(&a), &b, false)), 6);
    }

    #[test]
    fn packed_pixels_are_the_same() {
        let a = shown(1, 100, 3);
        let [plain, packed] = [false, true].map(|packed| message(None, &a, packed));
        let start = 24 + 2 * 8 + 2;
        let mut pixels = miniz_oxide::inflate::decompress_to_vec_zlib(&packed[start..]).unwrap();
        // Tiles of 64 and 36 columns with three rows each.
        let rows = [64, 64, 64, 36, 36, 36].map(|columns| columns * 3);
        let mut at = 0;
        for length in rows {
            for i in at + 3..at + length {
                pixels[i] = pixels[i].wrapping_add(pixels[i - 3]);
            }
            at += length;
        }
        assert_eq!(pixels, plain[start..]);
        assert_eq!(packed[1], 2);
    }
}
