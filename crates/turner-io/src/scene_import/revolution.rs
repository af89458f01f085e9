//! Spheres, disks and cylinders about the z axis as triangle meshes.

use turner::math::elementary::sin_cos;
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::MeshData;

/// Quads around the axis, and along the profile.
pub(crate) const AROUND: u32 = 72;
pub(crate) const ALONG: u32 = 36;

/// Maps the space of Turner's shapes (axis y, u = 0 at −z) to that of pbrt's and Mitsuba's (axis z, u = 0 at +x).
pub(crate) fn upright() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X))
}

/// Surfaces of revolution about z.
#[derive(Debug)]
pub(crate) enum Surface {
    /// Polar angles at v = 0 and 1, radians.
    Sphere {
        radius: f64,
        from: f64,
        to: f64,
    },
    Disk {
        radius: f64,
        inner: f64,
        height: f64,
    },
    Cylinder {
        radius: f64,
        from: f64,
        to: f64,
    },
    /// From the base at z = 0 to the tip.
    Cone {
        radius: f64,
        height: f64,
    },
    /// z = z_max · (r / radius)².
    Paraboloid {
        radius: f64,
        from: f64,
        to: f64,
    },
    /// A line from one point to the other, rotated.
    Hyperboloid {
        from: DVec3,
        to: DVec3,
    },
}

impl Surface {
    /// Position and normal at (sine, cosine) of the azimuth and at v.
    fn at(&self, (sin, cos): (f64, f64), v: f64) -> (DVec3, DVec3) {
        match *self {
            Surface::Sphere { radius, from, to } => {
                let (s, c) = sin_cos(from + (to - from) * v);
                let n = DVec3::new(s * cos, s * sin, c);
                (n * radius, n)
            }
            Surface::Disk { radius, inner, height } => {
                let r = radius + (inner - radius) * v;
                (DVec3::new(r * cos, r * sin, height), DVec3::Z)
            }
            Surface::Cylinder { radius, from, to } => {
                let n = DVec3::new(cos, sin, 0.0);
                (n * radius + DVec3::Z * (from + (to - from) * v), n)
            }
            Surface::Cone { radius, height } => {
                let r = radius * (1.0 - v);
                let n = DVec3::new(height * cos, height * sin, radius);
                (DVec3::new(r * cos, r * sin, height * v), n.normalize_or(DVec3::Z))
            }
            Surface::Paraboloid { radius, from, to } => {
                let z = from + (to - from) * v;
                let r = radius * (z / to).max(0.0).sqrt();
                // The gradient of r² / radius² − z / to.
                let (across, along) = (2.0 * r / (radius * radius), -1.0 / to);
                let n = DVec3::new(across * cos, across * sin, along);
                (DVec3::new(r * cos, r * sin, z), n.normalize_or(DVec3::NEG_Z))
            }
            Surface::Hyperboloid { from, to } => {
                let turned = |p: DVec3| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
                let (p, d) = (turned(from + (to - from) * v), turned(to - from));
                let around = DVec3::new(-p.y, p.x, 0.0);
                (p, around.cross(d).normalize_or(DVec3::Z))
            }
        }
    }

    /// The surface over azimuths from 0 to `phi` radians, with normals and (u, v).
    pub(crate) fn cut(&self, phi: f64) -> MeshData {
        let mut data = MeshData::default();
        let single = |v: DVec3| v.as_vec3().to_array();
        for j in 0..=ALONG {
            for i in 0..=AROUND {
                let (u, v) = (f64::from(i) / f64::from(AROUND), f64::from(j) / f64::from(ALONG));
                let (p, n) = self.at(sin_cos(phi * u), v);
                data.positions.push(single(p));
                data.normals.push(single(n));
                data.uvs.push([u as f32, v as f32]);
            }
        }
        for j in 0..ALONG {
            for i in 0..AROUND {
                let a = j * (AROUND + 1) + i;
                let (b, c, d) = (a + 1, a + AROUND + 1, a + AROUND + 2);
                // At a pole a row is one point.
                let at = |i: u32| data.positions[i as usize];
                let whole =
                    |t: &[u32; 3]| at(t[0]) != at(t[1]) && at(t[1]) != at(t[2]) && at(t[2]) != at(t[0]);
                let triangles = [[a, b, d], [a, d, c]].into_iter().filter(whole).collect::<Vec<_>>();
                data.triangles.extend(triangles);
            }
        }
        data
    }
}
