//! Single markers of tools of NDI, as emitters of the tracker.

use bus::message::EmitterSight;
use calib::marker::even_directions;
use geometry::{Frame as GeometryFrame, Point};
use ndi::session::Tool;
use ndi::{Handle, Sight, Why};
use scene::localizer::SingleMarkers;
use scene::operating_room::{Emitters, Shape};
use scene::tracking::EmitterSource;

use crate::driver::Places;

/// A calibration of a marker moves its emitters by less than this, and the next one is further off, mm.
const MOST_APART_MM: f64 = 1.0;

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
    names: SingleMarkers,
}

impl Single {
    /// The definitions `loaded` are held against the emitters of the scene, by which the tracker knows them.
    ///
    /// # Errors
    /// [`ShapeError`].
    pub(crate) fn new(names: &SingleMarkers, source: &EmitterSource, loaded: &[Tool]) -> Result<Self, ShapeError> {
        let of = |name: &str| loaded.iter().find(|tool| tool.name == name);
        if let Some(tool) = of(&names.tool) {
            is_same(tool, "marker", &places(&source.marker))?;
        }
        let patient = names.patient.as_deref().and_then(of);
        if let Some((tool, reference)) = patient.zip(source.reference.as_ref()) {
            is_same(tool, "reference", &places(&reference.shape))?;
        }
        Ok(Self { names: names.clone() })
    }

    /// What of a frame is published; `None` of one in which the device looked for none of these tools.
    pub(crate) fn places(&self, frame: &ndi::Frame, handle: impl Fn(&str) -> Option<Handle>) -> Option<Places> {
        let of = |name: &str| {
            let handle = handle(name)?;
            let looked = frame.tool(handle).map(Sight::why) != Some(Why::NotInFrame) && frame.tool(handle).is_some();
            looked.then(|| seen(frame, handle))
        };
        let (tool, patient) = (of(&self.names.tool), self.names.patient.as_deref().and_then(of));
        (tool.is_some() || patient.is_some()).then(|| Places {
            tool: tool.unwrap_or_default(),
            patient: patient.unwrap_or_default(),
        })
    }
}

/// The good markers of a tool. One that stands in the frame twice is none: nobody knows which place is its own.
fn seen(frame: &ndi::Frame, handle: Handle) -> Vec<EmitterSight> {
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

fn places<F: GeometryFrame>(shape: &Shape<F>) -> Vec<Point<F>> {
    match &shape.emitters {
        Emitters::Ball { count, radius_mm } => {
            let middle = Point::new(0.0, 0.0, 0.0);
            even_directions(*count)
                .into_iter()
                .map(|d| middle + d * *radius_mm)
                .collect()
        }
        Emitters::Listed(all) => all.iter().map(|emitter| emitter.place).collect(),
    }
}

fn is_same<F: GeometryFrame>(tool: &Tool, table: &'static str, emitters: &[Point<F>]) -> Result<(), ShapeError> {
    let (found, allowed) = (tool.rom.markers_mm.len(), emitters.len());
    if found != allowed {
        return Err(ShapeError::Count {
            tool: tool.name.clone(),
            table,
            found,
            allowed,
        });
    }
    for (marker, ([x, y, z], emitter)) in tool.rom.markers_mm.iter().zip(emitters).enumerate() {
        let found_mm = Point::new(*x, *y, *z).distance(*emitter);
        if found_mm > MOST_APART_MM {
            return Err(ShapeError::Apart {
                tool: tool.name.clone(),
                table,
                marker,
                found_mm,
            });
        }
    }
    Ok(())
}
