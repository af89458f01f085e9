//! Hostile file names, and files that must not be replaced.

use std::sync::Arc;

use turner::description::SceneDesc;
use turner::image::{Image, Pixels};
use turner::schema::{Asset, MeshData, Remedy};
use turner_io::assets::MemoryAssets;
use turner_io::convert::{ConvertOptions, to_toml};
use turner_io::scene::{LoadOptions, load_text};

use super::round_trip;

/// A scene with meshes and images whose files have these names.
fn called(names: &[&str]) -> SceneDesc {
    let mut text = String::new();
    for i in 0..names.len() {
        text += &format!(
            "[[object]]\nname = \"{i}\"\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, {i}.5, 0]]\ntriangles = [[0, 1, 2]]\n\
             material = {{ color = {{ type = \"image\", file = \"p{i}.png\" }} }}\n\n"
        );
    }
    let mut assets = MemoryAssets::default();
    for i in 0..names.len() as u8 {
        let image = Image { width: 1, height: 2, channels: 3, pixels: Pixels::U8(vec![i, 2, 3, 4, 5, 6]) };
        assets.files.insert(format!("p{i}.png"), turner_io::image::png::encode_samples(&image).unwrap());
    }
    let mut desc = load_text(text, "s.toml", &assets, &LoadOptions::default()).unwrap().desc;
    for (i, name) in names.iter().enumerate() {
        desc.images[i].uri = (*name).to_owned();
        // Used twice, so that the meshes are written to files.
        desc.meshes[i] = Asset { uri: (*name).to_owned(), data: Arc::clone(&desc.meshes[i].data) };
    }
    let twice = desc.objects.clone();
    desc.objects.extend(twice);
    for list in [&mut desc.textures] {
        for (thing, name) in list.iter_mut().zip(names) {
            thing.name = Some((*name).to_owned());
        }
    }
    for (thing, name) in desc.materials.iter_mut().zip(names) {
        thing.name = Some((*name).to_owned());
    }
    for (thing, name) in desc.objects.iter_mut().zip(names) {
        thing.name = Some((*name).to_owned());
    }
    desc
}

#[test]
fn hostile_names_stay_in_the_folder_and_come_back() {
    let long = "x".repeat(5000);
    let names = [
        "../../../etc/passwd",
        "/etc/passwd",
        "C:\\Windows\\win.ini",
        "\\\\server\\share",
        "file:///etc/passwd",
        "a\0b",
        "a\nb\r\n\u{1b}[31m",
        "con",
        "",
        ".",
        "..",
        "red",
        "red",
        "RED",
        "%2e%2e%2fx",
        "\u{202e}gpj.exe",
        "\"]]\n[film]\nwidth = 1",
        long.as_str(),
    ];
    let desc = called(&names);
    let (text, converted) = round_trip(&desc, &ConvertOptions::default(), "hostile names");
    for file in &converted.files {
        let name = file.path.file_name().unwrap().to_str().unwrap();
        assert!(
            name.len() <= 80 && !name.starts_with('.') && !name.contains(['%', ':', '\\', '"']),
            "{name}"
        );
        assert!(file.path.components().all(|c| c.as_os_str() != ".."), "{}", file.path.display());
    }
    // The header and the comments stay on one line each, whatever the names.
    assert!(!text.contains('\u{1b}') && !text.contains('\0'));
}

#[test]
fn the_source_s_name_cannot_leave_its_comment() {
    let options = ConvertOptions { source: "x\n[film]\nwidth = 7".into(), ..ConvertOptions::default() };
    let (text, _) = round_trip(&called(&["a"]), &options, "source");
    assert!(!text.contains("\nwidth = 7"));
}

#[test]
fn names_that_can_be_kept_are_kept() {
    let desc = called(&["wood", "Überzug", "a b"]);
    let (text, _) = round_trip(&desc, &ConvertOptions::default(), "names");
    for name in ["[material.wood]", "[material.\"Überzug\"]", "[texture.\"a b\"]"] {
        assert!(text.contains(name), "{name}\n{text}");
    }
}

#[test]
fn nothing_is_replaced_unasked() {
    let desc = called(&["a", "b"]);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("my scene.toml");
    let options = ConvertOptions::default();
    to_toml(&desc, &out, &options).unwrap();
    let refused = to_toml(&desc, &out, &options).unwrap_err();
    assert_eq!(refused.code.as_str(), "E0401");
    assert_eq!(refused.remedy.as_deref(), Some(&Remedy::Replace));
    // The scene file is gone, but its data files exist.
    std::fs::remove_file(&out).unwrap();
    assert_eq!(to_toml(&desc, &out, &options).unwrap_err().code.as_str(), "E0401");
    to_toml(&desc, &out, &ConvertOptions { overwrite: true, ..options }).unwrap();
    // No temporary file is left.
    let names =
        std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    assert!(names.into_iter().all(|n| !n.starts_with('.')));
}

#[test]
fn what_cannot_be_written_leaves_nothing_behind() {
    let mut desc = called(&["a", "b"]);
    desc.meshes[1].data =
        Arc::new(MeshData { triangles: vec![[0, 1, 9]], ..MeshData::clone(&desc.meshes[1].data) });
    let folder = tempfile::tempdir().unwrap();
    assert!(to_toml(&desc, &folder.path().join("s.toml"), &ConvertOptions::default()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn holes_in_lists_of_materials_and_all_of_a_mesh_come_back() {
    let mut desc = called(&["a"]);
    let mesh = MeshData {
        positions: (0..40).map(|i| [i as f32 * 0.1, (i % 7) as f32, 1.0 / (i + 1) as f32]).collect(),
        normals: (0..40).map(|i| [0.0, 0.6, if i % 2 == 0 { 0.8 } else { -0.8 }]).collect(),
        uvs: (0..40).map(|i| [i as f32 / 39.0, 0.3]).collect(),
        more_uvs: vec![(0..40).map(|i| [0.1, i as f32]).collect(), Vec::new(), vec![[0.5, 0.25]; 40]],
        tangents: vec![[1.0, 0.0, 0.0, -1.0]; 40],
        colors: (0..40).map(|i| [i as f32, 0.1, 0.2, 0.7]).collect(),
        triangles: (0..38).map(|i| [i, i + 1, i + 2]).collect(),
        face_materials: (0..38).map(|i| i as u16 % 3 * 300).collect(),
        polygons: Vec::new(),
        material_names: vec!["one".into(), " two\n%41 ".into(), String::new()],
        ..MeshData::default()
    };
    desc.meshes[0].data = Arc::new(mesh);
    let id = desc.objects[0].material;
    for object in &mut desc.objects {
        if let turner::description::ObjectContent::Shape(turner::shape::ShapeDesc::Mesh(m)) =
            &mut object.content
        {
            m.materials = vec![id, None, id];
            m.smooth = Some(true);
        }
    }
    round_trip(&desc, &ConvertOptions::default(), "all of a mesh");
}
