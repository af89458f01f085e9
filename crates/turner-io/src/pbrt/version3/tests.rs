use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::filter::FilterKind;
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::material::{AlphaMode, MaterialDesc, PrincipledMaterial};
use turner::math::DVec3;
use turner::medium::MediumDesc;
use turner::schema::{ColorSource, MeshData};
use turner::shape::ShapeDesc;

use crate::pbrt::tests::{read, read_with};

/// A scene of pbrt-v3 with this world block.
fn world(text: &str) -> SceneDesc {
    read(&format!("Film \"image\" WorldBegin {text} WorldEnd"))
}

fn of_sphere(text: &str) -> MaterialDesc {
    let scene = world(&format!("{text} Shape \"sphere\""));
    assert!(scene.warnings.is_empty(), "{text}: {:?}", scene.warnings);
    scene.materials[scene.objects[0].material.unwrap().index()].value.clone()
}

fn principled(text: &str) -> PrincipledMaterial {
    match of_sphere(text) {
        MaterialDesc::Principled(m) => m,
        other => panic!("{text}: {other:?}"),
    }
}

fn value(source: ColorSource) -> f64 {
    match source {
        ColorSource::Constant(c) => f64::from(c.g),
        ColorSource::Texture(_) => panic!("a texture"),
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3
}

#[test]
fn the_film_tells_the_version_and_its_defaults() {
    let scene = world("Shape \"sphere\" \"float radius\" 2 \"float radius\" 3");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let ObjectContent::Shape(ShapeDesc::Sphere(sphere)) = &scene.objects[0].content else {
        panic!("a sphere")
    };
    assert_eq!(sphere.radius, 3.0, "the last of equal names counts");
    assert_eq!(scene.imports[0].format, "pbrt-v3");
    assert_eq!((scene.film.width, scene.film.height, scene.film.filter), (640, 480, FilterKind::Box));
    let scene = read(
        "Film \"image\" \"float scale\" 3 PixelFilter \"triangle\" \"float xwidth\" 1 \"float ywidth\" 1 \
         Integrator \"directlighting\" WorldBegin LightSource \"point\" \"rgb I\" [1 2 3] \"rgb scale\" [2 1 1] \
         LightSource \"point\" \"rgb scale\" [1 1 1] Shape \"sphere\"",
    );
    assert_eq!((scene.film.filter, scene.film.filter_radius), (FilterKind::Tent, Some(1.0)));
    assert!(matches!(scene.integrator, IntegratorDesc::Direct(_)));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let LightDesc::Point(light) = &scene.lights[0].value else { panic!("a point light") };
    assert_eq!((light.color, light.intensity), (Spectrum::new(2.0, 2.0, 3.0), 3.0));
}

#[test]
fn files_of_version_2_have_other_directives() {
    let scene = read(
        "Film \"image\" SurfaceIntegrator \"directlighting\" VolumeIntegrator \"emission\" Renderer \"sampler\" WorldBegin \
         Volume \"homogeneous\" \"color sigma_s\" [1 1 1] Material \"matte\" \"color Kd\" [.1 .2 .3] Shape \"sphere\"",
    );
    assert!(matches!(scene.integrator, IntegratorDesc::Direct(_)));
    assert!(scene.warnings.len() == 1 && scene.warnings[0].message.contains("volume \"homogeneous\""));
}

#[test]
fn diffuse_and_glossy_materials_are_read() {
    let matte = principled("Material \"matte\" \"rgb Kd\" [.1 .2 .3] \"float sigma\" 20");
    assert_eq!(matte.base_color, ColorSource::Constant(Spectrum::new(0.1, 0.2, 0.3)));
    assert!(near(value(matte.base_diffuse_roughness), 0.349));
    // The default reflects as much as 1.5 times the dielectric. α of the roughness 0.1 is 0.462.
    let plastic = principled("Material \"plastic\"");
    assert!(near(value(plastic.specular_weight), 1.5) && near(value(plastic.base_color), 0.25 / 0.862));
    assert!(near(value(plastic.specular_roughness), 0.4618f64.sqrt()));
    let raw = principled("Material \"plastic\" \"float roughness\" .09 \"bool remaproughness\" \"false\"");
    assert!(near(value(raw.specular_roughness), 0.3));
    let substrate = principled("Material \"substrate\" \"color Ks\" [.04 .04 .04]");
    assert!(near(substrate.specular_ior, 1.5) && near(value(substrate.base_color), 0.4066));
}

#[test]
fn metals_mirrors_and_glass_are_read() {
    let gold =
        principled("Material \"metal\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"");
    assert!(value(gold.base_metalness) > 0.9 && near(value(gold.specular_roughness), 0.1389f64.sqrt()));
    let mirror = principled("Material \"mirror\"");
    assert!(near(value(mirror.base_color), 0.9) && near(value(mirror.specular_roughness), 0.0));
    let glass = principled("Material \"glass\" \"float index\" 1.4 \"rgb Kt\" [.5 .5 .5]");
    assert!(near(glass.specular_ior, 1.4) && near(value(glass.transmission_weight), 1.0));
    assert!(near(value(glass.transmission_color), 0.5));
}

#[test]
fn mixed_and_layered_materials_are_read() {
    let uber = principled(
        "Material \"uber\" \"rgb opacity\" [.5 .5 .5] \"rgb Kr\" [.3 .3 .3] \"rgb Kt\" [.2 .2 .2]",
    );
    assert_eq!(uber.alpha_mode, AlphaMode::Blend);
    assert!(near(value(uber.opacity), 0.5) && near(value(uber.coat_weight), 0.3));
    assert!(near(value(uber.transmission_weight), 0.2) && near(value(uber.base_color), 0.25 / 0.8));
    // Energy is conserved where the base has little weight.
    let clear = principled("Material \"uber\" \"rgb Kd\" [.9 .9 .9] \"rgb Kt\" [.95 .95 .95]");
    assert!(near(value(clear.base_color), 1.0) && near(value(clear.transmission_weight), 0.95));
    let MaterialDesc::Disney(disney) =
        of_sphere("Material \"disney\" \"rgb color\" [.7 .7 .7] \"float metallic\" .3")
    else {
        panic!("disney")
    };
    assert!(near(value(disney.base_color), 0.7) && near(value(disney.metallic), 0.3));
    assert!(near(value(disney.clearcoat_gloss), 1.0));
    // `amount` is the weight of the first material.
    let scene = world(
        "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [1 0 0] MakeNamedMaterial \"b\" \"string type\" \"matte\" \
         Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.2 .2 .2] Shape \"sphere\"",
    );
    let Some(MaterialDesc::Mix(mix)) = scene.materials.first().map(|m| &m.value) else { panic!("a mix") };
    assert_eq!(scene.materials[mix.materials[1].index()].name.as_deref(), Some("a"));
    assert!(near(value(mix.weights[0]), 0.2));
}

/// The mesh of a shape; its normals point to the side of its triangles.
fn mesh(shape: &str) -> MeshData {
    let scene = world(&format!("Shape {shape}"));
    let data = (*scene.meshes[0].data).clone();
    let at = |i: u32| DVec3::from(data.positions[i as usize].map(f64::from));
    for t in &data.triangles {
        let [a, b, c] = t.map(at);
        let normal = (b - a).cross(c - a);
        assert!(normal.length() > 0.0, "{shape}: a triangle without area");
        for i in t {
            let Some(n) = data.normals.get(*i as usize) else { continue };
            assert!(normal.dot(DVec3::from(n.map(f64::from))) > 0.0, "{shape}");
        }
    }
    data
}

#[test]
fn quadrics_are_triangles_on_their_surface() {
    let radius = |p: &[f32; 3]| f64::from(p[0] * p[0] + p[1] * p[1]).sqrt();
    for p in &mesh("\"cone\" \"float radius\" 2 \"float height\" 3").positions {
        assert!(near(radius(p), 2.0 * (1.0 - f64::from(p[2]) / 3.0)));
    }
    for p in &mesh("\"paraboloid\" \"float radius\" 2 \"float zmax\" 3 \"float zmin\" 0").positions {
        assert!(near(radius(p), 2.0 * (f64::from(p[2].max(0.0)) / 3.0).sqrt()));
    }
    // x² + y² = 1 + z² for the line from (1, −1, −1) to (1, 1, 1).
    for p in &mesh("\"hyperboloid\" \"point p1\" [1 -1 -1] \"point p2\" [1 1 1]").positions {
        assert!(near(radius(p), (1.0 + f64::from(p[2] * p[2])).sqrt()));
    }
    let field = mesh("\"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 1 2 3 4 5]");
    assert_eq!((field.triangles.len(), field.positions[4]), (4, [0.5, 1.0, 4.0]));
    let triangle = mesh(
        "\"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"float uv\" [0 0 1 0 .5 1]",
    );
    assert_eq!(triangle.uvs, [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]);
    for bad in ["\"integer nu\" 2 \"integer nv\" 9 \"float Pz\" [0 1 2 3]", "\"float Pz\" 1"] {
        assert!(!world(&format!("Shape \"heightfield\" {bad}")).warnings.is_empty());
    }
}

#[test]
fn lights_have_latitude_longitude_maps_and_colours() {
    // Red where φ is below 90°, from +x towards +y.
    let mut pfm = b"PF\n16 8\n-1\n".to_vec();
    for i in 0..16 * 8 {
        let rgb: [f32; 3] = if i % 16 < 4 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        rgb.iter().for_each(|v| pfm.extend(v.to_le_bytes()));
    }
    let text = "Film \"image\" WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.pfm\" \"rgb L\" [2 3 4] \"integer nsamples\" 4 Shape \"sphere\"";
    let scene = read_with(text, &[("sky.pfm", &pfm)]).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let LightDesc::Environment(light) = &scene.lights[0].value else { panic!("an environment") };
    assert_eq!(light.tint, Spectrum::new(2.0, 3.0, 4.0));
    // Turner's map goes once around y, with +x at three quarters: x = y = 1 is there, 45° up.
    let map = &scene.images[light.file.unwrap().index()].data;
    let at = |u: f64, v: f64| map.rgb((u * f64::from(map.width)) as u32, (v * f64::from(map.height)) as u32);
    assert_eq!(at(0.75, 0.25), [1.0, 0.0, 0.0]);
    for [u, v] in [[0.75, 0.75], [0.25, 0.25], [0.25, 0.75]] {
        assert_eq!(at(u, v), [0.0, 0.0, 1.0]);
    }
    let scene = world("AreaLightSource \"area\" \"blackbody L\" [3000 10] Shape \"sphere\"");
    let MaterialDesc::Principled(glowing) = &scene.materials[0].value else { panic!("a surface") };
    let expected = turner::color::black_body(3000.0) * 10.0;
    let ColorSource::Constant(found) = glowing.emission_color else { panic!("a colour") };
    assert!(near(f64::from(found.r) * glowing.emission_luminance, f64::from(expected.r)));
}

#[test]
fn media_are_grids() {
    let scene = world(
        "MakeNamedMedium \"smoke\" \"string type\" \"heterogeneous\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1 \
         \"point p0\" [0 0 0] \"point p1\" [2 1 1] \"float density\" [.5 1] \
         Material \"none\" MediumInterface \"smoke\" \"\" Shape \"sphere\"",
    );
    let MediumDesc::Grid(grid) = &scene.media[0].value else { panic!("a grid") };
    assert_eq!(grid.scattering, Some(Spectrum::new(2.55, 3.21, 3.77)));
}
