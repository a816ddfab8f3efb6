//! The Laplacian of a Gaussian as a detector of blobs: Lindeberg 1998, at the one scale of the beads looked for.

/// Share of an ideal bead's response that a maximum must have; a bead is taken for as bright as 12 bits hold.
const SHARE: f64 = 0.5;

/// The centres of blobs of this radius, mm.
pub(crate) fn blobs(values: &[i16], dims: [usize; 3], step_mm: [f64; 3], radius_mm: f64) -> Vec<[f64; 3]> {
    // In three dimensions a ball answers most at this scale.
    let sigma = radius_mm / 3.0_f64.sqrt();
    let mut smooth: Vec<f32> = values.iter().map(|v| f32::from(*v)).collect();
    let strides = [1, dims[0], dims[0] * dims[1]];
    for axis in 0..3 {
        smooth = blurred(&smooth, strides[axis], &kernel(sigma / step_mm[axis]));
    }
    let response = |i: usize| -> f64 {
        let second = |a: usize| {
            let around = smooth[i + strides[a]] + smooth[i - strides[a]] - 2.0 * smooth[i];
            f64::from(around) / (step_mm[a] * step_mm[a])
        };
        -sigma * sigma * (second(0) + second(1) + second(2))
    };
    let inner = dims.map(|d| 1..d - 1);
    let mut laplacian = vec![0.0_f32; values.len()];
    for k in inner[2].clone() {
        for j in inner[1].clone() {
            for i in inner[0].clone() {
                let at = i + j * strides[1] + k * strides[2];
                laplacian[at] = response(at) as f32;
            }
        }
    }
    // An ideal ball at its best scale answers with about 0.4 of its contrast.
    maxima(&laplacian, dims, (SHARE * 0.4 * 3071.0) as f32)
        .into_iter()
        .map(|[i, j, k]| {
            let at = i + j * strides[1] + k * strides[2];
            let voxel = [i, j, k].map(|v| v as f64);
            [0, 1, 2].map(|a| (voxel[a] + vertex(&laplacian, at, strides[a])) * step_mm[a])
        })
        .collect()
}

fn kernel(sigma: f64) -> Vec<f32> {
    let reach = (4.0 * sigma).ceil() as i32;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|i| (-0.5 * (f64::from(i) / sigma).powi(2)).exp())
        .collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| (w / sum) as f32).collect()
}

/// Convolved along the axis of this stride; what lies before the first or behind the last value of the volume is left out.
fn blurred(values: &[f32], stride: usize, kernel: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; values.len()];
    let half = kernel.len() / 2;
    for (tap, weight) in kernel.iter().enumerate() {
        let shift = tap.abs_diff(half) * stride;
        let (from, to) = if tap < half { (0, shift) } else { (shift, 0) };
        let count = values.len() - shift;
        let (source, target) = (&values[from..from + count], &mut out[to..to + count]);
        target.iter_mut().zip(source).for_each(|(t, s)| *t += weight * s);
    }
    out
}

fn maxima(values: &[f32], [nx, ny, nz]: [usize; 3], least: f32) -> Vec<[usize; 3]> {
    let mut found = Vec::new();
    for k in 1..nz - 1 {
        for j in 1..ny - 1 {
            for i in 1..nx - 1 {
                let at = (k * ny + j) * nx + i;
                let value = values[at];
                let over = |d: usize| {
                    let (dz, dy, dx) = (d / 9, d / 3 % 3, d % 3);
                    d == 13 || values[at + dz * nx * ny + dy * nx + dx - nx * ny - nx - 1] < value
                };
                if value > least && (0..27).all(over) {
                    found.push([i, j, k]);
                }
            }
        }
    }
    found
}

/// Of the parabola through a maximum and its two neighbours, in steps.
fn vertex(values: &[f32], at: usize, stride: usize) -> f64 {
    let [before, here, after] = [at - stride, at, at + stride].map(|i| f64::from(values[i]));
    let curve = before - 2.0 * here + after;
    if curve < 0.0 {
        0.5 * (before - after) / curve
    } else {
        0.0
    }
}
