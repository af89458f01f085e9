//! Light from all around: the cube map of a scene (`EXT_lights_image_based`).
//!
//! The six faces lie in the directions +x, −x, +y, −y, +z, −z. Seen from inside they are upright and not mirrored: of the
//! sides the upper edge is towards +y, of the ceiling towards −z, of the floor towards +z. The other resolutions and the
//! irradiance coefficients are the same light, blurred; a path tracer needs neither. A PNG with four channels has
//! colours divided by alpha (RGBD).

use std::sync::Arc;

use turner::color::srgb_decode;
use turner::description::SceneLight;
use turner::image::Image;
use turner::light::{EnvironmentDesc, LightDesc};
use turner::math::{DMat3, DVec3};
use turner::schema::{Asset, ImageId};

use super::fault::{Fault, Outcome};
use super::images::Images;
use super::json::{Document, EnvironmentJson, Index};
use super::nodes::from_parts;
use super::report::Report;
use crate::import::ImportOptions;
use crate::scene_import::environment_light::{MAX_ROWS, resampled};

/// The cube map of a scene.
pub(super) struct Cube<'a> {
    json: &'a EnvironmentJson,
    /// The images of its faces, in the highest resolution.
    pub(super) faces: Vec<Index>,
}

/// The cube map of a scene, if it has one.
pub(super) fn of_scene(document: &Document, scene: Option<Index>) -> Outcome<Option<Cube<'_>>> {
    let Some(scene) = scene else { return Ok(None) };
    let extensions = document.scenes.get(scene.index()).and_then(|s| s.extensions.as_ref());
    let Some(reference) = extensions.and_then(|e| e.environment.as_ref()) else { return Ok(None) };
    let pointer = format!("/scenes/{}/extensions/EXT_lights_image_based", scene.0);
    let lights = document.extensions.environments.as_ref().map_or(&[][..], |e| &e.lights);
    let Some(json) = lights.get(reference.light.index()) else {
        return Err(Fault::dangling(pointer, "light", reference.light.0, lights.len()));
    };
    let faces = json.specular_images.first().cloned().unwrap_or_default();
    let pointer = format!("/extensions/EXT_lights_image_based/lights/{}/specularImages/0", reference.light.0);
    if faces.len() != 6 {
        return Err(Fault::at(pointer, format!("has {} images; expected 6", faces.len())));
    }
    if let Some(bad) = faces.iter().find(|i| i.index() >= document.images.len()) {
        return Err(Fault::dangling(pointer, "image", bad.0, document.images.len()));
    }
    Ok(Some(Cube { json, faces }))
}

/// The light of a cube map, whose panorama is added to the images. `None`, which is reported, if a face is missing.
pub(super) fn light(
    cube: &Cube<'_>,
    images: &Images,
    all: &mut Vec<Asset<Image>>,
    options: &ImportOptions,
    report: &mut Report,
) -> Outcome<Option<SceneLight>> {
    let face = |i: &Index| images.id(*i).and_then(|id| images.assets.get(id.index())).map(|a| a.data.clone());
    let faces: Vec<Arc<Image>> = cube.faces.iter().filter_map(face).collect();
    let Ok(faces): Result<[Arc<Image>; 6], _> = faces.try_into() else {
        report.ignored("an environment light without all of its six images");
        return Ok(None);
    };
    // Few pixels are interpolated in more of them.
    let rows = faces.iter().map(|f| f.width.max(f.height)).max().unwrap_or(1).saturating_mul(2);
    let rows = rows.clamp(64, MAX_ROWS);
    let memory = &options.limits.memory;
    let need = 24 * u64::from(rows) * u64::from(rows);
    if let Err(error) = memory.need(need, || "an environment light".to_owned()) {
        report.ignored(&error.message);
        return Ok(None);
    }
    let looks = faces.each_ref().map(|f| Face::new(f));
    let at = |d: DVec3| radiance(&looks, d);
    let size = [rows.saturating_mul(2), rows];
    let Some(panorama) = resampled(size, DMat3::IDENTITY, options.threads, at) else {
        report.ignored("an environment light that is too large");
        return Ok(None);
    };
    let file = Some(ImageId(all.len() as u32));
    all.push(Asset { uri: String::new(), data: Arc::new(panorama) });
    let rotation = cube.json.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let turn = from_parts(DVec3::ZERO, rotation, DVec3::ONE).matrix3;
    let strength = cube.json.intensity.unwrap_or(1.0);
    let strength = if strength.is_finite() { strength.clamp(0.0, 1e30) } else { 1.0 };
    let desc = EnvironmentDesc { file, strength, ..EnvironmentDesc::default() };
    let desc = desc.clone().turned_by(turn).unwrap_or(desc);
    let name = cube.json.name.clone();
    Ok(Some(SceneLight { name, ..LightDesc::Environment(desc).into() }))
}

