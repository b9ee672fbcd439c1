//! Which lights are seen where: shares of a light's importance that learnt occlusion leaves of it, constant in each cell of a tree over
//! the scene, so that picks pass over lights that walls hide.

use super::LightTable;
use super::importance_sampler::ImportanceSampler;
use crate::math::Vec3;
use crate::math::discrete::Discrete;

/// The most numbers of all cells.
pub const MOST_VALUES: usize = 1 << 20;
/// The longest way to a cell.
pub const MOST_HALVINGS: usize = 64;

/// One node of the tree as it is kept and sent: from its root, the lower side of a plane first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VisibilityNode<'a> {
    /// Parted by a plane across an axis.
    Parted {
        /// 0 to 2 for x to z.
        axis: usize,
        /// Where the plane lies, m.
        at: f32,
    },
    /// A cell: the share of each light by index, above 0, at most 1.
    Cell(&'a [f32]),
}

impl VisibilityNode<'_> {
    /// Adds it to a tree as numbers.
    pub fn write(self, values: &mut Vec<f32>) {
        match self {
            Self::Parted { axis, at } => values.extend([-1.0 - axis as f32, at]),
            Self::Cell(shares) => values.extend(shares),
        }
    }
}

/// Numbers that tell nothing of a scene's lights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VisibilityError {
    /// A number that stands for nothing.
    #[error("the visibility of lights holds {0}, which is neither a share nor a plane")]
    Node(f32),
    /// Too many or too few numbers.
    #[error("the visibility of lights is not one tree with a share of every light in each cell")]
    Tree,
}

/// A node, and where its second part is.
#[derive(Clone, Copy, Debug)]
enum Node {
    Parted { axis: u8, at: f32, second: u32 },
    Cell(u32),
}

/// What picks need in a cell: the lights that are seen in it. Others are found by their power alone.
#[derive(Clone, Debug)]
pub struct VisibilityCell {
    /// By what is left of importances.
    pub(super) by_place: ImportanceSampler,
    /// By what is left of powers.
    pub(super) by_power: Discrete,
}

/// The tree.
#[derive(Clone, Debug)]
pub struct LightVisibility {
    nodes: Vec<Node>,
    cells: Vec<VisibilityCell>,
}

impl LightVisibility {
    /// For `lights`, from nodes as numbers.
    ///
    /// # Errors
    /// Numbers that are not one such tree.
    pub fn new(values: &[f32], lights: &LightTable) -> Result<Self, VisibilityError> {
        let mut tree = Self { nodes: Vec::new(), cells: Vec::new() };
        let rest = tree.read(values, lights, MOST_HALVINGS)?;
        if rest.is_empty() { Ok(tree) } else { Err(VisibilityError::Tree) }
    }

    /// Reads a node and all below it; what is left.
    fn read<'a>(
        &mut self,
        values: &'a [f32],
        lights: &LightTable,
        halvings: usize,
    ) -> Result<&'a [f32], VisibilityError> {
        let first = *values.first().ok_or(VisibilityError::Tree)?;
        let Some(axis) = [0u8, 1, 2].into_iter().find(|axis| -1.0 - f32::from(*axis) == first) else {
            let (shares, rest) = values.split_at_checked(lights.lights().len()).ok_or(VisibilityError::Tree)?;
            if let Some(wrong) = shares.iter().find(|share| !(**share > 0.0 && **share <= 1.0)) {
                return Err(VisibilityError::Node(*wrong));
            }
            self.nodes.push(Node::Cell(self.cells.len() as u32));
            self.cells.push(lights.visibility_cell(shares).ok_or(VisibilityError::Tree)?);
            return Ok(rest);
        };
        let at = *values.get(1).filter(|_| halvings > 0).ok_or(VisibilityError::Tree)?;
        if !at.is_finite() {
            return Err(VisibilityError::Node(at));
        }
        let node = self.nodes.len();
        self.nodes.push(Node::Parted { axis, at, second: 0 });
        let rest = self.read(&values[2..], lights, halvings - 1)?;
        let second = self.nodes.len() as u32;
        self.nodes[node] = Node::Parted { axis, at, second };
        self.read(rest, lights, halvings - 1)
    }

    /// The cell of a place.
    #[inline]
    pub fn cell(&self, position: Vec3) -> &VisibilityCell {
        &self.cells[self.cell_index(position)]
    }

    /// The index of the cell of a place, in the order of the tree.
    #[inline]
    pub fn cell_index(&self, position: Vec3) -> usize {
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Parted { axis, at, second } => {
                    node = if position[axis as usize] < at { node + 1 } else { second as usize };
                }
                Node::Cell(cell) => return cell as usize,
            }
        }
    }
}
