//! Mitsuba's hair: the BSDF, and the shapes of curves.

use turner::color::Spectrum;
use turner::material::{HairMaterial, MaterialDesc};
use turner::math::DAffine3;
use turner::schema::{ColorSource, ErrorCode, MeshId};
use turner::shape::curves::{CurveBasis, CurveKind, CurvesDesc};

use super::assembly::Assembly;
use super::materials::Use;
use super::meshes::MAX_FILE;
use super::params::Object;
use super::spectra::{Role, index};
use super::textures::source;
use crate::mesh::{hair, mitsuba_hair};
use crate::scene_import::report::Fault;

/// `hair`.
pub(super) fn material(
    scene: &mut Assembly<'_>,
    object: &Object,
    usage: &Use,
) -> Result<MaterialDesc, Fault> {
    let ior = index(object, "int_ior", 1.55)? / index(object, "ext_ior", 1.000277)?;
    let number = |name: &'static str, or: f64, [from, to]: [f64; 2]| {
        Ok::<f64, Fault>(object.float(name)?.unwrap_or(or).clamp(from, to))
    };
    let mut hair = HairMaterial {
        ior: ior.clamp(1.0, 10.0),
        beta_m: number("longitudinal_roughness", 0.3, [0.0, 1.0])?,
        beta_n: number("azimuthal_roughness", 0.3, [0.0, 1.0])?,
        alpha: number("scale_tilt", 2.0, [-30.0, 30.0])?,
        eumelanin: number("eumelanin", 1.3, [0.0, 1e6])?,
        pheomelanin: number("pheomelanin", 0.2, [0.0, 1e6])?,
        ..HairMaterial::default()
    };
    let scale = number("scale", 1.0, [0.0, 1e6])?;
    if let Some((node, element)) = object.find("sigma_a") {
        let place = element.place;
        match source(scene, node, Role::Unbounded, usage.surface)? {
            ColorSource::Constant(c) => hair.sigma_a = Some(c),
            ColorSource::Texture(_) => {
                scene.report.approximated(place, "a texture of sigma_a of hair: brown hair replaces it");
            }
        }
    }
    hair.eumelanin *= scale;
    hair.pheomelanin *= scale;
    hair.sigma_a = hair.sigma_a.map(|c: Spectrum| c.map(|v| (v * scale as f32).clamp(0.0, 1e6)));
    if usage.emission.is_some() || usage.opacity.is_some() || usage.bump.is_some() || usage.normal.is_some() {
        let message = "an emitter, mask, bump map or normal map of hair: opaque hair without them";
        scene.report.ignored(object.place, message);
    }
    scene.finish(object);
    Ok(MaterialDesc::Hair(hair))
}

/// `bsplinecurve` and `linearcurve`: a text file.
pub(super) fn curves(scene: &mut Assembly<'_>, object: &Object) -> Result<CurvesDesc, Fault> {
    let place = object.place_of("filename");
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        let message = format!("{} needs a filename", object.title());
        return Err(Fault::at(object.place, ErrorCode::MissingKey, message));
    };
    let basis = if object.kind == "linearcurve" { CurveBasis::Linear } else { CurveBasis::BSpline };
    let id = of_file(scene, &name, object)?;
    let counts = scene.meshes.get(id.index()).map(|mesh| mesh.data.clone());
    if let Some(bad) =
        counts.iter().flat_map(|data| data.curve_counts()).find(|n| basis.segments(*n).is_none())
    {
        let message =
            format!("a curve of {bad} points in {}; expected 4 or more", crate::assets::printable(&name));
        return Err(Fault::at(place, ErrorCode::Mesh, message));
    }
    Ok(CurvesDesc { curves: id, width: None, basis, kind: CurveKind::Tube })
}

/// `hair` of Mitsuba 0.6: polylines of one radius, which the transform `to_world` does not change.
pub(super) fn polylines(
    scene: &mut Assembly<'_>,
    object: &Object,
    to_world: &DAffine3,
) -> Result<CurvesDesc, Fault> {
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        let message = format!("{} needs a filename", object.title());
        return Err(Fault::at(object.place, ErrorCode::MissingKey, message));
    };
    // Mitsuba leaves out points and hairs to save time.
    object.pass(&["angle_threshold", "reduction"]);
    let id = of_file(scene, &name, object)?;
    let radius = object.float("radius")?.unwrap_or(0.025);
    let scale = to_world.matrix3.x_axis.length();
    let width = Some(2.0 * radius / scale).filter(|width| width.is_finite() && *width > 0.0);
    let Some(width) = width else {
        return Err(Fault::at(object.place_of("radius"), ErrorCode::OutOfRange, "hair without a width"));
    };
    Ok(CurvesDesc { curves: id, width: Some(width), basis: CurveBasis::Linear, kind: CurveKind::Tube })
}

