//! What the parts of a description refer to: which textures, materials, media, groups, images and meshes are in use.

use std::collections::HashSet;

use crate::description::*;
use crate::schema::value::Span;
use crate::schema::{IdMaps, Named, PartId, Renumber};

/// The number of parts of each kind.
fn counts(desc: &SceneDesc) -> [usize; 6] {
    let SceneDesc { textures, materials, media, groups, images, meshes, .. } = desc;
    [textures.len(), materials.len(), media.len(), groups.len(), images.len(), meshes.len()]
}

/// The index of a part's kind in [`counts`], and the part's number.
fn slot(part: PartId) -> (usize, usize) {
    match part {
        PartId::Texture(i) => (0, i as usize),
        PartId::Material(i) => (1, i as usize),
        PartId::Medium(i) => (2, i as usize),
        PartId::Group(i) => (3, i as usize),
        PartId::Image(i) => (4, i as usize),
        PartId::Mesh(i) => (5, i as usize),
    }
}

/// What an object refers to.
pub(super) fn of_object(object: &ObjectDesc) -> Vec<PartId> {
    let by = Renumber::recording();
    renumber_object(&mut object.clone(), &by);
    by.recorded()
}

/// What a light refers to.
pub(super) fn of_light(light: &SceneLight) -> Vec<PartId> {
    let by = Renumber::recording();
    light.value.clone().renumber(&by);
    by.recorded()
}

/// What a part refers to itself.
pub(super) fn of_part(desc: &SceneDesc, part: PartId) -> Vec<PartId> {
    let by = Renumber::recording();
    let (_, i) = slot(part);
    match part {
        PartId::Texture(_) => desc.textures.get(i).cloned().iter_mut().for_each(|t| t.value.renumber(&by)),
        PartId::Material(_) => desc.materials.get(i).cloned().iter_mut().for_each(|m| m.value.renumber(&by)),
        PartId::Medium(_) => desc.media.get(i).cloned().iter_mut().for_each(|m| m.value.renumber(&by)),
        PartId::Group(_) => desc.groups.get(i).cloned().iter_mut().for_each(|g| renumber_group(g, &by)),
        PartId::Image(_) | PartId::Mesh(_) => {}
    }
    by.recorded()
}

fn renumber_object(object: &mut ObjectDesc, by: &Renumber) {
    match &mut object.content {
        ObjectContent::Shape(shape) => shape.renumber(by),
        ObjectContent::Instance(group) => *group = by.group(*group),
    }
    object.material = object.material.map(|material| by.material(material));
}

fn renumber_group(group: &mut Named<GroupDesc>, by: &Renumber) {
    group.value.objects.iter_mut().for_each(|object| renumber_object(object, by));
    if let Some(model) = &mut group.value.model {
        model.renumber(by);
    }
}

/// Parts in the order in which they were first reached.
pub(super) struct Reached {
    /// By kind and number.
    seen: [Vec<bool>; 6],
    order: Vec<PartId>,
}

impl Reached {
    pub(super) fn none(desc: &SceneDesc) -> Reached {
        Reached { seen: counts(desc).map(|count| vec![false; count]), order: Vec::new() }
    }

    /// Everything that `start` refers to, directly or not.
    pub(super) fn follow(&mut self, desc: &SceneDesc, start: Vec<PartId>) {
        let mut stack = start;
        stack.reverse();
        while let Some(part) = stack.pop() {
            let (kind, number) = slot(part);
            let Some(seen) = self.seen[kind].get_mut(number).filter(|seen| !**seen) else { continue };
            *seen = true;
            self.order.push(part);
            let mut next = of_part(desc, part);
            next.reverse();
            stack.append(&mut next);
        }
    }
}

impl SceneDesc {
    /// Whether a position marks parts that a model brought with it: its groups, materials, textures, media, lights and
    /// cameras all have the position of the object that placed it first.
    pub fn model_spans(&self) -> impl Fn(Option<Span>) -> bool + use<> {
        let is_model = |group: &&Named<GroupDesc>| group.value.model.is_some();
        let mut spans: HashSet<Span> = self.groups.iter().filter(is_model).filter_map(|g| g.span).collect();
        let placed = self.objects.iter().filter(|object| match object.content {
            ObjectContent::Instance(id) => {
                self.groups.get(id.index()).is_some_and(|g| g.value.model.is_some())
            }
            ObjectContent::Shape(_) => false,
        });
        spans.extend(placed.filter_map(|object| object.span));
        move |span| span.is_some_and(|span| span.file == Span::NONE.file || spans.contains(&span))
    }

    /// All parts that are in use or have a table of their own.
    pub(super) fn reached(&self) -> Reached {
        let mut reached = Reached::none(self);
        let background = Renumber::recording();
        self.background.clone().renumber(&background);
        reached.follow(self, background.recorded());
        self.lights.iter().for_each(|light| reached.follow(self, of_light(light)));
        self.objects.iter().for_each(|object| reached.follow(self, of_object(object)));
        let is_of_model = self.model_spans();
        fn own<T>(list: &[Named<T>], is_of_model: &impl Fn(Option<Span>) -> bool) -> Vec<u32> {
            let is_own = |part: &Named<T>| part.name.is_some() && !is_of_model(part.span);
            (0..).zip(list).filter(|(_, part)| is_own(part)).map(|(i, _)| i).collect()
        }
        let mut parts: Vec<PartId> = Vec::new();
        parts.extend(own(&self.media, &is_of_model).into_iter().map(PartId::Medium));
        parts.extend(own(&self.textures, &is_of_model).into_iter().map(PartId::Texture));
        parts.extend(own(&self.materials, &is_of_model).into_iter().map(PartId::Material));
        parts.extend(own(&self.groups, &is_of_model).into_iter().map(PartId::Group));
        reached.follow(self, parts);
        reached
    }

