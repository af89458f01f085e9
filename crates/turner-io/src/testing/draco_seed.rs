//! A model with a Draco mesh: a torus of 18 triangles with seams, normals and texture coordinates, encoded by Google's
//! encoder 1.5 at its second slowest speed, which uses most methods.

use super::seeds::glb_of;

const STREAM: &[u8] = include_bytes!("torus.drc");

/// The model.
pub(super) fn draco_glb() -> Vec<u8> {
    let accessor = |kind| format!(r#"{{"componentType":5126,"count":52,"type":"{kind}"}}"#);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"indices":3,"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},
"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,
"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}}}}}}]}}],
"accessors":[{},{},{},{{"componentType":5125,"count":54,"type":"SCALAR"}}],
"buffers":[{{"byteLength":{size}}}],"bufferViews":[{{"buffer":0,"byteLength":{size}}}]}}"#,
        accessor("VEC3"),
        accessor("VEC3"),
        accessor("VEC2"),
        size = STREAM.len(),
    );
    glb_of(&json, STREAM)
}
