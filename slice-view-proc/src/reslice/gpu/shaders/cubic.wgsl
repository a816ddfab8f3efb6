// Catmull-Rom weights, as in the reference.

fn weights(at: Spot) -> array<vec3<f32>, TAPS> {
    let t = at.weight;
    let s = vec3<f32>(1.0) - t;
    return array<vec3<f32>, TAPS>(
        -0.5 * t * s * s,
        1.0 + t * t * (1.5 * t - 2.5),
        1.0 + s * s * (1.5 * s - 2.5),
        -0.5 * s * t * t,
    );
}

fn loops() -> i32 {
    return TAPS;
}
