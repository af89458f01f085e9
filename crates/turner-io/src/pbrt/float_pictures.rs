//! Images of float textures. pbrt reads the alpha channel of an image that has one, unless it is 1 everywhere, and
//! otherwise the mean of the colours. Its values are decoded like those of the colours.

use std::ops::Range;

use turner::image::{Image, Pixels};
use turner::schema::ImageId;
use turner::texture::{Encoding, ImageChannel};

use super::assembly::Assembly;

/// The image whose values a float texture has, and the channel of it. `has_alpha` is whether pbrt keeps the alpha channel
/// of files of this format.
pub(super) fn of_float(
    scene: &mut Assembly<'_>,
    file: ImageId,
    encoding: Encoding,
    has_alpha: bool,
) -> (ImageId, ImageChannel) {
    let Some((image, uri)) = scene.images.get(file.index()).map(|i| (i.data.clone(), i.uri.clone())) else {
        return (file, ImageChannel::Rgb);
    };
    if !matches!(image.channels, 2 | 4) {
        return (file, ImageChannel::Rgb);
    }
    let colors = image.channels as usize - 1;
    let (part, channel) = match alpha_of(&image) {
        Alpha::Partial if has_alpha && colors == 3 => {
            if encoding == Encoding::Linear || !image.is_display_encoded() {
                return (file, ImageChannel::A);
            }
            (colors..colors + 1, ImageChannel::A)
        }
        Alpha::Mask if has_alpha && colors == 3 => return (file, ImageChannel::A),
        _ => (0..colors, ImageChannel::Rgb),
    };
    // The key is no file name.
    let key = format!("\0float {} {part:?}", file.index());
    if let Some(&Some(known)) = scene.image_ids.get(&key) {
        return (known, ImageChannel::Rgb);
    }
    let bytes = u64::from(image.width) * u64::from(image.height) * part.len() as u64 * sample_bytes(&image);
    let made = if scene.may_copy(bytes) { selected(&image, part) } else { None };
    let Some(made) = made else { return (file, channel) };
    let id = scene.add_image(&uri, made);
    scene.image_ids.insert(key, Some(id));
    (id, ImageChannel::Rgb)
}

/// The values of an alpha channel.
enum Alpha {
    /// 1 everywhere.
    One,
    /// 0 or 1.
    Mask,
    Partial,
}

fn alpha_of(image: &Image) -> Alpha {
    fn of<T: Copy + PartialEq>(samples: &[T], channels: usize, [none, full]: [T; 2]) -> Alpha {
        let mut alphas = samples.chunks_exact(channels.max(1)).filter_map(<[T]>::last);
        if alphas.clone().all(|a| *a == full) {
            Alpha::One
        } else if alphas.all(|a| *a == full || *a == none) {
            Alpha::Mask
        } else {
            Alpha::Partial
        }
    }
    let channels = image.channels as usize;
    match &image.pixels {
        Pixels::U8(v) => of(v, channels, [0, u8::MAX]),
        Pixels::U16(v) => of(v, channels, [0, u16::MAX]),
        Pixels::F32(v) => of(v, channels, [0.0, 1.0]),
    }
}

fn sample_bytes(image: &Image) -> u64 {
    match image.pixels {
        Pixels::U8(_) => 1,
        Pixels::U16(_) => 2,
        Pixels::F32(_) => 4,
    }
}

/// The image with some of its channels; `None` if memory is short.
fn selected(image: &Image, part: Range<usize>) -> Option<Image> {
    fn of<T: Copy>(samples: &[T], channels: usize, part: &Range<usize>) -> Option<Vec<T>> {
        let mut out = Vec::new();
        out.try_reserve_exact(samples.len() / channels.max(1) * part.len()).ok()?;
        for pixel in samples.chunks_exact(channels.max(1)) {
            out.extend_from_slice(pixel.get(part.clone())?);
        }
        Some(out)
    }
    let channels = image.channels as usize;
    let pixels = match &image.pixels {
        Pixels::U8(v) => Pixels::U8(of(v, channels, &part)?),
        Pixels::U16(v) => Pixels::U16(of(v, channels, &part)?),
        Pixels::F32(v) => Pixels::F32(of(v, channels, &part)?),
    };
    Some(Image { channels: part.len() as u8, pixels, ..*image })
}
