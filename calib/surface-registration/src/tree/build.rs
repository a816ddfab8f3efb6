//! The tree from triangles.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::triangle::Normals;
use super::{LEAF, Node, Tree, Triangle};

pub(super) fn build(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Tree {
    let corner = |i: &u32| corners[*i as usize];
    let made: Vec<Triangle> = triangles
        .iter()
        .map(|[a, b, c]| Triangle {
            a: corner(a),
            b: corner(b),
            c: corner(c),
        })
        .collect();
    let normals = normals(&made, corners.len(), triangles);
    let centres: Vec<Vector3<f64>> = made.iter().map(|t| (t.a + t.b + t.c) / 3.0).collect();
    let mut order: Vec<u32> = (0..made.len() as u32).collect();
    let mut nodes = Vec::with_capacity(made.len());
    split(&made, &centres, &mut order, 0, &mut nodes);
    let triangles: Vec<Triangle> = order.iter().map(|i| made[*i as usize].clone()).collect();
    Tree {
        nodes,
        balls: triangles.iter().map(ball).collect(),
        normals: order.iter().map(|i| normals[*i as usize].clone()).collect(),
        triangles,
    }
}

/// One node over `order`, whose first triangle has the number `first` in the end, and all below it.
fn split(made: &[Triangle], centres: &[Vector3<f64>], order: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let place = nodes.len();
    nodes.push(bounded(made, order));
    if order.len() <= LEAF {
        nodes[place].link = first as u32;
        nodes[place].count = order.len() as u32;
        return;
    }
    let mut least = Vector3::repeat(f64::INFINITY);
    let mut most = Vector3::repeat(f64::NEG_INFINITY);
    for i in order.iter() {
        least = least.inf(&centres[*i as usize]);
        most = most.sup(&centres[*i as usize]);
    }
    let axis = (most - least).imax();
    let middle = order.len() / 2;
    // Halves of equal number keep the depth at the logarithm whatever the triangles are; ties go by number, so that the tree is the same
    // on every run.
    order.select_nth_unstable_by(middle, |i, j| {
        let (x, y) = (centres[*i as usize][axis], centres[*j as usize][axis]);
        x.total_cmp(&y).then(i.cmp(j))
    });
    let (left, right) = order.split_at_mut(middle);
    split(made, centres, left, first, nodes);
    nodes[place].link = nodes.len() as u32;
    split(made, centres, right, first + middle, nodes);
}

fn ball(t: &Triangle) -> [f32; 4] {
    let middle = (t.a + t.b + t.c) / 3.0;
    let radius = [t.a, t.b, t.c].iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    // The cast of the middle moves it by half an ulp in each axis: an ulp of its greatest coordinate more is enough.
    let room = middle.amax() * f64::from(f32::EPSILON);
    [
        middle.x as f32,
        middle.y as f32,
        middle.z as f32,
        ((radius + room) as f32).next_up(),
    ]
}

fn bounded(made: &[Triangle], order: &[u32]) -> Node {
    let mut least = [f32::INFINITY; 3];
    let mut most = [f32::NEG_INFINITY; 3];
    for i in order {
        let t = &made[*i as usize];
        for p in [t.a, t.b, t.c] {
            for k in 0..3 {
                // The next number beyond, since a cast rounds to the nearest.
                least[k] = least[k].min((p[k] as f32).next_down());
                most[k] = most[k].max((p[k] as f32).next_up());
            }
        }
    }
    Node {
        least,
        most,
        link: 0,
        count: 0,
    }
}

/// Normals of faces, sums of two on edges, and sums by angle at corners.
fn normals(made: &[Triangle], corners: usize, triangles: &[[u32; 3]]) -> Vec<Normals> {
    let face = |t: &Triangle| {
        let normal = (t.b - t.a).cross(&(t.c - t.a));
        normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    };
    let faces: Vec<Vector3<f64>> = made.iter().map(face).collect();
    // Each face's normal times its angle at each corner.
    let at_corners = |(t, n): (&Triangle, &Vector3<f64>)| {
        let p = [t.a, t.b, t.c];
        [0, 1, 2].map(|k| n * (p[(k + 1) % 3] - p[k]).angle(&(p[(k + 2) % 3] - p[k])))
    };
    let parts: Vec<[Vector3<f64>; 3]> = made.iter().zip(&faces).map(at_corners).collect();
    let mut at_corner = vec![Vector3::zeros(); corners];
    let mut at_edge: HashMap<(u32, u32), (Vector3<f64>, i32)> = HashMap::with_capacity(2 * triangles.len());
    for ((t, n), part) in triangles.iter().zip(&faces).zip(&parts) {
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            at_corner[i as usize] += part[k];
            let edge = at_edge.entry((i.min(j), i.max(j))).or_insert((Vector3::zeros(), 0));
            edge.0 += n;
            // As many one way as the other, but on a border.
            edge.1 += if i < j { 1 } else { -1 };
        }
    }
    let mut is_open = vec![false; corners];
    for ((i, j), (_, surplus)) in &at_edge {
        if *surplus != 0 {
            is_open[*i as usize] = true;
            is_open[*j as usize] = true;
        }
    }
    let narrow = |n: Vector3<f64>| [n.x as f32, n.y as f32, n.z as f32];
    let around = Incident::new(corners, triangles);
    let one = |(i, t): (usize, &[u32; 3])| {
        let edges = [0, 1, 2].map(|k| {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            at_edge[&(i.min(j), i.max(j))]
        });
        let bit = |is_open: bool, k: usize| u8::from(is_open) << k;
        let open = (0..3).map(|k| bit(edges[k].1 != 0, k) | bit(is_open[t[k] as usize], k + 3));
        let smooth = t.map(|corner| {
            let near = around
                .of(corner)
                .iter()
                .map(|place| (*place as usize / 3, *place as usize % 3));
            let alike = near.filter(|(other, _)| faces[*other].dot(&faces[i]) > CREASE_COSINE);
            narrow(alike.map(|(other, k)| parts[other][k]).sum())
        });
        Normals {
            face: faces[i],
            edges: edges.map(|edge| narrow(edge.0)),
            corners: t.map(|corner| narrow(at_corner[corner as usize])),
            open: open.fold(0, |all, bits| all | bits),
            smooth,
            bulge_mm: bulge(&made[i], edges.map(|edge| (edge.0, edge.1 == 0))) as f32,
        }
    };
    triangles.iter().enumerate().map(one).collect()
}

