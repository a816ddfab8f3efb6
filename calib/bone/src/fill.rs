//! Marrow: what a bone encloses belongs to it, also where the wall has holes of less than 4 mm.

use std::collections::VecDeque;

use crate::voxels::Crop;

/// Walls are closed over holes up to twice this, mm.
const CLOSE_MM: f64 = 2.0;

/// Adds to a mask what it encloses together with whatever else has `level` HU and more, where it has more of the wall than the others have: a
/// bone is not opened where a joint was cut off it. At the CT's ends a cavity that is cut is closed where its wall is closed in that plane.
pub(crate) fn fill(crop: &Crop, mask: &mut [u8], level: f64) {
    let wall: Vec<u8> = mask
        .iter()
        .zip(&crop.hu)
        .map(|(m, hu)| m | u8::from(f64::from(*hu) >= level))
        .collect();
    let reach = ball(crop, CLOSE_MM.max(1.01 * least_step(crop)));
    // Bone that ends where nothing was measured is closed there, as it is at the CT's end.
    let mut shut = wall.clone();
    crop.gap.iter().zip(&mut shut).for_each(|(gap, voxel)| *voxel |= gap);
    let open: Vec<u8> = dilated(crop, &shut, 1, &reach).iter().map(|v| 1 - v).collect();
    let open = dilated(crop, &open, 1, &reach);
    // Of the closed walls 0, of what is around them 1.
    let around = flooded(crop, &open);
    let holes: Vec<u8> = open
        .iter()
        .zip(&around)
        .map(|(o, a)| u8::from(*o == 1 && *a == 0))
        .collect();
    // A cavity ends where the closing began: grown back it meets its wall again.
    let mut cavity = dilated(crop, &holes, 1, &reach);
    // And what is enclosed without any closing.
    let free: Vec<u8> = shut.iter().map(|v| 1 - v).collect();
    let around = flooded(crop, &free);
    for (i, voxel) in cavity.iter_mut().enumerate() {
        *voxel = u8::from(free[i] == 1 && (*voxel == 1 || around[i] == 0));
    }
    own_cavities(crop, &cavity, &wall, mask);
    // What the bone encloses itself is its own, whatever it is: cement, a screw.
    let free: Vec<u8> = mask.iter().map(|v| 1 - v).collect();
    let around = flooded(crop, &free);
    for (voxel, outside) in mask.iter_mut().zip(&around) {
        *voxel = 1 - outside;
    }
}

/// Adds each cavity to the mask whose walls are the mask's for the greater part.
fn own_cavities(crop: &Crop, cavity: &[u8], wall: &[u8], mask: &mut [u8]) {
    let [nx, ny, _] = crop.dims;
    let mut seen = vec![false; cavity.len()];
    let before = mask.to_vec();
    for start in 0..cavity.len() {
        if cavity[start] == 0 || seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut members, mut next, mut own, mut others) = (vec![start], 0, 0_u64, 0_u64);
        while next < members.len() {
            let at = members[next];
            next += 1;
            for other in neighbours(crop, [at % nx, at / nx % ny, at / (nx * ny)]) {
                own += u64::from(before[other] == 1);
                others += u64::from(before[other] == 0 && wall[other] == 1);
                if cavity[other] == 1 && !seen[other] {
                    seen[other] = true;
                    members.push(other);
                }
            }
        }
        if own > others {
            members.iter().for_each(|i| mask[*i] = 1);
        }
    }
}

fn least_step(crop: &Crop) -> f64 {
    (0..3)
        .map(|k| crop.steps.column(k).norm())
        .fold(f64::INFINITY, f64::min)
}

/// Steps to all voxels within `mm`.
pub(crate) fn ball(crop: &Crop, mm: f64) -> Vec<[i32; 3]> {
    // How far a ball reaches along an index is the length of that row of the inverse times its radius.
    let reach = [0, 1, 2].map(|k| (crop.index_from_mm.row(k).norm() * mm).floor() as i32);
    let mut steps = Vec::new();
    for z in -reach[2]..=reach[2] {
        for y in -reach[1]..=reach[1] {
            for x in -reach[0]..=reach[0] {
                let at = crop.steps * nalgebra::Vector3::new(f64::from(x), f64::from(y), f64::from(z));
                if at.norm() <= mm {
                    steps.push([x, y, z]);
                }
            }
        }
    }
    steps
}

