//! Front-to-back order of a node's children, precomputed for the eight octants of ray directions.
//!
//! A child's key is the minimum of `±x ± y ± z` over its box, with the signs of the octant: where a ray along the
//! octant's diagonal enters the box. A sorting network sorts for all octants at once, four per register.
//!
//! ```text
//!     y ^        [b]     directions (+, +): a before b     key: x + y at the lower left corner
//!       |  [a]           directions (-, -): b before a     key: -x - y at the upper right corner
//!       +--------> x
//! ```

use super::lanes::F4;
use crate::node::{ChildRef, WideNode};

/// A sorting network for eight values with 19 comparators (Batcher 1968).
const NETWORK: [(usize, usize); 19] = [
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (2, 4),
    (3, 5),
    (1, 4),
    (3, 6),
    (1, 2),
    (3, 4),
    (5, 6),
];

/// Sets the traversal order of the node's children for each octant.
pub(crate) fn set_order(node: &mut WideNode) {
    let large = F4::splat(1e38);
    let mut keys = [[F4::splat(0.0); 2]; 8];
    for (child, keys) in keys.iter_mut().enumerate() {
        let [x, y, z]: [[f32; 2]; 3] =
            std::array::from_fn(|axis| [node.planes[axis][0][child], -node.planes[axis][1][child]]);
        let xs = F4::new([x[0], x[1], x[0], x[1]]);
        let ys = F4::new([y[0], y[0], y[1], y[1]]);
        let xys = xs.add(ys);
        let number = F4::splat(f32::from_bits(child as u32));
        for (half, key) in keys.iter_mut().enumerate() {
            let entry = xys.add(F4::splat(z[half]));
            // Empty slots come last. The child index replaces the lowest three bits; it must not turn the key into an
            // infinity or a NaN.
            let entry = if node.children[child] == ChildRef::EMPTY { large } else { entry };
            let entry = entry.min(large).max(F4::splat(-1e38));
            *key = entry.without(F4::splat(f32::from_bits(7))).or(number);
        }
    }
    for (a, b) in NETWORK {
        let (near, far) = (keys[a], keys[b]);
        keys[a] = [near[0].min(far[0]), near[1].min(far[1])];
        keys[b] = [near[0].max(far[0]), near[1].max(far[1])];
    }
    let mut order = [0; 8];
    for (place, halves) in keys.iter().enumerate() {
        for (octant, word) in order.iter_mut().enumerate() {
            let key = halves[octant / 4].array()[octant % 4];
            *word |= (key.to_bits() & 7) << (3 * (7 - place));
        }
    }
    node.order = order;
}
