//! Differences in a bounded range: entry = prediction + difference, modulo the range.

use super::super::reader::Reader;
use super::super::{Read, damaged};

/// Integers from `min` to `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrap {
    min: i32,
    max: i32,
}

impl Wrap {
    pub(super) fn read(reader: &mut Reader<'_>) -> Read<Wrap> {
        let (min, max) = (reader.i32()?, reader.i32()?);
        if min > max || max.checked_sub(min).is_none_or(|range| range == i32::MAX) {
            return damaged(&format!("has integers from {min} to {max}; expected fewer than 2^31"));
        }
        Ok(Wrap { min, max })
    }

    /// Turns a difference into the entry.
    #[inline]
    pub(super) fn restore(self, predicted: &[i32], entry: &mut [i32]) {
        let range = self.max.wrapping_sub(self.min).wrapping_add(1);
        for (value, predicted) in entry.iter_mut().zip(predicted) {
            let sum = (*predicted).clamp(self.min, self.max).wrapping_add(*value);
            *value = if sum > self.max {
                sum.wrapping_sub(range)
            } else if sum < self.min {
                sum.wrapping_add(range)
            } else {
                sum
            };
        }
    }
}

/// Octahedral coordinates from 0 to 2 `center`. The octahedron is unfolded to a square: the diamond in its middle has
/// x ≥ 0, its corners x < 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octahedron {
    center: i32,
}

impl Octahedron {
    pub(super) fn read(reader: &mut Reader<'_>) -> Read<Octahedron> {
        // The centre follows from the maximum.
        let (max, _) = (reader.i32()?, reader.i32()?);
        let bits = 32 - max.leading_zeros();
        if max % 2 == 0 || !(2..=30).contains(&bits) {
            return damaged(&format!("has octahedral coordinates up to {max}; expected 2^n - 1 below 2^30"));
        }
        Ok(Octahedron { center: (1 << (bits - 1)) - 1 })
    }

    /// The coordinates of a direction, or of the opposite one. Points at the edges of the square that are the same
    /// direction become one.
    pub(super) fn project(self, direction: [i32; 3], is_flipped: bool) -> [i32; 2] {
        let (center, max) = (self.center, 2 * self.center);
        let sum = direction.iter().map(|v| i64::from(*v).abs()).sum::<i64>();
        let mut scaled = match sum {
            0 => [center, 0, 0],
            _ => direction.map(|v| (i64::from(v) * i64::from(center) / sum) as i32),
        };
        let height = center - scaled[0].abs() - scaled[1].abs();
        scaled[2] = if direction[2] >= 0 { height } else { -height };
        let [s, t] = self.unfold(if is_flipped { scaled.map(|v| -v) } else { scaled });
        // The corners are one point, and the halves of each edge are glued to one another.
        match (s, t) {
            (0, 0) => [max, max],
            (0, t) if t == max => [max, max],
            (s, 0) if s == max => [max, max],
            (0, t) if t > center => [0, max - t],
            (s, t) if s == max && t < center => [s, max - t],
            (s, t) if t == max && s < center => [max - s, t],
            (s, 0) if s > center => [max - s, 0],
            _ => [s, t],
        }
    }

    fn unfold(self, [x, y, z]: [i32; 3]) -> [i32; 2] {
        if x >= 0 {
            return [y + self.center, z + self.center];
        }
        let side = |v: i32, other: i32| if v < 0 { other.abs() } else { 2 * self.center - other.abs() };
        [side(y, z), side(z, y)]
    }

    /// Swaps the diamond and the corners of the square, mirrored at the edges of the diamond. Coordinates are from
    /// −`center` to `center`.
    fn invert(self, [s, t]: [i32; 2]) -> [i32; 2] {
        let (sign_s, sign_t) = match (s, t) {
            (0.., 0..) => (1, 1),
            (s, t) if s <= 0 && t <= 0 => (-1, -1),
            _ => (if s > 0 { 1 } else { -1 }, if t > 0 { 1 } else { -1 }),
        };
        let (corner_s, corner_t) = (sign_s * self.center, sign_t * self.center);
        let s = s.wrapping_mul(2).wrapping_sub(corner_s);
        let t = t.wrapping_mul(2).wrapping_sub(corner_t);
        let (s, t) = if sign_s == sign_t { (t.wrapping_neg(), s.wrapping_neg()) } else { (t, s) };
        [s.wrapping_add(corner_s) / 2, t.wrapping_add(corner_t) / 2]
    }

    fn in_range(self, v: i32) -> i32 {
        let all = 2 * self.center + 1;
        if v > self.center {
            v.wrapping_sub(all)
        } else if v < -self.center {
            v.wrapping_add(all)
        } else {
            v
        }
    }

    /// The entry from its prediction and a difference, which is stored as if the prediction lay in the diamond's
    /// lower left quarter.
    #[inline]
    pub(super) fn restore(self, predicted: [i32; 2], difference: [i32; 2]) -> [i32; 2] {
        let mut at = predicted.map(|v| v.wrapping_sub(self.center));
        let [s, t] = at.map(i32::unsigned_abs);
        let is_inside = s.wrapping_add(t) <= self.center as u32;
        if !is_inside {
            at = self.invert(at);
        }
        let turns = quarter_turns(at);
        at = turn(at, turns);
        at = [0, 1].map(|k| self.in_range(at[k].wrapping_add(difference[k])));
        at = turn(at, (4 - turns) % 4);
        if !is_inside {
            at = self.invert(at);
        }
        at.map(|v| v.wrapping_add(self.center))
    }
}

/// How many quarter turns bring a point to the lower left.
fn quarter_turns([s, t]: [i32; 2]) -> u32 {
    match (s.signum(), t.signum()) {
        (0, 0) | (-1, ..=0) => 0,
        (0.., -1) => 1,
        (1, _) => 2,
        _ => 3,
    }
}

fn turn([s, t]: [i32; 2], quarters: u32) -> [i32; 2] {
    match quarters {
        1 => [t, s.wrapping_neg()],
        2 => [s.wrapping_neg(), t.wrapping_neg()],
        3 => [t.wrapping_neg(), s],
        _ => [s, t],
    }
}
