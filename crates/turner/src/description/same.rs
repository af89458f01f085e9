//! Comparison of descriptions: whether two of them are the same scene.
//!
//! Two descriptions can differ in ways that do not affect the picture: file positions, the names that references use,
//! the order of images and meshes, assets that nothing uses. A comparison field by field would report these. So both
//! descriptions are first brought into a canonical form: spans and these names are removed, and images and meshes are
//! numbered in the order of their first use, found by visiting the background, lights, media, textures, materials and
//! objects in a fixed order. The canonical forms are then equal exactly if the scenes are the same, and assets are
//! compared bit by bit in the new numbering. The cost is one clone of each description, which shares the assets, and
//! one pass. Assets that both descriptions share (the same `Arc`) are equal without a comparison.

use std::sync::Arc;

use crate::description::*;
use crate::image::{Image, Pixels};
use crate::schema::{Asset, MeshData, Renumber};

impl SceneDesc {
    /// Checks that two descriptions are the same scene, so that they render to the same bytes.
    ///
    /// These must be equal: camera, film, integrator, background and studio; the lists of other cameras, lights,
    /// textures, materials, media, groups and objects, in their order, including the names of cameras, lights and
    /// objects and the light groups; and the decoded data of every image, mesh, IES profile and grid that these refer
    /// to, bit by bit.
    ///
    /// These may differ: positions in files; the names of textures, materials, media and groups, which serve as
    /// references only; the order of images and meshes, unused images and meshes, and their file names; import
    /// summaries; warnings.
    ///
    /// Errors: a description of the first difference.
    pub fn same_scene(&self, other: &SceneDesc) -> Result<(), String> {
        let [a, b] = [Canonical::of(self), Canonical::of(other)];
        let (x, y) = (&a.desc, &b.desc);
        same("camera", &x.camera, &y.camera)?;
        same("film", &x.film, &y.film)?;
        same("integrator", &x.integrator, &y.integrator)?;
        same("background", &x.background, &y.background)?;
        same("studio", &x.studio, &y.studio)?;
        same_lists("view", &x.cameras, &y.cameras)?;
        same_lists("light", &x.lights, &y.lights)?;
        same_lists("animation", &x.animations, &y.animations)?;
        same_lists("medium", &x.media, &y.media)?;
        same_lists("texture", &x.textures, &y.textures)?;
        same_lists("material", &x.materials, &y.materials)?;
        same_lists("group", &x.groups, &y.groups)?;
        same_lists("object", &x.objects, &y.objects)?;
        let images = |c: &Canonical, d: &SceneDesc| c.pick(&c.by.images_in_order(), &d.images);
        let meshes = |c: &Canonical, d: &SceneDesc| c.pick(&c.by.meshes_in_order(), &d.meshes);
        assets("picture", &images(&a, self), &images(&b, other), same_image)?;
        assets("mesh", &meshes(&a, self), &meshes(&b, other), same_mesh)
    }
}

impl SceneDesc {
    /// Like [`same_scene`](SceneDesc::same_scene), except that the lists of textures, materials, media and groups may be
    /// in another order, and that parts without a name which nothing uses may be missing. Neither affects the picture.
    /// A scene whose parts moved between a table of their own and the place of their use is the same in this sense.
    ///
    /// Errors: a description of the first difference.
    pub fn same_apart_from_order(&self, other: &SceneDesc) -> Result<(), String> {
        self.in_order_of_use().same_scene(&other.in_order_of_use())
    }
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, a: &T, b: &T) -> Result<(), String> {
    if a == b { Ok(()) } else { Err(format!("{what}: {a:?}\nis not {b:?}")) }
}

fn same_lists<T: PartialEq + std::fmt::Debug>(what: &str, a: &[T], b: &[T]) -> Result<(), String> {
    if a.len() != b.len() {
        return Err(format!("{what}: {} of them, not {}", a.len(), b.len()));
    }
    let mut pairs = a.iter().zip(b).enumerate();
    pairs.try_for_each(|(i, (a, b))| same(&format!("{what} {i}"), a, b))
}

