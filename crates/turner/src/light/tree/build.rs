//! Building the light tree: top down, by the binary split that promises the least noise; seven splits give
//! eight children.

use turner_bvh::lanes::Block32;

use super::node::{LEAF, Node, WIDTH};
use super::{BITS, LightTree};
use crate::light::LightBound;
use crate::math::{Bounds, DVec3};

/// Number of bins along the widest axis; splits lie between bins.
const BINS: usize = 12;

/// From this level on, splits are by count: no arrangement of lights makes a tree deeper than a path can store.
const LEVELS: u32 = 12;

/// Least power of a light, as a fraction of the largest: an estimate of 0 may be wrong, so no light gets probability
/// 0.
const LEAST_POWER: f64 = 1e-9;

/// How much spheres grow in tree space, where the scene's radius is 1: more than rounding to single precision moves
/// points.
const GROWTH: f32 = 1e-6;

/// One light or several, in tree space.
#[derive(Clone, Copy)]
struct Item {
    center: [f32; 3],
    radius: f32,
    axis: [f32; 3],
    cos_o: f32,
    cos_e: f32,
    power: f32,
    two_sided: bool,
    light: u32,
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sine(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

/// The cosine of min(π, α + β).
fn cos_sum(cos_a: f32, cos_b: f32) -> f32 {
    if cos_a <= -cos_b { -1.0 } else { (cos_a * cos_b - sine(cos_a) * sine(cos_b)).max(-1.0) }
}

/// A box around spheres.
#[derive(Clone, Copy)]
struct SphereBounds {
    min: [f32; 3],
    max: [f32; 3],
}

impl SphereBounds {
    const NOTHING: SphereBounds = SphereBounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn add(&mut self, center: [f32; 3], radius: f32) {
        for (k, at) in center.into_iter().enumerate() {
            self.min[k] = self.min[k].min(at - radius);
            self.max[k] = self.max[k].max(at + radius);
        }
    }

    fn join(&mut self, other: &SphereBounds) {
        for k in 0..3 {
            self.min[k] = self.min[k].min(other.min[k]);
            self.max[k] = self.max[k].max(other.max[k]);
        }
    }

    fn size(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| (self.max[k] - self.min[k]).max(0.0))
    }

    fn diagonal2(&self) -> f32 {
        let size = self.size();
        dot(size, size)
    }
}

/// The sums over the lights on one side of a split.
#[derive(Clone, Copy)]
struct Side {
    count: u32,
    power: f32,
    axis: [f32; 3],
    bounds: SphereBounds,
}

impl Side {
    const NONE: Side = Side { count: 0, power: 0.0, axis: [0.0; 3], bounds: SphereBounds::NOTHING };

    fn add(&mut self, item: &Item) {
        self.count += 1;
        self.power += item.power;
        // Lights that emit in all directions have no axis; the axes of two-sided lights are flipped into one
        // half-space.
        if item.cos_o > -1.0 {
            let lead = item.axis.iter().find(|v| v.abs() > 0.5).copied().unwrap_or(1.0);
            let sign = if item.two_sided && lead < 0.0 { -item.power } else { item.power };
            for k in 0..3 {
                self.axis[k] += sign * item.axis[k];
            }
        }
        self.bounds.add(item.center, item.radius);
    }

    fn join(&mut self, other: &Side) {
        self.count += other.count;
        self.power += other.power;
        for k in 0..3 {
            self.axis[k] += other.axis[k];
        }
        self.bounds.join(&other.bounds);
    }

