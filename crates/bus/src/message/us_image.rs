//! An ultrasound image as a scanner delivers it: what travels in front of its grey values.

use iceoryx2::prelude::ZeroCopySend;
use ultrasound::{Beams, Shape, ShapeError};

use super::{CaptureClock, field_text, text_field};

/// Travels in front of the pixels: grey, 8 bits, row by row from the top.
///
/// On the wire: numbers only. Read it through [`UsImageHeader::shape`].
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/UsImageHeader/2")]
pub struct UsImageHeader {
    /// Counts the images of a run from 0.
    pub seq: u64,
    /// The scanner's own time of the image, ns; 0 where it stamps nothing.
    pub t_device_ns: i64,
    /// When the image was captured, as its source says, ns on the run's clock. How late that is beside the poses is
    /// for a calibration of the probe to find: nothing here knows it.
    pub t_capture_ns: i64,
    /// When it arrived, ns on the run's clock.
    pub t_arrival_ns: i64,
    /// When it was published, ns on the run's clock.
    pub t_publish_ns: i64,
    /// Sizes of a pixel along a row and along a column, mm; 0 where the source does not say.
    pub pixel_mm: [f64; 2],
    /// How far beams are shown from the probe's face, mm; 0 where the source does not say.
    pub depth_mm: f64,
    /// Of a linear array the first beam's place, the last one's and the face's row, mm, and 0; of a curved one the two
    /// coordinates of its centre, mm, its radius, mm, and half the angle of its beams, rad.
    pub beams: [f64; 4],
    /// [`UsImageHeader::UNKNOWN`], [`UsImageHeader::LINEAR`] or [`UsImageHeader::CONVEX`].
    pub array: u32,
    /// What `t_capture_ns` rests on: the code of a [`CaptureClock`].
    pub clock: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The scanner's name, UTF-8, zeros behind: read it through [`UsImageHeader::device_name`].
    pub device: [u8; 32],
    /// How rows and columns run, in PLUS's letters (`MF`), zeros behind; nothing where the source does not say: read it through
    /// [`UsImageHeader::orientation`].
    pub turned: [u8; 8],
}

const _: () = assert!(size_of::<UsImageHeader>() == 152 && align_of::<UsImageHeader>() == 8);

/// Why an image's numbers are none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UsImageError {
    /// The source does not say where beams run or how large pixels are.
    #[error("image {seq}: its source does not say where its beams run")]
    Unknown {
        /// The image.
        seq: u64,
    },
    /// A code that no version has.
    #[error("image {seq}: an array of kind {found}; known are 0 to 2")]
    Array {
        /// The image.
        seq: u64,
        /// The code.
        found: u32,
    },
    /// Numbers that cannot be.
    #[error("image {seq}: {why}")]
    Shape {
        /// The image.
        seq: u64,
        /// Which, and what they may be.
        why: ShapeError,
    },
}

impl UsImageHeader {
    /// The source does not say where beams run.
    pub const UNKNOWN: u32 = 0;
    /// Beams run side by side.
    pub const LINEAR: u32 = 1;
    /// Beams come from one centre.
    pub const CONVEX: u32 = 2;
    /// Pixels of the largest image that is passed on: 4 MiB.
    pub const MOST_PIXELS: usize = 1 << 22;

    /// Of an image of this shape, with everything else to be filled in.
    pub fn of(shape: &Shape) -> Self {
        let (array, beams) = match shape.beams() {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => (Self::LINEAR, [from_mm, to_mm, face_mm, 0.0]),
            Beams::Convex {
                centre_mm: [x, y],
                radius_mm,
                half_angle,
            } => (Self::CONVEX, [x, y, radius_mm, half_angle]),
        };
        Self {
            pixel_mm: shape.pixel_mm(),
            depth_mm: shape.depth_mm(),
            beams,
            array,
            // A shape has at most 4096 columns and rows.
            width: shape.columns() as u32,
            height: shape.rows() as u32,
            ..Self::default()
        }
    }

    /// Where beams run: the door from the bus to the image's plane.
    ///
    /// # Errors
    /// [`UsImageError`], also where the source does not say.
    pub fn shape(&self) -> Result<Shape, UsImageError> {
        let seq = self.seq;
        let [a, b, c, half_angle] = self.beams;
        let beams = match self.array {
            Self::UNKNOWN => return Err(UsImageError::Unknown { seq }),
            Self::LINEAR => Beams::Linear {
                from_mm: a,
                to_mm: b,
                face_mm: c,
            },
            Self::CONVEX => Beams::Convex {
                centre_mm: [a, b],
                radius_mm: c,
                half_angle,
            },
            found => return Err(UsImageError::Array { seq, found }),
        };
        let size = [self.width as usize, self.height as usize];
        Shape::new(size, self.pixel_mm, beams, self.depth_mm).map_err(|why| UsImageError::Shape { seq, why })
    }

    /// What the time of capture rests on; `None` for a code that is not known.
    pub fn capture_clock(&self) -> Option<CaptureClock> {
        CaptureClock::from_code(self.clock)
    }

    /// The scanner's name.
    pub fn device_name(&self) -> String {
        field_text(&self.device)
    }

    /// The same with a scanner's name, as far as it fits.
    #[must_use]
    pub fn with_device(self, name: &str) -> Self {
        Self {
            device: text_field(name),
            ..self
        }
    }

    /// How rows and columns run, as the source says, in PLUS's letters; `None` where it does not say.
    pub fn orientation(&self) -> Option<String> {
        Some(field_text(&self.turned)).filter(|text| !text.is_empty())
    }

    /// The same with how rows and columns run, as far as it fits.
    #[must_use]
    pub fn turned(self, orientation: &str) -> Self {
        Self {
            turned: text_field(orientation),
            ..self
        }
    }

    /// How many grey values belong to it.
    pub(crate) fn pixels(&self) -> Option<usize> {
        (self.width as usize).checked_mul(self.height as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_goes_over_the_bus_to_the_bit() {
        let linear = Beams::Linear {
            from_mm: 1.5,
            to_mm: 40.25,
            face_mm: 2.0,
        };
        let convex = Beams::Convex {
            centre_mm: [30.0, -41.5],
            radius_mm: 60.0,
            half_angle: 0.52,
        };
        for beams in [linear, convex] {
            let shape = Shape::new([300, 417], [0.1, 0.11], beams, 45.0).unwrap();
            assert_eq!(UsImageHeader::of(&shape).shape(), Ok(shape));
        }
    }

    #[test]
    fn what_is_no_shape_is_refused_with_the_image_s_number() {
        let linear = Beams::Linear {
            from_mm: 0.0,
            to_mm: 40.0,
            face_mm: 0.0,
        };
        let good = UsImageHeader {
            seq: 7,
            ..UsImageHeader::of(&Shape::new([300, 417], [0.1, 0.1], linear, 40.0).unwrap())
        };
        let words = |header: UsImageHeader| header.shape().unwrap_err().to_string();
        let nan = [f64::NAN, 0.1];
        assert!(words(UsImageHeader { pixel_mm: nan, ..good }).starts_with("image 7: pixels of NaN"));
        assert!(words(UsImageHeader { array: 3, ..good }).contains("kind 3"));
        assert!(words(UsImageHeader { array: 0, ..good }).contains("does not say"));
        assert!(words(UsImageHeader { width: 0, ..good }).contains("0 x 417"));
        assert!(words(UsImageHeader { depth_mm: -1.0, ..good }).contains("depth"));
    }
}
