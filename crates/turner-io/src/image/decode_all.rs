//! Many pictures at once.

use super::{DecodeLimits, ImageError, decode, shrink};
use std::sync::atomic::{AtomicUsize, Ordering};
use turner::image::Image;

/// What a picture is for: how its samples are to be averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorOrData {
    /// Colours: 8- and 16-bit samples carry the sRGB curve (but for alpha) and are averaged as light.
    Color,
    /// Normals, roughness, …: samples are averaged as they are.
    Data,
}

/// A picture still in its file: the bytes, the name for messages, what it is for.
pub type EncodedPicture<'a> = (&'a [u8], &'a str, ColorOrData);

/// Reads pictures on `threads` threads (0: all there are), each of them once. Results are in the order of `pictures`,
/// and neither they nor the errors depend on the number of threads.
///
/// With `max_size`, a picture that has more columns or rows is halved by a box filter until it has not: the means of
/// 2 x 2 pixels, in linear light where the use is [`ColorOrData::Color`].
///
/// At most `threads` pictures are decoded at a time, each within `limits`; what they add up to is for the caller to
/// bound.
pub fn decode_all(
    pictures: &[EncodedPicture<'_>],
    limits: &DecodeLimits,
    threads: usize,
    max_size: Option<u32>,
) -> Vec<Result<Image, ImageError>> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { all } else { threads }.min(pictures.len());
    let one = |&(bytes, name, used_as): &EncodedPicture<'_>| {
        let image = decode(bytes, name, limits)?;
        match max_size {
            Some(max) => shrink::to_fit(image, max, used_as, name),
            None => Ok(image),
        }
    };
    if threads <= 1 {
        return pictures.iter().map(one).collect();
    }
    // The longest first, so that no thread begins with it when the others are done.
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
    let mut results: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        // Decoders cannot panic through `contain`; what does is our own mistake and is passed on.
        let joined = workers.into_iter().map(|w| w.join().unwrap_or_else(|p| std::panic::resume_unwind(p)));
        joined.flatten().collect()
    });
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}
