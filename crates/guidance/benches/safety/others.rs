//! Other ways to the same distance: every boundary voxel, and an exact Euclidean distance transform of a label.

use geometry::Point;
use guidance::safety::Tube;

use crate::patient::{Patient, SIDE, STEP_MM};

/// Every boundary voxel with its label.
pub(crate) fn boundary(patient: &Patient) -> Vec<(i16, [f64; 3])> {
    let mut found = Vec::new();
    let at = |x: usize, y: usize, z: usize| patient.labels[x + SIDE * (y + SIDE * z)];
    for z in 0..SIDE {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let label = at(x, y, z);
                let is_rim = [x, y, z].iter().any(|&i| i == 0 || i == SIDE - 1);
                let differs = || {
                    let beside = [at(x - 1, y, z), at(x + 1, y, z), at(x, y - 1, z), at(x, y + 1, z)];
                    beside
                        .into_iter()
                        .chain([at(x, y, z - 1), at(x, y, z + 1)])
                        .any(|other| other != label)
                };
                if label != 0 && (is_rim || differs()) {
                    found.push((label, [x, y, z].map(|i| i as f64 * STEP_MM)));
                }
            }
        }
    }
    found
}

/// The least signed distance of each label over a list of voxels; infinite without any.
pub(crate) fn forced(points: &[(i16, [f64; 3])], tube: &Tube, least: &mut [f64]) {
    let (entry, axis, half) = (tube.entry().mm(), tube.axis().components(), tube.length_mm() / 2.0);
    least.fill(f64::INFINITY);
    for (label, p) in points {
        let away = [0, 1, 2].map(|k| p[k] - entry[k]);
        let depth = away[0] * axis[0] + away[1] * axis[1] + away[2] * axis[2];
        let across = [0, 1, 2].map(|k| away[k] - axis[k] * depth);
        let beside = across.iter().map(|x| x * x).sum::<f64>().sqrt() - tube.radius_mm();
        let beyond = (depth - half).abs() - half;
        let signed = if beside > 0.0 && beyond > 0.0 {
            beside.hypot(beyond)
        } else {
            beside.max(beyond)
        };
        let slot = &mut least[*label as usize];
        *slot = slot.min(signed);
    }
}

/// The distance of every voxel from the nearest of one label, mm, by the lower envelope of parabolas along each axis (Felzenszwalb and
/// Huttenlocher 2012).
pub(crate) fn transform(patient: &Patient, label: i16) -> Vec<f32> {
    let far = 1e9_f32;
    let mut field: Vec<f32> = patient
        .labels
        .iter()
        .map(|&l| if l == label { 0.0 } else { far })
        .collect();
    let (mut line, mut out) = (vec![0.0_f32; SIDE], vec![0.0_f32; SIDE]);
    let mut work = (vec![0_usize; SIDE], vec![0.0_f32; SIDE + 1]);
    for stride in [1, SIDE, SIDE * SIDE] {
        for k in 0..SIDE * SIDE {
            let start = match stride {
                1 => k * SIDE,
                SIDE => k % SIDE + k / SIDE * SIDE * SIDE,
                _ => k,
            };
            (0..SIDE).for_each(|i| line[i] = field[start + i * stride]);
            envelope(&line, &mut out, &mut work);
            (0..SIDE).for_each(|i| field[start + i * stride] = out[i]);
        }
    }
    field
        .iter_mut()
        .for_each(|square| *square = square.sqrt() * STEP_MM as f32);
    field
}

fn envelope(f: &[f32], out: &mut [f32], (v, z): &mut (Vec<usize>, Vec<f32>)) {
    let mut k = 0;
    (v[0], z[0], z[1]) = (0, f32::NEG_INFINITY, f32::INFINITY);
    for q in 1..f.len() {
        let meet = |p: usize| ((f[q] + (q * q) as f32) - (f[p] + (p * p) as f32)) / (2 * q - 2 * p) as f32;
        while k > 0 && meet(v[k]) <= z[k] {
            k -= 1;
        }
        let at = meet(v[k]);
        if at > z[k] {
            k += 1;
        }
        (v[k], z[k], z[k + 1]) = (q, at, f32::INFINITY);
    }
    k = 0;
    for (q, out) in out.iter_mut().enumerate() {
        while z[k + 1] < q as f32 {
            k += 1;
        }
        *out = (q as f32 - v[k] as f32).powi(2) + f[v[k]];
    }
}

/// The least of a distance field over points of the tube a step apart, each interpolated.
pub(crate) fn sampled(field: &[f32], tube: &Tube) -> f64 {
    let axis = tube.axis().vector();
    let helper = if axis.mm()[0].abs() < 0.8 {
        geometry::Direction::X
    } else {
        geometry::Direction::Y
    };
    let Some(u) = helper.vector().cross(axis).direction() else {
        return f64::NAN;
    };
    let v = axis.cross(u.vector());
    let across = (2.0 * tube.radius_mm() / STEP_MM).ceil() as i32;
    let along = (tube.length_mm() / STEP_MM).ceil() as i32;
    let mut least = f64::INFINITY;
    for i in 0..=along {
        let middle = tube.at(tube.length_mm() * f64::from(i) / f64::from(along));
        for j in 0..=across {
            for k in 0..=across {
                let [x, y] = [j, k].map(|n| tube.radius_mm() * (2.0 * f64::from(n) / f64::from(across) - 1.0));
                // Those outside the disc are moved to its rim.
                let shrink = (tube.radius_mm() / x.hypot(y)).min(1.0);
                least = least.min(interpolated(field, middle + u * (x * shrink) + v * (y * shrink)));
            }
        }
    }
    least
}

fn interpolated(field: &[f32], p: Point<geometry::Ct>) -> f64 {
    let index = p.mm().map(|mm| (mm / STEP_MM).clamp(0.0, (SIDE - 1) as f64 - 1e-9));
    let (first, part) = (index.map(|i| i as usize), index.map(f64::fract));
    (0..8)
        .map(|corner| {
            let bit = |k: usize| corner >> k & 1;
            let weight: f64 = (0..3)
                .map(|k| if bit(k) == 1 { part[k] } else { 1.0 - part[k] })
                .product();
            let at = (first[0] + bit(0)) + SIDE * ((first[1] + bit(1)) + SIDE * (first[2] + bit(2)));
            weight * f64::from(field[at])
        })
        .sum()
}
