//! A small picture of the selected texture or material, on its own.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use egui::{ColorImage, TextureHandle, TextureOptions, Ui};
use turner::camera::{CameraDesc, OrthographicDesc};
use turner::description::StudioDesc;
use turner::film::{Antialias, Denoise};
use turner::integrator::{AlbedoDesc, IntegratorDesc, PathDesc};
use turner::light::{AmbientDesc, LightDesc, PointDesc};
use turner::material::{MaterialDesc, MatteMaterial};
use turner::math::DVec3;
use turner::schema::{ColorSource, MaterialId, PrepareOptions, SceneError, TextureId};
use turner::shape::{RectangleDesc, ShapeDesc, SphereDesc};
use turner::{ObjectDesc, PassOptions, Renderer, SceneDesc};

use crate::node::Node;
use crate::studio::Studio;
use crate::task::Task;

/// The name of the part while it is drawn.
const NAME: &str = "part of the swatch";

/// Columns and rows.
const SIZE: u32 = 128;

/// The picture and what it was made of.
#[derive(Default)]
pub struct Swatch {
    texture: Option<TextureHandle>,
    of: Option<(Arc<SceneDesc>, Node)>,
    task: Option<Task<Option<ColorImage>>>,
}

/// A scene that shows one part.
fn scene(desc: &SceneDesc, node: Node) -> Result<Option<SceneDesc>, SceneError> {
    let mut named = desc.clone();
    // Parts without a name are numbered, and the part alone has another number.
    let name = match node {
        Node::Texture(i) => named.textures.get_mut(i).map(|texture| &mut texture.name),
        Node::Material(i) => named.materials.get_mut(i).map(|material| &mut material.name),
        _ => None,
    };
    let Some(name) = name else { return Ok(None) };
    *name = Some(NAME.to_owned());
    let Some(path) = node.path(&named.names()) else { return Ok(None) };
    let mut part = named.extract(&[&path])?;
    let is_own = |name: &Option<String>| name.as_deref() == Some(NAME);
    (part.film.width, part.film.height) = (SIZE, SIZE);
    match node {
        Node::Texture(_) => {
            let own = part.textures.iter().position(|texture| is_own(&texture.name));
            let Some(own) = own else { return Ok(None) };
            let color = ColorSource::Texture(TextureId(own as u32));
            part.materials
                .push(MaterialDesc::Matte(MatteMaterial { color, ..MatteMaterial::default() }).into());
            let material = Some(MaterialId((part.materials.len() - 1) as u32));
            let square = ShapeDesc::Rectangle(RectangleDesc::default());
            part.objects.push(ObjectDesc { material, ..ObjectDesc::new(square) });
            let viewport = turner::camera::Viewport::Height(2.0);
            part.camera = Some(
                CameraDesc::Orthographic(OrthographicDesc { viewport, ..OrthographicDesc::default() }).into(),
            );
            part.integrator = IntegratorDesc::Albedo(AlbedoDesc::default());
        }
        Node::Material(_) => {
            let own = part.materials.iter().position(|material| is_own(&material.name));
            let Some(own) = own else { return Ok(None) };
            let ball = ShapeDesc::Sphere(SphereDesc { center: DVec3::Y, radius: 1.0 });
            part.objects.push(ObjectDesc { material: Some(MaterialId(own as u32)), ..ObjectDesc::new(ball) });
            if desc.integrator.capabilities().physical {
                part.integrator = IntegratorDesc::Path(PathDesc::default());
                part.studio = Some(StudioDesc::default());
                (part.film.antialias, part.film.samples) = (Antialias::MonteCarlo, 16);
                (part.film.transfer, part.film.denoise) = (turner::color::Transfer::Srgb, Denoise::On);
            } else {
                part.integrator = desc.integrator.clone();
                let light = PointDesc { position: DVec3::new(4.0, 6.0, 8.0), ..PointDesc::default() };
                part.lights.push(LightDesc::Point(light).into());
                part.lights.push(LightDesc::Ambient(AmbientDesc::default()).into());
                part.film.antialias = Antialias::Adaptive;
            }
        }
        _ => return Ok(None),
    }
    Ok(Some(part))
}

fn draw(desc: &SceneDesc, node: Node, stop: &AtomicBool) -> Option<ColorImage> {
    let part = scene(desc, node).ok()??;
    let prepared = part.prepare(&PrepareOptions { threads: 1, ..PrepareOptions::default() }).ok()?;
    let mut renderer = Renderer::new(prepared).ok()?;
    let done = renderer.pass(u32::MAX, &PassOptions { threads: 1, cancel: stop, progress: None });
    done.is_ok_and(|done| done).then(|| crate::viewport::image(&renderer.develop()))
}

/// Shows the swatch of a texture or a material; nothing for other parts.
pub(crate) fn show(ui: &mut Ui, studio: &mut Studio, node: Node) {
    if !matches!(node, Node::Texture(_) | Node::Material(_)) {
        return;
    }
    let desc = Arc::clone(studio.document.desc());
    let swatch = &mut studio.swatch;
    if let Some(task) = &swatch.task
        && let Some(result) = task.poll()
    {
        swatch.task = None;
        let image = result.ok().flatten();
        swatch.texture = image.map(|image| ui.ctx().load_texture("swatch", image, TextureOptions::LINEAR));
    }
    let is_same = swatch.of.as_ref().is_some_and(|(of, at)| Arc::ptr_eq(of, &desc) && *at == node);
    if !is_same && swatch.task.is_none() {
        if swatch.of.as_ref().is_some_and(|(_, at)| *at != node) {
            swatch.texture = None;
        }
        swatch.of = Some((Arc::clone(&desc), node));
        swatch.task = Some(Task::start(ui.ctx(), move |stop| draw(&desc, node, stop)));
    }
    // It has its place before it is drawn: the form below does not jump, and keeps the keyboard.
    let (rect, response) = ui.allocate_exact_size(egui::Vec2::splat(SIZE as f32), egui::Sense::hover());
    crate::widgets::name(&response, egui::Role::Image, "Swatch");
    if let Some(texture) = &swatch.texture {
        let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        ui.painter().image(texture.id(), rect, whole, egui::Color32::WHITE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use turner_live::document::{Document, STARTS};

    #[test]
    fn every_material_and_texture_of_the_gallery_has_a_swatch() {
        for name in ["4. Wood", "12. Cube", "Material balls"] {
            let start = STARTS.iter().find(|start| start.name == name).unwrap();
            let document = Document::start(start).unwrap();
            let desc = document.desc();
            let materials = (0..desc.materials.len().min(4)).map(Node::Material);
            for node in materials.chain((0..desc.textures.len()).map(Node::Texture)) {
                let image =
                    draw(desc, node, &AtomicBool::new(false)).unwrap_or_else(|| panic!("{name}: {node:?}"));
                let first = image.pixels[0];
                assert!(image.pixels.iter().any(|p| *p != first), "{name}: {node:?} is one colour");
            }
        }
    }
}
