//! The values of accessors: `min` and `max`, finite numbers, unit vectors, indices, times and matrices.

use super::add;
use super::walk::Faults;
use crate::gltf::accessors::{Component, Elements};
use crate::gltf::buffers::Buffers;
use crate::gltf::json::{Accessor, Document, Index, Primitive};

/// Most values that are read: many accessors can share the same bytes.
const MOST_VALUES: usize = 1 << 28;
/// Largest deviation of the length of a unit vector.
const UNIT: f32 = 0.01;

/// Opens accessors until the values are used up.
struct Reader<'a> {
    document: &'a Document,
    buffers: &'a Buffers,
    left: usize,
}

impl<'a> Reader<'a> {
    /// The elements of an accessor that was checked before; `None` if it cannot be read.
    fn open(&mut self, index: Index) -> Option<Elements<'a>> {
        let json = self.document.accessors.get(index.index())?;
        let sparse = json.sparse.as_deref();
        let mut views = json
            .buffer_view
            .into_iter()
            .chain(sparse.into_iter().flat_map(|s| [s.indices.buffer_view, s.values.buffer_view]));
        if json.buffer_view.is_none() && sparse.is_none() || views.any(|view| self.buffers.is_absent(view)) {
            return None;
        }
        let elements = Elements::open(self.document, self.buffers, index, "").ok()?;
        let values = elements.count.checked_mul(elements.width)?;
        self.left = self.left.checked_sub(values)?;
        Some(elements)
    }
}

pub(super) fn check(document: &Document, buffers: &Buffers, faults: &mut Faults) {
    let mut reader = Reader { document, buffers, left: MOST_VALUES };
    for (i, json) in document.accessors.iter().enumerate() {
        if let Some(elements) = reader.open(Index(i as u32)) {
            bounds(json, &elements, i, faults);
        }
    }
    for (m, mesh) in document.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            vertices(&mut reader, primitive, m, &format!("/primitives/{p}"), faults);
        }
    }
    for (i, skin) in document.skins.iter().enumerate() {
        let Some(bind) = skin.inverse_bind_matrices.and_then(|a| reader.open(a)).filter(|b| b.width == 16)
        else {
            continue;
        };
        let is_affine = |m: [f32; 16]| [m[3], m[7], m[11], m[15]] == [0.0, 0.0, 0.0, 1.0];
        if !(0..bind.count).all(|k| is_affine(bind.get::<16>(k))) {
            add(faults, "/skins", i, "/inverseBindMatrices", "has a matrix whose last row is not 0, 0, 0, 1");
        }
    }
    times(&mut reader, faults);
}

/// Compares `min` and `max` with the values.
fn bounds(json: &Accessor, elements: &Elements<'_>, i: usize, faults: &mut Faults) {
    let padded =
        elements.width > 4 && elements.component != Component::F32 || json.kind.as_deref() == Some("MAT2");
    if padded && elements.component != Component::F32 {
        return;
    }
    let (mut least, mut most) = ([f32::INFINITY; 16], [f32::NEG_INFINITY; 16]);
    let mut is_finite = true;
    for k in 0..elements.count {
        // Bounds are those of the stored integers.
        let values = elements.stored::<16>(k);
        for ((v, least), most) in values.into_iter().zip(&mut least).zip(&mut most).take(elements.width) {
            is_finite &= v.is_finite();
            (*least, *most) = (least.min(v), most.max(v));
        }
    }
    if !is_finite {
        add(faults, "/accessors", i, "", "has NaN or infinite values");
        return;
    }
    for (member, stated, found) in [("/min", &json.min, least), ("/max", &json.max, most)] {
        let Some(stated) = stated else { continue };
        if stated.len() != elements.width {
            let message = format!("has {} numbers; expected {}", stated.len(), elements.width);
            add(faults, "/accessors", i, member, message);
        }
        // Decimal digits may be rounded; 32-bit integers are compared in single precision.
        let tolerance =
            |v: f32| if elements.component == Component::F32 { 1e-5 * v.abs().max(1e-3) } else { 0.0 };
        let wrong = stated.iter().zip(found).find(|(s, f)| (**s as f32 - f).abs() > tolerance(*f));
        if let Some((stated, found)) = wrong.filter(|_| elements.count > 0) {
            add(faults, "/accessors", i, member, format!("has {stated}, but of the values it is {found}"));
        }
    }
}

