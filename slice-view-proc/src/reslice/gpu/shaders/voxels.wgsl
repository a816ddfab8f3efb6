// Voxels as they are; beyond the outermost ones, these again.

@group(0) @binding(4) var volume: texture_3d<i32>;

fn texel(at: vec3<i32>) -> f32 {
    return f32(textureLoad(volume, at, 0).r);
}

fn place(at: vec3<i32>) -> vec3<i32> {
    return clamp(at, vec3<i32>(0), params.dims - vec3<i32>(1));
}
