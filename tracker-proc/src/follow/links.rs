//! The constants of the chain, from the scene or from files that may come, go and be replaced while the process runs.
//!
//! A file that is missing, or is refused, takes its constant away: there is no pose until it is put right. The old constant
//! never serves on, as the operator may have taken its file away for a reason.

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use bus::message::Lost;
use bus::scene::registration_id;
use bus::scene::tracking::{LinkFile, LinkFiles};
use calib::file::{FileError, MAX_BYTES, Registered, RegistrationFile, ToolFile};
use geometry::{Marker, Tool, Uncertain};

use super::Source;
use crate::chain::{Links, Registration};

/// Files are looked at this often, ns.
const EVERY_NS: i64 = 1_000_000_000;

/// What the files must have been made for.
pub(super) struct Expected {
    pub(super) tool: String,
    pub(super) ct_hash: String,
    pub(super) has_reference: bool,
}

/// Whether something else was found than at the last look.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Looked {
    pub(super) calibration: bool,
    pub(super) registration: bool,
}

/// The constants.
pub(super) struct Constants {
    source: Source,
    expected: Expected,
    own_id: u64,
    calibration: Option<Watched<Uncertain<Marker, Tool>>>,
    registration: Option<Watched<Registration>>,
    next_look_ns: i64,
}

/// What tells one content of a file from another: when and how long, and which file it is.
type Mark = (i64, i64, u64, u64);

/// A file that is looked at now and then.
struct Watched<T> {
    file: LinkFile,
    /// `None`: not there.
    mark: Option<Mark>,
    looked: bool,
    held: Result<T, String>,
}

impl Constants {
    pub(super) fn new(files: &LinkFiles, source: Source, expected: Expected, own_id: u64) -> Self {
        let mut constants = Self {
            source,
            expected,
            own_id,
            calibration: files.calibration.clone().map(Watched::new),
            registration: files.registration.clone().map(Watched::new),
            next_look_ns: i64::MIN,
        };
        constants.look(0);
        constants.next_look_ns = i64::MIN;
        constants
    }

    /// Looks at the files if it is time.
    pub(super) fn look(&mut self, now_ns: i64) -> Looked {
        if now_ns < self.next_look_ns {
            return Looked::default();
        }
        self.next_look_ns = now_ns.saturating_add(EVERY_NS);
        let expected = &self.expected;
        let calibration = |file: &LinkFile| calibration(file, expected);
        let registration = |file: &LinkFile| registration(file, expected);
        Looked {
            calibration: self
                .calibration
                .as_mut()
                .is_some_and(|watched| watched.look(calibration)),
            registration: self
                .registration
                .as_mut()
                .is_some_and(|watched| watched.look(registration)),
        }
    }

    /// Why there can be no pose: the calibration first, as nothing is known of the tool without it.
    pub(super) fn lost(&self) -> Option<Lost> {
        let refused = |held: bool, lost| held.then_some(lost);
        let calibration = self.calibration.as_ref().is_some_and(|w| w.held.is_err());
        let registration = self.registration.as_ref().is_some_and(|w| w.held.is_err());
        refused(calibration, Lost::NotCalibrated).or(refused(registration, Lost::NotRegistered))
    }

    /// The same in words, with the file.
    pub(super) fn reason(&self) -> Option<&str> {
        let calibration = self.calibration.as_ref().and_then(|w| w.held.as_ref().err());
        let registration = self.registration.as_ref().and_then(|w| w.held.as_ref().err());
        calibration.or(registration).map(String::as_str)
    }

    /// Those in use: the files' where there are files, else the scene's.
    pub(super) fn links(&self) -> Links {
        let held = |w: &Watched<_>| w.held.as_ref().ok().copied();
        Links {
            marker_from_tool: self
                .calibration
                .as_ref()
                .and_then(held)
                .unwrap_or(self.source.own.marker_from_tool),
            registration: self
                .registration
                .as_ref()
                .and_then(|w| w.held.as_ref().ok().copied())
                .unwrap_or(self.source.own.registration),
        }
    }