/// A face with linear colours.
struct Face<'a> {
    image: &'a Image,
    is_encoded: bool,
    /// Colours are divided by alpha.
    is_divided: bool,
}

impl Face<'_> {
    fn new(image: &Image) -> Face<'_> {
        let is_encoded = image.is_display_encoded();
        Face { image, is_encoded, is_divided: is_encoded && image.channels == 4 }
    }

    fn pixel(&self, x: u32, y: u32) -> [f64; 3] {
        let color = self.image.rgb(x, y).map(|v| f64::from(if self.is_encoded { srgb_decode(v) } else { v }));
        // Alpha 0 would be infinite.
        let by = if self.is_divided { f64::from(self.image.alpha(x, y)).max(1.0 / 255.0) } else { 1.0 };
        color.map(|v| if v.is_finite() { (v / by).max(0.0) } else { 0.0 })
    }

    /// The colour at (u, v) from the upper left, bilinear between pixel centres.
    fn at(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let place = |t: f64, n: u32| {
            let t = (t * f64::from(n) - 0.5).clamp(0.0, f64::from(n - 1));
            let low = (t as u32).min(n - 1);
            (low, (low + 1).min(n - 1), t - f64::from(low))
        };
        let (x0, x1, fx) = place(u, self.image.width);
        let (y0, y1, fy) = place(v, self.image.height);
        let corners = [self.pixel(x0, y0), self.pixel(x1, y0), self.pixel(x0, y1), self.pixel(x1, y1)];
        [0, 1, 2].map(|i| {
            let [a, b, c, d] = corners.map(|c| c[i]);
            (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + d * fx) * fy
        })
    }
}

