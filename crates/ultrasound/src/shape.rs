//! The shape of an image: its size, its pixels, and where the beams run that it was made of.

/// Where the beams of an image begin and how they run, in mm of the image's plane from the centre of its first pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beams {
    /// A linear array: beams run down, side by side.
    Linear {
        /// The first and the last beam's place along a row.
        from_mm: f64,
        /// See `from_mm`.
        to_mm: f64,
        /// The row of the probe's face, where the depth is 0.
        face_mm: f64,
    },
    /// A curved array: beams come from one centre and leave the face square to it.
    Convex {
        /// The centre of the face's curve, which may lie above the image.
        centre_mm: [f64; 2],
        /// The radius of the face: the depth is 0 there.
        radius_mm: f64,
        /// How far the outermost beams lean to each side from straight down, above 0 and below a quarter turn.
        half_angle: f64,
    },
}

/// One place of an image as the probe measured it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// The unit direction in which the sound runs on, in the image's plane.
    pub direction: [f64; 2],
    /// The way from the probe's face, mm.
    pub depth_mm: f64,
    /// Which beam: 0 for the first (leftmost), 1 for the last.
    pub share: f64,
}

/// Size, pixels and beams of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    columns: usize,
    rows: usize,
    pixel_mm: [f64; 2],
    beams: Beams,
    depth_mm: f64,
}

/// Why a shape or an image is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// No pixels, or more than any scanner shows.
    #[error("an image of {columns} x {rows} pixels; allowed are 16 x 16 to 4096 x 4096")]
    Size {
        /// As given.
        columns: usize,
        /// As given.
        rows: usize,
    },
    /// Pixels whose sizes are none: metres, for one.
    #[error("pixels of {} x {} mm; allowed are 0.005 to 2 mm", .0[0], .0[1])]
    Pixel([f64; 2]),
    /// Beams that cannot be.
    #[error("{what} is {found}; {allowed}")]
    Beams {
        /// Which number.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// Another number of pixels than the shape has.
    #[error("{found} pixels for an image of {expected}")]
    Pixels {
        /// How many there are.
        found: usize,
        /// Columns times rows.
        expected: usize,
    },
}

const PIXEL_MM: std::ops::RangeInclusive<f64> = 0.005..=2.0;
const SIDE: std::ops::RangeInclusive<usize> = 16..=4096;
/// Beyond 400 mm nothing comes back at any frequency used on people.
const DEPTH_MM: std::ops::RangeInclusive<f64> = 1.0..=400.0;

impl Shape {
    /// A shape of numbers that came from outside.
    ///
    /// `depth_mm` is how far beams are shown, from the face.
    ///
    /// # Errors
    /// Each number that cannot be, with what it may be.
    pub fn new(size: [usize; 2], pixel_mm: [f64; 2], beams: Beams, depth_mm: f64) -> Result<Self, ShapeError> {
        let [columns, rows] = size;
        if !SIDE.contains(&columns) || !SIDE.contains(&rows) {
            return Err(ShapeError::Size { columns, rows });
        }
        if !pixel_mm.iter().all(|side| PIXEL_MM.contains(side)) {
            return Err(ShapeError::Pixel(pixel_mm));
        }
        let refuse = |what, found, allowed| Err(ShapeError::Beams { what, found, allowed });
        if !DEPTH_MM.contains(&depth_mm) {
            return refuse("the depth, mm,", depth_mm, "allowed are 1 to 400");
        }
        match beams {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => {
                if !(from_mm.is_finite() && to_mm.is_finite() && to_mm - from_mm >= 1.0) {
                    return refuse("the width of the array, mm,", to_mm - from_mm, "allowed is 1 and more");
                }
                if face_mm.is_nan() || face_mm.abs() > 1e3 {
                    return refuse("the row of the face, mm,", face_mm, "allowed are -1000 to 1000");
                }
            }
            Beams::Convex {
                centre_mm,
                radius_mm,
                half_angle,
            } => {
                if let Some(far) = centre_mm.into_iter().find(|place| place.is_nan() || place.abs() > 1e3) {
                    return refuse("the centre of the face, mm,", far, "allowed are -1000 to 1000");
                }
                if !(1.0..=200.0).contains(&radius_mm) {
                    return refuse("the radius of the face, mm,", radius_mm, "allowed are 1 to 200");
                }
                if !(0.01..=1.55).contains(&half_angle) {
                    return refuse(
                        "half the angle of the beams, rad,",
                        half_angle,
                        "allowed are 0.01 to 1.55",
                    );
                }
            }
        }
        Ok(Self {
            columns,
            rows,
            pixel_mm,
            beams,
            depth_mm,
        })
    }

    /// Pixels in a row.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The sizes of a pixel along a row and along a column, mm.
    #[must_use]
    pub fn pixel_mm(&self) -> [f64; 2] {
        self.pixel_mm
    }

    /// Where the beams run.
    #[must_use]
    pub fn beams(&self) -> Beams {
        self.beams
    }

    /// How far beams are shown, mm from the face.
    #[must_use]
    pub fn depth_mm(&self) -> f64 {
        self.depth_mm
    }

    /// The place of a pixel's centre in the plane, mm.
    #[must_use]
    pub fn place_mm(&self, pixel: [f64; 2]) -> [f64; 2] {
        [pixel[0] * self.pixel_mm[0], pixel[1] * self.pixel_mm[1]]
    }

    /// The pixel, with its fraction, of a place in the plane.
    #[must_use]
    pub fn pixel_at(&self, place_mm: [f64; 2]) -> [f64; 2] {
        [place_mm[0] / self.pixel_mm[0], place_mm[1] / self.pixel_mm[1]]
    }

