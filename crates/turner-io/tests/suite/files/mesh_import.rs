//! Complete scenes from OBJ with MTL, PLY and STL: files by other authors, and every statement that matters.

use std::collections::BTreeMap;
use std::path::Path;

use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::material::{AlphaMode, BumpUnit, MaterialDesc, PrincipledMaterial};
use turner::math::{DVec3, Ray};
use turner::schema::{ColorSource, MeshData, PrepareOptions, SceneError, WarningKind};
use turner::shape::ShapeDesc;
use turner::texture::{Encoding, ImageChannel, TextureDesc, Wrap};
use turner_io::assets::{FolderAssets, MemoryAssets};
use turner_io::image::{Display, ImageFormat, Metadata, OutputImage, Transfer, encode};
use turner_io::import::{ImportOptions, import};
use turner_io::scene::{LoadOptions, load_text};

pub(crate) fn import_with(
    files: &[(&str, Vec<u8>)],
    options: &ImportOptions,
) -> Result<SceneDesc, SceneError> {
    let mut assets = MemoryAssets::default();
    assets.files.extend(files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.clone())));
    import(files[0].1.clone(), files[0].0, &assets, options)
}

pub(crate) fn read(files: &[(&str, &str)]) -> SceneDesc {
    let files: Vec<_> = files.iter().map(|(name, text)| (*name, text.as_bytes().to_vec())).collect();
    import_with(&files, &ImportOptions::default()).unwrap()
}

pub(crate) fn mesh(scene: &SceneDesc) -> &MeshData {
    &scene.meshes[0].data
}