    /// The expected noise of the side: power × extent in space × extent in direction. Instead of the cone measure of
    /// Conty Estevez and Kulla, the extent in direction is how far the length of the mean axis is from 1.
    fn cost(&self) -> f32 {
        let aligned = dot(self.axis, self.axis).sqrt() / self.power;
        self.power * self.bounds.diagonal2() * (1.0 + 2.0 * (1.0 - aligned.min(1.0)))
    }
}

fn side_of(items: &[Item]) -> Side {
    let mut side = Side::NONE;
    items.iter().for_each(|item| side.add(item));
    side
}

/// The bounds of several lights together.
fn bound(items: &[Item]) -> Item {
    let [first, rest @ ..] = items else {
        return Item {
            center: [0.0; 3],
            radius: 0.0,
            axis: [0.0; 3],
            cos_o: 1.0,
            cos_e: 1.0,
            power: 0.0,
            two_sided: false,
            light: 0,
        };
    };
    if rest.is_empty() {
        return *first;
    }
    let mut bounds = SphereBounds::NOTHING;
    let (mut axis, mut power) = ([0.0f64; 3], 0.0f64);
    let two_sided = items.iter().any(|item| item.two_sided);
    for item in items {
        bounds.add(item.center, item.radius);
        power += f64::from(item.power);
        // Of two sides, the one that is nearer to the axis of the others.
        let along: f64 = (0..3).map(|k| axis[k] * f64::from(item.axis[k])).sum();
        let sign = if two_sided && along < 0.0 { -1.0 } else { 1.0 };
        for (sum, along) in axis.iter_mut().zip(item.axis) {
            *sum += sign * f64::from(item.power) * f64::from(along);
        }
    }
    let center = [0, 1, 2].map(|k| 0.5 * bounds.min[k] + 0.5 * bounds.max[k]);
    let distance = |item: &Item| {
        let d = [0, 1, 2].map(|k| item.center[k] - center[k]);
        dot(d, d).sqrt() + item.radius
    };
    let radius = items.iter().map(distance).fold(0.0, f32::max) * (1.0 + GROWTH) + GROWTH;
    let mean = DVec3::from(axis).try_normalize();
    let (axis, cos_o) = match mean {
        Some(mean) => {
            let axis = mean.as_vec3().to_array();
            let cos_o = items.iter().map(|item| {
                let cos = dot(axis, item.axis);
                let cos = if two_sided { cos.abs() } else { cos };
                // The margin of 1e-5 covers rounding.
                cos_sum((cos - 1e-5).clamp(-1.0, 1.0), item.cos_o)
            });
            (axis, cos_o.fold(1.0, f32::min))
        }
        None => ([0.0, 1.0, 0.0], -1.0),
    };
    let cos_e = items.iter().map(|item| item.cos_e).fold(1.0, f32::min);
    Item { center, radius, axis, cos_o, cos_e, power: power as f32, two_sided, light: 0 }
}

/// Splits items in two non-empty parts and returns the length of the first. Splits by count alone if `evenly`.
fn split(items: &mut [Item], evenly: bool) -> usize {
    let half = items.len() / 2;
    let mut centers = SphereBounds::NOTHING;
    items.iter().for_each(|item| centers.add(item.center, 0.0));
    let size = centers.size();
    // Trying all three axes gave no better trees and took longer.
    let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
    let bin = |item: &Item| {
        (((item.center[axis] - centers.min[axis]) / size[axis] * BINS as f32) as usize).min(BINS - 1)
    };
    if !evenly && size[axis] > 0.0 {
        let mut bins = [Side::NONE; BINS];
        items.iter().for_each(|item| bins[bin(item)].add(item));
        let mut above = [Side::NONE; BINS];
        let mut sum = Side::NONE;
        for k in (1..BINS).rev() {
            sum.join(&bins[k]);
            above[k] = sum;
        }
        let mut below = Side::NONE;
        let mut best: Option<(f32, usize)> = None;
        for k in 1..BINS {
            below.join(&bins[k - 1]);
            if below.count == 0 || above[k].count == 0 {
                continue;
            }
            let cost = below.cost() + above[k].cost();
            if cost.is_finite() && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, k));
            }
        }
        if let Some((_, k)) = best {
            let mut first = 0;
            for i in 0..items.len() {
                if bin(&items[i]) < k {
                    items.swap(first, i);
                    first += 1;
                }
            }
            if first > 0 && first < items.len() {
                return first;
            }
        }
    }
    items.select_nth_unstable_by(half, |a, b| {
        a.center[axis].total_cmp(&b.center[axis]).then(a.light.cmp(&b.light))
    });
    half
}

/// Splits items in up to eight parts; returns the boundaries of the parts.
fn split_in_eight(items: &mut [Item], evenly: bool) -> [usize; WIDTH + 1] {
    if items.len() <= WIDTH {
        return std::array::from_fn(|i| i.min(items.len()));
    }
    // Boundaries of the parts, and the gain from splitting each.
    let mut ends = vec![0, items.len()];
    let gain = |items: &[Item]| match items.len() {
        0 | 1 => -1.0,
        n if evenly => n as f32,
        _ => side_of(items).cost().clamp(0.0, f32::MAX),
    };
    let mut gains = vec![gain(items)];
    while ends.len() <= WIDTH {
        let widest = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]).then(b.cmp(a)));
        let Some(k) = widest.filter(|k| gains[*k] >= 0.0) else { break };
        let boundary = ends[k] + split(&mut items[ends[k]..ends[k + 1]], evenly);
        ends.insert(k + 1, boundary);
        gains[k] = gain(&items[ends[k]..boundary]);
        gains.insert(k + 1, gain(&items[boundary..ends[k + 2]]));
    }
    let mut out = [items.len(); WIDTH + 1];
    out[..ends.len()].copy_from_slice(&ends);
    out
}

