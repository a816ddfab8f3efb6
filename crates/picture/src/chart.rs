//! Charts of measurements: points and lines over two axes, linear or logarithmic, with a legend.
//!
//! ```
//! use picture::Rgb;
//! use picture::chart::{Axis, Chart, Mark, Series};
//!
//! let mut chart = Chart::new("A cooling cup", Axis::linear("time, min"), Axis::log("above the room, K"));
//! let points = (0..8).map(|t| [f64::from(t), 60.0 * (-0.2 * f64::from(t)).exp()]);
//! chart.push(Series::joined("measured", Rgb(0, 90, 180), Mark::Dot, points));
//! let drawn = chart.draw(1000, 700);
//! assert_eq!((drawn.canvas.width(), drawn.skipped), (1000, 0));
//! ```

mod axis;
mod frame;
mod scale;
mod series;
mod span;

pub use axis::{Axis, Tick};
pub use scale::Scale;
pub use series::{Mark, Series};

use crate::{Canvas, Rgb};
use frame::Frame;
use span::Span;

/// Colours that tell series apart on white, for readers who see red and green alike too (Okabe and Ito 2008), and grey.
pub const COLOURS: [Rgb; 8] = [
    Rgb(0, 114, 178),
    Rgb(213, 94, 0),
    Rgb(0, 158, 115),
    Rgb(204, 121, 167),
    Rgb(230, 159, 0),
    Rgb(86, 180, 233),
    Rgb(0, 0, 0),
    Rgb(120, 120, 120),
];

/// A chart to be drawn: dark on white.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Above the chart.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upward.
    pub y: Axis,
    /// In the order of drawing, the last on top.
    pub series: Vec<Series>,
}

/// A chart as an image.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The image.
    pub canvas: Canvas,
    /// Points that could not be drawn: NaN, infinite, outside a range that was fixed, or not above zero on a logarithmic
    /// axis.
    pub skipped: usize,
}

impl Chart {
    /// A chart without series.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        let (title, series) = (title.into(), Vec::new());
        Self { title, x, y, series }
    }

    /// Adds a series on top of the others.
    pub fn push(&mut self, series: Series) {
        self.series.push(series);
    }

    /// Draws the chart; text is legible from 600 x 400 pixels, and nothing panics below that.
    ///
    /// Axes without a fixed range hold all points that can be drawn; without any they run from 0 to 1, or 1 to 10.
    pub fn draw(&self, width: u32, height: u32) -> Drawn {
        let mut canvas = Canvas::new(width, height);
        let spans = [self.span(0), self.span(1)];
        let frame = Frame::new(self, spans, [canvas.width(), canvas.height()]);
        frame.draw_axes(&mut canvas, self);
        let skipped = self.series.iter().map(|series| frame.draw_series(&mut canvas, series));
        let skipped = skipped.sum();
        frame.draw_legend(&mut canvas, self);
        // All is drawn in negative on black, so that the dark rim of text becomes a white one.
        for pixel in canvas.rgba_mut().chunks_exact_mut(4) {
            pixel[..3].iter_mut().for_each(|channel| *channel = 255 - *channel);
        }
        Drawn { canvas, skipped }
    }

    /// What axis 0 (x) or 1 (y) shows.
    fn span(&self, axis: usize) -> Span {
        let which = if axis == 0 { &self.x } else { &self.y };
        // A point counts for one axis only where the other can show it too.
        let usable = |p: &&[f64; 2]| self.x.scale.places(p[0]) && self.y.scale.places(p[1]);
        let points = self.series.iter().flat_map(|series| &series.points);
        Span::of((which.scale, which.range), points.filter(usable).map(|p| p[axis]))
    }
}

/// The colour that becomes `colour` once the image is inverted.
fn negative(Rgb(r, g, b): Rgb) -> Rgb {
    Rgb(255 - r, 255 - g, 255 - b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = Rgb(255, 0, 0);

    fn chart(x: Axis, y: Axis, points: &[[f64; 2]]) -> Chart {
        let mut chart = Chart::new("t", x, y);
        for mark in Mark::ALL {
            chart.push(Series::scatter("points", RED, mark, points.iter().copied()));
        }
        chart.push(Series::joined("line", RED, Mark::None, points.iter().copied()));
        chart
    }

    fn has(canvas: &Canvas, Rgb(r, g, b): Rgb) -> bool {
        canvas.rgba().chunks(4).any(|p| p == [r, g, b, 255])
    }

    #[test]
    fn points_are_drawn_in_their_colour_on_white() {
        let drawn = chart(Axis::linear("x"), Axis::linear("y"), &[[1.0, 2.0], [3.0, 4.0]]).draw(600, 400);
        assert_eq!(drawn.skipped, 0);
        assert_eq!(drawn.canvas.rgba()[..4], [255; 4]);
        assert!(has(&drawn.canvas, RED) && has(&drawn.canvas, Rgb(20, 20, 20)));
    }

    #[test]
    fn what_cannot_be_drawn_is_counted() {
        let bad = [
            [f64::NAN, 1.0],
            [1.0, f64::INFINITY],
            [0.0, 1.0],
            [-3.0, 1.0],
            [2.0, 1e305],
        ];
        // Each in every series: as many as there are marks, and the line.
        let each = Mark::ALL.len() + 1;
        let drawn = chart(Axis::log("x"), Axis::linear("y"), &bad).draw(600, 400);
        assert_eq!(drawn.skipped, 5 * each);
        let axis = Axis::linear("x").within(0.0, 1.0);
        let drawn = chart(axis, Axis::linear("y"), &[[0.5, 0.5], [1.5, 0.5]]).draw(600, 400);
        assert_eq!(drawn.skipped, each);
    }

    #[test]
    fn nothing_panics() {
        let sets: [&[[f64; 2]]; 6] = [
            &[],
            &[[f64::NAN; 2]],
            &[[0.0; 2]],
            &[[1e300, -1e300], [-1e300, 1e300]],
            &[[5e-324, 1e15], [1e300, 1e15 + 0.25]],
            &[[-7.0, -7.0]],
        ];
        let axes = [Axis::linear, Axis::log].map(|kind| kind("title"));
        for points in sets {
            for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                for [width, height] in [[1, 1], [30, 900], [1000, 700]] {
                    chart(axes[x].clone(), axes[y].clone(), points).draw(width, height);
                }
            }
        }
        for (low, high) in [(f64::NAN, 1.0), (3.0, -3.0), (1.0, 1.0), (0.0, f64::INFINITY)] {
            let axis = Axis::log("x").within(low, high);
            chart(axis.clone(), axis, &[[1.0; 2]]).draw(600, 400);
        }
    }

    #[test]
    fn the_same_chart_gives_the_same_pixels() {
        let draw = || chart(Axis::log("x"), Axis::log("y"), &[[1.0, 2.0], [30.0, 4.0]]).draw(400, 300);
        assert_eq!(draw().canvas.rgba(), draw().canvas.rgba());
    }
}