pub(crate) fn material<'a>(scene: &'a SceneDesc, name: &str) -> &'a PrincipledMaterial {
    let found = scene.materials.iter().find(|m| m.name.as_deref() == Some(name));
    match &found.unwrap_or_else(|| panic!("{name}: {:?}", scene.materials)).value {
        MaterialDesc::Principled(m) => m,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn said(scene: &SceneDesc, kind: WarningKind, words: &str) -> u64 {
    let found = scene.warnings.iter().filter(|w| w.kind == kind && w.message.contains(words));
    found.map(|w| w.count).sum()
}

pub(crate) fn constant(source: ColorSource) -> [f32; 3] {
    match source {
        ColorSource::Constant(c) => c.to_array(),
        ColorSource::Texture(_) => panic!("a texture"),
    }
}

fn picture(color: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let pixels: Vec<[u8; 4]> = (0..64).map(|i| color(i % 8, i / 8)).collect();
    let metadata = Metadata::new();
    let image = OutputImage {
        width: 8,
        height: 8,
        alpha: false,
        display: Some(Display::U8(&pixels)),
        transfer: Transfer::Srgb,
        metadata: &metadata,
        threads: 1,
        ..OutputImage::default()
    };
    encode(&image, ImageFormat::of_path(Path::new("a.png")).unwrap()).unwrap()
}

#[test]
fn files_of_other_people() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/mesh");
    let assets = FolderAssets::new(&folder).unwrap();
    // Vertices, triangles, materials.
    let expected: BTreeMap<&str, [u64; 3]> = [
        ("20mm-xyz-cube.stl", [132, 260, 1]),
        ("BoxTextured.ply", [24, 12, 1]),
        ("cornell_box.obj", [76, 36, 4]),
        ("cube-vertexcol.obj", [8, 12, 3]),
        ("cube.obj", [8, 12, 3]),
        ("cube_blender_uv.ply", [24, 12, 1]),
        ("cube_compressed.obj", [24, 12, 1]),
        ("issue-92.obj", [3, 1, 1]),
        ("missing_material_file.obj", [76, 36, 4]),
        ("mtllib-multiple-files-issue-112.obj", [3, 1, 1]),
        ("multi.ply", [4, 2, 1]),
        ("multibody.stl", [20, 32, 2]),
        ("negative_indices.obj", [24, 12, 1]),
        ("no_material.obj", [76, 36, 1]),
        ("octagonal_pocket.ply", [1658, 3262, 1]),
        ("plane_tri.ply", [4, 2, 1]),
        ("points_ascii.ply", [5, 0, 1]),
        ("polygonfaces.obj", [5, 3, 1]),
        ("refl.obj", [8, 12, 3]),
        ("smoothing-normal.obj", [12, 6, 1]),
        ("teapot.stl", [480, 894, 1]),
        ("test-nan.obj", [76, 34, 4]),
        ("texture-options-issue-85.obj", [3, 1, 1]),
        ("usemtl-issue-68.obj", [676, 400, 2]),
    ]
    .into();
    let mut found = BTreeMap::new();
    for name in expected.keys() {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let scene =
            import(bytes, name, &assets, &ImportOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let data = mesh(&scene);
        data.check().unwrap();
        assert_eq!(scene.imports[0].file, *name);
        let prepared = scene.prepare(&PrepareOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(prepared.scene.stats.bounds.is_some_and(|b| b.is_finite()), "{name}");
        let count = [data.positions.len(), data.triangles.len(), scene.materials.len()].map(|n| n as u64);
        found.insert(*name, count);
    }
    assert_eq!(found, expected);
}

#[test]
fn what_is_missing_is_reported_and_no_reason_to_stop() {
    let text = "mtllib a.mtl my lib.mtl no.mtl more\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\nusemtl y\nf 1 2 3\nusemtl z\nf 1 2 3\n\
                l 1 2\np 1\np 2\nf 1 2\nsurf 0 1 0 1 1 2\nwhat is this\n";
    let scene = read(&[
        ("sub/a.obj", text),
        (
            "sub/a.mtl",
            "newmtl x\nKd 1 0 0\nmap_Kd missing.png\nmap_Kd C:\\textures\\gone.png\ndisp d.png\nfoo 1\n",
        ),
        ("sub/my lib.mtl", "newmtl y\nKd 0 1 0\n"),
    ]);
    assert_eq!(constant(material(&scene, "x").base_color), [1.0, 0.0, 0.0]);
    assert_eq!(constant(material(&scene, "y").base_color), [0.0, 1.0, 0.0]);
    assert_eq!(constant(material(&scene, "z").base_color), [0.8; 3]);
    for (words, count) in [
        ("material library", 2),
        ("the image ", 1),
        ("materials without a definition", 1),
        ("`disp`", 1),
        ("`foo`", 1),
        ("(points)", 2),
        ("(lines)", 1),
        ("fewer than three", 1),
        ("free-form", 1),
        ("unknown statements", 1),
    ] {
        assert_eq!(said(&scene, WarningKind::Ignored, words), count, "{words}: {:?}", scene.warnings);
    }
}

#[test]
fn classic_keys_become_physical_ones() {
    let mtl = "newmtl dull\nKd 0.5 0.5 0.5\nKs 0 0 0\nillum 2\n\
               newmtl shiny\nKd 0.1 0.2 0.3\nKs 0.5 0.25 0.25\nNs 14\nillum 2\n\
               newmtl flat\nKd 1 1 1\nKs 1 1 1\nillum 1\n\
               newmtl mirror\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\n\
               newmtl glass\nKd 1 1 1\nNi 1.52\nTf 0.9 1 0.9\nillum 7\n\
               newmtl pane\nKd 1 1 1\nd 0.25\nNi 1.3\n\
               newmtl veil\nKd 1 1 1\nTr 0.75\nNi 1\n\
               newmtl bulb\nKd 1 1 1\nKe 5 4 3\n\
               newmtl old\nKd 1 1 1\nKa 20 20 20\n\
               newmtl pbr\nKd 1 0.5 0\nKs 0 0 0\nNs 10\nPr 0.4\nPm 1\nPs 0.2\nPc 0.7\nPcr 0.1\naniso 0.5\nanisor 0.25\n";
    let names = ["dull", "shiny", "flat", "mirror", "glass", "pane", "veil", "bulb", "old", "pbr"];
    let faces: String = names.iter().map(|n| format!("usemtl {n}\nf 1 2 3\n")).collect();
    let obj = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    let scene = read(&[("a.obj", &obj), ("a.mtl", mtl)]);
    let get = |name: &str| material(&scene, name);
    let grey = |source: ColorSource| constant(source)[0];
    assert_eq!(grey(get("dull").specular_weight), 0.0);
    let shiny = get("shiny");
    assert_eq!((grey(shiny.specular_weight), constant(shiny.specular_color)), (1.0, [1.0, 0.5, 0.5]));
    // (2 / 16)^(1/4).
    assert!((grey(shiny.specular_roughness) - 0.594_603_55).abs() < 1e-6);
    assert_eq!(grey(get("flat").specular_weight), 0.0);
    let mirror = get("mirror");
    assert_eq!((grey(mirror.base_metalness), grey(mirror.specular_roughness)), (1.0, 0.0));
    assert_eq!(constant(mirror.base_color), [0.9, 0.8, 0.7]);
    let glass = get("glass");
    assert_eq!((grey(glass.transmission_weight), glass.specular_ior), (1.0, f64::from(1.52_f32)));
    assert_eq!((constant(glass.transmission_color), grey(glass.opacity)), ([0.9, 1.0, 0.9], 1.0));
    assert_eq!((grey(get("pane").transmission_weight), grey(get("pane").opacity)), (0.75, 1.0));
    let veil = get("veil");
    assert_eq!(
        (grey(veil.opacity), veil.alpha_mode, grey(veil.transmission_weight)),
        (0.25, AlphaMode::Blend, 0.0)
    );
    for (name, color) in [("bulb", [5.0, 4.0, 3.0]), ("old", [20.0; 3])] {
        assert_eq!((get(name).emission_luminance, constant(get(name).emission_color)), (1.0, color));
    }
    let pbr = get("pbr");
    assert_eq!((grey(pbr.base_metalness), grey(pbr.specular_roughness)), (1.0, 0.4));
    assert_eq!((grey(pbr.specular_weight), grey(pbr.fuzz_weight), grey(pbr.coat_weight)), (1.0, 0.2, 0.7));
    assert_eq!((grey(pbr.coat_roughness), grey(pbr.specular_roughness_anisotropy)), (0.1, 0.5));
    assert_eq!(pbr.anisotropy_rotation, 90.0);
    assert_eq!(said(&scene, WarningKind::Approximated, "glass"), 1);
    assert_eq!(said(&scene, WarningKind::Approximated, "`Ka`"), 1);
    scene.prepare(&PrepareOptions::default()).unwrap();
}

#[test]
fn pictures_of_materials_with_their_options() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\n";
    let mtl = "newmtl a\nKd 0 0 0\nmap_Kd -s 2 3 -o 0.5 0.25 -clamp on -mm 0.1 0.5 C:\\work\\red.png\nmap_Pr -imfchan g data.png\n\
               map_Bump -bm 0.5 normals.png\nmap_d mask.png\n\
               newmtl b\nKd 0.5 1 1\nmap_Kd red.png\nmap_bump heights.png\nmap_d soft.png\nnorm normals.png\nrefl sky.png\n";
    let files = [
        ("a.obj", obj.as_bytes().to_vec()),
        ("a.mtl", mtl.as_bytes().to_vec()),
        ("red.png", picture(|_, _| [200, 10, 10, 255])),
        ("data.png", picture(|x, y| [0, (x * 30) as u8, (y * 30) as u8, 255])),
        ("normals.png", picture(|x, _| [120 + 2 * x as u8, 128, 250, 255])),
        ("heights.png", picture(|x, _| [(x * 30) as u8; 4])),
        ("mask.png", picture(|x, _| if x < 4 { [0; 4] } else { [255; 4] })),
        ("soft.png", picture(|x, _| [60 + 10 * x as u8; 4])),
    ];
    let scene = import_with(&files, &ImportOptions::default()).unwrap();
    let (a, b) = (material(&scene, "a"), material(&scene, "b"));
    let texture = |source: ColorSource| match source {
        ColorSource::Texture(id) => match &scene.textures[id.index()].value {
            TextureDesc::Image(image) => image.clone(),
            other => panic!("{other:?}"),
        },
        ColorSource::Constant(c) => panic!("{c:?}"),
    };
    let red = texture(a.base_color);
    assert_eq!(red.uv_matrix, Some([2.0, 0.0, 0.5, 0.0, 3.0, 0.25]));
    assert_eq!((red.wrap, red.tint, red.offset), (Wrap::Clamp, Spectrum::grey(0.5), Spectrum::grey(0.1)));
    assert_eq!(texture(a.specular_roughness).channel, ImageChannel::G);
    assert_eq!(
        (texture(a.normal_map.unwrap()).file, a.normal_scale),
        (texture(b.normal_map.unwrap()).file, 0.5)
    );
    assert_eq!((a.alpha_mode, b.alpha_mode), (AlphaMode::Mask, AlphaMode::Blend));
    let other = texture(b.base_color);
    assert_eq!((other.file, other.tint, other.uv_matrix), (red.file, Spectrum::new(0.5, 1.0, 1.0), None));
    assert_eq!((a.bump_map, b.bump_unit, b.bump_scale), (None, BumpUnit::Tile, 0.02));
    assert_eq!(texture(b.bump_map.unwrap()).encoding, Encoding::Linear);
    assert_eq!(said(&scene, WarningKind::Approximated, "bump maps"), 1);
    // Each file once: red, data, normals, mask, soft, heights.
    assert_eq!(scene.images.len(), 6);
    assert_eq!(said(&scene, WarningKind::Approximated, "images missing at their path"), 1);
    assert_eq!(said(&scene, WarningKind::Approximated, "normal maps"), 1);
    assert_eq!(said(&scene, WarningKind::Ignored, "`refl`"), 1);
    scene.prepare(&PrepareOptions::default()).unwrap();
}

#[test]
fn smoothing_groups_make_normals_within_them() {
    // Three sides of a roof along z.
    let roof = "v -1 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 1\nv 0 1 1\nv 1 0 1\n";
    let normals = |faces: &str| mesh(&read(&[("a.obj", &format!("{roof}{faces}"))])).normals.clone();
    let left = "f 1 2 5 4\n";
    let right = "f 2 3 6 5\n";
    assert!(normals(&format!("{left}{right}")).is_empty());
    assert!(normals(&format!("s off\n{left}s 0\n{right}")).is_empty());
    let smooth = normals(&format!("s 1\n{left}{right}"));
    assert_eq!(smooth.len(), 6);
    let ridge = smooth.iter().filter(|n| n[0].abs() < 1e-6 && (n[1].abs() - 1.0).abs() < 1e-6).count();
    assert_eq!(ridge, 2, "{smooth:?}");
    // Two groups have separate normals; faces without a group are flat.
    for faces in [format!("s 1\n{left}s 2\n{right}"), format!("s 1\n{left}s off\n{right}")] {
        let apart = normals(&faces);
        assert!(apart.len() >= 8 && apart.iter().all(|n| n[0].abs() > 0.7), "{apart:?}");
    }
    // Normals in the file take precedence.
    let given = normals(&format!("vn 0 0 1\ns 1\nf 1//1 2//1 5//1\n{right}"));
    assert_eq!(given.iter().filter(|n| **n == [0.0, 0.0, 1.0]).count(), 3);
}

#[test]
fn objects_and_groups_are_picked_by_name() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\no box lid\ng a b\nusemtl x\nf 1 2 4\ng\nf 1 3 4\no base\nf 2 3 4\ng a\nf 2 4 3\n";
    let pick = |nodes: &[&str]| {
        let options =
            ImportOptions { nodes: nodes.iter().map(|n| (*n).to_owned()).collect(), ..Default::default() };
        import_with(&[("a.obj", text.as_bytes().to_vec())], &options)
    };
    let count = |nodes: &[&str]| mesh(&pick(nodes).unwrap()).triangles.len();
    assert_eq!((count(&[]), count(&["box lid"]), count(&["base"])), (5, 2, 2));
    assert_eq!((count(&["a"]), count(&["b"]), count(&["b", "base"])), (2, 1, 3));
    let error = pick(&["bass"]).unwrap_err();
    assert!(error.message.contains("\"bass\"") && error.help.unwrap().contains("base"));
}

