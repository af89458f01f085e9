//! Skins and animations: the formats of their accessors and the nodes to which they refer.

use super::add;
use super::walk::Faults;
use crate::gltf::json::{Accessor, Animation, Document};
use crate::gltf::nodes::Tree;

const FLOAT: u32 = 5126;
/// Skins whose `skeleton` is checked; each takes time in proportion to the number of nodes.
const MOST_SKELETONS: usize = 64;

pub(super) fn check(document: &Document, tree: &Tree, faults: &mut Faults) {
    skins(document, tree, faults);
    for (i, animation) in document.animations.iter().enumerate() {
        animated(document, animation, i, faults);
    }
}

fn is_float(accessor: &Accessor, kind: &str) -> bool {
    accessor.kind.as_deref() == Some(kind) && accessor.component_type.is_some_and(|t| t.0 == FLOAT)
}

fn skins(document: &Document, tree: &Tree, faults: &mut Faults) {
    let roots = tree.roots();
    for (i, skin) in document.skins.iter().enumerate() {
        let bind = skin.inverse_bind_matrices.and_then(|a| document.accessors.get(a.index()));
        if let Some(bind) = bind {
            let count = bind.count.map_or(0, |c| c.0);
            if !is_float(bind, "MAT4") || bind.normalized {
                add(faults, "/skins", i, "/inverseBindMatrices", "are not MAT4 of floats");
            }
            if count < skin.joints.len() as u64 {
                let message = format!("are {count}; expected {}, one per joint", skin.joints.len());
                add(faults, "/skins", i, "/inverseBindMatrices", message);
            }
        }
        let mut above = skin.joints.iter().map(|j| roots.get(j.index()));
        let first = above.next();
        if above.any(|root| Some(root) != first) {
            add(faults, "/skins", i, "/joints", "have no common root");
        }
        if let Some(top) = skin.skeleton.filter(|_| i < MOST_SKELETONS) {
            let below = tree.below(top);
            if !skin.joints.iter().all(|j| below.get(j.index()).copied().unwrap_or(true)) {
                add(faults, "/skins", i, "/skeleton", "is not a common root of the joints");
            }
        }
    }
}

fn animated(document: &Document, animation: &Animation, i: usize, faults: &mut Faults) {
    for (s, sampler) in animation.samplers.iter().enumerate() {
        let Some(times) = document.accessors.get(sampler.input.index()) else { continue };
        let member = format!("/samplers/{s}/input");
        if !is_float(times, "SCALAR") {
            add(faults, "/animations", i, &member, "has times that are not floats");
        }
        if times.min.is_none() || times.max.is_none() {
            add(faults, "/animations", i, &member, "has no min and max; expected both");
        }
        if sampler.interpolation.as_deref() == Some("CUBICSPLINE") && times.count.is_some_and(|c| c.0 < 2) {
            add(faults, "/animations", i, &member, "has 1 key; expected at least 2 for a cubic spline");
        }
    }
    for (c, channel) in animation.channels.iter().enumerate() {
        let pointer = channel.target.extensions.as_deref().and_then(|e| e.pointer.as_ref());
        if pointer.is_some() && channel.target.path != "pointer" {
            let message = "is another than pointer, but KHR_animation_pointer is given";
            add(faults, "/animations", i, &format!("/channels/{c}/target/path"), message);
        }
        let member = format!("/channels/{c}/sampler");
        let Some(sampler) = animation.samplers.get(channel.sampler.index()) else {
            let count = animation.samplers.len();
            add(
                faults,
                "/animations",
                i,
                &member,
                format!("refers to sampler {}, but there are {count}", channel.sampler.0),
            );
            continue;
        };
        let Some(values) = document.accessors.get(sampler.output.index()) else { continue };
        let kind = match channel.target.path.as_str() {
            "translation" | "scale" => "VEC3",
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => continue,
        };
        let packed = values.normalized && kind != "VEC3" && values.kind.as_deref() == Some(kind);
        if !is_float(values, kind) && !packed {
            add(faults, "/animations", i, &member, format!("has values that are not {kind} of floats"));
        }
        let node = channel.target.node.and_then(|n| document.nodes.get(n.index()));
        let morphs = |mesh: usize| document.meshes.get(mesh)?.primitives.first().map(|p| p.targets.len());
        if kind == "SCALAR" && node.is_some_and(|n| n.mesh.and_then(|m| morphs(m.index())).unwrap_or(0) == 0)
        {
            add(faults, "/animations", i, &format!("/channels/{c}/target/node"), "has no morph targets");
        }
    }
}
