//! Single markers of tools of NDI, as emitters of the tracker.
//!
//! Nothing of the protocol says that marker k of a reply is marker k of the definition. The device's own pose of the tool shows it: with
//! that pose each marker lies nearest to its own place in the definition. Before it has shown that, nothing of the tool is published.

use std::collections::BTreeSet;

use bus::message::EmitterSight;
use calib::marker::even_directions;
use geometry::{Frame as GeometryFrame, Marker, Point, Rigid, Tracker};
use ndi::session::Tool;
use ndi::{Handle, Why};
use scene::localizer::SingleMarkers;
use scene::operating_room::{Emitters, Shape};
use scene::tracking::EmitterSource;

use crate::driver::Places;

/// A calibration of a marker moves its emitters by less than this, and the next one is further off, mm.
const MOST_APART_MM: f64 = 1.0;
/// So many different markers that lie at their own places are no accident: three hold a pose.
const PROVEN: usize = 3;

/// The emitters of the scene are not the markers of the tool's definition: their numbers would mean others.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// More or fewer.
    #[error(
        "the definition of {tool:?} has {found} markers, and the scene's [tracker.emitters.{table}] has {allowed} emitters"
    )]
    Count {
        /// The tool's name.
        tool: String,
        /// The table of the scene.
        table: &'static str,
        /// In the definition.
        found: usize,
        /// In the scene.
        allowed: usize,
    },
    /// One is elsewhere.
    #[error(
        "marker {marker} of the definition of {tool:?} is {found_mm:.3} mm from emitter {marker} of the scene's [tracker.emitters.{table}]; \
         at most {MOST_APART_MM} mm are allowed"
    )]
    Apart {
        /// The tool's name.
        tool: String,
        /// The table of the scene.
        table: &'static str,
        /// Which, from 0.
        marker: usize,
        /// How far.
        found_mm: f64,
    },
}

/// Whose single markers are published.
#[derive(Debug)]
pub(crate) struct Single {
    tool: One,
    patient: Option<One>,
}

/// A tool whose single markers are published.
#[derive(Debug)]
pub(crate) struct One {
    name: String,
    /// Places of its markers by its definition, mm.
    defined: Vec<Point<Marker>>,
    /// Its markers that the device's own pose has shown to be those of the definition, on this connection.
    shown: BTreeSet<u32>,
    /// Its pose has shown that they are others.
    is_other: bool,
}

impl Single {
    /// The definitions `loaded` are held against the emitters of the scene, by which the tracker knows them.
    ///
    /// # Errors
    /// [`ShapeError`].
    pub(crate) fn new(names: &SingleMarkers, source: &EmitterSource, loaded: &[Tool]) -> Result<Self, ShapeError> {
        let of = |name: &str, table, emitters: Vec<[f64; 3]>| {
            // The scene names its own tools alone.
            let tool = loaded.iter().find(|tool| tool.name == name);
            let defined = tool.map_or(&[][..], |tool| &tool.rom.markers_mm);
            is_same((name, table), defined, &emitters)?;
            Ok(One::new(name, defined))
        };
        let patient = names.patient.as_deref().zip(source.reference.as_ref());
        Ok(Self {
            tool: of(&names.tool, "marker", places_mm(&source.marker))?,
            patient: patient
                .map(|(name, reference)| of(name, "reference", places_mm(&reference.shape)))
                .transpose()?,
        })
    }

    /// Of another connection nothing is known.
    pub(crate) fn forget(&mut self) {
        for one in std::iter::once(&mut self.tool).chain(&mut self.patient) {
            (one.shown, one.is_other) = (BTreeSet::new(), false);
        }
    }

    /// What of a frame is published; `None` of one in which the device looked for none of these tools.
    pub(crate) fn places(&mut self, frame: &ndi::Frame, handle: impl Fn(&str) -> Option<Handle>) -> Option<Places> {
        let of = |one: &mut One| {
            let handle = handle(&one.name)?;
            let looked = frame.tool(handle).is_some_and(|sight| sight.why() != Why::NotInFrame);
            looked.then(|| one.seen(frame, handle))
        };
        let (tool, patient) = (of(&mut self.tool), self.patient.as_mut().and_then(of));
        (tool.is_some() || patient.is_some()).then(|| Places {
            tool: tool.unwrap_or_default(),
            patient: patient.unwrap_or_default(),
        })
    }

