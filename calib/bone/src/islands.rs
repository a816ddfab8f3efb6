//! Pieces of a surface that stand alone among places without a position.

use std::collections::BTreeSet;

/// A piece of less than this share of the whole area tells nothing of a pose, and which side of it is the bone's is told by its normals alone.
const LEAST_SHARE: f64 = 0.02;

/// The triangles without those of small pieces, and how many corners are of no triangle any more. Pieces hang together by edges: at a
/// corner alone two of them may stand back to back.
pub(crate) fn without_islands(triangles: Vec<[u32; 3]>, area: impl Fn(&[u32; 3]) -> f64) -> (Vec<[u32; 3]>, usize) {
    let pieces = pieces(&triangles);
    let mut areas = vec![0.0; triangles.len()];
    for (triangle, piece) in triangles.iter().zip(&pieces) {
        areas[*piece] += area(triangle);
    }
    let least = LEAST_SHARE * areas.iter().sum::<f64>();
    let before = used(&triangles);
    let both = triangles.into_iter().zip(pieces);
    let kept: Vec<[u32; 3]> = both
        .filter(|(_, piece)| areas[*piece] >= least)
        .map(|(triangle, _)| triangle)
        .collect();
    let dropped = before - used(&kept);
    (kept, dropped)
}

fn used(triangles: &[[u32; 3]]) -> usize {
    triangles.iter().flatten().collect::<BTreeSet<_>>().len()
}

/// The piece of each triangle: the first triangle of it.
pub(crate) fn pieces(triangles: &[[u32; 3]]) -> Vec<usize> {
    let mut edges: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * triangles.len());
    for (i, [a, b, c]) in triangles.iter().enumerate() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            edges.push(([*p.min(q), *p.max(q)], i));
        }
    }
    edges.sort_unstable();
    let mut roots: Vec<usize> = (0..triangles.len()).collect();
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (p, q) = (root(&mut roots, pair[0].1), root(&mut roots, pair[1].1));
        // To the smaller number, so that nothing depends on the order of the edges.
        roots[p.max(q)] = p.min(q);
    }
    (0..triangles.len()).map(|i| root(&mut roots, i)).collect()
}

/// The first triangle of a triangle's piece.
fn root(roots: &mut [usize], triangle: usize) -> usize {
    let mut at = triangle;
    while roots[at] != at {
        roots[at] = roots[roots[at]];
        at = roots[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_piece_goes_and_a_large_one_stays() {
        // A strip of 200 triangles, one of 3 that shares a corner with it, and a single one.
        let strip = |first: u32, count: u32| (0..count).map(move |i| [first + i, first + i + 1, first + i + 2]);
        let all: Vec<[u32; 3]> = strip(0, 200).chain(strip(201, 3)).chain(strip(400, 1)).collect();
        let (kept, dropped) = without_islands(all.clone(), |_| 1.0);
        assert_eq!((kept.len(), dropped), (200, 7));
        // The order of the triangles is no matter.
        let (mut turned, _) = without_islands(all.into_iter().rev().collect(), |_| 1.0);
        turned.reverse();
        assert_eq!(turned, kept);
        assert_eq!(without_islands(Vec::new(), |_| 1.0), (Vec::new(), 0));
    }
}
