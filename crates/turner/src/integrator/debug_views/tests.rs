//! The values of the debug views, by formula.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use super::{
    AlbedoDesc, AmbientOcclusionDesc, CostDesc, DepthDesc, DepthMeasure, IdsDesc, NormalsDesc, PositionDesc,
    UvDesc, WireframeDesc,
};
use crate::camera::PinholeDesc;
use crate::description::SceneDesc;
use crate::film::{Antialias, Picture};
use crate::integrator::IntegratorDesc;
use crate::lint::lint;
use crate::material::{ClassicMaterial, MaterialDesc, MatteMaterial, MixMaterial, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{MeshData, PrepareOptions};
use crate::shape::{PlaneDesc, ShapeDesc};
use crate::testing::scenes::{cuboid, grey, plane, rectangle, render, render_with, rgb, scene, sphere, v};
use crate::texture::{CheckerboardDesc, TextureDesc};

/// An empty scene, seen from the front.
fn nothing() -> SceneDesc {
    SceneDesc::default().seen_from_front(5.0, 50.0).sized([24, 16])
}

fn view(integrator: IntegratorDesc, desc: SceneDesc) -> Picture {
    render(&SceneDesc { integrator, ..desc }).0
}

fn depth(measure: DepthMeasure) -> IntegratorDesc {
    IntegratorDesc::Depth(DepthDesc { measure })
}

fn position() -> IntegratorDesc {
    IntegratorDesc::Position(PositionDesc::default())
}

fn uv() -> IntegratorDesc {
    IntegratorDesc::Uv(UvDesc::default())
}

fn albedo() -> IntegratorDesc {
    IntegratorDesc::Albedo(AlbedoDesc::default())
}

fn ids() -> IntegratorDesc {
    IntegratorDesc::Ids(IdsDesc::default())
}

fn cost() -> IntegratorDesc {
    IntegratorDesc::Cost(CostDesc::default())
}

fn wireframe(width: f64) -> IntegratorDesc {
    IntegratorDesc::Wireframe(WireframeDesc { width, ..WireframeDesc::default() })
}

/// A plane that faces the camera.
fn wall(z: f64) -> ShapeDesc {
    ShapeDesc::Plane(PlaneDesc { point: v(0.0, 0.0, z), normal: DVec3::Z })
}

fn ball() -> ShapeDesc {
    sphere(DVec3::ZERO, 1.5)
}

fn white() -> ClassicMaterial {
    ClassicMaterial { color: grey(1.0), ..ClassicMaterial::default() }
}

fn with_triangle(mut desc: SceneDesc) -> SceneDesc {
    let triangle = desc.mesh(MeshData {
        positions: vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 2.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    });
    desc.with(triangle, white())
}

/// The values of all pixels that hit something.
fn hits(picture: &Picture) -> Vec<[f64; 3]> {
    let hit = picture.linear.iter().filter(|p| p[3] == 1.0);
    hit.map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

#[test]
fn depth_of_a_plane_is_its_distance() {
    let seen = |measure| view(depth(measure), nothing().with_default(wall(0.0)));
    let axis = seen(DepthMeasure::Axis);
    assert_eq!(hits(&axis).len(), 24 * 16);
    assert!(hits(&axis).iter().all(|d| d.iter().all(|d| (d - 5.0).abs() < 1e-6)));
    // All depths are equal: the centre of the colour range.
    assert!(axis.display.iter().all(|c| *c == axis.display[0]));
    // Along the ray the depth is 5 over the cosine: p = 5 (tan x, tan y, 1).
    let distance = seen(DepthDesc::default().measure);
    let tan = (25f64.to_radians()).tan();
    for (i, d) in hits(&distance).iter().enumerate() {
        let (x, y) = ((i % 24) as f64 + 0.5 - 12.0, (i / 24) as f64 + 0.5 - 8.0);
        // The field of view is vertical.
        let expected = 5.0 * (1.0 + (x * x + y * y) * (tan / 8.0) * (tan / 8.0)).sqrt();
        assert!((d[0] - expected).abs() < 1e-5, "{d:?} {expected}");
    }
    // The nearest is the brightest, the farthest black.
    let [near, far] = [distance.display[7 * 24 + 11], distance.display[0]];
    assert_eq!((near, far), ([252, 253, 191, 255], [0, 0, 4, 255]));
}

#[test]
fn positions_lie_on_the_sphere() {
    let picture = view(position(), nothing().with_default(ball()));
    let found = hits(&picture);
    assert!(found.len() > 50 && found.len() < 24 * 16);
    for [x, y, z] in found {
        assert!(((x * x + y * y + z * z).sqrt() - 1.5).abs() < 1e-6 && z > 0.0);
    }
    // No position outside the sphere.
    assert_eq!(picture.linear[0], [0.0; 4]);
    assert_eq!(picture.display[0], [0; 4]);
}

#[test]
fn coordinates_run_along_the_edges() {
    let square = rectangle(DVec3::ZERO, v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0));
    let [uvs, at] = [uv(), position()].map(|show| view(show, nothing().with_default(square.clone())));
    assert!(!hits(&uvs).is_empty());
    for (uv, p) in hits(&uvs).iter().zip(hits(&at)) {
        assert!((uv[0] - (p[0] / 4.0 + 0.5)).abs() < 1e-6 && (uv[1] - (p[1] / 4.0 + 0.5)).abs() < 1e-6);
    }
    // Of repeated coordinates, the fractional part is shown.
    let wall = view(uv(), nothing().with_default(wall(0.0)));
    for (shown, p) in wall.display.iter().zip(hits(&wall)) {
        let expected = ((p[0] - p[0].floor()) * 255.0).round();
        assert!((f64::from(shown[0]) - expected).abs() <= 1.0, "{shown:?} {p:?}");
    }
}

#[test]
fn albedo_is_the_colour_without_light() {
    let dim = ClassicMaterial { color: rgb([0.5, 0.25, 0.125]), ka: 0.1, ..ClassicMaterial::default() };
    let picture = view(albedo(), nothing().before_color([0.25, 0.5, 1.0]).with(ball(), dim));
    assert_eq!(picture.linear[8 * 24 + 12], [0.5, 0.25, 0.125, 1.0]);
    assert_eq!(picture.linear[0], [0.25, 0.5, 1.0, 1.0]);
    let mut desc = nothing();
    let red = MatteMaterial { color: rgb([1.0, 0.0, 0.0]), ..MatteMaterial::default() };
    let blue = PrincipledMaterial { base_color: rgb([0.0, 0.0, 1.0]), ..PrincipledMaterial::default() };
    let materials = vec![desc.material(MaterialDesc::Matte(red)), desc.material(blue.into())];
    let mixed = view(albedo(), desc.with(ball(), MixMaterial { materials, weights: vec![grey(0.25)] }));
    assert_eq!(mixed.linear[8 * 24 + 12], [0.75, 0.0, 0.25, 1.0]);
}

#[test]
fn ids_are_indices_in_the_description() {
    let mut desc = nothing();
    let [one, two] = [(); 2].map(|()| desc.material(white().into()));
    let two = desc
        .with_shared(sphere(v(-1.0, 0.0, 0.0), 0.8), two)
        .with_shared(cuboid(v(0.5, -0.5, -0.5), v(1.5, 0.5, 0.5)), one);
    let picture = view(ids(), two);
    let mut seen: Vec<[u32; 2]> = hits(&picture).iter().map(|p| [p[0] as u32, p[1] as u32]).collect();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen, [[0, 1], [1, 0]]);
    let mut colors: Vec<[u8; 4]> = picture.display.clone();
    colors.sort_unstable();
    colors.dedup();
    assert_eq!(colors.len(), 3);
    let doubts = |antialias| {
        let mut desc = scene(ids()).seen_from_front(5.0, 50.0).with_default(ball());
        (desc.film.antialias, desc.film.samples) = (antialias, 16);
        let found = lint(&desc, &desc.prepare(&PrepareOptions::default()).unwrap());
        found.iter().filter(|w| w.message.contains("IDs cannot be averaged")).count()
    };
    assert_eq!((doubts(Antialias::None), doubts(Antialias::Mean)), (0, 1));
}

