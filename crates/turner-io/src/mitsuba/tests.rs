//! Tests of the import.

use turner::bsdf::{FacetDistribution, FacetMasking};
use turner::camera::{CameraDesc, Handedness, Viewport};
use turner::color::Spectrum;
use turner::description::{ObjectContent, SceneDesc};
use turner::integrator::IntegratorDesc;
use turner::light::LightDesc;
use turner::material::{MaterialDesc, PrincipledMaterial};
use turner::math::DVec3;
use turner::medium::MediumDesc;
use turner::schema::{ColorSource, SceneError, Transform, WarningKind};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;

use super::import_from;
use crate::assets::MemoryAssets;
use crate::import::ImportOptions;

fn read(inner: &str) -> Result<SceneDesc, SceneError> {
    let text = format!("<scene version=\"3.0.0\">\n{inner}\n</scene>");
    import_from(text.into_bytes(), "a.xml", &MemoryAssets::default(), &ImportOptions::default())
}

fn read_old(inner: &str) -> SceneDesc {
    let text = format!("<scene version='0.6.0'>{inner}</scene>");
    import_from(text.into_bytes(), "a.xml", &MemoryAssets::default(), &ImportOptions::default()).unwrap()
}

fn constant(source: ColorSource) -> f32 {
    match source {
        ColorSource::Constant(c) => c.g,
        ColorSource::Texture(_) => panic!("{source:?}"),
    }
}

fn principled(scene: &SceneDesc, i: usize) -> &PrincipledMaterial {
    match &scene.materials[i].value {
        MaterialDesc::Principled(m) => m,
        other => panic!("{other:?}"),
    }
}

#[test]
fn cameras_look_along_z_with_x_to_the_left() {
    let scene = read(
        "<sensor type='perspective'><float name='fov' value='90'/>
           <transform name='to_world'><lookat origin='1,2,3' target='1,2,8' up='0,1,0'/></transform>
           <film type='hdrfilm'><integer name='width' value='200'/><integer name='height' value='100'/></film>
           <sampler type='independent'><integer name='sample_count' value='7'/></sampler></sensor>
         <integrator type='path'><integer name='max_depth' value='5'/></integrator>",
    )
    .unwrap();
    let CameraDesc::Pinhole(camera) = &scene.camera.as_ref().unwrap().value else { panic!() };
    assert_eq!(camera.position, DVec3::new(1.0, 2.0, 3.0));
    assert!((camera.look_at - camera.position).normalize().dot(DVec3::Z) > 0.999_999);
    assert_eq!(camera.handedness, Handedness::Right);
    let Some(Viewport::Height(height)) = camera.viewport else { panic!() };
    assert!((height - 1.0).abs() < 1e-9, "{height}");
    assert_eq!((scene.film.width, scene.film.samples), (200, 7));
    assert!(matches!(&scene.integrator, IntegratorDesc::Path(p) if p.max_depth == 4));
}

#[test]
fn the_principal_point_shifts_the_screen() {
    let scene = read(
        "<sensor type='perspective'><float name='fov' value='50'/><float name='principal_point_offset_x' value='0.25'/>
           <float name='principal_point_offset_y' value='0.5'/></sensor>",
    );
    let Some(CameraDesc::Pinhole(c)) = scene.unwrap().camera.map(|c| c.value) else { panic!("a pinhole") };
    assert_eq!((c.shift.x, c.shift.y), (0.25, -0.5));
}

#[test]
fn steps_of_transforms_follow_one_another() {
    let scene = read(
        "<shape type='disk'><transform name='to_world'><scale value='2'/><rotate y='1' angle='90'/><translate x='1'/></transform></shape>",
    )
    .unwrap();
    let at = scene.objects[0].transform.0;
    assert!((at.transform_point3(DVec3::Z) - DVec3::new(3.0, 0.0, 0.0)).length() < 1e-12);
}

#[test]
fn wrappers_are_gathered() {
    let scene = read(
        "<bsdf type='mask' id='m'><float name='opacity' value='0.25'/><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></bsdf>
         <shape type='sphere'><ref id='m'/></shape>
         <shape type='sphere'><bsdf type='diffuse'/></shape>
         <shape type='sphere'><emitter type='area'><rgb name='radiance' value='3,2,1'/></emitter></shape>",
    )
    .unwrap();
    let masked = principled(&scene, 0);
    assert!(!masked.front_only && matches!(masked.opacity, ColorSource::Constant(c) if c.r == 0.25));
    assert!(principled(&scene, 1).front_only);
    let lamp = principled(&scene, 2);
    assert!(lamp.emission_front_only && lamp.emission_luminance == 1.0);
    assert!(matches!(lamp.base_color, ColorSource::Constant(c) if c.is_black()));
    assert_eq!(scene.materials[0].name.as_deref(), Some("m"));
}