fn assets<T>(
    what: &str,
    a: &[Option<Arc<T>>],
    b: &[Option<Arc<T>>],
    same: impl Fn(&T, &T) -> bool,
) -> Result<(), String> {
    if a.len() != b.len() {
        return Err(format!("{what}: {} of them are used, not {}", a.len(), b.len()));
    }
    let equal = |a: &Option<Arc<T>>, b: &Option<Arc<T>>| match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b) || same(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    match a.iter().zip(b).position(|(a, b)| !equal(a, b)) {
        Some(i) => Err(format!("{what} {i}, in the order of use, is another")),
        None => Ok(()),
    }
}

fn bits(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn same_image(a: &Image, b: &Image) -> bool {
    let pixels = match (&a.pixels, &b.pixels) {
        (Pixels::F32(a), Pixels::F32(b)) => bits(a, b),
        (a, b) => a == b,
    };
    (a.width, a.height, a.channels) == (b.width, b.height, b.channels) && pixels
}

fn same_mesh(a: &MeshData, b: &MeshData) -> bool {
    // Destructured, so that the compiler reports a new field that is not compared here.
    let MeshData {
        positions,
        normals,
        uvs,
        more_uvs,
        tangents,
        colors,
        triangles,
        polygons,
        face_materials,
        material_names,
        strands,
        widths,
    } = a;
    bits(positions.as_flattened(), b.positions.as_flattened())
        && bits(normals.as_flattened(), b.normals.as_flattened())
        && bits(uvs.as_flattened(), b.uvs.as_flattened())
        && more_uvs.len() == b.more_uvs.len()
        && more_uvs.iter().zip(&b.more_uvs).all(|(a, b)| bits(a.as_flattened(), b.as_flattened()))
        && bits(tangents.as_flattened(), b.tangents.as_flattened())
        && bits(colors.as_flattened(), b.colors.as_flattened())
        && *triangles == b.triangles
        && *polygons == b.polygons
        && *face_materials == b.face_materials
        && *material_names == b.material_names
        && *strands == b.strands
        && bits(widths, &b.widths)
}

/// A description in canonical form, with the numbering of its images and meshes.
struct Canonical {
    desc: SceneDesc,
    by: Renumber,
}

impl Canonical {
    fn of(desc: &SceneDesc) -> Canonical {
        let by = Renumber::in_order_of_use();
        let mut out = SceneDesc {
            images: Vec::new(),
            meshes: Vec::new(),
            imports: Vec::new(),
            warnings: Vec::new(),
            ..desc.clone()
        };
        out.background.renumber(&by);
        out.camera.iter_mut().chain(&mut out.cameras).for_each(|c| c.span = None);
        out.animations.iter_mut().for_each(|a| a.span = None);
        for light in &mut out.lights {
            light.span = None;
            light.value.renumber(&by);
        }
        macro_rules! plain {
            ($list:ident) => {
                for item in &mut out.$list {
                    (item.name, item.span) = (None, None);
                    item.value.renumber(&by);
                }
            };
        }
        plain!(media);
        plain!(textures);
        plain!(materials);
        for group in &mut out.groups {
            (group.name, group.span, group.value.model) = (None, None, None);
        }
        let in_groups = out.groups.iter_mut().flat_map(|g| &mut g.value.objects);
        for object in in_groups.chain(&mut out.objects) {
            object.span = None;
            if let ObjectContent::Shape(shape) = &mut object.content {
                shape.renumber(&by);
            }
        }
        Canonical { desc: out, by }
    }

    fn pick<T>(&self, order: &[u32], list: &[Asset<T>]) -> Vec<Option<Arc<T>>> {
        order.iter().map(|i| list.get(*i as usize).map(|a| Arc::clone(&a.data))).collect()
    }
}
