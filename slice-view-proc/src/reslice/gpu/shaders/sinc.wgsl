// Weights of a windowed sinc from a table: 4096 phases of a voxel with straight lines between them.

@group(0) @binding(5) var<storage, read> phases: array<f32>;

fn weights(at: Spot) -> array<vec3<f32>, TAPS> {
    let phase = (at.part >> vec3<u32>(12u)) * u32(TAPS);
    let between = vec3<f32>(at.part & vec3<u32>(0xfffu)) / 4096.0;
    var w: array<vec3<f32>, TAPS>;
    for (var k = 0; k < TAPS; k++) {
        let a = phase + vec3<u32>(u32(k));
        let b = a + vec3<u32>(u32(TAPS));
        let low = vec3<f32>(phases[a.x], phases[a.y], phases[a.z]);
        let high = vec3<f32>(phases[b.x], phases[b.y], phases[b.z]);
        w[k] = low + (high - low) * between;
    }
    return w;
}

// Unrolled, 1000 taps keep a driver compiling for minutes.
fn loops() -> i32 {
    return i32(params.taps);
}
