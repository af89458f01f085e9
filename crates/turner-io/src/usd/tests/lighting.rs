//! Cameras and lights.

use super::*;
use std::f64::consts::PI;
use turner::camera::Viewport;
use turner::math::DVec2;

fn camera(more: &str) -> CameraDesc {
    read(&format!("def Camera \"C\" {{ {more} }}")).camera.unwrap().value
}

#[test]
fn cameras_have_the_angle_of_their_aperture() {
    let place = "matrix4d xformOp:transform = ((0, 0, -1, 0), (0, 1, 0, 0), (1, 0, 0, 0), (4, 5, 6, 1))\n\
                 uniform token[] xformOpOrder = [\"xformOp:transform\"]";
    let CameraDesc::Pinhole(c) =
        camera(&format!("float focalLength = 12\n float verticalAperture = 24\n{place}"))
    else {
        panic!()
    };
    assert!((c.fov.unwrap() - 90.0).abs() < 1e-9);
    near(c.position, DVec3::new(4.0, 5.0, 6.0));
    near((c.look_at - c.position).normalize(), DVec3::NEG_X);
    let CameraDesc::Pinhole(c) =
        camera("float horizontalApertureOffset = 2.0955\n float verticalApertureOffset = -1.52908")
    else {
        panic!()
    };
    assert!((c.shift.x - 0.1).abs() < 1e-6 && (c.shift.y + 0.1).abs() < 1e-6, "{:?}", c.shift);
    let CameraDesc::ThinLens(c) =
        camera("float focalLength = 50\n float fStop = 2.5\n float focusDistance = 7")
    else {
        panic!()
    };
    // 50 tenths of a metre.
    assert!((c.lens_radius - 1.0).abs() < 1e-9 && c.focus_distance == Some(7.0));
    let CameraDesc::Orthographic(c) = camera(
        "token projection = \"orthographic\"\n float verticalAperture = 30\n float2 clippingRange = (0.5, 9)",
    ) else {
        panic!()
    };
    assert_eq!((c.viewport, c.near), (Viewport::Height(3.0), 0.5));
}

/// Parts of a square with corners at x and y of ±1, 10 units before a camera of 90°, seen through 20 by 20 pixels.
#[test]
fn a_square_covers_the_pixels_that_it_should() {
    let square = "def Mesh \"S\" { int[] faceVertexCounts = [4]\n int[] faceVertexIndices = [0, 1, 2, 3]\n\
                  point3f[] points = [(2, 1, -10), (4, 1, -10), (4, 5, -10), (2, 5, -10)]\n color3f[] primvars:displayColor = [(1, 1, 1)] }\n\
                  def Camera \"C\" { float focalLength = 10\n float verticalAperture = 20\n float horizontalAperture = 20 }\n\
                  def DomeLight \"D\" {}";
    let mut scene = read(square);
    (scene.film.width, scene.film.height) = (20, 20);
    let prepared = scene.prepare(&Default::default()).unwrap();
    for y in 0..20 {
        for x in 0..20 {
            // A pixel is one unit wide at the distance of the square; row 0 is at the top.
            let at = DVec2::new(f64::from(x) - 9.5, 9.5 - f64::from(y)) / 10.0;
            let ray = prepared.view.camera.ray(at, DVec2::ZERO);
            let hit = prepared.scene.intersect(&ray).is_some();
            assert_eq!(hit, (12..14).contains(&x) && (5..9).contains(&y), "{x} {y}");
        }
    }
}

fn lights(text: &str) -> Vec<LightDesc> {
    read(text).lights.into_iter().map(|l| l.value).collect()
}

#[test]
fn distant_lights_have_the_irradiance_of_their_disc() {
    let one = |more: &str| match lights(&format!("def DistantLight \"L\" {{ {more} }}")).remove(0) {
        LightDesc::Directional(d) => d,
        other => panic!("{other:?}"),
    };
    let sun = one("");
    let half = 0.265_f64.to_radians();
    // sin² of a small angle.
    let expected = 50_000.0 * PI * half * half;
    assert!((sun.intensity / expected - 1.0).abs() < 1e-4, "{}", sun.intensity);
    near(sun.direction.unwrap(), DVec3::NEG_Z);
    let sun = one(
        "float inputs:intensity = 3\n bool inputs:normalize = 1\n float inputs:angle = 2\n float inputs:exposure = 1",
    );
    assert!((sun.intensity - 6.0).abs() < 1e-9);
    // Older files lack "inputs:".
    assert!((one("float intensity = 3\n float angle = 0").intensity - 3.0).abs() < 1e-9);
}

