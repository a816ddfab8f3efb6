//! A recording that is opened at a moment: its index says which chunk holds it, and what lies before is not read.
//!
//! A file without an index (its recording was never finished, or its end is damaged) is walked through once, from record
//! to record, without reading what is in the chunks. A chunk is taken whose last message is not before the moment; the
//! messages come in the order of the file from there on, those captured before the moment left out.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let session = recorder::read::seek::Session::open("session.mcap".as_ref())?;
//! let first = session.poses_from(3_200_000_000)?.next();
//! # Ok(())
//! # }
//! ```

mod absent;
mod few;
mod places;
mod sound;
mod tiled;
mod unnamed;

use std::fs::File;
use std::io::{self, BufReader, Seek, SeekFrom};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use mcap::read::ChannelAccumulator;
use mcap::records::Metadata;
use mcap::{MAGIC, McapError, Summary};

use crate::read::damage::OpenError;
use crate::read::reader::{Emitters, Markers, Messages, Poses, Tissues, UsImages};
use crate::read::scan::{self, Item, Scan};
use crate::wire::proto::file_time;
use crate::wire::schema::{self, EMITTERS, MARKERS, TISSUE, TOOL_POSE, US_IMAGE};
pub use few::Found;
use places::Places;
pub(crate) use sound::Indexed;

/// A recording's index.
pub(crate) enum Stated {
    /// It can be read.
    Index(Box<Summary>),
    /// It can be read, and its channels are without their schemas: without them.
    Unnamed(Box<Summary>),
    /// The file states that it has none.
    Nothing,
    /// There is one, or there is no telling, and it cannot be read: why, in words.
    Unreadable(String),
}

/// What a recording states of its index.
pub(crate) fn stated(path: &Path) -> Result<Stated, OpenError> {
    let (mut file, length) = scan::open_file(path)?;
    Ok(match places::read_summary(&mut file, length) {
        Ok(Some(summary)) if places::fits(&summary, length) => Stated::Index(Box::new(summary)),
        Ok(Some(_)) => Stated::Unreadable("it names places that are not in the file".to_owned()),
        Ok(None) => Stated::Nothing,
        Err(error @ McapError::UnknownSchema(..)) => match unnamed::summary(&mut file, length).ok().flatten() {
            Some(summary) if places::fits(&summary, length) => Stated::Unnamed(Box::new(summary)),
            _ => Stated::Unreadable(error.to_string()),
        },
        Err(error) => Stated::Unreadable(error.to_string()),
    })
}

/// Where an index says something else than the records of its file do.
pub(crate) struct Differences {
    /// What is wrong, in words.
    pub(crate) found: Vec<String>,
    /// Which parts of the index are not there at all, in words.
    pub(crate) left_out: Vec<String>,
}

/// Where the index of a recording says something else than its records do. Parts that are left out are wrong where `is_whole`:
/// whoever wrote the file always writes them.
pub(crate) fn differences(path: &Path, summary: &Summary, is_whole: bool) -> Result<Differences, OpenError> {
    let (mut file, length) = scan::open_file(path)?;
    let mut walked = Places::walk(&mut file, length).map_err(|source| OpenError::Io {
        path: path.to_owned(),
        source,
    })?;
    let index = Places::from_summary(summary);
    let left_out = match is_whole {
        true => Vec::new(),
        false => places::leave_out(&index, &mut walked),
    };
    let mut found = places::differences(&index, &walked);
    found.extend(absent::absent(&mut file, length, summary, &walked));
    Ok(Differences { found, left_out })
}

/// Device and number of a file: which it is, whatever it is called.
fn identity(file: &File) -> io::Result<(u64, u64)> {
    let about = file.metadata()?;
    Ok((about.dev(), about.ino()))
}

/// A recording with its index in memory.
#[derive(Debug)]
pub struct Session {
    path: PathBuf,
    length: u64,
    /// Held open, so that no other file is given its number: another one under its name is none of this recording.
    file: File,
    places: Places,
    /// Channels, where the file has an index.
    summary: Option<Summary>,
}

