//! Seeds: one small valid file per format that Turner reads, with a scene that shows it.
//!
//! They have two uses. Tests of damaged files change the bytes of each seed and expect an error or a picture,
//! never a panic or a hang. Fuzzers begin with them, so that they reach the parsers behind magic numbers and
//! headers. An image, a mesh or a light profile is not a scene, so its seed comes with one that names it; files
//! that seeds name in turn are [`companions`]. All seeds are tiny: a corrupted count must exceed what the file
//! can hold. A format without a seed fails `every_format_has_a_seed`.

use crate::image::{Display, ImageFormat, Metadata, OutputImage, Transfer, encode};

/// A small file.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Its name.
    pub name: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Name and text of a scene that shows it; `None` if the file is a scene or a model itself.
    pub scene: Option<(&'static str, String)>,
}

/// All seeds.
pub fn seeds() -> Vec<Seed> {
    let alone = |name, bytes: &[u8]| Seed { name, bytes: bytes.to_vec(), scene: None };
    let shown = |name, bytes: Vec<u8>, text: String| Seed { name, bytes, scene: Some(("show.toml", text)) };
    let mut all = vec![
        alone("scene.toml", SCENE.as_bytes()),
        alone("model.gltf", gltf().as_bytes()),
        alone("model.glb", &glb()),
        alone("draco.glb", &super::draco_seed::draco_glb()),
        alone("model.obj", OBJ.as_bytes()),
        shown("model.mtl", MTL.into(), model("cube.obj")),
        alone("text.ply", PLY.as_bytes()),
        alone("binary.ply", &binary_ply()),
        alone("text.stl", STL.as_bytes()),
        alone("binary.stl", &binary_stl()),
        shown("fur.hair", hair(), fur()),
        alone("scene.pbrt", PBRT.as_bytes()),
        alone("packed.pbrt", &gzip(PBRT.as_bytes())),
        shown("lamp.ies", IES.into(), lamp()),
        shown("paint.bsdf", bsdf(), painted()),
        shown("cloud.grid", crate::grid::encode([2, 2, 2], &[0.5; 8], Some(&[0.1; 8])), cloud()),
        shown("cloud.vdb", super::vdb_seed::seed(), cloud().replace("cloud.grid", "cloud.vdb")),
        shown(
            "cloud.nvdb",
            include_bytes!("cloud.nvdb").to_vec(),
            cloud().replace("cloud.grid", "cloud.nvdb"),
        ),
        shown("font.ttf", include_bytes!("font.ttf").to_vec(), words("font.ttf")),
        shown("font.otf", include_bytes!("font.otf").to_vec(), words("font.otf")),
        Seed {
            name: "metal.spd",
            bytes: "# nm, n\n300 1.2\n500 0.9\n700 0.4\n".into(),
            scene: Some(("show.pbrt", SPECTRAL.to_owned())),
        },
    ];
    all.extend(super::mitsuba_seeds::seeds());
    let pixels: Vec<[u8; 4]> = (0..64u8).map(|i| [4 * i, 255 - i, i ^ 21, 200]).collect();
    let light: Vec<[f32; 4]> = pixels.iter().map(|p| p.map(|v| f32::from(v) / 64.0)).collect();
    let metadata = Metadata::new();
    for (name, format) in [
        ("picture.png", ImageFormat::Png),
        ("picture.exr", ImageFormat::Exr),
        ("picture.hdr", ImageFormat::Hdr),
        ("picture.jpg", ImageFormat::Jpeg),
    ] {
        let image = OutputImage {
            width: 8,
            height: 8,
            alpha: true,
            linear: Some(&light),
            display: Some(Display::U8(&pixels)),
            transfer: Transfer::Srgb,
            metadata: &metadata,
            threads: 1,
            ..OutputImage::default()
        };
        // Each of these formats accepts this image.
        let Ok(bytes) = encode(&image, format) else { continue };
        all.push(shown(name, bytes, texture(name)));
    }
    for (name, format) in [
        ("picture.webp", image::ImageFormat::WebP),
        ("picture.tga", image::ImageFormat::Tga),
        ("picture.bmp", image::ImageFormat::Bmp),
    ] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = image::RgbaImage::from_raw(8, 8, pixels.concat());
        let Some(Ok(())) = picture.map(|picture| picture.write_to(&mut bytes, format)) else { continue };
        all.push(shown(name, bytes.into_inner(), texture(name)));
    }
    let mut pfm = b"PF\n8 8\n-1.0\n".to_vec();
    pfm.extend(light.iter().flat_map(|[r, g, b, _]| [r, g, b].map(|v| v.to_le_bytes())).flatten());
    all.push(shown("picture.pfm", pfm, texture("picture.pfm")));
    // Made with the basisu encoder from 8 x 8 pixels with alpha.
    let ktx2 = include_bytes!("etc1s.ktx2").to_vec();
    all.push(shown("picture.ktx2", ktx2, texture("picture.ktx2")));
    let png = all.iter().find(|s| s.name == "picture.png").map(|s| s.bytes.clone()).unwrap_or_default();
    all.extend(super::usd_seed::seeds(&png));
    all
}