#[test]
fn colours_and_weights_of_vertices() {
    let faces = "f 1 2 3\n";
    let colors = |text: &str| mesh(&read(&[("a.obj", &format!("{text}{faces}"))])).colors.clone();
    assert!(colors("v 0 0 0\nv 1 0 0 1\nv 0 1 0 2\n").is_empty());
    let three = colors("v 0 0 0\nv 1 0 0 0.5 0.25 0\nv 0 1 0 1 0 0.5 0\n");
    assert_eq!(three, [[1.0; 4], [0.5, 0.25, 0.0, 1.0], [0.0, 0.5, 0.0, 1.0]]);
    let scene = read(&[("a.obj", "v 0 0 0 1 0 0\nv 2 0 0 1 0 0\nv 0 2 0 1 0 0\nf 1 2 3\n")]);
    let ColorSource::Texture(id) = (match &scene.materials[0].value {
        MaterialDesc::Principled(m) => m.base_color,
        other => panic!("{other:?}"),
    }) else {
        panic!("no colours")
    };
    assert!(matches!(scene.textures[id.index()].value, TextureDesc::VertexColor(_)));
}

#[test]
fn line_ends_comments_and_continued_lines() {
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl my paint\nf 1 2 3\nf 2 4 3\n";
    let expected = read(&[("a.obj", plain)]);
    for text in [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace(' ', "\t"),
        plain.replace(' ', "   "),
        plain.replace(" 0\n", " 0 # x y\n"),
        plain.replace("f 1", "f\\\n  1").replace("2 4", "2\\\r\n4"),
        plain.replace("my paint", "my \\\npaint # no"),
        format!("\u{feff}# c \\\nv 9 9 9\n{plain}"),
        plain.trim_end().to_owned(),
        format!("{plain}\\"),
    ] {
        let scene = read(&[("a.obj", &text)]);
        assert_eq!(mesh(&scene), mesh(&expected), "{text:?}");
        assert_eq!(scene.materials[0].name, expected.materials[0].name, "{text:?}");
    }
}

