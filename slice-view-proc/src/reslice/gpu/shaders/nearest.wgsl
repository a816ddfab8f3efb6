// The nearest voxel; in the middle between two, the later one.

fn value(at: Spot) -> f32 {
    return texel(place(at.whole + vec3<i32>(at.part >> vec3<u32>(23u))));
}