/// The curves of a file, which all shapes with its name share.
fn of_file(scene: &mut Assembly<'_>, name: &str, object: &Object) -> Result<MeshId, Fault> {
    let place = object.place_of("filename");
    let key = (format!("{name}\0curves"), false);
    if let Some(Some(known)) = scene.mesh_ids.get(&key) {
        return Ok(*known);
    }
    let (path, bytes) = scene.read(name, MAX_FILE, place)?;
    // A point takes at least six bytes of text, and 24 in memory while lists grow.
    let need = (bytes.len() as u64).saturating_mul(8);
    let limits = &scene.options.limits;
    limits.memory.need(need, || format!("{}: reading it", crate::assets::printable(&path)))?;
    let reader = if object.kind == "hair" { mitsuba_hair::read } else { hair::read_text };
    let read = reader(&bytes, &path).map_err(|e| {
        let message = e.to_string().lines().next().unwrap_or_default().to_owned();
        Fault::at(place, ErrorCode::Mesh, message)
    })?;
    for warning in read.warnings {
        scene.report.remark(warning);
    }
    let id = scene.mesh(String::new(), read.mesh);
    scene.mesh_ids.insert(key, Some(id));
    Ok(id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;
    use crate::mitsuba::import_from;
    use turner::description::{ObjectContent, SceneDesc};
    use turner::schema::SceneError;
    use turner::shape::ShapeDesc;

    fn read(inner: &str, file: &str) -> Result<SceneDesc, SceneError> {
        let text = format!("<scene version=\"3.0.0\">\n{inner}\n</scene>");
        let mut assets = MemoryAssets::default();
        assets.files.insert("fur.txt".into(), file.into());
        import_from(text.into_bytes(), "a.xml", &assets, &ImportOptions::default())
    }

    const CURVE: &str = "0 0 0 .1\n1 0 0 .1\n2 0 0 .1\n3 1 0 .2\n";

    #[test]
    fn hair_of_mitsuba_0_6_has_one_radius() {
        let text = "<scene version='0.6.0'><shape type='hair'><string name='filename' value='fur.txt'/>
            <float name='radius' value='0.1'/><float name='angleThreshold' value='2'/>
            <transform name='toWorld'><scale value='4'/></transform></shape></scene>";
        let mut assets = MemoryAssets::default();
        assets.files.insert("fur.txt".into(), "0 0 0\n1 0 0\n\n0 1 0\n0 2 0\n0 3 0\n".into());
        let scene = import_from(text.into(), "a.xml", &assets, &ImportOptions::default()).unwrap();
        let ObjectContent::Shape(ShapeDesc::Curves(curves)) = &scene.objects[0].content else { panic!() };
        assert_eq!(
            (curves.width, curves.basis, curves.kind),
            (Some(0.05), CurveBasis::Linear, CurveKind::Tube)
        );
        assert_eq!(scene.meshes[0].data.strands, [2, 3]);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }

    #[test]
    fn curves_have_the_widths_of_the_file_and_hair_its_keys() {
        let scene = read(
            "<shape type='bsplinecurve'><string name='filename' value='fur.txt'/>
               <bsdf type='hair'><float name='eumelanin' value='0.5'/><float name='scale' value='2'/>
                 <float name='longitudinal_roughness' value='0.2'/></bsdf></shape>
             <shape type='linearcurve'><string name='filename' value='fur.txt'/>
               <bsdf type='hair'><rgb name='sigma_a' value='0.1, 0.2, 0.3'/></bsdf></shape>",
            CURVE,
        )
        .unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let curves = |i: usize| match &scene.objects[i].content {
            ObjectContent::Shape(ShapeDesc::Curves(curves)) => curves.clone(),
            other => panic!("{other:?}"),
        };
        assert_eq!((curves(0).basis, curves(1).basis), (CurveBasis::BSpline, CurveBasis::Linear));
        assert_eq!(curves(0).curves, curves(1).curves);
        let data = &scene.meshes[curves(0).curves.index()].data;
        assert_eq!((data.strands.clone(), data.widths[3]), (vec![4], 0.4));
        let hair: Vec<&HairMaterial> = scene
            .materials
            .iter()
            .filter_map(|m| match &m.value {
                MaterialDesc::Hair(hair) => Some(hair),
                _ => None,
            })
            .collect();
        assert_eq!((hair[0].eumelanin, hair[0].pheomelanin, hair[0].beta_m), (1.0, 0.4, 0.2));
        assert!((hair[0].ior - 1.55 / 1.000277).abs() < 1e-9);
        assert_eq!(hair[1].sigma_a, Some(Spectrum::new(0.1, 0.2, 0.3)));
    }

    #[test]
    fn faulty_files_are_errors() {
        let shape = "<shape type='bsplinecurve'><string name='filename' value='fur.txt'/></shape>";
        for (file, expected) in [("0 0 0 1\n1 0 0 1\n", "curve of 2 points"), ("0 0 zero 1", "line 1")] {
            let error = read(shape, file).unwrap_err();
            assert!(error.message.contains(expected), "{}", error.message);
        }
        assert!(read("<shape type='linearcurve'/>", CURVE).is_err());
    }
}
