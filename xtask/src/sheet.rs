//! Places several images side by side.

use std::path::Path;

use turner::image::{Image, Pixels};
use turner_io::image::{
    DecodeLimits, Display, ImageFormat, OutputFile, OutputImage, Transfer, decode, encode,
};

/// Pixels between images.
const GAP: u32 = 6;
const PAPER: [u8; 4] = [255, 255, 255, 255];

/// Places images of the same size in rows of `columns`, with each pixel enlarged to `zoom` by `zoom`, and writes one
/// file.
pub(crate) fn write(parts: &[impl AsRef<Path>], columns: u32, zoom: u32, to: &Path) -> Result<(), String> {
    let images = parts.iter().map(|path| read(path.as_ref())).collect::<Result<Vec<_>, String>>()?;
    let (w, h) = images.first().map(|i| (i.width, i.height)).ok_or("no parts")?;

    if images.iter().any(|i| (i.width, i.height) != (w, h)) {
        return Err(format!("{}: the parts differ in size", to.display()));
    }
    let (w, h) = (w * zoom, h * zoom);
    let rows = (images.len() as u32).div_ceil(columns);
    let (width, height) = (columns * (w + GAP) - GAP, rows * (h + GAP) - GAP);
    let mut sheet = vec![PAPER; width as usize * height as usize];
    for (i, image) in (0..).zip(&images) {
        let (left, top) = (i % columns * (w + GAP), i / columns * (h + GAP));
        for y in 0..h {
            for x in 0..w {
                sheet[((top + y) * width + left + x) as usize] = pixel(image, x / zoom, y / zoom);
            }
        }
    }
    let image = OutputImage {
        width,
        height,
        alpha: false,
        display: Some(Display::U8(&sheet)),
        transfer: Transfer::Unstated,
        metadata: &Default::default(),
        threads: 1,
        ..OutputImage::default()
    };
    let format = ImageFormat::of_path(to).map_err(|e| e.to_string())?;
    let bytes = encode(&image, format).map_err(|e| e.to_string())?;
    OutputFile::create(to).and_then(|file| file.commit(&bytes)).map_err(|e| e.to_string())
}

fn read(path: &Path) -> Result<Image, String> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|e| format!("{name}: {e}"))?;
    decode(&bytes, &name, &DecodeLimits::default()).map_err(|e| e.to_string())
}

/// A pixel over a white background.
fn pixel(image: &Image, x: u32, y: u32) -> [u8; 4] {
    let n = usize::from(image.channels);
    let at = (y as usize * image.width as usize + x as usize) * n;
    let value = |c: usize| match &image.pixels {
        Pixels::U8(v) => u32::from(v[at + c]),
        Pixels::U16(v) => u32::from(v[at + c] >> 8),
        Pixels::F32(v) => (v[at + c].clamp(0.0, 1.0) * 255.0) as u32,
    };
    let alpha = if n == 2 || n == 4 { value(n - 1) } else { 255 };
    let over = |v: u32| ((v * alpha + 255 * (255 - alpha)) / 255) as u8;
    let [r, g, b] = if n < 3 { [0, 0, 0] } else { [0, 1, 2] };
    [over(value(r)), over(value(g)), over(value(b)), 255]
}
