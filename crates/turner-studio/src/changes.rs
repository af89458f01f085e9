//! What actions do with the parts of the scene.

use turner::SceneDesc;
use turner::description::{ObjectContent, ObjectDesc, SceneLight};
use turner::light::LightDesc;
use turner::material::MaterialDesc;
use turner::math::DVec3;
use turner::schema::{MaterialId, SceneError};
use turner::shape::ShapeDesc;

use crate::cameras::camera_of;
use crate::node::Node;
use crate::studio::{Dialog, Studio};

/// Changes the scene by a function that gives the key path of the part to select.
pub(crate) fn change(
    studio: &mut Studio,
    label: &str,
    change: impl FnOnce(&mut SceneDesc) -> Result<String, SceneError>,
) {
    let result = studio.document.edit(label, None, change);
    if let Some(path) = studio.check(result) {
        let node = Node::of_path(&path, &studio.document.desc().names());
        studio.select(node, false);
    }
}

/// The key paths of all selected parts.
pub(crate) fn selected_paths(studio: &Studio) -> Vec<String> {
    let names = studio.document.desc().names();
    studio.selected().into_iter().filter_map(|node| node.path(&names)).collect()
}

/// The material of the selected object.
pub(crate) fn material_of(studio: &Studio) -> Option<Node> {
    let Some(Node::Object(i)) = studio.selection else { return None };
    let material = studio.document.desc().objects.get(i)?.material?;
    Some(Node::Material(material.0 as usize))
}

pub(crate) fn duplicate(studio: &mut Studio) {
    let paths = selected_paths(studio);
    change(studio, "Duplicate", |desc| {
        let mut last = String::new();
        for path in &paths {
            last = desc.duplicate(path)?;
        }
        Ok(last)
    });
}

pub(crate) fn delete(studio: &mut Studio) {
    let (nodes, paths) = (studio.selected(), selected_paths(studio));
    let label = match nodes.as_slice() {
        [node] => format!("Delete {}", node.label(studio.document.desc())),
        nodes => format!("Delete {} parts", nodes.len()),
    };
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    let result = studio.document.edit(&label, None, |desc| desc.remove(&paths));
    if studio.check(result).is_some() {
        studio.select(None, false);
    }
}

/// Hides what is selected; shows it if all of it is hidden.
pub(crate) fn hide(studio: &mut Studio) {
    let nodes = studio.selected();
    let desc = studio.document.desc();
    let is_hidden = |node: &Node| match *node {
        Node::Object(i) => desc.objects[i].hidden,
        Node::Light(i) => desc.lights[i].hidden,
        _ => true,
    };
    let hidden = !nodes.iter().all(is_hidden);
    let result = studio.document.edit(if hidden { "Hide" } else { "Show" }, None, |desc| {
        for node in nodes {
            match node {
                Node::Object(i) => desc.objects[i].hidden = hidden,
                Node::Light(i) => desc.lights[i].hidden = hidden,
                _ => {}
            }
        }
        Ok(())
    });
    studio.check(result);
}

pub(crate) fn group(studio: &mut Studio) {
    let paths = selected_paths(studio);
    let paths: Vec<&str> =
        paths.iter().map(String::as_str).filter(|path| path.starts_with("object.")).collect();
    change(studio, "Group", |desc| desc.group_objects(&paths, "group"));
}

pub(crate) fn ungroup(studio: &mut Studio) {
    let Some(path) = selected_paths(studio).pop() else { return };
    change(studio, "Ungroup", |desc| {
        let paths = desc.ungroup(&path)?;
        Ok(paths.into_iter().next().unwrap_or_default())
    });
}

/// The point that new things are placed at: that at which the camera looks.
pub(crate) fn place(studio: &Studio) -> DVec3 {
    let Some(mut camera) = camera_of(studio) else { return DVec3::ZERO };
    let [_, look_at, _] = camera.value.placement_mut();
    *look_at
}

