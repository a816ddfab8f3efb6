//! Orders of elimination that fill little: `minimum_degree` for patterns that change, `dissection` for meshes, with `cut` (a part
//! in two), `cover` (by the fewest vertices) and `levels` (directions in a graph without places).

mod cover;
mod cut;
mod dissection;
mod levels;
mod minimum_degree;

#[cfg(test)]
pub(super) use cover::{Sides, smallest_cover};

use super::graph::Graph;
use minimum_degree::minimum_degree;

/// Nested dissection: for matrices of meshes in space, whose pattern stays.
///
/// A few unknowns that part the rest in two are eliminated last, and so on in each part. Of `n` unknowns of a solid that leaves
/// `n^2` multiplications, which minimum degree exceeds the more, the larger the mesh.
#[derive(Debug, Clone, Default)]
pub struct Dissection {
    size: usize,
    places: Option<Vec<[f64; 3]>>,
    root: Vec<u32>,
}

/// What no order can be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoOrder {
    /// A coordinate that is not finite.
    #[error("the place of unknown {0} is not finite")]
    Place(usize),
    /// An unknown that does not exist.
    #[error("unknown {unknown} of the root is none of the {size} unknowns")]
    Beyond {
        /// The unknown.
        unknown: usize,
        /// How many there are.
        size: usize,
    },
    /// An unknown named twice.
    #[error("unknown {0} is named twice in the root")]
    Twice(usize),
}

impl Dissection {
    /// By the place of each unknown's node, in any unit: cuts across the axes.
    ///
    /// `root` is eliminated last, in that order, whatever the rest: see [`super::Ldl::root`].
    ///
    /// # Errors
    /// [`NoOrder`]. Places may coincide: what no plane parts is dissected by its pattern alone.
    pub fn by_places(places: &[[f64; 3]], root: &[usize]) -> Result<Self, NoOrder> {
        if let Some(unknown) = places.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(NoOrder::Place(unknown));
        }
        let by_pattern = Self::by_pattern(places.len(), root)?;
        Ok(Self {
            places: Some(places.to_vec()),
            ..by_pattern
        })
    }

    /// By the pattern alone of a matrix of `size` unknowns, which finds worse cuts.
    ///
    /// # Errors
    /// [`NoOrder`].
    pub fn by_pattern(size: usize, root: &[usize]) -> Result<Self, NoOrder> {
        let mut named = vec![false; size];
        for &unknown in root {
            match named.get_mut(unknown) {
                None => return Err(NoOrder::Beyond { unknown, size }),
                Some(named) if *named => return Err(NoOrder::Twice(unknown)),
                Some(named) => *named = true,
            }
        }
        Ok(Self {
            size,
            places: None,
            root: root.iter().map(|u| *u as u32).collect(),
        })
    }
}

/// Groups of unknowns that are alike, in the order of their elimination.
pub(super) struct Ordered {
    pub(super) graph: Graph,
    pub(super) groups: Vec<Vec<u32>>,
    pub(super) weights: Vec<usize>,
    pub(super) order: Vec<u32>,
    /// How many of the last ones are the root.
    pub(super) kept: usize,
}

impl Ordered {
    /// The order of the unknowns of a pattern: by dissection, or by minimum degree.
    pub(super) fn new(pattern: &Graph, dissection: Option<&Dissection>) -> Self {
        // Made for another matrix, neither places nor root say anything.
        let fits = dissection.filter(|d| d.size == pattern.size());
        let root = fits.map_or(&[][..], |d| &d.root[..]);
        let mut in_root = vec![false; pattern.size()];
        root.iter().for_each(|u| in_root[*u as usize] = true);
        // Unknowns with the same neighbours, as those of a node, are ordered as one.
        let (graph, groups) = pattern.alike(&in_root);
        let weights: Vec<usize> = groups.iter().map(Vec::len).collect();
        let order = if dissection.is_some() {
            let places = fits.and_then(|d| d.places.as_deref());
            dissected(&graph, &groups, &weights, places, root)
        } else {
            minimum_degree(&graph, &weights)
        };
        Self {
            graph,
            groups,
            weights,
            order,
            kept: root.len(),
        }
    }
}

/// The order of groups by dissection, the root's unknowns, each a group, at its end.
fn dissected(
    graph: &Graph,
    groups: &[Vec<u32>],
    weights: &[usize],
    places: Option<&[[f64; 3]]>,
    root: &[u32],
) -> Vec<u32> {
    // Unknowns that are alike lie in one node: any speaks for the group.
    let places: Option<Vec<[f64; 3]>> = places.map(|all| groups.iter().map(|g| all[g[0] as usize]).collect());
    let mut group_of = vec![0; weights.iter().sum()];
    (0..groups.len()).for_each(|g| group_of[groups[g][0] as usize] = g as u32);
    let root: Vec<u32> = root.iter().map(|u| group_of[*u as usize]).collect();
    let mut kept = vec![false; groups.len()];
    root.iter().for_each(|g| kept[*g as usize] = true);
    let mut order = dissection::dissection(graph, weights, places.as_deref(), &kept);
    order.extend(root);
    order
}
