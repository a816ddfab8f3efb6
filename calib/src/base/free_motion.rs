//! The motion of the base that touches say the least of.

use std::fmt;

/// A small motion of the base that the touches hardly see, in the base's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeMotion {
    /// Rotation vector, in units of one over the touches' radius.
    pub turn: [f64; 3],
    /// Translation; both together have norm 1.
    pub shift: [f64; 3],
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        let (what, v) = if size(&self.turn) > size(&self.shift) {
            ("turn about", self.turn)
        } else {
            ("slide along", self.shift)
        };
        let n = size(&v).sqrt();
        // Adding 0 takes the sign off -0, which would be printed.
        let [x, y, z] = v.map(|x| x / n + 0.0);
        write!(f, "a {what} ({x:.2}, {y:.2}, {z:.2}) in the base's axes")
    }
}