pub(crate) fn add_shape(studio: &mut Studio, kind: &'static str) {
    let Some(shape) = ShapeDesc::of_type(kind) else { return };
    // A plane is a floor; all else stands where the camera looks.
    let at = if matches!(shape, ShapeDesc::Plane(_)) { DVec3::ZERO } else { place(studio) };
    change(studio, &format!("Add {kind}"), |desc| {
        let mut object = ObjectDesc { content: ObjectContent::Shape(shape), ..ObjectDesc::default() };
        object.name = Some(free_name(kind, desc.objects.iter().map(|o| &o.name)));
        object.transform.0.translation = at;
        Ok(desc.add_object(object))
    });
}

/// `kind`, or `kind 2`, … if it is taken.
pub(crate) fn free_name<'a>(kind: &str, taken: impl Iterator<Item = &'a Option<String>> + Clone) -> String {
    let is_free = |name: &String| !taken.clone().any(|other| other.as_ref() == Some(name));
    let numbered = (2..).map(|n: u32| format!("{kind} {n}"));
    std::iter::once(kind.to_owned()).chain(numbered).find(is_free).unwrap_or_default()
}

/// Where a new directional light comes from.
pub(crate) const DIRECTION: DVec3 = DVec3::new(1.0, 3.0, 2.0);

pub(crate) fn add_light(studio: &mut Studio, kind: &'static str) {
    let Some(mut light) = LightDesc::of_type(kind) else { return };
    let at = place(studio) + DVec3::new(1.0, 3.0, 1.0);
    match &mut light {
        LightDesc::Point(l) => l.position = at,
        LightDesc::Spot(l) => l.position = at,
        LightDesc::Directional(l) => l.from = Some(DIRECTION),
        _ => {}
    }
    change(studio, &format!("Add {kind} light"), |desc| {
        let name = Some(free_name(&format!("{kind} light"), desc.lights.iter().map(|l| &l.name)));
        Ok(desc.add_light(SceneLight { name, ..light.into() }))
    });
}

/// A new material of the kind that the integrator prefers; the selected object gets it.
pub(crate) fn add_material(studio: &mut Studio) {
    let desc = studio.document.desc();
    let kind = if desc.integrator.capabilities().physical { "principled" } else { "classic" };
    let Some(material) = MaterialDesc::of_type(kind) else { return };
    let object = if let Some(Node::Object(i)) = studio.selection { Some(i) } else { None };
    change(studio, "Add material", |desc| {
        let path = desc.add_material("material", material);
        let id = MaterialId((desc.materials.len() - 1) as u32);
        if let Some(object) = object.and_then(|i| desc.objects.get_mut(i)) {
            object.material = Some(id);
        }
        Ok(path)
    });
}

/// The name that a part has, if it is one that can be renamed.
pub(crate) fn name_of(studio: &Studio, node: Node) -> Option<String> {
    let desc = studio.document.desc();
    let names = desc.names();
    match node {
        Node::Object(i) => desc.objects.get(i).map(|o| o.name.clone().unwrap_or_default()),
        Node::Light(i) => desc.lights.get(i).map(|l| l.name.clone().unwrap_or_default()),
        Node::View(i) => desc.cameras.get(i).map(|c| c.name.clone().unwrap_or_default()),
        Node::Material(i) => names.materials.get(i).cloned(),
        Node::Texture(i) => names.textures.get(i).cloned(),
        Node::Medium(i) => names.media.get(i).cloned(),
        Node::Camera | Node::Film | Node::Integrator | Node::Background | Node::Studio => None,
    }
}

/// Asks for the new name of the selected part.
pub(crate) fn ask_name(studio: &mut Studio) {
    let Some(node) = studio.selection else { return };
    if let Some(name) = name_of(studio, node) {
        studio.dialog = Some(Dialog::Rename { node, name, fault: None });
    }
}

/// Gives a part another name. It stays selected.
pub(crate) fn rename(studio: &mut Studio, node: Node, name: &str) -> Result<(), SceneError> {
    let path = node.path(&studio.document.desc().names());
    studio.document.end_gesture();
    match path {
        Some(path) => studio.document.rename(&path, name).map(|_| ()),
        None => Ok(()),
    }
}
