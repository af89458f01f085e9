//! Emissive shapes, their triangles and points as leaves of a light tree.

use super::{Form, ShapeEmitter, triangle};
use crate::light::LightBound;
use crate::sampler::AliasTable;
use crate::scene::emitters::NONE;
use crate::scene::similarity::similarity;
use crate::scene::{Scene, SurfaceInteraction};
use crate::shape::{Shape, ShapeHit, Sphere};

impl ShapeEmitter {
    /// Whether it has parts that are chosen separately: triangles or points.
    pub(crate) fn has_parts(&self) -> bool {
        matches!(self.form, Form::Mesh { .. } | Form::Points { .. })
    }

    /// The number of parts; 1 for other shapes.
    pub(crate) fn parts(&self) -> u32 {
        match &self.form {
            Form::Mesh { choice, .. } | Form::Points { choice, .. } => choice.len() as u32,
            _ => 1,
        }
    }

    /// The index of the triangle or point at a position among the emissive ones.
    pub(crate) fn part_at(&self, position: u32) -> u32 {
        match &self.form {
            Form::Mesh { triangles, .. } => triangles.get(position as usize).copied().unwrap_or(NONE),
            _ => position,
        }
    }

    /// The position of the part that was hit; [`NONE`] if the part is not emissive.
    #[inline]
    pub(crate) fn position(&self, surface: &SurfaceInteraction) -> u32 {
        let part = surface.hit.shape.part;
        match &self.form {
            Form::Mesh { position, .. } if !position.is_empty() => {
                position.get(part as usize).copied().unwrap_or(NONE)
            }
            Form::Mesh { .. } | Form::Points { .. } => part,
            _ => 0,
        }
    }

    /// Frees the table of parts, once the light tree chooses among them.
    pub(crate) fn drop_part_table(&mut self) {
        if let Form::Mesh { choice, .. } | Form::Points { choice, .. } = &mut self.form {
            *choice = AliasTable::default();
        }
    }

    /// The bounds of the part at `position`, or of the complete shape if `part` is [`NONE`]. `power` is area times
    /// radiance, both sides summed.
    pub(crate) fn bound(&self, scene: &Scene, power: f64, part: u32, position: u32) -> Option<LightBound> {
        let primitive = scene.primitives.get(self.primitive as usize)?;
        let hit = ShapeHit { t: 0.0, part: if part == NONE { self.part } else { part }, u: 0.3, v: 0.3 };
        let material = scene.materials.get(scene.material_of(primitive, &hit).index());
        let both = material.is_none_or(|m| m.may_emit_backwards());
        let flat = if both { 0.5 * power } else { power };
        // A quarter of the area is the projected area, averaged over all directions.
        let round = 0.25 * flat;
        match &self.form {
            Form::Rectangle(f) => Some(f.bound(both, flat)),
            Form::Disk(f) => Some(f.bound(both, flat)),
            Form::Sphere(f) => Some(LightBound::everywhere(f.center, f.radius, round)),
            Form::Mesh { choice, .. } if part != NONE => {
                let Shape::Mesh(mesh) = &primitive.shape else { return None };
                let form = triangle(scene, self.primitive, mesh, part)?;
                Some(form.bound(both, flat * choice.probability(position)))
            }
            Form::Points { choice, .. } if part != NONE => {
                let Shape::Points(points) = &primitive.shape else { return None };
                let Sphere { center, radius } = points.sphere(part);
                let to_world = scene.to_world(primitive);
                let m = to_world.matrix3;
                // An upper bound of the scale factor.
                let growth = similarity(&to_world).unwrap_or_else(|| {
                    let squares = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length_squared());
                    squares.iter().sum::<f64>().sqrt()
                });
                let center = to_world.transform_point3(center);
                Some(LightBound::everywhere(center, radius * growth, round * choice.probability(position)))
            }
            _ => {
                let bounds = primitive.shape.bounds()?.transformed(&scene.to_world(primitive));
                Some(LightBound::everywhere(bounds.center(), 0.5 * bounds.size().length(), round))
            }
        }
    }
}
