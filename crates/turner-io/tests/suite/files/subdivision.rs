//! Polygons of files, from the reader to the subdivided surface.

use turner::schema::PrepareOptions;
use turner_io::assets::MemoryAssets;
use turner_io::mesh::{decode, ply};
use turner_io::scene::{LoadOptions, load_text};

/// A cube of edges 2 with one face cut into triangles, another with an additional corner.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 9 7\nf 4 1 5 8\nf 5 6 7 9\nf 5 9 8\n";

#[test]
fn readers_keep_polygons() {
    let mesh = decode(CUBE.as_bytes(), "cube.obj").unwrap().mesh;
    assert_eq!(mesh.polygons, [2, 2, 2, 3, 2, 2, 1]);
    assert_eq!(mesh.fans().unwrap()[3], [2, 3, 7, 8, 6]);
    // PLY in both directions.
    let mut bytes = Vec::new();
    ply::write(&mesh, &mut bytes).unwrap();
    let again = decode(&bytes, "cube.ply").unwrap().mesh;
    assert_eq!(again, mesh);
    // Only triangles: no list of polygons.
    assert!(decode(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj").unwrap().mesh.polygons.is_empty());
    // A concave polygon: its corners in order, whatever its triangles are.
    let arrow = b"v 0 0 0\nv 2 1 0\nv 0 2 0\nv .5 1 0\nf 1 2 3 4\nf 1 2 3\n";
    let mesh = decode(arrow, "a.obj").unwrap().mesh;
    let corners = turner::schema::boundary(mesh.polygon_triangles().next().unwrap()).unwrap();
    let start = corners.iter().position(|c| *c == 0).unwrap();
    assert_eq!((0..4).map(|i| corners[(start + i) % 4]).collect::<Vec<_>>(), [0, 1, 2, 3]);
}

fn triangles(keys: &str) -> Result<u64, String> {
    let mut assets = MemoryAssets::default();
    assets.files.insert("cube.obj".into(), CUBE.into());
    let text = format!("[[object]]\ntype = \"mesh\"\n{keys}\n");
    let loaded = load_text(text, "s.toml", &assets, &LoadOptions::default());
    let desc = loaded.map_err(|e| e.error.message)?.desc;
    let prepared = desc.prepare(&PrepareOptions::default()).map_err(|e| e.message)?;
    Ok(prepared.scene.stats.triangles)
}

#[test]
fn scenes_subdivide_polygons() {
    // A quadrilateral for each corner of a face, four for each of those a level later.
    let corners = 4 * 5 + 5 + 3;
    assert_eq!(
        triangles("file = \"cube.obj\"\nsubdivision = \"catmull_clark\"\nlevels = 1"),
        Ok(2 * corners)
    );
    assert_eq!(triangles("file = \"cube.obj\"\nsubdivision = \"catmull_clark\""), Ok(2 * corners * 16));
    assert_eq!(triangles("file = \"cube.obj\"\nsubdivision = \"loop\"\nlevels = 2"), Ok(14 * 16));
    assert_eq!(triangles("file = \"cube.obj\""), Ok(14));
    let inline = "positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\npolygons = [[0, 1, 2, 3]]\n";
    assert_eq!(triangles(&format!("{inline}subdivision = \"catmull_clark\"\nlevels = 2")), Ok(32));
    for (keys, words) in [
        ("levels = 2", "`levels` has no effect without `subdivision`"),
        ("triangles = [[0, 1, 2]]", "either `triangles` or `polygons`"),
        ("subdivision = \"loop\"\ncreases = [[1, 3, 2]]", "which no edge joins"),
        ("subdivision = \"catmull_clark\"\nlevels = 11", "levels"),
    ] {
        let error = triangles(&format!("{inline}{keys}")).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    assert!(
        triangles("positions = [[0, 0, 0]]\npolygons = [[0, 0]]")
            .unwrap_err()
            .contains("polygon 0 of a mesh")
    );
}

/// A square in two triangles with (u, v), displaced by a picture of 2 x 1 pixels.
#[test]
fn scenes_displace_meshes() {
    let square = "positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\npolygons = [[0, 1, 2, 3]]\n";
    let uvs = "uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]\n";
    let heights = b"Pf\n2 1\n-1.0\n\0\0\0\0\0\0\x80\x3f";
    let prepared = |keys: &str| {
        let mut assets = MemoryAssets::default();
        assets.files.insert("h.pfm".into(), heights.to_vec());
        let text = format!("[[object]]\ntype = \"mesh\"\n{square}{keys}\n");
        let desc =
            load_text(text, "s.toml", &assets, &LoadOptions::default()).map_err(|e| e.error.message)?.desc;
        let prepared = desc.prepare(&PrepareOptions::default()).map_err(|e| e.message)?;
        Ok::<_, String>((prepared.scene.stats.triangles, prepared.scene.stats.bounds.unwrap()))
    };
    let displaced = format!("{uvs}displacement = \"h.pfm\"\n");
    let keys = format!("{displaced}displacement_scale = 3\ndisplacement_midlevel = 0.5\nedge_length = 0.25");
    let (triangles, bounds) = prepared(&keys).unwrap();
    assert!(triangles > 32, "{triangles}");
    assert!((bounds.min.z + 1.5).abs() < 1e-5 && (bounds.max.z - 1.5).abs() < 1e-5, "{bounds:?}");
    assert_eq!(prepared("edge_length = 0.5").unwrap().0, 16, "the diagonal is divided twice");
    for (keys, words) in [
        ("displacement = \"h.pfm\"", "has no (u, v)"),
        ("displacement_scale = 2", "`displacement_scale` has no effect without `displacement`"),
        ("displacement = \"missing.pfm\"", "missing.pfm"),
        ("edge_length = 0", "edge_length"),
    ] {
        let error = prepared(keys).unwrap_err();
        assert!(error.contains(words), "{keys}: {error}");
    }
}
