//! Rectangles of whole pixels.

use egui::epaint::emath::Rect;

/// Pixels with `x0 <= x < x1` and `y0 <= y < y1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// The first column.
    pub x0: i32,
    /// The first row.
    pub y0: i32,
    /// The column after the last.
    pub x1: i32,
    /// The row after the last.
    pub y1: i32,
}

impl Area {
    /// No pixel, and less than that: the union with any area is that area.
    pub(crate) const NOTHING: Self = Self {
        x0: i32::MAX,
        y0: i32::MAX,
        x1: i32::MIN,
        y1: i32::MIN,
    };

    /// All of a screen.
    pub(crate) fn screen([columns, rows]: [u32; 2]) -> Self {
        Self {
            x0: 0,
            y0: 0,
            x1: i32::try_from(columns).unwrap_or(i32::MAX),
            y1: i32::try_from(rows).unwrap_or(i32::MAX),
        }
    }

    /// The pixels of a clip rectangle in points: rounded to whole pixels, as egui's painter for OpenGL does, and cut to `screen`.
    pub(crate) fn clip(rect: Rect, pixels_per_point: f32, screen: Self) -> Self {
        // The conversion saturates, and makes 0 of what is not a number.
        let round = |v: f32| (pixels_per_point * v).round() as i32;
        Self {
            x0: round(rect.min.x),
            y0: round(rect.min.y),
            x1: round(rect.max.x),
            y1: round(rect.max.y),
        }
        .intersect(screen)
    }

    /// The pixels in both.
    #[must_use]
    pub fn intersect(self, other: Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }

    /// The least area that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }

    /// Whether every pixel of `other` is in this one.
    pub fn holds(self, other: Self) -> bool {
        self.intersect(other) == other
    }

    /// Whether there is no pixel.
    pub fn is_empty(self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }

    /// Columns; 0 where there is no pixel.
    pub fn width(self) -> u32 {
        self.x1.saturating_sub(self.x0).max(0).unsigned_abs()
    }

    /// Rows; 0 where there is no pixel.
    pub fn height(self) -> u32 {
        self.y1.saturating_sub(self.y0).max(0).unsigned_abs()
    }
}

/// Memory of a screen with its width. Areas are those of the screen and not empty, or the slices are empty.
pub(crate) struct Canvas<'a> {
    pub(crate) pixels: &'a mut [u32],
    pub(crate) columns: usize,
}

impl Canvas<'_> {
    /// The pixels of row `y` with `x0 <= x < x1`.
    pub(crate) fn row(&mut self, y: i32, x0: i32, x1: i32) -> &mut [u32] {
        let (Ok(y), Ok(x0), Ok(x1)) = (usize::try_from(y), usize::try_from(x0), usize::try_from(x1)) else {
            return &mut [];
        };
        let start = y * self.columns;
        self.pixels.get_mut(start + x0..start + x1.max(x0)).unwrap_or_default()
    }
}