/// The radiance from a direction.
fn radiance(faces: &[Face<'_>; 6], d: DVec3) -> [f64; 3] {
    let [x, y, z] = d.abs().to_array();
    // The face, and its directions to the right and downwards.
    let (face, right, down, depth) = if x >= y && x >= z {
        if d.x >= 0.0 { (&faces[0], d.z, -d.y, x) } else { (&faces[1], -d.z, -d.y, x) }
    } else if y >= z {
        if d.y >= 0.0 { (&faces[2], -d.x, d.z, y) } else { (&faces[3], -d.x, -d.z, y) }
    } else if d.z >= 0.0 {
        (&faces[4], -d.x, -d.y, z)
    } else {
        (&faces[5], d.x, -d.y, z)
    };
    face.at([0.5 + 0.5 * right / depth, 0.5 + 0.5 * down / depth])
}

#[cfg(test)]
mod tests {
    use super::super::testing::{floats, glb};
    use turner::schema::{Limits, Memory};

    use super::*;
    use crate::assets::MemoryAssets;
    use crate::gltf::import;

    /// A PNG of 2 × 2 pixels.
    fn png(color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 2, 2);
        encoder.set_color(color);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        out
    }

    /// The red of the four pixels of a face.
    fn reds(face: u8) -> [u8; 4] {
        [0, 1, 2, 3].map(|i| 40 * face + 8 * i + 10)
    }

    fn scene(light: &str) -> Result<turner::description::SceneDesc, turner::schema::SceneError> {
        scene_within(light, Memory::default())
    }

    fn scene_within(
        light: &str,
        memory: Memory,
    ) -> Result<turner::description::SceneDesc, turner::schema::SceneError> {
        let images: Vec<String> = (0..6).map(|i| format!("{{\"uri\":\"{i}.png\"}}")).collect();
        let json = format!(
            r#""extensionsUsed":["EXT_lights_image_based"],"scene":0,
            "scenes":[{{"nodes":[0],"extensions":{{"EXT_lights_image_based":{{"light":0}}}}}}],
            "nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "extensions":{{"EXT_lights_image_based":{{"lights":[{{{light}"specularImageSize":2,"irradianceCoefficients":[{}]}}]}}}},
            "images":[{}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]"#,
            ["[0,0,0]"; 9].join(","),
            images.join(",")
        );
        let mut assets = MemoryAssets::default();
        for face in 0..6u8 {
            let rgb = reds(face).into_iter().flat_map(|r| [r, 100, 0]).collect::<Vec<u8>>();
            // The last face is divided by alpha.
            let rgbd = reds(face).into_iter().flat_map(|r| [r, 100, 0, 51]).collect::<Vec<u8>>();
            let (kind, pixels) =
                if face == 5 { (png::ColorType::Rgba, rgbd) } else { (png::ColorType::Rgb, rgb) };
            assets.files.insert(format!("{face}.png"), png(kind, &pixels));
        }
        let model = glb(&json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        let limits = Limits { memory: Arc::new(memory), ..Limits::default() };
        import(model, "a.glb", &assets, &ImportOptions { limits, ..ImportOptions::default() })
    }

    #[test]
    fn a_light_that_needs_too_much_memory_is_ignored() {
        let scene = scene_within(FACES, Memory::new(90_000, || None)).unwrap();
        assert!(!scene.lights.iter().any(|l| matches!(l.value, LightDesc::Environment(_))));
        let said = |w: &turner::schema::Warning| w.message.contains("an environment light needs");
        assert!(scene.warnings.iter().any(said), "{:?}", scene.warnings);
    }

    const FACES: &str = "\"specularImages\":[[0,1,2,3,4,5]],";

    /// Directions from inside to the centres of the upper left, upper right, lower left and lower right pixel of each
    /// face.
    #[test]
    fn faces_lie_where_they_belong() {
        for (members, turn) in [
            ("\"intensity\":3,", DMat3::IDENTITY),
            (
                "\"intensity\":3,\"rotation\":[0,0.6,0,0.8],",
                DMat3::from_cols(DVec3::new(0.28, 0.0, -0.96), DVec3::Y, DVec3::new(0.96, 0.0, 0.28)),
            ),
            (
                "\"intensity\":3,\"rotation\":[0.5,0.5,0.5,0.5],",
                DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            ),
        ] {
            let scene = scene(&format!("{members}{FACES}")).unwrap();
            let ignored = |w: &turner::schema::Warning| w.kind != turner::schema::WarningKind::Note;
            assert!(!scene.warnings.iter().any(ignored), "{:?}", scene.warnings);
            let LightDesc::Environment(desc) = &scene.lights[0].value else { panic!() };
            let light = desc.prepare(&scene.images, false).unwrap();
            let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
            for (face, [to, right, up]) in
                [[x, z, y], [-x, -z, y], [y, -x, -z], [-y, -x, z], [z, -x, y], [-z, x, y]]
                    .into_iter()
                    .enumerate()
            {
                for (i, red) in reds(face as u8).into_iter().enumerate() {
                    let side = [-0.5, 0.5];
                    let d = turn * (to + right * side[i % 2] - up * side[i / 2]);
                    let found = light.radiance(d.normalize());
                    // The panorama is interpolated between directions that are 3° apart.
                    let by = if face == 5 { 15.0 } else { 3.0 };
                    let linear = |red: u8| by * srgb_decode(f32::from(red) / 255.0);
                    let [least, .., most] = reds(face as u8).map(linear);
                    let expected = linear(red);
                    assert!(
                        (found.r - expected).abs() < 0.04 * (most - least),
                        "{members} {face} {i}: {found:?}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn cubes_have_six_faces() {
        let error = scene("\"specularImages\":[[0,1,2,3,4]],").unwrap_err();
        assert!(error.message.contains("has 5 images; expected 6"), "{}", error.message);
        let error = scene("\"specularImages\":[[0,1,2,3,4,6]],").unwrap_err();
        assert!(error.message.contains("specularImages/0"), "{}", error.message);
        assert!(scene("").unwrap_err().message.contains("has 0 images"));
    }
}
