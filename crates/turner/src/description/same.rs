//! When two descriptions are the same scene.

use std::sync::Arc;

use crate::description::*;
use crate::image::{Image, Pixels};
use crate::schema::{Asset, MeshData, Renumber};

impl SceneDesc {
    /// Whether two descriptions are the same scene, so that they prepare and render to the same bytes.
    ///
    /// They are, if all of these are equal: camera, film, integrator, background and stage; the lists of other cameras, lights, textures, materials, media, groups and
    /// objects, one by one in their order, with the names of cameras, lights and objects and with the groups of lights; and every picture, mesh, measured lamp
    /// and grid that these refer to, bit by bit (as they are in memory: how a file holds them does not matter).
    ///
    /// These may differ: places in files (spans); the names of textures, materials, media and groups, which say only what refers to what; the order of
    /// pictures and meshes, ones that nothing refers to, and the names of their files; what was imported; the warnings.
    ///
    /// Errors: the first difference, in words.
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
    // Named one by one, so that a list that is added is not forgotten here.
    let MeshData {
        positions,
        normals,
        uvs,
        more_uvs,
        tangents,
        colors,
        triangles,
        face_materials,
        material_names,
    } = a;
    bits(positions.as_flattened(), b.positions.as_flattened())
        && bits(normals.as_flattened(), b.normals.as_flattened())
        && bits(uvs.as_flattened(), b.uvs.as_flattened())
        && more_uvs.len() == b.more_uvs.len()
        && more_uvs.iter().zip(&b.more_uvs).all(|(a, b)| bits(a.as_flattened(), b.as_flattened()))
        && bits(tangents.as_flattened(), b.tangents.as_flattened())
        && bits(colors.as_flattened(), b.colors.as_flattened())
        && *triangles == b.triangles
        && *face_materials == b.face_materials
        && *material_names == b.material_names
}

/// A description without what does not count, its pictures and meshes numbered in the order in which they are first referred to.
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
        for light in &mut out.lights {
            light.span = None;
            light.value.renumber(&by);
        }
        macro_rules! plain {
            ($list:ident) => {
                for thing in &mut out.$list {
                    (thing.name, thing.span) = (None, None);
                    thing.value.renumber(&by);
                }
            };
        }
        plain!(media);
        plain!(textures);
        plain!(materials);
        for group in &mut out.groups {
            (group.name, group.span) = (None, None);
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