#[test]
fn groups_are_placed_again_and_again() {
    let scene = read(
        "<shape type='instance'><ref id='g'/></shape><shape type='instance'><ref id='g'/></shape>
         <shape type='shapegroup' id='g'><shape type='cube'/><shape type='cube'/></shape>",
    )
    .unwrap();
    assert_eq!((scene.groups.len(), scene.objects.len(), scene.meshes.len()), (1, 2, 1));
    assert!(scene.objects.iter().all(|o| matches!(o.content, ObjectContent::Instance(_))));
}

#[test]
fn what_is_misspelled_is_named_at_its_place() {
    let error = read("<shape type='spere'/>").unwrap_err();
    assert!(error.message.starts_with("a.xml:2:1: unknown shape \"spere\""), "{}", error.message);
    assert_eq!(error.help.as_deref(), Some("did you mean \"sphere\"?"));
    let scene =
        read("<shape type='sphere'><float name='radios' value='2'/><bsdf type='diffuse'/></shape>").unwrap();
    let warning = &scene.warnings[0];
    assert_eq!(warning.kind, WarningKind::Ignored);
    assert!(
        warning.message.contains("a.xml:2:22") && warning.message.contains("\"radius\""),
        "{}",
        warning.message
    );
    let error = read("<shape type='sphere'><ref id='b'/></shape><bsdf type='diffuse' id='bb'/>").unwrap_err();
    assert!(error.message.contains("unknown id \"b\""), "{}", error.message);
    let error = read("<shape type='sphere'><float name='radius' value='big'/></shape>").unwrap_err();
    assert!(error.message.contains("expected a number"), "{}", error.message);
    assert!(
        read(
            "<shape type='sphere'><bsdf type='conductor'><string name='material' value='Ax'/></bsdf></shape>"
        )
        .is_err()
    );
}

#[test]
fn lights_have_their_units() {
    let scene = read(
        "<emitter type='point'><transform name='to_world'><translate x='2'/></transform><rgb name='intensity' value='4'/></emitter>
         <emitter type='spot'><float name='cutoff_angle' value='40'/></emitter>
         <emitter type='constant'><spectrum name='radiance' value='1'/></emitter>
         <emitter type='directional'><vector name='direction' x='0' y='-1' z='0'/></emitter>",
    )
    .unwrap();
    let light = |i: usize| &scene.lights[i].value;
    assert!(matches!(light(0), LightDesc::Point(p) if p.position.x == 2.0 && p.color.r == 4.0));
    let LightDesc::Spot(spot) = light(1) else { panic!() };
    let lamp = spot.ies.as_ref().unwrap();
    // Halfway between 30° and 40°.
    assert!((lamp.data.candela(35.0, 0.0) - 0.5).abs() < 1e-6);
    assert!(matches!(light(2), LightDesc::Environment(e) if (e.tint.r - 1.2048).abs() < 1e-3));
    assert!(matches!(light(3), LightDesc::Directional(d) if d.direction == Some(DVec3::NEG_Y)));
}

#[test]
fn metals_have_their_index_and_the_factor_of_the_file() {
    let text = "<shape type='sphere'><bsdf type='conductor'><string name='material' value='Au'/>
           <rgb name='specular_reflectance' value='0.9 0.5 0.25'/></bsdf></shape>
         <shape type='sphere'><bsdf type='conductor'><rgb name='eta' value='0.2 0.9 1.1'/>
           <rgb name='k' value='3.9 2.4 2.2'/><float name='ext_eta' value='1.25'/></bsdf></shape>
         <shape type='sphere'><bsdf type='conductor'><string name='material' value='none'/></bsdf></shape>";
    let scene = read(text).unwrap();
    let (gold, given, mirror) = (principled(&scene, 0), principled(&scene, 1), principled(&scene, 2));
    assert_eq!(gold.metal_eta.map(|c| c.r), Some(0.14304));
    assert_eq!(gold.specular_color, ColorSource::Constant(Spectrum::new(0.9, 0.5, 0.25)));
    // For renderers without an index, the colour at normal incidence.
    let ColorSource::Constant(f0) = gold.base_color else { panic!() };
    assert!((f0.r - 0.9 * 0.967).abs() < 2e-3, "{f0:?}");
    let (eta, k) = (given.metal_eta.unwrap(), given.metal_k.unwrap());
    assert!((eta.r - 0.16).abs() < 1e-6 && (k.b - 1.76).abs() < 1e-6, "{eta:?} {k:?}");
    assert_eq!((mirror.metal_eta, mirror.base_metalness), (None, ColorSource::Constant(Spectrum::BLACK)));
}