#[test]
fn rays_pass_through_holes() {
    // The front one of two walls has the holes of a checkerboard.
    let mut desc = nothing();
    let board = CheckerboardDesc { even: grey(0.0), odd: grey(1.0), ..CheckerboardDesc::default() };
    let opacity = desc.texture(TextureDesc::Checkerboard(board));
    let walls = desc.with(wall(1.0), ClassicMaterial { opacity, ..white() }).with_default(wall(0.0));
    let picture = view(depth(DepthMeasure::Axis), walls);
    let count = |depth: f64| hits(&picture).iter().filter(|d| (d[0] - depth).abs() < 1e-6).count();
    assert!(count(4.0) > 50 && count(5.0) > 50);
    assert_eq!(count(4.0) + count(5.0), 24 * 16);
}

#[test]
fn occlusion_by_formula() {
    let open = |more: Option<&ShapeDesc>, distance: f64| {
        let settings = AmbientOcclusionDesc { samples: 4096, distance };
        let camera = PinholeDesc { position: v(3.0, 1.0, 0.0), ..PinholeDesc::default() };
        let floor = scene(IntegratorDesc::AmbientOcclusion(settings)).seen(camera).with_default(plane());
        let desc = more.into_iter().fold(floor, |desc, shape| desc.with_default(shape.clone()));
        let (picture, stats) = render(&desc.sized([1, 1]));
        assert_eq!(stats.shadow, 4096);
        f64::from(picture.linear[0][0])
    };
    assert_eq!(open(None, 0.0), 1.0);
    // A wall occludes half of all directions at any distance.
    let wall = ShapeDesc::Plane(PlaneDesc { normal: DVec3::X, point: v(-2.0, 0.0, 0.0) });
    assert!((open(Some(&wall), 0.0) - 0.5).abs() < 2e-3);
    assert_eq!(open(Some(&wall), 1.5), 1.0);
    // A sphere above occludes (r / h)².
    let found = open(Some(&sphere(v(0.0, 2.0, 0.0), 1.0)), 0.0);
    assert!((found - 0.75).abs() < 2e-3, "{found}");
    let none = view(IntegratorDesc::AmbientOcclusion(AmbientOcclusionDesc::default()), nothing());
    assert!(none.linear.iter().all(|p| *p == [1.0; 4]));
}

