use proptest::prelude::*;

use super::*;
use crate::generate::{SceneKind, rays};
use crate::{InstructionSet, Quality};

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn options(quality: Quality) -> BuildOptions<'static> {
    BuildOptions { quality, threads: 2, ..BuildOptions::default() }
}

fn build((positions, triangles): &Mesh, quality: Quality) -> Bvh {
    Bvh::build(&Triangles { positions, triangles }, &options(quality)).unwrap()
}

/// A mesh assembled from runs of an old one (`Ok`), with `Err(count)` new triangles in between, moved by `by`.
fn assembled(old: &Mesh, parts: &[Result<(u32, u32), u32>], by: [f32; 3]) -> (Mesh, Vec<Kept>) {
    let corners = |i: u32| old.1[i as usize].map(|v| old.0[v as usize]);
    let (mut mesh, mut kept) = (Mesh::default(), Vec::new());
    let mut add = |corners: [[f32; 3]; 3]| {
        let first = mesh.0.len() as u32;
        mesh.0.extend(corners);
        mesh.1.push([first, first + 1, first + 2]);
    };
    let mut to = 0;
    for part in parts {
        match *part {
            Ok((from, count)) => {
                (from..from + count).for_each(|i| add(corners(i)));
                kept.push(Kept { from, to, count });
                to += count;
            }
            Err(count) => {
                let moved = |i: u32| corners(i).map(|p| std::array::from_fn(|axis| p[axis] + by[axis]));
                (0..count).for_each(|i| add(moved(i * 7 % old.1.len() as u32)));
                to += count;
            }
        }
    }
    (mesh, kept)
}

/// The changed BVH.
fn changed(bvh: &Bvh, old: &Mesh, new: &Mesh, kept: &[Kept], quality: Quality) -> Option<Bvh> {
    let index_map = IndexMap { kept };
    let gone = (0..old.1.len() as u32)
        .filter(|i| index_map.of(*i).is_none())
        .flat_map(|i| old.1[i as usize])
        .fold(Aabb::EMPTY, |all, v| all.grow(old.0[v as usize]));
    let corners = |i: u32| Some(new.1[i as usize].map(|v| new.0[v as usize]));
    let farthest = new.0.iter().flatten().filter(|x| x.is_finite()).fold(0.0_f32, |m, x| m.max(x.abs()));
    let mesh = ChangedMesh { count: new.1.len() as u32, kept, gone, farthest, corners: &corners };
    bvh.changed(&mesh, &options(quality)).unwrap()
}

/// Every query with every instruction set gives the bits of a BVH built over the new mesh.
fn same(changed: &Bvh, fresh: &Bvh, rays: &[Ray]) {
    let bits = |hit: Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.primitive);
    assert_eq!(changed.space, fresh.space);
    for instruction_set in InstructionSet::available() {
        let [a, b] = [changed, fresh].map(|bvh| Bvh { instruction_set, ..bvh.clone() });
        // A filter that depends on the ray and on the hit.
        let odd = |ray: u32, hit: &Hit| !(ray + hit.primitive).is_multiple_of(3);
        let found = |bvh: &Bvh| {
            let (mut all, mut some) = (vec![Hit::MISS; rays.len()], vec![Hit::MISS; rays.len()]);
            bvh.intersect_batch(rays, &mut all);
            bvh.intersect_batch_filtered(rays, &mut some, odd);
            let single = rays.iter().map(|ray| bvh.intersect(ray).unwrap_or(Hit::MISS));
            let odd = rays.iter().map(|r| bvh.intersect_filtered(r, |h| odd(1, h)).unwrap_or(Hit::MISS));
            all.iter()
                .copied()
                .chain(some.iter().copied())
                .chain(single)
                .chain(odd)
                .map(bits)
                .collect::<Vec<_>>()
        };
        assert_eq!(found(&a), found(&b), "{instruction_set}");
        let occluded = |bvh: &Bvh| {
            let (mut all, mut some) = (vec![false; rays.len()], vec![false; rays.len()]);
            bvh.occluded_batch(rays, &mut all);
            bvh.occluded_batch_filtered(rays, &mut some, odd);
            let single = rays.iter().map(|ray| bvh.occluded(ray));
            let odd = rays.iter().map(|r| bvh.occluded_filtered(r, |h| odd(2, h)));
            all.iter().copied().chain(some.iter().copied()).chain(single).chain(odd).collect::<Vec<_>>()
        };
        assert_eq!(occluded(&a), occluded(&b), "{instruction_set}");
    }
}

