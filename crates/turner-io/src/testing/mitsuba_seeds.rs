//! Seeds of Mitsuba's formats: a scene, a serialized mesh and a volume.

use super::seeds::Seed;

/// The seeds.
pub(super) fn seeds() -> Vec<Seed> {
    let shown = |name, bytes, text: &str| Seed { name, bytes, scene: Some(("show.xml", text.to_owned())) };
    vec![
        Seed { name: "scene.xml", bytes: SCENE.into(), scene: None },
        shown("mesh.serialized", serialized(), MESH),
        shown("cloud.vol", volume(), CLOUD),
    ]
}

const SCENE: &str = r##"<?xml version="1.0"?>
<scene version="3.0.0">
<default name="spp" value="4"/><!-- a remark -->
<integrator type="path"><integer name="max_depth" value="6"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0, 1, 6" target="0 0 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/><rfilter type="tent"/></film>
<sampler type="independent"><integer name="sample_count" value="$spp"/></sampler></sensor>
<bsdf type="twosided" id="board"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">
<rgb name="color0" value="0.1 0.2 0.3"/><rgb name="color1" value="#ffcc99"/>
<transform name="to_uv"><scale x="4" y="4"/></transform></texture></bsdf></bsdf>
<shape type="rectangle"><ref id="board"/><transform name="to_world"><rotate x="1" angle="-90"/></transform></shape>
<shape type="sphere"><point name="center" x="0" y="1" z="0"/><float name="radius" value="0.5"/>
<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.2"/></bsdf></shape>
<shape type="shapegroup" id="many"><shape type="cube"><bsdf type="dielectric"/></shape></shape>
<shape type="instance"><ref id="many"/><transform name="to_world"><matrix value="1 0 0 2 0 1 0 1 0 0 1 0 0 0 0 1"/></transform></shape>
<shape type="sphere"><emitter type="area"><spectrum name="radiance" value="400:1, 500:2, 700:1.5"/></emitter></shape>
<emitter type="constant"><blackbody name="radiance" temperature="5000"/></emitter>
</scene>
"##;

const MESH: &str = r#"<scene version="3.0.0"><shape type="serialized"><string name="filename" value="mesh.serialized"/></shape>
<emitter type="point"><point name="position" value="0 0 3"/></emitter></scene>"#;

const CLOUD: &str = r#"<scene version="3.0.0"><shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous">
<volume name="sigma_t" type="gridvolume"><string name="filename" value="cloud.vol"/></volume></medium></shape>
<emitter type="constant"/></scene>"#;

/// A serialized mesh of one triangle.
fn serialized() -> Vec<u8> {
    let mut mesh = Vec::new();
    mesh.extend(0u32.to_le_bytes());
    mesh.extend(b"a\0");
    mesh.extend(3u64.to_le_bytes());
    mesh.extend(1u64.to_le_bytes());
    [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().for_each(|v| mesh.extend(v.to_le_bytes()));
    [0u32, 1, 2].iter().for_each(|i| mesh.extend(i.to_le_bytes()));
    let mut out = vec![0x1c, 0x04, 4, 0];
    out.extend(miniz_oxide::deflate::compress_to_vec_zlib(&mesh, 6));
    out.extend(0u64.to_le_bytes());
    out.extend(1u32.to_le_bytes());
    out
}

/// A grid of 2 x 2 x 2 densities.
fn volume() -> Vec<u8> {
    let mut out = b"VOL\x03".to_vec();
    [1i32, 2, 2, 2, 1].iter().for_each(|v| out.extend(v.to_le_bytes()));
    [0f32, 0.0, 0.0, 1.0, 1.0, 1.0].iter().for_each(|v| out.extend(v.to_le_bytes()));
    (0..8u8).for_each(|i| out.extend((f32::from(i) / 8.0).to_le_bytes()));
    out
}