#[test]
fn lines_have_their_width() {
    let large = nothing().sized([240, 160]);
    // The row of y = -0.5 crosses both long edges. Their slope is 1/2 in width per height, so a line is wider by
    // √(1 + 1/4) along x.
    for width in [1.0, 3.0] {
        let picture = view(wireframe(width), with_triangle(large.clone()));
        let row = &picture.linear[100 * 240..101 * 240];
        // Inside the triangle, surfaces are seen at a small angle.
        let inside: Vec<f32> = row.iter().filter(|p| p[0] < 1.0).map(|p| p[0]).collect();
        let dark: f64 = inside.iter().map(|v| (1.0 - f64::from(*v)).max(0.0)).sum();
        let shade: f64 = 0.02 * inside.len() as f64;
        // Only the half of each line on the triangle is drawn.
        let expected = 2.0 * (0.5 * width) * (1.25f64).sqrt();
        assert!((dark - expected).abs() < 0.6 + shade, "{dark} {expected}");
        assert!(picture.linear[150 * 240 + 120][0] > 0.9, "no line where none is");
    }
    // A sphere has lines of equal u and v: the equator covers the two centre rows, and the next line is 20 rows
    // away.
    let ball = view(wireframe(2.0), large.with_default(ball()));
    let row = |y: usize| &ball.linear[y * 240 + 85..y * 240 + 155];
    for y in [79, 80] {
        assert!(row(y).iter().all(|p| p[0] < 0.01), "{y}: {:?}", row(y));
    }
    for y in [76, 84] {
        let light = row(y).iter().filter(|p| p[0] > 0.5).count();
        // The next meridians, 45 degrees away, are outside these columns.
        assert_eq!(light, 68, "{y}: all but the two columns of the central meridian");
    }
}

#[test]
fn cost_counts_boxes_and_tests_along_the_ray() {
    // Shapes in the sphere culler and planes are tested one by one.
    let away = ShapeDesc::Plane(PlaneDesc { normal: DVec3::NEG_Z, ..PlaneDesc::default() });
    let picture = view(cost(), nothing().with_default(wall(0.0)).with_default(away));
    assert!(hits(&picture).iter().all(|c| *c == [2.0, 0.0, 2.0]));
    // One triangle: one node, one block where its box is hit, and nothing else.
    let picture = view(cost(), with_triangle(nothing()));
    let found = hits(&picture);
    assert_eq!(found.len(), 24 * 16, "rays that hit nothing cost something, too");
    let most = found.iter().map(|c| c[0]).fold(0.0, f64::max);
    assert!((1.0..=3.0).contains(&most) && found.iter().any(|c| c[0] < most), "{most}");
    assert!(found.iter().all(|c| c[0] == c[1] + c[2]));
}

#[test]
fn threads_change_nothing() {
    for integrator in [
        IntegratorDesc::Depth(DepthDesc::default()),
        position(),
        uv(),
        albedo(),
        ids(),
        IntegratorDesc::Wireframe(WireframeDesc::default()),
        IntegratorDesc::AmbientOcclusion(AmbientOcclusionDesc::default()),
        cost(),
        IntegratorDesc::Normals(NormalsDesc::default()),
    ] {
        let desc = SceneDesc { integrator, ..nothing() }.filmed([40, 40], 4).before(0.5);
        let desc = with_triangle(desc.with_default(ball())).with_default(wall(-1.0));
        let (one, three) = (render_with(&desc, 1, u32::MAX).0, render_with(&desc, 3, 1).0);
        assert_eq!(one, three, "{}", desc.integrator.type_name());
    }
}
