//! Packets of 16 coherent rays.

use std::ops::Range;

use turner_bvh::Ray;

use crate::ffi::{self, RtcArguments, RtcHit16, RtcRay16, RtcRayHit16};
use crate::{Hit, Scene};

/// Rays in the layout of `rtcIntersect16`, prepared in advance so that the conversion does not count as tracing.
#[derive(Clone, Debug)]
pub struct Packets {
    packets: Vec<RtcRay16>,
}

impl Packets {
    /// Rays per packet.
    pub const WIDTH: usize = 16;

    /// Lays out rays. Unused lanes of the last packet hold rays with an empty interval.
    pub fn new(rays: &[Ray]) -> Packets {
        let packets = rays.chunks(Packets::WIDTH).map(|rays| {
            let mut packet = EMPTY;
            for (i, ray) in rays.iter().enumerate() {
                for axis in 0..3 {
                    packet.origin[axis][i] = ray.origin[axis];
                    packet.direction[axis][i] = ray.direction[axis];
                }
                (packet.t_near[i], packet.t_far[i]) = (ray.t_min, ray.t_max);
            }
            packet
        });
        Packets { packets: packets.collect() }
    }

    /// Number of packets.
    pub fn len(&self) -> usize {
        self.packets.len()
    }

    /// Whether there are no packets.
    pub fn is_empty(&self) -> bool {
        self.packets.is_empty()
    }
}

/// All lanes are active: Embree ignores rays with an empty interval.
static ACTIVE: Active = Active([-1; 16]);

/// Embree reads it by aligned loads of 64 bytes.
#[repr(C, align(64))]
struct Active([i32; 16]);

const EMPTY: RtcRay16 = RtcRay16 {
    origin: [[0.0; 16]; 3],
    t_near: [0.0; 16],
    direction: [[0.0; 16], [0.0; 16], [1.0; 16]],
    time: [0.0; 16],
    t_far: [-1.0; 16],
    mask: [u32::MAX; 16],
    id: [0; 16],
    flags: [0; 16],
};

const NO_HITS: RtcHit16 = RtcHit16 {
    normal: [[0.0; 16]; 3],
    u: [0.0; 16],
    v: [0.0; 16],
    primitive: [ffi::INVALID; 16],
    geometry: [ffi::INVALID; 16],
    instance: [ffi::INVALID; 16],
    instance_primitive: [ffi::INVALID; 16],
};

impl Scene {
    /// The nearest hits of a range of packets: `rtcIntersect16` with the coherent flag. Hits beyond the end of `hits`
    /// are dropped.
    pub fn intersect_packets(&self, packets: &Packets, range: Range<usize>, hits: &mut [Hit]) {
        let mut arguments = RtcArguments::COHERENT;
        for (packet, out) in packets.packets[range].iter().zip(hits.chunks_mut(Packets::WIDTH)) {
            let mut query = RtcRayHit16 { ray: *packet, hit: NO_HITS };
            // SAFETY: the scene is committed; sizes and alignments are those of the header; the 16 flags are aligned.
            unsafe {
                (self.device.functions.intersect_16)(
                    ACTIVE.0.as_ptr(),
                    self.object,
                    &mut query,
                    &mut arguments,
                );
            }
            let RtcRayHit16 { ray, hit } = &query;
            for (i, out) in out.iter_mut().enumerate() {
                let is_hit = hit.geometry[i] != ffi::INVALID;
                *out = Hit {
                    t: if is_hit { ray.t_far[i] } else { f32::INFINITY },
                    u: hit.u[i],
                    v: hit.v[i],
                    primitive: hit.primitive[i],
                    instance: hit.instance[i],
                };
            }
        }
    }

    /// Whether each ray of a range of packets hits anything: `rtcOccluded16` with the coherent flag.
    pub fn occluded_packets(&self, packets: &Packets, range: Range<usize>, occluded: &mut [bool]) {
        let mut arguments = RtcArguments::COHERENT;
        for (packet, out) in packets.packets[range].iter().zip(occluded.chunks_mut(Packets::WIDTH)) {
            let mut query = *packet;
            // SAFETY: as in `intersect_packets`.
            unsafe {
                (self.device.functions.occluded_16)(
                    ACTIVE.0.as_ptr(),
                    self.object,
                    &mut query,
                    &mut arguments,
                );
            }
            for (out, &t) in out.iter_mut().zip(&query.t_far) {
                *out = t == f32::NEG_INFINITY;
            }
        }
    }
}
