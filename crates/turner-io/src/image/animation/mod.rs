//! Animations: frames of equal size in one file that browsers play, again and again.
//!
//! ```text
//! 8-bit RGBA frames ── encode ──┬─ GIF       256 colours a frame, dithered
//!                               ├─ APNG      all colours, lossless
//!                               └─ WebP      all colours, lossless, smaller
//! ```
//!
//! The bytes depend on the frames alone.

mod apng;
mod gif;
mod webp;

use super::ImageError;

/// A format of animations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AnimationFormat {
    /// GIF 89a.
    Gif,
    /// Animated PNG.
    Apng,
    /// Animated WebP.
    WebP,
}

impl AnimationFormat {
    /// All formats.
    pub const ALL: [AnimationFormat; 3] =
        [AnimationFormat::Gif, AnimationFormat::Apng, AnimationFormat::WebP];

    /// The format's name.
    pub fn name(self) -> &'static str {
        match self {
            AnimationFormat::Gif => "GIF",
            AnimationFormat::Apng => "animated PNG",
            AnimationFormat::WebP => "animated WebP",
        }
    }

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            AnimationFormat::Gif => "gif",
            AnimationFormat::Apng => "apng",
            AnimationFormat::WebP => "webp",
        }
    }

    /// The largest side of a picture in pixels.
    fn most(self) -> u32 {
        match self {
            AnimationFormat::Gif => u32::from(u16::MAX),
            AnimationFormat::Apng => i32::MAX as u32,
            AnimationFormat::WebP => 16384,
        }
    }

    /// The format of an extension in lower case.
    pub fn of_extension(extension: &str) -> Option<AnimationFormat> {
        AnimationFormat::ALL.into_iter().find(|format| format.extension() == extension)
    }
}

/// A frame: display values with straight alpha, row 0 at the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and alpha of each pixel.
    pub pixels: Vec<[u8; 4]>,
}

impl Frame {
    fn has_alpha(&self) -> bool {
        self.pixels.iter().any(|p| p[3] != 255)
    }
}

/// What all frames have in common.
#[derive(Clone, Copy, Debug)]
struct Shape {
    width: u32,
    height: u32,
    frames: u32,
    /// Frames per second.
    rate: f64,
}

impl Shape {
    /// When a frame begins, in units of which a second has `units`. A frame lasts until the next one begins, so that
    /// rounding does not add up.
    fn duration(&self, frame: u32, units: f64) -> u32 {
        let at = |frame: u32| (f64::from(frame) * units / self.rate).round();
        (at(frame + 1) - at(frame)).clamp(1.0, 65535.0) as u32
    }
}

/// Encodes an animation of `count` frames that repeats forever. `rate` is in frames per second, from 0.01 to 1000;
/// `frame` gives the frame of an index, and is called once for each, in order.
///
/// GIF measures time in hundredths of a second, so more than 50 frames per second play slower in most viewers.
///
/// Errors: no frames, frames of different sizes or too large for the format, and those of `frame`.
pub fn encode(
    format: AnimationFormat,
    count: u32,
    rate: f64,
    mut frame: impl FnMut(u32) -> Result<Frame, ImageError>,
) -> Result<Vec<u8>, ImageError> {
    let refuse = |problem: String| Err(ImageError::Encode { format: format.name(), problem });
    if count == 0 || !(0.01..=1000.0).contains(&rate) {
        return refuse(format!(
            "{count} frames at {rate} frames per second; expected 1 or more at 0.01 to 1000"
        ));
    }
    let first = frame(0)?;
    let (width, height) = (first.width, first.height);
    if width == 0 || height == 0 || width.max(height) > format.most() {
        return refuse(format!("{width} x {height} pixels; expected 1 to {} on a side", format.most()));
    }
    let shape = Shape { width, height, frames: count, rate };
    let mut first = Some(first);
    let mut next = |i: u32| {
        let found = match first.take() {
            Some(found) => found,
            None => frame(i)?,
        };
        let is_whole = found.pixels.len() as u64 == u64::from(width) * u64::from(height);
        if (found.width, found.height) == (width, height) && is_whole {
            return Ok(found);
        }
        let problem = format!(
            "frame {} has {} x {} pixels; expected {width} x {height} as in the first",
            i + 1,
            found.width,
            found.height
        );
        Err(ImageError::Encode { format: format.name(), problem })
    };
    match format {
        AnimationFormat::Gif => gif::encode(&shape, &mut next),
        AnimationFormat::Apng => apng::encode(&shape, &mut next),
        AnimationFormat::WebP => webp::encode(&shape, &mut next),
    }
}

/// Frames in order.
type Frames<'a> = dyn FnMut(u32) -> Result<Frame, ImageError> + 'a;

