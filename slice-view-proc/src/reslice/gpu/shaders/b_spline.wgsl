// Cubic B-spline weights, as in the reference.

fn weights(at: Spot) -> array<vec3<f32>, TAPS> {
    let t = at.weight;
    let s = vec3<f32>(1.0) - t;
    return array<vec3<f32>, TAPS>(
        s * s * s / 6.0,
        2.0 / 3.0 - t * t * (2.0 - t) * 0.5,
        2.0 / 3.0 - s * s * (2.0 - s) * 0.5,
        t * t * t / 6.0,
    );
}

fn loops() -> i32 {
    return TAPS;
}
