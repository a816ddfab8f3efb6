//! What a chart shows: points with marks, joined or not.

use crate::Rgb;

/// How a point is marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Not at all: for lines.
    None,
    /// A filled circle.
    Dot,
    /// A small filled circle, for many points.
    Small,
    /// An open circle.
    Circle,
    /// An open square.
    Square,
    /// A cross.
    Cross,
    /// An open triangle.
    Triangle,
}

impl Mark {
    /// All marks.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Dot,
        Self::Small,
        Self::Circle,
        Self::Square,
        Self::Cross,
        Self::Triangle,
    ];
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; without a name it is not there.
    pub name: String,
    /// Of marks and lines.
    pub colour: Rgb,
    /// At each point.
    pub mark: Mark,
    /// Width of the line that joins the points in their order, pixels; 0 for none.
    pub line_width: f32,
    /// The line is dashed.
    pub dashed: bool,
    /// x and y in the axes' units.
    pub points: Vec<[f64; 2]>,
}

impl Series {
    /// Points that are not joined.
    pub fn scatter(
        name: impl Into<String>,
        colour: Rgb,
        mark: Mark,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        Self {
            name: name.into(),
            colour,
            mark,
            line_width: 0.0,
            dashed: false,
            points: points.into_iter().collect(),
        }
    }

    /// Points joined by a line in their order; it is broken where a point cannot be drawn.
    pub fn joined(
        name: impl Into<String>,
        colour: Rgb,
        mark: Mark,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        Self {
            line_width: 2.0,
            ..Self::scatter(name, colour, mark, points)
        }
    }

    /// The same with a dashed line.
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }
}
