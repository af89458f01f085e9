//! Models: files in other formats, placed in a scene as one object.

use std::sync::Arc;

use super::read::Reader;
use crate::camera::CameraDesc;
use crate::description::*;
use crate::light::LightDesc;
use crate::math::elementary::cbrt;
use crate::math::{DAffine3, DMat3, DVec3};
use crate::schema::error::unknown_name;
use crate::schema::value::Span;
use crate::schema::{
    ErrorCode, GroupId, MaterialId, MaterialsByName, Named, ReadContext, Renumber, SceneError, TableReader,
    Transform, choice, params,
};
use crate::shape::ShapeDesc;

choice! {
    /// The axis of a model that points up.
    pub enum UpAxis {
        /// y, as in glTF and in Turner's scenes.
        Y = "y",
        /// z, as in most CAD and 3D-printing programs.
        Z = "z",
    }
}

impl UpAxis {
    /// The rotation from the model's axes to the scene's.
    pub fn rotation(self) -> DAffine3 {
        match self {
            UpAxis::Y => DAffine3::IDENTITY,
            UpAxis::Z => DAffine3::from_mat3(DMat3::from_cols(DVec3::X, -DVec3::Z, DVec3::Y)),
        }
    }
}

params! {
    /// A model file: glTF or GLB, USD, OBJ with its MTL, PLY, STL. Its objects become one object of the scene. Its
    /// lights and cameras are added to the scene, except in a group. A `material` of the object replaces all materials of
    /// the model.
    pub struct ModelDesc as "model" {
        /// The model file, as a path relative to the scene file.
        file: String, required, default String::new();
        /// The names of nodes (glTF), prims (USD) or groups (OBJ) to load, with everything below them. Without this key,
        /// all are loaded.
        nodes: Vec<String> = Vec::new();
        /// The scene of the file to load, by name or index. Without this key, the default scene of the file.
        scene: Option<String> = None;
        /// The material variant, by name or index.
        variant: Option<String> = None;
        /// The animation, by name or index; "none" is the pose without animation. Without this key, the first one.
        animation: Option<String> = None;
        /// The time in the animation, seconds.
        time: f64 = 0.0;
        /// The axis of the file that points up.
        up: UpAxis = UpAxis::Y;
        /// Materials that replace the model's materials of these names.
        materials: Option<MaterialsByName> = None;
    }
    example r##"[[object]]
type = "model"
file = "model.obj"
transform = { rotate = [0, 30, 0] }
materials = { paint = { type = "principled", base_color = "tomato", specular_roughness = 0.4 } }
"##
}

/// A model that is already part of the scene. Further objects with the same model become instances of its group.
pub(super) struct PlacedModel {
    model: Arc<SceneDesc>,
    material: Option<MaterialId>,
    group: GroupId,
    /// Whether the object replaced materials by name. Its group is then not shared, because the materials may differ.
    has_own_materials: bool,
}

impl Reader<'_> {
    /// Reads an object of the type "model".
    pub(super) fn read_model(
        &mut self,
        table: &mut TableReader<'_>,
        (material, hidden): (Option<MaterialId>, bool),
        transform: &mut Transform,
        motion: &mut Option<Transform>,
    ) -> Result<GroupId, SceneError> {
        let before = self.faults();
        let desc = ModelDesc::read(table, self)?;
        let source = Box::new(desc.clone());
        // A missing file name or wrong options would cause further, misleading errors.
        if self.faults() > before {
            return Ok(GroupId(0));
        }
        let span = table.span_of("file");
        let model = self.once(&format!("{desc:?}"), span, |assets| assets.model(&desc, span.file))?;
        for placed in std::iter::once(transform as &mut Transform).chain(motion) {
            placed.0 *= desc.up.rotation();
        }
        let in_group = self.in_group;
        let overrides = desc.materials.map(|m| m.0).unwrap_or_default();
        let from = self.span_of_model(table.span());
        if overrides.is_empty()
            && let Some(placed) = self
                .models
                .iter()
                .find(|p| Arc::ptr_eq(&p.model, &model) && p.material == material && !p.has_own_materials)
        {
            let group = placed.group;
            self.place_lights_and_cameras(&model, &transform.0, (in_group, hidden), (false, from));
            return Ok(group);
        }
        let by = Renumber {
            textures: self.textures.len() as u32,
            materials: self.materials.len() as u32,
            images: self.images.len() as u32,
            meshes: self.meshes.len() as u32,
            groups: self.group_count,
            media: self.media.len() as u32,
            ..Renumber::default()
        };
        self.textures.extend(model.textures.iter().cloned().map(|mut t| {
            t.value.renumber(&by);
            t.span = Some(from);
            Some(t)
        }));
        self.materials.extend(model.materials.iter().cloned().map(|mut m| {
            m.value.renumber(&by);
            m.span = Some(from);
            Some(m)
        }));
        self.media.extend(model.media.iter().cloned().map(|m| Some(Named { span: Some(from), ..m })));
        self.images.extend(model.images.iter().cloned());
        self.meshes.extend(model.meshes.iter().cloned());
        let replaced = replacements(&model, &overrides)?;
        let place = |objects: &[ObjectDesc]| -> Vec<ObjectDesc> {
            let place = |object: &ObjectDesc| placed_object(object, &by, material, &replaced);
            objects.iter().map(place).collect()
        };
        for group in &model.groups {
            let value = GroupDesc { objects: place(&group.value.objects), model: None };
            self.more_groups.push(Named { name: None, span: Some(from), value });
        }
        let whole = GroupDesc { objects: place(&model.objects), model: Some(source) };
        self.more_groups.push(Named { name: None, span: Some(from), value: whole });
        self.group_count += model.groups.len() as u32 + 1;
        let group = GroupId(self.group_count - 1);
        self.imports.extend(model.imports.iter().cloned());
        self.warnings.extend(model.warnings.iter().cloned());
        self.place_lights_and_cameras(&model, &transform.0, (in_group, hidden), (true, from));
        let has_own_materials = !overrides.is_empty();
        self.models.push(PlacedModel { model, material, group, has_own_materials });
        Ok(group)
    }

    /// The span that all parts of a model get: that of the object's table. For an object that a program made, a span
    /// that is in no file and that no other model has.
    fn span_of_model(&self, table: Span) -> Span {
        if table.file != Span::NONE.file {
            return table;
        }
        let number = self.group_count + 1;
        Span { file: Span::NONE.file, start: number, end: number }
    }

    fn place_lights_and_cameras(
        &mut self,
        model: &SceneDesc,
        by: &DAffine3,
        (in_group, hidden): (bool, bool),
        (first, from): (bool, Span),
    ) {
        if in_group {
            if !(model.lights.is_empty() && model.cameras.is_empty()) {
                (self as &mut dyn ReadContext)
                    .warn(None, "the lights and cameras of a model in a group are ignored: place the model in the scene itself to use them");
            }
            return;
        }
        for light in &model.lights {
            let value = placed_light(&light.value, by);
            self.model_lights.push(SceneLight {
                value,
                motion: light.motion.map(|motion| placed_motion(motion, by)),
                span: Some(from),
                hidden: light.hidden || hidden,
                ..light.clone()
            });
        }
        if first {
            for camera in &model.cameras {
                let value = placed_camera(&camera.value, by);
                self.cameras.push(Named { value, span: Some(from), ..camera.clone() });
            }
        }
    }
}