/// Faces turned by more than this against one another meet in an edge of the body itself, not of its facets: 30 degrees.
const CREASE_COSINE: f64 = 0.866_025_4;

/// The sum over its edges of `h a / 8`: over a facet of width `h` a surface that turns by `a` from one facet to the next bulges by so much
/// (`h^2 k / 8` of the curvature `k = a / h`). `edges` are the sums of the two normals, and whether there are two.
fn bulge(Triangle { a, b, c }: &Triangle, edges: [(Vector3<f64>, bool); 3]) -> f64 {
    let twice_area = (b - a).cross(&(c - a)).norm();
    let sides = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
    let one = |k: usize| {
        let (sum, has_two) = edges[k];
        // Of two unit vectors an angle a apart the sum has the length 2 cos (a / 2).
        let angle = 2.0 * (0.5 * sum.norm()).min(1.0).acos();
        if !has_two || sides[k] <= 0.0 || angle.cos() < CREASE_COSINE {
            return 0.0;
        }
        twice_area / sides[k] * angle / 8.0
    };
    (0..3).map(one).sum()
}

/// The triangles at each corner, each as three times its number and which of its corners it is.
struct Incident {
    first: Vec<u32>,
    places: Vec<u32>,
}

impl Incident {
    fn new(corners: usize, triangles: &[[u32; 3]]) -> Self {
        let mut first = vec![0_u32; corners + 1];
        for corner in triangles.iter().flatten() {
            first[*corner as usize + 1] += 1;
        }
        for i in 0..corners {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut all = vec![0; 3 * triangles.len()];
        for (i, t) in triangles.iter().enumerate() {
            for (k, corner) in t.iter().enumerate() {
                let place = &mut next[*corner as usize];
                all[*place as usize] = (3 * i + k) as u32;
                *place += 1;
            }
        }
        Self { first, places: all }
    }

    fn of(&self, corner: u32) -> &[u32] {
        &self.places[self.first[corner as usize] as usize..self.first[corner as usize + 1] as usize]
    }
}
