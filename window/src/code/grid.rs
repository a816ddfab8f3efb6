//! The squares of a cell, and how they are read off pixels.

use std::ops::RangeInclusive;

use super::{Code, check_sum};

/// Squares from left to right, the quiet frame of one white square on each side with them.
pub const COLUMNS: u32 = DATA_COLUMNS + 2;
/// Squares from top to bottom, with the quiet frame.
pub const ROWS: u32 = DATA_ROWS + 2;
/// The side of a square, pixels of the screen. Below, its edges would be most of it.
pub const SQUARE_PX: RangeInclusive<u32> = 3..=64;

const DATA_COLUMNS: u32 = 12;
const DATA_ROWS: u32 = 8;
/// Of the word; the check sum follows.
const WORD_BITS: u32 = 64;
/// The brightest that is black, and the darkest that is white, of 255. Between them is nothing that a window paints.
const BLACK: u8 = 80;
const WHITE: u8 = 175;

const _: () = assert!(DATA_COLUMNS * DATA_ROWS == WORD_BITS + 32);

/// The squares of one code, row by row, with their quiet frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid(pub(super) u128);

/// Why there is no code in the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unread {
    /// The pixels are not those of a whole cell.
    #[error("the cell does not lie on the screen as a whole")]
    Size,
    /// A square is neither black nor white all over: something else is painted there, or two pictures meet in it.
    #[error("something other than the window's cell is on the screen in its place")]
    Grey,
    /// The frame of white squares is not there.
    #[error("the cell is not where the window says, or something lies over it")]
    Frame,
    /// The check sum is another: two pictures at once, the cell of another run, or something that happens to be black and white.
    #[error("the cell is torn, or another run's")]
    CheckSum,
    /// Check sum and code do not belong to this version.
    #[error("the cell is of another version of the window")]
    Version,
}

impl Grid {
    pub(super) fn of(word: u64, key: u32) -> Self {
        Self(u128::from(word) << 32 | u128::from(sum(word, key)))
    }

    /// Whether the square is white; what lies outside the cell is.
    pub fn is_white(self, column: u32, row: u32) -> bool {
        let inner = (1..=DATA_COLUMNS).contains(&column) && (1..=DATA_ROWS).contains(&row);
        !inner || self.0 >> place(column - 1, row - 1) & 1 == 1
    }

    /// The cell as an image, 4 bytes RGBA a pixel, `COLUMNS * square` wide and `ROWS * square` high.
    pub fn rgba(self, square: u32) -> Vec<u8> {
        let (width, height) = (COLUMNS * square, ROWS * square);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let grey = pixels.map(|(x, y)| self.is_white(x / square.max(1), y / square.max(1)));
        grey.flat_map(|white| if white { [255; 4] } else { [0, 0, 0, 255] })
            .collect()
    }

    /// The code in the pixels of a cell, for the run with this [`key`](super::key): 4 bytes a pixel, of which the first three are its
    /// colours in any order, row after row without a gap.
    ///
    /// # Errors
    /// [`Unread`]. Neither the number nor the contents of the bytes can make this panic.
    pub fn read(pixels: &[u8], square: u32, key: u32) -> Result<Code, Unread> {
        let squares = Self::squares(pixels, square)?;
        let (word, found) = ((squares.0 >> 32) as u64, squares.0 as u32);
        if found != sum(word, key) {
            return Err(Unread::CheckSum);
        }
        Code::of_word(word).ok_or(Unread::Version)
    }

    fn squares(pixels: &[u8], square: u32) -> Result<Self, Unread> {
        let width = (COLUMNS * square) as usize;
        if !SQUARE_PX.contains(&square) || pixels.len() != width * (ROWS * square) as usize * 4 {
            return Err(Unread::Size);
        }
        let mut squares = 0;
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let white = is_white(pixels, width, [column, row], square).ok_or(Unread::Grey)?;
                let inner = (1..=DATA_COLUMNS).contains(&column) && (1..=DATA_ROWS).contains(&row);
                match (inner, white) {
                    (true, true) => squares |= 1 << place(column - 1, row - 1),
                    (false, false) => return Err(Unread::Frame),
                    _ => {}
                }
            }
        }
        Ok(Self(squares))
    }
}

/// The bit of a square: the first is the highest of the word.
fn place(column: u32, row: u32) -> u32 {
    WORD_BITS + 31 - (row * DATA_COLUMNS + column)
}

fn sum(word: u64, key: u32) -> u32 {
    let mut bytes = [0; 12];
    bytes[..8].copy_from_slice(&word.to_be_bytes());
    bytes[8..].copy_from_slice(&key.to_be_bytes());
    check_sum::of(&bytes)
}

/// The colour of a square; `None` where its pixels are not all black or all white. Its outermost pixels may be of any colour:
/// painters smooth edges.
fn is_white(pixels: &[u8], width: usize, [column, row]: [u32; 2], square: u32) -> Option<bool> {
    let inside = |at: u32| (at * square + 1) as usize..((at + 1) * square - 1) as usize;
    let mut colour = None;
    for y in inside(row) {
        for x in inside(column) {
            let at = (y * width + x) * 4;
            let [a, b, c] = [pixels[at], pixels[at + 1], pixels[at + 2]];
            let white = match (a.min(b).min(c), a.max(b).max(c)) {
                (darkest, _) if darkest >= WHITE => true,
                (_, brightest) if brightest <= BLACK => false,
                _ => return None,
            };
            if *colour.get_or_insert(white) != white {
                return None;
            }
        }
    }
    colour
}