#[test]
fn a_large_obj_is_the_same_for_any_number_of_threads() {
    use std::fmt::Write;
    let mut text = String::new();
    let side = 160_u32;
    for i in 0..side * side {
        let (x, z) = (i % side, i / side);
        writeln!(
            text,
            "v {}.{:06} {}e-3 -{}.5\nvt 0.{:04} 0.{:04}\nvn 0 1 0.{:03}",
            x,
            i % 1_000_000,
            i % 997,
            z,
            x,
            z,
            i % 1000
        )
        .unwrap();
        if x > 0 && z > 0 {
            writeln!(
                text,
                "g part{}\nusemtl m{}\ns {}\nf -1/-1/-1 -2/-2/-2 {}/{}/{} {}//{}",
                i / 5000,
                i % 3,
                i % 2,
                i - side,
                i - side,
                i - side,
                i - side + 1,
                i - side + 1
            )
            .unwrap();
        }
    }
    // The file is parsed in several chunks.
    assert!(text.len() > 3 << 20, "{}", text.len());
    let bytes = text.into_bytes();
    let read = |threads| {
        let options = ImportOptions { threads, ..Default::default() };
        import_with(&[("a.obj", bytes.clone())], &options).unwrap()
    };
    let one = read(1);
    assert_eq!(mesh(&one), mesh(&read(5)));
    assert_eq!(mesh(&one).triangles.len(), 2 * 159 * 159);
    assert_eq!(one.materials.len(), 3);
    assert!(one.imports[0].counts.contains(&("groups", 6)), "{:?}", one.imports);
    let p = mesh(&one).positions[mesh(&one).triangles[0][0] as usize];
    assert_eq!(p, [1.000_161, 0.161, -1.5]);
    // Errors far into the file report their line.
    let mut bad = bytes.clone();
    bad.extend_from_slice(b"f 1 2 99999999\n");
    let lines = bad.iter().filter(|&&b| b == b'\n').count();
    let error = import_with(&[("a.obj", bad)], &ImportOptions::default()).unwrap_err();
    assert!(
        error.message.contains(&format!(
            "line {lines}: face {} refers to vertex 99999999, but there are 25600",
            159 * 159 + 1
        )),
        "{error}"
    );
    let mut bad = bytes;
    bad.extend_from_slice(b"v 1 2 x\n");
    let error = import_with(&[("a.obj", bad)], &ImportOptions::default()).unwrap_err();
    assert!(error.message.contains(&format!("line {lines}: expected `v x y z`")), "{error}");
}

