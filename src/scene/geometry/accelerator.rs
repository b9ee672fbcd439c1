//! The bounding volume hierarchy over a scene's primitives. The only file that names obvhs.
//!
//! obvhs clamps the near distance to 10⁻⁴ of its own units, so coordinates are scaled by a power of two (which is exact) to
//! sizes where that is below the spacing of `f32`.

use std::time::Duration;

use glam::{UVec2, Vec3, Vec3A};
use obvhs::bvh2::builder::build_bvh2;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb, traverse};

use super::block::{self, Block, BlockKind};
use super::obstacles::{Layer, Obstacles};
use super::primitive::Primitive;
use super::ray::{PrimitiveHit, Ray, Shear, largest};

/// So few blocks are tested without a tree.
const FEW_BLOCKS: usize = 3;
/// What testing one primitive more costs in units of a step in the tree: lanes are cheap.
const LANE_COST: f32 = 8.0;

/// A hierarchy over primitives that it owns in its own order.
pub(crate) struct Accelerator {
    tree: CwBvh,
    /// World units to tree units.
    scale: f32,
    primitives: Vec<Primitive>,
    /// The tree's leaves, in its order.
    blocks: Vec<Leaf>,
    /// Whether rays need their shear.
    has_triangles: bool,
}

/// A block and where its primitives stand.
struct Leaf {
    block: Block,
    first: u32,
    count: u32,
}

#[derive(Clone, Copy)]
struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Accelerator {
    /// Builds over `primitives`; also gives the new order as indices into them.
    pub(crate) fn build(primitives: &[Primitive]) -> (Self, Vec<u32>) {
        let boxes: Vec<(Vec3, Vec3)> = primitives.iter().map(Primitive::bounds).collect();
        let size = boxes.iter().map(|(low, high)| largest(*low).max(largest(*high))).fold(0.0, f32::max);
        let scale = scale_for(size);
        let bounds = padded_boxes(boxes.into_iter(), scale);
        let groups: Vec<Vec<u32>> =
            [BlockKind::Triangles, BlockKind::OneSidedTriangles, BlockKind::Flat, BlockKind::Single]
                .into_iter()
                .flat_map(|kind| groups_of_kind(kind, primitives, &bounds))
                .collect();
        let of_group = |group: &Vec<u32>| {
            let members = group.iter().map(|index| bounds[*index as usize].0);
            Bounds(members.reduce(|all, one| all.union(&one)).unwrap_or_default())
        };
        let group_bounds: Vec<Bounds> = groups.iter().map(of_group).collect();
        let tree = build_tree(&group_bounds);
        let order: Vec<u32> =
            tree.primitive_indices.iter().flat_map(|group| groups[*group as usize].iter().copied()).collect();
        let has_triangles = primitives
            .iter()
            .any(|primitive| matches!(primitive, Primitive::Triangle(_) | Primitive::OneSidedTriangle(_)));
        let primitives: Vec<Primitive> = order.iter().map(|index| primitives[*index as usize]).collect();
        let mut first = 0;
        let blocks = tree.primitive_indices.iter().map(|group| {
            let count = groups[*group as usize].len();
            let block = Block::new(&primitives[first..first + count]);
            first += count;
            Leaf { block, first: (first - count) as u32, count: count as u32 }
        });
        let blocks = blocks.collect();
        (Self { tree, scale, primitives, blocks, has_triangles }, order)
    }

    /// The primitives in tree order.
    pub(crate) fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The nearest hit and the index of its primitive.
    #[inline]
    pub(crate) fn nearest(&self, ray: &Ray) -> Option<(usize, PrimitiveHit)> {
        let shear = self.shear(ray);
        let mut nearest = PrimitiveHit::at(ray.length);
        let mut found = usize::MAX;
        let mut test = |leaf: &Leaf| match self.intersect(leaf, ray, &shear, nearest.distance) {
            Some((index, hit)) => {
                (nearest, found) = (hit, index);
                hit.distance * self.scale
            }
            None => f32::INFINITY,
        };
        if self.blocks.len() <= FEW_BLOCKS {
            self.blocks.iter().for_each(|leaf| {
                test(leaf);
            });
        } else {
            visit_nearest(&self.tree, self.tree_ray(ray), |index| test(&self.blocks[index]));
        }
        (found != usize::MAX).then_some((found, nearest))
    }

    /// Whether anything is hit before the ray's length.
    #[inline]
    pub(crate) fn is_blocked(&self, ray: &Ray) -> bool {
        let shear = self.shear(ray);
        let blocks = |leaf: &Leaf| self.intersect(leaf, ray, &shear, ray.length).is_some();
        if self.blocks.len() <= FEW_BLOCKS {
            return self.blocks.iter().any(blocks);
        }
        visit_any(&self.tree, self.tree_ray(ray), |index| blocks(&self.blocks[index]))
    }

    /// Adds the primitives that may reach into `layer`, until there are too many.
    #[inline]
    pub(crate) fn collect(&self, layer: &Layer, obstacles: &mut Obstacles) {
        let mut goes_on = |leaf: &Leaf| {
            let mut found = leaf.block.may_reach(layer) & ((1 << leaf.count) - 1);
            while found != 0 {
                let index = (leaf.first + found.trailing_zeros()) as usize;
                if layer.may_hold(&self.primitives[index]) && !obstacles.add(index) {
                    return false;
                }
                found &= found - 1;
            }
            true
        };
        if self.blocks.len() <= FEW_BLOCKS {
            self.blocks.iter().all(goes_on);
        } else {
            visit_boxes(&self.tree, self.scale, layer, |index| goes_on(&self.blocks[index]));
        }
    }

    #[inline(always)]
    fn intersect(&self, leaf: &Leaf, ray: &Ray, shear: &Shear, length: f32) -> Option<(usize, PrimitiveHit)> {
        let first = leaf.first as usize;
        let primitives = &self.primitives[first..first + leaf.count as usize];
        let found = leaf.block.intersect(primitives, ray, shear, length)?;
        Some((first + found.lane, found.hit))
    }

    #[inline]
    fn shear(&self, ray: &Ray) -> Shear {
        if self.has_triangles { Shear::new(ray.direction) } else { Shear::UNUSED }
    }

    #[inline]
    fn tree_ray(&self, ray: &Ray) -> obvhs::ray::Ray {
        tree_ray(ray, self.scale)
    }
}

