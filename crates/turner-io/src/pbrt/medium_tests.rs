//! Tests of media.

use turner::color::Spectrum;
use turner::description::ObjectContent;
use turner::material::MaterialDesc;
use turner::math::DVec3;
use turner::medium::{GridBorder, GridMedium, MediumDesc};
use turner::schema::{GridScattering, Warning};
use turner::shape::ShapeDesc;

use super::tests::{read, read_with};

#[test]
fn a_grid_around_the_camera_is_a_box() {
    let scene = read(
        "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"float density\" [ 1 2 ] \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1\n\
         \"point3 p0\" [ 0 0 2 ] \"point3 p1\" [ 1 1 3 ] MediumInterface \"\" \"smoke\" Camera \"perspective\" WorldBegin\n\
         MediumInterface \"\" \"\" Shape \"sphere\"",
    );
    assert_eq!(scene.background.medium, None);
    let [sphere, smoke] = &scene.objects[..] else { panic!("{:?}", scene.objects) };
    assert!(matches!(sphere.content, ObjectContent::Shape(ShapeDesc::Sphere(_))));
    let ObjectContent::Shape(ShapeDesc::Box(bounds)) = &smoke.content else { panic!("{smoke:?}") };
    assert_eq!(bounds.min, Some(DVec3::new(0.0, 0.0, 2.0)));
    let material = &scene.materials[smoke.material.unwrap().index()].value;
    let MaterialDesc::Interface(boundary) = material else { panic!("{material:?}") };
    let MediumDesc::Grid(grid) = &scene.media[boundary.interior.unwrap().index()].value else { panic!() };
    assert_eq!(grid.border, GridBorder::Fade);
}

/// Placed by its transform and the medium's; the density fades within the cell around its voxels.
#[test]
fn nanovdb_files_are_grids() {
    let cloud = include_bytes!("../testing/cloud.nvdb");
    let load = |text: &str| {
        let text = format!(
            "Scale 2 2 2 MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"c.nvdb\"\n\
             \"float scale\" 3 \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [4 5 6] \"float g\" 0.5 {text} WorldBegin Shape \"sphere\""
        );
        let scene = read_with(&text, &[("c.nvdb", cloud)]).unwrap();
        (scene.media[0].value.clone(), scene.warnings)
    };
    let (MediumDesc::Grid(grid), warnings) = load("") else { panic!() };
    assert!(warnings.is_empty(), "{warnings:?}");
    let [min, max] = grid.bounds();
    assert!((min - DVec3::new(-29.5, -0.5, 4.5)).length() < 1e-6, "{min}");
    assert!((max - DVec3::new(32.5, 12.5, 43.5)).length() < 1e-6, "{max}");
    assert_eq!(grid.file.data.size(), [62, 13, 39]);
    assert_eq!((grid.density, grid.anisotropy), (3.0, 0.5));
    assert_eq!(grid.scattering, Some(Spectrum::new(4.0, 5.0, 6.0)));
    let (MediumDesc::Homogeneous(empty), warnings) = load("\"string gridname\" \"heat\"") else { panic!() };
    assert_eq!(empty.density, 0.0);
    assert!(warnings[0].message.contains("has no grid \"heat\""), "{warnings:?}");
}

/// Any grid may be that of temperatures; pbrt emits σa times the light of black bodies.
#[test]
fn hot_grids_glow() {
    let cloud = include_bytes!("../testing/cloud.nvdb");
    let load = |text: &str| {
        let text = format!(
            "Rotate 90 1 0 0 MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"c.nvdb\"\n\
             \"string temperaturename\" \"density\" \"rgb sigma_a\" [1 2 3] {text} WorldBegin Shape \"sphere\""
        );
        let scene = read_with(&text, &[("c.nvdb", cloud)]).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let MediumDesc::Grid(grid) = scene.media[0].value.clone() else { panic!() };
        grid
    };
    let grid = load("\"float LeScale\" 5 \"float temperaturescale\" 100 \"float temperaturecutoff\" 1");
    assert_eq!((grid.temperature_scale, grid.temperature_offset), (100.0, 1.0));
    assert_eq!(grid.emission, Spectrum::new(5.0, 10.0, 15.0));
    let hot = grid.temperature.as_ref().unwrap();
    assert_eq!(hot.data.density(), grid.file.data.density());
    assert_eq!(hot.data.bounds().unwrap(), grid.bounds());
    assert_eq!(grid.file.data.bounds().unwrap(), grid.bounds());
    assert!(grid.prepare().is_ok());
    assert_eq!(load("\"float Lescale\" 0").temperature, None);
    let scene = read(&format!(
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" {TWO} \"float density\" [1 2]\n\
         \"float temperature\" [10 20] \"float temperatureoffset\" 2 WorldBegin Shape \"sphere\""
    ));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let MediumDesc::Grid(grid) = &scene.media[0].value else { panic!() };
    assert_eq!(grid.temperature.as_ref().unwrap().data.density(), [10.0, 20.0]);
    assert_eq!((grid.temperature_offset, grid.emission), (2.0, Spectrum::WHITE));
}

