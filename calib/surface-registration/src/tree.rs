//! The place of a surface that is nearest to a point: a tree of boxes over its triangles.

mod build;
mod triangle;

use nalgebra::Vector3;

use triangle::Near;
pub(crate) use triangle::{Foot, Normals, Triangle};

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
    normals: Vec<Normals>,
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

/// The root of a square, and what rounding may have taken from it.
#[inline]
fn rounded_up(square: f64, slack: f64) -> f32 {
    (square.sqrt() + slack) as f32 * (1.0 + 1e-6)
}

impl Tree {
    /// Over triangles of which each corner exists.
    pub(crate) fn new(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Self {
        build::build(corners, triangles)
    }

    pub(crate) fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.triangles.iter()
    }

    /// All triangles with what is known at their places.
    pub(crate) fn faces(&self) -> impl Iterator<Item = (&Triangle, &Normals)> {
        self.triangles.iter().zip(&self.normals)
    }

    /// The opposite corners of the box of everything.
    pub(crate) fn bounds(&self) -> [Vector3<f64>; 2] {
        let root = &self.nodes[0];
        [root.least, root.most].map(|c| Vector3::new(c[0].into(), c[1].into(), c[2].into()))
    }

    /// The normal, at a nearest place, of the smooth surface that the facets stand for, and by how much that bulges there, mm.
    pub(crate) fn smooth(&self, foot: &Foot) -> (Vector3<f64>, f64) {
        let i = foot.triangle as usize;
        let normals = &self.normals[i];
        (normals.smooth(&self.triangles[i], &foot.place), normals.bulge_mm.into())
    }

    fn dressed(&self, (near, triangle): (Near, u32)) -> Foot {
        self.normals[triangle as usize].foot(&near, triangle)
    }

    /// The nearest place of some triangles.
    #[inline]
    pub(crate) fn foot_among(&self, p: &Vector3<f64>, among: &[u32]) -> Option<Foot> {
        let mut best: Option<(Near, u32)> = None;
        let (near, slack) = self.rounded(p);
        let mut reach = f32::INFINITY;
        for i in among {
            if !self.is_within(*i, &near, reach) {
                continue;
            }
            let own = self.triangles[*i as usize].near(p);
            if best.is_none_or(|best| own.distance2 < best.0.distance2) {
                reach = rounded_up(own.distance2, slack);
                best = Some((own, *i));
            }
        }
        best.map(|best| self.dressed(best))
    }

    /// A point in single precision, and by how much distances from it may be rounded: by at most 8 ulp of the coordinates, which are
    /// within 3000 mm and its own.
    #[inline]
    fn rounded(&self, p: &Vector3<f64>) -> ([f32; 3], f64) {
        let near = [p.x as f32, p.y as f32, p.z as f32];
        (
            near,
            1e-6 * f64::from(near.iter().fold(3000.0_f32, |m, x| m.max(x.abs()))),
        )
    }

    /// Whether the ball about a triangle comes within `reach`.
    #[inline]
    fn is_within(&self, triangle: u32, near: &[f32; 3], reach: f32) -> bool {
        let [x, y, z, radius] = self.balls[triangle as usize];
        let off = [x - near[0], y - near[1], z - near[2]];
        let limit = reach + radius;
        off[0] * off[0] + off[1] * off[1] + off[2] * off[2] <= limit * limit
    }

    /// All triangles within `reach` mm of a point, in the order of the tree; `None` where they are more than `most`.
    pub(crate) fn gather(&self, p: &Vector3<f64>, reach: f64, most: usize, into: &mut Vec<u32>) -> Option<()> {
        into.clear();
        let (near, slack) = self.rounded(p);
        let rough = rounded_up(reach * reach, slack);
        let mut stack = [0_u32; DEEPEST];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let now = stack[top];
            let node = &self.nodes[now as usize];
            if node.distance2(&near) > rough * rough {
                continue;
            }
            if node.count == 0 {
                if top + 2 > DEEPEST {
                    return None;
                }
                // The first child on top, so that what is found comes in order.
                (stack[top], stack[top + 1]) = (node.link, now + 1);
                top += 2;
                continue;
            }
            for i in node.link..node.link + node.count {
                if self.is_within(i, &near, rough) && self.triangles[i as usize].near(p).distance2 <= reach * reach {
                    if into.len() == most {
                        return None;
                    }
                    into.push(i);
                }
            }
        }
        Some(())
    }

    /// The nearest place within `within` mm; `None` where there is none, and for a point that is not finite. A triangle that is known to
    /// be near (`hint`, a [`Foot::triangle`]) makes it faster and changes nothing.
    pub(crate) fn foot(&self, p: &Vector3<f64>, within: f64, hint: Option<u32>) -> Option<Foot> {
        let mut best: Option<(Near, u32)> = None;
        let mut bound = within * within;
        let (near, slack) = self.rounded(p);
        let root = |bound: f64| rounded_up(bound, slack);
        let look = |i: u32, best: &mut Option<(Near, u32)>, bound: &mut f64| {
            let own = self.triangles[i as usize].near(p);
            if own.distance2 < *bound {
                *bound = own.distance2;
                *best = Some((own, i));
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
                    if self.is_within(i, &near, reach) {
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
                    return best.map(|best| self.dressed(best));
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
            let all = tree.triangles.iter().map(|t| t.near(&p).distance2);
            assert_eq!(foot.distance2, all.fold(f64::INFINITY, f64::min));
            let hinted = tree.foot(&p, f64::INFINITY, Some(7)).unwrap();
            assert_eq!(hinted.distance2, foot.distance2);
            assert!(tree.foot(&p, foot.distance2.sqrt() * 0.99, None).is_none());
            // What is near a place 0.5 mm off holds what is nearest here.
            let off = Vector3::from_fn(|_, _| random.around(0.0, 0.28));
            let mut near = Vec::new();
            let reach = tree.foot(&(p + off), f64::INFINITY, None).unwrap().distance2.sqrt() + 1.0;
            if tree.gather(&(p + off), reach, 200, &mut near).is_some() {
                assert!(near.is_sorted());
                assert_eq!(tree.foot_among(&p, &near).unwrap().distance2, foot.distance2);
            } else {
                assert!(p.norm() < 40.0, "{p}");
            }
        }
        assert!(tree.foot(&Vector3::repeat(f64::NAN), f64::INFINITY, None).is_none());
    }
}
