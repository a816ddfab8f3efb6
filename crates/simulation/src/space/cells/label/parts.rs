//! Parts of a set of voxels, and the holes in it.

/// Keeps the largest part of voxels that touch at faces; sizes of all parts, the largest first.
pub(super) fn largest_part(inside: &mut [bool], size: [usize; 3]) -> Vec<usize> {
    let parts = parts(inside, size);
    let largest = parts
        .iter()
        .max_by_key(|p| (p.len(), std::cmp::Reverse(p.first().copied())));
    inside.fill(false);
    for n in largest.into_iter().flatten() {
        inside[*n] = true;
    }
    let mut sizes: Vec<usize> = parts.iter().map(Vec::len).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

/// Voxels of holes: parts of the outside that do not reach the box's faces. Filled where asked.
pub(super) fn fill_holes(inside: &mut [bool], size: [usize; 3], fill: bool) -> usize {
    let outside: Vec<bool> = inside.iter().map(|i| !i).collect();
    // A margin is outside all around: the part that the first voxel is in.
    let holes: Vec<Vec<usize>> = parts(&outside, size)
        .into_iter()
        .filter(|p| p.first() != Some(&0))
        .collect();
    for n in holes.iter().flatten().filter(|_| fill) {
        inside[*n] = true;
    }
    holes.iter().map(Vec::len).sum()
}

/// Parts in the order of their first voxels, which stand first in them.
fn parts(inside: &[bool], size: [usize; 3]) -> Vec<Vec<usize>> {
    let mut seen = vec![false; inside.len()];
    let mut parts = Vec::new();
    for start in 0..inside.len() {
        if !inside[start] || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut part = vec![start];
        let mut next = 0;
        while next < part.len() {
            for n in beside(part[next], size).into_iter().flatten() {
                if inside[n] && !seen[n] {
                    seen[n] = true;
                    part.push(n);
                }
            }
            next += 1;
        }
        parts.push(part);
    }
    parts
}

/// Voxels across the faces of one.
fn beside(n: usize, size: [usize; 3]) -> [Option<usize>; 6] {
    let strides = [1, size[0], size[0] * size[1]];
    let at = [n % size[0], n / strides[1] % size[1], n / strides[2]];
    std::array::from_fn(|k| {
        let axis = k / 2;
        if k % 2 == 0 {
            (at[axis] > 0).then(|| n - strides[axis])
        } else {
            (at[axis] + 1 < size[axis]).then(|| n + strides[axis])
        }
    })
}