fn scene(kind: SceneKind, count: usize) -> (Mesh, Vec<Ray>) {
    let scene = kind.generate(count);
    let mesh = &scene.meshes[0];
    let old: Mesh = (mesh.positions.clone(), mesh.triangles.clone());
    let camera = rays::primary(&scene.camera, 20);
    let bvh = build(&old, Quality::Balanced);
    let extent = scene.extent();
    let points: Vec<_> = camera
        .iter()
        .filter_map(|r| bvh.intersect(r).and_then(|h| rays::point(&scene, extent, r, h.t, 0, h.primitive)))
        .collect();
    let mut rays = [camera, rays::diffuse(&points), rays::shadow(&points, scene.light)].concat();
    rays.push(Ray { t_max: f32::NAN, ..rays[0] });
    (old, rays)
}

#[test]
fn changed_parts_have_the_hits_of_a_new_bvh() {
    for kind in [SceneKind::Architecture, SceneKind::Scan] {
        let (old, rays) = scene(kind, 3000);
        let count = old.1.len() as u32;
        let third = count / 3;
        // Includes coincident triangles: which of them is hit depends on their indices.
        let cases: [(&[_], [f32; 3]); 5] = [
            (&[Ok((0, third)), Err(100), Ok((third + 100, count - third - 100))], [0.1, 0.2, -0.1]),
            (&[Err(50), Ok((0, count))], [0.0; 3]),
            (&[Ok((0, third)), Err(50), Ok((third, count - third)), Err(20)], [0.0; 3]),
            (&[Ok((3, 20)), Ok((third, third))], [0.0; 3]),
            (&[Err(300)], [0.5, 0.0, 0.0]),
        ];
        for (parts, by) in cases {
            for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
                let (new, kept) = assembled(&old, parts, by);
                let bvh = build(&old, quality);
                let changed = changed(&bvh, &old, &new, &kept, quality).unwrap();
                same(&changed, &build(&new, quality), &rays);
                assert!(changed.changed(&no_change(&kept), &options(quality)).unwrap().is_none());
            }
        }
    }
}

fn no_change(kept: &[Kept]) -> ChangedMesh<'_> {
    ChangedMesh { count: 0, kept, gone: Aabb::EMPTY, farthest: 1.0, corners: &|_| None }
}

#[test]
fn another_scale_needs_a_new_bvh() {
    let (old, _) = scene(SceneKind::Scan, 500);
    let bvh = build(&old, Quality::Balanced);
    let (new, kept) = assembled(&old, &[Ok((0, 100)), Err(10)], [1e20, 0.0, 0.0]);
    assert!(changed(&bvh, &old, &new, &kept, Quality::Balanced).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn any_change_has_the_hits_of_a_new_bvh(
        cuts in prop::collection::vec((any::<bool>(), 0u32..400, 0u32..60), 0..8),
        by in prop::array::uniform3(-1.0f32..1.0),
        seed in 0usize..3,
    ) {
        let kind = [SceneKind::Cornell, SceneKind::Architecture, SceneKind::Sticks][seed];
        let (old, rays) = scene(kind, 1500);
        let count = old.1.len() as u32;
        let (mut parts, mut at) = (Vec::new(), 0);
        for (new, run, skipped) in cuts {
            let run = run.min(count - at);
            parts.push(Ok((at, run)));
            at = (at + run + skipped).min(count);
            if new {
                parts.push(Err(skipped));
            }
        }
        parts.push(Ok((at, count - at)));
        let (new, kept) = assembled(&old, &parts, by);
        let bvh = build(&old, Quality::Balanced);
        if let Some(changed) = changed(&bvh, &old, &new, &kept, Quality::Balanced) {
            same(&changed, &build(&new, Quality::Balanced), &rays);
        }
    }
}
