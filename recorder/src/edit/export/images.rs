//! The images of an ultrasound probe as a sequence for the PLUS toolkit, each with where the markers were at its own stamp.
//!
//! As PLUS does it: `Timestamp` is the image's stamp as its source gave it, on the run's clock, and each transform is that of the
//! localizer's frames before and after that stamp, straight between both. How late images are beside poses is in no stamp and is not
//! taken out here: `calib lag` and `calib probe --lag-ms` find it in this very file, and it would count twice.
//!
//! The recording is read four times, so that no more is in memory than a line of each image: what is beside the messages, the images'
//! stamps, the localizer's frames, and the images' grey values.

mod listed;
mod posed;
mod text;

use std::io::Write;
use std::path::Path;

use geometry::{Marker, Reference, Rigid, Tracker};
use mcap::records::Metadata;
use scene::Scene;

use super::follow::FollowMarkers;
use super::{ExportError, write_error};
use crate::edit::progress::Progress;
use crate::read::one_run::OneRun;
use crate::read::reader::{self, ReadError};
use crate::read::scan::{self, Item};
use crate::wire::schema::{RUN, SCENE};

/// Where the markers were at an image's stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Posed {
    marker: Rigid<Tracker, Marker>,
    reference: Option<Rigid<Tracker, Reference>>,
}

/// What was exported.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExportedImages {
    /// Images in the file.
    pub images: u64,
    /// Of these, without a pose.
    pub unposed: u64,
    /// Why the last of these has none, in words.
    pub why: String,
    /// Images that are not in the file: their stamp is not after that of the one before.
    pub left_out: u64,
    /// Parts of the recording, or messages, that could not be read.
    pub unreadable: u64,
    /// The file ends within a record: what came behind that is in no image.
    pub is_cut_off: bool,
    /// Where beams run and whose tool it is, as options of `calib probe`; nothing where the images do not say where beams run.
    pub options: Option<String>,
}

/// Writes the images of the recording `input`.
pub(super) fn write(input: &Path, follow: FollowMarkers, out: &mut impl Write) -> Result<ExportedImages, ExportError> {
    let scene = scene_of(input)?;
    let refused = |why| ExportError::Images {
        path: input.to_owned(),
        why,
    };
    let mut follow = follow(&scene).map_err(|why| refused(format!("no marker can be followed: {why}")))?;
    let mut listed = listed::list(input)?;
    let Some(first) = listed.first else {
        return Err(refused("there is no image of an ultrasound probe in it".to_owned()));
    };
    let unposed = posed::pose(input, &scene, follow.as_mut(), &mut listed.images)?;
    if unposed.count == listed.images.len() as u64 {
        return Err(refused(format!("none of its images has a pose: {}", unposed.why)));
    }
    text::header(out, &first, &listed.images).map_err(write_error)?;
    let mut written = 0;
    let mut images = listed.images.iter().peekable();
    let (unreadable, is_cut_off) = each(input, "exporting", |frame| {
        // The same that were listed, in the same order.
        let is_next = |image: &&listed::Image| image.seq == frame.header.seq && image.t_ns == frame.header.t_capture_ns;
        if images.next_if(is_next).is_none() {
            return Ok(());
        }
        written += 1;
        out.write_all(&frame.grey).map_err(write_error)
    })?;
    if written != listed.images.len() as u64 {
        return Err(refused("it was changed while it was read".to_owned()));
    }
    Ok(ExportedImages {
        images: written,
        unposed: unposed.count,
        why: unposed.why,
        left_out: listed.left_out,
        unreadable,
        is_cut_off,
        options: text::options(&first, &scene.tool.name),
    })
}

/// The scene of a recording of one run as it happened: where markers are is drawn in it.
fn scene_of(input: &Path) -> Result<Scene, ExportError> {
    let refused = |why| ExportError::Images {
        path: input.to_owned(),
        why,
    };
    let (mut one_run, mut text, mut run) = (OneRun::default(), None, None::<Metadata>);
    for item in scan::open(input)?.flatten() {
        if let Some(why) = one_run.beside(&item) {
            return Err(refused(why));
        }
        match item {
            Item::Attachment(file) if file.name == SCENE => text = String::from_utf8(file.data.into_owned()).ok(),
            Item::Metadata(facts) if facts.name == RUN => run = Some(facts),
            _ => {}
        }
    }
    // Images go out again with the stamps of the run that they are of.
    if let Some(of) = run.and_then(|run| run.metadata.get("remade_from").cloned()) {
        return Err(refused(format!("it is of a replay: export {of} instead")));
    }
    let text = text.ok_or_else(|| refused("it holds no scene, and with it no drawing of the markers".to_owned()))?;
    Scene::parse(&text, Path::new(SCENE)).map_err(|error| refused(format!("its scene cannot be read: {error}")))
}

/// Every image in the order of the file; returns how many parts could not be read, and whether the file ends within a record.
fn each(
    input: &Path,
    what: &'static str,
    mut take: impl FnMut(crate::wire::proto::UsFrame) -> Result<(), ExportError>,
) -> Result<(u64, bool), ExportError> {
    let mut images = reader::us_images(input)?;
    let (mut progress, mut unreadable, mut is_cut_off) = (Progress::new(what), 0, false);
    while let Some(image) = images.next() {
        let (read, length) = images.progress();
        progress.at(read, length);
        match image {
            Ok(image) => take(image)?,
            Err(ReadError::Damage(damage)) if damage.fault.is_mere_ending() => is_cut_off = true,
            Err(_) => unreadable += 1,
        }
    }
    Ok((unreadable, is_cut_off))
}

#[cfg(test)]
mod tests;
