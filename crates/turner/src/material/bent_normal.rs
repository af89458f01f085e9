//! Correction of shading normals whose mirror direction is below the surface.

use crate::math::{DVec3, Frame, reflect};

/// Least height of the mirror direction above the surface, at most 0.9 times that of `wo`.
pub(crate) const HEIGHT: f64 = 0.01;

/// The frame rotated to another normal.
pub(crate) fn with_normal(frame: &Frame, n: DVec3) -> Frame {
    match (frame.x - n * n.dot(frame.x)).try_normalize() {
        Some(x) => Frame { x, y: n.cross(x), z: n },
        None => Frame::from_z(n),
    }
}

/// A shading normal bent until the mirror direction of `wo` is above the surface (Keller et al. 2017, "The Iray light
/// transport simulation and rendering system", A.3). Normal maps and smooth normals would otherwise show black specks
/// where it is below.
pub(crate) fn bent_normal(wo: DVec3, ns: DVec3, ng: DVec3) -> DVec3 {
    let mirrored = -reflect(wo, ns);
    let least = HEIGHT.min(0.9 * wo.dot(ng));
    let height = mirrored.dot(ng);
    if height >= least && wo.dot(ns) > 0.0 {
        return ns;
    }
    let flat = mirrored - height * ng;
    let lifted = flat.normalize_or_zero() * (1.0 - least * least).max(0.0).sqrt() + least * ng;
    let bent = (wo + lifted).normalize_or_zero();
    if bent.dot(wo) > 0.0 && bent.dot(ng) > 0.0 { bent } else { ng }
}