    /// Removes parts that nothing uses and that have no table of their own: materials written in place, for example,
    /// whose object is gone, and everything of a model that is gone.
    pub(super) fn drop_unused(&mut self) {
        let reached = self.reached();
        self.keep_only(&reached);
    }

    /// Removes all parts that were not reached.
    pub(super) fn keep_only(&mut self, reached: &Reached) {
        let mut maps = counts(self).map(|count| vec![u32::MAX; count]);
        let mut next = [0; 6];
        for (kind, seen) in reached.seen.iter().enumerate() {
            for (number, _) in seen.iter().enumerate().filter(|(_, seen)| **seen) {
                maps[kind][number] = next[kind];
                next[kind] += 1;
            }
        }
        self.renumber_parts(maps);
    }

    /// The scene with its textures, materials, media, groups, images and meshes in the order of their first use, without
    /// those that nothing uses and that have no table of their own.
    pub(super) fn in_order_of_use(&self) -> SceneDesc {
        let reached = self.reached();
        let mut maps = counts(self).map(|count| vec![u32::MAX; count]);
        let mut next = [0; 6];
        for part in &reached.order {
            let (kind, number) = slot(*part);
            maps[kind][number] = next[kind];
            next[kind] += 1;
        }
        let mut desc = self.clone();
        desc.renumber_parts(maps);
        desc
    }

    /// Gives all parts new numbers; those whose new number is `u32::MAX` are removed.
    fn renumber_parts(&mut self, maps: [Vec<u32>; 6]) {
        fn sort<T>(list: &mut Vec<T>, map: &[u32]) {
            if map.iter().zip(0..).all(|(new, old)| *new == old) {
                return;
            }
            let mut items: Vec<(u32, T)> = map.iter().copied().zip(std::mem::take(list)).collect();
            items.retain(|(new, _)| *new != u32::MAX);
            items.sort_by_key(|(new, _)| *new);
            list.extend(items.into_iter().map(|(_, item)| item));
        }
        sort(&mut self.textures, &maps[0]);
        sort(&mut self.materials, &maps[1]);
        sort(&mut self.media, &maps[2]);
        sort(&mut self.groups, &maps[3]);
        sort(&mut self.images, &maps[4]);
        sort(&mut self.meshes, &maps[5]);
        let [textures, materials, media, groups, images, meshes] = maps;
        let maps = IdMaps { textures, materials, media, groups, images, meshes };
        self.renumber_as(&maps);
    }

    /// Replaces all IDs that parts refer to.
    pub(super) fn renumber_as(&mut self, maps: &IdMaps) {
        let by = Renumber { maps: Some(maps.clone()), ..Renumber::default() };
        self.background.renumber(&by);
        self.lights.iter_mut().for_each(|light| light.value.renumber(&by));
        self.textures.iter_mut().for_each(|texture| texture.value.renumber(&by));
        self.materials.iter_mut().for_each(|material| material.value.renumber(&by));
        self.media.iter_mut().for_each(|medium| medium.value.renumber(&by));
        self.groups.iter_mut().for_each(|group| renumber_group(group, &by));
        self.objects.iter_mut().for_each(|object| renumber_object(object, &by));
    }

    /// Removes one texture, material, medium or group. Nothing may refer to it.
    pub(super) fn remove_part(&mut self, part: PartId) {
        let (kind, number) = slot(part);
        let mut maps = counts(self).map(|count| (0..count as u32).collect::<Vec<u32>>());
        if let Some(removed) = maps[kind].get_mut(number) {
            *removed = u32::MAX;
            maps[kind][number + 1..].iter_mut().for_each(|new| *new -= 1);
        }
        self.renumber_parts(maps);
    }
}

impl SceneDesc {
    /// The object with copies of the materials, textures and media that were written in place of their use: these belong
    /// to one object.
    pub(super) fn with_own_parts(&mut self, mut object: ObjectDesc) -> ObjectDesc {
        let own = of_object(&object);
        if let Some(maps) = self.copies(&own) {
            renumber_object(&mut object, &Renumber { maps: Some(maps), ..Renumber::default() });
        }
        object
    }

    /// Copies the unnamed ones of these parts, with their own unnamed parts; `None` if there are none.
    fn copies(&mut self, parts: &[PartId]) -> Option<IdMaps> {
        let is_of_model = self.model_spans();
        let mut maps = IdMaps {
            textures: (0..self.textures.len() as u32).collect(),
            materials: (0..self.materials.len() as u32).collect(),
            media: (0..self.media.len() as u32).collect(),
            ..IdMaps::default()
        };
        let mut copied = false;
        macro_rules! copy {
            ($list:ident, $i:expr, $part:expr) => {
                if let Some(item) = self.$list.get($i as usize)
                    && item.name.is_none()
                    && !is_of_model(item.span)
                    && maps.$list[$i as usize] == $i
                {
                    let mut copy = Named { span: None, ..item.clone() };
                    let inner = of_part(self, $part);
                    if let Some(maps) = self.copies(&inner) {
                        copy.value.renumber(&Renumber { maps: Some(maps), ..Renumber::default() });
                    }
                    maps.$list[$i as usize] = self.$list.len() as u32;
                    self.$list.push(copy);
                    copied = true;
                }
            };
        }
        for part in parts {
            match *part {
                PartId::Texture(i) => copy!(textures, i, *part),
                PartId::Material(i) => copy!(materials, i, *part),
                PartId::Medium(i) => copy!(media, i, *part),
                PartId::Group(_) | PartId::Image(_) | PartId::Mesh(_) => {}
            }
        }
        copied.then_some(maps)
    }
}
