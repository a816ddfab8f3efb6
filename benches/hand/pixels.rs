//! The reader of the window's pixels, for programs that stop where a frame is not painted.

use ::study::pixels;
pub(crate) use ::study::pixels::SCREEN;
use geometry::{Ct, Direction, Rigid, Tool};
use hand::{Reader, Reading, Shown};
use window::sizes::Screen;

/// How coarse that screen's sight is, for [`hand::SightReader`].
pub(crate) fn dial(screen: Screen) -> hand::Dial {
    pixels::dial(screen).unwrap()
}

/// The window's screen of seven images and the sight, and who reads it.
pub(crate) struct PixelReader(pixels::PixelReader);

impl PixelReader {
    /// On [`SCREEN`].
    pub(crate) fn new() -> Self {
        Self(pixels::PixelReader::new().unwrap())
    }
}

impl Reader for PixelReader {
    fn pictures(&self, shown: &Shown) -> Vec<usize> {
        self.0.pictures(shown)
    }

    fn axes(&self, picture: usize, pose: Rigid<Ct, Tool>) -> [Direction<Ct>; 2] {
        self.0.axes(picture, pose)
    }

    fn read(&mut self, picture: usize, shown: &Shown) -> Option<Reading> {
        let reading = self.0.read(picture, shown);
        self.0.painted().unwrap();
        reading
    }

    fn unseen_mm(&self, shown: &Shown) -> f64 {
        self.0.unseen_mm(shown)
    }
}
