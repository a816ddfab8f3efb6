//! Where the cell lies in its window, as a property of the window says it.

use super::{COLUMNS, ROWS, SQUARE_PX, VERSION};

/// The window's property: a list of CARDINALs of 32 bits, in the order of [`Place::to_cardinals`].
pub const PROPERTY: &str = "_TROCAR_CODE";
/// Coordinates in X are of 16 bits.
const FARTHEST: u32 = 32_767;

/// Where the cell lies, and whose it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Its upper left corner in the window, pixels.
    pub at: [u32; 2],
    /// The side of a square, pixels.
    pub square: u32,
    /// The run's [`key`](super::key).
    pub key: u32,
    /// The process that paints it.
    pub pid: u32,
}

/// Why a property says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// Too few or too many numbers.
    #[error("{0} numbers; 8 are needed")]
    Length(usize),
    /// Another layout.
    #[error("version {0} of the cell; this program reads version {VERSION}")]
    Version(u32),
    /// A number is out of bounds, or the grid is another.
    #[error(
        "a cell of {columns} x {rows} squares of {square} px at ({x}, {y}); {COLUMNS} x {ROWS} of 3 to 64 px are read"
    )]
    Bounds {
        /// Squares from left to right.
        columns: u32,
        /// Squares from top to bottom.
        rows: u32,
        /// Their side, pixels.
        square: u32,
        /// Left edge in the window, pixels.
        x: u32,
        /// Upper edge, pixels.
        y: u32,
    },
}

impl Place {
    /// x, y, square, columns, rows, version, key of the run, process: what [`PROPERTY`] is to hold.
    pub fn to_cardinals(self) -> [u32; 8] {
        let [x, y] = self.at;
        [x, y, self.square, COLUMNS, ROWS, VERSION, self.key, self.pid]
    }

    /// The place that a property names.
    ///
    /// # Errors
    /// [`PlaceError`]: anybody may write anything into a property.
    pub fn of_cardinals(cardinals: &[u32]) -> Result<Self, PlaceError> {
        let &[x, y, square, columns, rows, version, key, pid] = cardinals else {
            return Err(PlaceError::Length(cardinals.len()));
        };
        if version != VERSION {
            return Err(PlaceError::Version(version));
        }
        let is_ours = (columns, rows) == (COLUMNS, ROWS) && SQUARE_PX.contains(&square);
        if !is_ours || x > FARTHEST || y > FARTHEST {
            return Err(PlaceError::Bounds {
                columns,
                rows,
                square,
                x,
                y,
            });
        }
        let at = [x, y];
        Ok(Self { at, square, key, pid })
    }

    /// Width and height of the cell, pixels.
    pub fn size(self) -> [u32; 2] {
        [COLUMNS * self.square, ROWS * self.square]
    }
}