#[test]
fn numbers_exchange_the_colours_of_checkerboards() {
    let board = |name: &str| {
        format!(
            "<texture name='{name}' type='checkerboard'><float name='color0' value='0.1'/>
               <float name='color1' value='0.7'/></texture>"
        )
    };
    let shape =
        |bsdf: &str, inner: &str| format!("<shape type='disk'><bsdf type='{bsdf}'>{inner}</bsdf></shape>");
    let scene = read(
        &(shape("diffuse", &board("reflectance"))
            + &shape("roughconductor", &board("alpha"))
            + &shape("principled", &board("metallic"))),
    )
    .unwrap();
    let MaterialDesc::Disney(disney) = &scene.materials[2].value else { panic!() };
    let sources =
        [principled(&scene, 0).base_color, principled(&scene, 1).specular_alpha_x.unwrap(), disney.metallic];
    for (source, even) in sources.into_iter().zip([0.1, 0.7, 0.7]) {
        let ColorSource::Texture(id) = source else { panic!("{source:?}") };
        let TextureDesc::Checkerboard(board) = &scene.textures[id.index()].value else { panic!() };
        assert!((constant(board.even) - even).abs() < 1e-6, "{board:?}");
    }
    assert!(
        scene
            .objects
            .iter()
            .all(|o| matches!(&o.content, ObjectContent::Shape(ShapeDesc::Disk(d)) if d.polar))
    );
}

