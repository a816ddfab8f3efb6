// Coefficients of the B-spline, mirrored about the centres of the outermost voxels.

@group(0) @binding(4) var volume: texture_3d<f32>;

fn texel(at: vec3<i32>) -> f32 {
    return textureLoad(volume, at, 0).r;
}

fn place(at: vec3<i32>) -> vec3<i32> {
    let last = params.dims - vec3<i32>(1);
    // Taps lie at most two voxels beyond: mirrored about the first, the last, and in a volume of two the first again.
    let mirrored = abs(last - abs(last - abs(at)));
    // Of a single voxel every mirror image is itself.
    return min(mirrored, last);
}
