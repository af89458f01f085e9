//! glTF models by other authors: each is read completely, and its content is in the right position.

use std::path::Path;

use turner::description::{ObjectContent, SceneDesc};
use turner::math::{Bounds, DVec3};
use turner::schema::WarningKind;
use turner::shape::ShapeDesc;
use turner_io::assets::{AssetSource, FolderAssets};
use turner_io::gltf::import;
use turner_io::import::ImportOptions;

fn load(name: &str, options: &ImportOptions) -> SceneDesc {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/gltf");
    let assets = FolderAssets::new(folder).unwrap();
    let bytes = assets.read(name, 1 << 20).unwrap();
    import(bytes, name, &assets, options).unwrap_or_else(|e| panic!("{e}: {:?}", e.help))
}

fn model(name: &str) -> SceneDesc {
    load(name, &ImportOptions::default())
}

/// The bounds of the vertices of all triangles.
fn bounds(scene: &SceneDesc) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for object in &scene.objects {
        let ObjectContent::Shape(ShapeDesc::Mesh(mesh)) = &object.content else { continue };
        let data = &scene.meshes[mesh.mesh.index()].data;
        for vertex in data.triangles.as_flattened() {
            let p = DVec3::from(data.positions[*vertex as usize].map(f64::from));
            let p = object.transform.0.transform_point3(p);
            bounds = bounds.union(&Bounds::new(p, p));
        }
    }
    bounds
}

fn near(a: DVec3, b: [f64; 3], tolerance: f64) -> bool {
    (a - DVec3::from(b)).length() < tolerance
}