/// Pairs of the model's materials and their replacements.
///
/// Errors: a name that no material of the model has.
fn replacements(
    model: &SceneDesc,
    overrides: &[(String, Span, MaterialId)],
) -> Result<Vec<(MaterialId, MaterialId)>, SceneError> {
    let mut out = Vec::new();
    for (name, span, material) in overrides {
        let before = out.len();
        for (i, own) in model.materials.iter().enumerate() {
            if own.name.as_deref() == Some(name) {
                out.push((MaterialId(i as u32), *material));
            }
        }
        if out.len() == before {
            let names: Vec<&str> = model.materials.iter().filter_map(|m| m.name.as_deref()).collect();
            let what = "material of this model";
            return Err(unknown_name(ErrorCode::UnknownName, *span, what, name, &names));
        }
    }
    Ok(out)
}

/// An object of a model, with the IDs of the scene.
fn placed_object(
    object: &ObjectDesc,
    by: &Renumber,
    material: Option<MaterialId>,
    replaced: &[(MaterialId, MaterialId)],
) -> ObjectDesc {
    let own = |id: MaterialId| {
        let other = replaced.iter().find(|(old, _)| *old == id).map(|(_, new)| *new);
        other.unwrap_or_else(|| by.material(id))
    };
    let content = match &object.content {
        ObjectContent::Instance(g) => ObjectContent::Instance(by.group(*g)),
        ObjectContent::Shape(shape) => {
            let mut shape = shape.clone();
            if let ShapeDesc::Mesh(mesh) = &mut shape {
                mesh.mesh = by.mesh(mesh.mesh);
                match material {
                    Some(_) => mesh.materials.clear(),
                    None => mesh.materials.iter_mut().for_each(|m| *m = m.map(own)),
                }
            } else {
                shape.renumber(by);
            }
            ObjectContent::Shape(shape)
        }
    };
    let material = material.or(object.material.map(own));
    ObjectDesc { content, material, ..object.clone() }
}

/// A light transformed with its model. Its intensity does not change.
fn placed_light(light: &LightDesc, by: &DAffine3) -> LightDesc {
    let mut light = light.clone();
    match &mut light {
        LightDesc::Point(l) => l.position = by.transform_point3(l.position),
        LightDesc::Spot(l) => {
            l.position = by.transform_point3(l.position);
            l.look_at = by.transform_point3(l.look_at);
            l.image_up = by.transform_vector3(l.image_up);
            l.radius *= cbrt(by.matrix3.determinant().abs());
        }
        LightDesc::Directional(l) => {
            l.from = l.from.map(|v| by.transform_vector3(v));
            l.direction = l.direction.map(|v| by.transform_vector3(v));
        }
        // Models do not contain these, or they have no position.
        LightDesc::Ambient(_)
        | LightDesc::Rectangle(_)
        | LightDesc::Disk(_)
        | LightDesc::Sphere(_)
        | LightDesc::Environment(_)
        | LightDesc::Sky(_) => {}
    }
    light
}

/// A camera transformed with its model.
fn placed_camera(camera: &CameraDesc, by: &DAffine3) -> CameraDesc {
    let mut camera = camera.clone();
    let [position, look_at, up] = camera.placement_mut();
    *position = by.transform_point3(*position);
    *look_at = by.transform_point3(*look_at);
    *up = by.transform_vector3(*up);
    let motion = camera.motion_mut();
    *motion = motion.map(|motion| placed_motion(motion, by));
    camera
}

/// What moves a light or camera of a model, in the space of the scene.
fn placed_motion(motion: Transform, by: &DAffine3) -> Transform {
    Transform(*by * motion.0 * by.inverse())
}