impl LightTree {
    /// Builds the tree over lights 0 to `count` − 1, whose bounds are evaluated twice. `None` if there are no lights,
    /// more than [`LightTree::MOST`], or not enough memory.
    ///
    /// Lights with non-finite bounds count as being anywhere; a non-finite power counts as nearly 0.
    pub fn new(count: u32, bounds: impl Fn(u32) -> LightBound) -> Option<LightTree> {
        if count == 0 || count > LightTree::MOST {
            return None;
        }
        let valid = |b: &LightBound| b.center.is_finite() && b.radius.is_finite() && b.radius >= 0.0;
        let (mut extent, mut most) = (Bounds::EMPTY, 0.0f64);
        for b in (0..count).map(&bounds) {
            if valid(&b) {
                let reach = DVec3::splat(b.radius);
                extent = extent.union(&Bounds::new(b.center - reach, b.center + reach));
            }
            most = if b.power.is_finite() { most.max(b.power) } else { most };
        }
        let origin = if extent.is_empty() { DVec3::ZERO } else { extent.center() };
        let size = if extent.is_empty() { 0.0 } else { 0.5 * extent.size().length() };
        let scale = 1.0 / size;
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        let item = |light: u32| {
            let b = bounds(light);
            let power = if most > 0.0 && b.power > 0.0 && b.power.is_finite() { b.power / most } else { 0.0 };
            let power = power.max(LEAST_POWER) as f32;
            let local = ((b.center - origin) * scale).as_vec3();
            let radius = (b.radius * scale) as f32 * (1.0 + GROWTH) + GROWTH;
            let axis = b.axis.as_vec3();
            if !valid(&b) || !local.is_finite() || !radius.is_finite() {
                let anywhere = LightBound::everywhere(DVec3::ZERO, 4.0, 0.0);
                return Item { light, power, ..Item::of(&anywhere, [0.0; 3], 4.0) };
            }
            let everywhere = LightBound { cos_o: -1.0, ..b };
            let b =
                if axis.is_finite() && b.cos_o.is_finite() && b.cos_e.is_finite() { &b } else { &everywhere };
            Item { light, power, ..Item::of(b, local.to_array(), radius) }
        };
        let mut items = Vec::new();
        items.try_reserve_exact(count as usize).ok()?;
        items.extend((0..count).map(item));
        let mut paths = Vec::new();
        paths.try_reserve_exact(count as usize).ok()?;
        paths.resize(count as usize, 0);
        let mut tree = LightTree { nodes: Vec::new(), paths, origin, scale };
        tree.add(&mut items, 0, 0)?;
        tree.nodes.shrink_to_fit();
        Some(tree)
    }

    /// Adds a node over lights, and the nodes below it; `path` leads to it. Recursion is bounded: see [`LEVELS`].
    fn add(&mut self, items: &mut [Item], level: u32, path: u64) -> Option<u32> {
        let at = self.nodes.len();
        self.nodes.try_reserve(1).ok()?;
        self.nodes.push(Node { back: Block32([1.0; WIDTH]), ..Node::default() });
        let ends = split_in_eight(items, level >= LEVELS);
        for lane in 0..WIDTH {
            let part = &mut items[ends[lane]..ends[lane + 1]];
            let path = path | (lane as u64) << (BITS * level);
            let bound = bound(part);
            let child = match part {
                [] => LEAF,
                [item] => {
                    self.paths[item.light as usize] = path;
                    item.light | LEAF
                }
                part => self.add(part, level + 1, path)?,
            };
            let node = &mut self.nodes[at];
            for k in 0..3 {
                node.center[k].0[lane] = bound.center[k];
                node.axis[k].0[lane] = bound.axis[k];
            }
            (node.radius.0[lane], node.power.0[lane]) = (bound.radius, bound.power);
            (node.cos_o.0[lane], node.cos_e.0[lane]) = (bound.cos_o, bound.cos_e);
            node.back.0[lane] = if bound.two_sided { -1.0 } else { 1.0 };
            node.child[lane] = child;
        }
        Some(at as u32)
    }
}

impl Item {
    fn of(b: &LightBound, center: [f32; 3], radius: f32) -> Item {
        Item {
            center,
            radius,
            axis: b.axis.as_vec3().to_array(),
            cos_o: b.cos_o as f32,
            cos_e: b.cos_e as f32,
            power: 0.0,
            two_sided: b.two_sided,
            light: 0,
        }
    }
}
