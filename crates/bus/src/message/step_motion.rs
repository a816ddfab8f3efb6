//! What a motion that is listened to covers, for a picture of it.

use iceoryx2::prelude::ZeroCopySend;

/// A pivoting or a spinning so far. Angles are rad; what is not known is NaN.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct StepMotion {
    /// How far it reaches in each direction in which the handle can be tilted, the least over each sector; sector `k` is about `k` of
    /// [`StepMotion::SECTORS`] of a round from the right to the top, as seen along the shaft from the handle. Of a spinning, all alike.
    pub reach_rad: [f64; Self::SECTORS],
    /// What the gate is on: the half opening of the cone; of a spinning twice the root mean square turn.
    pub reached_rad: f64,
    /// What is needed of it.
    pub needed_rad: f64,
    /// Where the handle is: to the right and to the top; of a spinning how far it is turned, and 0.
    pub now_rad: [f64; 2],
    /// Cells where it was, 64 a number: `ring * SECTORS + sector`, a ring being a quarter of what is needed; of a spinning, of 5 degrees
    /// from half a round back.
    pub cells: [u64; 2],
    /// Code of a [`StepMotionKind`]; 0: there is none.
    pub kind: u32,
    /// Which axis of the marker points to the top, from 0.
    pub up: u32,
}

const _: () = assert!(size_of::<StepMotion>() == 8 * (StepMotion::SECTORS + 6) + 8);

/// Which motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepMotionKind {
    /// Turning about the tip to all sides.
    Pivot,
    /// Turning about the shaft.
    Spin,
}

impl StepMotion {
    /// Sectors of a round.
    pub const SECTORS: usize = 24;
    /// Rings of cells.
    pub const RINGS: usize = 5;
    /// Cells of a spinning.
    pub const TURN_CELLS: usize = 72;
    /// There is none.
    pub const NONE: Self = Self {
        reach_rad: [f64::NAN; Self::SECTORS],
        reached_rad: f64::NAN,
        needed_rad: f64::NAN,
        now_rad: [f64::NAN; 2],
        cells: [0; 2],
        kind: 0,
        up: 0,
    };

    /// Which motion; `None` where there is none, or one of a later version.
    pub const fn kind(&self) -> Option<StepMotionKind> {
        match self.kind {
            1 => Some(StepMotionKind::Pivot),
            2 => Some(StepMotionKind::Spin),
            _ => None,
        }
    }

    /// Whether a sector is reached. What is not a number is not.
    pub fn is_reached(&self, sector: usize) -> bool {
        self.reach_rad
            .get(sector)
            .is_some_and(|reach| *reach >= self.needed_rad)
    }

    /// Whether all are.
    pub fn is_complete(&self) -> bool {
        self.kind().is_some() && (0..Self::SECTORS).all(|sector| self.is_reached(sector))
    }

    /// Whether it was in a cell.
    pub const fn was_in(&self, cell: usize) -> bool {
        cell < 128 && self.cells[cell / 64] >> (cell % 64) & 1 == 1
    }
}

impl StepMotionKind {
    /// Its code on the wire, from 1.
    pub const fn code(self) -> u32 {
        self as u32 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_reached_of_no_motion_and_of_numbers_that_are_none() {
        let full = StepMotion {
            reach_rad: [0.5; StepMotion::SECTORS],
            needed_rad: 0.5,
            kind: StepMotionKind::Pivot.code(),
            ..StepMotion::NONE
        };
        assert!(full.is_complete() && !StepMotion::NONE.is_complete());
        for kind in [0, 3, u32::MAX] {
            assert!(!StepMotion { kind, ..full }.is_complete());
        }
        let needed_rad = f64::NAN;
        assert!(!StepMotion { needed_rad, ..full }.is_complete());
        for sector in 0..StepMotion::SECTORS {
            let mut one = full;
            one.reach_rad[sector] = f64::NAN;
            assert!(!one.is_complete() && !one.is_reached(StepMotion::SECTORS));
        }
        let cells = StepMotion {
            cells: [1, 1 << 63],
            ..full
        };
        assert!(cells.was_in(0) && cells.was_in(127) && !cells.was_in(1) && !cells.was_in(9999));
    }
}
