//! Lights that move while the shutter is open.
//!
//! A light that moves is the light as described, in a space that moves: what reaches a point at a time is what the light
//! sends to the point where it was in that space.

use super::{Light, LightBound, LightDesc};
use crate::animation::motion::Displacement;
use crate::math::{Bounds, DAffine3, DMat3, DVec3};
use crate::schema::Transform;

/// The least rotation from one direction to another.
fn turn(from: DVec3, to: DVec3) -> Option<DMat3> {
    Some(DMat3::from_quat(glam::DQuat::from_rotation_arc(from.try_normalize()?, to.try_normalize()?)))
}

/// What moves a point to another, and turns one direction to another about it.
fn moved([from, to]: [DVec3; 2], [axis, axis_to]: [DVec3; 2]) -> Option<DAffine3> {
    let matrix3 = turn(axis, axis_to)?;
    Some(DAffine3 { matrix3, translation: to - matrix3 * from })
}

impl LightDesc {
    /// What moves it to where `later` is; `None` if it stays, or is of another type or everywhere.
    pub(crate) fn motion_to(&self, later: &LightDesc) -> Option<Transform> {
        let same = [DVec3::Y; 2];
        let moved = match (self, later) {
            (LightDesc::Point(a), LightDesc::Point(b)) => moved([a.position, b.position], same)?,
            (LightDesc::Sphere(a), LightDesc::Sphere(b)) => moved([a.center, b.center], same)?,
            (LightDesc::Disk(a), LightDesc::Disk(b)) => moved([a.center, b.center], [a.normal, b.normal])?,
            (LightDesc::Spot(a), LightDesc::Spot(b)) => {
                let axes = [a.look_at - a.position, b.look_at - b.position];
                moved([a.position, b.position], axes)?
            }
            (LightDesc::Rectangle(a), LightDesc::Rectangle(b)) => {
                let [from, to] = [a, b].map(|own| DAffine3 {
                    matrix3: DMat3::from_cols(own.edge_u, own.edge_v, own.edge_u.cross(own.edge_v)),
                    translation: own.center,
                });
                to * from.inverse()
            }
            (LightDesc::Directional(a), LightDesc::Directional(b)) => {
                let [from, to] = [a, b].map(|own| own.from.or(own.direction.map(|d| -d)));
                moved([DVec3::ZERO; 2], [from?, to?])?
            }
            _ => return None,
        };
        (moved != DAffine3::IDENTITY && moved.is_finite()).then_some(Transform(moved))
    }
}

impl Light {
    /// A bound that holds from one time to another for a light moved by `motion`.
    pub(crate) fn moved_bound(&self, motion: &Displacement, [open, close]: [f64; 2]) -> Option<LightBound> {
        let own = self.bound()?;
        let reach = DVec3::splat(own.radius);
        let still = Bounds::new(own.center - reach, own.center + reach);
        let swept = motion.bounds(&still, open, close);
        Some(LightBound::everywhere(swept.center(), 0.5 * swept.size().length(), own.power))
    }
}