#[test]
fn projectors_without_an_image_are_even() {
    let scene = read(
        "<emitter type='projector'><rgb name='irradiance' value='0.5'/></emitter>
         <emitter type='projector'><float name='fov' value='90'/></emitter>",
    )
    .unwrap();
    let spots: Vec<_> = scene
        .lights
        .iter()
        .map(|l| match &l.value {
            LightDesc::Spot(spot) => spot.clone(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(spots.iter().all(|s| s.image.is_some()) && spots[0].color == Spectrum::grey(0.5));
    assert!((spots[1].image_fov.unwrap() - 90.0).abs() < 1e-9);
    // 50 mm on a film of 36 x 24 mm along the diagonal of a square.
    let half = (36.0f64 * 36.0 + 24.0 * 24.0).sqrt() / 100.0 / 2.0f64.sqrt();
    let fov = 2.0 * turner::math::elementary::atan2(half, 1.0).to_degrees();
    assert!((spots[0].image_fov.unwrap() - fov).abs() < 1e-9, "{:?}", spots[0].image_fov);
}

#[test]
fn skies_keep_their_zenith() {
    let sky = |text: &str| match read(text).unwrap().lights.remove(0).value {
        LightDesc::Sky(sky) => sky,
        other => panic!("{other:?}"),
    };
    let level = sky("<emitter type='sunsky'/>");
    assert_eq!(level.up, DVec3::Z);
    let sun = level.direction.unwrap().normalize();
    assert!((sun.z - 0.7203).abs() < 1e-3 && sun.y > 0.69, "{sun}");
    let turned =
        sky("<emitter type='sunsky'><vector name='sun_direction' value='0 1 1'/><transform name='to_world'>
        <rotate x='1' angle='-90'/></transform></emitter>");
    assert_eq!(turned.up, DVec3::Y);
    assert!((turned.direction.unwrap() - DVec3::new(0.0, 1.0, -1.0)).length() < 1e-9);
}

#[test]
fn facets_are_those_of_the_file() {
    let rough =
        |kind: &str, inner: &str| format!("<shape type='sphere'><bsdf type='{kind}'>{inner}</bsdf></shape>");
    let ggx = "<string name='distribution' value='ggx'/><float name='alpha' value='0.25'/>";
    let scene =
        read(&(rough("roughconductor", "") + &rough("roughplastic", "") + &rough("roughdielectric", ggx)));
    let scene = scene.unwrap();
    for (i, (distribution, roughness)) in [
        (FacetDistribution::Beckmann, 0.1f32.sqrt()),
        (FacetDistribution::Beckmann, 0.1f32.sqrt()),
        (FacetDistribution::Ggx, 0.5),
    ]
    .into_iter()
    .enumerate()
    {
        let m = principled(&scene, i);
        assert_eq!((m.specular_distribution, m.specular_masking), (distribution, FacetMasking::Separable));
        assert!(!m.specular_multiple_scattering);
        assert!((constant(m.specular_roughness) - roughness).abs() < 1e-6);
    }
}

#[test]
fn integrators_keep_their_settings() {
    let scene = read(
        "<integrator type='path'><integer name='max_depth' value='5'/><integer name='rr_depth' value='8'/>
         <boolean name='hide_emitters' value='true'/></integrator>",
    );
    let IntegratorDesc::Path(path) = scene.unwrap().integrator else { panic!() };
    assert_eq!((path.max_depth, path.rr_start, path.hide_emitters), (4, Some(8), true));
}

#[test]
fn media_may_lie_behind_thin_walls() {
    let medium = "<medium name='interior' type='homogeneous'/>";
    let scene = read(&format!(
        "<shape type='sphere'><bsdf type='thindielectric'/>{medium}</shape>
         <shape type='sphere'><bsdf type='mask'><bsdf type='diffuse'/></bsdf>{medium}</shape>
         <shape type='sphere'><bsdf type='diffuse'/>{medium}</shape>"
    ));
    let scene = scene.unwrap();
    let inside = [0, 1, 2].map(|i| principled(&scene, i).interior.is_some());
    assert_eq!(inside, [true, true, false]);
}

#[test]
fn old_names_are_understood() {
    let text = "<scene version='0.5.0'><sensor type='perspective'><transform name='toWorld'><lookAt origin='0,0,9' target='0,0,0' up='0,1,0'/></transform>
        <float name='fov' value='40'/></sensor><shape type='sphere'><bsdf type='dielectric'><float name='intIOR' value='1.5'/></bsdf></shape></scene>";
    let scene =
        import_from(text.as_bytes().to_vec(), "a.xml", &MemoryAssets::default(), &ImportOptions::default())
            .unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!((principled(&scene, 0).specular_ior - 1.5 / 1.000277).abs() < 1e-9);
}

#[test]
fn sums_of_two_lobes_keep_their_colours() {
    let scene = read_old(
        "<shape type='sphere'><bsdf type='twosided'><bsdf type='phong'><float name='exponent' value='40'/>
           <rgb name='diffuseReflectance' value='0.3'/><rgb name='specularReflectance' value='0.4'/></bsdf></bsdf></shape>
         <shape type='sphere'><bsdf type='ward'><rgb name='specularReflectance' value='0'/></bsdf></shape>
         <shape type='sphere'><bsdf type='mixturebsdf'><string name='weights' value='0.7, 0.3'/>
           <bsdf type='diffuse'/><bsdf type='conductor'><string name='material' value='none'/></bsdf></bsdf></shape>",
    );
    let MaterialDesc::Mix(mix) = &scene.materials[0].value else { panic!("{:?}", scene.materials[0]) };
    let [diffuse, glossy] = [0, 1].map(|i| principled(&scene, mix.materials[i].index()));
    let share = constant(mix.weights[0]);
    let sums = [(1.0 - share) * constant(diffuse.base_color), share * constant(glossy.specular_color)];
    assert!((sums[0] - 0.3).abs() < 1e-6 && (sums[1] - 0.4).abs() < 1e-6, "{sums:?}");
    // α² = 1 / 81, and roughness is √α.
    assert!((constant(glossy.specular_roughness) - 1.0 / 3.0).abs() < 1e-6);
    assert!(!diffuse.front_only && !glossy.front_only && constant(glossy.base_weight) == 0.0);
    assert_eq!(constant(principled(&scene, 1).base_color), 0.5);
    let MaterialDesc::Mix(mix) = &scene.materials[2].value else { panic!("{:?}", scene.materials[2]) };
    assert_eq!(mix.weights.iter().map(|w| constant(*w)).collect::<Vec<_>>(), [0.7, 0.3]);
}

#[test]
fn coats_lie_on_what_is_within() {
    let scene = read_old(
        "<shape type='sphere'><bsdf type='roughcoating'><float name='alpha' value='0.09'/><float name='intIOR' value='1.6'/><float name='extIOR' value='1'/>
           <float name='thickness' value='0.5'/><rgb name='sigmaA' value='0.2'/>
           <bsdf type='conductor'><string name='material' value='Au'/></bsdf></bsdf></shape>",
    );
    let coated = principled(&scene, 0);
    assert_eq!((constant(coated.coat_weight), coated.coat_ior), (1.0, 1.6));
    assert!((constant(coated.coat_roughness) - 0.3).abs() < 1e-6);
    assert!((constant(coated.coat_color) - 0.818_730_8).abs() < 1e-6);
    assert_eq!(constant(coated.base_metalness), 1.0);
}

#[test]
fn integrators_of_others_are_paths_and_their_values_are_not_asked_for() {
    let scene = read("<integrator type='guided'><integer name='max_depth' value='9'/><float name='budget' value='3'/></integrator>").unwrap();
    assert!(matches!(&scene.integrator, IntegratorDesc::Path(p) if p.max_depth == 8));
    let said: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(said.len() == 2 && said[0].contains("\"guided\": unknown integrator"), "{said:?}");
}

#[test]
fn opacity_is_what_a_mask_shows_and_not_its_alpha() {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 2, 1);
    encoder.set_color(png::ColorType::GrayscaleAlpha);
    // One row: grey 0 and 255, both of alpha 255.
    encoder.write_header().unwrap().write_image_data(&[0, 255, 255, 255]).unwrap();
    let text = "<scene version='3.0.0'><shape type='rectangle'><bsdf type='mask'><texture type='bitmap' name='opacity'><string name='filename' value='m.png'/></texture>
        <bsdf type='diffuse'/></bsdf></shape></scene>";
    let mut assets = MemoryAssets::default();
    assets.files.insert("m.png".into(), png);
    let scene = import_from(text.as_bytes().to_vec(), "a.xml", &assets, &ImportOptions::default()).unwrap();
    let ColorSource::Texture(texture) = principled(&scene, 0).opacity else { panic!() };
    let TextureDesc::Image(desc) = &scene.textures[texture.index()].value else { panic!() };
    assert_eq!(scene.images[desc.file.index()].data.channels, 1);
}

#[test]
fn a_heterogeneous_medium_ends_with_its_volume() {
    let medium = |kind: &str| {
        let scene = read(&format!(
            "<shape type='sphere'><bsdf type='null'/><medium type='{kind}' name='interior'>
               <volume type='constvolume' name='sigma_t'><rgb name='value' value='2'/><transform name='to_world'><translate x='-0.5'/></transform></volume>
             </medium></shape>"
        ))
        .unwrap();
        scene.media[0].value.clone()
    };
    let MediumDesc::Grid(grid) = medium("heterogeneous") else { panic!() };
    assert_eq!(grid.bounds(), [DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 1.0, 1.0)]);
    assert_eq!(grid.extinction.unwrap().g, 2.0);
    assert!(matches!(medium("homogeneous"), MediumDesc::Homogeneous(_)));
}

/// In Mitsuba 0.6 heterogeneous media have a `density`, and `material` chooses a named medium.
#[test]
fn media_of_mitsuba_0_6() {
    let medium = |text: &str| {
        let scene = read(&format!("<shape type='sphere'><bsdf type='null'/>{text}</shape>")).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene.media[0].value.clone()
    };
    let MediumDesc::Grid(grid) = medium(
        "<medium type='heterogeneous' name='interior'><string name='method' value='woodcock'/>
           <float name='step_size' value='0.1'/><volume type='constvolume' name='density'><float name='value' value='3'/></volume></medium>",
    ) else {
        panic!()
    };
    assert_eq!(grid.extinction.unwrap().g, 3.0);
    let MediumDesc::Homogeneous(cream) = medium(
        "<medium type='homogeneous' name='interior'><string name='material' value='cream'/><float name='scale' value='10'/></medium>",
    ) else {
        panic!()
    };
    assert_eq!(cream.density, 10.0);
    assert!((cream.scattering.unwrap().r - 7.38).abs() < 1e-5, "{cream:?}");
    assert!((cream.absorption.unwrap().b - 0.0163).abs() < 1e-6, "{cream:?}");
}

/// An emissive rectangle has no transform; other rectangles are triangles.
#[test]
fn rectangles_are_area_lights_or_triangles() {
    let shape = |inner: &str| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><scale x='2' y='3' z='-1'/>{inner}</shape>"
        )
    };
    let lamp = "<emitter type='area'><rgb name='radiance' value='5'/></emitter>";
    let front = "<rotate y='1' angle='180'/><scale z='-1'/><translate x='4'/></transform>";
    let mirrored = "<translate x='4'/></transform>";
    let scene =
        read(&[shape(&format!("{front}{lamp}")), shape(front), shape(&format!("{mirrored}{lamp}"))].join(""));
    let scene = scene.unwrap();
    let [lamp, wall, other] = &scene.objects[..] else { panic!() };
    let ObjectContent::Shape(ShapeDesc::Rectangle(rectangle)) = &lamp.content else { panic!("{lamp:?}") };
    assert!(lamp.transform.is_identity());
    assert!((rectangle.center - DVec3::new(4.0, 0.0, 0.0)).length() < 1e-9);
    assert!((rectangle.edge_u - DVec3::new(-4.0, 0.0, 0.0)).length() < 1e-9);
    assert!((rectangle.edge_v - DVec3::new(0.0, 6.0, 0.0)).length() < 1e-9);
    for object in [wall, other] {
        assert!(matches!(&object.content, ObjectContent::Shape(ShapeDesc::Mesh(_))), "{object:?}");
        assert!(!object.transform.is_identity());
    }
}

