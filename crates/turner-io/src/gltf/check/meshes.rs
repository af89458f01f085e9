//! Attributes, indices, morph targets and materials of mesh primitives (glTF 2.0 §3.7.2).

use std::collections::BTreeMap;

use super::walk::Faults;
use crate::gltf::json::{Accessor, Document, Index, Material, Mesh, Primitive};
use crate::gltf::materials::textures_of;
use crate::gltf::textures::uv_set;

const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// A primitive that is checked.
struct Of<'a> {
    document: &'a Document,
    faults: &'a mut Faults,
    mesh: usize,
    primitive: usize,
    is_quantized: bool,
}

impl Of<'_> {
    fn add(&mut self, member: &str, message: &str) {
        let pointer = format!("/meshes/{}/primitives/{}{member}", self.mesh, self.primitive);
        let kind: String = message.chars().filter(|c| !c.is_ascii_digit()).collect();
        self.faults.add(format!("/meshes{member} {kind}"), &pointer, message);
    }

    fn accessor(&self, index: Index) -> Option<&Accessor> {
        self.document.accessors.get(index.index())
    }
}

pub(super) fn check(document: &Document, faults: &mut Faults) {
    let is_quantized = document.extensions_used.iter().any(|name| name == "KHR_mesh_quantization");
    for (m, mesh) in document.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let mut of = Of { document, faults, mesh: m, primitive: p, is_quantized };
            of.attributes(primitive);
            of.indices(primitive);
            of.targets(mesh, primitive);
            of.material(primitive);
            of.variants(primitive);
        }
        let targets = mesh.primitives.first().map_or(0, |p| p.targets.len());
        if !mesh.weights.is_empty() && mesh.weights.len() != targets {
            let message =
                format!("has {} elements; expected {targets}, one per morph target", mesh.weights.len());
            super::add(faults, "/meshes", m, "/weights", message);
        }
    }
}

/// The name of an attribute without its set, and the set.
fn semantic(name: &str) -> Option<(&str, Option<usize>)> {
    if ["POSITION", "NORMAL", "TANGENT"].contains(&name) {
        return Some((name, None));
    }
    let (base, set) = name.split_once('_')?;
    let known = ["TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"].contains(&base);
    let plain = set == "0" || !set.starts_with('0') && set.bytes().all(|b| b.is_ascii_digit());
    (known && plain).then(|| Some((base, Some(set.parse().ok()?))))?
}

