//! Builds BVHs over many kinds of primitives and validates each one completely.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use proptest::prelude::*;

use super::validate::validate;
use super::*;

const QUALITIES: [Quality; 3] = [Quality::Fast, Quality::Balanced, Quality::High];

struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.next())
    }
}

/// Triangles that share no vertices.
struct Soup {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    fn new(corners: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Soup {
        let positions: Vec<[f32; 3]> = corners.into_iter().flatten().collect();
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Soup { positions, triangles }
    }

    /// Triangles of size `size` scattered over the unit cube.
    fn scattered(count: usize, size: f32) -> Soup {
        let mut random = Random(count as u64);
        Soup::new((0..count).map(|_| {
            let c = random.point();
            [0; 3].map(|_| {
                let d = random.point();
                std::array::from_fn(|i| c[i] + size * d[i])
            })
        }))
    }

    /// A mix of large, small, long and thin triangles.
    fn uneven(count: usize) -> Soup {
        let mut random = Random(7);
        Soup::new((0..count).map(|i| {
            let size = if i % 7 == 0 { 1.0 } else { 0.02 };
            let (c, d) = (random.point(), random.point());
            let p: [f32; 3] = std::array::from_fn(|k| c[k] + size * (d[k] - 0.5));
            let q: [f32; 3] = std::array::from_fn(|k| c[k] + 0.01 * size * d[(k + 1) % 3]);
            [c, p, q]
        }))
    }

    fn source(&self) -> Source<'_> {
        Source::Triangles { positions: &self.positions, triangles: &self.triangles, scale: 1.0 }
    }
}

fn options(quality: Quality, threads: usize) -> BuildOptions<'static> {
    BuildOptions { quality, threads, ..BuildOptions::default() }
}

/// Builds with all qualities, validates, and returns the BVHs.
fn build_all(source: &Source<'_>) -> [WideTree; 3] {
    QUALITIES.map(|quality| {
        let tree = build(source, &options(quality, 1)).unwrap();
        validate(&tree, source, quality != Quality::High).unwrap_or_else(|e| panic!("{quality:?}: {e}"));
        tree
    })
}

fn points(points: impl IntoIterator<Item = [f32; 3]>) -> Vec<Aabb> {
    points.into_iter().map(|p| Aabb::new(p, p)).collect()
}

fn build_boxes(boxes: &[Aabb]) -> [WideTree; 3] {
    build_all(&Source::Boxes { boxes, scale: 1.0, width: 1 })
}

#[test]
fn bvhs_of_all_sizes_are_valid() {
    for count in [0, 1, 2, 3, 4, 5, 8, 9, 31, 32, 33, 63, 64, 65, 257, 1000, 9000, 40_000] {
        let soup = Soup::scattered(count, 0.05);
        let trees = build_all(&soup.source());
        assert!(
            trees
                .iter()
                .all(|tree| tree.stats.primitives == count && (tree.nodes.is_empty() == (count == 0)))
        );
        let boxes: Vec<Aabb> = soup.positions.chunks(3).map(|p| Aabb::EMPTY.grow(p[0]).grow(p[1])).collect();
        build_boxes(&boxes);
    }
}

#[test]
fn any_number_of_threads_builds_the_same_bvh() {
    // Enough primitives that several threads split the root together.
    for soup in [Soup::scattered(300_000, 0.01), Soup::uneven(30_000)] {
        for quality in QUALITIES {
            let tree = build(&soup.source(), &options(quality, 1)).unwrap();
            for threads in [0, 2, 3, 7] {
                let other = build(&soup.source(), &options(quality, threads)).unwrap();
                assert!(tree == other, "{quality:?} with {threads} threads");
            }
        }
    }
}

