//! Scales a picture down.

use super::Shot;

/// A picture that owns its pixels.
pub(super) struct Scaled {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<[u8; 4]>,
}

/// The picture with at most `columns` x `rows` pixels, each the mean of those that it covers. Small pictures keep their
/// size.
pub(super) fn to_fit(shot: &Shot<'_>, columns: u32, rows: u32) -> Scaled {
    let (w, h) = (u64::from(shot.width.max(1)), u64::from(shot.height.max(1)));
    let (columns, rows) = (u64::from(columns.max(1)), u64::from(rows.max(1)));
    let (width, height) = if w <= columns && h <= rows {
        (w, h)
    } else if w * rows >= h * columns {
        (columns, (h * columns / w).max(1))
    } else {
        ((w * rows / h).max(1), rows)
    };
    let mut pixels = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            pixels.push(mean(shot, x * w / width..(x + 1) * w / width, y * h / height..(y + 1) * h / height));
        }
    }
    Scaled { width: width as u32, height: height as u32, pixels }
}

/// The mean of the pixels in a rectangle, colours weighted by alpha.
fn mean(shot: &Shot<'_>, columns: std::ops::Range<u64>, rows: std::ops::Range<u64>) -> [u8; 4] {
    let (mut sum, mut alpha, mut count) = ([0u64; 3], 0u64, 0u64);
    for y in rows {
        let row = y * u64::from(shot.width);
        let row = shot.pixels.get((row + columns.start) as usize..(row + columns.end) as usize);
        for [r, g, b, a] in row.unwrap_or_default() {
            let a = u64::from(*a);
            for (s, v) in sum.iter_mut().zip([r, g, b]) {
                *s += u64::from(*v) * a;
            }
            alpha += a;
            count += 1;
        }
    }
    if alpha == 0 {
        return [0; 4];
    }
    let [r, g, b] = sum.map(|s| ((s + alpha / 2) / alpha) as u8);
    [r, g, b, ((alpha + count / 2) / count) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_the_aspect() {
        let pixels = vec![[9, 9, 9, 255]; 640 * 480];
        let size = |width, height, columns, rows| {
            let scaled = to_fit(&Shot { width, height, pixels: &pixels }, columns, rows);
            assert_eq!(scaled.pixels.len(), (scaled.width * scaled.height) as usize);
            assert!(scaled.pixels.iter().all(|p| *p == [9, 9, 9, 255]));
            (scaled.width, scaled.height)
        };
        assert_eq!(size(640, 480, 80, 200), (80, 60));
        assert_eq!(size(640, 480, 800, 48), (64, 48));
        assert_eq!(size(24, 16, 80, 40), (24, 16));
        assert_eq!(size(1, 480, 80, 40), (1, 40));
        assert_eq!(size(640, 1, 80, 40), (80, 1));
    }

    #[test]
    fn transparent_pixels_lend_no_colour() {
        let pixels = [[200, 0, 0, 255], [0, 0, 0, 0]];
        let scaled = to_fit(&Shot { width: 2, height: 1, pixels: &pixels }, 1, 1);
        assert_eq!(scaled.pixels, [[200, 0, 0, 128]]);
    }
}