#[test]
fn lights_with_an_area_are_shapes_that_emit() {
    let radiance = |text: &str| {
        let scene = read(text);
        assert!(scene.objects[0].hidden_from_camera);
        let m = principled(&scene, 0);
        (m.emission_luminance, m.emission_front_only)
    };
    assert_eq!(radiance("def SphereLight \"L\" { float inputs:intensity = 5 }"), (5.0, false));
    let (found, _) =
        radiance("def SphereLight \"L\" { float inputs:intensity = 5\n bool inputs:normalize = 1 }");
    assert!((found - 5.0 / PI).abs() < 1e-9, "{found}");
    let rectangle = "float inputs:width = 2\n float inputs:height = 4\n bool inputs:normalize = 1\n float inputs:intensity = 8";
    assert_eq!(radiance(&format!("def RectLight \"L\" {{ {rectangle} }}")), (1.0, true));
    // The size is that after the transform.
    let scaled = "float3 xformOp:scale = (2, 2, 2)\n uniform token[] xformOpOrder = [\"xformOp:scale\"]";
    let (found, _) = radiance(&format!("def RectLight \"L\" {{ {rectangle}\n{scaled} }}"));
    assert!((found - 0.25).abs() < 1e-12, "{found}");
    let (found, _) = radiance("def DiskLight \"L\" { float inputs:radius = 2\n bool inputs:normalize = 1 }");
    assert!((found - 0.25 / PI).abs() < 1e-12, "{found}");
    let (found, _) = radiance(
        "def CylinderLight \"L\" { float inputs:length = 3\n float inputs:radius = 1\n bool inputs:normalize = 1 }",
    );
    assert!((found - 1.0 / (6.0 * PI)).abs() < 1e-12, "{found}");
}

/// A rectangular light emits along −z: a diffuse plane far below a small light of radiance L and area A, at a distance
/// d, has the irradiance L·A/d².
#[test]
fn a_rectangular_light_has_a_known_irradiance() {
    let text = "def RectLight \"L\" { float inputs:intensity = 900\n float inputs:width = 0.1\n float inputs:height = 0.1\n\
                double3 xformOp:translate = (0, 3, 0)\n float xformOp:rotateX = -90\n\
                uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateX\"] }\n\
                def Plane \"P\" { uniform token axis = \"Y\"\n double width = 9\n double length = 9\n color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)] }\n\
                def Camera \"C\" { float verticalAperture = 1\n double3 xformOp:translate = (0, 2, 0)\n float xformOp:rotateX = -90\n\
                uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateX\"] }";
    let mut scene = read(text);
    for material in &mut scene.materials {
        if let MaterialDesc::Principled(m) = &mut material.value {
            m.specular_weight = ColorSource::Constant(Spectrum::BLACK);
        }
    }
    (scene.film.width, scene.film.height, scene.film.samples) = (4, 4, 64);
    scene.integrator = turner::integrator::IntegratorDesc::Path(Default::default());
    let radiance = mean(&scene);
    // Albedo / π · L·A/d².
    let expected = 0.5 / PI * 900.0 * 0.01 / 9.0;
    assert!((radiance / expected - 1.0).abs() < 0.01, "{radiance} {expected}");
}

/// The mean radiance of a picture.
fn mean(scene: &SceneDesc) -> f64 {
    let mut renderer = turner::Renderer::new(scene.prepare(&Default::default()).unwrap()).unwrap();
    let cancel = std::sync::atomic::AtomicBool::new(false);
    let options = turner::PassOptions { threads: 1, cancel: &cancel, progress: None };
    renderer.pass(renderer.samples_per_pixel(), &options).unwrap();
    let picture = renderer.develop().linear;
    picture.iter().map(|p| f64::from(p[1])).sum::<f64>() / picture.len() as f64
}