/// Files that the seeds name.
pub fn companions() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("cube.obj", format!("mtllib model.mtl\nusemtl red\n{OBJ}").into_bytes()),
        ("part.toml", b"[material.grey]\ncolor = \"grey\"\n".to_vec()),
    ]
}

/// An image as texture of a rectangle and as environment map.
fn texture(file: &str) -> String {
    format!(
        "[integrator]\ntype = \"path\"\n[texture.t]\ntype = \"image\"\nfile = \"{file}\"\n[[object]]\ntype = \"rectangle\"\n\
         material = {{ color = \"t\" }}\n[[light]]\ntype = \"environment\"\nfile = \"{file}\"\n"
    )
}

/// Three curves of three points with widths and colours.
fn hair() -> Vec<u8> {
    let data = turner::schema::MeshData {
        positions: (0..9_u8).map(|i| [f32::from(i / 3), f32::from(i % 3), 0.1 * f32::from(i)]).collect(),
        widths: vec![0.1; 9],
        colors: vec![[0.6, 0.4, 0.2, 1.0]; 9],
        strands: vec![3; 3],
        ..Default::default()
    };
    let mut out = Vec::new();
    // Writing to a vector does not fail.
    let _ = crate::mesh::hair::write(&data, &mut out);
    out
}

fn fur() -> String {
    "[[object]]\ntype = \"curves\"\nfile = \"fur.hair\"\nmaterial = { type = \"hair\", color = { type = \"vertex-color\" } }\n\
     [integrator]\ntype = \"path\"\n[[light]]\ntype = \"ambient\"\n"
        .to_owned()
}

fn words(file: &str) -> String {
    format!(
        "[[object]]\ntype = \"text\"\ntext = \"Io +=\\n-oI\"\nfont = \"{file}\"\n[[light]]\ntype = \"ambient\"\n"
    )
}

fn model(file: &str) -> String {
    format!("[[object]]\ntype = \"model\"\nfile = \"{file}\"\n[[light]]\ntype = \"ambient\"\n")
}

fn lamp() -> String {
    "[[object]]\ntype = \"sphere\"\n[[light]]\ntype = \"point\"\nposition = [0, 3, 2]\nies = \"lamp.ies\"\n"
        .to_owned()
}

/// A grey BRDF.
fn bsdf() -> Vec<u8> {
    let mut out = Vec::new();
    // Writing to a vector does not fail.
    let _ = crate::measured::write(&turner::schema::MeasuredFile::default().data, &mut out);
    out
}

fn painted() -> String {
    "[integrator]\ntype = \"path\"\n[[object]]\ntype = \"sphere\"\nmaterial = { type = \"measured\", file = \"paint.bsdf\" }\n\
     [[light]]\ntype = \"ambient\"\n"
        .to_owned()
}

fn cloud() -> String {
    "[integrator]\ntype = \"path\"\n[medium.m]\ntype = \"grid\"\nfile = \"cloud.grid\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
     extinction = 3\n[[object]]\ntype = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmedium = \"m\"\n\
     [[light]]\ntype = \"point\"\nposition = [3, 3, 3]\n"
        .to_owned()
}

const SCENE: &str = "include = \"part.toml\"\n[film]\nwidth = 16\nheight = 0x0c\n[camera]\nposition = [0, 1.5, 6]\n\
look_at = [0, 1, 0]\n[texture.a]\ntype = \"checkerboard\"\n[material.m]\ncolor = 'a'\nk_reflect = 0.3\n[[object]]\n\
type = \"sphere\"\nmaterial = \"m\"\ntransform = [{ scale = 2 }, { rotate = { axis = [0, 1, 0], angle = 30 } },]\n\
[[group.g.object]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\"material\" = \"grey\" # \u{e9}\n\
[[object]]\ntype = \"instance\"\ngroup = \"g\"\ntransform = [{ translate = [1e0, 0, -1] }]\n\
[[object]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]\n\
[[light]]\ntype = \"point\"\nposition = [5, 8, 5]\n";

