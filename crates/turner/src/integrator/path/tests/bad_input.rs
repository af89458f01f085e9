//! Parameters that are out of range or non-finite, and scenes without light: each gives a clear error, or a defined
//! image and a warning.

use std::sync::Arc;

use crate::color::{Spectrum, Transfer, named};
use crate::description::{ObjectDesc, SceneDesc};
use crate::image::{Image, Pixels};
use crate::integrator::{IntegratorDesc, NormalsDesc, PathDesc};
use crate::light::{AmbientDesc, DiskLightDesc, EnvironmentDesc, LightDesc, PointDesc, RectangleLightDesc};
use crate::lint::lint;
use crate::material::{
    ClassicMaterial, DielectricMaterial, EmissiveMaterial, MaterialDesc, MatteMaterial, MetalMaterial,
    MixMaterial, PlasticMaterial, PrincipledMaterial,
};
use crate::math::DVec3;
use crate::schema::{Asset, ColorSource, ImageId, MaterialId, MeshData, WarningKind};
use crate::shape::{CylinderDesc, ShapeDesc};
use crate::testing::scenes::{grey, path, rectangle, render_with, rgb, sphere, v};

/// An empty scene, seen from the front, 8 × 8 pixels.
fn small() -> SceneDesc {
    let desc = path(PathDesc { rr_start: Some(1000), ..PathDesc::default() });
    let mut desc = desc.filmed([8, 8], 16).seen_from_front(4.0, 10.0);
    desc.film.transfer = Transfer::Srgb;
    desc
}

/// Adds a sphere with the material.
fn ball(mut desc: SceneDesc, material: MaterialDesc) -> SceneDesc {
    let material = desc.material(material);
    desc.with_shared(sphere(DVec3::ZERO, 1.0), material)
}

fn principled(material: PrincipledMaterial) -> MaterialDesc {
    MaterialDesc::Principled(material)
}

fn matte(color: ColorSource) -> MaterialDesc {
    MaterialDesc::Matte(MatteMaterial { color, ..MatteMaterial::default() })
}

fn emissive(strength: f64) -> MaterialDesc {
    MaterialDesc::Emissive(EmissiveMaterial { strength, ..EmissiveMaterial::default() })
}

/// The warnings of preparation and lint, without notes.
fn warnings(desc: &SceneDesc) -> Vec<String> {
    let prepared = desc.prepare(&Default::default()).unwrap();
    let judged = lint(desc, &prepared);
    let loud = prepared.warnings.iter().chain(&judged).filter(|w| w.kind != WarningKind::Note);
    loud.map(|w| w.message.clone()).collect()
}

