//! Nodes with eight children.

use crate::Aabb;

/// Eight child boxes, child references, and front-to-back orders, in four cache lines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct WideNode {
    /// By axis: the eight lower planes, then the eight upper ones. An empty slot has lower planes at +infinity and
    /// upper planes at -infinity, so that every ray misses it.
    pub(crate) planes: [[[f32; 8]; 2]; 3],
    pub(crate) children: [ChildRef; 8],
    /// For each octant of directions (bit `i` set: component `i` is negative), the child slots from far to near, three
    /// bits each, the farthest in the lowest bits.
    pub(crate) order: [u32; 8],
}

const _: () = assert!(size_of::<WideNode>() == 256);

/// A reference to a node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct ChildRef(pub(crate) u32);

/// The most blocks in a leaf: the count has four bits.
pub(crate) const MAX_LEAF_BLOCKS: usize = 15;
/// The most blocks in a BVH: the index has 27 bits.
pub(crate) const MAX_BLOCKS: usize = 1 << 27;
/// The most nodes on a path from the root to a leaf. Builders keep this limit.
pub(crate) const MAX_WIDE_DEPTH: usize = 40;

impl ChildRef {
    pub(crate) const LEAF: u32 = 1 << 31;
    /// An empty slot: a leaf without blocks.
    pub(crate) const EMPTY: ChildRef = ChildRef(ChildRef::LEAF);

    pub(crate) fn node(index: usize) -> ChildRef {
        debug_assert!(index < ChildRef::LEAF as usize);
        ChildRef(index as u32)
    }

    pub(crate) fn leaf(first_block: usize, blocks: usize) -> ChildRef {
        debug_assert!(first_block < MAX_BLOCKS && blocks <= MAX_LEAF_BLOCKS);
        ChildRef(ChildRef::LEAF | (first_block as u32) << 4 | blocks as u32)
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & ChildRef::LEAF != 0
    }

    /// The index of a node.
    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }

    #[inline(always)]
    pub(crate) fn first_block(self) -> usize {
        (self.0 >> 4 & 0x7ff_ffff) as usize
    }

    #[inline(always)]
    pub(crate) fn blocks(self) -> usize {
        (self.0 & 15) as usize
    }
}

impl WideNode {
    pub(crate) const EMPTY: WideNode = WideNode {
        planes: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
        children: [ChildRef::EMPTY; 8],
        order: [0o76543210; 8],
    };

    /// Byte offset from an axis' lower planes to its upper planes.
    pub(crate) const UPPER: u32 = 32;

    /// The lower (`offset` 0) or upper (`offset` [`UPPER`](Self::UPPER)) planes of an axis.
    #[inline(always)]
    pub(crate) fn side(&self, axis: usize, offset: u32) -> &[f32; 8] {
        debug_assert!(offset == 0 || offset == WideNode::UPPER);
        // SAFETY: both offsets are within `planes[axis]`, and traversal uses no others.
        unsafe { &*(&raw const self.planes[axis]).byte_add(offset as usize).cast::<[f32; 8]>() }
    }

    #[inline(always)]
    pub(crate) fn child_words(&self) -> &[u32; 8] {
        // SAFETY: `ChildRef` is a transparent u32.
        unsafe { &*(&raw const self.children).cast::<[u32; 8]>() }
    }

    pub(crate) fn bounds(&self, child: usize) -> Aabb {
        Aabb { min: self.planes.map(|p| p[0][child]), max: self.planes.map(|p| p[1][child]) }
    }

    pub(crate) fn set(&mut self, child: usize, bounds: Aabb, reference: ChildRef) {
        for axis in 0..3 {
            self.planes[axis][0][child] = bounds.min[axis];
            self.planes[axis][1][child] = bounds.max[axis];
        }
        self.children[child] = reference;
    }
}