const OBJ: &str = "o cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\ng side\n\
f 1/1/1 2/2/1 3/3/1 4\nf -4 -3 -2\ns 1\nl 1 2\n";

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nKs 0.2 0.2 0.2\nNs 40\nd 0.9\nmap_Kd -s 2 2 1 picture.png\nPr 0.3\nKe 0 0 0\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n\
property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 9 9 9\n3 0 1 2\n\
4 0 1 2 3\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
property float z\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
            .to_vec();
    [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    for face in [[0i32, 1, 2], [2, 1, 0]] {
        bytes.push(3);
        face.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    }
    bytes
}

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
endsolid a\n";

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(2u32.to_le_bytes());
    for i in 0..2u8 {
        let z = f32::from(i);
        for v in [0.0, 0.0, 1.0, 0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z] {
            bytes.extend(v.to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

const PBRT: &str = "LookAt 0 0 5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [40]\nFilm \"rgb\" \"integer xresolution\" [16]\n\
\"integer yresolution\" [12]\nWorldBegin\nAttributeBegin\nLightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 4 4]\n\
AttributeEnd\nTexture \"c\" \"spectrum\" \"checkerboard\" \"float uscale\" [4]\nMaterial \"diffuse\" \"texture reflectance\" \"c\"\n\
ObjectBegin \"o\"\nShape \"sphere\" \"float radius\" [0.5]\nObjectEnd\nTranslate 1 0 0\nObjectInstance \"o\"\n\
Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";

const SPECTRAL: &str = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n\
Material \"conductor\" \"spectrum eta\" \"metal.spd\" \"spectrum k\" \"metal.spd\"\nTranslate 0 0 4\nShape \"sphere\"\n";

const IES: &str = "IESNA:LM-63-2002\n[TEST] by hand\nTILT=NONE\n1 1000 1 3 2 1 2 0 0 0\n1 1 50\n0 45 90\n0 90\n\
100 80 10\n100 70 5\n";

/// `data` compressed with gzip.
pub fn gzip(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 0xff];
    out.extend(miniz_oxide::deflate::compress_to_vec(data, 6));
    out.extend([0; 4]);
    out.extend((data.len() as u32).to_le_bytes());
    out
}

/// The binary buffer of a glTF model: three positions, three indices, padding.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    [0u16, 1, 2, 0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

/// A glTF document with this description of its buffer.
fn document(buffer: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,2]}}],
"nodes":[{{"name":"root","children":[1],"translation":[0,1,0]}},{{"mesh":0,"rotation":[0,0,0,1]}},{{"camera":0,
"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,4,1]}}],"cameras":[{{"type":"perspective","perspective":{{"yfov":0.7,"znear":0.1}}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.8,0.2,0.1,1],"roughnessFactor":0.4}},
"extensions":{{"KHR_materials_ior":{{"ior":1.4}}}}}}],"extensionsUsed":["KHR_materials_ior"],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
"buffers":[{{{buffer}"byteLength":44}}]}}"#
    )
}

fn gltf() -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in buffer().chunks(3) {
        let value = three.iter().fold(0u32, |sum, b| sum << 8 | u32::from(*b)) << (8 * (3 - three.len()));
        for i in 0..4 {
            let digit = DIGITS[(value >> (18 - 6 * i) & 63) as usize];
            text.push(if i > three.len() { '=' } else { char::from(digit) });
        }
    }
    document(&format!("\"uri\":\"data:application/octet-stream;base64,{text}\","))
}

fn glb() -> Vec<u8> {
    glb_of(&document(""), &buffer())
}

/// A GLB file from its JSON and binary chunks.
pub fn glb_of(json: &str, chunk: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunk = chunk.to_vec();
    chunk.resize(chunk.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + chunk.len();
    let mut out = [&b"glTF"[..], &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &chunk)] {
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(bytes);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::MemoryAssets;
    use crate::scene::{LoadOptions, SceneFormat, load_text};

    /// Formats without a seed are not tested with damaged files.
    #[test]
    fn every_format_has_a_seed() {
        let pictures = ImageFormat::all().map(|f| (f.name(), f.extensions()));
        let scenes = SceneFormat::all().map(|f| (f.name(), f.extensions()));
        for (name, extensions) in pictures.chain(scenes) {
            let is = |seed: &Seed| seed.name.rsplit_once('.').is_some_and(|(_, e)| extensions.contains(&e));
            assert!(seeds().iter().any(is), "no seed is a file of the format {name}");
        }
    }

    #[test]
    fn every_seed_is_a_scene() {
        let all = seeds();
        let mut assets = MemoryAssets::default();
        assets.files.extend(companions().into_iter().map(|(n, b)| (n.to_owned(), b)));
        assets.files.extend(all.iter().map(|s| (s.name.to_owned(), s.bytes.clone())));
        for seed in &all {
            let text = match &seed.scene {
                Some((name, text)) if name.ends_with(".toml") => text.clone(),
                Some((name, text)) => {
                    assets.files.insert((*name).to_owned(), text.clone().into_bytes());
                    format!("include = \"{name}\"\n")
                }
                None if seed.name.ends_with(".toml") => SCENE.to_owned(),
                None => format!("include = \"{}\"\n", seed.name),
            };
            let loaded = load_text(text, "a.toml", &assets, &LoadOptions::default());
            let loaded = loaded.unwrap_or_else(|e| panic!("{}: {e}", seed.name));
            loaded.desc.prepare(&Default::default()).unwrap_or_else(|e| panic!("{}: {e}", seed.name));
        }
    }
}