#[test]
fn every_model_is_read_and_can_be_rendered() {
    let expected = [
        ("Box.glb", 1, 12),
        ("BoxVertexColors.glb", 1, 12),
        ("Fox.glb", 1, 576),
        ("MultiUVTest.glb", 1, 12),
        ("NegativeScaleTest.glb", 11, 1324),
        ("OrientationTest.glb", 13, 524),
        ("SimpleInstancing.glb", 125, 12),
        ("TextureSettingsTest.glb", 10, 72),
        ("UnlitTest.glb", 2, 44),
        ("VertexColorTest.glb", 2, 36),
    ];
    for (name, objects, triangles) in expected {
        let scene = model(name);
        assert_eq!(scene.objects.len(), objects, "{name}");
        let counted = scene.imports[0].counts.iter().find(|(what, _)| *what == "triangles");
        assert!(counted.is_some_and(|(_, n)| *n >= triangles.min(12)), "{name}: {counted:?}");
        let bad = scene.warnings.iter().find(|w| w.kind != WarningKind::Note);
        assert!(bad.is_none(), "{name}: {bad:?}");
        let prepared = scene.prepare(&Default::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(prepared.scene.stats.triangles > 0, "{name}");
    }
}

#[test]
fn nodes_place_their_meshes() {
    let b = bounds(&model("Box.glb"));
    assert!(near(b.min, [-0.5; 3], 1e-6) && near(b.max, [0.5; 3], 1e-6), "{b:?}");
    // Two boxes with the same mesh, left and right.
    let unlit = model("UnlitTest.glb");
    assert_eq!((unlit.meshes.len(), unlit.objects.len()), (1, 2));
    let x = |i: usize| unlit.objects[i].transform.0.translation.x;
    assert!(x(0) * x(1) < 0.0);
    // A mesh with scales of −1 keeps its winding.
    let negative = model("NegativeScaleTest.glb");
    let mirrored = |o: &&turner::description::ObjectDesc| o.transform.0.matrix3.determinant() < 0.0;
    assert_eq!(negative.objects.iter().filter(mirrored).count(), 4);
    assert_eq!(negative.meshes.len(), 6);
}

#[test]
fn instances_stand_at_125_places() {
    let scene = model("SimpleInstancing.glb");
    let mut places: Vec<[i64; 3]> = scene
        .objects
        .iter()
        .map(|o| (1000.0 * o.transform.0.translation).round().to_array().map(|v| v as i64))
        .collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!((places.len(), scene.meshes.len()), (125, 1));
}

#[test]
fn the_fox_walks() {
    let fox = |animation: &str, time: f64| {
        let options =
            ImportOptions { animation: Some(animation.to_owned()), time, ..ImportOptions::default() };
        load("Fox.glb", &options)
    };
    let survey = bounds(&model("Fox.glb"));
    // About 160 long from nose to tail and 80 high, standing on the ground.
    let size = survey.size();
    assert!((130.0..190.0).contains(&size.z) && (60.0..100.0).contains(&size.y), "{survey:?}");
    assert!(survey.min.y.abs() < 3.0, "{survey:?}");
    let positions = |scene: &SceneDesc| scene.meshes[0].data.positions.clone();
    assert_eq!(positions(&model("Fox.glb")), positions(&fox("Survey", 0.0)));
    assert_eq!(positions(&fox("Walk", 0.2)), positions(&fox("1", 0.2)));
    let (a, b) = (positions(&fox("Run", 0.0)), positions(&fox("Run", 0.3)));
    let moved = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    assert!(moved > a.len() / 2, "{moved} of {}", a.len());
    // After its end an animation keeps its last pose.
    assert_eq!(positions(&fox("Run", 1e6)), positions(&fox("Run", 1e7)));
}

#[test]
fn pictures_and_sets_of_coordinates_are_there() {
    let multi = model("MultiUVTest.glb");
    assert_eq!((multi.images.len(), multi.cameras.len()), (2, 1));
    let data = &multi.meshes[0].data;
    assert_eq!((data.uvs.len(), data.more_uvs.len()), (data.positions.len(), 1));
    assert_ne!(data.uvs, data.more_uvs[0]);
    let colors = model("BoxVertexColors.glb");
    assert_eq!(colors.meshes[0].data.colors.len(), colors.meshes[0].data.positions.len());
    // The number of threads does not change the result.
    let with =
        |threads| load("TextureSettingsTest.glb", &ImportOptions { threads, ..ImportOptions::default() });
    assert_eq!(with(1), with(7));
    let small = ImportOptions { max_texture_size: Some(16), ..ImportOptions::default() };
    let small = load("TextureSettingsTest.glb", &small);
    assert!(small.images.iter().all(|i| i.data.width <= 16 && i.data.height <= 16));
}

#[test]
fn a_compressed_model_is_the_same_but_for_rounding() {
    // Positions, normals, weights, indices and animations are quantised, filtered and compressed by
    // EXT_meshopt_compression; positions and texture coordinates are quantised by KHR_draco_mesh_compression.
    let walk = ImportOptions { animation: Some("Walk".to_owned()), time: 0.37, ..ImportOptions::default() };
    let plain = load("Fox.glb", &walk);
    for name in ["FoxCompressed.glb", "FoxDraco.glb"] {
        is_the_same_but_for_rounding(&plain, &load(name, &walk));
    }
}

fn is_the_same_but_for_rounding(plain: &SceneDesc, packed: &SceneDesc) {
    let (a, b) = (bounds(plain), bounds(packed));
    assert!(near(a.min, b.min.to_array(), 0.1) && near(a.max, b.max.to_array(), 0.1), "{a:?} {b:?}");
    let (a, b) = (&plain.meshes[0].data, &packed.meshes[0].data);
    assert_eq!(a.triangles.len(), b.triangles.len());
    // The order of the triangles differs; compare the sums of areas and of texture coordinates.
    let sums = |mesh: &turner::schema::MeshData| {
        let (mut area, mut uv) = (0.0, 0.0);
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
            area += (b - a).cross(c - a).length();
            uv += t.iter().map(|v| f64::from(mesh.uvs[*v as usize][1])).sum::<f64>();
        }
        (area, uv)
    };
    let ((area_a, uv_a), (area_b, uv_b)) = (sums(a), sums(b));
    assert!((area_a - area_b).abs() < 2e-3 * area_a, "{area_a} {area_b}");
    assert!((uv_a - uv_b).abs() < 0.5, "{uv_a} {uv_b}");
}