/// Reading ahead changes neither what is read nor the scene's hash, also where a file is named and not used.
#[test]
fn scenes_and_hashes_do_not_depend_on_threads() {
    let triangle = |x: f32| format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").into_bytes();
    let mut assets = MemoryAssets::default();
    let mut text = "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"unused\"><texture type=\"bitmap\" \
                    name=\"reflectance\"><string name=\"filename\" value=\"unused.png\"/></texture></bsdf>"
        .to_owned();
    for i in 0..40 {
        assets.files.insert(format!("{i}.obj"), triangle(0.01 * i as f32));
        text += &format!("<shape type=\"obj\"><string name=\"filename\" value=\"{i}.obj\"/></shape>");
    }
    assets.files.insert("unused.png".to_owned(), vec![0; 64]);
    assets.files.insert("s.xml".to_owned(), (text + "</scene>").into_bytes());
    let text = "[[object]]\ntype = \"model\"\nfile = \"s.xml\"\n";
    let load = |threads: usize| {
        let options = crate::scene::LoadOptions { threads, ..Default::default() };
        let loaded = crate::scene::load_text(text.to_owned(), "scene.toml", &assets, &options);
        let loaded = loaded.unwrap_or_else(|e| panic!("{}", e.error.message));
        (loaded.hash, loaded.desc.meshes.iter().map(|m| m.data.positions[0][0]).collect::<Vec<f32>>())
    };
    let (hash, first) = load(1);
    assert_eq!(first.len(), 40);
    for threads in [2, 3, 8, 2, 2, 2] {
        assert_eq!(load(threads), (hash.clone(), first.clone()), "{threads} threads");
    }
}

