//! Scenes with everything that a path may encounter, for the tests of replay.

use super::estimators;
use crate::camera::{FisheyeDesc, RealisticDesc, ThinLensDesc};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::Reconstruction;
use crate::filter::FilterKind;
use crate::integrator::path::{End, Passage, PathRecord, VertexRecord};
use crate::integrator::{Caustics, DirectDesc, IntegratorDesc, LightSampling, PathDesc, SharedPathsMode};
use crate::light::{AmbientDesc, DirectionalDesc, EnvironmentDesc, LightDesc};
use crate::material::{AlphaMode, DielectricMaterial, MetalMaterial, MixMaterial, PrincipledMaterial};
use crate::math::{DAffine3, DVec3};
use crate::medium::HomogeneousMedium;
use crate::schema::{MeshData, Transform};
use crate::shape::ShapeDesc;
use crate::testing::scenes::{
    bands, cuboid, emissive, even, grey, lamp, matte, path, placed, plane, rectangle, rgb, scene, sphere,
    turned, v,
};
use crate::texture::{CheckerboardDesc, MarbleDesc, TextureDesc};

pub(super) const WIDTH: u32 = 24;
pub(super) const HEIGHT: u32 = 16;

/// What must occur in some path of a scene.
pub(super) type Occurs = fn(&PathRecord) -> bool;

pub(super) fn scenes() -> Vec<(&'static str, SceneDesc, Occurs)> {
    vec![
        ("nested glass", nested_glass(), |p| {
            any(p, |v| v.passage == Passage::Hidden || v.transmittance.is_some())
        }),
        ("hidden boundaries", hidden_boundaries(), |p| any(p, |v| v.passage == Passage::Hidden)),
        ("environment", environment(), |p| {
            let mixed = |w: f64| w > 0.0 && w < 1.0;
            p.escape.as_ref().is_some_and(|e| e.pdf.is_some() && e.lights.iter().any(|l| mixed(l.weight)))
        }),
        ("rough mirrors under several lights", rough_mirrors(), |p| {
            any(p, |v| v.lights.iter().any(|l| l.candidates > 1 && l.counts > 1.0))
                && any(p, |v| v.emission.as_ref().is_some_and(|e| e.weight > 0.0 && e.weight < 1.0))
        }),
        ("a mesh with textures", textured_mesh(), |p| {
            any(p, |v| v.ns != v.ng && v.scatter.is_some_and(|s| s.terminator < 1.0))
        }),
        ("curved metal, seen from both sides, before textures", curved_metal(), |p| {
            p.vertices.len() > 2 && any(p, |v| v.ns != v.ng && v.scatter.is_some())
        }),
        ("mixes and holes", mixes_and_holes(), |p| {
            any(p, |v| v.chosen.is_some()) && any(p, |v| v.passage == Passage::Hole)
        }),
        ("panes", panes(), |p| {
            let visible = |v: &VertexRecord| v.lights.first().and_then(|l| l.visible);
            any(p, |v| v.passage == Passage::Pane)
                && any(p, |v| visible(v).is_some_and(|s| !s.is_black() && s != Spectrum::WHITE))
        }),
        ("dispersion", dispersion(), |p| any(p, |v| v.dispersed.is_some())),
        ("clamp, lens, motion, a transparent background", clamp_and_motion(), |p| {
            p.end == End::Depth && p.time > 0.0
        }),
        ("flat triangles of plain materials", flat_triangles(), |p| {
            p.vertices.len() > 3 && any(p, |v| v.transmittance.is_some())
        }),
        ("the same under many lamps, with a clamp and limits", many_lights(), |p| {
            p.end == End::Depth && p.vertices.len() > 3
        }),
        ("a room lit through a window", windowed_room(), |p| {
            any(p, |v| v.lights.iter().any(|l| l.visible.is_some()))
                && p.escape
                    .as_ref()
                    .is_some_and(|e| e.lights.iter().any(|l| l.weight > 0.0 && l.weight < 1.0))
        }),
        ("direct", direct(), |p| p.end == End::Unlit && p.vertices.len() > 1),
        ("lights by BSDF sampling alone", bsdf_sampling_only(), |p| {
            p.vertices.len() > 1 && any(p, |v| v.emission.is_some_and(|e| e.weight == 1.0))
        }),
        ("media", media(), |p| {
            any(p, |v| v.passage == Passage::Medium && !v.lights.is_empty())
                && any(p, |v| v.way.as_ref().is_some_and(|w| w.emission.is_some() && w.second.is_some()))
                && any(p, |v| v.passage == Passage::Interface)
        }),
        ("wax", wax(), |p| {
            any(p, |v| v.passage == Passage::Exit && !v.lights.is_empty())
                && any(p, |v| v.walk.is_some_and(|w| w.steps > 5))
        }),
        ("several light samples, in mirrors and in the open", several_light_samples(), |p| {
            any(p, |v| v.lights.iter().filter(|l| l.visible.is_some()).count() == 3)
                && p.vertices.iter().position(|v| v.lights.len() == 3).is_some_and(|i| i > 0)
        }),
        ("several light samples of plain triangles", several_light_samples_of_triangles(), |p| {
            p.vertices.len() > 3 && any(p, |v| v.lights.iter().filter(|l| l.visible.is_some()).count() > 3)
        }),
        ("light samples under a uniform sky", under_uniform_sky(3, balls), |p| {
            any(p, |v| v.lights.iter().filter(|l| l.visible.is_some()).count() == 3)
                && p.escape
                    .as_ref()
                    .is_some_and(|e| e.lights.iter().any(|l| l.weight > 0.0 && l.weight < 1.0))
        }),
        ("light samples of plain triangles under a uniform sky", under_uniform_sky(2, plain_meshes), |p| {
            any(p, |v| v.lights.iter().filter(|l| l.visible.is_some()).count() == 2)
                && p.vertices.iter().skip(1).any(|v| v.scatter.is_some() && v.lights.is_empty())
        }),
        ("a fisheye", fisheye(), |p| p.end == End::OutsideField),
        ("a lens", lens(), |p| p.vertices.len() > 1),
    ]
}