    /// What a person must know of the numbers of a device's markers.
    pub(crate) fn words(&self) -> Option<String> {
        let other = std::iter::once(&self.tool)
            .chain(&self.patient)
            .find(|one| one.is_other)?;
        Some(format!(
            "by the device's own pose of {:?} its single markers have other numbers than its definition: none of them is used",
            other.name
        ))
    }
}

impl One {
    fn new(name: &str, defined: &[[f64; 3]]) -> Self {
        Self {
            name: name.to_owned(),
            defined: defined.iter().map(|[x, y, z]| Point::new(*x, *y, *z)).collect(),
            shown: BTreeSet::new(),
            is_other: false,
        }
    }

    /// The good markers of a frame whose numbers are proven.
    fn seen(&mut self, frame: &ndi::Frame, handle: Handle) -> Vec<EmitterSight> {
        let seen = good(frame, handle);
        if let Some(Ok(pose)) = frame.tool(handle).map(ndi::Sight::pose)
            && let Ok(tracker_from_marker) = super::pose::rigid(&pose)
        {
            self.prove(tracker_from_marker, &seen);
        }
        let is_proven = self.shown.len() >= PROVEN && !self.is_other;
        let shown = seen.into_iter().filter(|sight| self.shown.contains(&sight.emitter));
        shown.filter(|_| is_proven).collect()
    }

