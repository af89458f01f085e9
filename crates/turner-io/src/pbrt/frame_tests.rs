//! Tests of cameras, films and exposure.

use turner::camera::{CameraDesc, Handedness, Viewport};
use turner::film::ClampSpace;
use turner::filter::FilterKind;
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::math::{DVec2, DVec3};
use turner::medium::MediumDesc;
use turner::schema::WarningKind;

use super::tests::read;

#[test]
fn the_frame_is_the_files_own() {
    let scene = read(
        "LookAt 3 4 1.5  .5 .5 0  0 0 1\nCamera \"perspective\" \"float fov\" 45\nSampler \"halton\" \"integer pixelsamples\" 128\n\
         Integrator \"volpath\" \"integer maxdepth\" [ 7 ]\nPixelFilter \"gaussian\" \"float xradius\" [1.5] \"float yradius\" [1.5]\n\
         Film \"rgb\" \"string filename\" \"simple.png\" \"integer xresolution\" [400] \"integer yresolution\" [300]\nWorldBegin",
    );
    assert!(scene.warnings.iter().all(|w| w.kind == WarningKind::Note), "{:?}", scene.warnings);
    let f = &scene.film;
    assert_eq!(
        (f.width, f.height, f.samples, f.filter, f.filter_radius),
        (400, 300, 128, FilterKind::Gaussian, Some(1.5))
    );
    assert!(matches!(&scene.integrator, IntegratorDesc::Path(p) if p.max_depth == 7));
    let Some(CameraDesc::Pinhole(c)) = scene.camera.map(|c| c.value) else { panic!("a pinhole camera") };
    assert!((c.position - DVec3::new(3.0, 4.0, 1.5)).length() < 1e-9);
    assert!(
        (c.look_at - c.position).normalize().dot((DVec3::new(0.5, 0.5, 0.0) - c.position).normalize())
            > 1.0 - 1e-9
    );
    // A camera of pbrt is left-handed unless it is mirrored.
    assert_eq!(c.handedness, Handedness::Left);
    let Some(Viewport::Height(h)) = c.viewport else { panic!("a height") };
    assert!((h / 2.0 - 0.414_213_562).abs() < 1e-6);
}

#[test]
fn a_window_off_the_middle_shifts_the_screen() {
    let camera = |kind: &str| {
        let window = "\"float screenwindow\" [ -1 3 -2 1 ]";
        read(&format!("LookAt 0 0 -5 0 0 0 0 1 0 Camera \"{kind}\" \"float fov\" 90 {window} WorldBegin"))
    };
    let Some(CameraDesc::Pinhole(c)) = camera("perspective").camera.map(|c| c.value) else { panic!() };
    let Some(Viewport::Size(size)) = c.viewport else { panic!("both sides") };
    assert!((size - DVec2::new(4.0, 3.0)).length() < 1e-12, "{size}");
    assert!((c.shift - DVec2::new(0.25, -0.5 / 3.0)).length() < 1e-12, "{:?}", c.shift);
    let Some(CameraDesc::Orthographic(c)) = camera("orthographic").camera.map(|c| c.value) else { panic!() };
    // Right and up are +x and +y of a left-handed camera that looks along +z.
    assert!((c.position - DVec3::new(1.0, -0.5, -5.0)).length() < 1e-9, "{}", c.position);
    assert!((c.look_at - c.position).normalize().dot(DVec3::Z) > 1.0 - 1e-12);
}

#[test]
fn the_field_of_view_is_that_of_the_shorter_side() {
    let height_of = |text: &str| {
        let scene = read(&format!("{text}\nWorldBegin"));
        let Some(CameraDesc::Pinhole(c)) = scene.camera.map(|c| c.value) else { panic!("a pinhole camera") };
        assert_eq!(c.handedness, Handedness::Right);
        let Some(Viewport::Height(h)) = c.viewport else { panic!("a height") };
        h
    };
    let height = |film: &str| {
        let camera = "Scale -1 1 1\nCamera \"perspective\" \"float fov\" 90";
        let before = height_of(&format!("Film \"rgb\" {film}\n{camera}"));
        // The order of the two does not matter.
        assert_eq!(before, height_of(&format!("{camera}\nFilm \"rgb\" {film}")));
        before
    };
    assert!((height("\"integer xresolution\" 200 \"integer yresolution\" 100") - 2.0).abs() < 1e-9);
    assert!((height("\"integer xresolution\" 100 \"integer yresolution\" 200") - 4.0).abs() < 1e-9);
}