#[test]
fn ply_colours_strips_corners_with_their_own_uv_and_pictures() {
    let head = "ply\nformat ascii 1.0\ncomment TextureFile my picture.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let points = "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n1 1 0 255 255 255\n";
    let colors = "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n";
    let strips = format!(
        "{head}{colors}element tristrips 1\nproperty list int int vertex_indices\nend_header\n{points}8 0 1 2 3 -1 3 1 0\n"
    );
    let scene = read(&[("a.ply", &strips)]);
    assert_eq!(mesh(&scene).triangles, [[0, 1, 2], [2, 1, 3], [3, 1, 0]]);
    assert_eq!(mesh(&scene).colors[1], [0.0, 1.0, 0.0, 1.0]);
    let plain = points
        .replace(" 255 0 0\n", "\n")
        .replace(" 0 255 0\n", "\n")
        .replace(" 0 0 255\n", "\n")
        .replace(" 255 255 255\n", "\n");
    let wedges = format!(
        "{head}element face 2\nproperty list uchar uint vertex_indices\nproperty list uchar float texcoord\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nend_header\n{plain}3 0 1 2 6 0 0 1 0 0 1 9 9 9\n3 1 3 2 6 0.5 0 1 1 0 1 9 9 9\n"
    );
    let files = [("a.ply", wedges.into_bytes()), ("my picture.png", picture(|_, _| [9; 4]))];
    let scene = import_with(&files, &ImportOptions::default()).unwrap();
    // Vertex 1 has two (u, v); vertex 2 has one.
    assert_eq!((mesh(&scene).positions.len(), mesh(&scene).uvs[3]), (5, [0.5, 0.0]));
    let ColorSource::Texture(id) = (match &scene.materials[0].value {
        MaterialDesc::Principled(m) => m.base_color,
        other => panic!("{other:?}"),
    }) else {
        panic!("no picture")
    };
    assert!(matches!(scene.textures[id.index()].value, TextureDesc::Image(_)));
    assert_eq!(said(&scene, WarningKind::Ignored, "face colours"), 1);
    // A concave quad is cut along its shorter diagonal.
    let arrow = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\n\
                 end_header\n0 0 0\n2 1 0\n0 2 0\n0.5 1 0\n4 0 1 2 3\n";
    let scene = read(&[("a.ply", arrow)]);
    assert!(
        mesh(&scene).triangles.iter().all(|t| t.contains(&1) && t.contains(&3)),
        "{:?}",
        mesh(&scene).triangles
    );
}

