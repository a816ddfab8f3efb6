// Linear by the texture sampler, whose weights have 8 bits on most hardware.

@group(0) @binding(4) var volume: texture_3d<f32>;
@group(0) @binding(6) var linear: sampler;

fn value(at: Spot) -> f32 {
    let index = vec3<f32>(at.whole) + at.weight;
    let within = (index + vec3<f32>(0.5)) / vec3<f32>(params.dims);
    return textureSampleLevel(volume, linear, within, 0.0).r * 32767.0;
}