/// The tree over boxes, which may be none. On a bumpy ball of 10⁶ triangles the slow way takes 4.9 s and the medium one 3.3 s, and
/// rays are as fast in either tree; below 10⁵ that is a matter of tenths of a second.
fn build_tree(bounds: &[Bounds]) -> CwBvh {
    let parameters = match bounds.len() {
        0 => return CwBvh::default(),
        1..100_000 => BvhBuildParams::slow_build(),
        _ => BvhBuildParams::medium_build(),
    };
    build_cwbvh(bounds, parameters, &mut Duration::default())
}

/// A hierarchy over boxes, whatever is in them.
pub(crate) struct BoxTree {
    tree: CwBvh,
    /// World units to tree units.
    scale: f32,
}

impl BoxTree {
    /// Builds over boxes, each of a smallest and a largest corner; also gives the tree's order as indices into them.
    pub(crate) fn build(boxes: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> (Self, Vec<u32>) {
        let size = boxes.clone().map(|(low, high)| largest(low).max(largest(high))).fold(0.0, f32::max);
        let scale = scale_for(size);
        let bounds = padded_boxes(boxes, scale);
        let mut tree = build_tree(&bounds);
        let order = std::mem::take(&mut tree.primitive_indices);
        tree.nodes.shrink_to_fit();
        (Self { tree, scale }, order)
    }

    /// Shows `visit` the boxes along `ray`, by their place in the tree's order. It gives the distance of a hit nearer than
    /// all before, and from then on boxes farther away are left out.
    #[inline]
    pub(crate) fn visit_nearest(&self, ray: &Ray, mut visit: impl FnMut(usize) -> Option<f32>) {
        visit_nearest(&self.tree, tree_ray(ray, self.scale), |index| match visit(index) {
            Some(distance) => distance * self.scale,
            None => f32::INFINITY,
        });
    }

    /// Whether `layer` may reach into a box.
    #[inline]
    pub(crate) fn may_meet(&self, layer: &Layer) -> bool {
        let mut meets = false;
        visit_boxes(&self.tree, self.scale, layer, |_| {
            meets = true;
            false
        });
        meets
    }

    /// Shows `visit` the boxes along `ray` until it says yes; whether it did.
    #[inline]
    pub(crate) fn visit_any(&self, ray: &Ray, visit: impl FnMut(usize) -> bool) -> bool {
        visit_any(&self.tree, tree_ray(ray, self.scale), visit)
    }
}

/// Shows `visit` the boxes along `ray`. It gives the distance of a hit, and from then on boxes farther away are left out.
// `CwBvh::ray_traverse`, but always part of its caller: as a call it takes 4 % more instructions of a pass.
#[inline(always)]
fn visit_nearest(tree: &CwBvh, mut ray: obvhs::ray::Ray, mut visit: impl FnMut(usize) -> f32) {
    let mut state = tree.new_traversal(ray.direction);
    let mut node;
    traverse!(tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
        ray.tmax = visit(state.primitive_id as usize).min(ray.tmax);
    });
}

