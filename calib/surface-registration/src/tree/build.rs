//! The tree from triangles.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::{LEAF, Node, Tree, Triangle};

pub(super) fn build(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Tree {
    let made = with_normals(corners, triangles);
    let centres: Vec<Vector3<f64>> = made.iter().map(|t| (t.a + t.b + t.c) / 3.0).collect();
    let mut order: Vec<u32> = (0..made.len() as u32).collect();
    let mut nodes = Vec::with_capacity(made.len());
    split(&made, &centres, &mut order, 0, &mut nodes);
    let triangles: Vec<Triangle> = order.iter().map(|i| made[*i as usize].clone()).collect();
    Tree {
        nodes,
        balls: triangles.iter().map(ball).collect(),
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

/// Triangles with normals of faces, sums of two on edges, and sums by angle at corners.
fn with_normals(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<Triangle> {
    let at = |t: &[u32; 3]| t.map(|c| corners[c as usize]);
    let face = |t: &[u32; 3]| {
        let [a, b, c] = at(t);
        (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros)
    };
    let faces: Vec<Vector3<f64>> = triangles.iter().map(face).collect();
    let mut at_corner = vec![Vector3::zeros(); corners.len()];
    let mut at_edge: HashMap<(u32, u32), (Vector3<f64>, i32)> = HashMap::with_capacity(2 * triangles.len());
    for (t, n) in triangles.iter().zip(&faces) {
        let p = at(t);
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            let (ahead, back) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            at_corner[i as usize] += n * ahead.angle(&back);
            let edge = at_edge.entry((i.min(j), i.max(j))).or_insert((Vector3::zeros(), 0));
            edge.0 += n;
            // As many one way as the other, but on a border.
            edge.1 += if i < j { 1 } else { -1 };
        }
    }
    let mut is_open = vec![false; corners.len()];
    for ((i, j), (_, surplus)) in &at_edge {
        if *surplus != 0 {
            is_open[*i as usize] = true;
            is_open[*j as usize] = true;
        }
    }
    let narrow = |n: Vector3<f64>| [n.x as f32, n.y as f32, n.z as f32];
    let made = triangles.iter().zip(&faces).map(|(t, n)| {
        let [a, b, c] = at(t);
        let edges = [0, 1, 2].map(|k| {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            at_edge[&(i.min(j), i.max(j))]
        });
        let bit = |is_open: bool, k: usize| u8::from(is_open) << k;
        let open = (0..3).map(|k| bit(edges[k].1 != 0, k) | bit(is_open[t[k] as usize], k + 3));
        Triangle {
            a,
            b,
            c,
            face: *n,
            edges: edges.map(|edge| narrow(edge.0)),
            corners: t.map(|i| narrow(at_corner[i as usize])),
            open: open.fold(0, |all, bits| all | bits),
        }
    });
    made.collect()
}
