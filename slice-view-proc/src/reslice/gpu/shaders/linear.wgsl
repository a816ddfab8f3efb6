// Seven nested a + (b - a) w: along x, then y, then z.

fn between(a: f32, b: f32, w: f32) -> f32 {
    return a + (b - a) * w;
}

fn edge(x: vec2<i32>, y: i32, z: i32, w: f32) -> f32 {
    return between(texel(vec3<i32>(x.x, y, z)), texel(vec3<i32>(x.y, y, z)), w);
}

fn value(at: Spot) -> f32 {
    let a = place(at.whole);
    let b = place(at.whole + vec3<i32>(1));
    let x = vec2<i32>(a.x, b.x);
    let near = between(edge(x, a.y, a.z, at.weight.x), edge(x, b.y, a.z, at.weight.x), at.weight.y);
    let far = between(edge(x, a.y, b.z, at.weight.x), edge(x, b.y, b.z, at.weight.x), at.weight.y);
    return between(near, far, at.weight.z);
}
