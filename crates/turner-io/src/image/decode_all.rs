//! Decodes several images in parallel.

use super::{DecodeLimits, ImageError, decode_as_stored, shrink};
use std::sync::atomic::{AtomicUsize, Ordering};
use turner::image::Image;

/// What an image is used for, which determines how its samples are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorOrData {
    /// Colours: 8- and 16-bit samples (except alpha) are sRGB-encoded and averaged in linear light.
    Color,
    /// Data such as normals and roughness: samples are averaged as stored.
    Data,
}

/// An encoded image: the bytes, its name in messages, its use.
pub type EncodedPicture<'a> = (&'a [u8], &'a str, ColorOrData);

/// Decodes images on `threads` threads (0: all available). Results are in the order of `pictures` and do not depend
/// on the number of threads.
///
/// With `max_size`, an image with more columns or rows is halved until it fits: 2 x 2 pixels are averaged with a box
/// filter, in linear light for [`ColorOrData::Color`].
///
/// The use decides how samples of 8 and 16 bits are decoded, not what a KTX2 file says of its own.
///
/// At most `threads` images are decoded at a time, each within `limits`; the caller bounds their sum.
pub fn decode_all(
    pictures: &[EncodedPicture<'_>],
    limits: &DecodeLimits,
    threads: usize,
    max_size: Option<u32>,
) -> Vec<Result<Image, ImageError>> {
    let all = turner_host::thread::available();
    let threads = if threads == 0 { all } else { threads }.min(pictures.len());
    let one = |&(bytes, name, used_as): &EncodedPicture<'_>| {
        let image = decode_as_stored(bytes, name, limits)?;
        match max_size {
            Some(max) => shrink::to_fit(image, max, used_as, name),
            None => Ok(image),
        }
    };
    if threads <= 1 {
        return pictures.iter().map(one).collect();
    }
    // The largest first, so that no thread starts it when the others have finished.
    let mut order: Vec<usize> = (0..pictures.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(pictures[i].0.len()));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push((i, one(&pictures[i])));
        }
        done
    };
    let mut results: Vec<_> = turner_host::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        // Panics of decoders are contained; any other panic is a bug and is propagated.
        let joined = workers.into_iter().map(|w| w.join().unwrap_or_else(|p| std::panic::resume_unwind(p)));
        joined.flatten().collect()
    });
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}
