//! Measures how long a pass runs after it is cancelled: `cancel_latency [--threads N] SCENE...`. Cancels each scene's
//! passes at many moments; prints the median and the longest time from the cancel to the return, in milliseconds.

use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use turner::{PassOptions, PrepareOptions, Renderer};

/// Number of cancelled passes per scene.
const CANCELS: u32 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let mut threads = 2;
    if arguments.next_if_eq("--threads").is_some() {
        threads = arguments.next().ok_or("--threads needs a number")?.parse()?;
    }
    for scene in arguments {
        let mut desc = turner_io::load(Path::new(&scene))?;
        desc.film.samples = desc.film.samples.max(256);
        let mut renderer = Renderer::new(desc.prepare(&PrepareOptions::default())?)?;
        // Finish the decisions that are made before the first sample.
        renderer.pass(1, &PassOptions { threads, cancel: &AtomicBool::new(false), progress: None })?;
        let mut milliseconds = Vec::new();
        for i in 0..CANCELS {
            let cancel = AtomicBool::new(false);
            let options = PassOptions { threads, cancel: &cancel, progress: None };
            let waited = std::thread::scope(|scope| -> Result<_, Box<dyn Error>> {
                let clock = scope.spawn(|| {
                    std::thread::sleep(Duration::from_micros(3000 + 7919 * u64::from(i) % 200_000));
                    cancel.store(true, Ordering::Relaxed);
                    Instant::now()
                });
                renderer.pass(u32::MAX, &options)?;
                let ended = Instant::now();
                let cancelled = clock.join().map_err(|_| "the clock failed")?;
                Ok(ended.saturating_duration_since(cancelled))
            })?;
            milliseconds.push(1e3 * waited.as_secs_f64());
        }
        milliseconds.sort_by(f64::total_cmp);
        let median = milliseconds[milliseconds.len() / 2];
        let most = milliseconds.last().copied().unwrap_or_default();
        println!("{scene:50} median {median:7.2} ms, longest {most:7.2} ms");
    }
    Ok(())
}
