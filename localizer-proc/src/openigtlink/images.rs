//! Ultrasound images of the peer, as the bus has them.
//!
//! A message says size and grey values, its matrix how large pixels are where its sender has set it, and nothing says how rows and columns
//! run, how deep the image goes or where its beams run: the scene does. An image that is not just what the scene says is none.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use bus::message::UsImageHeader;
use igtl::{Image, Message, Scalar, Stamp};
use scene::localizer::{ImagesSpec, ShownBeams};
use ultrasound::{Beams, Shape, ShapeError};

use super::{names, stamp_ns};

/// Bytes of a body with the largest image that is passed on, and its metadata.
pub(super) const MOST_BYTES: u64 = (UsImageHeader::MOST_PIXELS as u64) + (128 << 10);
/// Pixels of a message that differ by more than this share from the scene's were made at another depth.
const OTHER_PIXELS: f64 = 0.02;

/// An image is held against so many before it: what grabs a frozen screen may hand on its fields in turn.
const HELD: usize = 8;

/// Stamps that are not newer, but go on for so long, are of a clock that was set back: none of a picture that stands still, or came late, does, ns.
const SET_BACK_NS: i64 = 2_000_000_000;

/// An image with what it is of; numbers and times of the run are still to be filled in.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The scanner's stamp, ns of its clock; 0 where it states none.
    pub device_ns: i64,
    /// When its last byte had arrived, ns on the run's clock.
    pub arrival_ns: i64,
    /// Size, pixels, beams, orientation and name.
    pub header: UsImageHeader,
    /// Row by row from the top.
    pub grey: Vec<u8>,
}

/// Why a message's image is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum ImageError {
    #[error(
        "{components} components of {scalar} a pixel; 1 of uint8 is taken: let the peer send grey images of 8 bits"
    )]
    Grey { components: u8, scalar: &'static str },
    #[error("{} x {} x {} voxels; one slice is an image", .0[0], .0[1], .0[2])]
    Deep([u16; 3]),
    #[error("a part of an image: {size:?} of {whole:?} voxels")]
    Part { size: [u16; 3], whole: [u16; 3] },
    #[error("{columns} x {rows} pixels; at most {} are taken", UsImageHeader::MOST_PIXELS)]
    Large { columns: u16, rows: u16 },
    #[error(
        "its message says pixels of {} x {} mm, and localizer.images.pixel_mm {} x {}: was the depth changed?",
        found[0], found[1], expected[0], expected[1]
    )]
    Pixels { found: [f64; 2], expected: [f64; 2] },
    #[error(
        "neither its message nor localizer.images.pixel_mm says how large its pixels are, and its beams are told in mm"
    )]
    NoPixels,
    #[error(transparent)]
    Shape(#[from] ShapeError),
    #[error("its stamp is that of the image before, or an earlier one: a frozen picture, or one that comes too late")]
    NotNewer,
    #[error("it is one of the {HELD} images before once more, byte for byte: is the scanner frozen?")]
    Frozen,
}

/// The images that the scene asks for.
#[derive(Debug, Clone)]
pub(super) struct Images {
    spec: ImagesSpec,
    /// On the wire.
    name: Vec<u8>,
    order: Order,
    /// The last ones, by what their grey values come to.
    last: VecDeque<u64>,
}

/// The order of stamps.
#[derive(Debug, Clone, Copy, Default)]
struct Order {
    newest: Option<Stamp>,
    /// Of stamps that are not newer, and go on: when the first of them came, ns, and the last of them.
    behind: Option<(i64, Stamp)>,
}

impl Order {
    /// Whether an image is newer than all before, or else of a clock that was set back.
    fn takes(&mut self, stamp: Stamp, now_ns: i64) -> bool {
        let behind = std::mem::take(&mut self.behind);
        if self.newest.is_none_or(|newest| stamp > newest) {
            self.newest = Some(stamp);
            return true;
        }
        let since_ns = match behind {
            Some((since_ns, last)) if stamp > last => since_ns,
            _ => now_ns,
        };
        if now_ns.saturating_sub(since_ns) >= SET_BACK_NS {
            self.newest = Some(stamp);
            return true;
        }
        self.behind = Some((since_ns, stamp));
        false
    }
}

impl Images {
    pub(super) fn new(spec: &ImagesSpec) -> Self {
        Self {
            name: names::cut(&spec.name),
            spec: spec.clone(),
            order: Order::default(),
            last: VecDeque::with_capacity(HELD + 1),
        }
    }

    /// Another connection: its stamps may begin anew.
    pub(super) fn forget(&mut self) {
        self.order = Order::default();
    }