#[test]
fn cones_make_spots_and_temperatures_colours() {
    let LightDesc::Spot(spot) = lights(
        "def SphereLight \"L\" { float inputs:radius = 0.5\n float inputs:intensity = 4\n float inputs:shaping:cone:angle = 30\n\
         float inputs:shaping:cone:softness = 0.5 }",
    )
    .remove(0) else {
        panic!()
    };
    assert!((spot.intensity - PI).abs() < 1e-9, "{}", spot.intensity);
    assert_eq!((spot.angle, spot.penumbra), (30.0, 15.0));
    near(spot.look_at.normalize(), DVec3::NEG_Z);
    assert!((spot.radius - 0.5).abs() < 1e-12, "{}", spot.radius);
    let LightDesc::Point(point) =
        lights("def SphereLight \"L\" { float inputs:radius = 0\n float inputs:intensity = 8\n bool inputs:normalize = 1 }").remove(0)
    else {
        panic!()
    };
    assert!((point.intensity - 2.0).abs() < 1e-9);
    let warm = "bool inputs:enableColorTemperature = 1\n float inputs:colorTemperature = 3000";
    let LightDesc::Directional(sun) = lights(&format!("def DistantLight \"L\" {{ {warm} }}")).remove(0)
    else {
        panic!()
    };
    assert!(sun.color.r > 1.0 && sun.color.b < 0.5, "{:?}", sun.color);
}

/// OpenEXR: the centre of the image is at +z, longitude π/2, left of the centre, at +x.
#[test]
fn domes_have_the_orientation_of_openexr() {
    let mut assets = MemoryAssets::default();
    // Columns from left to right: red, green, blue, white.
    let mut pfm = b"PF\n4 2\n-1.0\n".to_vec();
    for _ in 0..2 {
        for c in [[1.0_f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]] {
            pfm.extend(c.map(f32::to_le_bytes).as_flattened());
        }
    }
    assets.files.insert("sky.pfm".into(), pfm);
    let radiance = |kind: &str, head: &str, more: &str, d: DVec3| {
        let text = format!(
            "#usda 1.0\n({head})\ndef {kind} \"D\" {{ asset inputs:texture:file = @sky.pfm@\n{more} }}"
        );
        let scene = import(text.into(), "a.usda", &assets, &ImportOptions::default()).unwrap();
        let LightDesc::Environment(light) = scene.lights[0].value.clone() else { panic!() };
        let found = light.prepare(&scene.images, false).unwrap().radiance(d.normalize());
        [found.r, found.g, found.b].map(|v| v > 0.6)
    };
    // The middles of the four columns have the longitudes 135°, 45°, −45° and −135°.
    for (d, color) in [
        (DVec3::new(1.0, 0.0, -1.0), [true, false, false]),
        (DVec3::new(1.0, 0.0, 1.0), [false, true, false]),
        (DVec3::new(-1.0, 0.0, 1.0), [false, false, true]),
        (DVec3::new(-1.0, 0.0, -1.0), [true, true, true]),
    ] {
        assert_eq!(radiance("DomeLight", "", "", d), color, "{d}");
        let turned = "float xformOp:rotateY = 90\n uniform token[] xformOpOrder = [\"xformOp:rotateY\"]";
        assert_eq!(radiance("DomeLight", "", turned, DVec3::new(d.z, 0.0, -d.x)), color, "{d}");
        // DomeLight has its pole at +y of the stage, which is −z of a scene made from z up.
        let up = "upAxis = \"Z\"";
        assert_eq!(radiance("DomeLight", up, "", DVec3::new(d.x, d.z, 0.0)), color, "{d}");
        // DomeLight_1 has its pole at +z of the stage, and +z of the image at −y.
        assert_eq!(radiance("DomeLight_1", up, "", d), color, "{d}");
    }
}

#[test]
fn lights_that_are_shapes_keep_the_studio_dark() {
    let mut assets = MemoryAssets::default();
    let notes = |assets: &MemoryAssets| {
        let loaded = crate::scene::load_from("a.usda", assets, &crate::LoadOptions::default()).unwrap();
        let prepared = loaded.desc.prepare(&Default::default()).unwrap();
        prepared.warnings.iter().any(|w| w.message.contains("no light in the file"))
    };
    let ball = "#usda 1.0\ndef Sphere \"S\" {}\n";
    assets.files.insert("a.usda".into(), ball.into());
    assert!(notes(&assets));
    let lit = format!(
        "{ball}def RectLight \"L\" {{ double xformOp:translateZ = 5\n uniform token[] xformOpOrder = [\"xformOp:translateZ\"] }}"
    );
    assets.files.insert("a.usda".into(), lit.into());
    assert!(!notes(&assets));
}
