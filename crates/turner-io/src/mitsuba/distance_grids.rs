//! `sdfgrid`: the surface of a grid of signed distances. The grid fills the unit cube, with its first and its last values
//! on the faces.

use std::sync::Arc;

use turner::math::DVec3;
use turner::schema::GridFile;
use turner::shape::ShapeDesc;
use turner::shape::solid::DistanceGridDesc;

use super::assembly::Assembly;
use super::params::Object;
use super::volumes::Cells;
use crate::assets::printable;
use crate::grid::MAX_GRID;
use crate::scene_import::report::Fault;

/// The shape; `None` if there is no grid, or none that can be read.
pub(super) fn shape(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<ShapeDesc>, Fault> {
    let normals = object.word("normals", &["smooth", "analytic"], &mut scene.report)?;
    // For differentiable rendering.
    object.pass(&["watertight"]);
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        scene.report.ignored(object.place, format!("{} without filename: omitted", object.title()));
        return Ok(None);
    };
    let place = object.place_of("filename");
    let (_, bytes) = scene.read(&name, MAX_GRID, place)?;
    let what = || format!("{}: reading it", printable(&name));
    let memory = &scene.options.limits.memory;
    memory.need(bytes.len() as u64, what).map_err(|e| Fault::from_scene(place, e))?;
    match Cells::distances(&bytes) {
        Ok(data) => Ok(Some(ShapeDesc::DistanceGrid(DistanceGridDesc {
            file: GridFile { uri: name, data: Arc::new(data) },
            min: Some(DVec3::ZERO),
            max: Some(DVec3::ONE),
            level: 0.0,
            // The faces of the box stay open.
            capped: false,
            smooth: normals == "smooth",
        }))),
        Err(problem) => {
            let message = format!("{}: {problem}; the shape is omitted", printable(&name));
            scene.report.ignored(place, message);
            Ok(None)
        }
    }
}

#[cfg(test)]
mod tests {
    use turner::description::{ObjectContent, SceneDesc};
    use turner::math::Ray;
    use turner::schema::{Limits, Memory, SceneError};
    use turner::shape::{MeshCache, Shape};

    use super::super::volumes::tests::file;
    use super::*;
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    fn read(inner: &str, bytes: Vec<u8>, memory: Memory) -> Result<SceneDesc, SceneError> {
        let text = format!(
            "<scene version='3.0.0'><shape type='shapegroup' id='g'><shape type='sdfgrid'>\
             <string name='filename' value='d.vol'/>{inner}</shape></shape>\
             <shape type='instance'><ref id='g'/></shape></scene>"
        );
        let mut assets = MemoryAssets::default();
        assets.files.insert("d.vol".into(), bytes);
        let limits = Limits { memory: Arc::new(memory), ..Limits::default() };
        let options = ImportOptions { limits, ..ImportOptions::default() };
        crate::mitsuba::import_from(text.into_bytes(), "a.xml", &assets, &options)
    }

    /// Values that rise along x from -0.5 to 1.5: the surface is at a quarter of the way.
    fn slope() -> Vec<f32> {
        (0..12).map(|i| (i % 3) as f32 - 0.5).collect()
    }

    #[test]
    fn the_first_and_the_last_values_lie_on_the_faces_of_the_unit_cube() {
        let bytes = file([3, 2, 2], 1, &slope());
        let inner = "<transform name='to_world'><scale value='4'/><translate x='10'/></transform>\
                     <string name='normals' value='analytic'/>";
        let scene = read(inner, bytes, Memory::default()).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let object = &scene.groups[0].value.objects[0];
        let ObjectContent::Shape(desc) = &object.content else { panic!() };
        let ShapeDesc::DistanceGrid(grid) = desc else { panic!("{desc:?}") };
        assert!(!grid.smooth && grid.file.data.has_distances());
        assert_eq!(grid.file.data.density(), slope());
        let shape: Shape = desc.prepare(&mut MeshCache::new(&[])).unwrap();
        let place = object.transform.0;
        let ray = Ray::new(DVec3::new(20.0, 1.0, 3.0), DVec3::NEG_X).transformed(&place.inverse());
        let hit = shape.intersect(&ray).unwrap();
        assert!((hit.t - 9.0).abs() < 1e-12, "{}", hit.t);
        let n = shape.surface(&ray, &hit).ns;
        assert!((n - DVec3::X).length() < 1e-12, "{n}");
    }

    #[test]
    fn grids_that_cannot_be_read_are_omitted() {
        let nan = [&slope()[..11], &[f32::NAN]].concat();
        for (bytes, problem) in [
            (file([3, 2, 2], 1, &slope()[..11]), "more than the file holds"),
            (file([12, 1, 1], 1, &slope()), "expected 2 or more"),
            (file([2, 2, 1], 3, &slope()), "3 channels"),
            (file([3, 2, 2], 1, &nan), "is NaN"),
            (b"VOL\x03".to_vec(), "truncated"),
            (b"VOL\x02".to_vec(), "version 3"),
        ] {
            let scene = read("", bytes, Memory::default()).unwrap();
            let warnings: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
            assert!(warnings[0].contains(problem), "{warnings:?}");
            assert!(scene.objects.is_empty());
        }
        let large = file([100, 100, 100], 1, &[1.0; 1_000_000]);
        let error = read("", large, Memory::new(1_000_000, || None)).unwrap_err();
        assert!(error.message.contains("d.vol: reading it needs"), "{}", error.message);
    }

    /// Mitsuba's (u, v) are 0 everywhere on the surface.
    #[test]
    fn textures_have_one_colour() {
        let inner = "<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>\
                     <rgb name='color0' value='0.25'/><rgb name='color1' value='0.75'/></texture></bsdf>";
        let scene = read(inner, file([3, 2, 2], 1, &slope()), Memory::default()).unwrap();
        assert!(scene.textures.is_empty() && scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}
