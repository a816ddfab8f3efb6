//! The label map: read and made ready by a thread of its own, and asked how far the selected way stays from each structure.

use std::path::Path;
use std::rc::Rc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use geometry::VolumeGrid;
use guidance::plan::Trajectory;
use guidance::safety::{Clearances, GridMatch, LabelNames, Section, Structures, Tube};
use scene::VolumeSpec;

use crate::program::LabelReader;

/// Structures are looked for so far from the way, mm.
pub(crate) const WITHIN_MM: f64 = 20.0;
/// The way is looked at in so many parts.
const SECTIONS: usize = 150;

/// What is known of the structures beside the selected way.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) enum Beside {
    /// There is no label map.
    #[default]
    NotGiven,
    /// It is being read.
    Reading,
    /// It is none, or cannot be read.
    Refused(String),
    /// There is no way to be looked at.
    NoWay,
    /// What was found.
    Found(Box<Found>),
}

/// The structures beside a way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found {
    /// Of the whole way, nearest first.
    pub(crate) clearances: Clearances,
    /// Of each part of it.
    pub(crate) sections: Vec<Section>,
    /// How the label map lies beside the CT: whether it belongs to it is not known else.
    pub(crate) grid: GridMatch,
    /// What is doubtful about whose it is, a sentence each.
    pub(crate) doubts: Rc<[String]>,
    /// What structures are called.
    pub(crate) names: Rc<LabelNames>,
}

/// The map's structures, what they are called, whether its file says to be in the frame of reference of the CT, and what is doubtful
/// about it.
type Read = Result<(Structures, LabelNames, bool, Vec<String>), String>;

#[derive(Debug)]
struct Known {
    structures: Structures,
    names: Rc<LabelNames>,
    is_in_its_frame: bool,
    doubts: Rc<[String]>,
}

/// The label map of the scene.
#[derive(Debug)]
pub(crate) struct Labels {
    reading: Option<Receiver<Read>>,
    read: Option<Result<Known, String>>,
    radius_mm: f64,
    /// What was asked last, and the answer.
    asked: Option<(Trajectory, Beside)>,
}

impl Labels {
    /// Begins to read, where there is a file. A screen that waited for it would be taken for frozen.
    pub(crate) fn open(path: Option<&Path>, examination: &VolumeSpec, tube_mm: f64, load: LabelReader) -> Self {
        let reading = path.map(|path| {
            let (told, reading) = channel();
            let examination = examination.clone();
            let (name, path) = (path.display().to_string(), path.to_owned());
            let read = move || {
                let named = |error: &dyn std::fmt::Display| format!("label map {name}: {error}");
                let labels = (load.map)(&path, &examination).map_err(|error| named(&error));
                let read = labels.and_then(|labels| {
                    let structures = labels.volume.structures().map_err(|error| named(&error))?;
                    let names = (load.names)(&path).map_err(|error| named(&error))?;
                    Ok((structures, names, labels.is_in_its_frame, labels.doubts))
                });
                // Nobody listens any more where the window has ended.
                let _ = told.send(read);
            };
            // A thread that was not started has dropped its end, which is told as such.
            let _ = std::thread::Builder::new().name("labels".to_owned()).spawn(read);
            reading
        });
        Self {
            reading,
            read: None,
            radius_mm: tube_mm / 2.0,
            asked: None,
        }
    }

    /// Whether the label map has come, or was refused, with this call.
    pub(crate) fn take(&mut self) -> bool {
        let Some(reading) = &self.reading else { return false };
        let read = match reading.try_recv() {
            Err(TryRecvError::Empty) => return false,
            Err(TryRecvError::Disconnected) => Err("the label map was not read: its reader ended".to_owned()),
            Ok(read) => read,
        };
        if let Err(why) = &read {
            bus::stderr_line!("window: {why}");
        }
        let read = read.map(|(structures, names, is_in_its_frame, doubts)| Known {
            structures,
            names: Rc::new(names),
            is_in_its_frame,
            doubts: doubts.into(),
        });
        (self.read, self.reading, self.asked) = (Some(read), None, None);
        true
    }

    /// What lies beside this way.
    pub(crate) fn beside(&mut self, way: Option<&Trajectory>, grid: Option<&VolumeGrid>) -> Beside {
        let known = match (&self.reading, &self.read) {
            (Some(_), _) => return Beside::Reading,
            (None, None) => return Beside::NotGiven,
            (None, Some(Err(why))) => return Beside::Refused(why.clone()),
            (None, Some(Ok(known))) => known,
        };
        let Some(way) = way else { return Beside::NoWay };
        if let Some((_, answer)) = self.asked.as_ref().filter(|(asked, _)| asked == way) {
            return answer.clone();
        }
        let answer = found(known, way, self.radius_mm, grid);
        self.asked = Some((*way, answer.clone()));
        answer
    }
}

fn found(known: &Known, way: &Trajectory, radius_mm: f64, grid: Option<&VolumeGrid>) -> Beside {
    let structures = &known.structures;
    let lies = |ct| GridMatch::of(structures.grid(), ct).known(known.is_in_its_frame);
    let found = Tube::new(way.entry, way.stop, radius_mm).and_then(|tube| {
        Ok(Found {
            clearances: structures.clearance(&tube, WITHIN_MM)?,
            sections: structures.profile(&tube, SECTIONS, WITHIN_MM)?,
            grid: grid.map_or(GridMatch::Other, lies),
            doubts: known.doubts.clone(),
            names: known.names.clone(),
        })
    });
    match found {
        Ok(found) => Beside::Found(Box::new(found)),
        Err(error) => Beside::Refused(error.to_string()),
    }
}
