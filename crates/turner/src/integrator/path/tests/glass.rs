//! Smooth glass: transmission, absorption, nested solids.

use crate::description::SceneDesc;
use crate::integrator::PathDesc;
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::schema::ColorSource;
use crate::shape::ShapeDesc;
use crate::testing::scenes::{Mean, cuboid, emissive, grey, mean, path, rectangle, rgb, v};
use crate::texture::{CheckerboardDesc, TextureDesc};

/// A camera that looks along the z axis, from distance 10.
fn along_z(desc: PathDesc) -> SceneDesc {
    path(desc).seen_from_front(10.0, 0.001)
}

fn empty() -> SceneDesc {
    along_z(PathDesc { max_depth: 200, ..PathDesc::default() })
}

/// A wall with emission 1, seen through `between`; everything else is black.
fn through(between: SceneDesc) -> Mean {
    let wall = rectangle(v(0.0, 0.0, -10.0), v(9.0, 0.0, 0.0), v(0.0, 9.0, 0.0));
    mean(256, between.with(wall, emissive(1.0, grey(1.0))))
}

fn glass(ior: f64) -> PrincipledMaterial {
    PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        specular_ior: ior,
        ..PrincipledMaterial::default()
    }
}

/// Glass of index 1.5 that transmits this colour over a distance of 4.
fn tinted(color: ColorSource) -> PrincipledMaterial {
    PrincipledMaterial { transmission_color: color, transmission_depth: 4.0, ..glass(1.5) }
}

const TINT: [f64; 3] = [0.25, 0.5, 1.0];

fn slab([from, to]: [f64; 2]) -> ShapeDesc {
    cuboid(v(-5.0, -5.0, from), v(5.0, 5.0, to))
}

fn reflectance(a: f64, b: f64) -> f64 {
    ((a - b) / (a + b)).powi(2)
}

/// Transmission of a slab with face reflectances r and s and internal transmittance a, all internal reflections
/// included.
fn passes(r: f64, s: f64, a: f64) -> f64 {
    (1.0 - r) * (1.0 - s) * a / (1.0 - r * s * a * a)
}

/// Transmission of a tinted slab of index 1.5 and thickness 2.
fn passes_tinted() -> [f64; 3] {
    let r = reflectance(1.0, 1.5);
    TINT.map(|c| passes(r, r, c.powf(2.0 / 4.0)))
}

#[test]
fn a_slab_passes_what_its_faces_do_not_reflect() {
    for ior in [1.2, 1.5, 2.4] {
        let r = reflectance(1.0, ior);
        through(empty().with(slab([-1.0, 1.0]), glass(ior))).is_grey(passes(r, r, 1.0), 0.01);
    }
}

#[test]
fn glass_absorbs_along_the_path() {
    through(empty().with(slab([-1.0, 1.0]), tinted(rgb(TINT)))).is(passes_tinted(), 0.01);
}

/// A texture is evaluated where light enters.
#[test]
fn glass_absorbs_by_its_texture() {
    let mut desc = empty();
    let (even, odd) = (rgb(TINT), rgb(TINT));
    let board = desc.texture(TextureDesc::Checkerboard(CheckerboardDesc { even, odd, ..Default::default() }));
    through(desc.with(slab([-1.0, 1.0]), tinted(board))).is(passes_tinted(), 0.01);
}

#[test]
fn solids_of_one_material_are_one_where_they_overlap() {
    let mut desc = empty();
    let glass = desc.material(MaterialDesc::Principled(tinted(rgb(TINT))));
    let both = desc.with_shared(slab([-1.0, 0.4]), glass).with_shared(slab([-0.3, 1.0]), glass);
    through(both).is(passes_tinted(), 0.01);
}

/// A liquid that overlaps its glass: the boundary between them is that of the glass.
#[test]
fn the_denser_of_overlapping_solids_has_priority() {
    let (air, between) = (reflectance(1.0, 1.5), reflectance(1.5, 1.33));
    // Glass from 1 to 2, water from −2 to 1.3 or exactly to 1: rays see glass, then water.
    let overlapping =
        through(empty().with(slab([1.0, 2.0]), glass(1.5)).with(slab([-2.0, 1.3]), glass(1.33)));
    let wet = reflectance(1.33, 1.0);
    // Three faces: the first two as a slab with inner reflectance, then with the third.
    let t12 = passes(air, between, 1.0);
    let back = between + (1.0 - between).powi(2) * air / (1.0 - air * between);
    let expected = t12 * (1.0 - wet) / (1.0 - back * wet);
    overlapping.is_grey(expected, 0.01);
}

#[test]
fn rays_pass_thin_walls_and_hundreds_of_shells() {
    // 64 nested shells of glass with air inside, of a clear material that reflects nothing.
    let mut desc =
        along_z(PathDesc { max_depth: 1000, rr_start: Some(1000), ..PathDesc::default() }).before(1.0);
    let clear = PrincipledMaterial { specular_weight: grey(0.0), ..glass(1.5) };
    let clear = desc.material(MaterialDesc::Principled(clear));
    for i in 0..64 {
        let (outer, inner) = (4.0 - 0.06 * f64::from(i), 3.97 - 0.06 * f64::from(i));
        desc = desc.with_shared(slab([-outer, -inner]), clear).with_shared(slab([inner, outer]), clear);
    }
    mean(4, desc).is_grey(1.0, 1e-6);
}