    /// The beam through a place of the plane (mm); `None` where no beam that is shown runs.
    #[must_use]
    pub fn beam_at(&self, place_mm: [f64; 2]) -> Option<Beam> {
        let beam = match self.beams {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => Beam {
                direction: [0.0, 1.0],
                depth_mm: place_mm[1] - face_mm,
                share: (place_mm[0] - from_mm) / (to_mm - from_mm),
            },
            Beams::Convex {
                centre_mm,
                radius_mm,
                half_angle,
            } => {
                let [x, y] = [place_mm[0] - centre_mm[0], place_mm[1] - centre_mm[1]];
                let far = x.hypot(y);
                Beam {
                    direction: [x / far, y / far],
                    depth_mm: far - radius_mm,
                    share: 0.5 + 0.5 * x.atan2(y) / half_angle,
                }
            }
        };
        let shown = (0.0..=1.0).contains(&beam.share) && (0.0..=self.depth_mm).contains(&beam.depth_mm);
        shown.then_some(beam)
    }

    /// The place (mm) at `depth_mm` of the beam `share` (0 the leftmost, 1 the rightmost), with the beam's direction.
    #[must_use]
    pub fn along(&self, share: f64, depth_mm: f64) -> ([f64; 2], [f64; 2]) {
        match self.beams {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => ([from_mm + share * (to_mm - from_mm), face_mm + depth_mm], [0.0, 1.0]),
            Beams::Convex {
                centre_mm,
                radius_mm,
                half_angle,
            } => {
                let (sine, cosine) = ((2.0 * share - 1.0) * half_angle).sin_cos();
                let far = radius_mm + depth_mm;
                ([centre_mm[0] + far * sine, centre_mm[1] + far * cosine], [sine, cosine])
            }
        }
    }
}

/// Grey values of an image, row by row, with their shape.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a> {
    shape: &'a Shape,
    grey: &'a [u8],
}

impl<'a> Image<'a> {
    /// An image.
    ///
    /// # Errors
    /// Another number of values than the shape has pixels.
    pub fn new(shape: &'a Shape, grey: &'a [u8]) -> Result<Self, ShapeError> {
        let expected = shape.columns * shape.rows;
        match grey.len() == expected {
            true => Ok(Self { shape, grey }),
            false => Err(ShapeError::Pixels {
                found: grey.len(),
                expected,
            }),
        }
    }

    /// Its shape.
    #[must_use]
    pub fn shape(&self) -> &'a Shape {
        self.shape
    }

    /// Its grey values, row by row.
    #[must_use]
    pub fn grey(&self) -> &'a [u8] {
        self.grey
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> [Shape; 2] {
        let linear = Beams::Linear {
            from_mm: 2.0,
            to_mm: 40.0,
            face_mm: 3.0,
        };
        let convex = Beams::Convex {
            centre_mm: [40.0, -50.0],
            radius_mm: 60.0,
            half_angle: 0.6,
        };
        [linear, convex].map(|beams| Shape::new([400, 500], [0.2, 0.18], beams, 75.0).unwrap())
    }

    #[test]
    fn a_place_along_a_beam_lies_on_that_beam() {
        for shape in shapes() {
            for (share, depth) in [(0.0, 0.0), (0.25, 10.0), (0.5, 33.3), (1.0, 75.0)] {
                let (place, direction) = shape.along(share, depth);
                // Just inside of the borders, which rounding may leave.
                let inner = |value: f64, most: f64| value.clamp(most * 1e-9, most * (1.0 - 1e-9));
                let (inside, _) = shape.along(inner(share, 1.0), inner(depth, 75.0));
                let beam = shape.beam_at(inside).unwrap();
                assert!(
                    (beam.share - share).abs() < 1e-8 && (beam.depth_mm - depth).abs() < 1e-6,
                    "{beam:?}"
                );
                assert!((beam.direction[0] - direction[0]).abs() < 1e-8);
                let pixel = shape.pixel_at(place);
                let back = shape.place_mm(pixel);
                assert!((back[0] - place[0]).abs() + (back[1] - place[1]).abs() < 1e-12);
            }
            assert_eq!(shape.beam_at(shape.along(0.5, -0.1).0), None);
            assert_eq!(shape.beam_at(shape.along(1.01, 5.0).0), None);
            assert_eq!(shape.beam_at(shape.along(0.5, 75.1).0), None);
        }
    }

    #[test]
    fn what_is_no_shape_is_refused_with_its_number() {
        let linear = Beams::Linear {
            from_mm: 2.0,
            to_mm: 40.0,
            face_mm: 3.0,
        };
        let said = |size, pixel, beams, depth| Shape::new(size, pixel, beams, depth).unwrap_err().to_string();
        assert!(said([8, 500], [0.1, 0.1], linear, 50.0).contains("8 x 500"));
        assert!(said([400, 500], [0.0001, 0.1], linear, 50.0).contains("0.0001 x 0.1 mm"));
        assert!(said([400, 500], [0.1, f64::NAN], linear, 50.0).contains("NaN"));
        assert!(said([400, 500], [0.1, 0.1], linear, f64::INFINITY).contains("the depth, mm, is inf"));
        let narrow = Beams::Linear {
            from_mm: 2.0,
            to_mm: 2.0,
            face_mm: 3.0,
        };
        assert!(said([400, 500], [0.1, 0.1], narrow, 50.0).contains("width of the array"));
        let wide = Beams::Convex {
            centre_mm: [0.0; 2],
            radius_mm: 60.0,
            half_angle: 90.0,
        };
        assert!(said([400, 500], [0.1, 0.1], wide, 50.0).contains("rad, is 90"));
        assert!(
            Image::new(&shapes()[0], &[0; 7])
                .unwrap_err()
                .to_string()
                .contains("7 pixels for an image of 200000")
        );
    }
}
