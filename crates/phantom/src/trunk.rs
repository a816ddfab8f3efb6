//! The trunk's outline: a full ellipse with a waist, flatter than an ellipse at the flanks, with a furrow down the back.

use crate::vec3::Vec3;

/// z of the narrowest place, mm.
const WAIST_Z: f64 = 60.0;
/// How the half-axes grow away from the waist, mm per mm^2: 12 mm at the hips.
const FLARE: f64 = 3.3e-4;
/// How far the outline fills its rectangle: 0 is an ellipse, 1 the rectangle (Fernandez-Guasti's squircle).
const FULLNESS: f64 = 0.35;
/// Depth and half-width of the furrow over the spine, mm.
const FURROW: [f64; 2] = [8.0, 24.0];

/// The trunk's surface at some depth under the skin; open upwards and downwards.
///
/// F = X^2 + Y^2 - `FULLNESS` X^2 Y^2 = 1 with X = x / rx(z), Y = (y - centre) / ry(z).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrunkWall {
    /// Half-axes at the waist, mm: right-left and front-back.
    pub half: [f64; 2],
    /// y of the middle, mm.
    pub centre_y: f64,
}

impl TrunkWall {
    /// The surface `by` mm further inside.
    pub(crate) fn deeper(self, by: f64) -> Self {
        self.inset(by, by, by)
    }

    /// The surface further inside by different amounts at the flanks, the belly and the back, mm.
    pub(crate) fn inset(self, flank: f64, belly: f64, back: f64) -> Self {
        Self {
            half: [self.half[0] - flank, self.half[1] - (belly + back) / 2.0],
            centre_y: self.centre_y + (belly - back) / 2.0,
        }
    }

    /// Depth of `p` under the surface, mm, to first order in the axial plane; negative outside.
    pub(crate) fn depth(&self, p: Vec3) -> f64 {
        if self.is_deep(p) {
            return f64::INFINITY;
        }
        let flare = FLARE * (p[2] - WAIST_Z).powi(2);
        let r = [self.half[0] + flare, self.half[1] + flare];
        let x = p[0] / r[0];
        let y = self.furrowed(p, r[1]);
        // Outside its rectangle F comes down again and means nothing.
        if x.abs() >= 1.0 || y.abs() >= 1.0 {
            return -1.0;
        }
        let (xx, yy) = (x * x, y * y);
        let f = xx + yy - FULLNESS * xx * yy;
        let gx = 2.0 * x * (1.0 - FULLNESS * yy) / r[0];
        let gy = 2.0 * y * (1.0 - FULLNESS * xx) / r[1];
        (1.0 - f) / (gx * gx + gy * gy).sqrt()
    }

    /// True only where the depth is certainly 15 mm or more, deeper than every ramp: most of a trunk's voxels.
    ///
    /// Without division: the ellipse of the waist's half-axes, shrunk to 0.75, lies inside every outline; the furrow
    /// takes at most a tenth of a half-axis.
    fn is_deep(&self, p: Vec3) -> bool {
        let [a, b] = self.half.map(|r| r * r);
        let dy = p[1] - self.centre_y;
        p[0] * p[0] * b + dy * dy * a < 0.55 * a * b
    }

    /// Y with the back moved inwards near the median plane; the square keeps it smooth where the back begins.
    fn furrowed(&self, p: Vec3, ry: f64) -> f64 {
        let y = (p[1] - self.centre_y) / ry;
        let back = y.max(0.0);
        let u = p[0] / FURROW[1];
        let bump = 1.0 + u * u;
        y + FURROW[0] / ry * back * back / (bump * bump)
    }

    /// Unbounded along z: the scan's ends cut the trunk.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let flare = FLARE * 200.0 * 200.0;
        let r = [self.half[0] + flare, self.half[1] + flare];
        (
            [-r[0], self.centre_y - r[1], f64::NEG_INFINITY],
            [r[0], self.centre_y + r[1], f64::INFINITY],
        )
    }

    /// Where the ray from (`from_x`, `from_y`) in the axial plane `z` along (`toward`) leaves the surface; by bisection.
    pub(crate) fn exit(&self, from: Vec3, toward: [f64; 2]) -> Vec3 {
        let at = |s: f64| [from[0] + s * toward[0], from[1] + s * toward[1], from[2]];
        let (mut inside, mut outside) = (0.0, 400.0);
        for _ in 0..60 {
            let middle = (inside + outside) / 2.0;
            if self.depth(at(middle)) > 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        at(inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: TrunkWall = TrunkWall {
        half: [130.0, 80.0],
        centre_y: 3.0,
    };

    #[test]
    fn deep_is_deeper_than_any_ramp() {
        for degrees in 0..360 {
            let (s, c) = f64::from(degrees).to_radians().sin_cos();
            for z in [-130.0, 0.0, 60.0, 210.0] {
                let surface = WALL.exit([0.0, 3.0, z], [c, s]);
                let under = |mm: f64| [surface[0] - c * mm, surface[1] - s * mm, z];
                // 4 mm along a ray that meets the surface at a slant is still 2 mm and more of depth.
                assert!(!WALL.is_deep(under(4.0)), "{degrees} degrees at z {z}");
                assert!(WALL.depth(under(4.0)) > 2.0, "{degrees} degrees at z {z}");
            }
        }
    }

    #[test]
    fn depth_is_first_order_right() {
        for degrees in 0..360 {
            let (s, c) = f64::from(degrees).to_radians().sin_cos();
            let surface = WALL.exit([0.0, 3.0, 20.0], [c, s]);
            let depth = WALL.depth([surface[0] - 1e-3 * c, surface[1] - 1e-3 * s, 20.0]);
            assert!(depth > 0.4e-3 && depth < 1.2e-3, "{depth} at {degrees} degrees");
        }
    }
}