/// Clouds in the unit cube keep their parameters; of other boxes they become a grid.
#[test]
fn clouds_are_clouds() {
    let load = |before: &str, text: &str| {
        let scene = read(&format!(
            "{before} MakeNamedMedium \"m\" \"string type\" \"cloud\" \"float density\" 2 \"float wispiness\" 0.5\n\
             \"float frequency\" 4 \"rgb sigma_s\" [1 2 3] {text} WorldBegin Shape \"sphere\""
        ));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene.media[0].value.clone()
    };
    let MediumDesc::Cloud(cloud) = load("Translate 1 2 3 Scale 2 3 4", "") else { panic!() };
    assert_eq!((cloud.min, cloud.max), (DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, 5.0, 7.0)));
    assert_eq!((cloud.density, cloud.wispiness, cloud.frequency), (2.0, 0.5, 4.0));
    assert_eq!(cloud.scattering, Some(Spectrum::new(1.0, 2.0, 3.0)));
    // The lower half of the unit cube is full of clouds.
    let MediumDesc::Grid(grid) = load("", "\"point3 p0\" [0 0.25 0] \"point3 p1\" [1 1.25 1]") else {
        panic!()
    };
    let data = &grid.file.data;
    let [nx, ny, _] = data.size().map(|n| n as usize);
    assert_eq!([nx, ny], [160, 160]);
    assert!(data.density()[..nx].iter().all(|d| *d > 0.49));
    assert!(matches!(load("Rotate 90 1 0 0", ""), MediumDesc::Grid(_)));
}

/// The grid of a medium of one or several cells, and what was reported.
fn colored(cells: &str, parameters: &str) -> (GridMedium, Vec<Warning>) {
    let scene = read(&format!(
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" {cells} {parameters} WorldBegin Shape \"sphere\""
    ));
    let MediumDesc::Grid(grid) = scene.media[0].value.clone() else { panic!("{:?}", scene.warnings) };
    (grid, scene.warnings)
}

const TWO: &str = "\"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1";

