//! Cubes on the lattice of pieces.

/// What of the organ is in a piece at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    Nothing,
    Part,
    All,
}

/// A cube on the lattice of pieces.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) nodes: [u32; 27],
    /// Its lowest corner and its side, in pieces.
    pub(super) corner: [i32; 3],
    pub(super) span: i32,
    /// What its pieces hold, fastest along x.
    pub(super) held: Vec<Held>,
    /// What all of them hold, if that is the same.
    pub(super) uniform: Option<Held>,
}

impl Placed {
    /// What a piece holds, counted from the cube's corner.
    #[inline]
    pub(super) fn held(&self, [x, y, z]: [i32; 3]) -> Held {
        self.uniform
            .unwrap_or_else(|| self.held[(x + self.span * (y + self.span * z)) as usize])
    }

    /// Whether some piece holds it.
    pub(super) fn holds(&self, wanted: Held) -> bool {
        self.uniform
            .map_or_else(|| self.held.contains(&wanted), |all| all == wanted)
    }
}
