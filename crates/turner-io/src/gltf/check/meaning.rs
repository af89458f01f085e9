//! Members of accessors, cameras, nodes, materials and lights that contradict one another.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::add;
use super::walk::Faults;
use crate::gltf::json::{Document, Node};
use turner::math::{DMat3, DVec3};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

pub(super) fn check(document: &Document, faults: &mut Faults) {
    header(document, faults);
    for (i, accessor) in document.accessors.iter().enumerate() {
        if accessor.normalized
            && accessor.component_type.is_some_and(|t| [FLOAT, UNSIGNED_INT].contains(&t.0))
        {
            add(
                faults,
                "/accessors",
                i,
                "/normalized",
                "is true for floats or 32-bit integers; expected false",
            );
        }
        let sparse = accessor.sparse.as_ref();
        if let (Some(sparse), Some(count)) = (sparse, accessor.count)
            && sparse.count > count
        {
            add(
                faults,
                "/accessors",
                i,
                "/sparse/count",
                format!("is {}; expected at most {}", sparse.count.0, count.0),
            );
        }
    }
    for (i, camera) in document.cameras.iter().enumerate() {
        let depths = match (&camera.perspective, &camera.orthographic) {
            (Some(p), _) => Some((p.znear, p.zfar)),
            (None, Some(o)) => {
                if o.xmag == 0.0 || o.ymag == 0.0 {
                    add(faults, "/cameras", i, "/orthographic", "has xmag or ymag 0; expected other numbers");
                }
                Some((o.znear, o.zfar))
            }
            (None, None) => None,
        };
        if let Some((near, Some(far))) = depths
            && far <= near
        {
            add(faults, "/cameras", i, "", format!("has zfar {far}; expected more than znear, {near}"));
        }
    }
    for (i, node) in document.nodes.iter().enumerate() {
        transform(node, i, faults);
    }
    for (i, material) in document.materials.iter().enumerate() {
        let ior = material.extensions.as_deref().and_then(|e| e.ior.as_ref()).and_then(|x| x.ior);
        if let Some(ior) = ior
            && ior != 0.0
            && (ior < 1.0 || ior.is_nan())
        {
            let message = format!("is {ior}; expected 0, or 1 or more");
            add(faults, "/materials", i, "/extensions/KHR_materials_ior/ior", message);
        }
    }
    let lights = document.extensions.lights.as_ref().map_or(&[][..], |l| &l.lights);
    for (i, light) in lights.iter().enumerate() {
        let list = "/extensions/KHR_lights_punctual/lights";
        let Some(cone) = &light.spot else {
            if light.kind == "spot" {
                add(faults, list, i, "/spot", "is missing; expected the angles of the cone");
            }
            continue;
        };
        let inner = cone.inner_cone_angle.unwrap_or(0.0);
        let outer = cone.outer_cone_angle.unwrap_or(FRAC_PI_4);
        if outer <= inner || outer > FRAC_PI_2 {
            let message = format!("is {outer}; expected more than innerConeAngle, {inner}");
            add(faults, list, i, "/spot/outerConeAngle", message);
        }
    }
}

/// Version and lists of extensions.
fn header(document: &Document, faults: &mut Faults) {
    let asset = document.asset.as_ref();
    let version = asset.and_then(|a| a.version.as_deref()).unwrap_or("2.0");
    if let Some(least) = asset.and_then(|a| a.min_version.as_deref())
        && least > version
    {
        faults.add(
            "minVersion".to_owned(),
            "/asset/minVersion",
            &format!("is {least}; expected at most {version}"),
        );
    }
    for (i, name) in document.extensions_required.iter().enumerate() {
        if !document.extensions_used.contains(name) {
            add(
                faults,
                "/extensionsRequired",
                i,
                "",
                format!("is {name}, which is missing in extensionsUsed"),
            );
        }
    }
    let quantization = "KHR_mesh_quantization".to_owned();
    if document.extensions_used.contains(&quantization)
        && !document.extensions_required.contains(&quantization)
    {
        let message = "lists KHR_mesh_quantization, which is missing in extensionsRequired";
        faults.add("quantization".to_owned(), "/extensionsUsed", message);
    }
}

/// The transform of a node: a matrix that is a translation, rotation and scale, or these three.
fn transform(node: &Node, i: usize, faults: &mut Faults) {
    if let Some(m) = &node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            add(faults, "/nodes", i, "/matrix", "is given together with translation, rotation or scale");
        }
        let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
        let affine = [m[3], m[7], m[11], m[15] - 1.0].iter().all(|v| v.abs() < 1e-6);
        if !affine || !is_orthogonal(&DMat3::from_cols(column(0), column(1), column(2))) {
            add(faults, "/nodes", i, "/matrix", "is not a translation, rotation and scale");
        }
    }
    if let Some(q) = node.rotation.as_deref() {
        let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length.is_nan() || (length - 1.0).abs() > 0.01 {
            add(faults, "/nodes", i, "/rotation", format!("has length {length}; expected a unit quaternion"));
        }
    }
}

/// Whether the columns are perpendicular to one another and none is 0.
fn is_orthogonal(m: &DMat3) -> bool {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let cosine = |a: DVec3, b: DVec3| a.dot(b).abs() / (a.length() * b.length());
    [cosine(x, y), cosine(y, z), cosine(z, x)].iter().all(|c| *c < 1e-2)
}