/// Of the voxels that are `of`, all within the steps, as 1.
pub(crate) fn dilated(crop: &Crop, mask: &[u8], of: u8, steps: &[[i32; 3]]) -> Vec<u8> {
    let mut out: Vec<u8> = mask.iter().map(|v| u8::from(*v == of)).collect();
    for_each(crop, |at, [x, y, z]| {
        if mask[at] != of {
            return;
        }
        let is_rim = neighbours(crop, [x, y, z]).any(|other| mask[other] != of);
        // What has its own kind all around reaches nothing that its neighbours do not.
        if !is_rim {
            return;
        }
        for step in steps {
            let to = [
                x as i64 + i64::from(step[0]),
                y as i64 + i64::from(step[1]),
                z as i64 + i64::from(step[2]),
            ];
            if (0..3).all(|k| to[k] >= 0 && to[k] < crop.dims[k] as i64) {
                out[crop.offset(to.map(|k| k as usize))] = 1;
            }
        }
    });
    out
}

pub(crate) fn for_each(crop: &Crop, mut visit: impl FnMut(usize, [usize; 3])) {
    let [nx, ny, nz] = crop.dims;
    let mut at = 0;
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                visit(at, [x, y, z]);
                at += 1;
            }
        }
    }
}

/// The numbers of the up to six voxels that share a face.
pub(crate) fn neighbours(crop: &Crop, [x, y, z]: [usize; 3]) -> impl Iterator<Item = usize> {
    let [nx, ny, nz] = crop.dims;
    let at = crop.offset([x, y, z]);
    [
        (x > 0).then(|| at - 1),
        (x + 1 < nx).then(|| at + 1),
        (y > 0).then(|| at - nx),
        (y + 1 < ny).then(|| at + nx),
        (z > 0).then(|| at - nx * ny),
        (z + 1 < nz).then(|| at + nx * ny),
    ]
    .into_iter()
    .flatten()
}

/// Of the voxels that are 1, those that reach an end of the part, as 1. In a face of the part a cavity is reached only if it reaches
/// the edges of that face within it: bone that the CT cuts through is closed there.
fn flooded(crop: &Crop, free: &[u8]) -> Vec<u8> {
    let mut reached = vec![0; free.len()];
    let mut queue = VecDeque::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, crop.dims[axis] - 1] {
            let mut seen = vec![false; crop.dims[u] * crop.dims[v]];
            let mut face = VecDeque::new();
            let offset = |i: usize, j: usize| {
                let mut at = [0; 3];
                (at[axis], at[u], at[v]) = (side, i, j);
                crop.offset(at)
            };
            for i in 0..crop.dims[u] {
                for j in 0..crop.dims[v] {
                    let is_rim = i == 0 || j == 0 || i + 1 == crop.dims[u] || j + 1 == crop.dims[v];
                    if is_rim && free[offset(i, j)] == 1 {
                        seen[i * crop.dims[v] + j] = true;
                        face.push_back((i, j));
                    }
                }
            }
            while let Some((i, j)) = face.pop_front() {
                let at = offset(i, j);
                if reached[at] == 0 {
                    reached[at] = 1;
                    queue.push_back(at);
                }
                let around = [(i.wrapping_sub(1), j), (i + 1, j), (i, j.wrapping_sub(1)), (i, j + 1)];
                for (a, b) in around {
                    // What wrapped is beyond the end as well.
                    if a < crop.dims[u] && b < crop.dims[v] && !seen[a * crop.dims[v] + b] && free[offset(a, b)] == 1 {
                        seen[a * crop.dims[v] + b] = true;
                        face.push_back((a, b));
                    }
                }
            }
        }
    }
    if crop.gap.contains(&1) {
        // Within a round field what is around the bone need not reach the CT's end: it is the largest of what hangs together.
        let start = largest(crop, free);
        queue.extend(start);
        start.into_iter().for_each(|at| reached[at] = 1);
    }
    let [nx, ny, _] = crop.dims;
    while let Some(at) = queue.pop_front() {
        let place = [at % nx, at / nx % ny, at / (nx * ny)];
        for other in neighbours(crop, place) {
            if free[other] == 1 && reached[other] == 0 {
                reached[other] = 1;
                queue.push_back(other);
            }
        }
    }
    reached
}

/// A voxel of the largest of the bodies that voxels that are 1 make.
fn largest(crop: &Crop, free: &[u8]) -> Option<usize> {
    let [nx, ny, _] = crop.dims;
    let (mut seen, mut best) = (vec![false; free.len()], None);
    for start in 0..free.len() {
        if free[start] == 0 || seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut queue, mut count) = (vec![start], 0_usize);
        while let Some(at) = queue.pop() {
            count += 1;
            for other in neighbours(crop, [at % nx, at / nx % ny, at / (nx * ny)]) {
                if free[other] == 1 && !seen[other] {
                    seen[other] = true;
                    queue.push(other);
                }
            }
        }
        best = best.max(Some((count, start)));
    }
    best.map(|(_, start)| start)
}