impl Session {
    /// Opens a recording and reads its index.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let (mut file, length) = scan::open_file(path)?;
        let fail = |source| OpenError::Io {
            path: path.to_owned(),
            source,
        };
        let summary = places::summary(&mut file, length);
        let places = match &summary {
            Some(summary) => Places::from_summary(summary),
            None => Places::walk(&mut file, length).map_err(fail)?,
        };
        Ok(Self {
            path: path.to_owned(),
            length,
            file,
            places,
            summary,
        })
    }

    /// Whether the file has an index. Without, it was never finished, or its end is damaged.
    pub fn is_indexed(&self) -> bool {
        self.summary.is_some()
    }

    /// The earliest and the latest capture, ns since the run's epoch; `None` without messages.
    pub fn span_ns(&self) -> Option<(u64, u64)> {
        let chunks = self.places.chunks.iter().filter(|chunk| chunk.to_ns > 0);
        let spans = chunks.map(|chunk| (chunk.from_ns, chunk.to_ns));
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The tracker's poses captured at `t_ns` or later.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn poses_from(&self, t_ns: i64) -> Result<Poses, OpenError> {
        self.poses_of(TOOL_POSE, t_ns)
    }

    /// The poses of `topic` captured at `t_ns` or later: [`TOOL_POSE`] or [`crate::wire::schema::GROUND_TRUTH`].
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn poses_of(&self, topic: &str, t_ns: i64) -> Result<Poses, OpenError> {
        let t_ns = file_time(t_ns);
        Ok(Messages::of(self.items_from(t_ns)?, topic, t_ns))
    }

    /// What the localizer saw at `t_ns` or later.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn emitters_from(&self, t_ns: i64) -> Result<Emitters, OpenError> {
        let t_ns = file_time(t_ns);
        Ok(Messages::of(self.items_from(t_ns)?, EMITTERS, t_ns))
    }

    /// The markers that the localizer followed at `t_ns` or later.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn markers_from(&self, t_ns: i64) -> Result<Markers, OpenError> {
        let t_ns = file_time(t_ns);
        Ok(Messages::of(self.items_from(t_ns)?, MARKERS, t_ns))
    }

    /// The images of an ultrasound probe captured at `t_ns` or later.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn us_images_from(&self, t_ns: i64) -> Result<UsImages, OpenError> {
        let t_ns = file_time(t_ns);
        Ok(Messages::of(self.items_from(t_ns)?, US_IMAGE, t_ns))
    }

    /// Where organs were for poses that were captured at `t_ns` or later.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn tissue_from(&self, t_ns: i64) -> Result<Tissues, OpenError> {
        let t_ns = file_time(t_ns);
        Ok(Messages::of(self.items_from(t_ns)?, TISSUE, t_ns))
    }

    /// Whether there may be messages of `topic`: without an index nobody knows.
    pub(crate) fn may_hold(&self, topic: &str) -> bool {
        let Some(summary) = &self.summary else { return true };
        let Some(stats) = &summary.stats else { return true };
        let count = |id| stats.channel_message_counts.get(id).copied().unwrap_or(0);
        let of_topic = summary.channels.iter().filter(|(_, channel)| channel.topic == topic);
        of_topic.into_iter().any(|(id, _)| count(id) > 0)
    }

    /// Everything from the first chunk on that has a message of `t_ns` or later; earlier ones of that chunk come too.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn items_from(&self, t_ns: u64) -> Result<Scan<BufReader<File>>, OpenError> {
        let first = self.places.first_at(t_ns);
        // Without an index, a file of another program says only on the way which channels it has.
        let knows_channels = self.summary.is_some() || self.places.is_ours;
        self.scan_at(match first {
            Some(_) if !knows_channels => Some(MAGIC.len() as u64),
            first => first,
        })
    }

    /// The attached file of this name; the last one of several. `None` where there is none that can be read.
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn attachment(&self, name: &str) -> Result<Option<Vec<u8>>, OpenError> {
        for &at in self.places.attachments.iter().rev() {
            if let Some(Ok(Item::Attachment(file))) = self.scan_at(Some(at))?.next()
                && file.name == name
            {
                return Ok(Some(file.data.into_owned()));
            }
        }
        Ok(None)
    }

    /// The newest metadata record of this name, such as [`crate::wire::schema::RUN`].
    ///
    /// # Errors
    /// [`OpenError::Io`].
    pub fn metadata(&self, name: &str) -> Result<Option<Metadata>, OpenError> {
        for &at in self.places.metadata.iter().rev() {
            if let Some(Ok(Item::Metadata(facts))) = self.scan_at(Some(at))?.next()
                && facts.name == name
            {
                return Ok(Some(facts));
            }
        }
        Ok(None)
    }

    /// Reads on from byte `at`; from the start where there is no such place.
    fn scan_at(&self, at: Option<u64>) -> Result<Scan<BufReader<File>>, OpenError> {
        let fail = |source| OpenError::Io {
            path: self.path.clone(),
            source,
        };
        let (mut file, _) = scene::file::open(&self.path).map_err(|error| fail(error.into()))?;
        if identity(&file).map_err(fail)? != identity(&self.file).map_err(fail)? {
            return Err(fail(io::Error::other(
                "it was replaced by another file since it was opened: begin anew",
            )));
        }
        let at = match at {
            Some(at) => at,
            None if self.places.is_complete => self.places.end,
            None => MAGIC.len() as u64,
        };
        file.seek(SeekFrom::Start(at)).map_err(fail)?;
        Ok(Scan::from_middle(
            BufReader::new(file),
            self.length,
            at,
            self.channels(),
        ))
    }

    /// The channels that the file declares; without an index, those that every file of this version has.
    fn channels(&self) -> ChannelAccumulator<'static> {
        match &self.summary {
            Some(summary) => ChannelAccumulator::from_summary(summary),
            None if self.places.is_ours => schema::built_in(),
            None => ChannelAccumulator::default(),
        }
    }
}

#[cfg(test)]
mod tests;
