//! The images of a run's ultrasound probe, looked at as they come.

use bus::message::{CaptureClock, UsImageHeader};
use bus::port::{UsImage, UsImageSubscriber};
use echo::bone::{BoneLine, Options, find};
use ultrasound::{Image, Shape};

use super::LiveError;

/// What an image showed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Looked {
    /// When it was captured as its source says, ns on the run's clock.
    pub(crate) t_capture_ns: i64,
    /// Its number.
    pub(crate) seq: u64,
    /// Its size, pixels and beams, or why they are none.
    pub(crate) shape: Result<Shape, String>,
    /// How its rows and columns run, as its source says, in PLUS's letters; `None` where it does not say.
    pub(crate) orientation: Option<String>,
    /// Whether `t_capture_ns` is the source's own stamp, and not the image's arrival.
    pub(crate) is_stamped: bool,
    /// From `t_capture_ns` to its arrival, ns.
    pub(crate) late_ns: i64,
    /// The line of a bone, or why there is none.
    pub(crate) line: Result<BoneLine, String>,
}

impl Looked {
    /// Looks for bone in an image.
    fn at(header: &UsImageHeader, grey: &[u8]) -> Self {
        let shape = header.shape().map_err(|why| why.to_string());
        let line = shape.clone().and_then(|shape| {
            let image = Image::new(&shape, grey).map_err(|why| why.to_string())?;
            find(&image, &Options::default()).map_err(|why| why.to_string())
        });
        Self {
            t_capture_ns: header.t_capture_ns,
            seq: header.seq,
            shape,
            orientation: header.orientation(),
            is_stamped: header.capture_clock() == Some(CaptureClock::Mapped),
            late_ns: header.t_arrival_ns.saturating_sub(header.t_capture_ns),
            line: line.and_then(|line| match line.reason() {
                Some(why) => Err(why),
                None => Ok(line),
            }),
        }
    }
}

/// Looks at what has come since the last call, one image at most: a localizer's frames are not kept waiting.
pub(super) fn look(images: &UsImageSubscriber, began_ns: i64) -> Result<Option<Looked>, LiveError> {
    let mut newest: Option<UsImage> = None;
    // Of several that wait, the newest: an older one would only be followed by more that wait.
    while let Some(image) = images.next()? {
        newest = Some(image);
    }
    let newest = newest.filter(|image| image.header().t_capture_ns >= began_ns);
    Ok(newest.map(|image| Looked::at(image.header(), image.grey())))
}