/// Whether `visit` says so of any box along `ray`. Part of its caller, too.
#[inline(always)]
fn visit_any(tree: &CwBvh, ray: obvhs::ray::Ray, mut visit: impl FnMut(usize) -> bool) -> bool {
    let mut state = tree.new_traversal(ray.direction);
    let mut node;
    traverse!(tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
        if visit(state.primitive_id as usize) {
            return true;
        }
    });
    false
}

/// Shows `goes_on` the boxes that meet the one around `layer`, until it says no.
#[inline]
fn visit_boxes(tree: &CwBvh, scale: f32, layer: &Layer, mut goes_on: impl FnMut(usize) -> bool) {
    let (low, high) = layer.bounds();
    let bounds = Aabb { min: (low * scale).into(), max: (high * scale).into() };
    let mut state = tree.new_traversal(Vec3A::ONE);
    let mut node;
    'boxes: {
        traverse!(tree, node, state, node.intersect_aabb(&bounds, state.oct_inv4), {
            if !goes_on(state.primitive_id as usize) {
                break 'boxes;
            }
        });
    }
}

#[inline]
fn tree_ray(ray: &Ray, scale: f32) -> obvhs::ray::Ray {
    let length = ray.length * scale;
    // obvhs misses everything along directions with a component of -0.0; adding zero makes it +0.0.
    let direction = ray.direction + Vec3::ZERO;
    obvhs::ray::Ray::new((ray.origin * scale).into(), direction.into(), 0.0, length)
}

/// The power of two that brings coordinates of `size` to about 4096.
fn scale_for(size: f32) -> f32 {
    let exponent = if size > 0.0 { libm::frexpf(size).1 } else { 0 };
    libm::ldexpf(1.0, (12 - exponent).clamp(-126, 127))
}

/// Boxes in tree units with room for rounding, so that flat ones keep every ray that meets what they hold.
///
/// A little more room by chance makes all boxes different. obvhs joins boxes that are each other's best partner: where all
/// look equally good, as in a row of equal triangles, that is one pair a round, and the time grows with the square of their number.
fn padded_boxes(boxes: impl Iterator<Item = (Vec3, Vec3)>, scale: f32) -> Vec<Bounds> {
    let padded = |(index, (low, high)): (usize, (Vec3, Vec3))| {
        let room = largest(low).max(largest(high)) * scale * (4.0 * f32::EPSILON) * (Vec3::ONE + scatter(index));
        Bounds(Aabb { min: (low * scale - room).into(), max: (high * scale + room).into() })
    };
    boxes.enumerate().map(padded).collect()
}

/// Three numbers in [0, 1) that neighbouring indices do not share (SplitMix64).
fn scatter(index: usize) -> Vec3 {
    let mut bits = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let part = |shift: u32| (bits >> shift & 0xf_ffff) as f32 / (1 << 20) as f32;
    Vec3::new(part(4), part(24), part(44))
}

/// Neighbours of one kind, at most [`block::LANES`] together, as indices into `primitives`.
fn groups_of_kind(kind: BlockKind, primitives: &[Primitive], bounds: &[Bounds]) -> Vec<Vec<u32>> {
    let members: Vec<u32> =
        (0..primitives.len() as u32).filter(|index| BlockKind::of(&primitives[*index as usize]) == kind).collect();
    if members.is_empty() || kind == BlockKind::Single {
        return members.into_iter().map(|index| vec![index]).collect();
    }
    if members.len() <= block::LANES {
        return vec![members];
    }
    let boxes: Vec<Bounds> = members.iter().map(|index| bounds[*index as usize]).collect();
    let parameters = BvhBuildParams {
        max_prims_per_leaf: block::LANES as u32,
        collapse_traversal_cost: LANE_COST,
        ..BvhBuildParams::medium_build()
    };
    let tree = build_bvh2(&boxes, parameters, &mut Duration::default());
    let leaves = tree.nodes.iter().filter(|node| node.is_leaf());
    let group = |first: u32, count: u32| {
        let range = first as usize..(first + count) as usize;
        tree.primitive_indices[range].iter().map(|index| members[*index as usize]).collect()
    };
    leaves.map(|node| group(node.first_index, node.prim_count)).collect()
}