impl Of<'_> {
    fn attributes(&mut self, primitive: &Primitive) {
        let position = primitive.attributes.get("POSITION").copied();
        let vertices = position.and_then(|p| self.accessor(p)).and_then(|a| a.count);
        let mut sets: BTreeMap<&str, usize> = BTreeMap::new();
        for (name, &index) in &primitive.attributes {
            let member = format!("/attributes/{name}");
            let Some(accessor) = self.accessor(index) else { continue };
            let (count, wide) =
                (accessor.count, accessor.component_type.is_some_and(|t| t.0 == UNSIGNED_INT));
            if name.starts_with('_') {
                if wide {
                    self.add(&member, "has 32-bit integers; expected another component type");
                }
            } else if let Some((base, set)) = semantic(name) {
                let highest = sets.entry(base).or_default();
                *highest = (*highest).max(set.map_or(0, |set| set + 1));
                if !self.is_format(base, accessor) {
                    self.add(&member, "has a type or component type that the attribute does not allow");
                }
            } else {
                self.add(
                    &member,
                    "is not an attribute of the specification; expected its name to start with _",
                );
            }
            if vertices.is_some() && count != vertices {
                self.add(&member, "has another number of elements than POSITION");
            }
        }
        for base in ["TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"] {
            let given =
                primitive.attributes.keys().filter(|n| semantic(n).is_some_and(|(b, _)| b == base)).count();
            if given < sets.get(base).copied().unwrap_or(0) {
                self.add("/attributes", &format!("has sets of {base} that are not numbered from 0"));
            }
        }
        if sets.get("JOINTS") != sets.get("WEIGHTS") {
            self.add("/attributes", "has different numbers of sets of JOINTS and WEIGHTS");
        }
        if position.is_some_and(|p| self.is_unbounded(p)) {
            self.add("/attributes/POSITION", "has no min and max; expected both");
        }
    }

    fn is_unbounded(&self, accessor: Index) -> bool {
        self.accessor(accessor).is_some_and(|a| a.min.is_none() || a.max.is_none())
    }

    /// Whether an accessor has a format of an attribute.
    fn is_format(&self, base: &str, a: &Accessor) -> bool {
        let (kind, component) = (a.kind.as_deref().unwrap_or(""), a.component_type.map_or(0, |t| t.0));
        let kinds: &[&str] = match base {
            "POSITION" | "NORMAL" => &["VEC3"],
            "TEXCOORD" => &["VEC2"],
            "COLOR" => &["VEC3", "VEC4"],
            _ => &["VEC4"],
        };
        let unit = a.normalized && [UNSIGNED_BYTE, UNSIGNED_SHORT].contains(&component);
        let small = [BYTE, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT].contains(&component);
        let allowed = match base {
            "JOINTS" => [UNSIGNED_BYTE, UNSIGNED_SHORT].contains(&component) && !a.normalized,
            "POSITION" => component == FLOAT || self.is_quantized && small,
            "NORMAL" | "TANGENT" => {
                component == FLOAT || self.is_quantized && a.normalized && [BYTE, SHORT].contains(&component)
            }
            "TEXCOORD" => component == FLOAT || unit || self.is_quantized && small,
            _ => component == FLOAT || unit,
        };
        kinds.contains(&kind) && allowed
    }

    fn indices(&mut self, primitive: &Primitive) {
        let Some(a) = primitive.indices.and_then(|i| self.accessor(i)) else { return };
        let component = a.component_type.map_or(0, |t| t.0);
        let unsigned = [UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT].contains(&component);
        if a.kind.as_deref() != Some("SCALAR") || !unsigned || a.normalized {
            self.add("/indices", "are not unsigned SCALAR integers");
        }
    }

    fn targets(&mut self, mesh: &Mesh, primitive: &Primitive) {
        let expected = mesh.primitives.first().map_or(0, |p| p.targets.len());
        if primitive.targets.len() != expected {
            let message =
                format!("has {} morph targets; expected {expected} as the first", primitive.targets.len());
            self.add("/targets", &message);
        }
        for (t, target) in primitive.targets.iter().enumerate() {
            for (name, &index) in target {
                let member = format!("/targets/{t}/{name}");
                let Some(count) = self.accessor(index).map(|a| a.count) else { continue };
                let known = semantic(name).is_some_and(|(base, _)| !["JOINTS", "WEIGHTS"].contains(&base));
                let base = primitive.attributes.get(name).and_then(|b| self.accessor(*b)).map(|a| a.count);
                if !known && !name.starts_with('_') {
                    self.add(&member, "is not an attribute of morph targets");
                } else if base.is_none() {
                    self.add(&member, "has no attribute of the primitive that it changes");
                } else if base != Some(count) {
                    self.add(&member, "has another number of elements than the attribute that it changes");
                }
                if name == "POSITION" && self.is_unbounded(index) {
                    self.add(&member, "has no min and max; expected both");
                }
            }
        }
    }

    fn material(&mut self, primitive: &Primitive) {
        let document = self.document;
        let Some(material) = primitive.material.and_then(|m| document.materials.get(m.index())) else {
            return;
        };
        let lacks = |set: u32| !primitive.attributes.contains_key(&format!("TEXCOORD_{set}"));
        if textures_of(material).iter().any(|(info, _)| lacks(uv_set(info))) {
            self.add("/material", "has a texture whose TEXCOORD the primitive lacks");
        }
        if needs_tangents(material) && !primitive.attributes.contains_key("TANGENT") {
            self.add("/material", "needs TANGENT, or a normalTexture from which tangents follow");
        }
    }

    fn variants(&mut self, primitive: &Primitive) {
        let mut seen = std::collections::BTreeSet::new();
        let variants = primitive.extensions.as_deref().and_then(|e| e.variants.as_ref());
        for mapping in variants.into_iter().flat_map(|v| &v.mappings) {
            if mapping.variants.iter().any(|variant| !seen.insert(*variant)) {
                self.add("/extensions/KHR_materials_variants/mappings", "has two materials for a variant");
            }
        }
    }
}

/// Whether a material's directions on the surface are defined by tangents alone.
fn needs_tangents(material: &Material) -> bool {
    let Some(e) = material.extensions.as_deref().filter(|_| material.normal_texture.is_none()) else {
        return false;
    };
    e.anisotropy.is_some() || e.clearcoat.as_ref().is_some_and(|c| c.clearcoat_normal_texture.is_some())
}
