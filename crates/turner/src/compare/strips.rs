//! Fills a map in independent strips of rows on several threads; temporary memory is needed per strip only.

use std::sync::Mutex;

/// Rows of a strip.
const ROWS: usize = 64;

/// A map of `width` x `height` zeros, filled by `work` one strip at a time; it gets the strip's first row and
/// its values.
pub(super) fn map(
    (width, height): (u32, u32),
    threads: usize,
    work: impl Fn(usize, &mut [f32]) + Sync,
) -> Vec<f32> {
    let (width, height) = (width as usize, height as usize);
    let mut map = vec![0.0; width * height];
    let strips = Mutex::new(map.chunks_mut((ROWS * width).max(1)).enumerate());
    let next = || strips.lock().unwrap_or_else(|e| e.into_inner()).next();
    let all = || {
        while let Some((i, strip)) = next() {
            work(i * ROWS, strip);
        }
    };
    turner_host::thread::scope(|scope| {
        let more = threads.min(height.div_ceil(ROWS)).saturating_sub(1);
        let _workers: Vec<_> = (0..more).map(|_| scope.spawn(all)).collect();
        all();
    });
    map
}