/// The values of a primitive's attributes and indices.
fn vertices(reader: &mut Reader<'_>, primitive: &Primitive, m: usize, at: &str, faults: &mut Faults) {
    let document = reader.document;
    let count = primitive
        .attributes
        .get("POSITION")
        .and_then(|p| document.accessors.get(p.index()))
        .and_then(|a| a.count)
        .map_or(u64::MAX, |c| c.0);
    if let Some(indices) = primitive.indices.and_then(|i| reader.open(i)).filter(Elements::is_unsigned) {
        let restart = match indices.component {
            Component::U8 => u32::from(u8::MAX),
            Component::U16 => u32::from(u16::MAX),
            _ => u32::MAX,
        };
        let most = (0..indices.count).map(|k| indices.index(k)).max().unwrap_or(0);
        if most == restart {
            add(faults, "/meshes", m, &format!("{at}/indices"), "has the index that restarts primitives");
        } else if u64::from(most) >= count {
            add(
                faults,
                "/meshes",
                m,
                &format!("{at}/indices"),
                format!("has {most}, but there are {count} vertices"),
            );
        }
    }
    for (name, &index) in &primitive.attributes {
        let member = format!("{at}/attributes/{name}");
        let is_color = name.starts_with("COLOR_");
        if !is_color && !["NORMAL", "TANGENT"].contains(&name.as_str()) {
            continue;
        }
        let Some(values) = reader.open(index) else { continue };
        let all = |is: &dyn Fn([f32; 4]) -> bool| (0..values.count).all(|k| is(values.get::<4>(k)));
        if is_color {
            if !all(&|c| c.iter().all(|v| (0.0..=1.0).contains(v))) {
                add(faults, "/meshes", m, &member, "has values outside of 0 to 1");
            }
        } else if !all(&|[x, y, z, _]| ((x * x + y * y + z * z).sqrt() - 1.0).abs() <= UNIT) {
            add(faults, "/meshes", m, &member, "has vectors whose length is not 1");
        } else if name == "TANGENT" && !all(&|t| t[3].abs() == 1.0) {
            add(faults, "/meshes", m, &member, "has a sign that is neither 1 nor -1");
        }
    }
}

/// Key times and rotations of animations.
fn times(reader: &mut Reader<'_>, faults: &mut Faults) {
    let document = reader.document;
    for (i, animation) in document.animations.iter().enumerate() {
        for (s, sampler) in animation.samplers.iter().enumerate() {
            let Some(times) = reader.open(sampler.input).filter(|t| t.width == 1) else { continue };
            let time = |k: usize| times.get::<1>(k)[0];
            let increase = (1..times.count).all(|k| time(k - 1) < time(k));
            if !increase || times.count > 0 && time(0) < 0.0 {
                let message = "has times that are negative or do not increase";
                add(faults, "/animations", i, &format!("/samplers/{s}/input"), message);
            }
        }
        for (c, channel) in animation.channels.iter().enumerate().filter(|(_, c)| c.target.path == "rotation")
        {
            let Some(sampler) = animation.samplers.get(channel.sampler.index()) else { continue };
            let Some(values) = reader.open(sampler.output).filter(|v| v.width == 4) else { continue };
            let cubic = sampler.interpolation.as_deref() == Some("CUBICSPLINE");
            let mut rows = (0..values.count).filter(|k| !cubic || k % 3 == 1);
            let length = |k: usize| values.get::<4>(k).iter().map(|v| v * v).sum::<f32>().sqrt();
            if rows.any(|k| (length(k) - 1.0).abs() > UNIT) {
                let member = format!("/channels/{c}/sampler");
                add(faults, "/animations", i, &member, "has rotations that are not unit quaternions");
            }
        }
    }
}
