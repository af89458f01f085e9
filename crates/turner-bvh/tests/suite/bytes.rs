//! Arbitrary bytes as triangles and rays: no panic, no endless traversal, and the same hits for every build and query.
//!
//! The fuzz target `bvh` runs the same check.

use turner_bvh::{BuildOptions, Bvh, Hit, Quality, Ray, Triangles};

/// Half of the numbers are small multiples of 0.25, so that they coincide often; half are any float.
fn number(bytes: [u8; 4]) -> f32 {
    if bytes[3] & 1 == 0 { f32::from(bytes[0] as i8) * 0.25 } else { f32::from_le_bytes(bytes) }
}

fn vector(bytes: &[u8]) -> [f32; 3] {
    [0, 1, 2].map(|i| number([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]))
}

/// Turns bytes into a mesh and rays and compares all builds and queries.
pub(crate) fn check(data: &[u8]) {
    let Some((&count, rest)) = data.split_first() else { return };
    let positions: Vec<[f32; 3]> = rest.chunks_exact(12).map(vector).collect();
    if positions.len() < 5 {
        return;
    }
    let (positions, others) = positions.split_at(positions.len() / 2);
    let vertices = positions.len() as u32;
    let triangles: Vec<[u32; 3]> = rest
        .windows(3)
        .take(usize::from(count))
        .map(|w| [0, 1, 2].map(|i| u32::from(w[i]) % vertices))
        .collect();
    let rays: Vec<Ray> = others.chunks_exact(2).map(|pair| Ray::new(pair[0], pair[1])).collect();
    let mesh = Triangles { positions, triangles: &triangles };
    let mut first: Option<Vec<Hit>> = None;
    for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
        let options = BuildOptions { quality, threads: 1, ..BuildOptions::default() };
        let bvh = Bvh::build(&mesh, &options).expect("few triangles with valid vertices");
        let hits: Vec<Hit> = rays.iter().map(|ray| bvh.intersect(ray).unwrap_or(Hit::MISS)).collect();
        let mut others = vec![Hit::MISS; rays.len()];
        bvh.intersect_batch(&rays, &mut others);
        assert_eq!(hits, others);
        let mut any = vec![false; rays.len()];
        bvh.occluded_batch(&rays, &mut any);
        assert!(hits.iter().zip(&any).all(|(hit, any)| hit.is_hit() == *any));
        for (ray, hit) in rays.iter().zip(&hits) {
            assert_eq!(bvh.occluded(ray), hit.is_hit());
            assert!(!hit.is_hit() || hit.t.is_finite() && hit.primitive < triangles.len() as u32);
        }
        assert_eq!(first.get_or_insert_with(|| hits.clone()), &hits);
    }
}

/// Checks random bytes: up to 100 vertices, some repeated so that vertices and rays coincide.
#[cfg(test)]
fn random_bytes(seed: u64, cases: u64) {
    for case in 0..cases {
        let mut random = turner_bvh::generate::Random::new(seed + case);
        let mut bytes = vec![random.bits() as u8];
        for _ in 0..5 + random.bits() % 100 {
            if bytes.len() > 12 && random.bits().is_multiple_of(4) {
                let from = 1 + 12 * (random.bits() as usize % (bytes.len() / 12));
                bytes.extend_from_within(from..from + 12);
            } else {
                let numbers = [random.bits(), random.bits()].map(u64::to_le_bytes).concat();
                bytes.extend_from_slice(&numbers[..12]);
            }
        }
        check(&bytes);
    }
}

#[test]
fn arbitrary_bytes() {
    random_bytes(0, 300);
}

/// Takes minutes: `cargo test --release -p turner-bvh --test suite -- --ignored bytes`.
#[test]
#[ignore = "takes minutes"]
fn many_arbitrary_bytes() {
    random_bytes(1 << 32, 2_000_000);
}