#[test]
fn the_order_of_primitives_does_not_affect_the_bvh() {
    // Splits depend on sets. Only the order of equal centres may differ.
    let soup = Soup::scattered(20_000, 0.01);
    let mut reversed = Soup { positions: soup.positions.clone(), triangles: soup.triangles.clone() };
    reversed.triangles.reverse();
    for quality in [Quality::Fast, Quality::Balanced] {
        let [a, b] =
            [&soup, &reversed].map(|soup| build(&soup.source(), &options(quality, 2)).unwrap().stats);
        assert!((a.sah_cost / b.sah_cost - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
}

#[test]
fn identical_boxes_are_halved() {
    let boxes = vec![Aabb::new([1.0, -2.0, -0.0], [3.0, 0.0, 0.5]); 1_000_000];
    for quality in [Quality::Fast, Quality::Balanced] {
        let source = Source::Boxes { boxes: &boxes, scale: 1.0, width: 1 };
        let tree = build(&source, &options(quality, 2)).unwrap();
        validate(&tree, &source, true).unwrap();
        assert!(tree.stats.max_depth <= 8, "{:?}", tree.stats);
    }
    build_boxes(&boxes[..10_000]);
    build_all(&Soup::new(vec![[[0.0; 3], [1.0; 3], [1.0, 0.0, 0.0]]; 10_000]).source());
}

#[test]
fn grids_lines_and_points_are_valid() {
    build_boxes(&points((0..20_000).map(|i| [i as f32, 0.0, 0.0])));
    build_boxes(&points((0..20_000).map(|i| [0.0, (i % 100) as f32, 3.0])));
    build_boxes(&points((0..30_000).map(|i| [(i % 31) as f32, (i / 31 % 31) as f32, (i / 961) as f32])));
    // Each is twice as far as the one before: every split separates only a few.
    let far: Vec<[f32; 3]> =
        (0..2000).map(|i| [(2.0_f32).exact_power(i % 160 - 80), 0.0, i as f32]).collect();
    build_boxes(&points(far));
    // All in one point.
    let [_, tree, _] = build_boxes(&points(vec![[0.0; 3]; 100]));
    assert!(tree.stats.sah_cost.is_finite());
}

trait ExactPower {
    fn exact_power(self, exponent: i32) -> f32;
}

impl ExactPower for f32 {
    /// `self` to an integer power, exactly for 2.
    fn exact_power(self, exponent: i32) -> f32 {
        let factor = if exponent < 0 { 1.0 / self } else { self };
        (0..exponent.abs()).fold(1.0, |x, _| x * factor)
    }
}

#[test]
fn huge_and_tiny_primitives_are_valid() {
    let mut random = Random(5);
    let scales = [1e-30, 1e-12, 1e-3, 1.0, 1e6, 1e12];
    let soup = Soup::new((0..6000).map(|i| {
        let (c, s) = (random.point(), scales[i % 6]);
        [0; 3].map(|_| {
            let d = random.point();
            std::array::from_fn(|k| s * (c[k] + d[k] - 1.0))
        })
    }));
    build_all(&soup.source());
    let boxes: Vec<Aabb> = (0..3000)
        .map(|i| {
            let p = random.point().map(|x| (x - 0.5) * f32::MAX);
            if i % 5 == 0 {
                Aabb::new([f32::MIN; 3], [f32::MAX; 3])
            } else {
                Aabb::new(p, p.map(|x| x.next_up()))
            }
        })
        .collect();
    build_boxes(&boxes);
}

#[test]
fn unusable_primitives_are_omitted_and_counted() {
    let mut soup = Soup::scattered(1000, 0.1);
    soup.positions[30] = [f32::NAN, 0.0, 0.0];
    soup.positions[61] = [0.0, f32::NEG_INFINITY, 0.0];
    soup.triangles[50][1] = soup.triangles[50][0];
    soup.positions[181] = soup.positions[180];
    for tree in build_all(&soup.source()) {
        let stats = tree.stats;
        assert_eq!((stats.primitives, stats.non_finite, stats.degenerate), (996, 2, 2));
    }
    let mut boxes = points((0..100_000).map(|i| [i as f32, 1.0, 2.0]));
    boxes[3].min[1] = f32::NAN;
    boxes[70_000].max[0] = -1.0;
    boxes[99_999] = Aabb::EMPTY;
    let source = Source::Boxes { boxes: &boxes, scale: 0.5, width: 1 };
    let tree = build(&source, &options(Quality::Balanced, 3)).unwrap();
    validate(&tree, &source, true).unwrap();
    assert_eq!((tree.stats.primitives, tree.stats.non_finite), (99_997, 3));
}

#[test]
fn boxes_hold_scaled_vertices_exactly() {
    let soup = Soup::scattered(5000, 0.1);
    for scale in [0.125, 2.0_f32.exact_power(-140), 2.0_f32.exact_power(40)] {
        let source = Source::Triangles { positions: &soup.positions, triangles: &soup.triangles, scale };
        build_all(&source);
    }
}

#[test]
fn the_first_invalid_vertex_is_reported() {
    let mut soup = Soup::scattered(100_000, 0.1);
    soup.triangles[90_000][2] = u32::MAX;
    soup.triangles[70_001][1] = 300_000;
    for threads in [1, 4] {
        let error = build(&soup.source(), &options(Quality::Balanced, threads)).unwrap_err();
        let expected = BuildError::VertexOutOfRange { triangle: 70_001, vertex: 300_000, vertices: 300_000 };
        assert_eq!(error, expected);
    }
}

#[test]
fn triangles_are_split_where_that_pays() {
    let soup = Soup::uneven(20_000);
    let [_, balanced, high] = build_all(&soup.source());
    assert!(high.stats.references > balanced.stats.references);
    assert!(high.stats.references <= 30_000);
    assert!(high.stats.sah_cost < 0.85 * balanced.stats.sah_cost, "{:?} {:?}", balanced.stats, high.stats);
}

#[test]
fn a_cancelled_build_ends() {
    let soup = Soup::scattered(200_000, 0.01);
    for quality in QUALITIES {
        let cancel = AtomicBool::new(true);
        let requested = BuildOptions { cancel: Some(&cancel), ..options(quality, 2) };
        assert_eq!(build(&soup.source(), &requested), Err(BuildError::Cancelled));
        let stop = |fraction: f32| cancel.store(fraction > 0.2, Ordering::Relaxed);
        cancel.store(false, Ordering::Relaxed);
        let requested = BuildOptions { progress: Some(&stop), ..requested };
        assert_eq!(build(&soup.source(), &requested), Err(BuildError::Cancelled));
    }
}

#[test]
fn progress_rises_to_one() {
    let soup = Soup::scattered(100_000, 0.01);
    for quality in QUALITIES {
        let reported = Mutex::new(Vec::new());
        let progress = |fraction: f32| reported.lock().unwrap().push(fraction);
        build(&soup.source(), &BuildOptions { progress: Some(&progress), ..options(quality, 2) }).unwrap();
        let reported = reported.into_inner().unwrap();
        assert!(reported.len() > 4 && reported.is_sorted() && reported[0] > 0.0, "{reported:?}");
        assert_eq!(reported.last(), Some(&1.0));
    }
}

#[test]
fn the_memory_limit_is_kept() {
    let soup = Soup::uneven(20_000);
    let with = |limit: usize| {
        build(&soup.source(), &BuildOptions { memory_limit: Some(limit), ..options(Quality::High, 1) })
    };
    let Err(BuildError::OutOfMemory { needed }) = with(1 << 20) else {
        panic!("20,000 triangles need more than a megabyte")
    };
    assert!(needed > 1 << 20 && needed < 4 << 20, "{needed}");
    // The smaller the limit, the simpler the build.
    let least = with(needed).unwrap();
    let split = with(1 << 30).unwrap();
    assert_eq!(least, build(&soup.source(), &options(Quality::Balanced, 1)).unwrap());
    assert_eq!(split, build(&soup.source(), &options(Quality::High, 1)).unwrap());
    let between = with(20_000 * 300).unwrap();
    assert_eq!(between.stats.references, 20_000);
    assert!(between.stats.sah_cost < least.stats.sah_cost);
}

#[test]
fn leaves_fill_their_blocks() {
    for soup in [Soup::scattered(50_000, 0.01), Soup::uneven(50_000)] {
        let stats = build(&soup.source(), &options(Quality::Balanced, 2)).unwrap().stats;
        assert!(stats.bytes <= 70 * 50_000, "{stats:?}");
    }
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -1.0_f32..1.0,
        2 => (-4_i8..5).prop_map(f32::from),
        1 => -1e12_f32..1e12,
        1 => -1e-30_f32..1e-30,
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(f32::NAN), Just(f32::INFINITY)],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn bvhs_of_any_triangles_are_valid(
        positions in prop::collection::vec(prop::array::uniform3(coordinate()), 1..60),
        corners in prop::collection::vec(prop::array::uniform3(0_usize..1000), 0..400),
    ) {
        let triangles: Vec<[u32; 3]> =
            corners.iter().map(|t| t.map(|v| (v % positions.len()) as u32)).collect();
        let source = Source::Triangles { positions: &positions, triangles: &triangles, scale: 1.0 };
        build_all(&source);
    }

    #[test]
    fn bvhs_of_any_boxes_are_valid(
        corners in prop::collection::vec(prop::array::uniform2(prop::array::uniform3(coordinate())), 0..400),
    ) {
        let boxes: Vec<Aabb> = corners.iter().map(|[a, b]| Aabb::EMPTY.grow(*a).grow(*b)).collect();
        build_boxes(&boxes);
    }
}