#[test]
fn a_cloud_of_points_is_shown_as_spheres() {
    let cloud = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
                 property uchar blue\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\nnan 0 0 1 1 1\n1 1 0 255 255 255\n";
    let scene = read(&[("a.ply", cloud)]);
    assert!(matches!(&scene.objects[0].content, ObjectContent::Shape(ShapeDesc::Points(_))));
    assert_eq!(mesh(&scene).positions.len(), 4);
    assert_eq!(said(&scene, WarningKind::Doubtful, "points with NaN"), 1);
    let mut assets = MemoryAssets::default();
    assets.files.insert("a.ply".into(), cloud.into());
    for object in ["type = \"points\"\nfile = \"a.ply\"\nradius = 0.75", "type = \"model\"\nfile = \"a.ply\""]
    {
        let text = format!("[[light]]\ntype = \"ambient\"\n[[object]]\n{object}\n");
        let desc = load_text(text, "s.toml", &assets, &LoadOptions::default()).unwrap().desc;
        let scene = desc.prepare(&PrepareOptions::default()).unwrap().scene;
        // Neighbours are 1 apart, so the radius is 0.75.
        let hit = scene.intersect(&Ray::new(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z)).unwrap();
        assert!((hit.shape.t - 4.25).abs() < 1e-9, "{object}: {}", hit.shape.t);
    }
    let text = "[[object]]\ntype = \"mesh\"\nfile = \"a.ply\"\n".to_owned();
    let error = load_text(text, "s.toml", &assets, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("4 vertices but no faces") && error.contains("type = \"points\""), "{error}");
}
