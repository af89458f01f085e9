//! ETC1S with BasisLZ: blocks of 4 x 4 pixels that refer to two codebooks, one of four-colour palettes and one of
//! selectors, which choose a colour for each pixel. The codebooks serve all images of the file. A slice holds the
//! indices of one image; the alpha channel, or the second of two independent channels, is a slice of its own.
//!
//! The bitstream is that of the KTX 2.0 specification, appendices BasisLZ Global Data and BasisLZ/ETC1S Bitstream; the
//! colours are those of the Khronos Data Format Specification, ETC1.

mod bits;
mod codebooks;
mod huffman;
mod slice;

use super::fault::{Fault, Outcome};
use codebooks::{Palette, read_palettes, read_selectors};

/// Bytes of the header and of an image's description.
const HEADER: usize = 20;
/// The flag of an image that refers to the one before it.
const P_FRAME: u32 = 2;

/// The global data of a file, in its parts.
struct Global<'a> {
    endpoint_count: usize,
    selector_count: usize,
    /// The five numbers that describe level 0, layer 0, face 0: flags, offset and length of two slices.
    image: [u32; 5],
    endpoints: &'a [u8],
    selectors: &'a [u8],
    tables: &'a [u8],
}

/// Five little-endian numbers.
fn numbers(bytes: &[u8; HEADER]) -> [u32; 5] {
    let mut out = [0; 5];
    for (value, four) in out.iter_mut().zip(bytes.as_chunks().0) {
        *value = u32::from_le_bytes(*four);
    }
    out
}

impl<'a> Global<'a> {
    /// Splits the global data of a file with `images` images.
    fn read(bytes: &'a [u8], images: u64) -> Outcome<Global<'a>> {
        let truncated = || Fault::damaged("the BasisLZ global data is truncated");
        let (header, rest) = bytes.split_first_chunk::<HEADER>().ok_or_else(truncated)?;
        let [counts, endpoint_bytes, selector_bytes, table_bytes, _] = numbers(header);
        let image = numbers(rest.first_chunk().ok_or_else(truncated)?);
        let described = images.checked_mul(HEADER as u64).and_then(|n| usize::try_from(n).ok());
        let (_, rest) = described.and_then(|n| rest.split_at_checked(n)).ok_or_else(truncated)?;
        let (endpoints, rest) = rest.split_at_checked(endpoint_bytes as usize).ok_or_else(truncated)?;
        let (selectors, rest) = rest.split_at_checked(selector_bytes as usize).ok_or_else(truncated)?;
        let tables = rest.get(..table_bytes as usize).ok_or_else(truncated)?;
        let (endpoint_count, selector_count) = ((counts & 0xffff) as usize, (counts >> 16) as usize);
        if endpoint_count == 0 || selector_count == 0 {
            return Err(Fault::damaged("a BasisLZ codebook is empty"));
        }
        Ok(Global { endpoint_count, selector_count, image, endpoints, selectors, tables })
    }
}

/// Decodes level 0 to RGBA, row 0 first. `out` has `4 * width * height` bytes. `level` holds the slices of the level
/// and `global` the codebooks; the file has `images` images. Without a second slice alpha is 255.
pub(super) fn decode(
    global: &[u8],
    images: u64,
    level: &[u8],
    has_second_slice: bool,
    width: usize,
    out: &mut [u8],
) -> Outcome<()> {
    let global = Global::read(global, images)?;
    let [flags, first_at, first_len, second_at, second_len] = global.image;
    if flags & P_FRAME != 0 {
        return Err(Fault::unsupported("video", "a still image"));
    }
    let slice = |at: u32, len: u32| {
        let end = at.checked_add(len).map(|end| end as usize);
        let bytes = end.and_then(|end| level.get(at as usize..end)).filter(|bytes| !bytes.is_empty());
        bytes.ok_or_else(|| {
            let problem = format!("a slice of {len} bytes at {at} in a level of {} bytes", level.len());
            Fault::damaged(problem)
        })
    };
    let palettes = read_palettes(global.endpoints, global.endpoint_count)?;
    let selectors = read_selectors(global.selectors, global.selector_count)?;
    let tables = slice::Tables::read(global.tables)?;
    let stride = 4 * width;
    let blocks = (width.div_ceil(4), (out.len() / stride.max(1)).div_ceil(4));
    let counts = (palettes.len(), selectors.len());
    slice::decode(slice(first_at, first_len)?, &tables, counts, blocks, |x, y, endpoint, selector| {
        let (palette, selectors) = chosen(&palettes, &selectors, endpoint, selector);
        let colors = palette.map(|[r, g, b]| [r, g, b, 255]);
        paint(out, stride, x, y, selectors, |pixel, s| pixel.copy_from_slice(&colors[s]));
    })?;
    if !has_second_slice {
        return Ok(());
    }
    slice::decode(slice(second_at, second_len)?, &tables, counts, blocks, |x, y, endpoint, selector| {
        let (palette, selectors) = chosen(&palettes, &selectors, endpoint, selector);
        paint(out, stride, x, y, selectors, |pixel, s| {
            if let Some(alpha) = pixel.last_mut() {
                // All three are the same; of other files the reference transcoder takes green.
                *alpha = palette[s][1];
            }
        });
    })
}

/// The entries of both codebooks.
fn chosen(palettes: &[Palette], selectors: &[u32], endpoint: usize, selector: usize) -> (Palette, u32) {
    let palette = palettes.get(endpoint).copied().unwrap_or_default();
    (palette, selectors.get(selector).copied().unwrap_or_default())
}

/// Calls `set` for each pixel of a block that lies in the image, with the pixel and its selector.
fn paint(
    out: &mut [u8],
    stride: usize,
    column: usize,
    row: usize,
    selectors: u32,
    mut set: impl FnMut(&mut [u8], usize),
) {
    let rows = out.chunks_exact_mut(stride).skip(4 * row).take(4);
    for (y, line) in rows.enumerate() {
        let pixels = line.chunks_exact_mut(4).skip(4 * column).take(4);
        for (x, pixel) in pixels.enumerate() {
            set(pixel, (selectors >> (8 * y + 2 * x) & 3) as usize);
        }
    }
}