fn failed(format: AnimationFormat, error: impl std::fmt::Display) -> ImageError {
    ImageError::Encode { format: format.name(), problem: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(i: u32) -> Frame {
        let pixel = |p: u32| {
            let (x, y) = (p % 37, p / 37);
            let inside = (x as i32 - 18).pow(2) + (y as i32 - 11).pow(2) < 90;
            [(7 * x + 20 * i) as u8, (9 * y) as u8, (3 * (x + y)) as u8, if inside { 255 } else { 0 }]
        };
        Frame { width: 37, height: 23, pixels: (0..37 * 23).map(pixel).collect() }
    }

    fn opaque(i: u32) -> Frame {
        let mut frame = example(i);
        frame.pixels.iter_mut().for_each(|p| p[3] = 255);
        frame
    }

    /// Frames and durations in milliseconds, by the decoders of the image crate.
    fn decoded(format: AnimationFormat, bytes: &[u8]) -> Vec<(Vec<[u8; 4]>, f64)> {
        use image::AnimationDecoder;
        let cursor = std::io::Cursor::new(bytes);
        let frames = match format {
            AnimationFormat::Gif => return gif::tests::decoded(bytes),
            AnimationFormat::Apng => return apng::tests::decoded(bytes),
            AnimationFormat::WebP => image::codecs::webp::WebPDecoder::new(cursor).unwrap().into_frames(),
        };
        let frame = |frame: image::ImageResult<image::Frame>| {
            let frame = frame.unwrap();
            let (above, below) = frame.delay().numer_denom_ms();
            let pixels = frame.buffer().pixels().map(|p| p.0).collect();
            (pixels, f64::from(above) / f64::from(below))
        };
        frames.map(frame).collect()
    }

    #[test]
    fn lossless_animations_are_their_frames() {
        for format in [AnimationFormat::Apng, AnimationFormat::WebP] {
            for source in [example as fn(u32) -> Frame, opaque] {
                let bytes = encode(format, 5, 24.0, |i| Ok(source(i))).unwrap();
                assert_eq!(bytes, encode(format, 5, 24.0, |i| Ok(source(i))).unwrap());
                let found = decoded(format, &bytes);
                assert_eq!(found.len(), 5, "{format:?}");
                let mut time = 0.0;
                for (i, (pixels, duration)) in found.iter().enumerate() {
                    // A transparent pixel has no colour.
                    let same = |(a, b): (&[u8; 4], &[u8; 4])| a == b || a[3] == 0 && b[3] == 0;
                    assert!(pixels.iter().zip(&source(i as u32).pixels).all(same), "{format:?} {i}");
                    time += duration;
                    assert!((time - (i + 1) as f64 * 1000.0 / 24.0).abs() <= 1.0, "{format:?} {time}");
                }
            }
        }
    }

    #[test]
    fn gifs_are_near_their_frames() {
        let bytes = encode(AnimationFormat::Gif, 4, 25.0, |i| Ok(example(i))).unwrap();
        assert_eq!(bytes, encode(AnimationFormat::Gif, 4, 25.0, |i| Ok(example(i))).unwrap());
        let found = decoded(AnimationFormat::Gif, &bytes);
        assert_eq!(found.len(), 4);
        for (i, (pixels, duration)) in found.iter().enumerate() {
            assert_eq!(*duration, 40.0);
            let mut differences = Vec::new();
            for (a, b) in pixels.iter().zip(&example(i as u32).pixels) {
                assert_eq!(a[3], b[3], "frame {i}");
                differences
                    .extend(a[..3].iter().zip(&b[..3]).filter(|_| b[3] > 0).map(|(a, b)| a.abs_diff(*b)));
            }
            let sum: u32 = differences.iter().map(|d| u32::from(*d)).sum();
            let mean = f64::from(sum) / differences.len() as f64;
            let far = differences.iter().filter(|d| **d > 32).count();
            assert!(mean < 16.0 && far * 8 < differences.len(), "frame {i}: mean {mean}, {far} far off");
        }
    }

    #[test]
    fn frames_of_other_sizes_are_refused() {
        for format in AnimationFormat::ALL {
            let mixed = |i: u32| {
                Ok(if i == 1 { Frame { width: 1, height: 1, pixels: vec![[0; 4]] } } else { opaque(i) })
            };
            let message = encode(format, 3, 24.0, mixed).unwrap_err().to_string();
            assert!(message.contains("frame 2 has 1 x 1"), "{message}");
            assert!(encode(format, 0, 24.0, |i| Ok(opaque(i))).is_err());
            assert_eq!(AnimationFormat::of_extension(format.extension()), Some(format));
        }
    }
}
