//! Which triangles hang together, and where their surface is open.

use nalgebra::Vector3;

use super::SurfaceError;

/// A border edge in the direction in which its triangle goes along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub(super) from: u32,
    pub(super) to: u32,
    /// The triangle it belongs to.
    pub(super) triangle: u32,
}

pub(super) struct Topology {
    /// The part of each triangle: the least triangle in it.
    pub(super) part: Vec<u32>,
    pub(super) borders: Vec<Border>,
}

/// Disjoint sets by the least member.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(n: usize) -> Self {
        // Places in lists of at most four million triangles.
        Self((0..n as u32).collect())
    }

    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            // Path halving keeps the trees flat without a second pass.
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        let (least, other) = (a.min(b), a.max(b));
        self.0[other as usize] = least;
    }
}

/// # Errors
/// [`SurfaceError::Orientation`].
pub(super) fn topology(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<Topology, SurfaceError> {
    let mut edges: Vec<(u32, u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            edges.push((a.min(b), a.max(b), i as u32, a < b));
        }
    }
    edges.sort_unstable();
    let mut sets = Sets::new(triangles.len());
    let mut borders = Vec::new();
    let (mut wrong, mut first) = (0, None);
    for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for pair in group.windows(2) {
            sets.join(pair[0].2, pair[1].2);
        }
        // Of a consistent surface as many triangles go along an edge one way as the other, also where four meet in it; one more at a
        // border.
        let up = group.iter().filter(|edge| edge.3).count();
        let surplus = 2 * up as i64 - group.len() as i64;
        if surplus.abs() > 1 {
            wrong += 1;
            first.get_or_insert((group[0].0, group[0].1));
        } else if surplus != 0
            && let Some(edge) = group.iter().find(|edge| edge.3 == (surplus > 0))
        {
            let (from, to) = if edge.3 { (edge.0, edge.1) } else { (edge.1, edge.0) };
            borders.push(Border {
                from,
                to,
                triangle: edge.2,
            });
        }
    }
    if let Some((a, b)) = first {
        return Err(SurfaceError::Orientation {
            edges: wrong,
            from: corners[a as usize].into(),
            to: corners[b as usize].into(),
        });
    }
    let part = (0..triangles.len() as u32).map(|i| sets.root(i)).collect();
    Ok(Topology { part, borders })
}
