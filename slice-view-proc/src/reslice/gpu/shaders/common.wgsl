// What every filter shares: where points lie, which of them are inside, and what becomes of several points of a pixel.
// A filter is added behind this text: it defines `value`, the HU at one spot.

struct Params {
    // From one point to the next along a row: 16 bits of voxels, 48 bits of fraction, low and high words.
    step_low: vec3<u32>,
    // Points of one pixel along a row.
    fold: u32,
    step_high: vec3<u32>,
    // Pixels of a row.
    width: u32,
    dims: vec3<i32>,
    // Rows of pixels in this dispatch.
    rows: u32,
    // Through a slab: 0 mean, 1 maximum, 2 minimum.
    mode: u32,
    padding: f32,
    // Parts of a HU in which means are added up, and its inverse.
    unit: f32,
    per_unit: f32,
    // Taps of the filter along an axis, for loops that no compiler is to unroll.
    taps: u32,
}

// The part of one row of points that is inside the volume: columns `from` to `to`, and the place of the first.
struct Run {
    low: vec3<u32>,
    // The topmost bit marks the first run of a layer of points.
    from_column: u32,
    high: vec3<u32>,
    to_column: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// For each row of pixels its first run and how many there are.
@group(0) @binding(1) var<storage, read> rows: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> runs: array<Run>;
@group(0) @binding(3) var<storage, read_write> hu: array<f32>;

const NEW_LAYER: u32 = 0x80000000u;

// A place with 16 bits of voxels and 48 of fraction: 64-bit integers, so that it is as exact at the end of a row as at
// its beginning.
struct Place {
    low: vec3<u32>,
    high: vec3<u32>,
}

// A place as filters take it: voxel, and a fraction of 24 bits, which an f32 holds exactly.
struct Spot {
    whole: vec3<i32>,
    part: vec3<u32>,
    weight: vec3<f32>,
}

fn plus(a: Place, b: Place) -> Place {
    let low = a.low + b.low;
    let carry = select(vec3<u32>(0u), vec3<u32>(1u), low < a.low);
    return Place(low, a.high + b.high + carry);
}

// The lower 64 bits of `a` times `n`.
fn times(a: Place, n: u32) -> Place {
    let half = vec3<u32>(0xffffu);
    let al = a.low & half;
    let ah = a.low >> vec3<u32>(16u);
    let nl = n & 0xffffu;
    let nh = n >> 16u;
    let ll = al * nl;
    let hl = ah * nl;
    let lh = al * nh;
    let hh = ah * nh;
    let middle = (ll >> vec3<u32>(16u)) + (hl & half) + (lh & half);
    let low = (ll & half) | (middle << vec3<u32>(16u));
    let above = hh + (hl >> vec3<u32>(16u)) + (lh >> vec3<u32>(16u)) + (middle >> vec3<u32>(16u));
    return Place(low, above + a.high * n);
}

fn spot(at: Place) -> Spot {
    let rounded = plus(at, Place(vec3<u32>(0x00800000u), vec3<u32>(0u)));
    let whole = bitcast<vec3<i32>>(rounded.high) >> vec3<u32>(16u);
    let above = (rounded.high & vec3<u32>(0xffffu)) << vec3<u32>(8u);
    let part = above | (rounded.low >> vec3<u32>(24u));
    return Spot(whole, part, vec3<f32>(part) * 0x1p-24f);
}

// Values added up in 64-bit integers: whatever the number of points, a mean is off by half a unit.
struct Mean {
    low: u32,
    high: u32,
    count: u32,
    // The value added last; of a single one the mean is itself.
    last: f32,
}

fn add(mean: ptr<function, Mean>, value: f32) {
    let units = i32(round(value * params.unit));
    let low = (*mean).low + bitcast<u32>(units);
    (*mean).high += bitcast<u32>(units >> 31u) + select(0u, 1u, low < (*mean).low);
    (*mean).low = low;
    (*mean).count += 1u;
    (*mean).last = value;
}

fn mean_of(mean: Mean) -> f32 {
    if mean.count == 1u {
        return mean.last;
    }
    // By sign and magnitude: -1 in two words would round to 0.
    var low = mean.low;
    var high = mean.high;
    var unit = params.per_unit;
    if (high & 0x80000000u) != 0u {
        low = ~low + 1u;
        high = ~high + select(0u, 1u, low == 0u);
        unit = -unit;
    }
    return (f32(high) * 4294967296.0 + f32(low)) / f32(mean.count) * unit;
}

// The mean of a layer of points becomes part of the pixel.
fn add_layer(pixel: ptr<function, Mean>, layer: Mean) {
    if layer.count == 0u {
        return;
    }
    let value = mean_of(layer);
    if params.mode == 0u || (*pixel).count == 0u {
        add(pixel, value);
    } else if params.mode == 1u {
        (*pixel).last = max((*pixel).last, value);
    } else {
        (*pixel).last = min((*pixel).last, value);
    }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if pixel.x >= params.width || pixel.y >= params.rows {
        return;
    }
    let step = Place(params.step_low, params.step_high);
    let left = pixel.x * params.fold;
    let right = (pixel.x + 1u) * params.fold;
    var total = Mean(0u, 0u, 0u, 0.0);
    var layer = total;
    let row = rows[pixel.y];
    for (var r = row.x; r < row.x + row.y; r++) {
        let run = runs[r];
        if (run.from_column & NEW_LAYER) != 0u {
            add_layer(&total, layer);
            layer = Mean(0u, 0u, 0u, 0.0);
        }
        let first_inside = run.from_column & ~NEW_LAYER;
        let begin = max(left, first_inside);
        let end = min(right, run.to_column);
        if begin >= end {
            continue;
        }
        var at = plus(Place(run.low, run.high), times(step, begin - first_inside));
        for (var column = begin; column < end; column++) {
            add(&layer, value(spot(at)));
            at = plus(at, step);
        }
    }
    add_layer(&total, layer);
    hu[pixel.y * params.width + pixel.x] = select(params.padding, mean_of(total), total.count > 0u);
}
