//! Orthonormal frames.

use super::DVec3;

/// A right-handed orthonormal basis: x × y = z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// The normal.
    pub z: DVec3,
}

impl Frame {
    /// A frame around the unit vector `z`. The tangents are arbitrary, but continuous except at z = (0, 0, −1) (Duff
    /// et al. 2017, "Building an orthonormal basis, revisited").
    pub fn from_z(z: DVec3) -> Frame {
        let sign = 1.0_f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Frame {
            x: DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: DVec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// From local coordinates to the space of the axes.
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        v.x * self.x + v.y * self.y + v.z * self.z
    }

    /// From the space of the axes to local coordinates.
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for z in
            [DVec3::X, DVec3::NEG_Z, DVec3::Z, DVec3::new(0.6, -0.48, -0.64), DVec3::new(0.0, 1.0, -1e-9)]
        {
            let f = Frame::from_z(z.normalize());
            assert!(f.x.dot(f.y).abs() < 1e-12 && f.x.dot(f.z).abs() < 1e-12);
            assert!((f.x.cross(f.y) - f.z).length() < 1e-12);
            let v = DVec3::new(0.3, -2.0, 5.0);
            assert!((f.to_world(f.to_local(v)) - v).length() < 1e-12);
        }
    }
}
