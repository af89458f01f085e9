//! The layers of light by the lobe of the first surface: sums and formulas. And numbers of bounces.

use super::tests::Rendered;
use crate::description::SceneDesc;
use crate::film::Aov;
use crate::integrator::{BouncesDesc, Caustics, DirectDesc, IntegratorDesc, PathDesc, SharedPathsMode};
use crate::material::{DielectricMaterial, PrincipledMaterial};
use crate::medium::HomogeneousMedium;
use crate::testing::scenes::{
    cuboid, emissive, even, grey, lamp, matte, path, plane, rectangle, render, rgb, sphere, v,
};

const LAYERS: [&str; 7] = [
    "emission",
    "direct_diffuse",
    "direct_specular",
    "indirect_diffuse",
    "indirect_specular",
    "transmission",
    "volume",
];

fn aovs() -> Vec<Aov> {
    [Aov::Emission, Aov::Caustics].into_iter().chain(Aov::LOBES).collect()
}

/// Plastic with a coat, glass, a mirror, subsurface scattering, a lamp and a luminous sphere.
fn room(integrator: IntegratorDesc) -> SceneDesc {
    let plastic = PrincipledMaterial { coat_weight: grey(0.5), ..PrincipledMaterial::default() };
    let wax = PrincipledMaterial { subsurface_weight: grey(0.7), ..PrincipledMaterial::default() };
    let metal = PrincipledMaterial { base_metalness: grey(1.0), ..PrincipledMaterial::default() };
    SceneDesc { integrator, ..SceneDesc::default() }
        .with(plane(), matte(rgb([0.6, 0.5, 0.4])))
        .with(rectangle(v(0.0, 1.0, -1.5), v(5.0, 0.0, 0.0), v(0.0, 4.0, 0.0)), metal)
        .with(sphere(v(-0.5, 0.5, 0.0), 0.5), DielectricMaterial::default())
        .with(sphere(v(0.6, 0.4, 0.0), 0.4), plastic)
        .with(sphere(v(1.5, 0.4, 0.0), 0.4), wax)
        .with(sphere(v(0.0, 1.7, -0.5), 0.15), emissive(3.0, rgb([1.0, 0.8, 0.6])))
        .lit(lamp(v(2.0, 2.5, 2.0), 6.0))
        .seen_at(v(0.0, 1.2, 4.0), v(0.0, 0.6, 0.0), 45.0)
        .filmed([24, 16], 32)
}

/// For each way in which light is added: the layers add up to the picture, and none is negative.
#[test]
fn layers_of_lobes_add_up() {
    let path = |desc: PathDesc| IntegratorDesc::Path(PathDesc { max_depth: 6, ..desc });
    let off = PathDesc { caustics: Caustics::Off, ..PathDesc::default() };
    for integrator in [
        path(off.clone()),
        path(PathDesc { shared_paths: SharedPathsMode::Always, ..off.clone() }),
        path(PathDesc { clamp_indirect: 0.3, ..off }),
        path(PathDesc { caustics: Caustics::LightTracing, ..PathDesc::default() }),
        path(PathDesc { caustics: Caustics::Full, ..PathDesc::default() }),
        IntegratorDesc::Direct(DirectDesc::default()),
    ] {
        let mut desc = room(integrator.clone());
        (desc.film.samples, desc.film.clamp_sample) = (8, 3.0);
        for fog in [false, true] {
            if fog {
                let smoke = HomogeneousMedium { scattering: even(0.1), ..HomogeneousMedium::default() };
                desc = desc.filled(cuboid(v(-3.0, 0.01, -1.4), v(3.0, 2.4, 2.2)), smoke);
            }
            let r = Rendered::of(&desc, &aovs());
            for (i, band) in ["R", "G", "B"].iter().enumerate() {
                let caustics = r.channel(&format!("caustics.{band}"));
                let layers = LAYERS.map(|name| r.channel(&format!("{name}.{band}")));
                for (pixel, linear) in r.picture.linear.iter().enumerate() {
                    let sum: f64 = caustics[pixel] + layers.iter().map(|l| l[pixel]).sum::<f64>();
                    let exact = f64::from(linear[i]);
                    assert!((sum - exact).abs() < 2e-5, "{integrator:?} {fog} {pixel}: {sum} {exact}");
                    for (name, layer) in LAYERS.iter().zip(&layers) {
                        assert!(layer[pixel] > -2e-5, "{integrator:?} {fog} {name} {pixel} {}", layer[pixel]);
                    }
                }
                let is_direct = matches!(integrator, IntegratorDesc::Direct(_));
                for (name, layer) in LAYERS.iter().zip(&layers) {
                    let has_some = match *name {
                        "volume" => fog,
                        "indirect_diffuse" | "indirect_specular" => !is_direct,
                        _ => true,
                    };
                    assert!(!has_some || layer.iter().sum::<f64>() > 0.1, "{integrator:?} {fog} {name}");
                    assert!(has_some || *name != "volume" || layer.iter().all(|v| *v == 0.0));
                }
            }
        }
    }
}

