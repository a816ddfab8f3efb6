//! Where the markers were at each image's stamp: between the localizer's frames before and after it, and nowhere else.

use std::path::Path;

use bus::message::{EmitterFrame, MarkerFrame};
use geometry::{Frame, Rigid, Tracker};
use scene::{Scene, TrackerSource};

use super::super::follow::{Delivered, Follow, Seen};
use super::listed::Image;
use super::{ExportError, Posed};
use crate::edit::progress::Progress;
use crate::read::reader::{self, Messages, Recorded};

/// Between two frames that are further apart nothing is known of the way, ns; as for a sweep.
const MOST_APART_NS: i64 = 150_000_000;

/// Images without a pose.
#[derive(Debug, Default)]
pub(super) struct Unposed {
    pub(super) count: u64,
    /// Why the last of them has none.
    pub(super) why: String,
}

/// A frame of the localizer.
struct At {
    t_ns: i64,
    seen: Result<Seen, String>,
}

/// A frame of either kind.
trait Localized: Recorded {
    fn times_ns(&self) -> [i64; 2];
    fn delivered(&self) -> Delivered<'_>;
}

impl Localized for EmitterFrame {
    fn times_ns(&self) -> [i64; 2] {
        [self.t_capture_ns, self.t_publish_ns]
    }

    fn delivered(&self) -> Delivered<'_> {
        Delivered::Emitters(self)
    }
}

impl Localized for MarkerFrame {
    fn times_ns(&self) -> [i64; 2] {
        [self.t_capture_ns, self.t_publish_ns]
    }

    fn delivered(&self) -> Delivered<'_> {
        Delivered::Markers(self)
    }
}

/// Gives each image the pose of its stamp.
pub(super) fn pose(
    input: &Path,
    scene: &Scene,
    follow: &mut dyn Follow,
    images: &mut [Image],
) -> Result<Unposed, ExportError> {
    match &scene.tracker.source {
        TrackerSource::Markers(_) => Ok(pose_by(reader::markers(input)?, follow, images)),
        _ => Ok(pose_by(reader::emitters(input)?, follow, images)),
    }
}

fn pose_by<T: Localized>(mut frames: Messages<T>, follow: &mut dyn Follow, images: &mut [Image]) -> Unposed {
    let mut unposed = Unposed::default();
    let mut give = |image: &mut Image, found: Result<Posed, String>| match found {
        Ok(posed) => image.posed = Some(posed),
        Err(why) => (unposed.count, unposed.why) = (unposed.count + 1, why),
    };
    let mut images = images.iter_mut().peekable();
    let (mut progress, mut before) = (Progress::new("following the markers"), None::<At>);
    while let Some(frame) = frames.next() {
        let (read, length) = frames.progress();
        progress.at(read, length);
        let Ok(frame) = frame else { continue };
        let [t_ns, now_ns] = frame.times_ns();
        // One that came late is passed over, as the tracker does: it is not in the way of those about it.
        if before.as_ref().is_some_and(|before| t_ns <= before.t_ns) {
            continue;
        }
        let seen = follow.see(frame.delivered(), now_ns);
        let after = At { t_ns, seen };
        while let Some(image) = images.next_if(|image| image.t_ns <= t_ns) {
            let found = at(image, before.as_ref(), &after);
            give(image, found);
        }
        before = Some(after);
    }
    for image in images {
        give(image, Err("the localizer's frames end before its stamp".to_owned()));
    }
    unposed
}

/// The pose at an image's stamp, which is after `before` and not after `after`.
fn at(image: &Image, before: Option<&At>, after: &At) -> Result<Posed, String> {
    if !image.is_stamped {
        return Err("it is stamped by its arrival, and when it was captured nobody knows".to_owned());
    }
    let posed = |seen: &Seen| Posed {
        marker: seen.marker,
        reference: seen.reference,
    };
    if image.t_ns == after.t_ns {
        return after.seen.as_ref().map(posed).map_err(String::clone);
    }
    let Some(before) = before else {
        return Err("the localizer's frames begin after its stamp".to_owned());
    };
    let apart_ns = after.t_ns - before.t_ns;
    if apart_ns > MOST_APART_NS {
        let apart_ms = bus::clock::ms(apart_ns);
        return Err(format!(
            "the localizer's frames about its stamp are {apart_ms:.0} ms apart, 150 at most"
        ));
    }
    let (a, b) = (before.seen.as_ref()?, after.seen.as_ref()?);
    let share = (image.t_ns - before.t_ns) as f64 / apart_ns as f64;
    Ok(Posed {
        marker: between(&a.marker, &b.marker, share),
        // A scene has a marker on the patient in every frame or in none.
        reference: a.reference.zip(b.reference).map(|(a, b)| between(&a, &b, share)),
    })
}

fn between<M: Frame>(a: &Rigid<Tracker, M>, b: &Rigid<Tracker, M>, share: f64) -> Rigid<Tracker, M> {
    let shift = a.translation() + (b.translation() - a.translation()) * share;
    Rigid::from_parts(a.rotation().slerp(b.rotation(), share), shift)
}
