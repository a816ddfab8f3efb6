//! The place of a surface that is nearest to a point: a tree of boxes over its triangles.

mod build;
mod triangle;

use nalgebra::Vector3;

pub(crate) use triangle::{Foot, Triangle};

/// Triangles in a leaf, at most.
const LEAF: usize = 4;
/// Deeper than any tree of four million triangles that is halved by number.
const DEEPEST: usize = 64;

/// A box with what is in it. Numbers are f32, rounded outwards: half the memory, and no triangle is missed.
#[derive(Debug, Clone, Copy)]
struct Node {
    least: [f32; 3],
    most: [f32; 3],
    /// Of a leaf its first triangle; else the place of the second child, the first one follows its parent.
    link: u32,
    /// Triangles of a leaf; 0 of an inner node.
    count: u32,
}

/// All triangles, in the order of the leaves.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
    /// A ball about each triangle: its middle and its radius, rounded up. A leaf's are one line of the cache, and rule most of its
    /// triangles out before they are looked at.
    balls: Vec<[f32; 4]>,
}

impl Node {
    /// Square of the distance to the box.
    #[inline]
    fn distance2(&self, p: &[f32; 3]) -> f32 {
        let off = [0, 1, 2].map(|k| (self.least[k] - p[k]).max(p[k] - self.most[k]).max(0.0));
        off[0] * off[0] + off[1] * off[1] + off[2] * off[2]
    }
}

impl Tree {
    /// Over triangles of which each corner exists.
    pub(crate) fn new(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Self {
        build::build(corners, triangles)
    }

    pub(crate) fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.triangles.iter()
    }

    /// The opposite corners of the box of everything.
    pub(crate) fn bounds(&self) -> [Vector3<f64>; 2] {
        let root = &self.nodes[0];
        [root.least, root.most].map(|c| Vector3::new(c[0].into(), c[1].into(), c[2].into()))
    }

    /// The nearest place within `within` mm; `None` where there is none, and for a point that is not finite. A triangle that is known to
    /// be near (`hint`, a [`Foot::triangle`]) makes it faster and changes nothing.
    pub(crate) fn foot(&self, p: &Vector3<f64>, within: f64, hint: Option<u32>) -> Option<Foot> {
        let mut best: Option<Foot> = None;
        let mut bound = within * within;
        let near = [p.x as f32, p.y as f32, p.z as f32];
        // Distances are rounded in f32: by at most 8 ulp of the coordinates, which are within 3000 mm and a point's own.
        let slack = 1e-6 * f64::from(near.iter().fold(3000.0_f32, |m, x| m.max(x.abs())));
        let root = |bound: f64| (bound.sqrt() + slack) as f32 * (1.0 + 1e-6);
        let look = |i: u32, best: &mut Option<Foot>, bound: &mut f64| {
            let foot = self.triangles[i as usize].foot(p, i);
            if foot.distance2 < *bound {
                *bound = foot.distance2;
                *best = Some(foot);
            }
        };
        if let Some(i) = hint {
            look(i, &mut best, &mut bound);
        }
        let mut reach = root(bound);
        let mut stack = [(0_u32, 0.0_f32); DEEPEST];
        let mut top = 0;
        let mut now = 0_u32;
        loop {
            let node = &self.nodes[now as usize];
            if node.count > 0 {
                for i in node.link..node.link + node.count {
                    let [x, y, z, radius] = self.balls[i as usize];
                    let off = [x - near[0], y - near[1], z - near[2]];
                    let limit = reach + radius;
                    if off[0] * off[0] + off[1] * off[1] + off[2] * off[2] <= limit * limit {
                        look(i, &mut best, &mut bound);
                        reach = root(bound);
                    }
                }
            } else {
                let children = [now + 1, node.link];
                let off = children.map(|child| self.nodes[child as usize].distance2(&near));
                // The nearer box first: what is found there rules the other one out, for the most part.
                let (first, second) = if off[0] <= off[1] { (0, 1) } else { (1, 0) };
                if off[second] <= reach * reach && top < DEEPEST {
                    stack[top] = (children[second], off[second]);
                    top += 1;
                }
                if off[first] <= reach * reach {
                    now = children[first];
                    continue;
                }
            }
            loop {
                if top == 0 {
                    return best;
                }
                top -= 1;
                if stack[top].1 <= reach * reach {
                    now = stack[top].0;
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use chance::SplitMix64;

    #[test]
    fn the_nearest_place_is_that_of_a_look_at_every_triangle() {
        let (corners, triangles) = shapes::ball(40.0, 24);
        let corners: Vec<Vector3<f64>> = corners.into_iter().map(Vector3::from).collect();
        let tree = Tree::new(&corners, &triangles);
        let mut random = SplitMix64::new(3);
        for _ in 0..2000 {
            let p = Vector3::from_fn(|_, _| random.around(0.0, 90.0));
            let foot = tree.foot(&p, f64::INFINITY, None).unwrap();
            let all = tree.triangles.iter().map(|t| t.foot(&p, 0).distance2);
            assert_eq!(foot.distance2, all.fold(f64::INFINITY, f64::min));
            let hinted = tree.foot(&p, f64::INFINITY, Some(7)).unwrap();
            assert_eq!(hinted.distance2, foot.distance2);
            assert!(tree.foot(&p, foot.distance2.sqrt() * 0.99, None).is_none());
        }
        assert!(tree.foot(&Vector3::repeat(f64::NAN), f64::INFINITY, None).is_none());
    }
}