/// A sphere without textures needs no transform; where (u, v) count, and under other transforms, it keeps its own.
#[test]
fn spheres_have_no_transform_where_none_is_needed() {
    let texture = "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"/></bsdf>";
    let sphere = |transform: &str, bsdf: &str| {
        let inner = format!(
            "<shape type=\"sphere\"><float name=\"radius\" value=\"2\"/><transform name=\"to_world\">{transform}\
             </transform>{bsdf}</shape>"
        );
        let scene = read(&inner).unwrap();
        let object = scene.objects[0].clone();
        let ObjectContent::Shape(ShapeDesc::Sphere(sphere)) = object.content else { panic!("{object:?}") };
        (sphere, object.transform)
    };
    let turned = "<rotate y=\"1\" angle=\"30\"/><scale value=\"1.5\"/><translate x=\"1\" y=\"2\" z=\"-3\"/>";
    let (s, transform) = sphere(turned, "");
    assert!((s.center - DVec3::new(1.0, 2.0, -3.0)).length() < 1e-9 && (s.radius - 3.0).abs() < 1e-9);
    assert_eq!(transform, Transform::IDENTITY);
    for (transform, bsdf) in [(turned, texture), ("<scale x=\"2\"/>", ""), ("<scale value=\"-1\"/>", "")] {
        let (s, transform) = sphere(transform, bsdf);
        assert!(s.center == DVec3::ZERO && s.radius == 2.0 && transform != Transform::IDENTITY);
    }
}