    /// The image of a message; `None` where it has another name than the scene's.
    pub(super) fn take(
        &mut self,
        message: &Message<'_>,
        image: &Image<'_>,
        now_ns: i64,
    ) -> Option<Result<Picture, ImageError>> {
        (message.device.as_bytes() == self.name).then(|| self.picture(message, image, now_ns))
    }

    fn picture(&mut self, message: &Message<'_>, image: &Image<'_>, now_ns: i64) -> Result<Picture, ImageError> {
        let header = self.header(image)?;
        // A peer that sends a frozen picture again packs it with the stamp that it had.
        if message.stamp != Stamp::NONE && !self.order.takes(message.stamp, now_ns) {
            return Err(ImageError::NotNewer);
        }
        // One that stamps what it grabs of a frozen screen gives it a new one, but speckle and noise never come twice. Where all is of one
        // value, as of a probe in the air, there are none, and no bone.
        let grey = hash(&image.voxels);
        if self.last.contains(&grey) && image.voxels.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(ImageError::Frozen);
        }
        self.last.push_back(grey);
        if self.last.len() > HELD {
            self.last.pop_front();
        }
        Ok(Picture {
            device_ns: stamp_ns(message.stamp),
            arrival_ns: now_ns,
            header: header.with_device(&self.spec.name).turned(&self.spec.orientation),
            grey: image.voxels.to_vec(),
        })
    }

    fn header(&self, image: &Image<'_>) -> Result<UsImageHeader, ImageError> {
        let [columns, rows, slices] = image.dimensions;
        if (image.components, image.scalar) != (1, Scalar::Uint8) {
            let (components, scalar) = (image.components, image.scalar.word());
            return Err(ImageError::Grey { components, scalar });
        }
        if slices != 1 {
            return Err(ImageError::Deep(image.dimensions));
        }
        if image.size != image.dimensions {
            return Err(ImageError::Part {
                size: image.size,
                whole: image.dimensions,
            });
        }
        if usize::from(columns) * usize::from(rows) > UsImageHeader::MOST_PIXELS {
            return Err(ImageError::Large { columns, rows });
        }
        let pixel_mm = self.pixel_mm(image)?;
        let size = [usize::from(columns), usize::from(rows)];
        match (self.spec.shown, pixel_mm) {
            (Some((depth_mm, beams)), Some(pixel_mm)) => {
                let shape = Shape::new(size, pixel_mm, beams_of(beams), depth_mm)?;
                Ok(UsImageHeader::of(&shape))
            }
            (Some(_), None) => Err(ImageError::NoPixels),
            // Nobody says where its beams run.
            (None, pixel_mm) => Ok(UsImageHeader {
                pixel_mm: pixel_mm.unwrap_or_default(),
                width: columns.into(),
                height: rows.into(),
                ..UsImageHeader::default()
            }),
        }
    }

    /// Sizes of a pixel, by the scene and the message, whichever says them. Steps of 1 mm are what a sender writes that does not know.
    fn pixel_mm(&self, image: &Image<'_>) -> Result<Option<[f64; 2]>, ImageError> {
        let length = |step: [f32; 3]| step.map(f64::from).iter().map(|mm| mm * mm).sum::<f64>().sqrt();
        let [along, down, _] = image.placed.columns;
        let steps = [length(along), length(down)];
        let says_nothing = steps.iter().all(|mm| *mm == 0.0 || (mm - 1.0).abs() < 1e-5);
        let Some(expected) = self.spec.pixel_mm else {
            return Ok((!says_nothing).then_some(steps));
        };
        let is_other = (0..2).any(|i| (steps[i] / expected[i] - 1.0).abs() > OTHER_PIXELS);
        match !says_nothing && is_other {
            true => Err(ImageError::Pixels { found: steps, expected }),
            false => Ok(Some(expected)),
        }
    }
}

/// Two images of another picture come to one number once in 1.8e19.
fn hash(grey: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    grey.hash(&mut hasher);
    hasher.finish()
}