/// Whether any vertex of the path satisfies the condition.
fn any(path: &PathRecord, is: impl Fn(&VertexRecord) -> bool) -> bool {
    path.vertices.iter().any(is)
}

/// An empty scene, seen from slightly above.
pub(super) fn seen(desc: SceneDesc) -> SceneDesc {
    desc.seen_at(v(0.0, 1.5, 5.0), v(0.0, 0.7, 0.0), 45.0).filmed([WIDTH, HEIGHT], 4)
}

/// The same with Russian roulette from the first bounce on.
fn base() -> SceneDesc {
    seen(path(PathDesc { rr_start: Some(1), ..PathDesc::default() }))
}

/// Adds a checkerboard floor.
fn floored(mut desc: SceneDesc) -> SceneDesc {
    let board = desc.texture(TextureDesc::Checkerboard(CheckerboardDesc::default()));
    desc.with(plane(), matte(board))
}

/// Adds a light above.
fn with_light(desc: SceneDesc) -> SceneDesc {
    desc.with(cuboid(v(-1.0, 3.0, -1.0), v(1.0, 3.2, 1.0)), emissive(5.0, grey(1.0)))
}

/// Adds both.
fn furnished(desc: SceneDesc) -> SceneDesc {
    with_light(floored(desc))
}

/// A ball of radius 1 on the floor.
fn ball(x: f64) -> ShapeDesc {
    sphere(v(x, 1.0, 0.0), 1.0)
}

fn studio() -> LightDesc {
    LightDesc::Environment(EnvironmentDesc::studio())
}

fn metal(roughness: f64) -> MetalMaterial {
    MetalMaterial { roughness: grey(roughness), ..MetalMaterial::default() }
}

fn clear() -> PrincipledMaterial {
    PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    }
}

fn tinted() -> PrincipledMaterial {
    PrincipledMaterial { transmission_color: rgb([0.3, 0.6, 0.9]), transmission_depth: 0.5, ..clear() }
}

fn nested_glass() -> SceneDesc {
    let water = PrincipledMaterial { specular_ior: 1.33, ..tinted() };
    furnished(base())
        .with(ball(0.0), DielectricMaterial::default())
        .with(sphere(v(0.0, 1.0, 0.3), 0.8), water)
}

fn hidden_boundaries() -> SceneDesc {
    let rough = DielectricMaterial { ior: 1.3, roughness: grey(0.2), ..DielectricMaterial::default() };
    furnished(base())
        .with(ball(0.0), DielectricMaterial::default())
        .with(sphere(v(0.5, 1.0, 0.0), 0.8), rough)
}

fn environment() -> SceneDesc {
    let sun = DirectionalDesc { direction: Some(v(-1.0, -2.0, -1.0)), angle: 3.0, ..Default::default() };
    let desc =
        base().lit(studio()).lit(LightDesc::Ambient(AmbientDesc::default())).lit(LightDesc::Directional(sun));
    floored(desc).with(ball(0.0), metal(0.3))
}