    /// Whether the errors of every link are known, so that one at the tip can be predicted.
    pub(super) fn errors_known(&self) -> bool {
        let from_files = self.calibration.is_some() && self.registration.is_some();
        self.source.errors_known && (self.source.own_errors_known || from_files)
    }

    /// Identifies what poses rest on: the scene's own id, or that of the numbers in use where a file gives some.
    pub(super) fn registration_id(&self) -> u64 {
        if self.calibration.is_none() && self.registration.is_none() {
            return self.own_id;
        }
        let links = self.links();
        let (q, t) = match &links.registration {
            Registration::Fixed(at) => (at.transform().quaternion(), at.transform().translation_mm()),
            Registration::Referenced(at) => (at.transform().quaternion(), at.transform().translation_mm()),
        };
        let tool = links.marker_from_tool.transform();
        let numbers = [&q[..], &t, &tool.quaternion(), &tool.translation_mm()].concat();
        registration_id(&numbers)
    }
}

impl<T> Watched<T> {
    fn new(file: LinkFile) -> Self {
        Self {
            held: Err(format!("{} was not read yet", name(&file.path))),
            mark: None,
            looked: false,
            file,
        }
    }

    /// Reads the file again if it is another than before; tells whether it was.
    fn look(&mut self, read: impl Fn(&LinkFile) -> Result<T, String>) -> bool {
        let mark = fs::metadata(&self.file.path)
            .ok()
            .map(|m| (m.mtime(), m.mtime_nsec(), m.size(), m.ino()));
        if self.looked && mark == self.mark {
            return false;
        }
        (self.looked, self.mark) = (true, mark);
        self.held = read(&self.file);
        match &self.held {
            Ok(_) => bus::say!("tracker: {} is in use", self.file.path.display()),
            Err(why) => bus::say!("tracker: not used: {why} ({})", self.file.path.display()),
        }
        true
    }
}

/// The name of a file without its folder: what fits on a line.
fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn calibration(file: &LinkFile, expected: &Expected) -> Result<Uncertain<Marker, Tool>, String> {
    let failed = |error: FileError| format!("{}: {error}", name(&file.path));
    let tool = ToolFile::parse(&text(&file.path)?).map_err(failed)?;
    let marker = file.marker.as_deref().unwrap_or(&tool.marker);
    tool.of(&expected.tool, marker).map_err(failed)?;
    Ok(tool.marker_from_tool)
}

fn registration(file: &LinkFile, expected: &Expected) -> Result<Registration, String> {
    let failed = |error: FileError| format!("{}: {error}", name(&file.path));
    let found = RegistrationFile::parse(&text(&file.path)?).map_err(failed)?;
    let untold = found.marker.as_deref().unwrap_or_default();
    let marker = file.marker.as_deref().unwrap_or(untold);
    found.of(&expected.ct_hash, marker).map_err(failed)?;
    match found.registered {
        Registered::Fixed(ct_from_tracker) => Ok(Registration::Fixed(ct_from_tracker)),
        Registered::Referenced(ct_from_reference) if expected.has_reference => {
            Ok(Registration::Referenced(ct_from_reference))
        }
        Registered::Referenced(_) => Err(format!(
            "{}: rests on a reference, and the scene has none",
            name(&file.path)
        )),
    }
}

/// The text of a file of bounded length.
fn text(path: &Path) -> Result<String, String> {
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("{} is not there", name(path)),
        _ => format!("{}: {error}", name(path)),
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(format!("{} is no file", name(path)));
    }
    let mut text = String::new();
    let most = MAX_BYTES as u64 + 1;
    File::open(path)
        .and_then(|file| file.take(most).read_to_string(&mut text))
        .map_err(failed)?;
    Ok(text)
}
