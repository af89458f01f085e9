//! Edits of meshes in the static world mesh: the BVH of the others is kept.

use std::sync::Arc;

use proptest::prelude::*;

use super::tests::{is_as_fresh, rendered, shown, start};
use super::{Preparer, UpdateOptions};
use crate::description::SceneDesc;
use crate::integrator::{CostDesc, IntegratorDesc, NormalsDesc};
use crate::math::{DAffine3, DVec3};
use crate::schema::{Asset, MeshData, PrepareOptions, Transform};

/// A square with hills, of `2 side²` triangles, with degenerate and non-finite ones.
fn hills(side: u32, seed: u32) -> Arc<MeshData> {
    let height = |x: u32, z: u32| ((x * 7 + z * 13 + seed * 31) % 17) as f32 * 0.02;
    let coordinate = |i: u32| i as f32 / side as f32 - 0.5;
    let points = (0..=side).flat_map(|z| (0..=side).map(move |x| (x, z)));
    let mut positions: Vec<_> = points.map(|(x, z)| [coordinate(x), height(x, z), coordinate(z)]).collect();
    positions.push([f32::NAN; 3]);
    let squares = (0..side).flat_map(|z| (0..side).map(move |x| z * (side + 1) + x));
    let mut triangles: Vec<_> =
        squares.flat_map(|a| [[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]).collect();
    triangles.extend([[0, 1, 2], [0, 1, positions.len() as u32 - 1]]);
    Arc::new(MeshData { positions, triangles, ..MeshData::default() })
}

/// Sixteen overlapping squares.
fn squares() -> SceneDesc {
    let mut desc = start();
    (desc.film.width, desc.film.height) = (24, 18);
    desc.groups.clear();
    desc.objects.truncate(3);
    desc.meshes = (0..16).map(|i| Asset { uri: format!("{i}"), data: hills(12, i / 2) }).collect();
    for i in 0..16 {
        let at = [f64::from(i % 4) - 1.5, 0.1 * f64::from(i / 2), f64::from(i / 4) - 2.0];
        desc.objects.push(shown(i, 0, at));
    }
    desc
}

/// One edit of a mesh or of its object, selected by two integers.
fn edit(desc: &mut SceneDesc, what: u8, by: u8) {
    let x = f64::from(by) / 64.0 - 2.0;
    let count = desc.objects.len();
    let object = 3 + usize::from(by) % (count - 3).max(1);
    match what {
        0 if object < count => {
            let turn = DAffine3::from_rotation_y(x);
            desc.objects[object].transform =
                Transform(DAffine3::from_translation(DVec3::new(x, 0.5, 0.0)) * turn);
        }
        // The same number of triangles, and another number.
        1 => desc.meshes[usize::from(by) % 16].data = hills(12, u32::from(by)),
        2 => desc.meshes[usize::from(by) % 16].data = hills(u32::from(by % 16) + 1, 3),
        3 => desc.objects.push(shown(u32::from(by) % 16, 0, [x, 1.0, 0.0])),
        4 if object < count => drop(desc.objects.remove(object)),
        5 if object < count => {
            let removed = desc.objects.remove(object);
            desc.objects.push(removed);
        }
        // Far away: the traversal frame changes.
        6 if object < count => desc.objects[object].transform.0.translation.x = 1e4 * x,
        _ => desc.camera = Some(super::tests::camera(4.0 + x).into()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn world_meshes_that_change_have_the_bytes_of_fresh_ones(
        edits in prop::collection::vec((0u8..8, any::<u8>()), 1..8),
    ) {
        let mut preparer = Preparer::new(PrepareOptions::default());
        let mut desc = squares();
        preparer.update(&desc).unwrap();
        for (what, by) in edits {
            edit(&mut desc, what, by);
            prop_assert!(is_as_fresh(&mut preparer, &desc), "{what} {by}");
        }
    }
}

#[test]
fn the_bvh_of_the_others_is_kept_unless_traversal_cost_is_shown() {
    let mut preparer = Preparer::new(PrepareOptions::default());
    let mut desc = squares();
    preparer.update(&desc).unwrap();
    let mut changed = |desc: &SceneDesc| {
        let update = preparer.update_with(desc, &UpdateOptions::default()).unwrap().unwrap();
        let changed = update.prepared.scene.world_mesh.as_ref().unwrap().is_changed();
        let fresh = desc.prepare(&PrepareOptions::default()).unwrap();
        assert!(rendered(update.prepared) == rendered(fresh));
        (update.rebuilt.world_mesh, changed)
    };
    desc.integrator = IntegratorDesc::Normals(NormalsDesc::default());
    assert_eq!(changed(&desc), (false, false));
    edit(&mut desc, 0, 5);
    assert_eq!(changed(&desc), (true, true));
    desc.camera = Some(super::tests::camera(6.0).into());
    assert_eq!(changed(&desc), (false, true));
    // At the original transform.
    desc.objects = squares().objects;
    assert_eq!(changed(&desc), (true, false));
    edit(&mut desc, 0, 5);
    assert_eq!(changed(&desc), (true, true));
    desc.integrator = IntegratorDesc::Cost(CostDesc::default());
    assert_eq!(changed(&desc), (true, false));
    edit(&mut desc, 1, 100);
    assert_eq!(changed(&desc), (true, false));
    // So many edits that a full rebuild is better.
    desc.integrator = IntegratorDesc::Normals(NormalsDesc::default());
    for object in [1, 60, 90, 130] {
        edit(&mut desc, 0, object);
    }
    assert_eq!(changed(&desc), (true, false));
}

/// As few meshes as possible stay out of the world mesh: a wide floor under small meshes, a small mesh among wide ones.
#[test]
fn few_meshes_keep_their_own_bvh() {
    let triangles_gathered = |widths: [f32; 4]| {
        let mut desc = squares();
        desc.objects.truncate(3);
        desc.meshes.truncate(widths.len());
        for (i, width) in widths.into_iter().enumerate() {
            let mut data = (*hills(1 + i as u32, 0)).clone();
            data.positions.iter_mut().for_each(|p| *p = p.map(|v| v * width));
            desc.meshes[i].data = Arc::new(data);
            desc.objects.push(shown(i as u32, 0, [0.0; 3]));
        }
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        prepared.scene.world_mesh.as_ref().map(|world| world.mesh().triangle_count())
    };
    // Meshes of 3, 8, 18 and 32 triangles.
    assert_eq!(triangles_gathered([1.0, 1.0, 1.0, 1.0]), Some(61));
    assert_eq!(triangles_gathered([4000.0, 1.0, 1.0, 1.0]), Some(61));
    assert_eq!(triangles_gathered([400_000.0, 1.0, 1.0, 1.0]), Some(58));
    assert_eq!(triangles_gathered([400_000.0, 400_000.0, 1.0, 400_000.0]), Some(43));
}