#[test]
fn daylight_of_the_white_balance_is_white() {
    let color = |film: &str| {
        let scene = read(&format!(
            "Film \"rgb\" {film} WorldBegin LightSource \"infinite\" \"spectrum L\" \"stdillum-D50\""
        ));
        let LightDesc::Environment(e) = &scene.lights[0].value else { panic!("an environment") };
        e.tint
    };
    let plain = color("");
    assert!(plain.r > 1.1 && plain.b < 0.75, "{plain:?}");
    let balanced = color("\"float whitebalance\" 5000");
    assert!(balanced.to_array().iter().all(|v| (v - 1.0).abs() < 0.02), "{balanced:?}");
}

#[test]
fn media_shine_as_the_film_that_follows_them_takes_them() {
    let medium = "MakeNamedMedium \"fire\" \"string type\" \"homogeneous\" \"rgb Le\" [ 1 1 1 ]";
    let film = "Film \"rgb\" \"float iso\" 400";
    let light = |text: &str| {
        let scene = read(&format!("{text} Shape \"sphere\""));
        let MediumDesc::Homogeneous(m) = &scene.media[0].value else { panic!() };
        m.emission
    };
    let before = light(&format!("{film} {medium} WorldBegin"));
    assert_eq!(before, light(&format!("{medium} {film} WorldBegin")));
    assert_eq!(before, light(&format!("{film} WorldBegin {medium}")));
    assert!((before.r - 4.0 * light(&format!("{medium} WorldBegin")).r).abs() < 1e-5, "{before:?}");
}

#[test]
fn bright_samples_are_cut() {
    let most = |film: &str| {
        let film = read(&format!("Film \"rgb\" {film} WorldBegin")).film;
        (film.clamp_sample, film.clamp_space)
    };
    assert_eq!(most(""), (0.0, ClampSpace::Rgb));
    assert_eq!(most("\"float maxcomponentvalue\" 10"), (10.0, ClampSpace::Xyz));
}

/// White balance at 3200 K and 4500 K of a light of another colour: Bradford's cone responses and their published inverse
/// (Lam 1985; Lindbloom), between CIE XYZ and linear Rec. 709 (IEC 61966-2-1).
#[test]
fn the_white_balance_is_bradfords() {
    let by = |m: [[f64; 3]; 3], v: [f64; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let (to_cones, to_xyz) = (
        [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
        [[0.986993, -0.147054, 0.159963], [0.432305, 0.51836, 0.0492912], [-0.00852866, 0.0400428, 0.968487]],
    );
    let to_rgb = [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.969266, 1.8760108, 0.041556],
        [0.0556434, -0.2040259, 1.0572252],
    ];
    let of_rgb = [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.072175],
        [0.0193339, 0.119192, 0.9503041],
    ];
    let color = |film: &str, light: &str| {
        let scene = read(&format!("Film \"rgb\" {film} WorldBegin LightSource \"infinite\" {light}"));
        let LightDesc::Environment(e) = &scene.lights[0].value else { panic!("an environment") };
        e.tint.to_array().map(f64::from)
    };
    // Chromaticities of a black body of 3201.8 K (by Planck's law) and of the D series at 4502.5 K (CIE 15).
    for (kelvin, [x, y]) in [(3200.0, [0.4231, 0.399]), (4500.0, [0.362, 0.3708])] {
        let light = "\"rgb L\" [1 .8 .5]";
        let plain = by(of_rgb, color("", light));
        let cones = |xyz| by(to_cones, xyz);
        let (from, to) = (cones([x / y, 1.0, (1.0 - x - y) / y]), cones([0.95047, 1.0, 1.08883]));
        let seen = cones(plain);
        let adapted = by(to_xyz, [0, 1, 2].map(|i| seen[i] * to[i] / from[i]));
        let expected = by(to_rgb, adapted);
        let found = color(&format!("\"float whitebalance\" {kelvin}"), light);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.01, "{kelvin}: {found:?} {expected:?}");
        }
    }
}