/// The picture is the same with layers and without.
#[test]
fn layers_of_lobes_change_nothing() {
    let desc = room(IntegratorDesc::Path(PathDesc::default())).filmed([24, 16], 4);
    let (plain, _) = render(&desc);
    assert_eq!(Rendered::of(&desc, &aovs()).picture.linear, plain.linear);
}

/// A wall that only reflects diffusely, a mirror of it, and a lamp.
#[test]
fn a_matte_wall_is_direct_and_diffuse() {
    let wall = rectangle(v(0.0, 0.0, 0.0), v(20.0, 0.0, 0.0), v(0.0, 20.0, 0.0));
    let desc = path(PathDesc { caustics: Caustics::Off, ..PathDesc::default() })
        .with(wall, matte(grey(0.5)))
        .lit(lamp(v(0.0, 0.0, 3.0), 20.0))
        .seen_from_front(5.0, 60.0)
        .filmed([8, 6], 4);
    let r = Rendered::of(&desc, &aovs());
    let direct = r.channel("direct_diffuse.G");
    let picture = r.picture.linear.iter().map(|p| f64::from(p[1]));
    assert!(picture.zip(&direct).all(|(a, b)| (a - b).abs() < 1e-6 && *b > 0.0));
    for name in LAYERS.iter().filter(|name| **name != "direct_diffuse") {
        assert!(r.channel(&format!("{name}.G")).iter().all(|v| *v == 0.0), "{name}");
    }
}

/// Between two white walls a path continues until it is ended; towards the open it has one bounce.
#[test]
fn bounces_are_counted() {
    let wall = |z: f64| rectangle(v(0.0, 0.0, z), v(2000.0, 0.0, 0.0), v(0.0, 2000.0, 0.0));
    let paths =
        PathDesc { max_depth: 5, rr_start: Some(100), caustics: Caustics::Off, ..PathDesc::default() };
    let open =
        path(paths.clone()).with(wall(0.0), matte(grey(1.0))).seen_from_front(5.0, 60.0).filmed([8, 6], 4);
    let closed = open.clone().with(wall(6.0), matte(grey(1.0)));
    let view = |desc: &SceneDesc| {
        let bounces = BouncesDesc { max_depth: 5, rr_start: 100 };
        let (picture, _) =
            render(&SceneDesc { integrator: IntegratorDesc::Bounces(bounces), ..desc.clone() });
        picture
    };
    for (desc, expected) in [(open, 1.0), (closed, 5.0)] {
        let r = Rendered::of(&desc, &[Aov::Bounces]);
        assert!(r.channel("bounces").iter().all(|v| (*v - expected).abs() < 1e-6), "{expected}");
        assert!(view(&desc).linear.iter().all(|p| (f64::from(p[0]) - expected).abs() < 1e-6 && p[3] == 1.0));
    }
}
