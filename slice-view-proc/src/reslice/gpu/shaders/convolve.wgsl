// A product of TAPS weights an axis: along x, then y, then z.

fn value(at: Spot) -> f32 {
    var w = weights(at);
    var voxel: array<vec3<i32>, TAPS>;
    for (var k = 0; k < TAPS; k++) {
        voxel[k] = place(at.whole + vec3<i32>(k + 1 - TAPS / 2));
    }
    var sum = 0.0;
    for (var k = 0; k < loops(); k++) {
        var layer = 0.0;
        for (var j = 0; j < loops(); j++) {
            var line = 0.0;
            for (var i = 0; i < TAPS; i++) {
                line += w[i].x * texel(vec3<i32>(voxel[i].x, voxel[j].y, voxel[k].z));
            }
            layer += w[j].y * line;
        }
        sum += w[k].z * layer;
    }
    return sum;
}