/// Mean of the red channel. Rendering itself counts non-finite samples and fails.
fn brightness(desc: &SceneDesc) -> f64 {
    let picture = render_with(desc, 2, u32::MAX).0;
    assert!(picture.linear.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
    picture.linear.iter().map(|p| f64::from(p[0])).sum::<f64>() / picture.linear.len() as f64
}

#[track_caller]
fn has(messages: &[String], text: &str) {
    assert!(messages.iter().any(|m| m.contains(text)), "{text}: {messages:?}");
}

#[test]
fn colours_above_one_are_clamped_and_counted() {
    let lit = || small().before(1.0);
    for material in [
        matte(rgb([5.0, 3.0, 2.0])),
        principled(PrincipledMaterial {
            base_metalness: grey(1.0),
            base_color: rgb([9.0, 1.0, 1.0]),
            ..PrincipledMaterial::default()
        }),
        principled(PrincipledMaterial {
            base_color: grey(1e30),
            coat_weight: grey(1.0),
            coat_color: grey(7.0),
            fuzz_weight: grey(0.5),
            fuzz_color: grey(4.0),
            ..PrincipledMaterial::default()
        }),
        MaterialDesc::Dielectric(DielectricMaterial { color: grey(20.0), ..DielectricMaterial::default() }),
    ] {
        let desc = ball(lit(), material.clone());
        has(&warnings(&desc), "above 1: a surface cannot reflect");
        let seen = brightness(&desc);
        assert!(seen > 0.5 && seen <= 1.002, "{material:?}: {seen}");
    }
    let two = ball(ball(lit(), matte(grey(2.0))), matte(grey(3.0)));
    has(&warnings(&two), "2 material colours are above 1");
    // A value above 1 by rounding is no error.
    assert!(warnings(&ball(lit(), matte(grey(1.00001)))).is_empty());
}

#[test]
fn invalid_emission_counts_as_none() {
    let with = |luminance: f64, color: [f32; 3]| {
        let emitter = PrincipledMaterial {
            emission_luminance: luminance,
            emission_color: ColorSource::Constant(Spectrum::from(color)),
            ..EmissiveMaterial::default().principled()
        };
        ball(small().before(0.25), principled(emitter))
    };
    for (luminance, color) in
        [(-1.0, [1.0; 3]), (f64::NAN, [1.0; 3]), (1.0, [f32::NAN, -1.0, f32::NEG_INFINITY])]
    {
        let desc = with(luminance, color);
        has(&warnings(&desc), "emission of 1 material is");
        assert!(brightness(&desc) == 0.0, "{luminance} {color:?}");
    }
    // Clamped to the largest representable emission, but finite.
    for desc in [with(1e300, [1e38; 3]), with(f64::INFINITY, [f32::INFINITY; 3])] {
        has(&warnings(&desc), "emission of 1 material is");
        let picture = render_with(&desc, 2, u32::MAX).0;
        assert!(picture.linear.iter().all(|p| p[0].is_finite() && p[0] > 1e9));
    }
}

/// A principled material with this index of refraction and roughness.
fn of_index(specular_ior: f64, roughness: f64) -> PrincipledMaterial {
    PrincipledMaterial { specular_ior, specular_roughness: grey(roughness), ..PrincipledMaterial::default() }
}

/// Materials at the limits of their parameters, with the minimum that a sphere of each shows of a white background.
fn extremes() -> Vec<(MaterialDesc, f64)> {
    let white = || PrincipledMaterial { base_color: grey(1.0), ..PrincipledMaterial::default() };
    let glass = |material| PrincipledMaterial { transmission_weight: grey(1.0), ..material };
    let metal = |roughness| MetalMaterial {
        color: Some(grey(1.0)),
        roughness: grey(roughness),
        ..MetalMaterial::default()
    };
    let rough =
        PrincipledMaterial { base_diffuse_roughness: grey(1.0), specular_roughness: grey(0.0), ..white() };
    let coat = PrincipledMaterial {
        coat_weight: grey(1.0),
        coat_ior: 0.01,
        coat_roughness: grey(1.0),
        ..PrincipledMaterial::default()
    };
    let film = PrincipledMaterial {
        thin_film_weight: grey(1.0),
        thin_film_thickness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    // An index of 0 is a perfect mirror, as in glTF.
    vec![
        (principled(of_index(0.0, 0.0)), 0.999),
        (principled(of_index(0.0, 1.0)), 0.6),
        (principled(glass(of_index(0.0, 0.0))), 0.999),
        (principled(PrincipledMaterial { base_color: grey(1.0), ..of_index(100.0, 0.0) }), 0.99),
        (principled(glass(of_index(100.0, 1.0))), 0.2),
        (principled(rough), 0.95),
        (MaterialDesc::Dielectric(DielectricMaterial { ior: 0.0, ..DielectricMaterial::default() }), 0.999),
        (MaterialDesc::Plastic(PlasticMaterial { ior: 0.0, ..PlasticMaterial::default() }), 0.5),
        (MaterialDesc::Metal(metal(0.0)), 0.999),
        (MaterialDesc::Metal(metal(1.0)), 0.95),
        (principled(coat), 0.2),
        (principled(film), 0.2),
    ]
}

#[test]
fn indices_and_roughnesses_at_the_ends_of_their_ranges() {
    for (material, least) in extremes() {
        let desc = ball(small().filmed([8, 8], 256).before(1.0), material.clone());
        let seen = brightness(&desc);
        assert!(seen >= least && seen <= 1.01, "{material:?}: {seen}");
    }
}

/// A matte sphere in an environment map of 4 × 2 pixels.
fn in_environment(pixels: [f32; 24]) -> SceneDesc {
    let mut desc = ball(small(), matte(grey(0.5)));
    let image = Image { width: 4, height: 2, channels: 3, pixels: Pixels::F32(pixels.to_vec()) };
    desc.images.push(Asset { uri: "sky.hdr".into(), data: Arc::new(image) });
    desc.lit(LightDesc::Environment(EnvironmentDesc { file: Some(ImageId(0)), ..EnvironmentDesc::studio() }))
}

#[test]
fn black_and_non_finite_environments() {
    let black = in_environment([0.0; 24]);
    let text = warnings(&black);
    has(&text, "environment light is black");
    has(&text, "the picture is black");
    assert!(brightness(&black) == 0.0);

    let mut some = [1.0; 24];
    (some[0], some[4], some[11]) = (f32::NAN, f32::INFINITY, -3.0);
    let some = in_environment(some);
    has(&warnings(&some), "3 pixels of the environment map");
    let seen = brightness(&some);
    assert!(seen > 0.3 && seen < 0.5, "{seen}");

    let none = in_environment([f32::NAN; 24]);
    let text = warnings(&none);
    has(&text, "8 pixels of the environment map");
    has(&text, "environment light is black");
    assert!(brightness(&none) == 0.0);
}

#[test]
fn lights_without_area() {
    let refused = |desc: SceneDesc| desc.prepare(&Default::default()).expect_err("no area").to_string();
    let parallel = (v(1.0, 0.0, 0.0), v(2.0, 0.0, 0.0));
    let center = v(0.0, 2.0, 0.0);
    let flat = |(edge_u, edge_v)| {
        LightDesc::Rectangle(RectangleLightDesc { center, edge_u, edge_v, ..RectangleLightDesc::default() })
    };
    let degenerate = DiskLightDesc { center, normal: DVec3::ZERO, ..DiskLightDesc::default() };
    for (light, text) in [
        (flat(parallel), "no area"),
        (flat((DVec3::ZERO, DVec3::Z)), "no area"),
        (LightDesc::Disk(degenerate), "must not be zero"),
    ] {
        let error = refused(ball(small(), matte(grey(0.8))).lit(light.clone()));
        assert!(error.contains(text), "{light:?}: {error}");
    }
    let end = v(1.0, 0.0, 0.0);
    let tube = CylinderDesc { from: end, to: end, ..CylinderDesc::default() };
    for (shape, text) in [
        (rectangle(DVec3::ZERO, parallel.0, parallel.1), "rectangle"),
        (ShapeDesc::Cylinder(tube), "two points"),
    ] {
        let mut desc = small();
        let emitter = desc.material(emissive(1.0));
        let error = refused(desc.with_shared(shape.clone(), emitter));
        assert!(error.contains(text), "{shape:?}: {error}");
    }
    // Degenerate triangles among others, and alone: there is nothing to hit or to sample.
    let mesh = |triangles: &[[u32; 3]]| {
        let mut desc = small().before(0.5);
        let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh =
            desc.mesh(MeshData { positions: corners, triangles: triangles.into(), ..MeshData::default() });
        let (emitter, white) = (desc.material(emissive(1.0)), desc.material(matte(grey(0.8))));
        desc.with_shared(mesh, emitter).with_shared(sphere(v(0.0, -1.2, 0.0), 1.0), white)
    };
    let both = mesh(&[[0, 1, 2], [0, 1, 3], [1, 1, 1]]);
    assert!(brightness(&both) > 0.4);
    let flat = mesh(&[[0, 1, 2], [1, 1, 1]]);
    let seen = brightness(&flat);
    assert!(seen > 0.3 && seen < 0.51, "{seen}");
}

/// A point light above the scene.
fn point(intensity: f64) -> LightDesc {
    LightDesc::Point(PointDesc { position: v(0.0, 5.0, 0.0), intensity, ..PointDesc::default() })
}

/// Lit scenes, one for each kind of light.
fn with_light() -> Vec<SceneDesc> {
    let white = || ball(small(), matte(grey(0.8)));
    let unlit = PrincipledMaterial { unlit: true, ..PrincipledMaterial::default() };
    let mut mixed = small();
    let parts = [MaterialDesc::Classic(ClassicMaterial::default()), emissive(1.0)];
    let materials: Vec<MaterialId> = parts.into_iter().map(|m| mixed.material(m)).collect();
    let mix = MaterialDesc::Mix(MixMaterial { materials, weights: Vec::new() });
    let (mut zenith, mut with_studio, mut normals) = (white(), white(), white());
    zenith.background.zenith = named("skyblue");
    with_studio.studio = Some(Default::default());
    normals.integrator = IntegratorDesc::Normals(NormalsDesc::default());
    vec![
        ball(small(), emissive(1.0)),
        ball(small(), principled(unlit)),
        ball(mixed, mix),
        white().before(0.1),
        zenith,
        white().lit(LightDesc::Environment(EnvironmentDesc::studio())),
        white().lit(point(1.0)),
        white().lit(LightDesc::Ambient(AmbientDesc::default())),
        with_studio,
        normals,
    ]
}

#[test]
fn only_scenes_without_light_give_a_warning() {
    let dark = "the picture is black";
    let white = || ball(small(), matte(grey(0.8)));
    has(&warnings(&white()), dark);
    has(&warnings(&white().lit(point(0.0))), dark);
    let ambient = AmbientDesc { intensity: 0.0, ..AmbientDesc::default() };
    has(&warnings(&white().lit(LightDesc::Ambient(ambient))), dark);
    has(&warnings(&ball(small(), emissive(0.0))), dark);
    // The result is defined: the number of lights does not become 0 in a division.
    assert_eq!(brightness(&white()), 0.0);

    for lit in with_light() {
        assert!(warnings(&lit).is_empty(), "{lit:?}: {:?}", warnings(&lit));
    }
    // Surfaces are not lit by the background in the classic integrator.
    let classic = || {
        let mut desc = SceneDesc::default().before(1.0);
        desc.objects.push(ObjectDesc::new(sphere(DVec3::ZERO, 1.0)));
        desc
    };
    has(&warnings(&classic()), "the scene has no [[light]]");
    has(&warnings(&classic().lit(point(0.0))), "all lights of the scene are black");
    assert!(warnings(&ball(SceneDesc::default(), emissive(1.0))).is_empty());
}
