//! What a localizer delivers: the places of the emitters that it saw at one moment, before any pose is made of them.

use iceoryx2::prelude::ZeroCopySend;

/// One emitter as seen.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/EmitterSight/1")]
pub struct EmitterSight {
    /// Where, in the localizer's frame, mm.
    pub place_mm: [f64; 3],
    /// Which of its marker's emitters, from 0.
    pub emitter: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
}

/// One frame of the localizer.
///
/// On the wire: numbers only. Read it through [`EmitterFrame::tool`] and [`EmitterFrame::reference`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/EmitterFrame/1")]
pub struct EmitterFrame {
    /// Counts the frames of a run from 0; the pose made of it has the same number.
    pub seq: u64,
    /// The localizer's own time of the measurement, ns.
    pub t_device_ns: i64,
    /// When the frame was captured, ns on the run's clock.
    pub t_capture_ns: i64,
    /// When it was published, ns on the run's clock.
    pub t_publish_ns: i64,
    /// How many of `tool_sights` are meant.
    pub tool_seen: u32,
    /// How many of `reference_sights` are meant.
    pub reference_seen: u32,
    /// Emitters of the tool's marker; zeros behind those that are meant.
    pub tool_sights: [EmitterSight; EmitterFrame::MOST],
    /// Emitters of the marker on the patient; zeros behind those that are meant.
    pub reference_sights: [EmitterSight; EmitterFrame::MOST],
}

const _: () = assert!(size_of::<EmitterFrame>() == 2088 && align_of::<EmitterFrame>() == 8);

/// A frame that says more emitters than it can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("frame {seq} of the localizer: {found} emitters of one marker; at most {most} are allowed", most = EmitterFrame::MOST)]
pub struct TooManyEmitters {
    /// Which frame.
    pub seq: u64,
    /// How many it claims.
    pub found: usize,
}

impl EmitterFrame {
    /// Most emitters of one marker.
    pub const MOST: usize = 32;

    /// A frame in which nothing is seen; every number is zero.
    pub const EMPTY: Self = Self {
        seq: 0,
        t_device_ns: 0,
        t_capture_ns: 0,
        t_publish_ns: 0,
        tool_seen: 0,
        reference_seen: 0,
        tool_sights: [EmitterSight::NONE; Self::MOST],
        reference_sights: [EmitterSight::NONE; Self::MOST],
    };

    /// The emitters of the tool's marker.
    ///
    /// # Errors
    /// [`TooManyEmitters`]. Places and numbers are checked by whoever knows the marker.
    pub fn tool(&self) -> Result<&[EmitterSight], TooManyEmitters> {
        self.meant(&self.tool_sights, self.tool_seen)
    }

    /// The emitters of the marker on the patient.
    ///
    /// # Errors
    /// [`TooManyEmitters`].
    pub fn reference(&self) -> Result<&[EmitterSight], TooManyEmitters> {
        self.meant(&self.reference_sights, self.reference_seen)
    }

    fn meant<'a>(&self, sights: &'a [EmitterSight], seen: u32) -> Result<&'a [EmitterSight], TooManyEmitters> {
        let found = seen as usize;
        sights.get(..found).ok_or(TooManyEmitters { seq: self.seq, found })
    }

    /// Puts the emitters seen into the frame: the tool's and the patient's.
    ///
    /// # Errors
    /// [`TooManyEmitters`]; the frame is as it was.
    pub fn set(
        &mut self,
        tool: impl ExactSizeIterator<Item = EmitterSight>,
        reference: impl ExactSizeIterator<Item = EmitterSight>,
    ) -> Result<(), TooManyEmitters> {
        let found = tool.len().max(reference.len());
        if found > Self::MOST {
            return Err(TooManyEmitters { seq: self.seq, found });
        }
        (self.tool_seen, self.tool_sights) = filled(tool);
        (self.reference_seen, self.reference_sights) = filled(reference);
        Ok(())
    }
}

impl EmitterSight {
    const NONE: Self = Self {
        place_mm: [0.0; 3],
        emitter: 0,
        reserved: 0,
    };
}

/// The number of sights, and the sights with zeros behind.
fn filled(from: impl Iterator<Item = EmitterSight>) -> (u32, [EmitterSight; EmitterFrame::MOST]) {
    let mut sights = [EmitterSight::NONE; EmitterFrame::MOST];
    let mut seen = 0;
    for (sight, into) in from.zip(&mut sights) {
        *into = sight;
        seen += 1;
    }
    (seen, sights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sights(n: usize) -> Vec<EmitterSight> {
        let sight = |i: usize| EmitterSight {
            place_mm: [i as f64, -1.0, 2000.0],
            emitter: i as u32,
            reserved: 0,
        };
        (0..n).map(sight).collect()
    }

    #[test]
    fn frames_hold_what_was_put_into_them() {
        let mut frame = EmitterFrame::EMPTY;
        for (tool, reference) in [(0, 0), (3, 32), (32, 1), (0, 4)] {
            let (tool, reference) = (sights(tool), sights(reference));
            frame.set(tool.iter().copied(), reference.iter().copied()).unwrap();
            assert_eq!(
                (frame.tool().unwrap(), frame.reference().unwrap()),
                (&tool[..], &reference[..])
            );
        }
        // Nothing of an earlier frame is left behind.
        assert_eq!(frame.tool_sights, EmitterFrame::EMPTY.tool_sights);
    }

    #[test]
    fn more_emitters_than_there_is_room_for_are_refused() {
        let mut frame = EmitterFrame {
            seq: 9,
            ..EmitterFrame::EMPTY
        };
        let error = frame.set(sights(33).into_iter(), sights(0).into_iter()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "frame 9 of the localizer: 33 emitters of one marker; at most 32 are allowed"
        );
        assert_eq!(
            frame,
            EmitterFrame {
                seq: 9,
                ..EmitterFrame::EMPTY
            }
        );
        frame.reference_seen = u32::MAX;
        assert_eq!(frame.reference().unwrap_err().found, u32::MAX as usize);
    }
}