    /// Each marker lies nearest to its own place in the definition, or the numbers are others.
    fn prove(&mut self, tracker_from_marker: Rigid<Tracker, Marker>, seen: &[EmitterSight]) {
        for sight in seen {
            let [x, y, z] = sight.place_mm;
            let place = tracker_from_marker.inverse() * Point::<Tracker>::new(x, y, z);
            let off = |k: &usize| self.defined[*k].distance(place);
            let nearest = (0..self.defined.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
            match nearest.is_some_and(|k| k == sight.emitter as usize) {
                true => {
                    self.shown.insert(sight.emitter);
                }
                false => self.is_other = true,
            }
        }
    }
}

/// The good markers of a tool. One that stands in the frame twice is none: nobody knows which place is its own.
fn good(frame: &ndi::Frame, handle: Handle) -> Vec<EmitterSight> {
    let of = || frame.markers.iter().filter(|marker| marker.tool() == Some(handle));
    let once = |index: u16| of().filter(|other| other.index() == index).count() == 1;
    of().filter(|marker| once(marker.index()))
        .filter_map(|marker| {
            Some(EmitterSight {
                place_mm: marker.place_mm().ok()?,
                emitter: u32::from(marker.index()),
                reserved: 0,
            })
        })
        .collect()
}

/// Places of the emitters of a marker of the scene, mm.
fn places_mm<F: GeometryFrame>(shape: &Shape<F>) -> Vec<[f64; 3]> {
    match &shape.emitters {
        Emitters::Ball { count, radius_mm } => even_directions::<F>(*count)
            .iter()
            .map(|direction| direction.components().map(|x| x * radius_mm))
            .collect(),
        Emitters::Listed(all) => all.iter().map(|emitter| emitter.place.mm()).collect(),
    }
}

fn is_same((tool, table): (&str, &'static str), defined: &[[f64; 3]], emitters: &[[f64; 3]]) -> Result<(), ShapeError> {
    let (found, allowed) = (defined.len(), emitters.len());
    if found != allowed {
        return Err(ShapeError::Count {
            tool: tool.to_owned(),
            table,
            found,
            allowed,
        });
    }
    let point = |[x, y, z]: [f64; 3]| Point::<Marker>::new(x, y, z);
    for (marker, (place, emitter)) in defined.iter().zip(emitters).enumerate() {
        let found_mm = point(*place).distance(point(*emitter));
        if found_mm > MOST_APART_MM {
            return Err(ShapeError::Apart {
                tool: tool.to_owned(),
                table,
                marker,
                found_mm,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector;
    use ndi::status::{MarkerStatus, ToolStatus};
    use ndi::{Bx2, Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, FrameKind, Transform};

    const PLACES: [[f64; 3]; 5] = [
        [0.0, 0.0, 0.0],
        [50.0, 0.0, 0.0],
        [0.0, 70.0, 0.0],
        [30.0, 30.0, 40.0],
        [-60.0, 10.0, 5.0],
    ];
    const HANDLE: Handle = Handle(1);

    fn pose() -> Rigid<Tracker, Marker> {
        Rigid::from_rotation_vector(Vector::new(0.4, -1.1, 0.2), Vector::new(100.0, -20.0, -1500.0)).unwrap()
    }

    /// A frame in which these markers are seen where these places of the definition are.
    fn bx2(markers: &[(u16, usize)], has_pose: bool) -> Bx2Frame {
        let at = pose();
        let told = Bx2Tool {
            handle: HANDLE,
            status: ToolStatus(if has_pose { 0 } else { ToolStatus::MISSING | 13 }),
            transform: has_pose.then_some(Transform {
                q: at.quaternion(),
                t_mm: at.translation_mm(),
                error_mm: 0.1,
            }),
        };
        let marker = |&(index, place): &(u16, usize)| {
            let [x, y, z] = PLACES[place];
            Bx2Marker {
                status: MarkerStatus(0),
                index,
                place_mm: (at * Point::<Marker>::new(x + 0.2, y, z - 0.1)).mm(),
            }
        };
        Bx2Frame {
            kind: FrameKind(2),
            index: 0,
            status: ToolStatus(0),
            number: 1,
            device_ns: 5,
            tools: vec![told],
            markers: vec![Bx2Markers {
                handle: HANDLE,
                markers: markers.iter().map(marker).collect(),
            }],
            errors: Vec::new(),
        }
    }

    fn of(frame: Bx2Frame) -> ndi::Frame {
        let reply = Bx2 {
            frames: vec![frame],
            ..Bx2::default()
        };
        ndi::Frame::of_bx2(&reply, 1e-3).remove(0)
    }

    fn single() -> Single {
        Single {
            tool: One::new("ball", &PLACES),
            patient: None,
        }
    }

    fn numbers(single: &mut Single, markers: &[(u16, usize)], has_pose: bool) -> Vec<u32> {
        let places = single.places(&of(bx2(markers, has_pose)), |_| Some(HANDLE)).unwrap();
        places.tool.iter().map(|sight| sight.emitter).collect()
    }

    #[test]
    fn markers_are_published_once_the_devices_own_pose_has_shown_which_they_are() {
        let mut single = single();
        let three = [(0, 0), (2, 2), (4, 4)];
        assert!(numbers(&mut single, &three, false).is_empty(), "nothing shows it");
        assert!(numbers(&mut single, &three[..2], true).is_empty(), "two are too few");
        assert_eq!(numbers(&mut single, &three, true), [0, 2, 4]);
        // Too few for a pose of the device, and what was not shown yet.
        assert_eq!(numbers(&mut single, &[(0, 0), (1, 1), (4, 4)], false), [0, 4]);
        assert_eq!(numbers(&mut single, &[(1, 1), (3, 3), (4, 4)], true), [1, 3, 4]);
        assert_eq!(numbers(&mut single, &[(1, 1), (3, 3)], false), [1, 3]);
        // Twice in one frame.
        assert_eq!(numbers(&mut single, &[(1, 1), (1, 2), (3, 3)], false), [3]);
        single.forget();
        assert!(numbers(&mut single, &three, false).is_empty());
        assert_eq!(single.words(), None);
    }

    /// They lie where a marker of the tool would, and have a number of one.
    #[test]
    fn markers_of_no_tool_are_left_out() {
        let mut single = single();
        let (with, without) = ([(0, 0), (1, 1), (2, 2), (3, 3)], [(0, 0), (1, 1), (2, 2)]);
        assert_eq!(numbers(&mut single, &with, true), [0, 1, 2, 3]);
        let mut stray = bx2(&without, true);
        let last = bx2(&with, true).markers[0].markers[3];
        stray.markers.push(Bx2Markers {
            handle: Handle::STRAY,
            markers: vec![last],
        });
        let read = of(stray);
        assert_eq!(read.markers.len(), 4);
        let places = single.places(&read, |_| Some(HANDLE)).unwrap();
        let numbers: Vec<u32> = places.tool.iter().map(|sight| sight.emitter).collect();
        assert_eq!(numbers, [0, 1, 2]);
    }

    /// A device that counts from 1, or in another order than the definition.
    #[test]
    fn markers_of_other_numbers_are_not_used_and_that_is_told() {
        for markers in [
            [(1, 0), (2, 1), (3, 2), (4, 3)],
            [(0, 4), (1, 3), (2, 2), (3, 1)],
            [(0, 0), (1, 1), (2, 2), (9, 3)],
        ] {
            let mut single = single();
            assert!(numbers(&mut single, &markers, true).is_empty(), "{markers:?}");
            assert!(numbers(&mut single, &[(0, 0), (1, 1), (2, 2)], true).is_empty());
            assert!(single.words().unwrap().contains("\"ball\""));
        }
    }
}