#[test]
fn grids_of_colors_keep_their_coefficients() {
    let (grid, warnings) = colored(
        TWO,
        "\"rgb sigma_a\" [1 2 3 0 0.5 0] \"rgb sigma_s\" [4 0 1 0.5 0.25 2] \"float scale\" 3 \"float g\" 0.25\n\
         \"point3 p0\" [0 0 2] \"point3 p1\" [1 1 3]",
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((grid.border, grid.density, grid.anisotropy), (GridBorder::Fade, 3.0, 0.25));
    assert_eq!((grid.extinction, grid.albedo), (None, None));
    assert_eq!(grid.min, Some(DVec3::new(0.0, 0.0, 2.0)));
    let data = &grid.file.data;
    assert_eq!(data.extinction(), Some(&[[5.0, 2.0, 4.0], [0.5, 0.75, 2.0]][..]));
    let scattering = GridScattering::Coefficient(vec![[4.0, 0.0, 1.0], [0.5, 0.25, 2.0]]);
    assert_eq!(data.scattering(), Some(&scattering));
    assert_eq!(data.density(), [5.0, 2.0]);
    // A coefficient that is not given is 1.
    let (grid, _) = colored(TWO, "\"rgb sigma_a\" [1 2 3 0 0.5 0]");
    assert_eq!(grid.file.data.extinction(), Some(&[[2.0, 3.0, 4.0], [1.0, 1.5, 1.0]][..]));
    // A number of cells that is not the size of the grid.
    let scene = read(
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"rgb sigma_a\" [1 2 3 4 5 6] WorldBegin Shape \"sphere\"",
    );
    let MediumDesc::Homogeneous(empty) = &scene.media[0].value else { panic!() };
    assert_eq!(empty.density, 0.0);
    assert!(scene.warnings[0].message.contains("2 values of density for 1 cells"), "{:?}", scene.warnings);
}

/// pbrt emits σa Le: here of one colour, so that nothing is approximated.
#[test]
fn grids_of_colors_shine() {
    let emitted = |grid: &GridMedium, cell: usize| {
        let factor = grid.density * f64::from(grid.file.data.emission().unwrap()[cell]);
        grid.emission.to_array().map(|v| f64::from(v) * factor * f64::from(grid.file.data.density()[cell]))
    };
    let (grid, warnings) = colored(
        TWO,
        "\"rgb sigma_a\" [1 2 4 2 4 8] \"rgb sigma_s\" [1 1 1 1 1 9] \"rgb Le\" [3 2 1 1.5 1 0.5] \"float Lescale\" 2\n\
         \"float scale\" 10",
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    for cell in 0..2 {
        for (found, expected) in emitted(&grid, cell).into_iter().zip([60.0, 80.0, 80.0]) {
            assert!((found / expected - 1.0).abs() < 1e-5, "{cell}: {found}, not {expected}");
        }
    }
    let (_, warnings) = colored(TWO, "\"rgb sigma_a\" [1 1 1 1 1 1] \"rgb Le\" [1 0 0 0 1 0]");
    assert!(warnings[0].message.contains("mean colour"), "{warnings:?}");
}

#[test]
fn grids_of_colors_have_colors_for_every_cell() {
    for (parameters, expected) in [
        ("\"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [1 2 3 4 5 6]", "1 colours of \"sigma_a\" for 2 cells"),
        ("\"rgb sigma_a\" [1 2 3 4 5 6] \"rgb sigma_s\" [1 2 3]", "1 colours of \"sigma_s\" for 2 cells"),
        ("\"rgb sigma_a\" [1 2 3 4 5 6] \"rgb Le\" [1 2 3]", "1 colours of \"Le\" for 2 cells"),
        ("\"rgb sigma_s\" [1 2 3 4 5 6] \"rgb Le\" [1 2 3 4 5 6]", "without \"sigma_a\""),
    ] {
        let scene = read(&format!(
            "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" {TWO} {parameters} WorldBegin Shape \"sphere\""
        ));
        let MediumDesc::Homogeneous(empty) = &scene.media[0].value else { panic!("{parameters}") };
        assert_eq!(empty.density, 0.0);
        assert!(scene.warnings[0].message.contains(expected), "{:?}", scene.warnings);
    }
}

#[test]
fn nanovdb_media_need_a_filename() {
    let scene = read("MakeNamedMedium \"m\" \"string type\" \"nanovdb\" WorldBegin Shape \"sphere\"");
    assert!(scene.warnings[0].message.contains("without a filename"), "{:?}", scene.warnings);
}

#[test]
fn rotated_grids_keep_their_cells_or_fill_the_box_around() {
    let load = |rotation: &str| {
        let scene = read(&format!(
            "{rotation} MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"float density\" [1 2] {TWO}\n\
             \"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1] WorldBegin Shape \"sphere\""
        ));
        let MediumDesc::Grid(grid) = scene.media[0].value.clone() else { panic!("{:?}", scene.warnings) };
        (grid, scene.warnings)
    };
    for (rotation, size, density) in [
        ("Rotate 90 0 0 1", [1, 2, 1], [1.0, 2.0]),
        ("Rotate -90 0 0 1", [1, 2, 1], [2.0, 1.0]),
        ("Rotate 90 0 1 0", [1, 1, 2], [2.0, 1.0]),
        ("Scale -1 1 1", [2, 1, 1], [2.0, 1.0]),
    ] {
        let (grid, warnings) = load(rotation);
        assert_eq!((grid.file.data.size(), grid.file.data.density()), (size, &density[..]), "{rotation}");
        assert!((grid.min.unwrap() + 1.0).length() < 1e-6 && (grid.max.unwrap() - 1.0).length() < 1e-6);
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    let (grid, warnings) = load("Rotate 45 0 0 1");
    let corner = DVec3::new(2f64.sqrt(), 2f64.sqrt(), 1.0);
    assert!((grid.min.unwrap() + corner).length() < 1e-6 && (grid.max.unwrap() - corner).length() < 1e-6);
    assert!(warnings[0].message.contains("rotated"), "{warnings:?}");
}