fn beams_of(beams: ShownBeams) -> Beams {
    match beams {
        ShownBeams::Linear {
            from_mm,
            to_mm,
            face_mm,
        } => Beams::Linear {
            from_mm,
            to_mm,
            face_mm,
        },
        ShownBeams::Convex {
            centre_mm,
            radius_mm,
            half_angle_rad,
        } => Beams::Convex {
            centre_mm,
            radius_mm,
            half_angle: half_angle_rad,
        },
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::time::Duration;

    use igtl::{Body, ByteOrder, DeviceName, Matrix, Space};

    use super::*;

    fn spec() -> ImagesSpec {
        let beams = ShownBeams::Linear {
            from_mm: 0.0,
            to_mm: 3.0,
            face_mm: 0.0,
        };
        ImagesSpec {
            name: "UltrasoundImageOfThe1stProbe".to_owned(),
            orientation: "MF".to_owned(),
            pixel_mm: Some([0.1, 0.2]),
            shown: Some((8.0, beams)),
            latest: Duration::from_millis(300),
        }
    }

    fn image(size: [u16; 3], steps: [f32; 2]) -> Image<'static> {
        let [along, down] = steps;
        let voxels: Vec<u8> = (0..size.iter().map(|n| usize::from(*n)).product::<usize>())
            .map(|i| i as u8)
            .collect();
        Image {
            components: 1,
            scalar: Scalar::Uint8,
            order: ByteOrder::Big,
            space: Space::Ras,
            dimensions: size,
            placed: Matrix {
                // A sender turns the image as it likes: only lengths are read.
                columns: [[0.0, along, 0.0], [0.0, 0.0, -down], [1.0, 0.0, 0.0]],
                ..Matrix::IDENTITY
            },
            offset: [0; 3],
            size,
            voxels: Cow::Owned(voxels),
        }
    }

    fn taken(images: &mut Images, image: &Image<'static>, stamp: Stamp) -> Result<Picture, ImageError> {
        taken_at(images, image, stamp, 7)
    }

    fn taken_at(images: &mut Images, image: &Image<'static>, stamp: Stamp, now_ns: i64) -> Result<Picture, ImageError> {
        let name = DeviceName::new("UltrasoundImageOfThe").unwrap();
        let mut message = Message::new(name, Body::Image(image.clone()));
        message.stamp = stamp;
        images.take(&message, image, now_ns).unwrap()
    }

    #[test]
    fn an_image_is_what_scene_and_message_say_and_nothing_is_turned() {
        let mut images = Images::new(&spec());
        let stamp = Stamp::of_ns(1_790_000_000_000_000_000).unwrap();
        let one = image([32, 40, 1], [1.0, 1.0]);
        let picture = taken(&mut images, &one, stamp).unwrap();
        assert_eq!(picture.grey, *one.voxels);
        assert_eq!((picture.device_ns, picture.arrival_ns), (1_790_000_000_000_000_000, 7));
        assert_eq!(picture.header.orientation().as_deref(), Some("MF"));
        let shape = picture.header.shape().unwrap();
        assert_eq!((shape.columns(), shape.rows(), shape.pixel_mm()), (32, 40, [0.1, 0.2]));
        let other = Message::new(DeviceName::new("Image").unwrap(), Body::Image(one.clone()));
        assert!(images.take(&other, &one, 7).is_none());
    }

    /// An image that says its number.
    fn numbered(number: u8) -> Image<'static> {
        let mut image = image([32, 40, 1], [1.0, 1.0]);
        image.voxels.to_mut()[0] = number;
        image
    }

    /// A picture that stood still for one to two seconds and was sent again was a new one.
    #[test]
    fn a_stamp_that_is_not_newer_is_refused_however_old_until_a_clock_that_was_set_back_is_seen_to_go_on() {
        const MS: i64 = 1_000_000;
        let at = |ms: i64| Stamp::of_ns((1_790_000_000_000 + ms).unsigned_abs() * 1_000_000).unwrap();
        for back_ms in [0, 1, 900, 1000, 1100, 1500, 1999, 3000, 3_600_000] {
            let mut images = Images::new(&spec());
            assert!(taken(&mut images, &numbered(0), at(0)).is_ok());
            // Sent again and again, for a minute: packed once, so that it has the stamp that it had.
            for k in 1..1500 {
                let again = taken_at(&mut images, &numbered(k as u8), at(-back_ms), k * 40 * MS);
                assert_eq!(again, Err(ImageError::NotNewer), "{back_ms} {k}");
            }
            assert!(taken(&mut images, &numbered(1), at(60_000)).is_ok());
        }
        // A clock that was set back, or one stamp of nonsense: images go on after 2 s, and their time is for the law to judge.
        let mut images = Images::new(&spec());
        assert!(taken(&mut images, &numbered(255), at(3_000_000_000)).is_ok());
        let found = (0..100).find(|k| taken_at(&mut images, &numbered(*k as u8), at(k * 40), k * 40 * MS).is_ok());
        assert_eq!(found, Some(50));
        assert!(taken(&mut images, &numbered(200), at(51 * 40)).is_ok());
        // Another connection begins anew.
        images.forget();
        assert!(taken(&mut images, &numbered(201), at(0)).is_ok());
    }

    /// A frozen screen that was grabbed as two fields in turn was a live image.
    #[test]
    fn pictures_that_come_in_turn_are_frozen() {
        let at = |k: u64| Stamp::of_ns(1_790_000_000_000_000_000 + k * 40_000_000).unwrap();
        for count in [1, 2, 3, 8] {
            let mut images = Images::new(&spec());
            let taken = (0..100).filter(|k| taken(&mut images, &numbered((k % count) as u8), at(*k)).is_ok());
            assert_eq!(taken.count() as u64, count);
        }
    }

    /// A frozen screen that is grabbed again has a new stamp.
    #[test]
    fn an_image_that_is_the_one_before_byte_for_byte_is_frozen_unless_it_shows_nothing() {
        let at = |k: u64| Stamp::of_ns(1_790_000_000_000_000_000 + k * 40_000_000).unwrap();
        let mut images = Images::new(&spec());
        assert!(taken(&mut images, &numbered(0), at(0)).is_ok());
        assert_eq!(taken(&mut images, &numbered(0), at(1)), Err(ImageError::Frozen));
        assert_eq!(taken(&mut images, &numbered(0), Stamp::NONE), Err(ImageError::Frozen));
        images.forget();
        assert_eq!(taken(&mut images, &numbered(0), at(2)), Err(ImageError::Frozen));
        assert!(taken(&mut images, &numbered(1), at(3)).is_ok());
        assert_eq!(taken(&mut images, &numbered(0), at(4)), Err(ImageError::Frozen));
        assert!((2..9).all(|k| taken(&mut images, &numbered(k), at(3 + u64::from(k))).is_ok()));
        assert!(taken(&mut images, &numbered(0), at(12)).is_ok());
        let black = Image {
            voxels: Cow::Owned(vec![0; 32 * 40]),
            ..numbered(0)
        };
        assert!((13..16).all(|k| taken(&mut images, &black, at(k)).is_ok()));
    }

    #[test]
    fn pixels_are_those_of_the_message_where_the_scene_says_none_and_a_contradiction_is_refused() {
        let words = |spec: &ImagesSpec, image: &Image<'static>| {
            taken(&mut Images::new(spec), image, Stamp::NONE)
                .map_or_else(|error| error.to_string(), |_| "taken".to_owned())
        };
        assert_eq!(words(&spec(), &image([32, 40, 1], [0.1, 0.2])), "taken");
        assert!(words(&spec(), &image([32, 40, 1], [0.1, 0.21])).contains("was the depth changed?"));
        let by_message = ImagesSpec {
            pixel_mm: None,
            ..spec()
        };
        let picture = taken(
            &mut Images::new(&by_message),
            &image([32, 40, 1], [0.125, 0.25]),
            Stamp::NONE,
        )
        .unwrap();
        assert_eq!(picture.header.pixel_mm, [0.125, 0.25]);
        assert!(words(&by_message, &image([32, 40, 1], [1.0, 1.0])).starts_with("neither its message"));
        let unknown = ImagesSpec {
            shown: None,
            ..by_message
        };
        let picture = taken(&mut Images::new(&unknown), &image([32, 40, 1], [1.0, 1.0]), Stamp::NONE).unwrap();
        assert_eq!(
            (picture.header.array, picture.header.pixel_mm),
            (UsImageHeader::UNKNOWN, [0.0; 2])
        );
    }

    #[test]
    fn what_is_no_grey_image_of_one_slice_is_refused_by_name() {
        let words = |image: Image<'static>| {
            taken(&mut Images::new(&spec()), &image, Stamp::NONE)
                .unwrap_err()
                .to_string()
        };
        let good = image([32, 40, 1], [1.0, 1.0]);
        let colour = Image {
            components: 3,
            ..good.clone()
        };
        assert!(words(colour).starts_with("3 components of uint8"));
        let deep = Image {
            scalar: Scalar::Uint16,
            ..good.clone()
        };
        assert!(words(deep).starts_with("1 components of uint16"));
        assert!(words(image([32, 40, 2], [1.0, 1.0])).contains("32 x 40 x 2 voxels"));
        let part = Image {
            size: [32, 20, 1],
            ..good
        };
        assert!(words(part).starts_with("a part of an image"));
        assert!(words(image([8, 40, 1], [1.0, 1.0])).contains("8 x 40 pixels"));
        let large = Image {
            voxels: Cow::Owned(Vec::new()),
            ..image([4096, 1, 1], [1.0, 1.0])
        };
        let large = Image {
            dimensions: [4096, 1025, 1],
            size: [4096, 1025, 1],
            ..large
        };
        assert!(words(large).contains("at most 4194304 are taken"));
    }
}
