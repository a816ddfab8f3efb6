//! The faces of the pieces of a cube that has two of them an axis.

/// A face between two pieces, or of one and what is beyond the cube.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// Its corners at x + 3 y + 9 z: the lowest, the next along both of its axes, in the order of axes, and the highest.
    pub(super) corners: [usize; 4],
    /// Their bits.
    pub(super) bits: u32,
    /// The bits of the pieces below and above it, at x + 2 y + 4 z: 0 beyond the cube.
    pub(super) pieces: [u8; 2],
}

/// All of them.
pub(super) const FACES: [Face; 36] = faces();

const fn faces() -> [Face; 36] {
    let none = Face {
        corners: [0; 4],
        bits: 0,
        pieces: [0; 2],
    };
    let mut faces = [none; 36];
    let mut k = 0;
    while k < 36 {
        // By axis, place along it, and the two steps beside it.
        let (axis, along, b, c) = (k / 12, k / 4 % 3, k % 2, k / 2 % 2);
        let corner = [1, 3, 9];
        let piece = [1, 2, 4];
        let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
        let low = along * corner[axis] + b * corner[one] + c * corner[other];
        let corners = [
            low,
            low + corner[one],
            low + corner[other],
            low + corner[one] + corner[other],
        ];
        let beside = b * piece[one] + c * piece[other];
        faces[k] = Face {
            corners,
            bits: 1 << corners[0] | 1 << corners[1] | 1 << corners[2] | 1 << corners[3],
            pieces: [
                if along > 0 {
                    1 << (beside + (along - 1) * piece[axis])
                } else {
                    0
                },
                if along < 2 {
                    1 << (beside + along * piece[axis])
                } else {
                    0
                },
            ],
        };
        k += 1;
    }
    faces
}
