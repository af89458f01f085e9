//! Timing: contenders alternate on the same rays, on pinned threads.

use std::hint::black_box;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Barrier, Mutex};
use std::time::{Duration, Instant};

use turner_bvh::Ray;

use super::embree::{Packets, packets};
use super::tracer::Hit;

/// Rays that a thread takes at a time.
pub(super) const CHUNK: usize = 256;

/// Target minimum of one run in seconds: small sets of rays are traced several times.
const MIN_SECONDS: f64 = 0.1;
/// Target maximum of one run in seconds: of large sets, evenly spaced chunks are omitted.
const MAX_SECONDS: f64 = 0.5;

/// How rays are passed to a tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Query {
    /// Singly.
    One,
    /// Many at once, incoherent.
    Batch,
    /// Many at once, coherent.
    Coherent,
}

/// Traces rays. It gets a range of at most [`CHUNK`] rays that begins at a multiple of [`CHUNK`] and writes their
/// results to the front of the output.
pub(super) trait Tracer: Sync {
    /// The nearest hits.
    fn nearest(&self, query: Query, set: &RaySet, range: Range<usize>, hits: &mut [Hit; CHUNK]);
    /// Whether there is any hit.
    fn any(&self, query: Query, set: &RaySet, range: Range<usize>, occluded: &mut [bool; CHUNK]);
}

/// Rays, and the query they are for.
pub(super) struct RaySet {
    /// The rays.
    pub(super) rays: Vec<Ray>,
    /// The same rays, prepared as packets.
    #[cfg_attr(not(feature = "embree"), expect(dead_code))]
    pub(super) packets: Packets,
    /// Whether any hit counts.
    pub(super) any: bool,
}

impl RaySet {
    pub(super) fn new(rays: Vec<Ray>, any: bool) -> RaySet {
        RaySet { packets: packets(&rays), rays, any }
    }

    fn chunk(&self, index: usize) -> Range<usize> {
        index * CHUNK..((index + 1) * CHUNK).min(self.rays.len())
    }

    /// Traces a chunk and passes the results to `take`: an occluded ray has `t` = 0.
    #[inline]
    fn trace(&self, by: Contender<'_>, chunk: usize, mut take: impl FnMut(&[Hit])) {
        let range = self.chunk(chunk);
        let count = range.len();
        let mut hits = [Hit::MISS; CHUNK];
        if self.any {
            let mut occluded = [false; CHUNK];
            by.tracer.any(by.query, self, range, &mut occluded);
            for (hit, &occluded) in hits.iter_mut().zip(&occluded) {
                hit.t = if occluded { 0.0 } else { f32::INFINITY };
            }
        } else {
            by.tracer.nearest(by.query, self, range, &mut hits);
        }
        take(&hits[..count]);
    }
}

/// A tracer and how rays are passed to it.
#[derive(Clone, Copy)]
pub(super) struct Contender<'a> {
    pub(super) tracer: &'a dyn Tracer,
    pub(super) query: Query,
}

/// The part of a set that each run traces, and how often.
pub(super) struct Plan {
    chunks: Vec<usize>,
    passes: usize,
    /// Rays of one run.
    pub(super) rays: usize,
}

impl Plan {
    /// Chooses the size by a short trial.
    pub(super) fn new(set: &RaySet, trial: Contender<'_>, threads: usize) -> Plan {
        let all = set.rays.len().div_ceil(CHUNK);
        let every = |step: usize, passes: usize| {
            let chunks: Vec<usize> = (0..all).step_by(step.max(1)).collect();
            let rays = chunks.iter().map(|&i| set.chunk(i).len()).sum::<usize>() * passes;
            Plan { chunks, passes, rays }
        };
        // The first trial warms up the caches.
        let trial = [256, 64].map(|parts| {
            let plan = every(all.div_ceil(parts), 1);
            run(set, trial, &plan, 1).as_secs_f64() / plan.chunks.len().max(1) as f64
        });
        let seconds = (trial[1] * all as f64 / threads as f64).max(1e-6);
        let step = (seconds / MAX_SECONDS).ceil() as usize;
        every(step, if step > 1 { 1 } else { (MIN_SECONDS / seconds).ceil() as usize })
    }
}

/// One run: the time from the start of the first thread to the end of the last.
pub(super) fn run(set: &RaySet, by: Contender<'_>, plan: &Plan, threads: usize) -> Duration {
    let next = AtomicUsize::new(0);
    let total = plan.chunks.len() * plan.passes;
    let barrier = Barrier::new(threads);
    let spans = Mutex::new(Vec::with_capacity(threads));
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let (next, barrier, spans) = (&next, &barrier, &spans);
            scope.spawn(move || {
                pin(thread);
                barrier.wait();
                let start = Instant::now();
                loop {
                    let turn = next.fetch_add(1, Ordering::Relaxed);
                    if turn >= total {
                        break;
                    }
                    set.trace(by, plan.chunks[turn % plan.chunks.len()], |hits| {
                        black_box(hits);
                    });
                }
                spans.lock().unwrap_or_else(|e| e.into_inner()).push((start, Instant::now()));
            });
        }
    });
    let spans = spans.into_inner().unwrap_or_else(|e| e.into_inner());
    let start = spans.iter().map(|s| s.0).min();
    let end = spans.iter().map(|s| s.1).max();
    start.zip(end).map_or(Duration::ZERO, |(start, end)| end - start)
}

/// The results for the rays of the plan, in its order.
pub(super) fn answers(set: &RaySet, by: Contender<'_>, plan: &Plan) -> Vec<Hit> {
    let mut all = Vec::with_capacity(plan.rays);
    for &chunk in &plan.chunks {
        set.trace(by, chunk, |hits| all.extend_from_slice(hits));
    }
    all
}

/// The results for all rays.
pub(super) fn all_answers(set: &RaySet, by: Contender<'_>) -> Vec<Hit> {
    let plan =
        Plan { chunks: (0..set.rays.len().div_ceil(CHUNK)).collect(), passes: 1, rays: set.rays.len() };
    answers(set, by, &plan)
}

/// Number of rays with different results: a hit and a miss, or distances with a relative difference above 1e-4.
pub(super) fn differences(a: &[Hit], b: &[Hit]) -> usize {
    let differ = |(a, b): &(&Hit, &Hit)| match (a.t.is_finite(), b.t.is_finite()) {
        (false, false) => false,
        (true, true) => (a.t - b.t).abs() > 1e-4 * a.t.abs().max(b.t.abs()),
        (true, false) | (false, true) => true,
    };
    a.iter().zip(b).filter(differ).count()
}

/// Pins the calling thread to one of the processors it may use. Failures are ignored.
#[cfg(target_os = "linux")]
fn pin(thread: usize) {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let Ok(allowed) = sched_getaffinity(None) else { return };
    let cpus: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu)).collect();
    if let Some(&cpu) = cpus.get(thread % cpus.len().max(1)) {
        let mut one = CpuSet::new();
        one.set(cpu);
        // An unpinned measurement is better than none.
        let _ = sched_setaffinity(None, &one);
    }
}

#[cfg(not(target_os = "linux"))]
fn pin(_: usize) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_differ_by_more_than_rounding() {
        let hit = |t: f32| Hit { t, ..Hit::MISS };
        assert_eq!(differences(&[hit(1.0), Hit::MISS, hit(2.0)], &[hit(1.00001), Hit::MISS, hit(2.0)]), 0);
        assert_eq!(differences(&[hit(1.0), Hit::MISS, hit(2.0)], &[hit(1.001), hit(1.0), Hit::MISS]), 3);
    }
}
