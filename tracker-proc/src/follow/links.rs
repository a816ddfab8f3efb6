//! The constants of the chain, from the scene or from files that may come, go and be replaced while the process runs.
//!
//! A file that is missing, or is refused, takes its constant away: there is no pose until it is put right. The old constant
//! never serves on, as the operator may have taken its file away for a reason. Files are looked at by threads of their own
//! ([`watch`](super::watch)), so that a folder that does not answer holds up no pose; what was read last is in use meanwhile.

use std::sync::Arc;

use bus::message::Lost;
use geometry::{Marker, Tool, Uncertain};
use scene::registration_id;
use scene::tracking::LinkFiles;

use super::Source;
use super::link_files::{Expected, Filed, calibration, registration};
use super::watch::Watched;
use crate::chain::{Links, Registration};

/// Whether something else was found than at the last look.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Looked {
    pub(super) calibration: bool,
    pub(super) registration: bool,
}

/// The constants.
pub(super) struct Constants {
    source: Source,
    own_id: u64,
    calibration: Option<Watched<Uncertain<Marker, Tool>>>,
    registration: Option<Watched<Filed>>,
}

impl Constants {
    /// Watches the files, and gives each a moment to be read for the first time.
    pub(super) fn new(files: &LinkFiles, source: Source, expected: Expected, own_id: u64) -> Self {
        let expected = Arc::new(expected);
        let calibration = files.calibration.clone().map(|link| {
            let (path, expected) = (link.file.path.clone(), expected.clone());
            Watched::new(path, move || calibration(&link, &expected))
        });
        let registration = files.registration.clone().map(|link| {
            let (path, expected) = (link.file.path.clone(), expected.clone());
            Watched::new(path, move || registration(&link, &expected))
        });
        let mut constants = Self {
            source,
            own_id,
            calibration,
            registration,
        };
        constants.calibration.iter_mut().for_each(Watched::first);
        constants.registration.iter_mut().for_each(Watched::first);
        constants
    }

    /// Takes what the threads have found since the last call.
    pub(super) fn look(&mut self, now_ns: i64) -> Looked {
        Looked {
            calibration: self.calibration.as_mut().is_some_and(|watched| watched.take(now_ns)),
            registration: self.registration.as_mut().is_some_and(|watched| watched.take(now_ns)),
        }
    }

    /// Why there can be no pose: the calibration first, as nothing is known of the tool without it.
    pub(super) fn lost(&self) -> Option<Lost> {
        let refused = |held: bool, lost| held.then_some(lost);
        let calibration = self.calibration.as_ref().is_some_and(|w| w.held().is_err());
        let registration = self.registration.as_ref().is_some_and(|w| w.held().is_err());
        refused(calibration, Lost::NotCalibrated).or(refused(registration, Lost::NotRegistered))
    }

    /// The same in words, with the file; or which file cannot be looked at.
    pub(super) fn reason(&self) -> Option<String> {
        fn why<T>(watched: Option<&Watched<T>>) -> Option<String> {
            watched?.held().as_ref().err().cloned()
        }
        why(self.calibration.as_ref())
            .or_else(|| why(self.registration.as_ref()))
            .or_else(|| self.calibration.as_ref()?.silent())
            .or_else(|| self.registration.as_ref()?.silent())
    }

    /// What of the files in use keeps no pose back, and should be known.
    pub(super) fn warning(&self) -> Option<&str> {
        self.registration.as_ref()?.held().as_ref().ok()?.warning.as_deref()
    }

    /// Those in use: the files' where there are files, else the scene's.
    pub(super) fn links(&self) -> Links {
        Links {
            marker_from_tool: self
                .calibration
                .as_ref()
                .and_then(|w| w.held().as_ref().ok().copied())
                .unwrap_or(self.source.own.marker_from_tool),
            registration: self
                .registration
                .as_ref()
                .and_then(|w| w.held().as_ref().ok().map(|filed| filed.registration))
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