/// The sky is sampled adaptively.
fn windowed_room() -> SceneDesc {
    let shared_paths = SharedPathsMode::Off;
    estimators::windowed_room(PathDesc { shared_paths, ..PathDesc::default() }).filmed([WIDTH, HEIGHT], 4)
}

fn rough_mirrors() -> SceneDesc {
    let mut desc = seen(path(PathDesc { caustics: Caustics::Off, ..PathDesc::default() }))
        .lit(studio())
        .lit(lamp(v(-2.0, 2.0, 3.0), 9.0));
    let mirror = PrincipledMaterial {
        base_metalness: grey(1.0),
        base_color: rgb([0.9, 0.6, 0.3]),
        specular_roughness: grey(0.3),
        ..PrincipledMaterial::default()
    };
    let mirror = desc.material(mirror.into());
    let floor = desc.mesh(MeshData {
        positions: vec![[-3.0, 0.0, -3.0], [3.0, 0.0, -3.0], [3.0, 0.0, 3.0], [-3.0, 0.0, 3.0]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..MeshData::default()
    });
    with_light(desc)
        .with(sphere(v(1.5, 1.0, 1.0), 0.3), emissive(9.0, grey(1.0)))
        .with_shared(sphere(v(-0.6, 0.7, 0.0), 0.7), mirror)
        .with_shared(floor, mirror)
}

/// A sheet of two triangles, slightly bent.
fn sheet() -> MeshData {
    MeshData {
        positions: vec![[-2.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 0.5, 2.0], [-2.0, 0.0, 2.0]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..MeshData::default()
    }
}

fn textured_mesh() -> SceneDesc {
    let mut desc = with_light(base());
    let sheet = desc.mesh(MeshData {
        normals: vec![[0.0, 1.0, 0.0], [0.3, 1.0, 0.0], [0.0, 1.0, 0.3], [0.0, 1.0, 0.0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        ..sheet()
    });
    let material = PrincipledMaterial {
        base_color: desc.texture(TextureDesc::Checkerboard(CheckerboardDesc::default())),
        specular_roughness: desc.texture(TextureDesc::Marble(MarbleDesc::default())),
        coat_weight: grey(0.5),
        ..PrincipledMaterial::default()
    };
    desc.with(sheet, material)
}

/// The curvature of the metal widens or narrows the footprints in the texture.
fn curved_metal() -> SceneDesc {
    let mut desc = with_light(base());
    let front = MeshData {
        normals: vec![[-0.5, 1.0, -0.4], [0.5, 1.0, -0.4], [0.5, 1.0, 0.4], [-0.5, 1.0, 0.4]],
        ..sheet()
    };
    let mut back = front.clone();
    back.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    back.positions.iter_mut().for_each(|[_, y, z]| (*y, *z) = (*y + 0.6, *z - 1.0));
    let metal = PrincipledMaterial { base_metalness: grey(1.0), ..PrincipledMaterial::default() };
    let checks = PrincipledMaterial {
        base_color: desc.texture(TextureDesc::Checkerboard(CheckerboardDesc::default())),
        ..PrincipledMaterial::default()
    };
    let (front, back) = (desc.mesh(front), desc.mesh(back));
    let behind = rectangle(v(0.0, 3.0, -3.0), v(12.0, 0.0, 0.0), v(0.0, 8.0, 0.0));
    desc.with(front, metal.clone()).with(back, metal).with(behind, checks)
}

fn mixes_and_holes() -> SceneDesc {
    let mut desc = furnished(base().lit(lamp(v(2.0, 3.0, 4.0), 20.0)));
    let materials = vec![
        desc.material(matte(grey(0.8)).into()),
        desc.material(MetalMaterial::default().into()),
        desc.material(emissive(2.0, grey(1.0)).into()),
    ];
    let mix = MixMaterial { materials, weights: vec![grey(0.3); 2] };
    let holes = PrincipledMaterial { alpha_mode: AlphaMode::Blend, opacity: grey(0.4), ..Default::default() };
    desc.with(ball(-1.0), mix).with(rectangle(v(0.0, 1.0, 2.0), v(8.0, 0.0, 0.3), v(0.0, 4.0, 0.0)), holes)
}

fn panes() -> SceneDesc {
    let pane = DielectricMaterial { thin: true, ..DielectricMaterial::default() };
    let tinted = DielectricMaterial { color: rgb([0.9, 0.6, 0.3]), ..pane.clone() };
    furnished(base())
        .with(rectangle(v(0.0, 1.5, 2.0), v(9.0, 0.0, 0.0), v(0.0, 5.0, 0.0)), tinted)
        .with(rectangle(v(0.0, 2.0, 0.0), v(9.0, 0.0, 0.0), v(0.0, 0.0, 9.0)), pane)
}

fn dispersion() -> SceneDesc {
    let prism = PrincipledMaterial { transmission_dispersion_scale: 2.0, ..clear() };
    furnished(base().before_color([0.2, 0.4, 0.6])).with(ball(0.0), prism)
}

fn clamp_and_motion() -> SceneDesc {
    let camera = ThinLensDesc {
        position: v(0.0, 1.5, 5.0),
        look_at: v(0.0, 0.7, 0.0),
        fov: Some(45.0),
        focus_distance: Some(5.0),
        lens_radius: 0.1,
        ..ThinLensDesc::default()
    };
    let settings = PathDesc { clamp_indirect: 0.05, max_depth: 4, ..PathDesc::default() };
    let mut desc = with_light(seen(path(settings)).seen(camera));
    (desc.film.shutter, desc.film.filter) = ([0.2, 0.9], FilterKind::Gaussian);
    // A pixel consists of its own samples only.
    desc.film.reconstruction = Reconstruction::Importance;
    desc.background.transparent = true;
    let motion = Some(Transform(DAffine3::from_translation(DVec3::X)));
    desc.with_object(ObjectDesc { motion, ..ObjectDesc::new(ball(0.0)) }, matte(grey(0.8)))
        .with(cuboid(v(-2.0, -0.1, -2.0), v(2.0, 0.0, 2.0)), matte(grey(0.8)))
}

fn flat_triangles() -> SceneDesc {
    plain_meshes(floored(with_light(base().lit(studio()))))
}

/// A mirror on a dull floor under the sky and a lamp.
fn several_light_samples() -> SceneDesc {
    let settings = PathDesc {
        light_samples: Some(3),
        rr_start: Some(1),
        caustics: Caustics::Off,
        ..PathDesc::default()
    };
    floored(with_light(seen(path(settings)).lit(studio()))).with(ball(0.0), metal(0.0))
}

fn several_light_samples_of_triangles() -> SceneDesc {
    let settings = PathDesc { light_samples: Some(5), rr_start: Some(1), ..PathDesc::default() };
    plain_meshes(floored(with_light(seen(path(settings)).lit(studio()))))
}

/// A mirror, a rough metal and a glass ball.
fn balls(desc: SceneDesc) -> SceneDesc {
    desc.with(ball(-1.0), metal(0.0)).with(ball(0.0), metal(0.3)).with(ball(1.0), tinted())
}

fn under_uniform_sky(light_samples: u32, with: fn(SceneDesc) -> SceneDesc) -> SceneDesc {
    let settings = PathDesc { light_samples: Some(light_samples), rr_start: Some(1), ..PathDesc::default() };
    let (desc, sky) = estimators::uniform_sky(seen(path(settings)));
    floored(with(desc.lit(sky)))
}

fn many_lights() -> SceneDesc {
    let settings = PathDesc {
        rr_start: Some(2),
        max_depth: 5,
        max_diffuse: Some(3),
        max_glossy: Some(2),
        clamp_indirect: 0.5,
        ..PathDesc::default()
    };
    (0..80).fold(plain_meshes(seen(path(settings))), |desc, i| {
        let at = v(f64::from(i % 10 - 5), 3.0, f64::from(i / 10 - 4));
        desc.with(sphere(at, 0.05), emissive(20.0, grey(1.0)))
    })
}

/// Meshes with geometric normals, most of them in one BVH: translated, rotated and mirrored; Lambertian, thin or not,
/// some of one side only, and rough mirrors. One is inside coloured glass, two have smooth normals.
fn plain_meshes(desc: SceneDesc) -> SceneDesc {
    let mirror = PrincipledMaterial {
        base_weight: grey(0.0),
        specular_ior: 0.0,
        specular_color: rgb([0.9, 0.7, 0.5]),
        specular_roughness: grey(0.4),
        ..PrincipledMaterial::default()
    };
    let thin = PrincipledMaterial { thin_walled: true, ..matte(rgb([0.2, 0.6, 0.9])) };
    let one_sided = PrincipledMaterial { front_only: true, ..matte(rgb([0.7, 0.7, 0.4])) };
    let moved = |x: f64, y: f64, z: f64| DAffine3::from_translation(v(x, y, z));
    let scaled = |by: f64| DAffine3::from_scale(DVec3::splat(by));
    let mirrored = turned(70.0, 20.0, 0.0) * DAffine3::from_scale(v(-0.3, 0.5, 0.4));
    let sheets = [
        (DAffine3::IDENTITY, None, matte(rgb([0.8, 0.6, 0.3]))),
        (moved(-1.0, 1.0, 0.0) * mirrored, None, matte(grey(0.8))),
        (moved(2.0, 1.0, 0.0) * turned(0.0, 0.0, 80.0), None, mirror),
        (moved(0.7, 1.0, 1.0) * scaled(0.1), None, matte(grey(0.8))),
        (moved(1.5, 0.5, 1.0) * scaled(0.2), Some(true), thin.clone()),
        (moved(-1.5, 0.5, 1.0) * scaled(0.2), None, thin),
        (moved(0.2, 0.6, 1.2) * turned(50.0, 30.0, 0.0) * scaled(0.4), Some(true), one_sided.clone()),
        (moved(-0.8, 1.3, 1.1) * mirrored, None, one_sided),
    ];
    let meshes = sheets.into_iter().fold(desc, |mut desc, (transform, smooth, material)| {
        let mut shape = desc.mesh(sheet());
        if let ShapeDesc::Mesh(mesh) = &mut shape {
            mesh.smooth = smooth;
        }
        desc.with_object(placed(shape, transform), material)
    });
    meshes.with(sphere(v(0.7, 1.0, 1.0), 0.5), tinted())
}

fn direct() -> SceneDesc {
    let unlit = PrincipledMaterial { unlit: true, ..PrincipledMaterial::default() };
    furnished(seen(scene(IntegratorDesc::Direct(DirectDesc::default()))))
        .with(ball(0.0), metal(0.0))
        .with(sphere(v(1.5, 1.0, 1.0), 0.5), unlit)
}

fn bsdf_sampling_only() -> SceneDesc {
    furnished(seen(path(PathDesc { light_sampling: LightSampling::Bsdf, ..PathDesc::default() })))
}

fn media() -> SceneDesc {
    let milk = HomogeneousMedium {
        scattering: bands([2.0, 1.0, 3.0]),
        anisotropy: 0.5,
        ..HomogeneousMedium::default()
    };
    let juice = HomogeneousMedium {
        scattering: even(1.0),
        absorption: bands([0.0, 0.5, 1.0]),
        ..HomogeneousMedium::default()
    };
    let fog = HomogeneousMedium {
        extinction: even(0.05),
        albedo: bands([0.9, 0.8, 0.7]),
        emission: Spectrum::grey(0.01),
        ..HomogeneousMedium::default()
    };
    let mut desc = furnished(base()).filled(ball(1.0), milk);
    let interior = desc.medium(juice);
    desc.with(ball(-1.0), DielectricMaterial { interior, ..DielectricMaterial::default() }).in_fog(fog)
}

fn wax() -> SceneDesc {
    let mut desc = furnished(base().lit(lamp(v(2.0, 3.0, 4.0), 20.0)));
    let coated = PrincipledMaterial {
        subsurface_weight: grey(0.8),
        subsurface_radius: 0.1,
        subsurface_color: desc.texture(TextureDesc::Marble(MarbleDesc::default())),
        coat_weight: grey(0.5),
        coat_color: rgb([1.0, 0.8, 0.6]),
        subsurface_scatter_anisotropy: 0.5,
        ..PrincipledMaterial::default()
    };
    let mut desc = desc.with(ball(0.0), coated).with(sphere(v(0.6, 1.0, 0.0), 0.2), emissive(3.0, grey(1.0)));
    let body = PrincipledMaterial { subsurface_weight: grey(1.0), ..PrincipledMaterial::default() };
    let materials = vec![desc.material(matte(grey(0.8)).into()), desc.material(body.into())];
    let mix = MixMaterial { materials, ..MixMaterial::default() };
    desc.with(cuboid(v(-1.5, 0.0, 1.0), v(-0.5, 1.0, 1.5)), mix)
}

fn lens() -> SceneDesc {
    let camera =
        RealisticDesc { position: v(0.0, 1.5, 5.0), look_at: v(0.0, 0.7, 0.0), ..RealisticDesc::default() };
    furnished(base().seen(camera))
}

fn fisheye() -> SceneDesc {
    let camera =
        FisheyeDesc { position: v(0.0, 1.5, 5.0), look_at: v(0.0, 0.7, 0.0), ..FisheyeDesc::default() };
    furnished(base().seen(camera))
}
